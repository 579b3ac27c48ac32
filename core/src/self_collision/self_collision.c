/* What the modules of self-collision share: common motions, directions for coinciding points, shapes at rest. */

#include "base/ranges.h"
#include "math/mass_sum.h"
#include "math/simd_float4.h"
#include "self_collision/self_collision_impl.h"

pli_vec3 plii_self_common_motion(const pli_body* body, const plii_substep* substep, const pli_vec3* from) {
    plii_dvec3 sum = {0};
    for (int i = 0; i < body->node_count; ++i) {
        sum = plii_dvec3_add(sum, plii_dvec3_from(plii_self_motion_from(body, substep, from, i)));
    }
    return plii_dvec3_to_float(plii_dvec3_scale(sum, 1.0 / (double)body->node_count));
}

typedef struct self_limit {
    const pli_body* body;
    const plii_substep* substep;
    pli_vec4* velocities; /* or NULL */
    float longest, rate;
    pli_vec3 first, move, turn; /* common motion, about the first node: a rigid one brings no two nodes nearer */
} self_limit;

static pli_vec3 self_limit_common(const self_limit* limit, int node) {
    const pli_vec3 arm = pli_vec3_sub(plii_substep_start(limit->body, limit->substep, node), limit->first);
    return pli_vec3_add(limit->move, pli_vec3_cross(limit->turn, arm));
}

/* Takes as common motion that of a rigid body with the momentum and the angular momentum of the nodes. False where one
   is pinned. */
static bool self_limit_fit(self_limit* limit) {
    const pli_body* body = limit->body;
    const plii_substep* substep = limit->substep;
    plii_mass_sum sum = {0};
    limit->first = plii_substep_start(body, substep, 0);
    for (int i = 0; i < body->node_count; ++i) {
        const double mass = 1.0 / (double)substep->displacements[i].w;
        if (!isfinite(mass)) { return false; }
        const pli_vec3 x = pli_vec3_sub(plii_substep_start(body, substep, i), limit->first);
        plii_mass_sum_add(&sum, mass, plii_dvec3_from(x), plii_dvec3_from(plii_substep_motion(substep, i)));
    }
    const double* motion = sum.momentum;
    if (!plii_mass_sum_solve(&sum)) { return false; }
    limit->move = pli_vec3_make((float)motion[0], (float)motion[1], (float)motion[2]);
    limit->turn = pli_vec3_make((float)motion[3], (float)motion[4], (float)motion[5]);
    return true;
}

static void self_limit_move(const self_limit* limit, int node, pli_vec3 move) {
    plii_add_xyz(&limit->substep->displacements[node], move);
    if (limit->velocities != NULL) { plii_add_xyz(&limit->velocities[node], pli_vec3_scale(move, limit->rate)); }
}

static double self_limit_block(int begin, int end, const void* data) {
    const self_limit* limit = data;
    const plii_substep* substep = limit->substep;
    const float longest = limit->longest;
    int longer = 0;
    for (int i = begin; i < end; ++i) {
        const pli_vec3 motion = pli_vec3_sub(plii_substep_motion(substep, i), self_limit_common(limit, i));
        const float squared = pli_vec3_length_squared(motion);
        if (!(substep->displacements[i].w > 0.0f) || !(squared > longest * longest)) { continue; }
        self_limit_move(limit, i, pli_vec3_scale(motion, longest / sqrtf(squared) - 1.0f));
        longer += 1;
    }
    return longer;
}

/* Where the common motion has no turn: how many are longer, pinned ones too. */
static double self_limit_count(int begin, int end, const void* data) {
    const self_limit* limit = data;
    const plii_float4 move = plii_lanes_from_vec3(&limit->move);
    int longer = 0;
    for (int i = begin; i < end; ++i) {
        const plii_float4 displacement = plii_float4_from(&limit->substep->displacements[i]);
        const plii_float4 motion = displacement - plii_float4_from(&limit->substep->start_displacements[i]) - move;
        longer += plii_lanes_dot(motion, motion) > limit->longest * limit->longest;
    }
    return longer;
}

enum { SELF_LIMIT_NS = 5 }; /* per node */
static int self_limit_run(const self_limit* limit, plii_block_value_fn* run) {
    const pli_body* body = limit->body;
    return (int)plii_sum_blocks(body->context, body->node_count, plii_grain(SELF_LIMIT_NS), run, limit);
}

int plii_self_limit_motions(const pli_body* body, const plii_substep* substep, float longest, pli_vec4* velocities,
                            bool keeps_momentum) {
    self_limit limit = {body, substep, velocities, 0.5f * longest, .rate = body->step.inverse_dt};
    /* Where no node goes farther than the half, none does beside their mean. */
    if (self_limit_run(&limit, self_limit_count) == 0) { return 0; }
    limit.longest = longest;
    limit.move = plii_self_common_motion(body, substep, NULL);
    if (self_limit_run(&limit, self_limit_count) == 0) { return 0; }
    keeps_momentum = keeps_momentum && self_limit_fit(&limit);
    const int longer = self_limit_run(&limit, self_limit_block);
    const pli_vec3 move = limit.move, turn = limit.turn;
    if (!keeps_momentum || longer == 0 || !self_limit_fit(&limit)) { return longer; }
    limit.move = pli_vec3_sub(move, limit.move);
    limit.turn = pli_vec3_sub(turn, limit.turn);
    for (int i = 0; i < body->node_count; ++i) {
        self_limit_move(&limit, i, self_limit_common(&limit, i));
    }
    return longer;
}

/* From the middle of a cube to a point of it that a hash of the indices picks. */
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
