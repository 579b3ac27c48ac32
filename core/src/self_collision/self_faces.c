/* Self-collision of faces: nodes with faces and edges with edges that have no node in common. Pairs within reach are
   collected once per step; of those, a substep looks at the ones that could come together in it. Nearest points at the
   start of a step (or substep) give each pair a plane between its sides. Pairs nearer than the thickness are pushed
   apart along its normal, like other contacts; whatever constraints do then, motions are in the end cut short where a
   pair would get to the wrong side of its plane. So nothing that starts apart ever crosses, as in Lan and others,
   "Penetration-free Projective Dynamics", and Chen and others, "Offset Geometric Contact". */

#include "body/pipeline.h"
#include "self_collision/self_faces_impl.h"

// ----------------------------------------------------------------------------------------------------------- the solve

#define SELF_FACES_MAX_PASSES 16
/* Share of its distance that a pair keeps at least. */
#define SELF_FACES_KEPT 0.2f

/* The inverse mass of both sides. Where one is pinned, a node that bears little beside pinned ones does not go far. */
static float self_faces_weight(const pli_vec4* displacements, const plii_self_faces_pair* pair) {
    const int second = pair->is_edges ? 2 : 1;
    const int *nodes = pair->nodes, *others = pair->nodes + second;
    const float *weights = pair->weights, *other_weights = pair->weights + second;
    const float first = plii_point_weight(displacements, second, nodes, weights, 0.0f);
    const float other = plii_point_weight(displacements, 4 - second, others, other_weights, 0.0f);
    if (!(first > 0.0f)) { return plii_point_weight_unpinned(displacements, 4 - second, others, other_weights); }
    return other > 0.0f ? first + other : plii_point_weight_unpinned(displacements, second, nodes, weights);
}

/* `of`: displacements or velocities. */
static void self_faces_push(const plii_substep* substep, const plii_self_faces_pair* pair, pli_vec3 change,
                            pli_vec4* of) {
    for (int k = 0; k < 4; ++k) {
        const int node = pair->nodes[k];
        plii_add_xyz(&of[node], pli_vec3_scale(change, substep->displacements[node].w * pair->weights[k]));
    }
}

/* True when the pair was too near. */
static bool self_faces_part(const pli_body* body, const plii_substep* substep, const plii_self_faces_pair* pair,
                            float friction) {
    const float weight = self_faces_weight(substep->displacements, pair);
    float distance = 0.0f;
    pli_vec3 motion = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < 4; ++k) {
        const int node = pair->nodes[k];
        distance +=
            pair->weights[k] * pli_vec3_dot(pair->normal, plii_self_difference(body, substep, pair->nodes[0], node));
        motion = pli_vec3_add(motion, pli_vec3_scale(plii_substep_motion(substep, node), pair->weights[k]));
    }
    if (!(distance < pair->target) || !(weight > 0.0f)) { return false; }
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(pair->normal, pli_vec3_dot(motion, pair->normal)));
    const pli_vec3 change = pli_vec3_sub(pli_vec3_scale(pair->normal, (pair->target - distance) / weight),
                                         pli_vec3_scale(sliding, friction / weight));
    self_faces_push(substep, pair, change, substep->displacements);
    return true;
}

/* Pairs that overlapped at the start lose the speed that came of drawing that out. */
static void self_faces_slow(pli_body* body, void* data, const plii_substep* substep) {
    const plii_self_faces_state* state = data;
    for (int i = 0; i < state->active_count; ++i) {
        const plii_self_faces_pair* pair = &state->pairs[state->active[i]];
        const float overlap = pair->target - pair->distance, weight = self_faces_weight(substep->displacements, pair);
        if (!(overlap > 0.0f) || !(weight > 0.0f)) { continue; }
        float parting = 0.0f;
        for (int k = 0; k < 4; ++k) {
            parting += pair->weights[k] * pli_vec3_dot(pair->normal, plii_xyz(body->velocities[pair->nodes[k]]));
        }
        const float lost = plii_clamp(parting, 0.0f, overlap * substep->inverse_dt);
        self_faces_push(substep, pair, pli_vec3_scale(pair->normal, -lost / weight), body->velocities);
    }
}

/* Pushes pairs apart that are too near. */
static void self_faces_solve(const pli_body* body, plii_self_faces_state* state, const plii_substep* substep) {
    const float near = state->def.thickness;
    int contacts = 0;
    for (int i = 0; i < state->active_count; ++i) {
        const plii_self_faces_pair* pair = &state->pairs[state->active[i]];
        if (pair->distance > pair->target + near) { continue; }
        contacts += self_faces_part(body, substep, pair, state->def.friction);
    }
    state->report.contacts = contacts;
}

