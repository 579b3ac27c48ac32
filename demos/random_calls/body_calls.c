/* Bodies: settings, motion, states copied out and set back, measures. */

#include "calls.h"

#include <math.h>
#include <string.h>

#define BODY_CALL(c, chosen, call) CALL(c, (chosen)->world->home, call)

static void set_solver(calls* c, calls_body* chosen) {
    pli_solver_settings settings = pli_body_get_solver_settings(chosen->body);
    switch (bytes_below(&c->bytes, 6)) {
    case 0:
        settings.position_iterations = bytes_small(&c->bytes, 0, 8);
        break;
    case 1:
        settings.velocity_iterations = bytes_small(&c->bytes, 0, 4);
        break;
    case 2:
        settings.drift_iterations = bytes_small(&c->bytes, 0, 4);
        break;
    case 3:
        settings.drift_correction = bytes_float(&c->bytes, 0.0f, 1.0f);
        break;
    case 4:
        settings.velocity_damping = bytes_float(&c->bytes, 0.0f, 1.0f);
        break;
    default:
        settings.time_scale = bytes_float(&c->bytes, 0.5f, 2.0f);
        break;
    }
    BODY_CALL(c, chosen, pli_body_set_solver_settings(chosen->body, &settings));
}

/* Vertices into a buffer that may be too small for some layouts, which are refused. */
static void draw(calls* c, calls_body* chosen) {
    pli_body* body = chosen->body;
    float vertices[32 * 8];
    pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
    const int node_count = pli_body_get_view(body).node_count;
    buffer.vertices = vertices;
    buffer.vertex_count = node_count < 32 ? node_count : 32;
    buffer.stride = 4 * bytes_small(&c->bytes, 2, 8);
    switch (bytes_below(&c->bytes, 6)) {
    case 0:
        BODY_CALL(c, chosen, pli_body_enable_normals(body));
        break;
    case 1:
        BODY_CALL(c, chosen, pli_body_disable_normals(body));
        break;
    case 2:
        BODY_CALL(c, chosen, pli_body_enable_topology_changes(body));
        break;
    case 3:
        BODY_CALL(c, chosen, pli_body_disable_topology_changes(body));
        break;
    case 4:
        buffer.normal_offset = -1;
        BODY_CALL(c, chosen, pli_body_write_vertices(body, &buffer, bytes_float(&c->bytes, 0.0f, 2.0f)));
        break;
    default:
        BODY_CALL(c, chosen, pli_body_write_vertices(body, &buffer, bytes_float(&c->bytes, 0.0f, 2.0f)));
        break;
    }
}

/* Freezes, sleeps, steps less often or goes on. */
static void stop_body(calls* c, const calls_body* chosen) {
    pli_body* body = chosen->body;
    const int kind = bytes_below(&c->bytes, 10);
    if (kind < 4) {
        CALL(c, chosen->world->home, pli_body_set_frozen(body, kind == 0));
    } else if (kind < 6) {
        pli_sleep_def def = pli_sleep_def_default();
        def.speed = bytes_float(&c->bytes, 0.05f, 50.0f);
        def.time = bytes_float(&c->bytes, 0.001f, 0.1f);
        BODY_CALL(c, chosen, pli_body_enable_sleep(body, &def));
    } else if (kind < 8) {
        BODY_CALL(c, chosen, pli_body_set_asleep(body, kind == 6));
        (void)pli_body_is_asleep(body);
        (void)pli_body_is_resting(body);
    } else if (kind == 8) {
        BODY_CALL(c, chosen, pli_body_set_update_interval(body, bytes_below(&c->bytes, 12)));
    } else {
        BODY_CALL(c, chosen, pli_body_disable_sleep(body));
    }
}

void calls_set_up_body(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_body* body = chosen->body;
    const pli_body_view view = pli_body_get_view(body);
    const calls_rigid* rigid = &c->rigids[bytes_below(&c->bytes, CALLS_RIGIDS)];
    const int node = bytes_index(&c->bytes, view.node_count), link = bytes_index(&c->bytes, view.link_count);
    switch (bytes_below(&c->bytes, 11)) {
    case 0:
        set_solver(c, chosen);
        break;
    case 1:
        draw(c, chosen);
        break;
    case 2:
        BODY_CALL(c, chosen, pli_body_set_collision_margin(body, bytes_float(&c->bytes, 0.0f, 0.4f)));
        break;
    case 3:
        BODY_CALL(c, chosen, pli_body_set_rest_length(body, link, bytes_float(&c->bytes, 0.1f, 1.0f)));
        (void)pli_body_get_rest_length(body, link);
        break;
    case 4:
        BODY_CALL(c, chosen, pli_body_set_node_mass(body, node, bytes_float(&c->bytes, 0.0f, 3.0f)));
        break;
    case 5:
        if (bytes_flag(&c->bytes)) {
            BODY_CALL(c, chosen, pli_body_enable_step_smoothing(body));
        } else {
            BODY_CALL(c, chosen, pli_body_disable_step_smoothing(body));
        }
        break;
    case 6:
        if (bytes_flag(&c->bytes)) {
            BODY_CALL(c, chosen, pli_body_enable_velocity_links(body));
        } else {
            BODY_CALL(c, chosen, pli_body_disable_velocity_links(body));
        }
        break;
    case 7:
    case 8:
        if (bytes_below(&c->bytes, 4) > 0) {
            BODY_CALL(c, chosen, pli_body_enable_colored_links(body));
        } else {
            BODY_CALL(c, chosen, pli_body_disable_colored_links(body));
        }
        break;
    case 9:
        stop_body(c, chosen);
        break;
    default:
        if (rigid->rigid == NULL) { return; }
        BODY_CALL(c, chosen, pli_body_ignore_rigid(body, rigid->rigid, bytes_flag(&c->bytes)));
        (void)pli_body_ignores_rigid(body, rigid->rigid);
        break;
    }
}

