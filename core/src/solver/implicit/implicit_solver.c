/* Implicit mass-spring solver: v += dv, x += h v with (M - h^2 J) dv = h (f + h J v), after Kang, "Efficient Methods
   for Cloth Animation and Collision Handling", and Baraff and Witkin, "Large Steps in Cloth Simulation". The system is
   solved with the anchors first; contacts are looked for where that leads, and where there are any the solution goes on
   with them. Pose matching and contacts of other kinds then correct positions as in the position-based solver, and the
   velocities of the nodes that they move follow. */

#include "body/pipeline.h"
#include "math/bounds.h"
#include "solver/implicit/implicit_system.h"

enum { IMPLICIT_MAX_LINEARISATIONS = 16 };
#define IMPLICIT_LARGEST_EXCESS 0.01   /* of energy in a step, see plii_implicit_excess */
#define IMPLICIT_LARGEST_GROWTH 1.5625 /* of step^2 / mass before the spectral radius is estimated anew */
#define IMPLICIT_CONTACT_REACH 0.5f    /* of the margin, see plii_solver_class: bodies that lie keep their contacts */

// ------------------------------------------------------------------------------------------------------- prediction

/* The change of velocity of a node without springs; that by forces is limited as in the position-based solver. */
static pli_vec3 implicit_free_change(const pli_body* body, int node, float dt) {
    const float limit = body->world->def.max_force_displacement / dt;
    pli_vec3 change = pli_vec3_make(0, 0, 0);
    if (body->forces != NULL) {
        change = pli_vec3_scale(pli_vec3_scale(body->forces[node], body->positions[node].w), dt);
        change = plii_vec3_clamp(change, limit);
    }
    return pli_vec3_add(change, pli_vec3_scale(body->world->def.gravity, dt));
}

enum { IMPLICIT_NODE_NS = 5 }; /* of a pass over the nodes */

/* Free flight is a new base for the velocities, which springs change, or by the right-hand side part of the unknown. */
static void implicit_external_range(int begin, int end, void* data) {
    const plii_implicit_system* system = data;
    const pli_body* body = system->body;
    for (int i = begin; i < end; ++i) {
        system->rhs[i] = (plii_dvec3){0};
        if (body->positions[i].w > 0.0f) {
            const pli_vec3 change = implicit_free_change(body, i, body->step.dt);
            if (system->def.start == PLI_IMPLICIT_START_AT_REST) {
                system->rhs[i] = plii_dvec3_scale(plii_dvec3_from(change), 1.0 / (double)body->positions[i].w);
            } else {
                plii_add_xyz(&body->velocities[i], change);
            }
        }
        if (body->forces != NULL) { body->forces[i] = pli_vec3_make(0, 0, 0); }
    }
}

static void implicit_iterate(plii_implicit_system* system, bool is_warm) {
    const int sweeps = system->def.sweeps;
    if (system->def.method == PLI_IMPLICIT_CONJUGATE_GRADIENT) {
        plii_implicit_conjugate_gradient(system, sweeps, is_warm);
        return;
    }
    system->report.iterations += is_warm ? sweeps + 1 : sweeps;
    bool is_weighted = system->def.method == PLI_IMPLICIT_CHEBYSHEV;
    /* Contacts come and go within an iteration, which weights that look back at earlier iterates do not bear. */
    for (int i = 0; i < system->constraints.count && is_weighted; ++i) {
        is_weighted = system->constraints.items[i].is_anchor;
    }
    if (is_weighted) {
        /* It grows with steps and as nodes get lighter; too large it does no harm, too small sweeps pass on little. */
        double mobility = 0.0; /* s^2 / kg */
        for (int i = 0; i < system->body->node_count; ++i) {
            mobility += (double)(system->body->positions[i].w * system->body->step.dt * system->body->step.dt);
        }
        if (system->spectral_radius == 0.0 || mobility > IMPLICIT_LARGEST_GROWTH * system->spectral_mobility) {
            system->spectral_radius = plii_implicit_spectral_radius(system);
            system->spectral_mobility = mobility;
        }
        system->report.spectral_radius = (float)system->spectral_radius;
        plii_implicit_chebyshev(system, sweeps, is_warm);
    } else {
        plii_implicit_jacobi(system, sweeps, is_warm);
    }
}