/* What nodes that nothing stops have in common, or else all: that is not cut short. */
static pli_vec3 self_faces_common_motion(const pli_body* body, const plii_substep* substep) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    int count = 0;
    for (int i = 0; i < body->node_count; ++i) {
        if (substep->displacements[i].w > 0.0f) { continue; }
        sum = pli_vec3_add(sum, plii_substep_motion(substep, i));
        count += 1;
    }
    return count > 0 ? pli_vec3_scale(sum, 1.0f / (float)count) : plii_self_common_motion(body, substep, NULL);
}

/* Ends motions beside the common one, with which the plane of a pair goes, too near to that; velocities, where given,
   follow. True when one did. */
static bool self_faces_shorten(const pli_body* body, const plii_substep* substep, const plii_self_faces_pair* pair,
                               pli_vec3 common, bool is_forced, pli_vec4* velocities) {
    /* Levels of the nodes along the normal, about the middle; positive on the first side. The lowest of each side. */
    float sign[4], level[4], lowest[2] = {FLT_MAX, FLT_MAX};
    const pli_vec3 origin = pli_vec3_add(plii_substep_start(body, substep, pair->nodes[0]), common);
    for (int k = 0; k < 4; ++k) {
        const bool is_first = k == 0 || (k == 1 && pair->is_edges);
        const pli_vec3 x = pli_vec3_sub(plii_substep_position(body, substep, pair->nodes[k]), origin);
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
        if (!(substep->displacements[node].w > 0.0f)) { continue; }
        const pli_vec3 motion = pli_vec3_sub(plii_substep_motion(substep, node), common);
        const float change = sign[k] * pli_vec3_dot(pair->normal, motion);
        /* A little more than needed, lest rounding brings the pair back in the next pass. */
        const float share = change < 0.0f ? plii_clamp((level[k] - 1.01f * kept) / change, 0.0f, 1.0f) : 0.0f;
        if (share > 0.0f) {
            const pli_vec3 less = pli_vec3_scale(motion, -share);
            plii_add_xyz(&substep->displacements[node], less);
            if (velocities != NULL) { plii_add_xyz(&velocities[node], pli_vec3_scale(less, substep->inverse_dt)); }
            is_shortened = true;
        }
    }
    return is_shortened;
}

/* After all constraints of a step or substep: cuts motions short. */
static void self_faces_finish(const pli_body* body, plii_self_faces_state* state, const plii_substep* substep,
                              pli_vec4* velocities) {
    state->report.shortened += plii_self_limit_motions(body, substep, state->motion, velocities, false);
    const pli_vec3 common = self_faces_common_motion(body, substep);
    bool is_done = false;
    for (int pass = 0; pass <= SELF_FACES_MAX_PASSES && !is_done; ++pass) {
        is_done = true;
        for (int i = 0; i < state->active_count; ++i) {
            const bool is_forced = pass == SELF_FACES_MAX_PASSES;
            const plii_self_faces_pair* pair = &state->pairs[state->active[i]];
            if (self_faces_shorten(body, substep, pair, common, is_forced, velocities)) {
                is_done = false;
                state->report.shortened += 1;
            }
        }
    }
}

// --------------------------------------------------------------------------------------------------------- the feature

/* Of the thickness: how far constraints may move a node in a substep beyond its free motion. */
#define SELF_FACES_SUBSTEP_ROOM 0.1f

static void self_faces_run_prepare(pli_body* body, void* data) {
    plii_self_faces_state* state = data;
    memcpy(state->starts, body->previous, (size_t)body->node_count * sizeof *state->starts);
    const plii_substep step = plii_substep_of_step(body, body->positions, state->starts);
    plii_self_faces_begin(body, state);
    plii_self_faces_restart(body, state, &step, state->travel);
}

static void self_faces_run_position(pli_body* body, void* data) {
    plii_self_faces_state* state = data;
    const plii_substep step = plii_substep_of_step(body, body->positions, state->starts);
    self_faces_solve(body, state, &step);
}

/* After velocities were taken from positions. */
static void self_faces_run_finish(pli_body* body, void* data) {
    plii_self_faces_state* state = data;
    if (body->solver_class->has_substeps) { return; }
    const plii_substep step = plii_substep_of_step(body, body->positions, state->starts);
    self_faces_finish(body, state, &step, body->velocities);
    self_faces_slow(body, state, &step);
}

static void self_faces_restart_substep(pli_body* body, void* data, const plii_substep* substep) {
    plii_self_faces_state* state = data;
    const float most = state->travel * substep->dt * body->step.inverse_dt;
    const float room = SELF_FACES_SUBSTEP_ROOM * state->def.thickness;
    plii_self_faces_restart(body, state, substep, plii_self_faces_bound(body, substep, room, most));
}

static void self_faces_sweep(pli_body* body, void* data, const plii_substep* substep) {
    self_faces_solve(body, data, substep);
    self_faces_finish(body, data, substep, NULL);
}

