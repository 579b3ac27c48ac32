/* Faces and edges of one body that come too near to each other are pushed apart, and motions that would take one to the
   wrong side of the other are cut short. */

#include "body/point_weight.h"
#include "math/range.h"
#include "self_collision/self_faces_impl.h"

#define SELF_FACES_MAX_PASSES 16
/* Share of its distance that a pair keeps at least. */
#define SELF_FACES_KEPT 0.2f

/* The inverse mass of both sides. Where all of one side is pinned, a node of the other that bears little of the point
   beside pinned ones does not go far for them. */
static float self_faces_weight(const plii_self_nodes* nodes, const plii_self_faces_pair* pair) {
    const int second = pair->is_edges ? 2 : 1;
    float weights[2] = {0};
    for (int k = 0; k < 4; ++k) {
        weights[k >= second] += pair->weights[k] * pair->weights[k] * nodes->offsets[pair->nodes[k]].w;
    }
    if (!(weights[0] > 0.0f)) {
        return plii_point_weight_unpinned(nodes->offsets, 4 - second, pair->nodes + second, pair->weights + second);
    }
    if (!(weights[1] > 0.0f)) { return plii_point_weight_unpinned(nodes->offsets, second, pair->nodes, pair->weights); }
    return weights[0] + weights[1];
}

/* True when the pair was too near. */
static bool self_faces_part(const plii_self_nodes* nodes, const plii_self_faces_pair* pair, float friction) {
    const float weight = self_faces_weight(nodes, pair);
    float distance = 0.0f;
    pli_vec3 motion = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < 4; ++k) {
        const int node = pair->nodes[k];
        distance += pair->weights[k] * pli_vec3_dot(pair->normal, plii_self_difference(nodes, pair->nodes[0], node));
        motion = pli_vec3_add(motion, pli_vec3_scale(plii_self_motion(nodes, node), pair->weights[k]));
    }
    if (!(distance < pair->target) || !(weight > 0.0f)) { return false; }
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(pair->normal, pli_vec3_dot(motion, pair->normal)));
    const pli_vec3 change = pli_vec3_sub(pli_vec3_scale(pair->normal, (pair->target - distance) / weight),
                                         pli_vec3_scale(sliding, friction / weight));
    for (int k = 0; k < 4; ++k) {
        const int node = pair->nodes[k];
        plii_self_move(nodes, node, change, nodes->offsets[node].w * pair->weights[k]);
    }
    return true;
}

void plii_self_faces_solve(plii_self_faces_state* state, const plii_self_nodes* nodes) {
    const float near = state->def.thickness;
    int contacts = 0;
    for (int i = 0; i < state->active_count; ++i) {
        const plii_self_faces_pair* pair = &state->pairs[state->active[i]];
        if (pair->distance > pair->target + near) { continue; }
        contacts += self_faces_part(nodes, pair, state->def.friction);
    }
    state->report.contacts = contacts;
}

/* Motions of the nodes of a pair end where they would come too near to its plane. True when one did. */
static bool self_faces_shorten(const plii_self_nodes* nodes, const plii_self_faces_pair* pair, bool is_forced) {
    /* Levels of the nodes along the normal, about the middle; positive on the first side. The lowest of each side. */
    float sign[4], level[4], lowest[2] = {FLT_MAX, FLT_MAX};
    const pli_vec3 origin = plii_self_start(nodes, pair->nodes[0]);
    for (int k = 0; k < 4; ++k) {
        const bool is_first = k == 0 || (k == 1 && pair->is_edges);
        const pli_vec3 x = pli_vec3_sub(plii_self_position(nodes, pair->nodes[k]), origin);
        sign[k] = is_first ? 1.0f : -1.0f;
        level[k] = sign[k] * (pli_vec3_dot(pair->normal, x) - pair->middle);
        lowest[is_first] = plii_min(lowest[is_first], level[k]);
    }
    const float kept = 0.5f * SELF_FACES_KEPT * pair->distance;
    if (!is_forced && lowest[0] + lowest[1] >= 2.0f * kept) { return false; } /* apart, if not at this plane */
    bool is_shortened = false;
    for (int k = 0; k < 4; ++k) {
        if (!(level[k] < kept)) { continue; }
        const int node = pair->nodes[k];
        const pli_vec3 motion = plii_self_motion(nodes, node);
        const float change = sign[k] * pli_vec3_dot(pair->normal, motion);
        /* A little more than needed, lest rounding brings the pair back in the next pass. */
        const float share = change < 0.0f ? plii_clamp((level[k] - 1.01f * kept) / change, 0.0f, 1.0f) : 0.0f;
        if (share > 0.0f) {
            plii_self_move(nodes, node, motion, -share);
            is_shortened = true;
        }
    }
    return is_shortened;
}

void plii_self_faces_finish(const pli_body* body, plii_self_faces_state* state, const plii_self_nodes* nodes) {
    state->report.shortened += plii_self_limit_motions(body, nodes, state->motion);
    bool is_done = false;
    for (int pass = 0; pass <= SELF_FACES_MAX_PASSES && !is_done; ++pass) {
        is_done = true;
        for (int i = 0; i < state->active_count; ++i) {
            if (self_faces_shorten(nodes, &state->pairs[state->active[i]], pass == SELF_FACES_MAX_PASSES)) {
                is_done = false;
                state->report.shortened += 1;
            }
        }
    }
}
