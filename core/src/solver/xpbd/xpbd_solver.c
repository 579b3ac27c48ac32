/* XPBD: a step is parted into substeps; each moves the nodes freely, sweeps over the constraints and takes the
   velocities from the motion. Macklin, Mueller, Chentanez, "XPBD", and Macklin and others, "Small Steps in Physics
   Simulation". Contacts are looked for once per step, at the positions that a step without constraints would reach. */

#include "body/substep_rigid.h"
#include "math/simd_float4.h"
#include "solver/xpbd/xpbd_impl.h"

enum {
    XPBD_NODES_GRAIN = 2048,
    XPBD_SUBSTEPS_PER_START = 5 /* positions follow the nodes after so many */
};

typedef struct xpbd_state {
    /* Of the step in progress. */
    plii_substep_kinds kinds;
    plii_xpbd_nodes nodes;
    bool has_finish;
    int sweep;
    pli_xpbd_def def;
    float reference_dt;                                            /* s; 0: there was no step yet */
    bool had_links;                                                /* on positions, before this solver came */
    pli_vec4 *displacements, *start_displacements, *accelerations; /* [node_count] */
} xpbd_state;

/* Consumes the forces; `limit` of accelerations by them, m/s^2. */
static pli_vec3 xpbd_acceleration(const pli_body* body, int node, float limit) {
    const float inverse_mass = body->positions[node].w;
    pli_vec3 acceleration = pli_vec3_make(0, 0, 0);
    if (body->forces != NULL) {
        acceleration = plii_vec3_clamp(pli_vec3_scale(body->forces[node], inverse_mass), limit);
        body->forces[node] = pli_vec3_make(0, 0, 0);
    }
    return inverse_mass > 0.0f ? pli_vec3_add(acceleration, body->world->def.gravity) : pli_vec3_make(0, 0, 0);
}

static void xpbd_integrate_free(int begin, int end, void* data) {
    const pli_body* body = data;
    const plii_step* step = &body->step;
    const xpbd_state* state = plii_feature_state(body, &plii_xpbd_class);
    /* As in the position-based solver. */
    const float limit = body->world->def.max_force_displacement * step->inverse_dt * step->inverse_dt;
    const plii_float4 dt = plii_float4_all(step->dt);
    for (int i = begin; i < end; ++i) {
        const pli_vec3 a = xpbd_acceleration(body, i, limit);
        const plii_float4 acceleration = plii_lanes_xyzw(a.x, a.y, a.z, 0.0f);
        const plii_float4 position = plii_float4_from(&body->positions[i]);
        const plii_float4 velocity = plii_float4_from(&body->velocities[i]) + acceleration * dt;
        plii_float4_to(&state->accelerations[i], acceleration);
        plii_float4_to(&body->previous[i], plii_lanes_xyz(position));
        plii_float4_to(&body->positions[i], position + velocity * dt);
    }
}

static void xpbd_predict(pli_body* body, float dt) {
    plii_solver_set_step(body, dt);
    body->gas = NULL;
    plii_run_stage(body, PLII_STAGE_FORCES);
    plii_body_run_nodes(body, xpbd_integrate_free, body, XPBD_NODES_GRAIN);
    plii_run_stage(body, PLII_STAGE_UPDATE);
    plii_solver_update_predicted_bounds(body);
}

static const plii_xpbd_nodes_kernel* xpbd_kernel(const pli_body* body) {
    return PLII_KERNEL(body->context, &plii_xpbd_nodes);
}

/* What sweeps leave of errors acts as springs of mass / dt^2: in steps that are shorter than those before they would be
   stiffer as they are stretched, and have more energy. So they stay as stiff as in a step of a reference length, which
   rises slowly lest single long steps soften a body, and falls slowly. Time scales do not count. */
