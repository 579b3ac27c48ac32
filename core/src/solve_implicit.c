/* Implicit mass-spring solver: v += dv, x += h v with (M - h^2 J) dv = h (f + h J v), after Kang, "Efficient Methods
   for Cloth Animation and Collision Handling", and Baraff and Witkin, "Large Steps in Cloth Simulation". Springs are
   solved before contacts are looked for; anchors, contacts and pose matching then correct positions as in the
   position-based solver, and the velocities of the nodes that they move follow. */

#include "implicit_system.h"
#include "world_impl.h"

#include <string.h>

enum { IMPLICIT_MAX_VECTORS = 4 };

typedef struct implicit_state {
    pli_implicit_def def;
    bool had_links; /* on positions, before this solver came */
    plii_implicit_half* halves;
    plii_implicit_block* blocks;
    plii_dvec3* vectors[IMPLICIT_MAX_VECTORS]; /* the last only for conjugate gradients */
    double spectral_radius;                    /* 0: to be estimated */
    pli_implicit_report report;
} implicit_state;

static const plii_feature_class implicit_class;

static size_t implicit_halves_size(int link_count) {
    return 2 * (size_t)link_count * sizeof(plii_implicit_half);
}
static size_t implicit_blocks_size(int node_count) {
    return (size_t)node_count * sizeof(plii_implicit_block);
}
static size_t implicit_vector_size(int node_count) {
    return (size_t)node_count * sizeof(plii_dvec3);
}
static int implicit_vector_count(const implicit_state* state) {
    return state->def.method == PLI_IMPLICIT_CONJUGATE_GRADIENT ? 4 : 3;
}

// ------------------------------------------------------------------------------------------------------- prediction

/* The change of velocity of a node without springs; that by forces is limited as in the position-based solver. */
static pli_vec3 implicit_free_change(const pli_body* body, int node, float dt) {
    const float limit = body->world->def.max_force_displacement / dt;
    pli_vec3 change = pli_vec3_make(0, 0, 0);
    if (body->forces != NULL) {
        change = pli_vec3_scale(pli_vec3_scale(body->forces[node], body->positions[node].w), dt);
        change = pli_vec3_make(plii_clamp(change.x, -limit, limit), plii_clamp(change.y, -limit, limit),
                               plii_clamp(change.z, -limit, limit));
    }
    return pli_vec3_add(change, pli_vec3_scale(body->world->def.gravity, dt));
}

/* Free flight is a new base for the velocities, the unknown is what springs change about it; else it is part of the
   unknown, by the right-hand side. */
static void implicit_add_external(pli_body* body, const implicit_state* state, float dt, plii_dvec3* rhs) {
    for (int i = 0; i < body->node_count; ++i) {
        rhs[i] = (plii_dvec3){0};
        if (body->positions[i].w > 0.0f) {
            const pli_vec3 change = implicit_free_change(body, i, dt);
            if (state->def.start == PLI_IMPLICIT_LITERAL) {
                rhs[i] = plii_dvec3_scale(plii_dvec3_from(change), 1.0 / (double)body->positions[i].w);
            } else {
                plii_set_xyz(&body->velocities[i], pli_vec3_add(plii_xyz(body->velocities[i]), change));
            }
        }
        if (body->forces != NULL) { body->forces[i] = pli_vec3_make(0, 0, 0); }
    }
}

static void implicit_iterate(const pli_body* body, implicit_state* state, plii_implicit_system* system) {
    state->report.iterations = state->def.sweeps;
    if (state->def.method == PLI_IMPLICIT_CONJUGATE_GRADIENT) {
        double residual = 0.0;
        state->report.iterations =
            plii_implicit_conjugate_gradient(body, system, state->def.sweeps, (double)state->def.tolerance, &residual);
        state->report.residual = (float)residual;
    } else if (state->def.method == PLI_IMPLICIT_CHEBYSHEV) {
        if (state->spectral_radius == 0.0) { state->spectral_radius = plii_implicit_spectral_radius(system); }
        state->report.spectral_radius = (float)state->spectral_radius;
        plii_implicit_chebyshev(system, state->def.sweeps, state->spectral_radius);
    } else {
        plii_implicit_jacobi(system, state->def.sweeps);
    }
}

