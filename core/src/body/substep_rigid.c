#include "body/substep_rigid.h"

#include "body/world_state.h"

/* As the node has moved before. Damping, which acts at the end of a step, is not what holds it. */
static pli_vec3 substep_own_motion(const pli_body* body, const plii_substep* substep, int node) {
    const pli_vec3 motion = plii_substep_motion(substep, node);
    if (!(substep->displacements[node].w > 0.0f)) { return motion; }
    const pli_vec3 fall = pli_vec3_scale(body->world->def.gravity, substep->dt * substep->dt);
    const float kept = substep->index == 0 ? plii_max(1.0f - body->solver.velocity_damping, 0.5f) : 1.0f;
    return pli_vec3_scale(pli_vec3_sub(motion, fall), 1.0f / kept);
}

/* Along the normal the node itself is no measure: pressed hard it is thrown to and fro. */
pli_vec3 plii_substep_carried(const pli_body* body, const plii_substep* substep, int node, pli_vec3 normal) {
    const pli_vec3 own = substep_own_motion(body, substep, node);
    pli_vec3 across = own, motion = pli_vec3_make(0, 0, 0);
    for (PLII_EACH_AT(const plii_pipeline_entry, limit, substep->limits->at, substep->limits->count)) {
        plii_substep_carry_fn* carry = limit->klass->substepped->carry;
        if (carry != NULL && carry(body, limit->state, substep, node, normal, own, &motion)) { across = motion; }
    }
    return pli_vec3_add(across, pli_vec3_scale(normal, pli_vec3_dot(normal, pli_vec3_sub(motion, across))));
}

float plii_substep_room(const pli_body* body, const plii_substep* substep, int node, pli_vec3 direction, float wanted) {
    float room = INFINITY;
    for (PLII_EACH_AT(const plii_pipeline_entry, limit, substep->limits->at, substep->limits->count)) {
        plii_substep_room_fn* own = limit->klass->substepped->room;
        room = plii_min(room, own(body, limit->state, substep, node, direction, wanted));
    }
    return room;
}

void plii_substep_follow_rigid(pli_body* body, pli_rigid* rigid) {
    plii_rigid_path* path = &rigid->path;
    if (rigid->kind == PLI_RIGID_STATIC || path->is_followed) { return; }
    plii_rigid_begin_path(rigid);
    path->is_followed = true;
    path->is_pushed = false;
    path->next = body->followed_rigids;
    body->followed_rigids = rigid;
    body->finish_rigids = plii_substep_rigids_finish;
}

void plii_substep_rigid_pivot_turn(plii_substep_rigid_pivot* pivot) {
    const plii_twist turn = {{0, 0, 0}, pivot->point.rigid->path.moved.angular};
    const pli_transform turned = plii_rigid_advance(pli_transform_identity(), turn, 1.0f);
    pivot->point.offset = pli_mat3_mul_vec3(turned.rotation, pivot->start_offset);
}

/* As much of a change of velocity by the host as it is a free fall along gravity. */
static plii_twist substep_free_fall(const pli_body* body, pli_vec3 change) {
    const pli_vec3 fall = pli_vec3_scale(body->world->def.gravity, body->host_dt);
    const float square = pli_vec3_dot(fall, fall);
    const float off = square > 0.0f ? fabsf(pli_vec3_dot(change, fall) / square - 1.0f) : 1.0f;
    return plii_twist_make(pli_vec3_scale(fall, plii_max(1.0f - 2.0f * off, 0.0f)), pli_vec3_make(0, 0, 0));
}

static void substep_rigid_begin(pli_rigid* rigid, const pli_body* body, float dt) {
    plii_rigid_path* path = &rigid->path;
    const float rate = 1.0f / body->host_dt;
    path->start = plii_rigid_velocity(rigid);
    path->moved = path->gain = (plii_twist){0};
    path->drift = plii_twist_sub(plii_twist_scale(path->shift, rate), path->carried);
    const bool is_moved = plii_rigid_is_moved_by_host(rigid);
    if (is_moved && rigid->kind == PLI_RIGID_KINEMATIC) { /* ends up where the host has put it */
        const pli_vec3 motion = pli_vec3_sub(rigid->state.pose.origin, path->begin.origin);
        path->drift.linear = pli_vec3_sub(pli_vec3_scale(motion, rate), path->start.linear);
        return;
    }
    const pli_vec3 gained = pli_vec3_sub(rigid->given.linear, path->begin_velocity.linear);
    const plii_twist change =
        is_moved ? substep_free_fall(body, gained) : plii_twist_make(path->pull, pli_vec3_make(0, 0, 0));
    path->gain = plii_twist_scale(change, dt * rate);
    plii_rigid_set_velocity(rigid, plii_twist_sub(path->start, change));
}

static void substep_rigid_move(pli_rigid* rigid, float dt) {
    plii_rigid_path* path = &rigid->path;
    const plii_twist velocity = plii_substep_rigid_velocity(rigid);
    path->moved = plii_twist_add(path->moved, plii_twist_scale(velocity, dt));
}

void plii_substep_rigids_restart(const pli_body* body, const plii_substep* substep) {
    for (pli_rigid* rigid = body->followed_rigids; rigid != NULL; rigid = rigid->path.next) {
        if (substep->index == 0) {
            substep_rigid_begin(rigid, body, substep->host_dt);
        } else {
            substep_rigid_move(rigid, substep->host_dt);
        }
        plii_rigid_set_velocity(rigid, plii_twist_add(plii_rigid_velocity(rigid), rigid->path.gain));
    }
}

/* One that was not pushed, or takes no impulses, goes as its host moves it. */
void plii_substep_rigids_finish(pli_body* body, float dt) {
    while (body->followed_rigids != NULL) {
        pli_rigid* rigid = body->followed_rigids;
        plii_rigid_path* path = &rigid->path;
        body->followed_rigids = path->next;
        path->is_followed = false;
        if (!path->is_pushed || !(rigid->state.inverse_mass > 0.0f)) {
            plii_rigid_set_velocity(rigid, path->start);
            continue;
        }
        substep_rigid_move(rigid, dt);
        const plii_twist expected = plii_twist_scale(plii_twist_add(path->start, path->drift), body->host_dt);
        path->shift = plii_twist_add(path->shift, plii_twist_sub(path->moved, expected));
        path->carried = plii_twist_add(path->carried, plii_twist_sub(plii_rigid_velocity(rigid), path->start));
    }
}
