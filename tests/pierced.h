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

/* Signed volume: which side of a face the point is on. */
static inline float pierced_side(const pli_vec3 corners[3], pli_vec3 point) {
    const pli_vec3 normal = pli_vec3_cross(pli_vec3_sub(corners[1], corners[0]), pli_vec3_sub(corners[2], corners[0]));
    return pli_vec3_dot(normal, pli_vec3_sub(point, corners[0]));
}

static inline bool pierced_is_inside(const pli_vec3 corners[3], pli_vec3 point) {
    const pli_vec3 normal = pli_vec3_cross(pli_vec3_sub(corners[1], corners[0]), pli_vec3_sub(corners[2], corners[0]));
    bool is_inside = true;
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 edge = pli_vec3_sub(corners[(k + 1) % 3], corners[k]);
        is_inside = is_inside && pli_vec3_dot(normal, pli_vec3_cross(edge, pli_vec3_sub(point, corners[k]))) >= 0;
    }
    return is_inside;
}

/* Whether a point and a face are apart along one axis during all of their motions. */
static inline bool pierced_is_apart(const float begin[3], const float end[3], float point_begin, float point_end) {
    const float low = point_begin < point_end ? point_begin : point_end;
    const float high = point_begin < point_end ? point_end : point_begin;
    bool is_below = true, is_above = true;
    for (int k = 0; k < 3; ++k) {
        is_below = is_below && begin[k] < low && end[k] < low;
        is_above = is_above && begin[k] > high && end[k] > high;
    }
    return is_below || is_above;
}

/* Whether a point crosses a face, all motions being straight. Looked at in parts, within which sides change evenly. */
static inline bool pierced_crosses(const pli_vec3 begin[3], const pli_vec3 end[3], pli_vec3 point_begin,
                                   pli_vec3 point_end) {
    const int parts = 32;
    float before = pierced_side(begin, point_begin);
    for (int i = 1; i <= parts; ++i) {
        pli_vec3 at[3];
        const float share = (float)i / (float)parts;
        for (int k = 0; k < 3; ++k) {
            at[k] = pierced_mix(begin[k], end[k], share);
        }
        const float after = pierced_side(at, pierced_mix(point_begin, point_end, share));
        if ((before < 0) != (after < 0)) {
            const float moment = share - after / (after - before) / (float)parts;
            for (int k = 0; k < 3; ++k) {
                at[k] = pierced_mix(begin[k], end[k], moment);
            }
            if (pierced_is_inside(at, pierced_mix(point_begin, point_end, moment))) { return true; }
        }
        before = after;
    }
    return false;
}

/* The face that the point crossed; PLI_NULL_INDEX if none. */
static inline int pierced_face(const pli_body* body, const pierced_moment* before, const pierced_moment* after) {
    const pli_body_view view = pli_body_get_view(body);
    for (int f = 0; f < view.face_count; ++f) {
        pli_vec3 begin[3], end[3];
        float begin_xs[3], begin_zs[3], end_xs[3], end_zs[3];
        for (int k = 0; k < 3; ++k) {
            const pli_vec4 b = before->positions[view.face_nodes[3 * f + k]];
            const pli_vec4 e = after->positions[view.face_nodes[3 * f + k]];
            begin[k] = pli_vec3_make(b.x, b.y, b.z);
            end[k] = pli_vec3_make(e.x, e.y, e.z);
            begin_xs[k] = b.x;
            begin_zs[k] = b.z;
            end_xs[k] = e.x;
            end_zs[k] = e.z;
        }
        if (pierced_is_apart(begin_xs, end_xs, before->point.x, after->point.x)) { continue; }
        if (pierced_is_apart(begin_zs, end_zs, before->point.z, after->point.z)) { continue; }
        if (pierced_crosses(begin, end, before->point, after->point)) { return f; }
    }
    return PLI_NULL_INDEX;
}

#endif