/* Nodes move by the solution. */
static void implicit_solution_range(int begin, int end, void* data) {
    const plii_implicit_system* system = data;
    const pli_body* body = system->body;
    for (int i = begin; i < end; ++i) {
        if (body->positions[i].w > 0.0f) {
            const plii_dvec3 velocity = plii_implicit_xyz(&body->velocities[i]);
            plii_set_xyz(&body->velocities[i], plii_dvec3_to_float(plii_dvec3_add(velocity, system->solution[i])));
        }
        plii_set_xyz(&body->previous[i], plii_xyz(body->positions[i]));
        plii_add_xyz(&body->positions[i], pli_vec3_scale(plii_xyz(body->velocities[i]), body->step.dt));
    }
}

static void implicit_predict(pli_body* body, float dt) {
    plii_implicit_system* system = plii_feature_state(body, &plii_implicit_class);
    plii_solver_set_step(body, dt);
    plii_run_stage(body, PLII_STAGE_FORCES);
    system->body = body;
    system->graph = plii_feature_state(body, &plii_link_graph_class);
    system->report = (pli_implicit_report){0};
    plii_body_run_nodes(system->body, implicit_external_range, system, plii_grain(IMPLICIT_NODE_NS));
    plii_implicit_gather_holds(body, system);
    system->leads = NULL;
    system->report.collapsed_links = plii_implicit_assemble(system);
    plii_implicit_constraints_gather(body, &system->constraints, false, system->blocks, NULL);
    implicit_iterate(system, false);
    if (system->def.start == PLI_IMPLICIT_START_IN_FREE_FLIGHT) {
        plii_implicit_keep_momentum(system, body->positions, false);
    }
    plii_body_run_nodes(system->body, implicit_solution_range, system, plii_grain(IMPLICIT_NODE_NS));
    plii_run_stage(body, PLII_STAGE_UPDATE);
    plii_solver_update_predicted_bounds(body);
    body->bounds =
        plii_bounds_grow(body->bounds, IMPLICIT_CONTACT_REACH * body->collision_margin + plii_step_fall(body));
}

// -------------------------------------------------------------------------------------------- anchors and contacts

/* Where the velocity of a node leads, rounded as in implicit_solution_range. */
static pli_vec3 implicit_reached(const pli_body* body, int node) {
    const pli_vec3 motion = pli_vec3_scale(plii_xyz(body->velocities[node]), body->step.dt);
    return pli_vec3_add(plii_xyz(body->previous[node]), motion);
}

/* Nodes follow a solution that has changed; what others moved them by stays. */
static void implicit_follow_solution(pli_body* body, const plii_implicit_system* system) {
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const pli_vec3 predicted = implicit_reached(body, i),
                       others = pli_vec3_sub(plii_xyz(body->positions[i]), predicted);
        const plii_dvec3 more = plii_dvec3_sub(system->solution[i], system->before[i]);
        const plii_dvec3 velocity = plii_dvec3_add(plii_implicit_xyz(&body->velocities[i]), more);
        plii_set_xyz(&body->velocities[i], plii_dvec3_to_float(velocity));
        plii_set_xyz(&body->positions[i], pli_vec3_add(implicit_reached(body, i), others));
    }
    memcpy(system->before, system->solution, plii_implicit_vector_size(body));
}

/* A step of conjugate gradients, or of sweeps that they may finish, is held to its energy. */
static bool implicit_is_improved(const plii_implicit_system* system) {
    const pli_implicit_def* def = &system->def;
    return def->start == PLI_IMPLICIT_START_IN_FREE_FLIGHT &&
           (def->method == PLI_IMPLICIT_CONJUGATE_GRADIENT || def->finishing_iterations > 0);
}

/* Whether nodes are not where they were noted: what moved them, as bodies that overlap, is not to become speed. */
static bool implicit_is_shifted(const pli_body* body, const plii_dvec3* noted) {
    for (int i = 0; i < body->node_count; ++i) {
        const plii_dvec3 x = plii_implicit_xyz(&body->positions[i]);
        if (x.x != noted[i].x || x.y != noted[i].y || x.z != noted[i].z) { return true; }
    }
    return false;
}

