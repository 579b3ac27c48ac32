#ifndef DEMOS_RENDER_MATRIX_H
#define DEMOS_RENDER_MATRIX_H

// The few vector and matrix functions that drawing needs beyond pliant/math.h.

#include <pliant/math.h>

#include <array>

namespace render {

inline pli_vec3 operator+(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_add(a, b);
}
inline pli_vec3 operator-(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_sub(a, b);
}
inline pli_vec3 operator*(pli_vec3 a, float s) {
    return pli_vec3_scale(a, s);
}

// Unit vector; the y axis for a zero vector.
pli_vec3 normalized(pli_vec3 v);

// Column-major, as OpenGL takes it; maps column vectors.
using Matrix4 = std::array<float, 16>;

Matrix4 multiply(const Matrix4& a, const Matrix4& b);
// World to a frame whose axes are `right`, `up` and minus `forward`.
Matrix4 look_along(pli_vec3 eye, pli_vec3 right, pli_vec3 up, pli_vec3 forward);
Matrix4 perspective(float tangent_x, float tangent_y, float near, float far);
Matrix4 orthographic(float left, float right, float bottom, float top, float near, float far);

// Bounds that start empty and grow.
struct Box {
    pli_vec3 min{1e30f, 1e30f, 1e30f}, max{-1e30f, -1e30f, -1e30f};

    bool is_empty() const { return min.x > max.x; }
    void add(pli_vec3 point);
    void add(const Box& box);
    pli_vec3 center() const { return (min + max) * 0.5f; }
    float diagonal() const { return is_empty() ? 0.0f : pli_vec3_length(max - min); }
    // Largest gap along an axis; negative when the boxes overlap.
    float gap(const Box& other) const;
    pli_vec3 corner(int index) const;
};

} // namespace render
#endif
