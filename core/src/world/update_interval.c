/* Bodies that step less often than their world: a step of theirs covers several of the world's, from its first one on.
   What touches others has to push and be pushed in each step. */

#include "body/pipeline.h"

enum { UPDATE_INTERVAL_MOST = 60 };

static void update_interval_note_rigid(pli_body* other, pli_rigid* rigid, void* user) {
    bool* holds_dynamic = user;
    *holds_dynamic = *holds_dynamic || (rigid != NULL && rigid->kind == PLI_RIGID_DYNAMIC);
}

static int update_interval_steps(const pli_body* body) {
    const plii_update_interval* interval = &body->interval;
    bool holds_dynamic = false;
    plii_features_visit_joined(body, update_interval_note_rigid, &holds_dynamic);
    if (interval->is_near || body->joint_iterations > 0 || holds_dynamic) { return 1; }
    return interval->first_steps > 0 ? interval->first_steps : interval->steps;
}

/* A step begins when the last one has run out, and makes up for what that was too long or too short. */
static void update_intervals_take(pli_world* world, float dt) {
    for (PLII_EACH_BODY(body, world)) {
        plii_update_interval* interval = &body->interval;
        if (plii_body_is_stopped(body)) {
            *interval = (plii_update_interval){.steps = interval->steps, .step = dt};
            continue;
        }
        interval->is_waiting = interval->lead >= 0.5f * dt;
        if (!interval->is_waiting) {
            const float most = plii_max(PLI_MAX_TIME_STEP - dt, dt);
            interval->step = plii_min((float)update_interval_steps(body) * dt - interval->lead, most);
            interval->first_steps = 0;
            interval->is_near = false;
            interval->lead += interval->step;
        }
        interval->lead -= dt;
    }
}

void plii_world_use_update_intervals(pli_world* world) {
    world->take_update_intervals = update_intervals_take;
}
bool plii_update_interval_is_valid(const plii_update_interval* interval) {
    return interval->steps >= 1 && interval->steps <= UPDATE_INTERVAL_MOST && interval->first_steps >= 0 &&
           interval->first_steps <= UPDATE_INTERVAL_MOST && fabsf(interval->lead) <= PLI_MAX_TIME_STEP &&
           interval->step >= 0.0f && interval->step <= 2.0f * PLI_MAX_TIME_STEP;
}

pli_status pli_body_set_update_interval(pli_body* body, int steps) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_int(body->context, steps, 1, UPDATE_INTERVAL_MOST, "steps", __func__));
    if (steps == body->interval.steps) { return PLI_OK; }
    body->interval.steps = steps;
    body->interval.first_steps = 1 + body->world_index % steps; /* bodies take turns */
    plii_world_use_update_intervals(body->world);
    return plii_body_changed(body, PLI_OK);
}

PLII_DEFINE_GET(int, pli_body_get_update_interval, body, body->interval.steps, 1)
