#pragma once

/* Vectors in double, for geometry whose decisions must survive cancellation. */

#include "pliant/math.h"

#include <stdbool.h>

typedef struct plii_dvec3 {
    double x, y, z;
} plii_dvec3;

static inline plii_dvec3 plii_dvec3_make(double x, double y, double z) {
    const plii_dvec3 v = {x, y, z};
    return v;
}
static inline plii_dvec3 plii_dvec3_from(pli_vec3 v) {
    return plii_dvec3_make((double)v.x, (double)v.y, (double)v.z);
}
/* Rounded, whatever follows: where pairs of components become vectors (-mavx), GCC 12 takes the doubles of before for
   what is widened again. */
static inline pli_vec3 plii_dvec3_to_float(plii_dvec3 v) {
    pli_vec3 rounded = pli_vec3_make((float)v.x, (float)v.y, (float)v.z);
#if defined(__GNUC__) && defined(__x86_64__)
    __asm__("" : "+x"(rounded.x), "+x"(rounded.y), "+x"(rounded.z));
#endif
    return rounded;
}
static inline plii_dvec3 plii_dvec3_add(plii_dvec3 a, plii_dvec3 b) {
    return plii_dvec3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline plii_dvec3 plii_dvec3_sub(plii_dvec3 a, plii_dvec3 b) {
    return plii_dvec3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline plii_dvec3 plii_dvec3_scale(plii_dvec3 a, double s) {
    return plii_dvec3_make(a.x * s, a.y * s, a.z * s);
}
static inline plii_dvec3 plii_dvec3_add_scaled(plii_dvec3 a, plii_dvec3 b, double s) {
    return plii_dvec3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}
static inline double plii_dvec3_dot(plii_dvec3 a, plii_dvec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline plii_dvec3 plii_dvec3_cross(plii_dvec3 a, plii_dvec3 b) {
    return plii_dvec3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline plii_dvec3 plii_dvec3_rotate(const pli_mat3* m, plii_dvec3 v) {
    return plii_dvec3_make(plii_dvec3_dot(plii_dvec3_from(m->rows[0]), v),
                           plii_dvec3_dot(plii_dvec3_from(m->rows[1]), v),
                           plii_dvec3_dot(plii_dvec3_from(m->rows[2]), v));
}
static inline double plii_dvec3_length(plii_dvec3 a) {
    return sqrt(plii_dvec3_dot(a, a));
}
/* False for what has no direction. */
static inline bool plii_dvec3_unit(plii_dvec3 v, pli_vec3* unit) {
    const double length = plii_dvec3_length(v);
    if (!(length > 0.0) || !isfinite(length)) { return false; }
    *unit = plii_dvec3_to_float(plii_dvec3_scale(v, 1.0 / length));
    return true;
}
/* The part across a unit vector. */
static inline plii_dvec3 plii_dvec3_across(plii_dvec3 v, plii_dvec3 unit) {
    return plii_dvec3_add_scaled(v, unit, -plii_dvec3_dot(unit, v));
}
/* A unit vector across another one. */
static inline plii_dvec3 plii_dvec3_perpendicular(plii_dvec3 unit) {
    const plii_dvec3 axis = fabs(unit.x) < 0.5 ? plii_dvec3_make(1, 0, 0) : plii_dvec3_make(0, 1, 0);
    const plii_dvec3 side = plii_dvec3_cross(unit, axis);
    return plii_dvec3_scale(side, 1.0 / plii_dvec3_length(side));
}
