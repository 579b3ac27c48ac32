/* Dragging: a spring and a damper from a point of a body to a goal. Both in one, by the backward Euler rule: the force
   at the end of a step h is -k (x - g) - c (x - x0) / h = -(k + c / h) (x - r), with the reference point
   r = (k g + c / h x0) / (k + c / h), so it is one compliant constraint. */

#include "pliant/drag.h"
#include "base/id_pool.h"
#include "body/node_constraint.h"
#include "body/pipeline.h"
#include "body/substep.h"
#include "geometry/closest_point.h"

typedef struct drag_item {
    int slot;
    int nodes[3], node_count;
    float weights[3];
    pli_vec3 shift; /* m, from the point of the nodes to what is dragged */
    float stiffness, damping;
    pli_vec3 from, to; /* goal at the start and the end of the step */
    /* For a step or a substep. */
    pli_vec3 reference;
    float hardness; /* kg: (k + c / h) h^2 */
    pli_vec3 multiplier;
} drag_item;

typedef struct drag_state {
    drag_item* items;
    int count, capacity;
    plii_id_pool ids;
} drag_state;

/* `places`: displacements in a substep, else (NULL) positions, which may be those of the start of the step. */
static pli_vec3 drag_point(const pli_body* body, const drag_item* item, const plii_substep* substep,
                           const pli_vec4* places) {
    pli_vec3 point = item->shift;
    for (int k = 0; k < item->node_count; ++k) {
        const int node = item->nodes[k];
        const pli_vec3 place =
            substep != NULL ? plii_substep_place(body, substep, places, node) : plii_xyz(places[node]);
        point = pli_vec3_add(point, pli_vec3_scale(place, item->weights[k]));
    }
    return point;
}

/* From `start`, towards a goal. */
static void drag_begin_solve(drag_item* item, pli_vec3 start, pli_vec3 goal, float dt) {
    const float spring = item->stiffness * dt * dt, damper = item->damping * dt;
    item->hardness = spring + damper;
    const float share = item->hardness > 0.0f ? spring / item->hardness : 0.0f;
    item->reference = pli_vec3_lerp(start, goal, share);
    item->multiplier = pli_vec3_make(0, 0, 0);
}

/* The step of the multiplier, kg m, of a point that is at `point` and as heavy as the nodes are. */
static pli_vec3 drag_impulse(drag_item* item, const pli_body* body, pli_vec3 point) {
    const float weight = plii_point_weight(body->positions, item->node_count, item->nodes, item->weights, 0.0f);
    const pli_vec3 error = pli_vec3_sub(item->reference, point);
    const pli_vec3 missing = pli_vec3_sub(pli_vec3_scale(error, item->hardness), item->multiplier);
    const pli_vec3 step = pli_vec3_scale(missing, 1.0f / (1.0f + item->hardness * weight));
    if (!plii_vec3_is_finite(step)) { return pli_vec3_make(0, 0, 0); }
    item->multiplier = pli_vec3_add(item->multiplier, step);
    return step;
}

static void drag_prepare(pli_body* body, void* data) {
    drag_state* state = data;
    for (PLII_EACH(drag_item, item, state->items, state->count)) {
        drag_begin_solve(item, drag_point(body, item, NULL, body->previous), item->to, body->step.dt);
    }
}

/* In a substep, or in a whole step (NULL). */
static void drag_sweep(pli_body* body, void* data, const plii_substep* substep) {
    drag_state* state = data;
    pli_vec4* places = substep != NULL ? substep->displacements : body->positions;
    for (PLII_EACH(drag_item, item, state->items, state->count)) {
        const pli_vec3 push = drag_impulse(item, body, drag_point(body, item, substep, places));
        for (int k = 0; k < item->node_count; ++k) {
            pli_vec4* place = &places[item->nodes[k]];
            plii_add_xyz(place, pli_vec3_scale(push, item->weights[k] * place->w));
        }
    }
}

static void drag_solve(pli_body* body, void* data) {
    if (!body->solver_class->solves_constraints) { drag_sweep(body, data, NULL); } /* else it is in the system */
}

static void drag_finish(pli_body* body, void* data) {
    drag_state* state = data;
    for (PLII_EACH(drag_item, item, state->items, state->count)) {
        item->from = item->to;
    }
}

/* Each node on a spring of its own, stiff by its weight: the sum of the forces is that of the point, and its moment
   against the turning of the face is a damper of the step. At the start of a step, before nodes move. */
