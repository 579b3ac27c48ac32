/* The position-based step: explicit prediction, then iterations of the enabled features, then velocities from
   positions. Matches btSoftBody::predictMotion and solveConstraints. */

#include "math/simd_float4.h"

#include "body/pipeline.h"
#include "body/world_state.h"
#include "math/range.h"

#include <string.h>

// -------------------------------------------------------------------------------------------------- bounds

void plii_solver_set_start(pli_body* body) {
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i], plii_xyz(body->previous[i]));
        body->velocities[i] = (pli_vec4){0};
    }
    plii_body_update_bounds(body);
}

static void solver_put_back(pli_body* body) {
    const int node = plii_body_find_lost_node(body);
    plii_solver_set_start(body);
    body->is_frozen = true;
    plii_world_add_event(body->world, (pli_event){.kind = PLI_EVENT_BODY_FROZEN, .body = body, .node = node});
}

bool plii_solver_update_bounds(pli_body* body) {
    if (plii_body_update_bounds(body)) { return true; }
    solver_put_back(body);
    return false;
}

/* The position-based solver takes velocities from the motions of a step, which do not lead out of the world. */
static bool solver_bounds_velocities(const pli_body* body) {
    if (body->solver_class != &plii_position_solver) { return false; }
    if (!plii_stage_is_empty(&body->pipeline, PLII_STAGE_FINISH)) { return false; }
    const float drift = body->solver.drift_iterations > 0 ? fabsf(body->solver.drift_correction) : 0.0f;
    return 2.0f * PLI_MAX_COORDINATE * body->step.inverse_dt * (1.0f + drift) <= PLI_MAX_SPEED;
}

bool plii_solver_check_velocities(pli_body* body) {
    if (solver_bounds_velocities(body) || plii_body_is_slow(body)) { return true; }
    solver_put_back(body);
    return false;
}

// ------------------------------------------------------------------------------------------------ prediction

enum { SOLVER_NODES_GRAIN = 4096 };

/* The arrays, which stores to them do not move. */
typedef struct solver_nodes {
    pli_vec4* restrict positions, * restrict previous, * restrict velocities;
    pli_vec3* restrict forces; /* or NULL */
    float dt;                  /* s */
    pli_vec3 gravity;          /* change of velocities, m/s */
    float limit;               /* of the change by forces, m/s */
    float rate;                /* velocities, or their change, for motions since the start of the step, 1/s */
} solver_nodes;

static solver_nodes solver_nodes_of(const pli_body* body) {
    return (solver_nodes){.positions = body->positions,
                          .previous = body->previous,
                          .velocities = body->velocities,
                          .forces = body->forces};
}

/* Inline, with its range: bodies of a few nodes would notice the calls. The range is called by its name, since
   compilers need not inline a call through a pointer. */
#define SOLVER_PASS(body, range, nodes)                                                                                \
    do {                                                                                                               \
        const pli_context* const pass_context = (body)->context;                                                       \
        const int pass_count = (body)->node_count;                                                                     \
        if (pass_count > SOLVER_NODES_GRAIN) {                                                                         \
            pass_context->parallel_for(range, nodes, pass_count, SOLVER_NODES_GRAIN, pass_context->parallel_user);     \
        } else {                                                                                                       \
            range(0, pass_count, nodes);                                                                               \
        }                                                                                                              \
    } while (0)

/* Pinned nodes keep their velocity. */
PLII_SIMD_INLINE plii_float4 solver_apply_gravity(plii_float4 velocity, plii_float4 position, plii_float4 added) {
    const plii_mask4 is_free = plii_lanes_less(plii_float4_all(0.0f), plii_lanes_all_w(position));
    return plii_lanes_select(is_free, plii_float4_add(velocity, added), velocity);
}