static float xpbd_find_lag(const pli_body* body, xpbd_state* state) {
    const float dt = body->host_dt, before = state->reference_dt > 0.0f ? state->reference_dt : dt;
    const float ratio = before / dt, falls = plii_max(1.0f - 0.003f * ratio * ratio, 0.75f);
    state->reference_dt =
        ratio < 1.0f ? before + 0.1f * (plii_min(dt, 4.0f * before) - before) : plii_max(before * falls, dt);
    return plii_max(state->reference_dt * state->reference_dt / (dt * dt) - 1.0f, 0.0f);
}

static void xpbd_begin(pli_body* body) {
    xpbd_state* state = plii_feature_state(body, &plii_xpbd_class);
    const plii_step* step = &body->step;
    const float parts = (float)state->def.substeps;
    state->nodes = (plii_xpbd_nodes){.substep = {.dt = step->dt / parts,
                                                 .inverse_dt = step->inverse_dt * parts,
                                                 .host_dt = body->host_dt / parts,
                                                 .inverse_host_dt = 1.0f / body->host_dt * parts,
                                                 .lag = xpbd_find_lag(body, state),
                                                 .displacements = state->displacements,
                                                 .start_displacements = state->start_displacements,
                                                 .limits = &state->kinds.limits},
                                     .positions = body->positions,
                                     .velocities = body->velocities,
                                     .previous = body->previous,
                                     .accelerations = state->accelerations};
    body->damps_links = false;
    plii_substep_kinds_begin(body, &state->kinds, false);
    state->has_finish = false;
    for (int k = 0; k < state->kinds.count; ++k) {
        state->has_finish = state->has_finish || state->kinds.at[k]->klass->substepped->finish != NULL;
    }
    state->sweep = 0;
    body->substep = &state->nodes.substep;
    plii_body_run_nodes(body, xpbd_kernel(body)->begin, &state->nodes, XPBD_NODES_GRAIN);
}

static void xpbd_end_substep(pli_body* body, xpbd_state* state) {
    const plii_xpbd_nodes_kernel* pass = xpbd_kernel(body);
    const int count = state->def.substeps, done = state->nodes.substep.index + 1;
    state->nodes.follows = done == count || done % XPBD_SUBSTEPS_PER_START == 0;
    plii_body_run_nodes(body, done < count && !state->has_finish ? pass->finish_and_move : pass->finish, &state->nodes,
                        XPBD_NODES_GRAIN);
    for (PLII_EACH_AT(const plii_pipeline_entry, entry, state->kinds.at, state->kinds.count)) {
        plii_substep_fn* finish = entry->klass->substepped->finish;
        if (finish != NULL) { finish(body, entry->state, &state->nodes.substep); }
    }
}

static void xpbd_sweep(pli_body* body) {
    xpbd_state* state = plii_feature_state(body, &plii_xpbd_class);
    plii_substep* substep = &state->nodes.substep;
    if (state->sweep == state->def.sweeps) {
        xpbd_end_substep(body, state);
        substep->index += 1;
        state->sweep = 0;
        if (state->has_finish) { plii_body_run_nodes(body, xpbd_kernel(body)->move, &state->nodes, XPBD_NODES_GRAIN); }
    }
    if (state->sweep == 0) {
        substep->remaining = (float)(state->def.substeps - 1 - substep->index) * substep->dt;
        substep->has_new_positions = substep->index == 0 || state->nodes.follows;
        plii_substep_kinds_restart(body, &state->kinds, substep);
    }
    substep->is_first_sweep = state->sweep == 0;
    substep->is_last_sweep = ++state->sweep == state->def.sweeps;
    plii_substep_kinds_sweep(body, &state->kinds, substep);
}

