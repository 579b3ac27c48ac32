#ifndef SELF_CLOTH_H
#define SELF_CLOTH_H

/* A world with a floor, and a sheet that stands on its edge above it and falls in folds. */

#include "check.h"
#include "failing_allocator.h"

#include <pliant/pliant.h>

typedef struct self_scene {
    pli_context* context;
    pli_world* world;
    pli_shape* shape; /* floor or ball */
} self_scene;

static inline int self_scene_setup(void** state) {
    static self_scene scene;
    scene = (self_scene){0};
    *state = &scene;
    if (pli_context_create(NULL, &scene.context) != PLI_OK) { return -1; }
    return pli_world_create(scene.context, NULL, &scene.world) == PLI_OK ? 0 : -1;
}

static inline int self_scene_teardown(void** state) {
    self_scene* scene = (self_scene*)*state;
    pli_world_destroy(scene->world);
    if (scene->shape != NULL) { pli_shape_release(scene->shape); }
    const bool is_empty = pli_context_allocated_bytes(scene->context) == 0;
    pli_context_destroy(scene->context);
    return is_empty ? 0 : -1;
}

static inline void self_scene_add_shape(self_scene* scene, pli_shape* shape, pli_vec3 origin) {
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 1;
    def.shapes = &shape;
    def.friction = 1;
    def.state.pose.origin = origin;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(scene->world, &def, &rigid), PLI_OK);
    scene->shape = shape;
}

static inline void self_scene_add_floor(self_scene* scene) {
    pli_shape* floor = NULL;
    assert_int_equal(pli_shape_create_plane(scene->context, pli_vec3_make(0, 1, 0), 0, &floor), PLI_OK);
    self_scene_add_shape(scene, floor, pli_vec3_make(0, 0, 0));
}

/* nodes x nodes, `spacing` apart; standing sheets are a little slanted, so that they buckle. */
static inline pli_mesh* self_sheet_mesh(pli_context* context, int nodes, float spacing, pli_vec3 centre,
                                        bool is_standing) {
    const float half = 0.5f * spacing * (float)(nodes - 1);
    const pli_vec3 across = pli_vec3_make(half, 0, 0);
    const pli_vec3 along =
        is_standing ? pli_vec3_make(0.03f * half, 0.9995f * half, 0.01f * half) : pli_vec3_make(0, 0, half);
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_sub(pli_vec3_sub(centre, across), along);
    def.corner_10 = pli_vec3_sub(pli_vec3_add(centre, across), along);
    def.corner_01 = pli_vec3_add(pli_vec3_sub(centre, across), along);
    def.corner_11 = pli_vec3_add(pli_vec3_add(centre, across), along);
    def.columns = def.rows = nodes;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.2f), PLI_OK);
    return mesh;
}

static inline pli_body* self_make_body(self_scene* scene, pli_mesh* mesh, float margin, float velocity_damping) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = velocity_damping;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(scene->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = 0.5f;
    contacts.static_hardness = 1.0f;
    assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);
    return body;
}

static inline double self_distance(const pli_body_view* view, int a, int b) {
    const pli_vec4 p = view->positions[a], q = view->positions[b];
    const double d[3] = {(double)p.x - (double)q.x, (double)p.y - (double)q.y, (double)p.z - (double)q.z};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Of unlinked nodes, by looking at all pairs: smallest distance, and how many are nearer than `limit`. */
static inline double self_count_near(const pli_body* body, double limit, int* near) {
    const pli_body_view view = pli_body_get_view(body);
    const size_t count = (size_t)view.node_count;
    uint8_t* linked = (uint8_t*)calloc(count * count, 1);
    assert_non_null(linked);
    for (int i = 0; i < view.link_count; ++i) {
        const int* nodes = view.link_nodes + i * view.link_node_stride;
        linked[(size_t)nodes[0] * count + (size_t)nodes[1]] = linked[(size_t)nodes[1] * count + (size_t)nodes[0]] = 1;
    }
    double smallest = 1e30;
    for (int a = 0; a < view.node_count; ++a) {
        for (int b = a + 1; b < view.node_count; ++b) {
            if (linked[(size_t)a * count + (size_t)b]) { continue; }
            const double distance = self_distance(&view, a, b);
            smallest = fmin(smallest, distance);
            if (near != NULL) { *near += distance < limit; }
        }
    }
    free(linked);
    return smallest;
}

static inline double self_smallest_distance(const pli_body* body) {
    return self_count_near(body, 0.0, NULL);
}

static inline double self_largest_speed(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    double largest = 0.0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 v = view.velocities[i];
        largest =
            fmax(largest, sqrt((double)v.x * (double)v.x + (double)v.y * (double)v.y + (double)v.z * (double)v.z));
    }
    return largest;
}

static inline void self_steps(self_scene* scene, int steps) {
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(scene->world, 1.0f / 60.0f), PLI_OK);
    }
}

/* Loose nodes, no gravity. */
/* Each step is one iteration. */
static inline pli_body* self_make_loose(self_scene* scene, int count, const pli_vec3* positions, const float* masses) {
    assert_int_equal(pli_world_set_gravity(scene->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(scene->context, &mesh), PLI_OK);
    for (int i = 0; i < count; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, positions[i], masses[i], NULL), PLI_OK);
    }
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 1;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(scene->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static inline pli_self_collision_def self_make_def(float thickness, float friction, float speed_limit_ratio) {
    pli_self_collision_def def = pli_self_collision_def_default();
    def.thickness = thickness;
    def.friction = friction;
    def.speed_limit_ratio = speed_limit_ratio;
    return def;
}

#endif
