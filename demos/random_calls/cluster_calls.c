/* Clusters, their contacts, and joints. */

#include "calls.h"

#define TRY(call) CALL(c, home, call)

static float a_share(calls* c) {
    return bytes_float(&c->bytes, 0.0f, 1.0f);
}

static void set_cluster(calls* c, pli_body* body, calls_context* home) {
    const int cluster = bytes_index(&c->bytes, pli_body_cluster_count(body));
    pli_cluster_settings settings;
    if (TRY(pli_body_get_cluster_settings(body, cluster, &settings)) != PLI_OK) { return; }
    settings.matching = a_share(c);
    settings.node_damping = a_share(c);
    settings.linear_damping = a_share(c);
    settings.angular_damping = a_share(c);
    settings.collides = bytes_below(&c->bytes, 4) > 0;
    settings.max_self_impulse = bytes_float(&c->bytes, 0.0f, 100.0f);
    settings.self_impulse_factor = a_share(c);
    TRY(pli_body_set_cluster_settings(body, cluster, &settings));
    pli_cluster_view view;
    TRY(pli_body_get_cluster(body, cluster, &view));
}

static void add_cluster(calls* c, pli_body* body, calls_context* home) {
    enum { MOST = 8 };
    int nodes[MOST], cluster = 0;
    const int count = bytes_small(&c->bytes, 1, MOST), node_count = pli_body_get_view(body).node_count;
    const int first = bytes_index(&c->bytes, node_count);
    for (int i = 0; i < count; ++i) {
        nodes[i] = bytes_seldom(&c->bytes, 32) ? bytes_index(&c->bytes, node_count) : (first + i) % node_count;
    }
    TRY(pli_body_add_cluster(body, nodes, count, &cluster));
}

static void enable_contacts(calls* c, pli_body* body, calls_context* home) {
    pli_cluster_contacts_def def = pli_cluster_contacts_def_default();
    const int flags = bytes_next(&c->bytes);
    def.with_rigids = flags % 8 > 0;
    def.with_bodies = flags / 8 % 4 > 0;
    def.with_self = (flags & 32) != 0;
    def.accurate_penetration = (flags & 64) != 0;
    def.disable_contact_cache = (flags & 128) != 0;
    if (bytes_flag(&c->bytes)) {
        def.friction = a_share(c);
        def.dynamic_hardness = a_share(c);
        def.static_hardness = a_share(c);
        def.soft_hardness = a_share(c);
        def.dynamic_split = a_share(c);
        def.static_split = a_share(c);
        def.soft_split = a_share(c);
    }
    if (bytes_seldom(&c->bytes, 32)) {
        def.distance = calls_cluster_distance;
        def.distance_user = c;
    }
    TRY(pli_body_enable_cluster_contacts(body, &def));
}

void calls_change_clusters(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_body* body = chosen->body;
    calls_context* home = chosen->world->home;
    pli_clusters_def def = pli_clusters_def_default();
    int made = 0;
    switch (bytes_below(&c->bytes, 16)) {
    case 0:
        def.iterations = bytes_small(&c->bytes, 1, 5);
        def.reference_mode = bytes_flag(&c->bytes);
        TRY(pli_body_enable_clusters(body, &def));
        break;
    case 1:
        CALL(c, home, pli_body_disable_clusters(body));
        break;
    case 2:
    case 3:
    case 4:
        TRY(pli_body_generate_clusters(body, bytes_count(&c->bytes, 1, 6), bytes_small(&c->bytes, 0, 8), &made));
        break;
    case 5:
        if (pli_body_get_view(body).face_count + pli_body_get_view(body).tetra_count > 100) { return; }
        TRY(pli_body_generate_clusters_from_elements(body, &made));
        break;
    case 6:
    case 7:
        add_cluster(c, body, home);
        break;
    case 8:
        TRY(pli_body_remove_clusters(body));
        break;
    case 9:
    case 10:
        set_cluster(c, body, home);
        break;
    case 11:
        TRY(pli_body_reset_clusters(body));
        break;
    default:
        enable_contacts(c, body, home);
        break;
    }
}

// ------------------------------------------------------------------------------------------------------ joints

static pli_joint_end some_end(calls* c) {
    pli_joint_end end = {0};
    const calls_body* body = &c->bodies[bytes_below(&c->bytes, CALLS_BODIES)];
    const calls_rigid* rigid = &c->rigids[bytes_below(&c->bytes, CALLS_RIGIDS)];
    const int kind = bytes_below(&c->bytes, 8);
    if (kind < 3 || kind == 7) { end.body = body->body; }
    if (kind >= 3 && kind != 6) { end.rigid = rigid->rigid; }
    if (end.body != NULL) { end.cluster = bytes_index(&c->bytes, pli_body_cluster_count(end.body)); }
    return end;
}

static pli_joint_softness some_softness(calls* c) {
    pli_joint_softness softness = {1.0f, 1.0f, 1.0f};
    if (bytes_seldom(&c->bytes, 96)) {
        softness.error_reduction = a_share(c);
        softness.velocity_factor = a_share(c);
        softness.split = a_share(c);
    }
    return softness;
}

void calls_add_joint(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_body* body = chosen->body;
    calls_context* home = chosen->world->home;
    pli_joint_id* joint = &c->joints[bytes_below(&c->bytes, CALLS_IDS)];
    if (pli_body_cluster_count(body) == 0) { TRY(pli_body_generate_clusters(body, 1, 4, NULL)); }
    const int cluster = bytes_index(&c->bytes, pli_body_cluster_count(body));
    const int kind = bytes_below(&c->bytes, 8);
    if (kind < 3) {
        pli_linear_joint_def def = pli_linear_joint_def_default();
        def.cluster = cluster;
        def.other = some_end(c);
        def.position = bytes_vec3(&c->bytes, -1.0f, 1.0f);
        def.softness = some_softness(c);
        TRY(pli_body_add_linear_joint(body, &def, joint));
    } else if (kind < 7) {
        pli_angular_joint_def def = pli_angular_joint_def_default();
        def.cluster = cluster;
        def.other = some_end(c);
        def.axis = bytes_vec3(&c->bytes, -1.0f, 1.0f);
        def.softness = some_softness(c);
        if (bytes_flag(&c->bytes)) { def.controller = calls_controller(c); }
        TRY(pli_body_add_angular_joint(body, &def, joint));
    } else {
        TRY(pli_body_remove_joint(body, *joint));
    }
}