PLII_SIMD_INLINE void solver_add_gravity(int begin, int end, void* data) {
    const solver_nodes nodes = *(const solver_nodes*)data;
    const plii_float4 added = plii_lanes_from_vec3(&nodes.gravity);
    for (int i = begin; i < end; ++i) {
        const plii_float4 velocity = plii_float4_from(&nodes.velocities[i]);
        plii_float4_to(&nodes.velocities[i],
                       solver_apply_gravity(velocity, plii_float4_from(&nodes.positions[i]), added));
    }
}

/* The w of velocities is 0, and previous positions have none. */
PLII_SIMD_INLINE void solver_move_node(solver_nodes nodes, int node, plii_float4 velocity, plii_float4 dt) {
    const plii_float4 position = plii_float4_from(&nodes.positions[node]);
    plii_float4_to(&nodes.previous[node], plii_lanes_xyz(position));
    plii_float4_to(&nodes.positions[node], plii_float4_add(position, plii_float4_mul(velocity, dt)));
}

PLII_SIMD_INLINE void solver_move(int begin, int end, void* data) {
    const solver_nodes nodes = *(const solver_nodes*)data;
    const plii_float4 step = plii_float4_all(nodes.dt);
    for (int i = begin; i < end; ++i) {
        solver_move_node(nodes, i, plii_float4_from(&nodes.velocities[i]), step);
    }
}

PLII_SIMD_INLINE void solver_add_forces_and_move(int begin, int end, void* data) {
    const solver_nodes nodes = *(const solver_nodes*)data;
    const plii_float4 low = plii_float4_all(-nodes.limit), high = plii_float4_all(nodes.limit);
    const plii_float4 step = plii_float4_all(nodes.dt);
    for (int i = begin; i < end; ++i) {
        const plii_float4 inverse_mass = plii_lanes_all_w(plii_float4_from(&nodes.positions[i]));
        const plii_float4 change =
            plii_float4_mul(plii_float4_mul(plii_lanes_from_vec3(&nodes.forces[i]), inverse_mass), step);
        const plii_float4 clamped = plii_lanes_min(high, plii_lanes_max(low, change));
        const plii_float4 velocity = plii_float4_add(plii_float4_from(&nodes.velocities[i]), clamped);
        plii_float4_to(&nodes.velocities[i], velocity);
        solver_move_node(nodes, i, velocity, step);
    }
    memset(&nodes.forces[begin], 0, (size_t)(end - begin) * sizeof *nodes.forces);
}

/* All of it in one pass, where nothing but gravity pulls. */
PLII_SIMD_INLINE void solver_integrate_free(int begin, int end, void* data) {
    const solver_nodes nodes = *(const solver_nodes*)data;
    const plii_float4 added = plii_lanes_from_vec3(&nodes.gravity), step = plii_float4_all(nodes.dt);
    for (int i = begin; i < end; ++i) {
        const plii_float4 start = plii_float4_from(&nodes.velocities[i]);
        const plii_float4 velocity = solver_apply_gravity(start, plii_float4_from(&nodes.positions[i]), added);
        plii_float4_to(&nodes.velocities[i], velocity);
        solver_move_node(nodes, i, velocity, step);
    }
}

void plii_solver_update_predicted_bounds(pli_body* body) {
    const pli_bounds before = body->bounds;
    const bool is_early = body->has_early_bounds;
    body->has_early_bounds = false;
    if (!plii_solver_update_bounds(body)) { return; }
    if (is_early) { body->bounds = before; }
    if (body->sweeping_features == 0) { return; }
    body->bounds.min = plii_vec3_min(body->bounds.min, before.min);
    body->bounds.max = plii_vec3_max(body->bounds.max, before.max);
}

