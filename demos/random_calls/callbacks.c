/* Callbacks of the user, in which anything may be tried. They take no bytes: how often they are called is not for the
   sequence to say. */

#include "calls.h"

#include <stdlib.h>

static uint32_t next_whim(calls* c) {
    c->whim = c->whim * 1664525u + 1013904223u;
    return c->whim >> 8;
}

static bool lies(calls* c, uint32_t one_in) {
    return (c->kinds & RANDOM_CALLS_EXTREMES) != 0 && next_whim(c) % one_in == 0;
}

/* What changes something; not allowed here. */
static pli_status try_change(calls_body* chosen, const calls_rigid* rigid, uint32_t which) {
    pli_body* body = chosen->body;
    pli_world* world = chosen->world->world;
    const pli_vec3 vector = {0.1f, 0.2f, 0.3f};
    pli_mesh* mesh = NULL;
    switch (which % 16) {
    case 0:
        return pli_body_enable_pressure(body, 1.0f);
    case 1:
        return pli_body_enable_aero(body, NULL);
    case 2:
        return pli_body_enable_tethers(body, NULL);
    case 3:
        return pli_body_enable_soft_contacts(body, NULL);
    case 4:
        return pli_body_enable_rigid_contacts(body, NULL);
    case 5:
        return pli_body_enable_pose_matching(body, 0.5f);
    case 6:
        return pli_body_cut_swept(body, vector, pli_vec3_neg(vector), vector, vector, NULL);
    case 7:
        return pli_body_generate_clusters(body, 2, 4, NULL);
    case 8:
        return pli_world_step(world, 0.01f);
    case 9:
        return pli_world_predict(world, 0.01f);
    case 10:
        return pli_body_add_velocity(body, vector);
    case 11:
        return pli_body_set_node_mass(body, 0, 2.0f);
    case 12:
        return pli_mesh_create(chosen->world->home->context, &mesh);
    case 13:
        return pli_world_set_gravity(world, vector);
    case 14:
        return rigid->rigid != NULL ? pli_rigid_set_friction(rigid->rigid, 0.3f) : PLI_ERROR_WRONG_STATE;
    default:
        return pli_body_enable_colored_links(body);
    }
}

void calls_from_callback(calls* c) {
    calls_context* home = c->active;
    if (home == NULL || (c->kinds & RANDOM_CALLS_CALLBACKS) == 0) { return; }
    const uint32_t whim = next_whim(c);
    calls_body* chosen = &c->bodies[whim % CALLS_BODIES];
    const calls_rigid* rigid = &c->rigids[whim / 8 % CALLS_RIGIDS];
    if (whim / 64 % 4 != 0 || chosen->body == NULL || chosen->world->home != home) { return; }
    if (rigid->rigid != NULL && rigid->world->home != home) { return; }
    (void)pli_body_state_hash(chosen->body);
    c->active = NULL; /* no deeper */
    const uint32_t which = next_whim(c);
    if (try_change(chosen, rigid, which) == PLI_OK) {
        calls_finding(c, "change %u was not refused in a callback", (unsigned)(which % 16));
    }
    c->active = home;
}

// --------------------------------------------------------------------------------------------------- functions

void calls_profile(const char* stage, const char* feature, bool begins, void* user) {
    (void)feature;
    (void)begins;
    calls* c = user;
    if (stage == NULL) { calls_finding(c, "a stage without a name"); }
    calls_from_callback(c);
}

static pli_vec3 steer(pli_vec3 axis, void* user) {
    calls* c = user;
    calls_from_callback(c);
    if (lies(c, 8)) { return pli_vec3_make(NAN, 1e30f, 0.0f); }
    return pli_vec3_add(axis, pli_vec3_make(0.0f, 0.01f, 0.02f));
}

static float speed(float present, void* user) {
    calls* c = user;
    calls_from_callback(c);
    if (lies(c, 8)) { return next_whim(c) % 2 == 0 ? 1e8f : INFINITY; }
    return 0.5f * present + 2.0f;
}