static void self_faces_enable(pli_body* body, void* data) {
    plii_self_faces_state* state = data;
    plii_body_copy_positions(body, state->rest);
    plii_self_faces_find_edges(body, state);
}

static void self_faces_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    plii_self_faces_state* state = data;
    plii_self_carry_rest(body, change, state->rest);
    plii_self_faces_find_edges(body, state);
    state->pair_count = state->active_count = 0;
    state->reach = 0.0f;
}

/* Not in Bullet. After all links, and nothing may move nodes after the motions are cut short. */
enum { SELF_FACES_ORDER = 50, SELF_FACES_LAST_ORDER = 60, SELF_FACES_SUBSTEP_ORDER = 1000 };
const plii_feature_class plii_self_faces_class = {
    .name = "self-collision of faces",
    .state_size = sizeof(plii_self_faces_state),
    .settings = PLII_LIMITS_AT(offsetof(plii_self_faces_state, def),
                               PLII_FIELD(pli_self_faces_def, thickness, PLII_ABOVE_0, PLI_MAX_COORDINATE),
                               PLII_FIELD(pli_self_faces_def, friction, 0, 1),
                               PLII_FIELD(pli_self_faces_def, max_travel, 0, PLI_MAX_COORDINATE)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(plii_self_faces_state, def, moved, PLII_SAVED, "3fu2f"),
                                    PLII_STATE_OF(plii_self_faces_state, mean_edge_length, PLII_FILED, "f"),
                                    PLII_STATE_SPAN(plii_self_faces_state, travel, hits, PLII_LEFT, NULL),
                                    PLII_STATE_OF(plii_self_faces_state, report, PLII_SAVED, "3iB")),
    .stages = {[PLII_STAGE_PREPARE] = {self_faces_run_prepare, SELF_FACES_ORDER},
               [PLII_STAGE_POSITION] = {self_faces_run_position, SELF_FACES_ORDER},
               [PLII_STAGE_FINISH] = {self_faces_run_finish, SELF_FACES_LAST_ORDER}},
    .substepped =
        PLII_SUBSTEPPED(.order = SELF_FACES_SUBSTEP_ORDER, .begin = plii_self_faces_begin,
                        .restart = self_faces_restart_substep, .sweep = self_faces_sweep, .finish = self_faces_slow),
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(plii_self_faces_state, rest), PLII_PER_NODE, .is_kept = true, PLII_FILED_AS("3f")},
        PLII_LEFT_PER_NODE(plii_self_faces_state, starts),
        {PLII_MEMBER(plii_self_faces_state, rows), PLII_PER_NODE, .more = 1, .is_scratch = true},
        {PLII_MEMBER(plii_self_faces_state, firsts), PLII_PER_FACE, .times = 3, .is_scratch = true},
        {PLII_MEMBER(plii_self_faces_state, corners), PLII_PER_FACE, .times = 3, .is_scratch = true},
        {PLII_MEMBER(plii_self_faces_state, edges), PLII_PER_FACE, .times = 3, .snapshot = PLII_LEFT},
        {PLII_MEMBER(plii_self_faces_state, last), PLII_PER_NODE, PLII_SAVED_AS("3f")},
        PLII_BVH_LISTS(plii_self_faces_state, tree), PLII_LEFT_LIST(plii_self_faces_state, boxes, box_capacity),
        PLII_LEFT_LISTS(plii_self_faces_state, hits, items, capacity),
        {PLII_COUNTED_LIST(plii_self_faces_state, pairs, pair_capacity, pair_count), PLII_SAVED_AS("4nB10f")},
        {PLII_COUNTED_LIST(plii_self_faces_state, due, due_capacity, pair_count), PLII_SAVED_AS("f")},
        PLII_LEFT_COUNTED(plii_self_faces_state, active, active_capacity, active_count)),
    .enable = self_faces_enable,
    .topology_commit = self_faces_topology_commit,
};

PLII_DEFINE_DEFAULT(pli_self_faces_def, .thickness = 0.01f, .friction = 0.1f)
pli_status pli_body_enable_self_faces(pli_body* body, const pli_self_faces_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_self_faces_def, used, def, plii_self_faces_class);
    PLII_TRY(plii_check_faces(body, "faces are kept apart", __func__));
    plii_self_faces_state* state = NULL;
    PLII_TRY(plii_feature_enable_with(body, &plii_self_faces_class, &used, sizeof used, (void**)&state));
    state->reach = 0.0f;
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_DISABLE(pli_body_disable_self_faces, plii_check_body_idle, plii_self_faces_class)
PLII_DEFINE_STATE_GET(pli_self_faces_report, pli_body_get_self_faces_report, plii_self_faces_state,
                      plii_self_faces_class, state->report, (pli_self_faces_report){0})
