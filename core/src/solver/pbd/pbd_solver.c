/* The position-based step: explicit prediction, then iterations of the enabled features, then velocities from
   positions. Matches btSoftBody::predictMotion and solveConstraints. */

#include "body/pipeline.h"
#include "math/bounds.h"
#include "solver/pbd/pbd_nodes.h"

void plii_solver_set_start(pli_body* body) {
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i], plii_xyz(body->previous[i]));
        body->velocities[i] = (pli_vec4){0};
    }
    plii_body_update_bounds(body);
}

static void solver_put_back(pli_body* body) {
    body->lost_node = plii_body_find_lost_node(body);
    plii_solver_set_start(body);
    body->is_frozen = body->was_frozen = true;
    plii_world_note_frozen(body->world);
}

bool plii_solver_update_bounds(pli_body* body) {
    if (plii_body_update_bounds(body)) { return true; }
    solver_put_back(body);
    return false;
}

bool plii_solver_check_velocities(pli_body* body) {
    /* The position-based solver takes velocities from the motions of a step, which do not lead out of the world. */
    const float drift = body->solver.drift_iterations > 0 ? fabsf(body->solver.drift_correction) : 0.0f;
    const bool are_bounded = body->solver_class == &plii_position_solver &&
                             plii_stage_is_empty(body, PLII_STAGE_FINISH) &&
                             2.0f * PLI_MAX_COORDINATE * body->step.inverse_dt * (1.0f + drift) <= PLI_MAX_SPEED;
    if (are_bounded || plii_body_is_slow(body)) { return true; }
    solver_put_back(body);
    return false;
}

enum { SOLVER_NODES_GRAIN = 4096 };

static plii_pbd_nodes solver_nodes_of(const pli_body* body) {
    return (plii_pbd_nodes){.positions = body->positions,
                            .previous = body->previous,
                            .velocities = body->velocities,
                            .forces = body->forces};
}

void plii_solver_update_predicted_bounds(pli_body* body) {
    const pli_bounds before = body->bounds;
    const bool is_early = body->has_early_bounds;
    body->has_early_bounds = false;
    if (!plii_solver_update_bounds(body)) { return; }
    if (is_early) { body->bounds = before; }
    const float margin = body->collision_margin;
    body->leaps =
        plii_follows_rigids(body) && !(plii_vec3_is_within(pli_vec3_sub(body->bounds.min, before.min), margin) &&
                                       plii_vec3_is_within(pli_vec3_sub(body->bounds.max, before.max), margin));
    /* A step that goes beyond that of the world leads away from what a host has only moved by one of the world. */
    if (body->sweeping_features == 0 && !body->leaps && !(body->interval.lead > 0.0f)) { return; }
    const float ahead = body->soft_slack > 0.0f ? 3.0f : 0.0f; /* they look two steps farther, by relative motions */
    const pli_bounds after = {pli_vec3_lerp(before.min, body->bounds.min, ahead),
                              pli_vec3_lerp(before.max, body->bounds.max, ahead)};
    body->bounds = plii_bounds_grow(plii_bounds_join(plii_bounds_join(body->bounds, before), after), body->soft_slack);
}

void plii_solver_set_step(pli_body* body, float dt) {
    body->step.dt = dt * body->solver.time_scale;
    body->step.inverse_dt = 1.0f / body->step.dt;
    /* Rigid bodies keep their own time. */
    const bool is_as_in_bullet = !plii_follows_rigids(body) && !body->solver_class->solves_constraints;
    body->host_dt = is_as_in_bullet ? body->step.dt : dt;
    body->rigid_pace = is_as_in_bullet ? 1.0f : 1.0f / body->solver.time_scale;
}