void calls_move_body(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_body* body = chosen->body;
    const int node = bytes_index(&c->bytes, pli_body_get_view(body).node_count);
    const int kind = bytes_below(&c->bytes, 7);
    if (kind == 0) {
        const pli_transform transform = bytes_transform(&c->bytes, 1.0f);
        BODY_CALL(c, chosen, pli_body_transform(body, transform));
        return;
    }
    const pli_vec3 vector = bytes_vec3(&c->bytes, -2.0f, 2.0f);
    if (kind == 1) { BODY_CALL(c, chosen, pli_body_set_node_position(body, node, vector)); }
    if (kind == 2) { BODY_CALL(c, chosen, pli_body_set_node_velocity(body, node, vector)); }
    if (kind == 3) { BODY_CALL(c, chosen, pli_body_add_node_force(body, node, vector)); }
    if (kind == 4) { BODY_CALL(c, chosen, pli_body_add_force(body, vector)); }
    if (kind == 5) { BODY_CALL(c, chosen, pli_body_add_velocity(body, vector)); }
    const pli_body_view view = pli_body_get_view(body);
    const bool is_free = node >= 0 && node < view.node_count && view.positions[node].w > 0.0f;
    if (kind == 6 && !is_free) { BODY_CALL(c, chosen, pli_body_move_node(body, node, vector)); }
}

// ------------------------------------------------------------------------------------------------------ states

static pli_vec3 xyz(pli_vec4 record) {
    return pli_vec3_make(record.x, record.y, record.z);
}

void calls_save_state(calls* c) {
    const calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    const pli_body_view view = pli_body_get_view(chosen->body);
    if (view.node_count > CALLS_MOST_NODES) { return; }
    c->saved.count = view.node_count;
    for (int i = 0; i < view.node_count; ++i) {
        c->saved.positions[i] = xyz(view.positions[i]);
        c->saved.velocities[i] = xyz(view.velocities[i]);
    }
}

void calls_set_state_back(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL || c->saved.count < pli_body_get_view(chosen->body).node_count) { return; }
    const bool with_velocities = bytes_below(&c->bytes, 4) > 0;
    const pli_vec3* velocities = with_velocities ? c->saved.velocities : NULL;
    if (BODY_CALL(c, chosen, pli_body_set_state(chosen->body, c->saved.positions, velocities)) != PLI_OK) { return; }
    const pli_body_view view = pli_body_get_view(chosen->body);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec3 position = xyz(view.positions[i]), velocity = xyz(view.velocities[i]);
        if (memcmp(&position, &c->saved.positions[i], sizeof position) != 0 ||
            (with_velocities && memcmp(&velocity, &c->saved.velocities[i], sizeof velocity) != 0)) {
            calls_finding(c, "node %d is not where a state has put it", i);
            return;
        }
    }
}

// ---------------------------------------------------------------------------------------------------- measures

void calls_measure_body(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    const pli_body* body = chosen->body;
    const float energy = pli_body_kinetic_energy(body), stretch = pli_body_max_stretch(body);
    if ((isnan(energy) || energy < 0.0f || isnan(stretch)) && c->bytes.is_tame) {
        calls_finding(c, "energy %g, stretch %g", (double)energy, (double)stretch);
    }
    (void)pli_body_momentum(body);
    (void)pli_body_volume(body);
    (void)pli_body_total_mass(body);
    (void)pli_body_get_bounds(body);
    (void)pli_body_bytes(body);
    (void)pli_body_get_implicit_report(body);
    (void)pli_body_get_self_collision_report(body);
    (void)pli_body_get_self_grids_report(body);
    (void)pli_body_get_self_faces_report(body);
    (void)pli_body_get_tether(body, bytes_index(&c->bytes, pli_body_get_view(body).node_count));
    (void)pli_body_collides_with_bodies(body);
    if (pli_body_get_world(body) != chosen->world->world || pli_body_get_user_data(body) != c) {
        calls_finding(c, "a body does not know its world or its data");
    }
    int crossings = 0;
    pli_transform pose;
    BODY_CALL(c, chosen, pli_body_count_crossings(body, &crossings));
    BODY_CALL(c, chosen, pli_body_get_pose(body, &pose));
    int parts = 0;
    BODY_CALL(c, chosen, pli_body_count_parts(body, &parts));
    if (parts < 0 || parts > pli_body_get_view(body).node_count) { calls_finding(c, "%d parts", parts); }
}
