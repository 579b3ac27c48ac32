/* Self-collision of nodes (Mueller, "Ten Minute Physics" 15): pairs from a dense hash, found as nodes leave their
   paths; smaller distances at rest count as thickness; a speed limit; friction towards the mean motion of a pair. */

#include "body/pipeline.h"
#include "math/simd_float4.h"
#include "self_collision/self_node_pairs.h"

enum { SELF_NODES_PARTS = 16 };
typedef struct self_nodes_state {
    pli_self_collision_def def;
    pli_vec3 origin; /* of the positions of pairs, which are small so, and precise */
    plii_self_node_pairs pairs;
    int firsts[SELF_NODES_PARTS + 1]; /* pair of each part of them, and of nodes apart */
    int touching_counts[SELF_NODES_PARTS + 1];
    plii_self_pair* touching; /* pairs that the last sweep parted: of each part so many, from where its pairs begin */
    int touching_capacity;
    pli_self_collision_report report;
} self_nodes_state;

// ------------------------------------------------------------------------------------------------------ the search

/* After searches: what they found. */
static void self_nodes_report(const pli_body* body, self_nodes_state* state) {
    const plii_self_node_pairs* pairs = &state->pairs;
    const bool has_room =
        PLII_RESERVE(body->context, &state->touching, &state->touching_capacity, pairs->found.capacity);
    state->report.pairs = pairs->found.count;
    state->report.searches = pairs->searches;
    state->report.is_truncated = state->report.is_truncated || pairs->is_truncated || !has_room;
}

/* At the start of a step. Without substeps constraints move nodes from the ends of their paths. Positions are the
   solver's own then; those of the last search are others where that was in a step with substeps. */
static void self_nodes_begin(pli_body* body, void* data) {
    self_nodes_state* state = data;
    const plii_substep start = plii_substep_of_step(body, body->previous, body->previous);
    const bool has_substeps = body->solver_class->has_substeps;
    const pli_vec3 origin = state->origin;
    const bool has_other_origin = !has_substeps && pli_vec3_length_squared(origin) > 0.0f;
    const int limited = state->report.limited_nodes; /* by the UPDATE stage of this step */
    state->report = (pli_self_collision_report){.limited_nodes = has_substeps ? 0 : limited};
    state->pairs.is_truncated = false;
    state->pairs.searches = 0;
    if (has_substeps) {
        plii_self_node_pairs_copy(body, &state->pairs, &start, &state->origin);
    } else {
        state->origin = pli_vec3_make(0, 0, 0);
        state->pairs.at = body->previous;
    }
    if (has_other_origin || !plii_self_node_pairs_serve_on(body, &state->pairs, state->def.thickness)) {
        state->pairs.thickness = state->def.thickness;
        if (has_substeps) {
            state->origin = plii_xyz(body->previous[0]);
            if (!plii_vec3_is_finite(state->origin)) { state->origin = pli_vec3_make(0, 0, 0); }
            plii_self_node_pairs_copy(body, &state->pairs, &start, &state->origin);
        }
        plii_self_node_pairs_search_step(body, &state->pairs, pli_vec3_sub(origin, state->origin));
    }
    self_nodes_report(body, state);
}

// ------------------------------------------------------------------------------------------------------ the solve

/* Of motions beside the common one. */
static void self_nodes_limit(const pli_body* body, self_nodes_state* state, const plii_substep* substep,
                             pli_vec4* velocities) {
    const float longest = state->def.speed_limit_ratio * state->def.thickness; /* m, 0 without a limit */
    if (!(longest > 0.0f)) { return; }
    state->report.limited_nodes += plii_self_limit_motions(body, substep, longest, velocities, true);
}

static void self_nodes_move(const plii_substep* substep, pli_vec4* at, int node, plii_float4 move) {
    pli_vec4* displacement = &substep->displacements[node];
    plii_float4_to(displacement, plii_float4_from(displacement) + move);
    if (at != substep->displacements) { plii_float4_to(&at[node], plii_float4_from(&at[node]) + move); }
}

static plii_float4 self_nodes_apart(const pli_vec4* at, const plii_self_pair* pair) {
    return plii_float4_from(&at[pair->b]) - plii_float4_from(&at[pair->a]);
}

