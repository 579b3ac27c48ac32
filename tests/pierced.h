#ifndef TESTS_PIERCED_H
#define TESTS_PIERCED_H

/* Whether a moving point went through a moving surface. For C and C++. */

#include <pliant/body.h>

#include <stdbool.h>
#include <string.h>

enum { PIERCED_MAX_NODES = 512 };

/* The surface and the point at one moment. */
typedef struct pierced_moment {
    pli_vec4 positions[PIERCED_MAX_NODES];
    pli_vec3 point;
} pierced_moment;

static inline pli_vec3 pierced_mix(pli_vec3 a, pli_vec3 b, float share) {
    return pli_vec3_add(pli_vec3_scale(a, 1 - share), pli_vec3_scale(b, share));
}

static inline pierced_moment pierced_look(const pli_body* body, pli_vec3 point) {
    const pli_body_view view = pli_body_get_view(body);
    pierced_moment moment;
    memcpy(moment.positions, view.positions, (size_t)view.node_count * sizeof *view.positions);
    moment.point = point;
    return moment;
}

/* The face that the point crossed, all motions being straight; PLI_NULL_INDEX if none. */
static inline int pierced_face(const pli_body* body, const pierced_moment* before, const pierced_moment* after) {
    const pli_body_view view = pli_body_get_view(body);
    for (int f = 0; f < view.face_count; ++f) {
        pli_vec3 begin[3], end[3], at[3];
        for (int k = 0; k < 3; ++k) {
            const pli_vec4 b = before->positions[view.face_nodes[3 * f + k]];
            const pli_vec4 e = after->positions[view.face_nodes[3 * f + k]];
            begin[k] = pli_vec3_make(b.x, b.y, b.z);
            end[k] = pli_vec3_make(e.x, e.y, e.z);
        }
        const pli_vec3 begin_normal =
            pli_vec3_cross(pli_vec3_sub(begin[1], begin[0]), pli_vec3_sub(begin[2], begin[0]));
        const pli_vec3 end_normal = pli_vec3_cross(pli_vec3_sub(end[1], end[0]), pli_vec3_sub(end[2], end[0]));
        const float side_before = pli_vec3_dot(begin_normal, pli_vec3_sub(before->point, begin[0]));
        const float side_after = pli_vec3_dot(end_normal, pli_vec3_sub(after->point, end[0]));
        if ((side_before < 0) == (side_after < 0)) { continue; }
        const float share = side_before / (side_before - side_after);
        for (int k = 0; k < 3; ++k) {
            at[k] = pierced_mix(begin[k], end[k], share);
        }
        const pli_vec3 p = pierced_mix(before->point, after->point, share);
        const pli_vec3 normal = pli_vec3_cross(pli_vec3_sub(at[1], at[0]), pli_vec3_sub(at[2], at[0]));
        bool is_inside = true;
        for (int k = 0; k < 3; ++k) {
            const pli_vec3 edge = pli_vec3_sub(at[(k + 1) % 3], at[k]);
            is_inside = is_inside && pli_vec3_dot(normal, pli_vec3_cross(edge, pli_vec3_sub(p, at[k]))) >= 0;
        }
        if (is_inside) { return f; }
    }
    return PLI_NULL_INDEX;
}

#endif
