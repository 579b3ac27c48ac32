#ifndef DEMOS_RENDER_CANVAS_H
#define DEMOS_RENDER_CANVAS_H

// Buffers of the graphics card: what is drawn to and what is drawn.

#include "geometry.h"
#include "image.h"

#include <epoxy/gl.h>

namespace render {

// Drawn to with `scale` times the width and height and four samples per pixel, read back at the size of the picture.
class Canvas {
public:
    Canvas(int width, int height, int scale);
    ~Canvas();
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;

    void begin() const; // what is drawn from now on goes here
    Image read() const;
    // Copies to a window's own buffer, with the bottom left corner at (x, y); for a scale of 1.
    void show(int x, int y) const;

    int width() const { return width_; }
    int height() const { return height_; }
    int scale() const { return scale_; }

private:
    void resolve() const;

    int width_, height_, scale_;
    GLuint framebuffers_[3]{}, renderbuffers_[4]{}; // many samples, one sample, picture; the first has depth too
};

// Depths as the light sees them.
class ShadowMap {
public:
    explicit ShadowMap(int size);
    ~ShadowMap();
    ShadowMap(const ShadowMap&) = delete;
    ShadowMap& operator=(const ShadowMap&) = delete;

    void begin() const;
    void bind_texture() const; // to unit 0

private:
    int size_;
    GLuint framebuffer_ = 0, texture_ = 0;
};

// The window's own buffer as it was drawn last, before it is shown.
Image read_window(int width, int height);

// Vertices of a batch, or corners of text.
class Triangles {
public:
    explicit Triangles(const std::vector<Vertex>& vertices);
    explicit Triangles(const std::vector<float>& corners); // x, y
    ~Triangles();
    Triangles(const Triangles&) = delete;
    Triangles& operator=(const Triangles&) = delete;

    void draw() const;

private:
    GLuint array_ = 0, buffer_ = 0;
    GLsizei count_;
};

} // namespace render
#endif
