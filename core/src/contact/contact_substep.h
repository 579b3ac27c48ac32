#pragma once

/* What contacts with rigid and with soft bodies have in common. */

#include "body/substep.h"

/* At a point of a face, by its barycentric weights. */
static inline pli_vec3 plii_contact_blend(const pli_vec4* values, const int* face, pli_vec3 weights) {
    return pli_vec3_add(pli_vec3_add(pli_vec3_scale(plii_xyz(values[face[0]]), weights.x),
                                     pli_vec3_scale(plii_xyz(values[face[1]]), weights.y)),
                        pli_vec3_scale(plii_xyz(values[face[2]]), weights.z));
}
/* Adds to the values of the nodes of a face, to each its share. */
static inline void plii_contact_add(pli_vec4* values, const int* face, pli_vec3 shares, pli_vec3 by) {
    plii_add_xyz(&values[face[0]], pli_vec3_scale(by, shares.x));
    plii_add_xyz(&values[face[1]], pli_vec3_scale(by, shares.y));
    plii_add_xyz(&values[face[2]], pli_vec3_scale(by, shares.z));
}
/* Share of its sliding that a contact leaves in each solve. What slides slower than the friction cone allows sticks;
   else friction takes a fixed share. That may exceed 1, as in Bullet; the sliding is then reversed. */
static inline float plii_contact_slip(pli_vec3 motion, pli_vec3 normal, float friction) {
    const float along_normal = pli_vec3_dot(motion, normal);
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(normal, along_normal));
    const bool sticks = pli_vec3_length_squared(sliding) < along_normal * friction * along_normal * friction;
    return sticks ? 0.0f : 1.0f - friction;
}
/* m/s, where the definition names none. Position-based steps of Bullet's kind know no such speed. */
static inline float plii_contact_recovery_speed(float of_definition) {
    return of_definition > 0.0f ? of_definition : 1.0f;
}
/* The new sum of friction of a contact: what would stop the sliding of a mass, kg, but not above Coulomb's limit. */
static inline pli_vec3 plii_contact_friction(pli_vec3 friction, pli_vec3 sliding, float mass, float limit) {
    const pli_vec3 wanted = pli_vec3_sub(friction, pli_vec3_scale(sliding, mass));
    const float length = pli_vec3_length(wanted);
    return length > limit ? pli_vec3_scale(wanted, limit / length) : wanted;
}