/* Springs anew where the solution has brought them. */
static void implicit_linearise_again(const pli_body* body, plii_implicit_system* system, bool releases_contacts) {
    plii_dvec3* leads = system->spare;
    for (int i = 0; i < body->node_count; ++i) {
        const plii_dvec3 free = plii_dvec3_sub(plii_implicit_xyz(&body->velocities[i]), system->solution[i]);
        leads[i] = plii_dvec3_add_scaled(free, plii_implicit_moved(body, i), -(double)body->step.inverse_dt);
        system->rhs[i] = (plii_dvec3){0};
    }
    for (PLII_EACH(plii_implicit_rigid, rigid, system->constraints.rigids, system->constraints.rigid_count)) {
        memcpy(rigid->before, rigid->change, sizeof rigid->before);
    }
    for (PLII_EACH(const plii_implicit_hold, hold, system->holds.items, system->holds.count)) {
        system->rhs[hold->node] = plii_dvec3_add(system->rhs[hold->node], hold->rhs);
    }
    system->leads = leads;
    system->report.collapsed_links = plii_implicit_assemble(system);
    plii_implicit_constraints_update(body, &system->constraints, releases_contacts);
}

/* Goes on from the solution of the prediction, now with contacts and with rigid bodies as their host has left them. */
static void implicit_solve_constraints(pli_body* body, plii_implicit_system* system) {
    plii_thread.pass.feature = NULL; /* stages have run */
    plii_implicit_constraints_gather(body, &system->constraints, true, system->blocks, system->solution);
    const bool is_free = system->def.start == PLI_IMPLICIT_START_IN_FREE_FLIGHT;
    const bool is_improved = implicit_is_improved(system) && !implicit_is_shifted(body, system->before);
    const bool is_exact = system->def.method == PLI_IMPLICIT_CONJUGATE_GRADIENT;
    const int iterations = is_exact ? system->def.sweeps : system->def.finishing_iterations;
    memcpy(system->before, system->solution, plii_implicit_vector_size(body));
    if (system->constraints.count > 0) { implicit_iterate(system, true); }
    if (system->constraints.count > 0 || (is_free && system->groups.has_free)) {
        if (is_free) { plii_implicit_keep_momentum(system, body->previous, true); }
        implicit_follow_solution(body, system);
    }
    double excess = (double)INFINITY, share = 1.0;
    for (int round = 0; is_improved && round < IMPLICIT_MAX_LINEARISATIONS; ++round) {
        const double excess_before = excess;
        excess = plii_implicit_excess(system);
        const bool is_better = excess < 0.9 * excess_before || share < 1.0 || (round == 1 && !is_exact);
        if (!(excess > IMPLICIT_LARGEST_EXCESS) || !is_better) { break; }
        implicit_linearise_again(body, system, round == 0 && !is_exact);
        plii_implicit_conjugate_gradient(system, iterations, true);
        plii_implicit_keep_momentum(system, body->previous, true);
        share = plii_implicit_search(system);
        implicit_follow_solution(body, system);
    }
    plii_implicit_constraints_push_rigids(body, &system->constraints);
    if (body->records_contacts) { plii_implicit_constraints_report(&system->constraints); }
}

/* Taking back an error moves nodes, but gives them no speed. */
static void implicit_end_recovery(pli_body* body, const plii_implicit_constraints* constraints) {
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        if (constraint->rows == 0 || constraint->is_pinned || constraints->rigids[constraint->rigid].is_dynamic) {
            continue;
        }
        double load = 0.0; /* the parts of all points of faces that move a node are that of one */
        for (int k = 0; k < constraint->node_count; ++k) {
            load += constraint->weights[k] * (constraint->is_point ? constraints->loads[constraint->nodes[k]] : 1.0);
        }
        for (int k = 0; k < constraint->node_count; ++k) {
            const int node = constraint->nodes[k];
            if (!(body->positions[node].w > 0.0f)) { continue; }
            pli_vec4* velocity = &body->velocities[node];
            const double share = constraint->influence * constraint->weights[k] / load;
            plii_set_xyz(velocity, pli_vec3_sub(plii_xyz(*velocity),
                                                plii_dvec3_to_float(plii_dvec3_scale(constraint->recovery, share))));
        }
    }
}

