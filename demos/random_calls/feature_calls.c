/* Features that are no solver: forces, contacts, self-collision, tethers, pose matching. */

#include "calls.h"

#include <pliant/bullet_reference.h>

#define TURN(call) CALL(c, home, call)

static void change_aero(calls* c, pli_body* body, calls_context* home) {
    pli_aero_def def = pli_aero_def_default();
    def.model = (pli_aero_model)bytes_small(&c->bytes, 0, 6);
    def.lift = bytes_float(&c->bytes, 0.0f, 0.5f);
    def.drag = bytes_float(&c->bytes, 0.0f, 0.5f);
    def.wind = bytes_vec3(&c->bytes, -5.0f, 5.0f);
    TURN(pli_body_enable_aero(body, &def));
    if (bytes_seldom(&c->bytes, 64)) {
        const pli_vec3 wind = bytes_vec3(&c->bytes, -5.0f, 5.0f);
        TURN(pli_body_set_wind(body, wind));
    }
}

static void change_rigid_contacts(calls* c, pli_body* body, calls_context* home) {
    pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
    if (bytes_flag(&c->bytes)) {
        def.friction = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.dynamic_hardness = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.static_hardness = bytes_float(&c->bytes, 0.0f, 1.0f);
        const int flags = bytes_next(&c->bytes);
        if ((flags & 16) != 0) { def.compliance = bytes_float(&c->bytes, 0.0f, 0.01f); }
        if ((flags & 32) != 0) { def.recovery_speed = bytes_float(&c->bytes, 0.0f, 2.0f); }
        if ((flags & 14) == 14) { TURN(pli_body_enable_bullet_node_boxes(body)); }
        if ((flags & 14) == 6) { TURN(pli_body_disable_bullet_node_boxes(body)); }
    }
    TURN(pli_body_enable_rigid_contacts(body, &def));
}

static void change_rigid_face_contacts(calls* c, pli_body* body, calls_context* home) {
    pli_rigid_face_contacts_def def = pli_rigid_face_contacts_def_default();
    if (bytes_flag(&c->bytes)) {
        def.friction = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.dynamic_hardness = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.static_hardness = bytes_float(&c->bytes, 0.0f, 1.0f);
    }
    TURN(pli_body_enable_rigid_face_contacts(body, &def));
}

static void change_soft_contacts(calls* c, pli_body* body, calls_context* home) {
    enum { MOST = 64 };
    pli_soft_contacts_def def = pli_soft_contacts_def_default();
    if (bytes_flag(&c->bytes)) {
        def.friction = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.hardness = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.recovery_speed = bytes_float(&c->bytes, 0.0f, 3.0f);
        const int flags = bytes_next(&c->bytes);
        def.bullet_boxes = (flags & 1) != 0;
        if ((flags & 2) != 0) { def.compliance = bytes_float(&c->bytes, 0.0f, 0.01f); }
    }
    TURN(pli_body_enable_soft_contacts(body, &def));
    const pli_body_view view = pli_body_get_view(body);
    if (!def.bullet_boxes || !bytes_flag(&c->bytes) || view.node_count > MOST || view.face_count > MOST) { return; }
    const pli_vec3 low = bytes_vec3(&c->bytes, -1.0f, 0.0f), high = bytes_vec3(&c->bytes, 0.0f, 1.0f);
    pli_bounds boxes[MOST];
    for (int i = 0; i < MOST; ++i) {
        boxes[i] = (pli_bounds){low, high};
    }
    TURN(pli_body_set_bullet_boxes(body, boxes, boxes));
}

static void change_self_collision(calls* c, pli_body* body, calls_context* home) {
    pli_self_collision_def def = pli_self_collision_def_default();
    def.thickness = bytes_float(&c->bytes, 0.01f, 0.5f);
    def.friction = bytes_float(&c->bytes, 0.0f, 1.0f);
    def.speed_limit_ratio = bytes_float(&c->bytes, 0.0f, 0.5f);
    TURN(pli_body_enable_self_collision(body, &def));
}

static void change_self_grids(calls* c, pli_body* body, calls_context* home) {
    pli_self_grids_def def = pli_self_grids_def_default();
    def.distance = bytes_float(&c->bytes, 0.01f, 0.5f);
    def.separation = bytes_float(&c->bytes, 0.1f, 1.0f);
    TURN(pli_body_enable_self_grids(body, &def));
}

static void change_self_faces(calls* c, pli_body* body, calls_context* home) {
    pli_self_faces_def def = pli_self_faces_def_default();
    def.thickness = bytes_float(&c->bytes, 0.005f, 0.12f);
    def.friction = bytes_float(&c->bytes, 0.0f, 1.0f);
    def.max_travel = bytes_float(&c->bytes, 0.0f, 0.3f);
    TURN(pli_body_enable_self_faces(body, &def));
}

static void turn_off(calls* c, pli_body* body, calls_context* home) {
    switch (bytes_below(&c->bytes, 12)) {
    case 0:
        TURN(pli_body_disable_aero(body));
        break;
    case 1:
        TURN(pli_body_disable_pressure(body));
        break;
    case 2:
        TURN(pli_body_disable_volume_conservation(body));
        break;
    case 3:
        TURN(pli_body_disable_rigid_contacts(body));
        break;
    case 4:
        TURN(pli_body_disable_rigid_face_contacts(body));
        break;
    case 5:
        TURN(pli_body_disable_soft_contacts(body));
        break;
    case 6:
        TURN(pli_body_disable_self_collision(body));
        break;
    case 7:
        TURN(pli_body_disable_self_grids(body));
        break;
    case 8:
        TURN(pli_body_disable_self_faces(body));
        break;
    case 9:
        TURN(pli_body_disable_tethers(body));
        break;
    case 10:
        TURN(pli_body_disable_pose_matching(body));
        break;
    default:
        TURN(pli_body_disable_cluster_contacts(body));
        break;
    }
}

void calls_change_feature(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_body* body = chosen->body;
    calls_context* home = chosen->world->home;
    pli_tethers_def tethers = pli_tethers_def_default();
    switch (bytes_below(&c->bytes, 16)) {
    case 0:
        change_aero(c, body, home);
        break;
    case 1:
        TURN(pli_body_enable_pressure(body, bytes_float(&c->bytes, -5.0f, 50.0f)));
        break;
    case 2:
        TURN(pli_body_enable_volume_conservation(body, bytes_float(&c->bytes, 0.0f, 50.0f)));
        break;
    case 3:
    case 4:
        change_rigid_contacts(c, body, home);
        break;
    case 5:
    case 6:
        change_rigid_face_contacts(c, body, home);
        break;
    case 7:
    case 8:
        change_soft_contacts(c, body, home);
        break;
    case 9:
        change_self_collision(c, body, home);
        break;
    case 10:
        change_self_grids(c, body, home);
        break;
    case 11:
        change_self_faces(c, body, home);
        break;
    case 12:
        tethers.slack = bytes_float(&c->bytes, 0.0f, 0.2f);
        TURN(pli_body_enable_tethers(body, &tethers));
        break;
    case 13:
        TURN(pli_body_enable_pose_matching(body, bytes_float(&c->bytes, 0.0f, 1.0f)));
        break;
    default:
        turn_off(c, body, home);
        break;
    }
}