static void drag_visit_springs(pli_body* body, void* data, plii_spring_fn* visit, void* user) {
    const drag_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        drag_item item = state->items[i];
        const pli_vec3 start = drag_point(body, &item, NULL, body->positions);
        drag_begin_solve(&item, start, item.to, body->step.dt);
        const pli_vec3 way = pli_vec3_sub(item.reference, start);
        for (int k = 0; k < item.node_count; ++k) {
            const plii_node_spring spring = {
                .node = item.nodes[k], .hardness = item.weights[k] * item.hardness, .way = way};
            visit(&spring, user);
        }
    }
}

static void drag_restart(pli_body* body, void* data, const plii_substep* substep) {
    drag_state* state = data;
    const float share = (float)(substep->index + 1) * substep->dt * body->step.inverse_dt;
    for (PLII_EACH(drag_item, item, state->items, state->count)) {
        const pli_vec3 goal = pli_vec3_lerp(item->from, item->to, share);
        drag_begin_solve(item, drag_point(body, item, substep, substep->start_displacements), goal, substep->dt);
    }
}

/* Faces that are cut are no longer there; their old nodes are. */
static void drag_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    drag_state* state = data;
    for (PLII_EACH(drag_item, item, state->items, state->count)) {
        int face = 0, heaviest = 0;
        while (face < change->face_count && memcmp(item->nodes, change->faces[face], sizeof item->nodes) != 0) {
            ++face;
        }
        if (item->node_count == 1 || face < change->face_count) { continue; }
        for (int k = 1; k < item->node_count; ++k) {
            if (item->weights[k] > item->weights[heaviest]) { heaviest = k; }
        }
        const pli_vec3 point = drag_point(body, item, NULL, body->positions);
        item->nodes[0] = item->nodes[heaviest];
        item->weights[0] = 1.0f;
        item->node_count = 1;
        item->shift = pli_vec3_sub(point, plii_xyz(body->positions[item->nodes[0]]));
    }
}

/* After the links, which pull it back. */
enum { DRAG_ORDER = PLII_ORDER_LINKS + 3, DRAG_SUBSTEP_ORDER = 42, DRAG_FINISH_ORDER = 0 };

static bool drag_is_sound(const pli_body* body, const void* data) {
    const drag_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        const drag_item* item = &state->items[i];
        const bool has_nodes = item->node_count >= 1 && item->node_count <= 3;
        if (!has_nodes || !plii_id_pool_has(&state->ids, item->slot, i)) { return false; }
    }
    return plii_id_pool_is_sound(&state->ids, state->count);
}

const plii_feature_class plii_drag_class = {
    .name = "drags",
    .is_made_by_calls = true,
    .state_size = sizeof(drag_state),
    /* Stays when the last drag ends, so that old ids stay stale. */
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(drag_state, ids.first_free1, PLII_SAVED, "i")),
    .is_sound = drag_is_sound,
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(drag_state, items, capacity, count), .is_kept = true, PLII_SAVED_AS("i3ni21f"),
         .settings = PLII_LIMITS_AT(0, PLII_FIELD(drag_item, stiffness, 0, PLI_MAX_COEFFICIENT),
                                    PLII_FIELD(drag_item, damping, 0, FLT_MAX),
                                    PLII_FIELD(drag_item, to, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE))},
        {PLII_COUNTED_LIST(drag_state, ids.slots, ids.capacity, ids.count), .is_kept = true, PLII_SAVED_AS("uii")}),
    .stages = {[PLII_STAGE_PREPARE] = {drag_prepare, DRAG_ORDER},
               [PLII_STAGE_POSITION] = {drag_solve, DRAG_ORDER},
               [PLII_STAGE_FINISH] = {drag_finish, DRAG_FINISH_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = DRAG_SUBSTEP_ORDER, .restart = drag_restart, .sweep = drag_sweep),
    .visit_springs = drag_visit_springs,
    .topology_commit = drag_topology_commit,
};

PLII_DEFINE_DEFAULT(pli_drag_def, .face = PLI_NULL_INDEX, .frequency = 5.0f, .damping_ratio = 1.0f)

static const plii_field drag_fields[] = {
    PLII_FIELD(pli_drag_def, point, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE),
    PLII_FIELD(pli_drag_def, frequency, 0, PLI_MAX_FACTOR),
    PLII_FIELD(pli_drag_def, stiffness, 0, PLI_MAX_COEFFICIENT),
    PLII_FIELD(pli_drag_def, damping_ratio, 0, PLI_MAX_FACTOR),
};