// ------------------------------------------------------------------------------------------------------ corrections

/* Nodes that pose matching, anchors, contacts and the like moved since the solution, by as much over the step. */
static void implicit_corrections_range(int begin, int end, void* data) {
    pli_body* body = data;
    for (int i = begin; i < end; ++i) {
        const pli_vec3 solved = implicit_reached(body, i);
        const plii_dvec3 moved = plii_dvec3_sub(plii_implicit_xyz(&body->positions[i]), plii_dvec3_from(solved));
        plii_add_xyz(&body->velocities[i], plii_dvec3_to_float(plii_dvec3_scale(moved, (double)body->step.inverse_dt)));
    }
}

static void implicit_begin(pli_body* body) {
    plii_implicit_system* system = plii_feature_state(body, &plii_implicit_class);
    if (system->def.method == PLI_IMPLICIT_CONJUGATE_GRADIENT) { /* sweeps pass on too little of what poses pull by */
        plii_body_run_nodes(system->body, implicit_corrections_range, body, plii_grain(IMPLICIT_NODE_NS));
    }
    for (int i = 0; i < body->node_count && implicit_is_improved(system); ++i) {
        system->before[i] = plii_implicit_xyz(&body->positions[i]);
    }
    plii_run_stage(body, PLII_STAGE_PREPARE);
    implicit_solve_constraints(body, system);
}

/* Twice: little beside the solution, and what lies in piles comes to rest by it. */
static void implicit_couple(pli_body* body) {
    plii_implicit_system* system = plii_feature_state(body, &plii_implicit_class);
    plii_implicit_constraints* constraints = &system->constraints;
    plii_run_stage(body, PLII_STAGE_COUPLE);
    plii_run_stage(body, PLII_STAGE_COUPLE);
    for (PLII_EACH(plii_implicit_constraint, constraint, constraints->items, constraints->node_bound_count)) {
        const pli_vec3 x = plii_xyz(body->positions[constraint->nodes[0]]);
        const bool has_moved = plii_vec3_compare(x, implicit_reached(body, constraint->nodes[0])) != 0;
        if (has_moved && !constraint->is_pinned) { plii_implicit_constraint_reproject(body, constraints, constraint); }
    }
}

static void implicit_end(pli_body* body) {
    const plii_implicit_system* system = plii_feature_state(body, &plii_implicit_class);
    plii_body_run_nodes(system->body, implicit_corrections_range, body, plii_grain(IMPLICIT_NODE_NS));
    implicit_end_recovery(body, &system->constraints);
    for (int i = 0; i < body->node_count && body->solver.velocity_damping > 0.0f; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        plii_set_xyz(&body->velocities[i],
                     pli_vec3_scale(plii_xyz(body->velocities[i]), 1.0f - body->solver.velocity_damping));
    }
    plii_run_stage(body, PLII_STAGE_FINISH);
}

static void implicit_solve(pli_body* first) {
    const plii_solver_pace pace = plii_solver_iterations(first);
    plii_solve_island(first, pace, implicit_begin, plii_solver_sweep, implicit_couple, implicit_end);
}

static const plii_solver_class implicit_solver = {.name = "implicit",
                                                  .predict = implicit_predict,
                                                  .pace = plii_solver_iterations,
                                                  .solve = implicit_solve,
                                                  .solves_constraints = true,
                                                  .contact_reach = IMPLICIT_CONTACT_REACH};

// ------------------------------------------------------------------------------------------------------ the feature

/* Nothing of a step is needed by the next one, but the spectral radius, which is another now. */
static void implicit_build(pli_body* body, void* data) {
    plii_implicit_system* system = data;
    system->spectral_radius = 0.0;
    system->constraints.count = 0;
    system->holds.count = system->groups.count = 0;
}