static void solver_predict(pli_body* body, float dt) {
    plii_solver_set_step(body, dt);
    const plii_pbd_nodes_kernel* pass = PLII_KERNEL(body->context, &plii_pbd_nodes);
    plii_pbd_nodes nodes = solver_nodes_of(body);
    nodes.dt = body->step.dt;
    nodes.gravity = pli_vec3_scale(body->world->def.gravity, body->step.dt);
    if (body->forces == NULL && plii_stage_is_empty(body, PLII_STAGE_FORCES)) {
        plii_body_run_nodes(body, pass->fly, &nodes, SOLVER_NODES_GRAIN);
    } else {
        nodes.limit = body->world->def.max_force_displacement / body->step.dt;
        plii_body_run_nodes(body, pass->add_gravity, &nodes, SOLVER_NODES_GRAIN);
        plii_run_stage(body, PLII_STAGE_FORCES);
        plii_body_run_nodes(body, pass->add_forces, &nodes, SOLVER_NODES_GRAIN);
    }
    plii_run_stage(body, PLII_STAGE_UPDATE);
    plii_solver_update_predicted_bounds(body);
}

plii_solver_pace plii_solver_iterations(const pli_body* body) {
    return (plii_solver_pace){1, body->solver.position_iterations};
}

static void solver_begin(pli_body* body) {
    const pli_solver_settings* settings = &body->solver;
    plii_run_stage(body, PLII_STAGE_PREPARE);
    for (int i = 0; i < settings->velocity_iterations; ++i) {
        plii_run_stage(body, PLII_STAGE_VELOCITY);
    }
    for (int i = 0; i < body->node_count && settings->velocity_iterations > 0; ++i) {
        const pli_vec3 motion = pli_vec3_scale(plii_xyz(body->velocities[i]), body->step.dt);
        plii_set_xyz(&body->positions[i], pli_vec3_add(plii_xyz(body->previous[i]), motion));
    }
}

void plii_solver_sweep(pli_body* body) {
    plii_run_stage(body, PLII_STAGE_POSITION);
}
void plii_solver_couple(pli_body* body) {
    plii_run_stage(body, PLII_STAGE_COUPLE);
}

static void solver_end(pli_body* body) {
    const plii_step* step = &body->step;
    const pli_solver_settings* settings = &body->solver;
    if (body->followed_rigids != NULL) { body->finish_rigids(body, body->host_dt); }
    if (settings->position_iterations > 0) {
        plii_pbd_nodes nodes = solver_nodes_of(body);
        nodes.rate = step->inverse_dt * (1.0f - settings->velocity_damping);
        plii_body_run_nodes(body, PLII_KERNEL(body->context, &plii_pbd_nodes)->set_velocities, &nodes,
                            SOLVER_NODES_GRAIN);
    }
    if (settings->drift_iterations > 0) {
        /* The drift solve measures from the solved positions, which must be good to fall back to. */
        if (!plii_solver_update_bounds(body)) { return; }
        for (int i = 0; i < body->node_count; ++i) {
            plii_set_xyz(&body->previous[i], plii_xyz(body->positions[i]));
        }
        for (int i = 0; i < settings->drift_iterations; ++i) {
            plii_run_stage(body, PLII_STAGE_DRIFT);
        }
        const float rate = settings->drift_correction * step->inverse_dt;
        for (int i = 0; i < body->node_count; ++i) {
            const pli_vec3 moved = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
            plii_add_xyz(&body->velocities[i], pli_vec3_scale(moved, rate));
        }
    }
    plii_run_stage(body, PLII_STAGE_FINISH);
}

static void solver_solve(pli_body* first) {
    const plii_solver_pace pace = plii_solver_iterations(first);
    plii_solve_island(first, pace, solver_begin, plii_solver_sweep, plii_solver_couple, solver_end);
}

const plii_solver_class plii_position_solver = {
    .name = "position-based",
    .predict = solver_predict,
    .pace = plii_solver_iterations,
    .solve = solver_solve,
    .last_couples = 4,
};

pli_status plii_solver_check_change(const pli_body* body, const plii_solver_class* solver_class, const char* function) {
    PLII_FAIL_IF(body->solver_class != &plii_position_solver && body->solver_class != solver_class, body->context,
                 PLI_ERROR_WRONG_STATE, function, "disable the %s solver of the body first", body->solver_class->name);
    return PLI_OK;
}