/* A face without an area is held at its first node. */
static void drag_take_hold(const pli_body* body, const pli_drag_def* def, drag_item* item) {
    item->node_count = 1;
    item->nodes[0] = def->node;
    item->weights[0] = 1.0f;
    if (def->face == PLI_NULL_INDEX) { return; }
    const int* nodes = body->topology->faces[def->face];
    const pli_vec3 a = plii_xyz(body->positions[nodes[0]]), b = plii_xyz(body->positions[nodes[1]]),
                   c = plii_xyz(body->positions[nodes[2]]);
    item->nodes[0] = nodes[0];
    if (!plii_measure_triangle(a, b, c).is_usable) { return; }
    plii_closest_feature closest;
    plii_closest_point_on_triangle(def->point, a, b, c, &closest);
    item->node_count = 3;
    memcpy(item->nodes, nodes, sizeof item->nodes);
    memcpy(item->weights, &closest.weights, sizeof item->weights);
}

static void drag_set_spring(const pli_body* body, const pli_drag_def* def, drag_item* item) {
    const double mass = (double)pli_body_total_mass(body);
    const double rate = 2.0 * 3.14159265358979 * (double)def->frequency; /* rad/s */
    const double wanted = def->stiffness > 0.0f ? (double)def->stiffness : mass * rate * rate;
    item->stiffness = (float)fmin(wanted, (double)PLI_MAX_COEFFICIENT);
    item->damping = (float)(2.0 * (double)def->damping_ratio * sqrt((double)item->stiffness * mass));
}

pli_status pli_body_begin_drag(pli_body* body, const pli_drag_def* def, pli_drag_id* drag) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_DEF(body->context, pli_drag_def, def, drag_fields, __func__);
    PLII_TRY(def->face == PLI_NULL_INDEX
                 ? plii_check_node(body, def->node, __func__)
                 : plii_check_index(body->context, def->face, body->topology->face_count, "face", "body", __func__));
    if (drag == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "drag is null"); }
    PLII_TRY_ENABLE(body, drag_state, state, plii_drag_class);
    if (!PLII_GROW(body->context, &state->items, &state->capacity, state->count) ||
        !plii_id_pool_reserve(body->context, &state->ids, 1)) {
        return PLII_FAIL_ENABLED(body, plii_drag_class, __func__, "no memory for a drag");
    }
    drag_item* item = &state->items[state->count];
    *item = (drag_item){.slot = plii_id_pool_alloc(&state->ids, state->count)};
    drag_take_hold(body, def, item);
    drag_set_spring(body, def, item);
    item->from = item->to = drag_point(body, item, NULL, body->positions);
    state->count += 1;
    *drag = (pli_drag_id){item->slot + 1, state->ids.slots[item->slot].generation};
    return plii_body_changed(body, PLI_OK);
}

static pli_status drag_find(const pli_body* body, pli_drag_id drag, const char* function, drag_item** item) {
    const drag_state* state = plii_feature_state(body, &plii_drag_class);
    const int place = state != NULL ? plii_id_pool_find(&state->ids, drag.index1, drag.generation) : PLI_NULL_INDEX;
    PLII_FAIL_IF(place == PLI_NULL_INDEX, body->context, PLI_ERROR_STALE_ID, function, "the body has no drag {%d, %u}",
                 (int)drag.index1, (unsigned)drag.generation);
    *item = &state->items[place];
    return PLI_OK;
}

pli_status pli_body_move_drag(pli_body* body, pli_drag_id drag, pli_vec3 goal) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_vec3_within(body->context, goal, PLI_MAX_COORDINATE, "goal", __func__));
    drag_item* item = NULL;
    PLII_TRY(drag_find(body, drag, __func__, &item));
    item->to = goal;
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_end_drag(pli_body* body, pli_drag_id drag) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    drag_item* item = NULL;
    PLII_TRY(drag_find(body, drag, __func__, &item));
    drag_state* state = plii_feature_state(body, &plii_drag_class);
    const int slot = item->slot;
    PLII_ID_POOL_REMOVE_IF(&state->ids, drag_item, at, state->items, state->count, at->slot == slot);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_get_drag(const pli_body* body, pli_drag_id drag, pli_vec3* point, pli_vec3* goal) {
    if (point != NULL) { *point = pli_vec3_make(0, 0, 0); }
    if (goal != NULL) { *goal = pli_vec3_make(0, 0, 0); }
    PLII_TRY(plii_check_body(body, __func__));
    drag_item* item = NULL;
    PLII_TRY(drag_find(body, drag, __func__, &item));
    if (point != NULL) { *point = drag_point(body, item, NULL, body->positions); }
    if (goal != NULL) { *goal = item->to; }
    return PLI_OK;
}
