#include "canvas.h"

#include "description/error.h"

#include <algorithm>
#include <cstddef>

namespace render {

static void check_framebuffer() {
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw demos::Error("OpenGL offers no buffer of the size of the picture");
    }
}

// ---------------------------------------------------------------------------------------------------- canvas

static void attach_storage(GLuint renderbuffer, GLenum attachment, GLenum format, int samples, int width, int height) {
    glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
}

Canvas::Canvas(int width, int height, int scale) : width_(width), height_(height), scale_(scale) {
    glGenFramebuffers(3, framebuffers_);
    glGenRenderbuffers(4, renderbuffers_);
    GLint most_samples = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &most_samples);
    const int samples = most_samples < 4 ? most_samples : 4;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[0]);
    attach_storage(renderbuffers_[0], GL_COLOR_ATTACHMENT0, GL_RGBA8, samples, scale * width, scale * height);
    attach_storage(renderbuffers_[3], GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, samples, scale_ * width,
                   scale_ * height);
    check_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[1]);
    attach_storage(renderbuffers_[1], GL_COLOR_ATTACHMENT0, GL_RGBA8, 0, scale_ * width, scale_ * height);
    check_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[2]);
    attach_storage(renderbuffers_[2], GL_COLOR_ATTACHMENT0, GL_RGBA8, 0, width, height);
    check_framebuffer();
}

Canvas::~Canvas() {
    glDeleteFramebuffers(3, framebuffers_);
    glDeleteRenderbuffers(4, renderbuffers_);
}

void Canvas::begin() const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[0]);
    glViewport(0, 0, scale_ * width_, scale_ * height_);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

// Many samples to one.
void Canvas::resolve() const {
    const int wide = scale_ * width_, high = scale_ * height_;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[0]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[1]);
    glBlitFramebuffer(0, 0, wide, high, 0, 0, wide, high, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void Canvas::show(int x, int y) const {
    resolve();
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBlitFramebuffer(0, 0, width_, height_, x, y, x + width_, y + height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

Image read_window(int width, int height) {
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    Image upside_down(width, height), image(width, height);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.pixels.data());
    const size_t row = 3 * static_cast<size_t>(width);
    for (size_t y = 0; y < static_cast<size_t>(height); ++y) {
        const auto from = upside_down.pixels.begin() + static_cast<std::ptrdiff_t>(y * row);
        std::copy(from, from + static_cast<std::ptrdiff_t>(row),
                  image.pixels.end() - static_cast<std::ptrdiff_t>((y + 1) * row));
    }
    return image;
}

Image Canvas::read() const {
    const int wide = scale_ * width_, high = scale_ * height_;
    resolve();
    // Halving with a linear filter takes the mean of four pixels; turned upside down, as images go from the top.
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[2]);
    glBlitFramebuffer(0, 0, wide, high, 0, height_, width_, 0, GL_COLOR_BUFFER_BIT, GL_LINEAR);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[2]);
    Image image(width_, height_);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
    if (glGetError() != GL_NO_ERROR) { throw demos::Error("OpenGL failed while it drew the picture"); }
    return image;
}

// ------------------------------------------------------------------------------------------------ shadow map

ShadowMap::ShadowMap(int size) : size_(size) {
    glGenTextures(1, &texture_);
    bind_texture();
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glGenFramebuffers(1, &framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    check_framebuffer();
}

ShadowMap::~ShadowMap() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteTextures(1, &texture_);
}

void ShadowMap::begin() const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glViewport(0, 0, size_, size_);
    glClear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMap::bind_texture() const {
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, texture_);
}

// ------------------------------------------------------------------------------------------------- triangles

static const void* buffer_offset(size_t bytes) {
    return reinterpret_cast<const void*>(bytes); // how OpenGL wants an offset
}

Triangles::Triangles(const std::vector<Vertex>& vertices) : count_(static_cast<GLsizei>(vertices.size())) {
    glGenVertexArrays(1, &array_);
    glBindVertexArray(array_);
    glGenBuffers(1, &buffer_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(),
                 GL_STATIC_DRAW);
    const size_t offsets[] = {offsetof(Vertex, position), offsetof(Vertex, normal), offsetof(Vertex, edges)};
    for (GLuint i = 0; i < 3; ++i) {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), buffer_offset(offsets[i]));
    }
}

Triangles::Triangles(const std::vector<float>& corners) : count_(static_cast<GLsizei>(corners.size() / 2)) {
    glGenVertexArrays(1, &array_);
    glBindVertexArray(array_);
    glGenBuffers(1, &buffer_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(float)), corners.data(),
                 GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

Triangles::~Triangles() {
    glDeleteBuffers(1, &buffer_);
    glDeleteVertexArrays(1, &array_);
}

void Triangles::draw() const {
    glBindVertexArray(array_);
    glDrawArrays(GL_TRIANGLES, 0, count_);
}

} // namespace render
