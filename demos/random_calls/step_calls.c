/* Steps, whole and in parts, with what can be read after them; rays. */

#include "calls.h"

#include <pliant/bullet_reference.h>

static float some_dt(calls* c) {
    return bytes_seldom(&c->bytes, 64) ? bytes_float(&c->bytes, 0.0005f, 0.1f) : 1.0f / 60.0f;
}

static void read_events(calls* c, const calls_world* world) {
    int count = 0;
    const pli_event* events = pli_world_get_events(world->world, &count);
    for (int i = 0; i < count; ++i) {
        c->report->events += events[i].kind < PLI_EVENT_BODY_ASLEEP;
        if (events[i].body != NULL && pli_body_get_world(events[i].body) != world->world) {
            calls_finding(c, "an event of a body elsewhere");
        }
    }
}

static void check_node(calls* c, const pli_body* body, int node) {
    if (node < 0 || node >= pli_body_get_view(body).node_count) { calls_finding(c, "a contact of node %d", node); }
}

static void read_contacts(calls* c, const pli_body* body) {
    enum { MOST = 16 };
    pli_rigid_contact at_rigids[MOST];
    pli_rigid_face_contact of_faces[MOST];
    pli_soft_contact at_bodies[MOST];
    pli_cluster_contact of_clusters[MOST];
    const int counts[4] = {
        pli_body_get_rigid_contacts(body, MOST, at_rigids), pli_body_get_rigid_face_contacts(body, MOST, of_faces),
        pli_body_get_soft_contacts(body, MOST, at_bodies), pli_body_get_cluster_contacts(body, MOST, of_clusters)};
    for (int i = 0; i < MOST; ++i) {
        if (i < counts[0]) { check_node(c, body, at_rigids[i].node); }
        if (i < counts[2]) { check_node(c, body, at_bodies[i].node); }
        if (i < counts[1] && of_faces[i].face >= pli_body_get_view(body).face_count) {
            calls_finding(c, "a contact of face %d", of_faces[i].face);
        }
        if (i < counts[3] && of_clusters[i].cluster >= pli_body_cluster_count(body)) {
            calls_finding(c, "a contact of cluster %d", of_clusters[i].cluster);
        }
    }
}

static void read_all_contacts(calls* c, const calls_world* world) {
    for (int i = 0; i < pli_world_body_count(world->world); ++i) {
        read_contacts(c, pli_world_get_body(world->world, i));
    }
}

void calls_step(calls* c) {
    const calls_world* world = calls_any_world(c);
    if (world == NULL) { return; }
    const float dt = some_dt(c);
    const int count = 1 + bytes_next(&c->bytes) % 3;
    for (int i = 0; i < count && !calls_have_finding(c); ++i) {
        c->report->steps += STEP_CALL(c, world->home, pli_world_step(world->world, dt)) == PLI_OK;
        read_events(c, world);
    }
    read_all_contacts(c, world);
}

// ------------------------------------------------------------------------------------------------------ in parts

static void turn_around(calls* c, const calls_body* chosen) {
    enum { MOST = 64 };
    int order[MOST];
    pli_body* body = chosen->body;
    calls_context* home = chosen->world->home;
    const int kind = bytes_below(&c->bytes, 3);
    const int count = kind == 0   ? pli_body_get_rigid_contacts(body, 0, NULL)
                      : kind == 1 ? pli_body_get_soft_contacts(body, 0, NULL)
                                  : pli_body_get_cluster_contacts(body, 0, NULL);
    if (count > MOST) { return; }
    for (int i = 0; i < count; ++i) {
        order[i] = count - 1 - i;
    }
    if (count > 0 && bytes_seldom(&c->bytes, 64)) { order[0] = bytes_index(&c->bytes, count); }
    if (kind == 0) { CALL(c, home, pli_body_reorder_rigid_contacts(body, order, count)); }
    if (kind == 1) { CALL(c, home, pli_body_reorder_soft_contacts(body, order, count)); }
    if (kind == 2) { CALL(c, home, pli_body_reorder_cluster_contacts(body, order, count)); }
}