static void xpbd_end(pli_body* body) {
    xpbd_state* state = plii_feature_state(body, &plii_xpbd_class);
    xpbd_end_substep(body, state);
    const float kept = 1.0f - body->solver.velocity_damping;
    for (int i = 0; i < body->node_count && kept < 1.0f; ++i) {
        const pli_vec3 velocity = plii_xyz(body->velocities[i]);
        if (body->positions[i].w > 0.0f) { plii_set_xyz(&body->velocities[i], pli_vec3_scale(velocity, kept)); }
    }
    plii_substep_rigids_finish(body, state->nodes.substep.host_dt);
    plii_run_stage(body, PLII_STAGE_FINISH);
    body->substep = NULL;
}
static plii_solver_pace xpbd_pace(const pli_body* body) {
    const xpbd_state* state = plii_feature_state(body, &plii_xpbd_class);
    return (plii_solver_pace){state->def.substeps, state->def.sweeps};
}

static void xpbd_solve(pli_body* first) {
    plii_solve_island(first, xpbd_pace(first), xpbd_begin, xpbd_sweep, plii_solver_couple, xpbd_end);
}

static const plii_solver_class xpbd_solver = {
    .name = "XPBD", .predict = xpbd_predict, .pace = xpbd_pace, .solve = xpbd_solve, .has_substeps = true};

const plii_feature_class plii_xpbd_class = {
    .name = "XPBD solver",
    .state_size = sizeof(xpbd_state),
    .settings = PLII_LIMITS_AT(offsetof(xpbd_state, def), PLII_FIELD(pli_xpbd_def, substeps, 1, INT_MAX),
                               PLII_FIELD(pli_xpbd_def, sweeps, 1, INT_MAX)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(xpbd_state, def, reference_dt, PLII_SAVED, "2iuf"),
                                    PLII_STATE_SPAN(xpbd_state, kinds, sweep, PLII_LEFT, NULL),
                                    PLII_STATE_OF(xpbd_state, had_links, PLII_FILED, "B")),
    /* Nothing of a step is needed by the next one. */
    .arrays =
        PLII_ARRAYS(PLII_LEFT_PER_NODE(xpbd_state, displacements), PLII_LEFT_PER_NODE(xpbd_state, start_displacements),
                    PLII_LEFT_PER_NODE(xpbd_state, accelerations)),
    .solver = &xpbd_solver,
};

pli_status plii_xpbd_enable_kind(pli_body* body, const plii_feature_class* klass, const void* given, size_t size,
                                 const char* function, void** state) {
    PLII_TRY(plii_solver_check_change(body, &xpbd_solver, function));
    PLII_FAIL_IF(!plii_feature_is_enabled(body, &plii_xpbd_class), body->context, PLI_ERROR_WRONG_STATE, function,
                 "call pli_body_enable_xpbd first");
    return plii_feature_enable_with(body, klass, given, size, state);
}

PLII_DEFINE_DEFAULT(pli_xpbd_def, .substeps = 10, .sweeps = 1)
pli_status pli_body_enable_xpbd(pli_body* body, const pli_xpbd_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_xpbd_def, used, def, plii_xpbd_class);
    PLII_TRY(plii_solver_check_change(body, &xpbd_solver, __func__));
    const bool is_new = body->solver_class != &xpbd_solver;
    xpbd_state* state = NULL;
    PLII_TRY(plii_feature_enable_with(body, &plii_xpbd_class, &used, sizeof used, (void**)&state));
    if (is_new) { state->had_links = plii_feature_disable(body, &plii_links_class); }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_disable_xpbd(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const xpbd_state* state = plii_feature_state(body, &plii_xpbd_class);
    if (state == NULL) { return PLI_OK; }
    if (state->had_links) { PLII_TRY(plii_feature_enable(body, &plii_links_class, NULL)); }
    const plii_pipeline* pipeline = &body->pipeline;
    for (int i = pipeline->feature_count; i-- > 0;) {
        if (i >= pipeline->feature_count) { continue; } /* what only the last one needed went with it */
        const plii_feature_class* klass = pipeline->features[i].klass;
        if (klass->substepped != NULL && klass->substepped->is_of_xpbd) { plii_feature_disable(body, klass); }
    }
    plii_feature_disable(body, &plii_xpbd_class);
    return plii_body_changed(body, PLI_OK);
}