/* Springs do not move the centre of mass of nodes that hang together. Unfinished sweeps do, which is taken back here;
   a pinned node counts as infinitely heavy. */
static void implicit_keep_momentum(const pli_body* body, const plii_link_graph* graph, plii_implicit_system* system) {
    plii_dvec3 *momenta = system->rhs, *masses = system->spare; /* by component; masses in x */
    for (int i = 0; i < body->node_count; ++i) {
        momenta[i] = (plii_dvec3){0};
        masses[i] = (plii_dvec3){0};
    }
    for (int i = 0; i < body->node_count; ++i) {
        const int component = graph->components[i];
        const double mass = 1.0 / (double)body->positions[i].w; /* infinite when pinned */
        masses[component].x += mass;
        if (!isfinite(mass)) { continue; }
        momenta[component] = plii_dvec3_add_scaled(momenta[component], system->solution[i], mass);
    }
    for (int i = 0; i < body->node_count; ++i) {
        const int component = graph->components[i];
        system->solution[i] =
            plii_dvec3_add_scaled(system->solution[i], momenta[component], -1.0 / masses[component].x);
    }
}

static void implicit_add_solution(pli_body* body, const plii_dvec3* solution, float dt) {
    for (int i = 0; i < body->node_count; ++i) {
        if (body->positions[i].w > 0.0f) {
            const plii_dvec3 velocity = plii_dvec3_from(plii_xyz(body->velocities[i]));
            plii_set_xyz(&body->velocities[i], plii_dvec3_to_float(plii_dvec3_add(velocity, solution[i])));
        }
        const pli_vec3 position = plii_xyz(body->positions[i]);
        plii_set_xyz(&body->previous[i], position);
        plii_set_xyz(&body->positions[i], pli_vec3_add(position, pli_vec3_scale(plii_xyz(body->velocities[i]), dt)));
    }
}

static void implicit_predict(pli_body* body, float dt) {
    implicit_state* state = plii_feature_state(body, &implicit_class);
    const plii_link_graph* graph = plii_feature_state(body, &plii_link_graph_class);
    plii_step* step = &body->step;
    step->dt = dt * body->solver.time_scale;
    step->inverse_dt = 1.0f / step->dt;
    plii_run_stage(body, &body->pipeline, PLII_STAGE_FORCES, step);

    plii_implicit_system system = {
        .node_count = body->node_count,
        .begin = graph->begin,
        .halves = state->halves,
        .blocks = state->blocks,
        .rhs = state->vectors[0],
        .solution = state->vectors[1],
        .spare = state->vectors[2],
        .direction = state->vectors[3],
    };
    state->report = (pli_implicit_report){0};
    implicit_add_external(body, state, step->dt, system.rhs);
    state->report.collapsed_links = plii_implicit_assemble(body, graph, &state->def, step->dt, &system);
    implicit_iterate(body, state, &system);
    if (state->def.start == PLI_IMPLICIT_FREE_FLIGHT) { implicit_keep_momentum(body, graph, &system); }
    implicit_add_solution(body, system.solution, step->dt);

    plii_run_stage(body, &body->pipeline, PLII_STAGE_UPDATE, step);
    if (plii_solver_freeze_if_not_finite(body)) { return; }
    plii_body_update_bounds(body);
}

// ------------------------------------------------------------------------------------------------------ corrections

/* Nodes that pose matching, anchors, contacts and the like moved since implicit_add_solution, by as much over the
   step. */
static void implicit_follow_corrections(pli_body* body, const plii_step* step) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 solved =
            pli_vec3_add(plii_xyz(body->previous[i]), pli_vec3_scale(plii_xyz(body->velocities[i]), step->dt));
        const plii_dvec3 moved = plii_dvec3_sub(plii_dvec3_from(plii_xyz(body->positions[i])), plii_dvec3_from(solved));
        plii_set_xyz(&body->velocities[i],
                     pli_vec3_add(plii_xyz(body->velocities[i]),
                                  plii_dvec3_to_float(plii_dvec3_scale(moved, (double)step->inverse_dt))));
    }
}