void calls_step_in_parts(calls* c) {
    const calls_world* world = calls_any_world(c);
    const calls_body* a = &c->bodies[bytes_below(&c->bytes, CALLS_BODIES)];
    const calls_body* b = &c->bodies[bytes_below(&c->bytes, CALLS_BODIES)];
    const calls_rigid* rigid = &c->rigids[bytes_below(&c->bytes, CALLS_RIGIDS)];
    if (world == NULL) { return; }
    const int parts = bytes_next(&c->bytes);
    if (calls_is_stepping(world) || parts % 32 == 0) {
        if ((parts & 1) != 0 && a->body != NULL && rigid->rigid != NULL) {
            STEP_CALL(c, world->home, pli_world_collide_rigid(world->world, a->body, rigid->rigid));
        }
        if ((parts & 32) != 0 && b->body != NULL && rigid->rigid != NULL) {
            const pli_rigid_pair pairs[3] = {{b->body, rigid->rigid}, {a->body, rigid->rigid}, {b->body, rigid->rigid}};
            STEP_CALL(c, world->home, pli_world_collide_rigids(world->world, pairs, parts % 4));
        }
        if ((parts & 2) != 0 && a->body != NULL && b->body != NULL) {
            STEP_CALL(c, world->home, pli_world_collide_bodies(world->world, a->body, b->body));
        }
        if ((parts & 64) != 0 && a->body != NULL && b->body != NULL) {
            const pli_body_pair pairs[2] = {{a->body, b->body}, {b->body, a->body}};
            STEP_CALL(c, world->home, pli_world_collide_body_pairs(world->world, pairs, parts % 3));
        }
        if ((parts & 12) == 12 && a->body != NULL) { turn_around(c, a); }
        if ((parts & 16) != 0) {
            c->report->steps += STEP_CALL(c, world->home, pli_world_solve(world->world)) == PLI_OK;
            read_events(c, world);
        }
    } else {
        const float dt = some_dt(c);
        STEP_CALL(c, world->home, pli_world_predict(world->world, dt));
    }
}

// -------------------------------------------------------------------------------------------------------- worlds

void calls_set_up_world(calls* c) {
    const calls_world* world = calls_any_world(c);
    if (world == NULL) { return; }
    if (bytes_flag(&c->bytes)) {
        const pli_vec3 gravity = bytes_vec3(&c->bytes, -20.0f, 20.0f);
        CALL(c, world->home, pli_world_set_gravity(world->world, gravity));
    } else {
        pli_profile_fn* profile = bytes_below(&c->bytes, 4) > 0 ? calls_profile : NULL;
        CALL(c, world->home, pli_world_set_profile(world->world, profile, c));
    }
    if (pli_world_get_context(world->world) != world->home->context || pli_world_get_user_data(world->world) != c) {
        calls_finding(c, "a world does not know its context or its data");
    }
}

void calls_cast_ray(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_ray_def def = pli_ray_def_default();
    def.from = bytes_vec3(&c->bytes, -2.0f, 2.0f);
    def.to = bytes_vec3(&c->bytes, -2.0f, 2.0f);
    def.targets = bytes_below(&c->bytes, 20);
    def.radius = bytes_float(&c->bytes, 0.0f, 0.2f);
    pli_ray_hit hit;
    if (CALL(c, chosen->world->home, pli_body_cast_ray(chosen->body, &def, &hit)) != PLI_OK) { return; }
    if (!(hit.fraction >= 0.0f && hit.fraction <= 1.0f)) {
        calls_finding(c, "a ray hits at %g of its length", (double)hit.fraction);
    }
    if (hit.kind != PLI_FEATURE_NONE) { check_node(c, chosen->body, hit.nearest_node); }
}
