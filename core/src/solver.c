/* The position-based step: explicit prediction, then iterations of the enabled features, then velocities from
   positions. Matches btSoftBody::predictMotion and solveConstraints. */

#include "world_impl.h"

#include <string.h>

// ------------------------------------------------------------------------------------------------ finiteness

static int solver_find_non_finite_node(const pli_body* body) {
    uint32_t all_exponents_full = 0;
    for (int i = 0; i < body->node_count; ++i) {
        uint32_t bits[3];
        memcpy(bits, &body->positions[i], sizeof bits);
        for (int k = 0; k < 3; ++k) {
            all_exponents_full |= (bits[k] & 0x7f800000u) == 0x7f800000u;
        }
    }
    if (all_exponents_full == 0) { return PLI_NULL_INDEX; }
    for (int i = 0; i < body->node_count; ++i) {
        if (!plii_vec3_is_finite(plii_xyz(body->positions[i]))) { return i; }
    }
    return PLI_NULL_INDEX;
}

bool plii_solver_freeze_if_not_finite(pli_body* body) {
    const int node = solver_find_non_finite_node(body);
    if (node == PLI_NULL_INDEX) { return false; }
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i], plii_xyz(body->previous[i]));
        body->velocities[i] = (pli_vec4){0};
    }
    body->is_frozen = true;
    plii_body_update_bounds(body);
    plii_world_add_event(body->world, (pli_event){PLI_EVENT_BODY_FROZEN, body, node});
    return true;
}

// ------------------------------------------------------------------------------------------------ prediction

static void solver_add_gravity(pli_body* body, float dt) {
    const pli_vec3 change = pli_vec3_scale(body->world->def.gravity, dt);
    for (int i = 0; i < body->node_count; ++i) {
        if (body->positions[i].w > 0.0f) {
            plii_set_xyz(&body->velocities[i], pli_vec3_add(plii_xyz(body->velocities[i]), change));
        }
    }
}

static void solver_add_forces(pli_body* body, float dt) {
    const float limit = body->world->def.max_force_displacement / dt;
    for (int i = 0; i < body->node_count; ++i) {
        pli_vec3 change = pli_vec3_scale(pli_vec3_scale(body->forces[i], body->positions[i].w), dt);
        change.x = plii_clamp(change.x, -limit, limit);
        change.y = plii_clamp(change.y, -limit, limit);
        change.z = plii_clamp(change.z, -limit, limit);
        plii_set_xyz(&body->velocities[i], pli_vec3_add(plii_xyz(body->velocities[i]), change));
        body->forces[i] = pli_vec3_make(0, 0, 0);
    }
}

static void solver_move(pli_body* body, float dt) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 position = plii_xyz(body->positions[i]);
        plii_set_xyz(&body->previous[i], position);
        plii_set_xyz(&body->positions[i], pli_vec3_add(position, pli_vec3_scale(plii_xyz(body->velocities[i]), dt)));
    }
}

static void solver_predict(pli_body* body, float dt) {
    plii_step* step = &body->step;
    step->dt = dt * body->solver.time_scale;
    step->inverse_dt = 1.0f / step->dt;
    solver_add_gravity(body, step->dt);
    plii_run_stage(body, &body->pipeline, PLII_STAGE_FORCES, step);
    if (body->forces != NULL) { solver_add_forces(body, step->dt); }
    solver_move(body, step->dt);
    plii_run_stage(body, &body->pipeline, PLII_STAGE_UPDATE, step);
    if (plii_solver_freeze_if_not_finite(body)) { return; }
    const pli_bounds before = body->bounds;
    plii_body_update_bounds(body);
    if (body->sweeping_features > 0) {
        body->bounds.min = plii_vec3_min(body->bounds.min, before.min);
        body->bounds.max = plii_vec3_max(body->bounds.max, before.max);
    }
}

// ------------------------------------------------------------------------------------------------- iterations

static void solver_positions_from_velocities(pli_body* body, float dt) {
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i],
                     pli_vec3_add(plii_xyz(body->previous[i]), pli_vec3_scale(plii_xyz(body->velocities[i]), dt)));
    }
}

static void solver_velocities_from_positions(pli_body* body, float scale) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 moved = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
        plii_set_xyz(&body->velocities[i], pli_vec3_scale(moved, scale));
    }
}

static void solver_add_drift_to_velocities(pli_body* body, float scale) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 moved = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
        plii_set_xyz(&body->velocities[i], pli_vec3_add(plii_xyz(body->velocities[i]), pli_vec3_scale(moved, scale)));
    }
}

static void solver_solve(pli_body* body) {
    const plii_pipeline* pipeline = &body->pipeline;
    const plii_step* step = &body->step;
    const pli_solver_settings* settings = &body->solver;

    plii_run_stage(body, pipeline, PLII_STAGE_PREPARE, step);
    if (settings->velocity_iterations > 0) {
        for (int i = 0; i < settings->velocity_iterations; ++i) {
            plii_run_stage(body, pipeline, PLII_STAGE_VELOCITY, step);
        }
        solver_positions_from_velocities(body, step->dt);
    }
    if (settings->position_iterations > 0) {
        for (int i = 0; i < settings->position_iterations; ++i) {
            plii_run_stage(body, pipeline, PLII_STAGE_POSITION, step);
        }
        solver_velocities_from_positions(body, step->inverse_dt * (1.0f - settings->velocity_damping));
    }
    if (settings->drift_iterations > 0) {
        /* The drift solve measures from the solved positions, which must be good to fall back to. */
        if (plii_solver_freeze_if_not_finite(body)) { return; }
        for (int i = 0; i < body->node_count; ++i) {
            plii_set_xyz(&body->previous[i], plii_xyz(body->positions[i]));
        }
        for (int i = 0; i < settings->drift_iterations; ++i) {
            plii_run_stage(body, pipeline, PLII_STAGE_DRIFT, step);
        }
        solver_add_drift_to_velocities(body, settings->drift_correction * step->inverse_dt);
    }
    plii_run_stage(body, pipeline, PLII_STAGE_FINISH, step);
}

const plii_solver_class plii_position_solver = {.name = "bullet", .predict = solver_predict, .solve = solver_solve};

pli_status plii_solver_check_change(const pli_body* body, const plii_solver_class* solver_class, const char* function) {
    if (body->world->is_stepping) {
        return plii_fail(body->context, PLI_ERROR_WRONG_STATE, function, "not allowed between predict and solve");
    }
    if (body->solver_class != &plii_position_solver && body->solver_class != solver_class) {
        return plii_fail(body->context, PLI_ERROR_WRONG_STATE, function,
                         "the body is stepped by the %s solver, which has to be disabled first",
                         body->solver_class->name);
    }
    return PLI_OK;
}
