#ifndef DEMOS_RENDER_RENDERER_H
#define DEMOS_RENDER_RENDERER_H

// Draws snapshots in the OpenGL 3.3 context that is current, be it one of a window or one without.

#include "bodies.h"
#include "camera.h"
#include "canvas.h"

#include <memory>
#include <string>

namespace render {

struct ShadowQuality {
    int size; // of the map, texels
    int taps; // per pixel
};
inline constexpr ShadowQuality fine_shadows{4096, 24}, quick_shadows{2048, 8};

class Renderer {
public:
    // Throws demos::Error when shaders or buffers cannot be made.
    explicit Renderer(ShadowQuality shadows);
    ~Renderer();

    // `view` is what light and haze are made for.
    void draw(const Canvas& canvas, const Snapshot& snapshot, const Extent& extent, const View& view,
              const Camera& camera, const Look& look) const;
    // Words on a dark, half transparent plate in the top left corner; the detail may be empty.
    void draw_caption(const Canvas& canvas, const std::string& title, const std::string& detail) const;

private:
    struct Tools; // what OpenGL needs for any picture
    std::unique_ptr<Tools> tools_;
};

} // namespace render
#endif