static const plii_field implicit_fields[] = {
    PLII_FIELD(pli_implicit_def, stiffness, 0, PLI_MAX_COEFFICIENT),
    PLII_FIELD(pli_implicit_def, damping, 0, PLI_MAX_COEFFICIENT),
    PLII_FIELD(pli_implicit_def, sweeps, 1, INT_MAX),
    PLII_FIELD(pli_implicit_def, finishing_iterations, 0, INT_MAX),
    PLII_FIELD(pli_implicit_def, method, PLI_IMPLICIT_JACOBI, PLI_IMPLICIT_CONJUGATE_GRADIENT),
    PLII_FIELD(pli_implicit_def, start, PLI_IMPLICIT_START_IN_FREE_FLIGHT, PLI_IMPLICIT_START_AT_REST),
    PLII_FIELD(pli_implicit_def, tolerance, PLII_ABOVE_0, 1.0f - FLT_EPSILON / 2.0f),
};
const plii_feature_class plii_implicit_class = {
    .name = "implicit solver",
    .state_size = sizeof(plii_implicit_system),
    .settings = PLII_LIMITS(plii_implicit_system, def, implicit_fields),
    .state_parts =
        PLII_STATE_PARTS(PLII_STATE_OF(plii_implicit_system, def, PLII_SAVED, "2f2ie2e1fBu"),
                         PLII_STATE_OF(plii_implicit_system, had_links, PLII_FILED, "B"),
                         PLII_STATE_SPAN(plii_implicit_system, body, direction, PLII_LEFT, NULL),
                         PLII_STATE_SPAN(plii_implicit_system, spectral_radius, report, PLII_SAVED, "2di2fi")),
    .needs = PLII_NEEDS(&plii_link_graph_class),
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(plii_implicit_system, halves), PLII_PER_LINK, .times = 2, .snapshot = PLII_LEFT},
        PLII_LEFT_PER_NODE(plii_implicit_system, blocks), PLII_LEFT_PER_NODE(plii_implicit_system, groups.of_nodes),
        PLII_LEFT_PER_NODE(plii_implicit_system, rhs), PLII_LEFT_PER_NODE(plii_implicit_system, solution),
        PLII_LEFT_PER_NODE(plii_implicit_system, spare), PLII_LEFT_PER_NODE(plii_implicit_system, residual),
        PLII_LEFT_PER_NODE(plii_implicit_system, before), PLII_LEFT_PER_NODE(plii_implicit_system, direction),
        PLII_LEFT_PER_NODE(plii_implicit_system, constraints.loads),
        PLII_LEFT_LIST(plii_implicit_system, constraints.items, constraints.capacity),
        PLII_LEFT_LIST(plii_implicit_system, constraints.listed, constraints.listed_capacity),
        PLII_LEFT_LIST(plii_implicit_system, constraints.rigids, constraints.rigid_capacity),
        PLII_LEFT_LIST(plii_implicit_system, holds.items, holds.capacity),
        PLII_LEFT_LIST(plii_implicit_system, groups.items, groups.capacity)),
    .solver = &implicit_solver,
    .build = implicit_build,
};

PLII_DEFINE_DEFAULT(pli_implicit_def, .stiffness = 1000.0f, .sweeps = 5, .tolerance = 1e-4f)

/* A tolerance of 1 is not below the first residual. */
pli_status pli_body_enable_implicit(pli_body* body, const pli_implicit_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_implicit_def, used, def, plii_implicit_class);
    PLII_TRY(plii_solver_check_change(body, &implicit_solver, __func__));
    const bool is_new = body->solver_class != &implicit_solver;
    plii_implicit_system* system = NULL;
    PLII_TRY(plii_feature_enable_with(body, &plii_implicit_class, &used, sizeof used, (void**)&system));
    if (is_new) { system->had_links = plii_feature_disable(body, &plii_links_class); }
    system->spectral_radius = 0.0;
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_disable_implicit(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const plii_implicit_system* system = plii_feature_state(body, &plii_implicit_class);
    if (system == NULL) { return PLI_OK; }
    if (system->had_links) { PLII_TRY(plii_feature_enable(body, &plii_links_class, NULL)); }
    plii_feature_disable(body, &plii_implicit_class);
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_STATE_GET(pli_implicit_report, pli_body_get_implicit_report, plii_implicit_system, plii_implicit_class,
                      state->report, (pli_implicit_report){0})
