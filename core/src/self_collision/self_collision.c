/* What the modules of self-collision share: common motions, directions for coinciding points, shapes at rest. */

#include "base/ranges.h"
#include "math/dvec3.h"
#include "self_collision/self_collision_impl.h"

pli_vec3 plii_self_common_motion(const pli_body* body, const plii_self_nodes* nodes, const pli_vec3* from) {
    plii_dvec3 sum = {0};
    for (int i = 0; i < body->node_count; ++i) {
        sum = plii_dvec3_add(sum, plii_dvec3_from(plii_self_motion_from(nodes, from, i)));
    }
    return plii_dvec3_to_float(plii_dvec3_scale(sum, 1.0 / (double)body->node_count));
}

typedef struct self_limit {
    const plii_self_nodes* nodes;
    float longest;
    pli_vec3 common;
} self_limit;

static double self_limit_block(int begin, int end, const void* data) {
    const self_limit* limit = data;
    const plii_self_nodes* nodes = limit->nodes;
    const float longest = limit->longest;
    int shortened = 0;
    for (int i = begin; i < end; ++i) {
        const pli_vec3 motion = pli_vec3_sub(plii_self_motion(nodes, i), limit->common);
        const float squared = pli_vec3_length_squared(motion);
        if (!(nodes->offsets[i].w > 0.0f) || !(squared > longest * longest)) { continue; }
        plii_self_move(nodes, i, motion, longest / sqrtf(squared) - 1.0f);
        shortened += 1;
    }
    return shortened;
}

enum { SELF_LIMIT_NS = 5 }; /* per node */
int plii_self_limit_motions(const pli_body* body, const plii_self_nodes* nodes, float longest) {
    const self_limit limit = {nodes, longest, plii_self_common_motion(body, nodes, NULL)};
    return (int)plii_sum_blocks(body->context, body->node_count, plii_grain(SELF_LIMIT_NS), self_limit_block, &limit);
}

/* Points on a sphere by the golden angle; the index is spread over them. */
pli_vec3 plii_self_direction(int a, int b) {
    unsigned h = (unsigned)a * 0x9e3779b1u ^ (unsigned)b * 0x85ebca77u;
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    const pli_vec3 v = pli_vec3_make((float)(h & 0x3ffu) - 511.5f, (float)(h >> 10 & 0x3ffu) - 511.5f,
                                     (float)(h >> 20 & 0x3ffu) - 511.5f);
    return plii_vec3_divide(v, sqrtf(pli_vec3_length_squared(v)));
}

void plii_self_carry_rest(const pli_body* body, const plii_topology_change* change, pli_vec3* rest) {
    for (int i = change->old_node_count; i < change->node_count; ++i) {
        const plii_node_origin* origin = &change->node_origins[i - change->old_node_count];
        rest[i] = pli_vec3_lerp(rest[origin->a], rest[origin->b], origin->share);
    }
    if (change->takes_rest_shape) { plii_body_copy_positions(body, rest); }
}
