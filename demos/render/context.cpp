#include "context.h"

#include "description/error.h"

#include <epoxy/egl.h>

#include <cstdlib>

namespace render {

Context::Context() {
    setenv("EGL_LOG_LEVEL", "fatal", 0); // the reasons below are enough; Mesa would print its own
    if (!epoxy_has_egl()) { throw demos::Error("pictures need EGL, and there is no libEGL here"); }
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless") ||
        !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base")) {
        throw demos::Error("pictures need EGL without a display (Mesa's EGL_MESA_platform_surfaceless)");
    }
    // The display belongs to the process and is never ended: there may be other contexts.
    display_ = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) == EGL_FALSE) {
        throw demos::Error("pictures need EGL, which does not start here (is Mesa's libgl1-mesa-dri installed?)");
    }
    const EGLint attributes[] = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) { throw demos::Error("pictures need desktop OpenGL"); }
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context_ == EGL_NO_CONTEXT) { throw demos::Error("pictures need OpenGL 3.3, which EGL does not offer here"); }
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
        eglDestroyContext(display_, context_);
        throw demos::Error("pictures need an OpenGL context without a surface, which EGL does not offer here");
    }
}

Context::~Context() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
}

} // namespace render