/* Of a pair that is too near. True when one of them can move. */
static bool self_nodes_part(const plii_substep* substep, pli_vec4* at, plii_self_pair pair, plii_float4 apart,
                            float friction) {
    const float weight_a = at[pair.a].w, weight_b = at[pair.b].w, weight = weight_a + weight_b;
    if (!(weight > 0.0f)) { return false; }
    float distance = sqrtf(plii_lanes_dot(apart, apart)), gap = pair.distance - distance;
    plii_float4 along = plii_lanes_xyz(apart);
    if (!(distance > 1e-6f * pair.distance)) {
        const pli_vec3 direction = plii_self_direction(pair.a, pair.b);
        along = plii_lanes_from_vec3(&direction);
        distance = 1.0f;
    }
    const float scale = gap / (distance * weight);
    self_nodes_move(substep, at, pair.a, along * (-scale * weight_a));
    self_nodes_move(substep, at, pair.b, along * (scale * weight_b));
    if (friction > 0.0f) {
        const pli_vec3 motion =
            pli_vec3_sub(plii_substep_motion(substep, pair.b), plii_substep_motion(substep, pair.a));
        const plii_float4 lanes = plii_lanes_from_vec3(&motion);
        const float share_a = weight_a / weight;
        self_nodes_move(substep, at, pair.a, lanes * (friction * share_a));
        self_nodes_move(substep, at, pair.b, lanes * (friction * (share_a - 1.0f)));
    }
    return true;
}

/* ratio: of distances, squared. */
static bool self_nodes_is_near(plii_float4 apart, const plii_self_pair* pair, float ratio) {
    return plii_lanes_dot(apart, apart) < ratio * (pair->distance * pair->distance);
}

/* Pairs that follow each other in the list share nodes and would wait for each other. So a batch is walked in strides
   of an eighth of it; it is small enough for its nodes to stay in the first cache. All of a batch are looked at,
   without a branch, before those that are too near are parted. */
enum { SELF_NODES_STRIDES = 8, SELF_NODES_BATCH = 8 * 64 };
/* Pairs a little too far, of distances squared, are looked at again; or coils of cloth keep trembling. */
#define SELF_NODES_ALMOST 1.2f

/* Pairs too near, or almost, of a batch. */
static int self_nodes_find_near(const pli_vec4* at, const plii_self_pair* pairs, int count,
                                const plii_self_pair** near) {
    const int stride = (count + SELF_NODES_STRIDES - 1) / SELF_NODES_STRIDES;
    int found = 0;
    for (int k = 0; k < stride; ++k) {
        for (int i = k; i < count; i += stride) {
            near[found] = &pairs[i];
            found += self_nodes_is_near(self_nodes_apart(at, &pairs[i]), &pairs[i], SELF_NODES_ALMOST);
        }
    }
    return found;
}

/* Pairs are in the order of the layers of cells that their first nodes are in, and lead from a layer to itself or to
   the next one. So parts of whole layers, of which one is between, have no node in common. Those of nodes apart come
   last, and all where the hash has no layers. */
static void self_nodes_set_parts(self_nodes_state* state) {
    const plii_self_node_pairs* pairs = &state->pairs;
    const plii_self_pair* items = pairs->found.items;
    const plii_spatial_hash_cell* cells = pairs->hash.cells;
    int count = pairs->hash.strides[0] != 0 ? pairs->found.count : 0;
    while (count > 0 && pairs->is_apart[items[count - 1].a]) {
        count -= 1;
    }
    for (int part = 0, first = 0; part <= SELF_NODES_PARTS; ++part) {
        const int even = (int)((int64_t)count * (part + 1) / SELF_NODES_PARTS);
        state->firsts[part] = first;
        first = first < even ? even : first + 1;
        while (first < count && cells[items[first].a].x == cells[items[first - 1].a].x) {
            first += 1;
        }
        if (first > count) { first = count; }
    }
}

/* A pass over all pairs: those of even parts, of odd ones, and of nodes apart. */
typedef struct self_nodes_parts {
    const pli_body* body;
    self_nodes_state* state;
    void (*run)(const struct self_nodes_parts* pass, int part);
    const plii_substep* substep;
    float friction;
    int odd;
} self_nodes_parts;

