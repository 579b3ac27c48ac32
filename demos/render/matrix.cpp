#include "matrix.h"

#include <algorithm>
#include <cmath>

namespace render {

pli_vec3 normalized(pli_vec3 v) {
    const float length = pli_vec3_length(v);
    return length > 0.0f ? v * (1.0f / length) : pli_vec3_make(0, 1, 0);
}

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 c{};
    for (size_t column = 0; column < 4; ++column) {
        for (size_t row = 0; row < 4; ++row) {
            for (size_t k = 0; k < 4; ++k) {
                c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
            }
        }
    }
    return c;
}

Matrix4 look_along(pli_vec3 eye, pli_vec3 right, pli_vec3 up, pli_vec3 forward) {
    return {right.x,
            up.x,
            -forward.x,
            0,
            right.y,
            up.y,
            -forward.y,
            0,
            right.z,
            up.z,
            -forward.z,
            0,
            -pli_vec3_dot(right, eye),
            -pli_vec3_dot(up, eye),
            pli_vec3_dot(forward, eye),
            1};
}

Matrix4 perspective(float tangent_x, float tangent_y, float near, float far) {
    Matrix4 m{};
    m[0] = 1.0f / tangent_x;
    m[5] = 1.0f / tangent_y;
    m[10] = (far + near) / (near - far);
    m[11] = -1.0f;
    m[14] = 2.0f * far * near / (near - far);
    return m;
}

Matrix4 orthographic(float left, float right, float bottom, float top, float near, float far) {
    Matrix4 m{};
    m[0] = 2.0f / (right - left);
    m[5] = 2.0f / (top - bottom);
    m[10] = 2.0f / (near - far);
    m[12] = (right + left) / (left - right);
    m[13] = (top + bottom) / (bottom - top);
    m[14] = (far + near) / (near - far);
    m[15] = 1.0f;
    return m;
}

void Box::add(pli_vec3 point) {
    min = pli_vec3_make(std::min(min.x, point.x), std::min(min.y, point.y), std::min(min.z, point.z));
    max = pli_vec3_make(std::max(max.x, point.x), std::max(max.y, point.y), std::max(max.z, point.z));
}

void Box::add(const Box& box) {
    if (box.is_empty()) { return; }
    add(box.min);
    add(box.max);
}

float Box::gap(const Box& other) const {
    const float x = std::max(other.min.x - max.x, min.x - other.max.x);
    const float y = std::max(other.min.y - max.y, min.y - other.max.y);
    const float z = std::max(other.min.z - max.z, min.z - other.max.z);
    return std::max({x, y, z});
}

pli_vec3 Box::corner(int index) const {
    return pli_vec3_make((index & 1) != 0 ? max.x : min.x, (index & 2) != 0 ? max.y : min.y,
                         (index & 4) != 0 ? max.z : min.z);
}

} // namespace render