static void solver_predict(pli_body* body, float dt) {
    plii_step* step = &body->step;
    step->dt = dt * body->solver.time_scale;
    step->inverse_dt = 1.0f / step->dt;
    solver_nodes nodes = solver_nodes_of(body);
    nodes.dt = step->dt;
    nodes.gravity = pli_vec3_scale(body->world->def.gravity, step->dt);
    if (body->forces == NULL && plii_stage_is_empty(&body->pipeline, PLII_STAGE_FORCES)) {
        SOLVER_PASS(body, solver_integrate_free, &nodes);
    } else {
        SOLVER_PASS(body, solver_add_gravity, &nodes);
        plii_run_stage(body, &body->pipeline, PLII_STAGE_FORCES, step);
        if (body->forces != NULL) {
            nodes.limit = body->world->def.max_force_displacement / step->dt;
            SOLVER_PASS(body, solver_add_forces_and_move, &nodes);
        } else {
            SOLVER_PASS(body, solver_move, &nodes);
        }
    }
    plii_run_stage(body, &body->pipeline, PLII_STAGE_UPDATE, step);
    plii_solver_update_predicted_bounds(body);
}

// ------------------------------------------------------------------------------------------------- iterations

static void solver_positions_from_velocities(pli_body* body, float dt) {
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i],
                     pli_vec3_add(plii_xyz(body->previous[i]), pli_vec3_scale(plii_xyz(body->velocities[i]), dt)));
    }
}

PLII_SIMD_INLINE plii_float4 solver_velocity(const solver_nodes* nodes, int node) {
    const plii_float4 moved =
        plii_float4_sub(plii_float4_from(&nodes->positions[node]), plii_float4_from(&nodes->previous[node]));
    return plii_lanes_xyz(plii_float4_mul(moved, plii_float4_all(nodes->rate)));
}

PLII_SIMD_INLINE void solver_set_velocities(int begin, int end, void* data) {
    const solver_nodes nodes = *(const solver_nodes*)data;
    for (int i = begin; i < end; ++i) {
        plii_float4_to(&nodes.velocities[i], solver_velocity(&nodes, i));
    }
}

PLII_SIMD_INLINE void solver_add_velocities(int begin, int end, void* data) {
    const solver_nodes nodes = *(const solver_nodes*)data;
    for (int i = begin; i < end; ++i) {
        const plii_float4 velocity = plii_float4_from(&nodes.velocities[i]);
        plii_float4_to(&nodes.velocities[i], plii_float4_add(velocity, solver_velocity(&nodes, i)));
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
    solver_nodes nodes = solver_nodes_of(body);
    if (settings->position_iterations > 0) {
        for (int i = 0; i < settings->position_iterations; ++i) {
            plii_run_stage(body, pipeline, PLII_STAGE_POSITION, step);
        }
        nodes.rate = step->inverse_dt * (1.0f - settings->velocity_damping);
        SOLVER_PASS(body, solver_set_velocities, &nodes);
    }
    if (settings->drift_iterations > 0) {
        /* The drift solve measures from the solved positions, which must be good to fall back to. */
        if (!plii_solver_update_bounds(body)) { return; }
        for (int i = 0; i < body->node_count; ++i) {
            plii_set_xyz(&body->previous[i], plii_xyz(body->positions[i]));
        }
        for (int i = 0; i < settings->drift_iterations; ++i) {
            plii_run_stage(body, pipeline, PLII_STAGE_DRIFT, step);
        }
        nodes.rate = settings->drift_correction * step->inverse_dt;
        SOLVER_PASS(body, solver_add_velocities, &nodes);
    }
    plii_run_stage(body, pipeline, PLII_STAGE_FINISH, step);
}

const plii_solver_class plii_position_solver = {
    .name = "position-based", .predict = solver_predict, .solve = solver_solve};

pli_status plii_solver_check_change(const pli_body* body, const plii_solver_class* solver_class, const char* function) {
    if (body->solver_class != &plii_position_solver && body->solver_class != solver_class) {
        return plii_fail(body->context, PLI_ERROR_WRONG_STATE, function,
                         "the body is stepped by the %s solver, which has to be disabled first",
                         body->solver_class->name);
    }
    return PLI_OK;
}