static void self_nodes_run_range(int begin, int end, void* data) {
    const self_nodes_parts* pass = data;
    for (int k = begin; k < end; ++k) {
        pass->run(pass, 2 * k + pass->odd);
    }
}

enum { SELF_NODES_PAIR_NS = 16 }; /* so that a range is worth it */
static void self_nodes_run_parts(self_nodes_parts* pass) {
    const int grain = plii_grain(SELF_NODES_PAIR_NS) * SELF_NODES_PARTS / (pass->state->pairs.found.count + 1) + 1;
    for (pass->odd = 0; pass->odd < 2; ++pass->odd) {
        plii_parallel_for(pass->body->context, self_nodes_run_range, pass, SELF_NODES_PARTS / 2, grain);
    }
    pass->run(pass, SELF_NODES_PARTS);
}

static void self_nodes_part_some(const self_nodes_parts* pass, int part) {
    self_nodes_state* state = pass->state;
    const plii_self_pair_list* pairs = &state->pairs.found;
    const int begin = state->firsts[part], end = part < SELF_NODES_PARTS ? state->firsts[part + 1] : pairs->count;
    const plii_self_pair* near[SELF_NODES_BATCH];
    const bool has_room = state->touching_capacity >= pairs->count;
    pli_vec4* at = state->pairs.at;
    int contacts = 0;
    for (int first = begin; first < end; first += SELF_NODES_BATCH) {
        const int left = end - first, count = left < SELF_NODES_BATCH ? left : SELF_NODES_BATCH;
        const int found = self_nodes_find_near(at, pairs->items + first, count, near);
        for (int k = 0; k < found; ++k) {
            const plii_float4 apart = self_nodes_apart(at, near[k]);
            if (!self_nodes_is_near(apart, near[k], 1.0f)) { continue; }
            if (!self_nodes_part(pass->substep, at, *near[k], apart, pass->friction)) { continue; }
            if (has_room) { state->touching[begin + contacts] = *near[k]; }
            contacts += 1;
        }
    }
    state->touching_counts[part] = contacts;
}

/* Given an origin, positions are relative to it. */
static void self_nodes_part_all(const pli_body* body, self_nodes_state* state, const plii_substep* substep,
                                const pli_vec3* origin, float friction) {
    self_nodes_parts pass = {body, state, self_nodes_part_some, substep, friction, 0};
    plii_self_node_pairs_update(body, &state->pairs, substep, origin);
    self_nodes_report(body, state);
    self_nodes_set_parts(state);
    self_nodes_run_parts(&pass);
    state->report.contacts = 0;
    for (int part = 0; part <= SELF_NODES_PARTS; ++part) {
        state->report.contacts += state->touching_counts[part];
    }
}

static void self_nodes_run_position(pli_body* body, void* data) {
    self_nodes_state* state = data;
    const plii_substep step = plii_substep_of_step(body, body->positions, body->previous);
    state->pairs.at = body->positions;
    self_nodes_part_all(body, state, &step, NULL, state->def.friction);
}

static void self_nodes_restart(pli_body* body, void* data, const plii_substep* substep) {
    self_nodes_limit(body, data, substep, NULL);
}

/* Friction is left to the velocities: moved sideways, nodes would get into others. */
static void self_nodes_sweep(pli_body* body, void* data, const plii_substep* substep) {
    self_nodes_state* state = data;
    self_nodes_part_all(body, state, substep, &state->origin, 0.0f);
}

/* Pairs that were parted lose the speed with which they part, and `friction` of their motion. Without substeps only
   what came of an overlap at the start, or folds are pressed together. */