static void implicit_solve(pli_body* body) {
    const plii_pipeline* pipeline = &body->pipeline;
    const plii_step* step = &body->step;
    plii_run_stage(body, pipeline, PLII_STAGE_PREPARE, step);
    for (int i = 0; i < body->solver.position_iterations; ++i) {
        plii_run_stage(body, pipeline, PLII_STAGE_POSITION, step);
    }
    implicit_follow_corrections(body, step);
    if (body->solver.velocity_damping > 0.0f) {
        for (int i = 0; i < body->node_count; ++i) {
            plii_set_xyz(&body->velocities[i],
                         pli_vec3_scale(plii_xyz(body->velocities[i]), 1.0f - body->solver.velocity_damping));
        }
    }
    plii_run_stage(body, pipeline, PLII_STAGE_FINISH, step);
}

static const plii_solver_class implicit_solver = {"implicit", implicit_predict, implicit_solve, false, 0.0f};

// ------------------------------------------------------------------------------------------------------ the feature

static void implicit_release(pli_body* body, implicit_state* state, int node_count, int link_count) {
    plii_release(body->context, state->halves, implicit_halves_size(link_count));
    plii_release(body->context, state->blocks, implicit_blocks_size(node_count));
    for (int i = 0; i < IMPLICIT_MAX_VECTORS; ++i) {
        plii_release(body->context, state->vectors[i], implicit_vector_size(node_count));
        state->vectors[i] = NULL;
    }
    state->halves = NULL;
    state->blocks = NULL;
}

static pli_status implicit_enable(pli_body* body, void* data) {
    implicit_state* state = data;
    state->halves = plii_allocate(body->context, implicit_halves_size(body->link_count));
    state->blocks = plii_allocate(body->context, implicit_blocks_size(body->node_count));
    bool is_complete = (state->halves != NULL || body->link_count == 0) && state->blocks != NULL;
    for (int i = 0; i < 3; ++i) {
        state->vectors[i] = plii_allocate(body->context, implicit_vector_size(body->node_count));
        is_complete = is_complete && state->vectors[i] != NULL;
    }
    if (!is_complete) {
        implicit_release(body, state, body->node_count, body->link_count);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    body->solver_class = &implicit_solver;
    return PLI_OK;
}

static void implicit_disable(pli_body* body, void* data) {
    implicit_release(body, data, body->node_count, body->link_count);
    body->solver_class = &plii_position_solver;
}

static size_t implicit_bytes(const pli_body* body, const void* data) {
    const implicit_state* state = data;
    return implicit_halves_size(body->link_count) + implicit_blocks_size(body->node_count) +
           (size_t)implicit_vector_count(state) * implicit_vector_size(body->node_count);
}

static int implicit_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                    size_t* sizes) {
    const implicit_state* state = data;
    (void)body;
    sizes[0] = implicit_halves_size(change->link_count);
    sizes[1] = implicit_blocks_size(change->node_count);
    for (int i = 0; i < IMPLICIT_MAX_VECTORS; ++i) {
        sizes[2 + i] = i < implicit_vector_count(state) ? implicit_vector_size(change->node_count) : 0;
    }
    return 2 + IMPLICIT_MAX_VECTORS;
}

/* Nothing of a step is needed by the next one, but the spectral radius, which is another now. */
static void implicit_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    implicit_state* state = data;
    implicit_release(body, state, change->old_node_count, change->old_link_count);
    state->halves = blocks[0];
    state->blocks = blocks[1];
    for (int i = 0; i < IMPLICIT_MAX_VECTORS; ++i) {
        state->vectors[i] = blocks[2 + i];
    }
    state->spectral_radius = 0.0;
}

static const plii_feature_class* const implicit_needs[] = {&plii_link_graph_class, NULL};

