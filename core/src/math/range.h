#pragma once

/* Where numbers from outside are held against the limits of limits.h. */

#include "base/context.h"
#include "math/vec.h"
#include "pliant/limits.h"

#include <limits.h>

/* The lowest of what has to be above 0; not the smallest float of all, which is 0 where denormals are flushed. */
#define PLII_ABOVE_0 FLT_MIN

/* False for NaN. */
static inline bool plii_is_within(float value, float limit) {
    return fabsf(value) <= limit;
}
static inline bool plii_vec3_is_within(pli_vec3 v, float limit) {
    return plii_is_within(v.x, limit) && plii_is_within(v.y, limit) && plii_is_within(v.z, limit);
}
static inline bool plii_is_point(pli_vec3 v) {
    return plii_vec3_is_within(v, PLI_MAX_COORDINATE);
}
/* Within 0.01: hosts integrate their rotations, and round them. False for NaN and for mirrors. */
static inline bool plii_is_rotation(pli_mat3 m) {
    const pli_vec3 lengths_squared = {pli_vec3_length_squared(m.rows[0]), pli_vec3_length_squared(m.rows[1]),
                                      pli_vec3_length_squared(m.rows[2])};
    const pli_vec3 cosines = {pli_vec3_dot(m.rows[0], m.rows[1]), pli_vec3_dot(m.rows[1], m.rows[2]),
                              pli_vec3_dot(m.rows[2], m.rows[0])};
    return plii_vec3_is_within(pli_vec3_sub(lengths_squared, pli_vec3_make(1, 1, 1)), 0.02f) &&
           plii_vec3_is_within(cosines, 0.01f) && pli_vec3_dot(pli_vec3_cross(m.rows[0], m.rows[1]), m.rows[2]) > 0.0f;
}
/* 1/kg of something that can move; with some room for quotients. */
static inline bool plii_is_inverse_mass(float inverse_mass) {
    return inverse_mass >= 0.999f / PLI_MAX_MASS && inverse_mass <= 1.001f / PLI_MIN_MASS;
}
/* By component; what rounding has taken over a limit comes back. */
static inline pli_vec3 plii_vec3_clamp(pli_vec3 v, float limit) {
    return pli_vec3_make(plii_clamp(v.x, -limit, limit), plii_clamp(v.y, -limit, limit),
                         plii_clamp(v.z, -limit, limit));
}
static inline pli_vec3 plii_clamp_point(pli_vec3 v) {
    return plii_vec3_clamp(v, PLI_MAX_COORDINATE);
}

/* PLI_OK, or the error of a value beyond one of two limits, or NaN; `name` is that of the value. */
pli_status plii_check_between(pli_context* context, float value, float low, float high, const char* name,
                              const char* function);
pli_status plii_check_vec3_between(pli_context* context, pli_vec3 value, float low, float high, const char* name,
                                   const char* function);
/* The same of the absolute. */
static inline pli_status plii_check_vec3_within(pli_context* context, pli_vec3 value, float limit, const char* name,
                                                const char* function) {
    return plii_check_vec3_between(context, value, -limit, limit, name, function);
}
/* INT_MAX: there is no highest. */
pli_status plii_check_int(pli_context* context, int value, double low, double high, const char* name,
                          const char* function);
/* Positions of an array, or NULL; `what` and a number name one. */
pli_status plii_check_finite_points(pli_context* context, int count, const pli_vec3* points, const char* what,
                                    const char* function);
/* PLI_OK, or the error of an index: "node 5 is out of range, the body has 3 nodes". */
pli_status plii_check_index(pli_context* context, int index, int count, const char* what, const char* owner,
                            const char* function);