static void self_nodes_slow_some(const self_nodes_parts* pass, int part) {
    const self_nodes_state* state = pass->state;
    const bool has_substeps = pass->body->solver_class->has_substeps;
    const int first = state->firsts[part], last = first + state->touching_counts[part];
    const pli_vec4* at = state->pairs.at;
    pli_vec4* v = pass->body->velocities;
    for (int i = first; i < last; ++i) {
        const int a = state->touching[i].a, b = state->touching[i].b;
        const plii_float4 apart = plii_lanes_xyz(self_nodes_apart(at, &state->touching[i]));
        const plii_float4 relative = plii_lanes_xyz(self_nodes_apart(v, &state->touching[i]));
        const float squared = plii_lanes_dot(apart, apart), parting = plii_lanes_dot(relative, apart);
        if (!(squared > 0.0f)) { continue; }
        float lost = plii_max(parting, 0.0f);
        if (!has_substeps) {
            const plii_float4 start = apart - relative * pass->substep->dt;
            const float overlap = state->touching[i].distance - sqrtf(plii_lanes_dot(start, start));
            lost = plii_min(lost, plii_max(overlap, 0.0f) * pass->substep->inverse_dt * sqrtf(squared));
        }
        const float inverse = 1.0f / (squared * (at[a].w + at[b].w));
        /* change * squared */
        const plii_float4 change = apart * (lost - pass->friction * parting) + relative * (pass->friction * squared);
        plii_float4_to(&v[a], plii_float4_from(&v[a]) + change * (at[a].w * inverse));
        plii_float4_to(&v[b], plii_float4_from(&v[b]) + change * (-at[b].w * inverse));
    }
}

/* Without substeps friction has acted on positions. */
static void self_nodes_slow(pli_body* body, void* data, const plii_substep* substep) {
    self_nodes_state* state = data;
    const float friction = body->solver_class->has_substeps ? state->def.friction : 0.0f;
    self_nodes_parts pass = {body, state, self_nodes_slow_some, substep, friction, 0};
    const bool has_list = state->touching_capacity >= state->pairs.found.count;
    if (has_list && state->report.contacts > 0) { self_nodes_run_parts(&pass); }
}

static void self_nodes_run_finish(pli_body* body, void* data) {
    const plii_substep step = plii_substep_of_step(body, body->positions, body->previous);
    if (!body->solver_class->has_substeps) { self_nodes_slow(body, data, &step); }
}

// ------------------------------------------------------------------------------------------------------ the feature

static void self_nodes_run_update(pli_body* body, void* data) {
    self_nodes_state* state = data;
    if (body->solver_class->has_substeps) { return; }
    state->report.limited_nodes = 0;
    const plii_substep step = plii_substep_of_step(body, body->positions, body->previous);
    self_nodes_limit(body, state, &step, body->velocities);
}

static void self_nodes_enable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    plii_self_node_pairs_start(&state->pairs);
    plii_body_copy_positions(body, state->pairs.rest);
}

static void self_nodes_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    self_nodes_state* state = data;
    plii_self_carry_rest(body, change, state->pairs.rest);
    plii_self_node_pairs_start(&state->pairs);
    state->report = (pli_self_collision_report){0};
}

/* Not in Bullet. Speeds are limited before anything is taken from predicted positions; contacts come after all links
   and, in substeps, before those with rigid bodies, which have the last word. */
enum { SELF_NODES_LIMIT_ORDER = 1, SELF_NODES_ORDER = 50, SELF_NODES_SUBSTEP_ORDER = 55 };

/* Later searches of single nodes look into the table of the last search of all. */
static void self_nodes_on_restored(pli_body* body, void* data) {
    plii_self_node_pairs_rebuild(body, &((self_nodes_state*)data)->pairs);
}

static bool self_nodes_is_sound(const pli_body* body, const void* data) {
    const plii_self_node_pairs* pairs = &((const self_nodes_state*)data)->pairs;
    const int most_apart = body->node_count / PLII_SELF_NODES_PER_APART + PLII_SELF_NODES_APART;
    return pairs->apart_count >= 0 && pairs->apart_count <= most_apart &&
           (!pairs->is_known || (pairs->thickness > 0.0f && pairs->reach >= 0.0f));
}