static const plii_feature_class implicit_class = {
    .name = "implicit solver",
    .state_size = sizeof(implicit_state),
    .needs = implicit_needs,
    .enable = implicit_enable,
    .disable = implicit_disable,
    .bytes = implicit_bytes,
    .topology_blocks = implicit_topology_blocks,
    .topology_commit = implicit_topology_commit,
};

// --------------------------------------------------------------------------------------------------------- settings

pli_implicit_def pli_implicit_def_default(void) {
    return (pli_implicit_def){.stiffness = 1000.0f, .sweeps = 5, .tolerance = 1e-4f, .cookie = PLII_DEF_COOKIE};
}

static pli_status implicit_check(pli_context* context, const pli_implicit_def* def, const char* function) {
    if (def == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "start from pli_implicit_def_default()");
    }
    if (!plii_is_finite(def->stiffness) || !plii_is_finite(def->damping)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "stiffness is %g and damping is %g",
                         (double)def->stiffness, (double)def->damping);
    }
    if (def->stiffness < 0.0f || def->damping < 0.0f) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function,
                         "stiffness is %g and damping is %g, at least 0 is allowed", (double)def->stiffness,
                         (double)def->damping);
    }
    if (def->sweeps < 1) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function,
                         "%d sweeps are not stable, take 1, 3, 5 or another odd number", def->sweeps);
    }
    const int method = (int)def->method, start = (int)def->start;
    if (method < PLI_IMPLICIT_JACOBI || method > PLI_IMPLICIT_CONJUGATE_GRADIENT) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "there is no method %d, the last one is %d",
                         method, PLI_IMPLICIT_CONJUGATE_GRADIENT);
    }
    if (start != PLI_IMPLICIT_FREE_FLIGHT && start != PLI_IMPLICIT_LITERAL) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "there is no start %d, the last one is %d", start,
                         PLI_IMPLICIT_LITERAL);
    }
    if (!(def->tolerance > 0.0f && def->tolerance < 1.0f)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "tolerance %g is not in (0, 1)",
                         (double)def->tolerance);
    }
    return PLI_OK;
}

pli_status pli_body_enable_implicit(pli_body* body, const pli_implicit_def* def) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(implicit_check(body->context, def, __func__));
    PLII_TRY(plii_solver_check_change(body, &implicit_solver, __func__));
    const bool is_new = body->solver_class != &implicit_solver;
    void* data = NULL;
    PLII_TRY(plii_feature_enable(body, &implicit_class, &data));
    implicit_state* state = data;
    if (def->method == PLI_IMPLICIT_CONJUGATE_GRADIENT && state->vectors[3] == NULL) {
        state->vectors[3] = plii_allocate(body->context, implicit_vector_size(body->node_count));
        if (state->vectors[3] == NULL) {
            if (is_new) { plii_feature_disable(body, &implicit_class); }
            return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for conjugate gradients");
        }
    }
    if (def->method != PLI_IMPLICIT_CONJUGATE_GRADIENT) {
        plii_release(body->context, state->vectors[3], implicit_vector_size(body->node_count));
        state->vectors[3] = NULL;
    }
    if (is_new) {
        state->had_links = plii_feature_is_enabled(body, &plii_links_class);
        plii_feature_disable(body, &plii_links_class);
    }
    state->def = *def;
    state->spectral_radius = 0.0;
    return PLI_OK;
}

pli_status pli_body_disable_implicit(pli_body* body) {
    PLII_TRY(plii_check_body(body, __func__));
    const implicit_state* state = plii_feature_state(body, &implicit_class);
    if (state == NULL) { return PLI_OK; }
    PLII_TRY(plii_solver_check_change(body, &implicit_solver, __func__));
    if (state->had_links) { PLII_TRY(plii_feature_enable(body, &plii_links_class, NULL)); }
    plii_feature_disable(body, &implicit_class);
    return PLI_OK;
}

pli_implicit_report pli_body_get_implicit_report(const pli_body* body) {
    const implicit_state* state =
        plii_check_body(body, __func__) == PLI_OK ? plii_feature_state(body, &implicit_class) : NULL;
    return state != NULL ? state->report : (pli_implicit_report){0};
}