pli_joint_controller calls_controller(calls* c) {
    const int which = bytes_below(&c->bytes, 4);
    return (pli_joint_controller){which != 1 ? steer : NULL, which != 2 ? speed : NULL, c};
}

bool calls_cluster_distance(const pli_body* body, pli_cluster_contact* contact, void* user) {
    calls* c = user;
    calls_from_callback(c);
    pli_cluster_view view;
    if (next_whim(c) % 2 == 0 || pli_body_get_cluster(body, contact->cluster, &view) != PLI_OK) { return false; }
    contact->witness = view.frame.origin;
    contact->normal = pli_vec3_make(0.0f, 1.0f, 0.0f);
    contact->distance = 0.01f;
    contact->other_witness = pli_vec3_sub(contact->witness, pli_vec3_scale(contact->normal, contact->distance));
    if (lies(c, 8)) { contact->distance = NAN; }
    if (lies(c, 8)) { contact->normal.x = 1e20f; }
    return true;
}

/* A plane, of which `whim` says the place; a function that gives other values the next time must not do harm. */
float calls_surface(pli_vec3 point, void* user) {
    calls* c = user;
    const uint32_t kept = c->whim;
    calls_from_callback(c);
    if ((kept & 0xe0u) == 0xe0u && lies(c, 4)) { return next_whim(c) % 2 == 0 ? NAN : 1e38f; }
    c->whim = kept;
    const float offset = (float)(kept & 7u) * 0.1f - 0.35f;
    if ((kept & 8u) != 0) { return pli_vec3_length(point) - 0.2f - offset; }
    return (kept & 16u) != 0 ? point.x + 0.3f * point.y - offset : point.z + 0.7f * point.x - offset;
}

// ------------------------------------------------------------------------------------------------------ shapes

typedef struct sphere {
    calls* calls;
    float radius;
    int lie;
} sphere;

static void sphere_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                             pli_vec3* normals) {
    const sphere* self = user;
    calls_from_callback(self->calls);
    for (int i = 0; i < count; ++i) {
        const float length = pli_vec3_length(points[i]);
        distances[i] = length - self->radius;
        if (self->lie == 1) { distances[i] = NAN; }
        if (self->lie == 2) { distances[i] = -1e30f; }
        normals[i] = length > 0.0f ? pli_vec3_scale(points[i], 1.0f / length) : pli_vec3_make(0.0f, 1.0f, 0.0f);
        if (self->lie == 3) { normals[i] = pli_vec3_make(0.0f, 0.0f, 0.0f); }
        if (self->lie == 4) { normals[i].x = NAN; }
    }
    (void)max_distance;
}

static pli_bounds sphere_bounds(const void* user) {
    const sphere* self = user;
    calls_from_callback(self->calls);
    const float r = self->lie == 5 ? INFINITY : self->lie == 6 ? NAN : self->radius;
    return (pli_bounds){{-r, -r, -r}, {r, r, r}};
}

static pli_vec3 sphere_support(const void* user, pli_vec3 direction) {
    const sphere* self = user;
    calls_from_callback(self->calls);
    return pli_vec3_scale(direction, self->lie == 7 ? NAN : self->radius);
}

static void sphere_destroy(void* user) {
    sphere* self = user;
    --self->calls->custom_shapes;
    free(self);
}

pli_shape_def calls_custom_shape(calls* c) {
    pli_shape_def def = pli_shape_def_default();
    const float radius = bytes_float(&c->bytes, 0.2f, 0.8f), border = bytes_float(&c->bytes, 0.0f, 0.1f);
    const int choice = bytes_next(&c->bytes);
    sphere* self = malloc(sizeof *self);
    if (self == NULL) { return def; }
    *self = (sphere){c, radius, c->bytes.is_tame || choice < 128 ? 0 : choice % 8};
    ++c->custom_shapes;
    def.user = self;
    def.distances = sphere_distances;
    def.bounds = sphere_bounds;
    def.support = choice % 16 < 8 ? sphere_support : NULL;
    def.radius = border;
    def.destroy = sphere_destroy;
    return def;
}
