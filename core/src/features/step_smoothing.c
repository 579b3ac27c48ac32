/* Steps that get shorter. What a long step leaves of errors, the short one after it puts right, as a speed of the error
   over its own length; between steps of 1/15 and 1/240 s that gives 256 times the energy. Here what a step changes
   about free flight counts as if it had taken as long as a step before. */

#include "body/all_features.h"
#include "body/body_impl.h"
#include "body/pipeline.h"
#include "body/world_state.h"
#include "pliant/body.h"

/* Of the reference length, in each step: errors that are left after a step are at most about so large. */
#define STEP_SMOOTHING_DECAY 0.75f

typedef struct step_smoothing_state {
    pli_vec3* starts;   /* [node_count] m/s, velocities without what the step changes */
    float reference_dt; /* s; 0: there was no step yet */
    bool is_shorter;    /* the step in progress */
} step_smoothing_state;

static void step_smoothing_start(pli_body* body, void* data) {
    step_smoothing_state* state = data;
    state->is_shorter = body->step.dt < state->reference_dt;
    if (!state->is_shorter) {
        state->reference_dt = body->step.dt;
        return;
    }
    /* The position-based solver has added gravity already. */
    const bool has_gravity = body->solver_class == &plii_position_solver;
    const pli_vec3 added = pli_vec3_scale(body->world->def.gravity, has_gravity ? 0.0f : body->step.dt);
    for (int i = 0; i < body->node_count; ++i) {
        state->starts[i] = pli_vec3_add(plii_xyz(body->velocities[i]), added);
    }
}

static void step_smoothing_finish(pli_body* body, void* data) {
    step_smoothing_state* state = data;
    if (!state->is_shorter) { return; }
    const float ratio = body->step.dt / state->reference_dt;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const pli_vec3 change = pli_vec3_sub(plii_xyz(body->velocities[i]), state->starts[i]);
        plii_set_xyz(&body->velocities[i], pli_vec3_add(state->starts[i], pli_vec3_scale(change, ratio)));
    }
    state->reference_dt = plii_max(body->step.dt, STEP_SMOOTHING_DECAY * state->reference_dt);
}

/* Not in Bullet. Before all forces, and after all that changes velocities. */
enum { STEP_SMOOTHING_START_ORDER = 0, STEP_SMOOTHING_FINISH_ORDER = 100 };

const plii_feature_class plii_step_smoothing_class = {
    .name = "step smoothing",
    .state_size = sizeof(step_smoothing_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(step_smoothing_state, reference_dt, PLII_SAVED, "f"),
                                    PLII_STATE(step_smoothing_state, is_shorter, PLII_LEFT)),
    .stages = {[PLII_STAGE_FORCES] = {step_smoothing_start, STEP_SMOOTHING_START_ORDER},
               [PLII_STAGE_FINISH] = {step_smoothing_finish, STEP_SMOOTHING_FINISH_ORDER}},
    .arrays = PLII_ARRAYS({PLII_MEMBER(step_smoothing_state, starts), PLII_PER_NODE, .snapshot = PLII_LEFT}),
};

pli_status pli_body_enable_step_smoothing(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    return plii_feature_enable(body, &plii_step_smoothing_class, NULL);
}

pli_status pli_body_disable_step_smoothing(pli_body* body) {
    return plii_feature_disable_if(plii_check_body_idle(body, __func__), body, &plii_step_smoothing_class);
}
