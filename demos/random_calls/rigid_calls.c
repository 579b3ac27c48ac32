/* Rigid bodies as the host changes them, and anchors. */

#include "calls.h"

void calls_change_rigid(calls* c) {
    calls_rigid* chosen = calls_any_rigid(c);
    if (chosen == NULL) { return; }
    pli_rigid* rigid = chosen->rigid;
    calls_context* home = chosen->world->home;
    pli_rigid_state state = pli_rigid_get_state(rigid);
    const int kind = bytes_below(&c->bytes, 8);
    if (kind < 3) {
        state.pose = bytes_transform(&c->bytes, 1.0f);
        state.linear_velocity = bytes_vec3(&c->bytes, -4.0f, 4.0f);
        state.angular_velocity = bytes_vec3(&c->bytes, -4.0f, 4.0f);
    }
    if (kind == 0) {
        state.inverse_mass = bytes_float(&c->bytes, 0.1f, 2.0f);
        state.inverse_inertia_world.rows[bytes_below(&c->bytes, 3)] = bytes_vec3(&c->bytes, 0.0f, 2.0f);
    }
    if (kind < 2) { CALL(c, home, pli_rigid_set_state(rigid, &state)); }
    if (kind == 2) {
        CALL(c, home,
             pli_rigid_set_kind(rigid, (pli_rigid_kind)bytes_small(&c->bytes, 0, 2),
                                bytes_flag(&c->bytes) ? &state : NULL));
    }
    if (kind == 3) {
        const float friction = bytes_float(&c->bytes, 0.0f, 1.0f);
        CALL(c, home, pli_rigid_set_friction(rigid, friction));
        CALL(c, home, pli_rigid_set_present(rigid, friction < 0.8f));
    }
    if (kind == 4) {
        const pli_vec3 linear = bytes_vec3(&c->bytes, 0.0f, 1.0f), angular = bytes_vec3(&c->bytes, 0.0f, 1.0f);
        CALL(c, home, pli_rigid_set_factors(rigid, linear, angular));
    }
    if (kind == 5) {
        const calls_shape* shape = calls_any_shape(c);
        const pli_transform pose = bytes_transform(&c->bytes, 0.5f);
        if (shape == NULL || !calls_may_mix(c, shape->home, chosen->world)) { return; }
        pli_shape* const shapes[1] = {shape->shape};
        const int count = bytes_small(&c->bytes, 0, 1);
        CALL(c, home, pli_rigid_set_shapes(rigid, count, shapes, bytes_flag(&c->bytes) ? &pose : NULL));
    }
    if (kind >= 6) {
        const pli_vec3 gravity = bytes_vec3(&c->bytes, -10.0f, 10.0f);
        CALL(c, home, pli_rigid_integrate(rigid, gravity, bytes_float(&c->bytes, 0.002f, 0.05f)));
    }
    (void)pli_rigid_was_touched(rigid);
    (void)pli_rigid_get_shift(rigid, NULL, NULL);
    if (pli_rigid_get_user_data(rigid) != c) { calls_finding(c, "a rigid body does not know its data"); }
}

void calls_add_anchor(calls* c) {
    calls_body* chosen = calls_any_body(c);
    const calls_rigid* rigid = calls_any_rigid(c);
    if (chosen == NULL || rigid == NULL) { return; }
    pli_body* body = chosen->body;
    calls_context* home = chosen->world->home;
    pli_anchor_id* anchor = &c->anchors[bytes_below(&c->bytes, CALLS_IDS)];
    const int kind = bytes_below(&c->bytes, 8);
    if (kind < 5) {
        pli_anchor_def def = pli_anchor_def_default();
        def.node = bytes_index(&c->bytes, pli_body_get_view(body).node_count);
        def.rigid = rigid->rigid;
        pli_vec3 pivot = bytes_vec3(&c->bytes, -1.0f, 1.0f);
        if (bytes_flag(&c->bytes)) { def.local_pivot = &pivot; }
        if (bytes_seldom(&c->bytes, 64)) { def.influence = bytes_float(&c->bytes, 0.0f, 1.0f); }
        const int flags = bytes_next(&c->bytes);
        def.disable_collision = (flags & 1) != 0;
        if ((flags & 6) == 6) { def.compliance = bytes_float(&c->bytes, 0.0f, 0.01f); }
        CALL(c, home, pli_body_add_anchor(body, &def, anchor));
    } else if (kind < 7) {
        CALL(c, home, pli_body_remove_anchor(body, *anchor));
    } else {
        CALL(c, home, pli_body_set_anchor_hardness(body, bytes_float(&c->bytes, 0.0f, 1.0f)));
    }
}
