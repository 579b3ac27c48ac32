#ifndef DEMOS_RENDER_CONTEXT_H
#define DEMOS_RENDER_CONTEXT_H

// An OpenGL 3.3 context without window or display, current while the object lives.

namespace render {

class Context {
public:
    // Throws demos::Error when there is no OpenGL.
    Context();
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

private:
    void* display_ = nullptr;
    void* context_ = nullptr;
};

} // namespace render
#endif
