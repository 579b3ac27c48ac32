/* Steps that get shorter. What a long step leaves of errors, the short one after it puts right, as a speed of the error
   over its own length; between steps of 1/15 and 1/240 s that gives 256 times the energy. Here what a step changes
   about free flight counts as if it had taken as long as a step before. */

#include "body/pipeline.h"
#include "body/substep.h"

/* The reference length falls as errors do, within these bounds: an error d acts as a spring of m / H^2. */
#define STEP_SMOOTHING_FASTEST 0.75
#define STEP_SMOOTHING_SLOWEST 0.98

typedef struct step_smoothing_state {
    pli_vec3* starts;   /* [node_count] m/s, velocities without what the step changes */
    float reference_dt; /* s; 0: there was no step yet */
    float error;        /* kg m^2, sum of m d^2 of what the step before put right; 0: it was not shorter */
    bool is_shorter;    /* the step in progress */
} step_smoothing_state;

static void step_smoothing_start(pli_body* body, void* data) {
    step_smoothing_state* state = data;
    state->is_shorter = body->step.dt < state->reference_dt;
    if (!state->is_shorter) {
        state->reference_dt = body->step.dt;
        state->error = 0.0f;
        return;
    }
    /* The position-based solver has added gravity already. */
    const bool has_gravity = body->solver_class == &plii_position_solver;
    const pli_vec3 gravity = pli_vec3_scale(body->world->def.gravity, has_gravity ? 0.0f : body->step.dt);
    for (int i = 0; i < body->node_count; ++i) {
        pli_vec3 added = gravity;
        if (body->forces != NULL) {
            added = pli_vec3_add(added, pli_vec3_scale(body->forces[i], body->positions[i].w * body->step.dt));
        }
        state->starts[i] = pli_vec3_add(plii_xyz(body->velocities[i]), added);
    }
}

/* What takes energy counts as a speed of the error over the reference length; what gives some, as the speed that a
   spring gives in this step which would give that one in a step of the reference length. */
static void step_smoothing_finish(pli_body* body, void* data) {
    step_smoothing_state* state = data;
    if (!state->is_shorter) { return; }
    double along = 0.0, square = 0.0; /* sums over the nodes of m u v and m u u: u the change, v the start */
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const pli_vec3 change = pli_vec3_sub(plii_xyz(body->velocities[i]), state->starts[i]);
        const double mass = 1.0 / (double)body->positions[i].w;
        along += mass * (double)pli_vec3_dot(change, state->starts[i]);
        square += mass * (double)pli_vec3_dot(change, change);
    }
    /* What XPBD puts right it does as in a longer step by itself. */
    const double lag = body->substep != NULL ? (double)body->substep->lag : 0.0;
    const double ratio = fmin((double)body->step.dt * sqrt(1.0 + lag) / (double)state->reference_dt, 1.0);
    const double neutral = along < 0.0 ? -2.0 * along / square : 0.0;
    const float share = (float)fmin(fmax(neutral, ratio * ratio), ratio);
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const pli_vec3 change = pli_vec3_sub(plii_xyz(body->velocities[i]), state->starts[i]);
        plii_set_xyz(&body->velocities[i], pli_vec3_add(state->starts[i], pli_vec3_scale(change, share)));
    }
    const double error = square * (double)body->step.dt * (double)body->step.dt;
    const double before = (double)state->error;
    const double left = before > 0.0 ? sqrt(error / before) : STEP_SMOOTHING_SLOWEST;
    const double falls = fmin(fmax(left, STEP_SMOOTHING_FASTEST), STEP_SMOOTHING_SLOWEST);
    state->reference_dt = plii_max(body->step.dt, (float)falls * state->reference_dt);
    state->error = (float)error;
}

/* Before pressure and volume, which act against what holds them as links do; after all that changes velocities. */
enum { STEP_SMOOTHING_START_ORDER = 15, STEP_SMOOTHING_FINISH_ORDER = 100 };
const plii_feature_class plii_step_smoothing_class = {
    .name = "step smoothing",
    .state_size = sizeof(step_smoothing_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(step_smoothing_state, reference_dt, error, PLII_SAVED, "2f"),
                                    PLII_STATE(step_smoothing_state, is_shorter, PLII_LEFT)),
    .stages = {[PLII_STAGE_FORCES] = {step_smoothing_start, STEP_SMOOTHING_START_ORDER},
               [PLII_STAGE_FINISH] = {step_smoothing_finish, STEP_SMOOTHING_FINISH_ORDER}},
    .arrays = PLII_ARRAYS(PLII_LEFT_PER_NODE(step_smoothing_state, starts)),
};

pli_status pli_body_enable_step_smoothing(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    return plii_body_changed(body, plii_feature_enable(body, &plii_step_smoothing_class, NULL));
}
PLII_DEFINE_DISABLE(pli_body_disable_step_smoothing, plii_check_body_idle, plii_step_smoothing_class)
