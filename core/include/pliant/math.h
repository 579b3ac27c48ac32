#ifndef PLIANT_MATH_H
#define PLIANT_MATH_H

/// Vectors, matrices, quaternions and rigid transforms, as plain values. Matrices are three row vectors; products
/// are evaluated left to right, so that a result does not depend on the compiler.

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_vec3 {
    float x, y, z;
} pli_vec3;

/// `w` is the scalar part.
typedef struct pli_quat {
    float x, y, z, w;
} pli_quat;

typedef struct pli_mat3 {
    pli_vec3 rows[3];
} pli_mat3;

/// Maps p to rotation * p + origin.
typedef struct pli_transform {
    pli_mat3 rotation;
    pli_vec3 origin;
} pli_transform;

/// Axis-aligned box; `min` <= `max` per axis.
typedef struct pli_bounds {
    pli_vec3 min, max;
} pli_bounds;

static inline pli_vec3 pli_vec3_make(float x, float y, float z) {
    pli_vec3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

static inline pli_vec3 pli_vec3_add(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline pli_vec3 pli_vec3_sub(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline pli_vec3 pli_vec3_scale(pli_vec3 a, float s) {
    return pli_vec3_make(a.x * s, a.y * s, a.z * s);
}
static inline pli_vec3 pli_vec3_neg(pli_vec3 a) {
    return pli_vec3_make(-a.x, -a.y, -a.z);
}
static inline pli_vec3 pli_vec3_mul(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_make(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline float pli_vec3_dot(pli_vec3 a, pli_vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline float pli_vec3_length_squared(pli_vec3 a) {
    return pli_vec3_dot(a, a);
}
static inline float pli_vec3_length(pli_vec3 a) {
    return sqrtf(pli_vec3_dot(a, a));
}

static inline pli_vec3 pli_vec3_cross(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/// a + (b - a) * t per component.
static inline pli_vec3 pli_vec3_lerp(pli_vec3 a, pli_vec3 b, float t) {
    return pli_vec3_make(a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t);
}

static inline pli_mat3 pli_mat3_identity(void) {
    pli_mat3 m;
    m.rows[0] = pli_vec3_make(1, 0, 0);
    m.rows[1] = pli_vec3_make(0, 1, 0);
    m.rows[2] = pli_vec3_make(0, 0, 1);
    return m;
}

/// m * v.
static inline pli_vec3 pli_mat3_mul_vec3(pli_mat3 m, pli_vec3 v) {
    return pli_vec3_make(pli_vec3_dot(m.rows[0], v), pli_vec3_dot(m.rows[1], v), pli_vec3_dot(m.rows[2], v));
}

/// transpose(m) * v, without forming the transpose.
static inline pli_vec3 pli_mat3_transpose_mul_vec3(pli_mat3 m, pli_vec3 v) {
    return pli_vec3_make(m.rows[0].x * v.x + m.rows[1].x * v.y + m.rows[2].x * v.z,
                         m.rows[0].y * v.x + m.rows[1].y * v.y + m.rows[2].y * v.z,
                         m.rows[0].z * v.x + m.rows[1].z * v.y + m.rows[2].z * v.z);
}

/// a * b.
static inline pli_mat3 pli_mat3_mul(pli_mat3 a, pli_mat3 b) {
    pli_mat3 m;
    m.rows[0] = pli_mat3_transpose_mul_vec3(b, a.rows[0]);
    m.rows[1] = pli_mat3_transpose_mul_vec3(b, a.rows[1]);
    m.rows[2] = pli_mat3_transpose_mul_vec3(b, a.rows[2]);
    return m;
}

static inline pli_mat3 pli_mat3_transpose(pli_mat3 m) {
    pli_mat3 t;
    t.rows[0] = pli_vec3_make(m.rows[0].x, m.rows[1].x, m.rows[2].x);
    t.rows[1] = pli_vec3_make(m.rows[0].y, m.rows[1].y, m.rows[2].y);
    t.rows[2] = pli_vec3_make(m.rows[0].z, m.rows[1].z, m.rows[2].z);
    return t;
}

/// Rotation matrix of a quaternion of any non-zero length.
static inline pli_mat3 pli_mat3_from_quat(pli_quat q) {
    const float s = 2.0f / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    const float xs = q.x * s, ys = q.y * s, zs = q.z * s;
    const float wx = q.w * xs, wy = q.w * ys, wz = q.w * zs;
    const float xx = q.x * xs, xy = q.x * ys, xz = q.x * zs;
    const float yy = q.y * ys, yz = q.y * zs, zz = q.z * zs;
    pli_mat3 m;
    m.rows[0] = pli_vec3_make(1.0f - (yy + zz), xy - wz, xz + wy);
    m.rows[1] = pli_vec3_make(xy + wz, 1.0f - (xx + zz), yz - wx);
    m.rows[2] = pli_vec3_make(xz - wy, yz + wx, 1.0f - (xx + yy));
    return m;
}

/// Rz(z) * Ry(y) * Rx(x), angles in radians (btMatrix3x3::setEulerZYX).
static inline pli_mat3 pli_mat3_from_euler_zyx(float x, float y, float z) {
    const float ci = cosf(x), cj = cosf(y), ch = cosf(z);
    const float si = sinf(x), sj = sinf(y), sh = sinf(z);
    const float cc = ci * ch, cs = ci * sh, sc = si * ch, ss = si * sh;
    pli_mat3 m;
    m.rows[0] = pli_vec3_make(cj * ch, sj * sc - cs, sj * cc + ss);
    m.rows[1] = pli_vec3_make(cj * sh, sj * ss + cc, sj * cs - sc);
    m.rows[2] = pli_vec3_make(-sj, cj * si, cj * ci);
    return m;
}

static inline pli_quat pli_quat_identity(void) {
    pli_quat q;
    q.x = q.y = q.z = 0.0f;
    q.w = 1.0f;
    return q;
}

/// Ry(yaw) * Rx(pitch) * Rz(roll), angles in radians (btQuaternion::setEuler).
static inline pli_quat pli_quat_from_yaw_pitch_roll(float yaw, float pitch, float roll) {
    const float cy = cosf(yaw * 0.5f), sy = sinf(yaw * 0.5f);
    const float cp = cosf(pitch * 0.5f), sp = sinf(pitch * 0.5f);
    const float cr = cosf(roll * 0.5f), sr = sinf(roll * 0.5f);
    pli_quat q;
    q.x = cr * sp * cy + sr * cp * sy;
    q.y = cr * cp * sy - sr * sp * cy;
    q.z = sr * cp * cy - cr * sp * sy;
    q.w = cr * cp * cy + sr * sp * sy;
    return q;
}

static inline pli_transform pli_transform_identity(void) {
    pli_transform t;
    t.rotation = pli_mat3_identity();
    t.origin = pli_vec3_make(0, 0, 0);
    return t;
}

static inline pli_transform pli_transform_make(pli_quat rotation, pli_vec3 origin) {
    pli_transform t;
    t.rotation = pli_mat3_from_quat(rotation);
    t.origin = origin;
    return t;
}

static inline pli_vec3 pli_transform_point(pli_transform t, pli_vec3 p) {
    return pli_vec3_add(pli_mat3_mul_vec3(t.rotation, p), t.origin);
}

/// The point that `t` maps to `p`.
static inline pli_vec3 pli_transform_inverse_point(pli_transform t, pli_vec3 p) {
    return pli_mat3_transpose_mul_vec3(t.rotation, pli_vec3_sub(p, t.origin));
}

/// First `b`, then `a`.
static inline pli_transform pli_transform_mul(pli_transform a, pli_transform b) {
    pli_transform t;
    t.rotation = pli_mat3_mul(a.rotation, b.rotation);
    t.origin = pli_transform_point(a, b.origin);
    return t;
}

#ifdef __cplusplus
}
#endif
#endif