const plii_feature_class plii_self_nodes_class = {
    .name = "self-collision of nodes",
    .state_size = sizeof(self_nodes_state),
    .settings = PLII_LIMITS_AT(offsetof(self_nodes_state, def),
                               PLII_FIELD(pli_self_collision_def, thickness, PLII_ABOVE_0, PLI_MAX_COORDINATE),
                               PLII_FIELD(pli_self_collision_def, friction, 0, 1),
                               PLII_FIELD(pli_self_collision_def, speed_limit_ratio, 0, PLI_MAX_FACTOR)),
    .state_parts =
        PLII_STATE_PARTS(PLII_STATE_SPAN(self_nodes_state, def, origin, PLII_SAVED, "3fu3f"),
                         PLII_STATE_SPAN(self_nodes_state, pairs.thickness, pairs.reach, PLII_SAVED, "fi2f3ff"),
                         PLII_STATE_SPAN(self_nodes_state, pairs.at, pairs.parts, PLII_LEFT, NULL),
                         PLII_STATE_SPAN(self_nodes_state, pairs.is_known, pairs.searches, PLII_SAVED, "2Bi"),
                         PLII_STATE_SPAN(self_nodes_state, firsts, touching_counts, PLII_LEFT, NULL),
                         PLII_STATE_OF(self_nodes_state, report, PLII_SAVED, "4iB")),
    .is_sound = self_nodes_is_sound,
    .on_restored = self_nodes_on_restored,
    .needs = PLII_NEEDS(&plii_link_graph_class),
    .stages = {[PLII_STAGE_UPDATE] = {self_nodes_run_update, SELF_NODES_LIMIT_ORDER},
               [PLII_STAGE_PREPARE] = {self_nodes_begin, SELF_NODES_ORDER},
               [PLII_STAGE_POSITION] = {self_nodes_run_position, SELF_NODES_ORDER},
               [PLII_STAGE_FINISH] = {self_nodes_run_finish, SELF_NODES_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = SELF_NODES_SUBSTEP_ORDER, .begin = self_nodes_begin,
                                  .restart = self_nodes_restart, .sweep = self_nodes_sweep, .finish = self_nodes_slow),
    .arrays =
        PLII_ARRAYS({PLII_MEMBER(self_nodes_state, pairs.rest), PLII_PER_NODE, .is_kept = true, PLII_FILED_AS("3f")},
                    {PLII_MEMBER(self_nodes_state, pairs.middle), PLII_PER_NODE, PLII_SAVED_AS("3f")},
                    PLII_LEFT_PER_NODE(self_nodes_state, pairs.local),
                    {PLII_MEMBER(self_nodes_state, pairs.searched), PLII_PER_NODE, PLII_SAVED_AS("4f")},
                    {PLII_MEMBER(self_nodes_state, pairs.travel), PLII_PER_NODE, PLII_SAVED_AS("4f")},
                    {PLII_MEMBER(self_nodes_state, pairs.is_apart), PLII_PER_NODE, PLII_SAVED_AS("B")},
                    {PLII_MEMBER(self_nodes_state, pairs.apart), PLII_PER_NODE, .per = PLII_SELF_NODES_PER_APART,
                     .more = PLII_SELF_NODES_APART, PLII_SAVED_AS("n")},
                    PLII_LEFT_PER_NODE(self_nodes_state, pairs.search.linked),
                    PLII_SPATIAL_HASH_LISTS(self_nodes_state, pairs.hash, pairs.search.near),
                    PLII_LEFT_LISTS(self_nodes_state, pairs.parts, search.linked, search.linked_capacity),
                    PLII_LEFT_LISTS(self_nodes_state, pairs.parts, search.near.pairs, search.near.capacity),
                    PLII_LEFT_LISTS(self_nodes_state, pairs.parts, found.items, found.capacity),
                    {PLII_COUNTED_LIST(self_nodes_state, pairs.found.items, pairs.found.capacity, pairs.found.count),
                     PLII_SAVED_AS("2nf")},
                    PLII_LEFT_LIST(self_nodes_state, touching, touching_capacity)),
    .enable = self_nodes_enable,
    .topology_commit = self_nodes_topology_commit,
};

PLII_DEFINE_DEFAULT(pli_self_collision_def, .thickness = 0.01f, .friction = 0.1f, .speed_limit_ratio = 0.2f)
PLII_DEFINE_ENABLE(pli_body_enable_self_collision, plii_check_body_idle, pli_self_collision_def, plii_self_nodes_class)
PLII_DEFINE_DISABLE(pli_body_disable_self_collision, plii_check_body_idle, plii_self_nodes_class)
PLII_DEFINE_STATE_GET(pli_self_collision_report, pli_body_get_self_collision_report, self_nodes_state,
                      plii_self_nodes_class, state->report, (pli_self_collision_report){0})
