#include "body/substep_rigid.h"

float plii_substep_room(const pli_body* body, const plii_substep* substep, int node, pli_vec3 direction) {
    float room = INFINITY;
    for (int i = 0; i < body->pipeline.feature_count; ++i) {
        const plii_feature* feature = &body->pipeline.features[i];
        const plii_substep_class* kind = feature->klass->substepped;
        if (kind == NULL || kind->room == NULL) { continue; }
        room = plii_min(room, kind->room(body, feature->state, substep, node, direction));
    }
    return room;
}

/* a + b * scale */
static pli_vec3 substep_rigid_add(pli_vec3 a, pli_vec3 b, float scale) {
    return pli_vec3_add(a, pli_vec3_scale(b, scale));
}

void plii_substep_follow_rigid(pli_body* body, pli_rigid* rigid) {
    plii_rigid_path* path = &rigid->path;
    if (rigid->kind == PLI_RIGID_STATIC || path->is_followed) { return; }
    plii_rigid_begin_path(rigid);
    path->is_followed = true;
    path->is_pushed = false;
    path->next = body->followed_rigids;
    body->followed_rigids = rigid;
}

static void substep_rigid_begin(pli_rigid* rigid, const pli_body* body, float dt) {
    pli_rigid_state* state = &rigid->state;
    plii_rigid_path* path = &rigid->path;
    const float rate = body->step.inverse_dt;
    path->start_linear = state->linear_velocity;
    path->start_angular = state->angular_velocity;
    path->moved = path->rotated = pli_vec3_make(0, 0, 0);
    path->drift_linear = pli_vec3_sub(pli_vec3_scale(path->shift, rate), path->carried_linear);
    path->drift_angular = pli_vec3_sub(pli_vec3_scale(path->shift_rotation, rate), path->carried_angular);
    path->gain_linear = path->gain_angular = pli_vec3_make(0, 0, 0);
    if (!plii_rigid_is_moved_by_host(rigid)) { return; }
    if (rigid->kind == PLI_RIGID_KINEMATIC) { /* ends up where the host has put it */
        const pli_vec3 motion = pli_vec3_sub(state->pose.origin, path->begin.origin);
        path->drift_linear = pli_vec3_sub(pli_vec3_scale(motion, rate), state->linear_velocity);
        return;
    }
    const pli_vec3 linear = pli_vec3_sub(rigid->given_linear_velocity, path->begin_linear);
    const pli_vec3 angular = pli_vec3_sub(rigid->given_angular_velocity, path->begin_angular);
    path->gain_linear = pli_vec3_scale(linear, dt * rate);
    path->gain_angular = pli_vec3_scale(angular, dt * rate);
    state->linear_velocity = pli_vec3_sub(state->linear_velocity, linear);
    state->angular_velocity = pli_vec3_sub(state->angular_velocity, angular);
}

static void substep_rigid_move(pli_rigid* rigid, float dt) {
    plii_rigid_path* path = &rigid->path;
    path->moved = substep_rigid_add(path->moved, pli_vec3_add(rigid->state.linear_velocity, path->drift_linear), dt);
    path->rotated =
        substep_rigid_add(path->rotated, pli_vec3_add(rigid->state.angular_velocity, path->drift_angular), dt);
}

void plii_substep_rigids_restart(const pli_body* body, const plii_substep* substep) {
    for (pli_rigid* rigid = body->followed_rigids; rigid != NULL; rigid = rigid->path.next) {
        if (substep->index == 0) {
            substep_rigid_begin(rigid, body, substep->dt);
        } else {
            substep_rigid_move(rigid, substep->dt);
        }
        pli_rigid_state* state = &rigid->state;
        state->linear_velocity = pli_vec3_add(state->linear_velocity, rigid->path.gain_linear);
        state->angular_velocity = pli_vec3_add(state->angular_velocity, rigid->path.gain_angular);
    }
}

/* One that was not pushed, or takes no impulses, goes as its host moves it. */
void plii_substep_rigids_finish(pli_body* body, const plii_substep* substep) {
    const float dt = body->step.dt;
    while (body->followed_rigids != NULL) {
        pli_rigid* rigid = body->followed_rigids;
        pli_rigid_state* state = &rigid->state;
        plii_rigid_path* path = &rigid->path;
        body->followed_rigids = path->next;
        path->is_followed = false;
        if (!path->is_pushed || !(state->inverse_mass > 0.0f)) {
            state->linear_velocity = path->start_linear;
            state->angular_velocity = path->start_angular;
            continue;
        }
        substep_rigid_move(rigid, substep->dt);
        const pli_vec3 linear = pli_vec3_add(path->start_linear, path->drift_linear);
        const pli_vec3 angular = pli_vec3_add(path->start_angular, path->drift_angular);
        path->shift = pli_vec3_add(path->shift, substep_rigid_add(path->moved, linear, -dt));
        path->shift_rotation = pli_vec3_add(path->shift_rotation, substep_rigid_add(path->rotated, angular, -dt));
        path->carried_linear =
            pli_vec3_add(path->carried_linear, pli_vec3_sub(state->linear_velocity, path->start_linear));
        path->carried_angular =
            pli_vec3_add(path->carried_angular, pli_vec3_sub(state->angular_velocity, path->start_angular));
    }
}
