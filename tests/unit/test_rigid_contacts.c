/* Contacts of nodes with rigid bodies: balance of momentum, the friction regimes, rest, life of contacts, errors. */

#include "failing_allocator.h"

#include "pliant/bullet_reference.h"
#include "pliant/contact.h"
#include "pliant/generate.h"
#include "pliant/world.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const float dt = 1.0f / 60.0f;

typedef struct fixture {
    pli_context* context;
    pli_world* world;
    pli_shape* plane;  /* y <= 0 */
    pli_shape* sphere; /* radius 1 */
} fixture;

static int make_fixture(void** state, bool reference_mode) {
    fixture* f = calloc(1, sizeof *f);
    if (f == NULL || pli_context_create(NULL, &f->context) != PLI_OK) { return -1; }
    *state = f;
    pli_world_def def = pli_world_def_default();
    def.gravity = pli_vec3_make(0, 0, 0);
    def.reference_mode = reference_mode;
    if (pli_world_create(f->context, &def, &f->world) != PLI_OK) { return -1; }
    if (pli_shape_create_plane(f->context, pli_vec3_make(0, 1, 0), 0, &f->plane) != PLI_OK) { return -1; }
    return pli_shape_create_sphere(f->context, 1, &f->sphere) == PLI_OK ? 0 : -1;
}

static int setup(void** state) {
    return make_fixture(state, false);
}
static int setup_reference(void** state) {
    return make_fixture(state, true);
}

static int teardown(void** state) {
    fixture* f = *state;
    pli_world_destroy(f->world);
    pli_shape_release(f->plane);
    pli_shape_release(f->sphere);
    const size_t left = pli_context_allocated_bytes(f->context);
    pli_context_destroy(f->context);
    free(f);
    return left == 0 ? 0 : -1;
}

/* A body of loose nodes. */
static pli_body* make_nodes(fixture* f, int count, const pli_vec3* positions, float mass, float margin, float friction,
                            float hardness) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    for (int i = 0; i < count; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, positions[i], mass, NULL), PLI_OK);
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = friction;
    contacts.static_hardness = hardness;
    assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);
    return body;
}

static pli_rigid* make_rigid(fixture* f, pli_shape* shape, float mass, pli_vec3 velocity) {
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 1;
    def.shapes = &shape;
    def.friction = 1;
    if (mass > 0) {
        def.kind = PLI_RIGID_DYNAMIC;
        def.state.inverse_mass = 1 / mass;
        def.state.linear_velocity = velocity;
        const float i = 2.5f / mass; /* sphere of radius 1 */
        def.state.inverse_inertia_world = (pli_mat3){{{i, 0, 0}, {0, i, 0}, {0, 0, i}}};
    }
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(f->world, &def, &rigid), PLI_OK);
    return rigid;
}

static pli_vec3 velocity_of(const pli_body* body, int node) {
    const pli_vec4 v = pli_body_get_view(body).velocities[node];
    return pli_vec3_make(v.x, v.y, v.z);
}
static pli_vec3 position_of(const pli_body* body, int node) {
    const pli_vec4 v = pli_body_get_view(body).positions[node];
    return pli_vec3_make(v.x, v.y, v.z);
}

static void test_rigid_contacts_keep_momentum(void** state) {
    fixture* f = *state;
    const pli_vec3 positions[3] = {{0.1f, 1.3f, 0}, {-0.6f, 1.1f, 0.3f}, {0.2f, 1.0f, 0.9f}};
    pli_body* body = make_nodes(f, 3, positions, 0.5f, 0.25f, 0.3f, 1);
    pli_rigid* rigid = make_rigid(f, f->sphere, 2, pli_vec3_make(0, 3, 0));
    assert_int_equal(pli_body_add_velocity(body, pli_vec3_make(1, -4, 0.5f)), PLI_OK);
    bool touched = false;
    for (int i = 0; i < 30; ++i) {
        const pli_rigid_state before = pli_rigid_get_state(rigid);
        pli_vec3 linear = pli_vec3_add(pli_body_momentum(body), pli_vec3_scale(before.linear_velocity, 2));
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        const pli_rigid_state after = pli_rigid_get_state(rigid);
        const pli_vec3 change =
            pli_vec3_sub(pli_vec3_add(pli_body_momentum(body), pli_vec3_scale(after.linear_velocity, 2)), linear);
        check_at_most(pli_vec3_length(change), 1e-5);
        touched = touched || pli_rigid_was_touched(rigid);
        assert_int_equal(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), dt), PLI_OK);
    }
    assert_true(touched);
    check_at_most(pli_rigid_get_state(rigid).linear_velocity.y, 2.0); /* it was 3 */
    assert_true(pli_vec3_length(pli_rigid_get_state(rigid).angular_velocity) > 0.1f);
}

/* A pinned node pushes a dynamic body and stays where it is. */
static void test_rigid_contacts_pinned_node_stops_a_rigid_body(void** state) {
    fixture* f = *state;
    const pli_vec3 position = {0, 1.2f, 0};
    pli_body* body = make_nodes(f, 1, &position, 0, 0.25f, 0.3f, 1);
    pli_rigid* rigid = make_rigid(f, f->sphere, 2, pli_vec3_make(0, 5, 0));
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 1);
    check_at_most(pli_rigid_get_state(rigid).linear_velocity.y, 1e-5);
    check_near(pli_vec3_length(pli_vec3_sub(position_of(body, 0), position)), 0, 0);
    /* Against what does not move either nothing happens. */
    pli_rigid_destroy(rigid);
    make_rigid(f, f->sphere, 0, pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 0);
}

/* Both nodes come down on a plane with 1 m/s, node 0 slides with 0.2 m/s and sticks, node 1 with 2. Friction 0.3. */
static pli_body* slide_on_plane(fixture* f, float height) {
    const pli_vec3 positions[2] = {{0, height, 0}, {5, height, 0}};
    pli_body* body = make_nodes(f, 2, positions, 1, 0.1f, 0.3f, 1);
    make_rigid(f, f->plane, 0, pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_body_set_node_velocity(body, 0, pli_vec3_make(0.2f, -1, 0)), PLI_OK);
    assert_int_equal(pli_body_set_node_velocity(body, 1, pli_vec3_make(2, -1, 0)), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    check_near(velocity_of(body, 0).x, 0, 1e-6);
    return body;
}

/* Being stopped takes 0.3 of it off the sliding at most. */
static void test_rigid_contacts_coulomb_friction(void** state) {
    pli_body* body = slide_on_plane(*state, 0.1f);
    check_near(velocity_of(body, 1).x, 1.7, 2e-5);
    check_near(position_of(body, 0).y, 0.1, 1e-6);
    check_near(position_of(body, 1).y, 0.1, 1e-6);
}

/* In reference mode a share of 0.3 is taken off. */
static void test_rigid_contacts_friction_regimes(void** state) {
    pli_body* body = slide_on_plane(*state, 0.05f);
    check_near(velocity_of(body, 1).x, 1.4, 2e-5);
    /* As in Bullet the motion into the plane is taken back and the predicted penetration removed on top of that. */
    check_near(position_of(body, 0).y, 0.05 + (0.1 - (0.05 - 1.0 / 60)), 1e-6);
    check_near(position_of(body, 1).y, 0.05 + (0.1 - (0.05 - 1.0 / 60)), 1e-6);
    pli_rigid_contact contacts[2];
    assert_int_equal(pli_body_get_rigid_contacts(body, 2, contacts), 2);
    assert_int_equal(contacts[0].node, 0);
    assert_int_equal(contacts[1].node, 1);
    check_near(contacts[0].normal.y, 1, 0);
    check_near(contacts[0].distance, 0.05 - 1.0 / 60 - 0.1, 1e-7);
}

static void test_rigid_contacts_rest_on_a_plane(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, -10, 0)), PLI_OK);
    pli_vec3 positions[100];
    for (int i = 0; i < 100; ++i) {
        positions[i] = pli_vec3_make((float)(i % 10), 1, (float)(i / 10));
    }
    pli_body* body = make_nodes(f, 100, positions, 1, 0.25f, 0.2f, 0.1f);
    make_rigid(f, f->plane, 0, pli_vec3_make(0, 0, 0));
    for (int i = 0; i < 300; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    }
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 100);
    for (int i = 0; i < 100; ++i) {
        check_near(position_of(body, i).y, 0.25, 1e-5);
        check_near(position_of(body, i).x, positions[i].x, 0);
    }
    /* A settled step allocates nothing. */
    const uint64_t allocations = pli_context_allocation_count(f->context);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    }
    check_near(pli_context_allocation_count(f->context), allocations, 0);
}

/* Two nodes on a rough plane, the link between them too short by a tenth: it pulls with less than friction holds, as
   contacts have the last word. */
static void test_rigid_contacts_hold_against_links(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, -10, 0)), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(0, 0.25f, 0), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(1, 0.25f, 0), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_link(mesh, 0, 1, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_set_material(mesh, 0, &(pli_material){.linear_stiffness = 0.0025f}), PLI_OK);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_set_rest_length(body, 0, 0.9f), PLI_OK);
    make_rigid(f, f->plane, 0, pli_vec3_make(0, 0, 0));
    const double lengths[2] = {0.9, 1.0}, tolerances[2] = {1e-3, 1e-6};
    for (int is_rough = 0; is_rough < 2; ++is_rough) {
        pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        contacts.friction = (float)is_rough;
        assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);
        const pli_vec3 places[2] = {pli_vec3_make(0, 0.25f, 0), pli_vec3_make(1, 0.25f, 0)};
        assert_int_equal(pli_body_set_state(body, places, NULL), PLI_OK);
        for (int i = 0; i < 300; ++i) {
            assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        }
        const pli_vec3 apart = pli_vec3_sub(position_of(body, 1), position_of(body, 0));
        check_near(pli_vec3_length(apart), lengths[is_rough], tolerances[is_rough]);
    }
}

static void test_rigid_contacts_shape_poses_and_kinematic_drag(void** state) {
    fixture* f = *state;
    const pli_vec3 positions[2] = {{3, 1.1f, 0}, {-3, 0, 1.1f}};
    pli_body* body = make_nodes(f, 2, positions, 1, 0.25f, 1.0f, 1);
    pli_shape* shapes[2] = {f->sphere, f->sphere};
    pli_transform poses[2] = {pli_transform_identity(), pli_transform_identity()};
    poses[0].origin.x = -3;
    poses[1].origin.x = 3;
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_KINEMATIC;
    def.state.linear_velocity = pli_vec3_make(0, 0, 0.6f);
    def.shape_count = 2;
    def.shapes = shapes;
    def.shape_poses = poses;
    def.friction = 1;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(f->world, &def, &rigid), PLI_OK);
    /* Friction takes a push; this one is worth 1 m/s. */
    assert_int_equal(pli_body_set_node_velocity(body, 0, pli_vec3_make(0, -1, 0)), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    pli_rigid_contact contacts[2];
    assert_int_equal(pli_body_get_rigid_contacts(body, 2, contacts), 2);
    /* Shape by shape. */
    assert_int_equal(contacts[0].shape, 0);
    assert_int_equal(contacts[0].node, 1);
    assert_int_equal(contacts[1].shape, 1);
    assert_int_equal(contacts[1].node, 0);
    check_near(contacts[1].normal.y, 1, 1e-6);
    /* The node on top is carried along by full friction; the kinematic body itself is not slowed down. */
    check_near(velocity_of(body, 0).z, 0.6, 1e-5);
    check_near(pli_rigid_get_state(rigid).linear_velocity.z, 0.6f, 0);
}

/* A node that has sunk deep into an open floor, but not through its thickness, comes out again. */
static void test_rigid_contacts_behind_an_open_floor(void** state) {
    fixture* f = *state;
    const pli_vec3 positions[2] = {{0.1f, -0.4f, 0.2f}, {0.1f, -0.6f, 0.2f}};
    pli_body* body = make_nodes(f, 2, positions, 1, 0.05f, 0.2f, 1);
    const pli_vec3 points[3] = {{0, 0, 3}, {3, 0, -3}, {-3, 0, -3}};
    const int triangle[3] = {0, 1, 2};
    pli_shape* floor = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(f->context, 3, points, 1, triangle, 0.5f, &floor), PLI_OK);
    make_rigid(f, floor, 0, pli_vec3_make(0, 0, 0));
    pli_shape_release(floor);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    check_near(position_of(body, 0).y, -0.4 + 1.0 / 60, 1e-6); /* at 1 m/s */
    check_near(position_of(body, 1).y, -0.6, 1e-6);
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    }
    check_near(position_of(body, 0).y, 0.05, 1e-6);
    check_near(position_of(body, 1).y, -0.6, 1e-6);
}

static void nan_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    (void)user;
    (void)points;
    (void)max_distance;
    for (int i = 0; i < count; ++i) {
        distances[i] = i % 2 == 0 ? NAN : -INFINITY;
        normals[i] = pli_vec3_make(NAN, 0, 0);
    }
}
static pli_bounds big_bounds(const void* user) {
    (void)user;
    return (pli_bounds){{-9, -9, -9}, {9, 9, 9}};
}

static void test_rigid_contacts_survive_a_broken_shape(void** state) {
    fixture* f = *state;
    const pli_vec3 positions[2] = {{0, 0, 0}, {1, 0, 0}};
    pli_body* body = make_nodes(f, 2, positions, 1, 0.25f, 1.0f, 1);
    pli_shape_def def = pli_shape_def_default();
    def.distances = nan_distances;
    def.bounds = big_bounds;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create(f->context, &def, &shape), PLI_OK);
    make_rigid(f, shape, 0, pli_vec3_make(0, 0, 0));
    pli_shape_release(shape);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 0);
}

static void test_rigid_contacts_go_with_their_rigid_body(void** state) {
    fixture* f = *state;
    const pli_vec3 position = {0, 1.1f, 0};
    pli_body* body = make_nodes(f, 1, &position, 1, 0.25f, 1.0f, 1);
    pli_rigid* rigid = make_rigid(f, f->sphere, 1, pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_rigid_set_present(rigid, false), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 0);
    assert_int_equal(pli_rigid_set_present(rigid, true), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 1);
    pli_rigid_destroy(rigid);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 0);
    int count = 0;
    pli_world_get_events(f->world, &count);
    assert_int_equal(count, 0); /* contacts are no anchors */
    rigid = make_rigid(f, f->sphere, 1, pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 1);
    assert_int_equal(pli_body_disable_rigid_contacts(body), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 0);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
}

static void check_refused(const fixture* f, pli_status got, pli_status expected, const char* message) {
    assert_int_equal(got, expected);
    if (strstr(pli_last_error(f->context), message) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", pli_last_error(f->context), message);
    }
}

static void test_rigid_contacts_refuse_bad_input(void** state) {
    fixture* f = *state;
    const pli_vec3 positions[3] = {{0, 1.1f, 0}, {1.1f, 0, 0}, {0, 0, 1.1f}};
    pli_body* body = make_nodes(f, 3, positions, 1, 0.25f, 1.0f, 1);
    pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_contacts(NULL, &def), PLI_ERROR_NULL_ARGUMENT);
    def.friction = -1;
    check_refused(f, pli_body_enable_rigid_contacts(body, &def), PLI_ERROR_INVALID_VALUE, "friction is -1");
    def = pli_rigid_contacts_def_default();
    def.dynamic_hardness = 1.5f;
    check_refused(f, pli_body_enable_rigid_contacts(body, &def), PLI_ERROR_INVALID_VALUE, "dynamic_hardness is 1.5");
    def = pli_rigid_contacts_def_default();
    def.static_hardness = -0.5f;
    check_refused(f, pli_body_enable_rigid_contacts(body, &def), PLI_ERROR_INVALID_VALUE, "static_hardness is -0.5");
    def = pli_rigid_contacts_def_default();
    def.static_hardness = NAN;
    check_refused(f, pli_body_enable_rigid_contacts(body, &def), PLI_ERROR_NOT_FINITE, "static_hardness is nan");
    def.cookie = 0;
    check_refused(f, pli_body_enable_rigid_contacts(body, &def), PLI_ERROR_INVALID_DEF, "default");
    assert_int_equal(pli_body_get_rigid_contacts(NULL, 3, NULL), 0);
    assert_int_equal(pli_body_disable_rigid_contacts(NULL), PLI_ERROR_NULL_ARGUMENT);

    pli_rigid* rigid = make_rigid(f, f->sphere, 0, pli_vec3_make(0, 0, 0));
    const int order[3] = {2, 0, 1}, twice[3] = {0, 0, 1}, out[3] = {0, 1, 3};
    check_refused(f, pli_body_reorder_rigid_contacts(body, order, 3), PLI_ERROR_WRONG_STATE, "between");
    assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
    assert_int_equal(pli_world_collide_rigid(f->world, body, rigid), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 3);
    check_refused(f, pli_body_reorder_rigid_contacts(body, order, 2), PLI_ERROR_INVALID_VALUE, "count is 2");
    check_refused(f, pli_body_reorder_rigid_contacts(body, NULL, 3), PLI_ERROR_NULL_ARGUMENT, "order");
    check_refused(f, pli_body_reorder_rigid_contacts(body, twice, 3), PLI_ERROR_INVALID_VALUE, "second time");
    check_refused(f, pli_body_reorder_rigid_contacts(body, out, 3), PLI_ERROR_INDEX_OUT_OF_RANGE, "order[2] is 3");
    assert_int_equal(pli_body_reorder_rigid_contacts(body, order, 3), PLI_OK);
    pli_rigid_contact contacts[3];
    pli_body_get_rigid_contacts(body, 3, contacts);
    assert_int_equal(contacts[0].node, 2);
    assert_int_equal(contacts[1].node, 0);
    assert_int_equal(contacts[2].node, 1);
    assert_int_equal(pli_world_solve(f->world), PLI_OK);
    assert_int_equal(pli_body_disable_rigid_contacts(body), PLI_OK);
    check_refused(f, pli_body_reorder_rigid_contacts(body, order, 3), PLI_ERROR_WRONG_STATE, "not enabled");
}

enum { CROWD = 23 };

/* Nodes around a sphere that nothing moves, each with a mass and velocity of its own: towards it, away from it, along
 * it. */
static uint64_t hash_of_crowd(fixture* f, bool is_reversed) {
    pli_vec3 positions[CROWD];
    for (int i = 0; i < CROWD; ++i) {
        const float turn = 0.7f * (float)i, height = (float)i / (CROWD - 1) * 1.8f - 0.9f;
        const float radius = sqrtf(1 - height * height) * 1.05f;
        positions[i] = pli_vec3_make(radius * cosf(turn), height * 1.05f, radius * sinf(turn));
    }
    pli_body* body = make_nodes(f, CROWD, positions, 0.5f, 0.25f, 0.3f, 0.4f);
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.position_iterations = 3;
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    pli_rigid* rigid = make_rigid(f, f->sphere, 0, pli_vec3_make(0, 0, 0));
    int order[CROWD], approaching = 0;
    for (int i = 0; i < CROWD; ++i) {
        const float turn = 1.3f * (float)i;
        const pli_vec3 along = pli_vec3_make(cosf(turn), sinf(2 * turn), sinf(turn));
        const pli_vec3 velocity = pli_vec3_sub(along, pli_vec3_scale(positions[i], 4 * cosf(5 * turn)));
        assert_int_equal(pli_body_set_node_mass(body, i, 0.2f + 0.1f * (float)(i % 5)), PLI_OK);
        assert_int_equal(pli_body_set_node_velocity(body, i, velocity), PLI_OK);
        approaching += pli_vec3_dot(velocity, positions[i]) < 0 ? 1 : 0;
        order[i] = is_reversed ? CROWD - 1 - i : i;
    }
    assert_true(approaching > 4 && approaching < CROWD - 4);
    assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
    assert_int_equal(pli_world_collide_rigid(f->world, body, rigid), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), CROWD);
    assert_int_equal(pli_body_reorder_rigid_contacts(body, order, CROWD), PLI_OK);
    assert_int_equal(pli_world_solve(f->world), PLI_OK);
    const uint64_t hash = pli_body_state_hash(body);
    pli_body_destroy(body);
    pli_rigid_destroy(rigid);
    return hash;
}

/* The same contacts as by nearness, from boxes that take memory and give it back. */
static void test_rigid_contacts_by_kept_boxes(void** state) {
    fixture* f = *state;
    const pli_vec3 positions[3] = {{0, 1.05f, 0}, {0, 1.5f, 0}, {0.9f, 0.5f, 0}};
    pli_body* near = make_nodes(f, 3, positions, 1, 0.1f, 0.3f, 1);
    pli_body* kept = make_nodes(f, 3, positions, 1, 0.1f, 0.3f, 1);
    make_rigid(f, f->sphere, 0, pli_vec3_make(0, 0, 0));
    pli_bounds boxes[3] = {{{-2, -2, -2}, {2, 2, 2}}, {{-2, -2, -2}, {2, 2, 2}}, {{-2, -2, -2}, {2, 2, 2}}};
    assert_int_equal(pli_body_set_bullet_boxes(kept, boxes, NULL), PLI_ERROR_WRONG_STATE);
    const size_t bytes = pli_body_bytes(kept);
    assert_int_equal(pli_body_enable_bullet_node_boxes(kept), PLI_OK);
    assert_true(pli_body_bytes(kept) >= bytes + sizeof boxes);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        assert_int_equal(pli_body_get_rigid_contacts(near, 0, NULL), i == 0 ? 2 : 0);
        assert_int_equal(pli_body_get_rigid_contacts(kept, 0, NULL), i == 0 ? 2 : 0);
        assert_true(pli_body_state_hash(near) == pli_body_state_hash(kept));
        assert_int_equal(pli_body_set_bullet_boxes(kept, boxes, NULL), PLI_OK);
    }
    boxes[1].max.x = NAN;
    assert_int_equal(pli_body_set_bullet_boxes(kept, boxes, NULL), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_body_disable_bullet_node_boxes(kept), PLI_OK);
    assert_int_equal(pli_body_set_bullet_boxes(kept, boxes, NULL), PLI_ERROR_WRONG_STATE);
}

/* Ascending nodes are solved four at a time, others one by one. */
/* Nodes are measured many at a time; each has the distance and the normal that its place alone has. */
static void test_rigid_contacts_are_of_their_own_nodes(void** state) {
    fixture* f = *state;
    enum { COUNT = 60, SHAPES = 9 };
    const pli_vec3 points[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const int triangles[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    pli_shape* shapes[SHAPES] = {f->plane, f->sphere};
    const pli_vec3 half = pli_vec3_make(0.7f, 0.5f, 0.6f), axis = pli_vec3_make(0.3f, 0.6f, 0.1f);
    assert_int_equal(pli_shape_create_box(f->context, half, &shapes[2]), PLI_OK);
    assert_int_equal(pli_shape_create_capsule(f->context, axis, 0.4f, &shapes[3]), PLI_OK);
    assert_int_equal(pli_shape_create_cylinder(f->context, axis, 0.6f, &shapes[4]), PLI_OK);
    assert_int_equal(pli_shape_create_convex_hull(f->context, 6, points, 0.1f, &shapes[5]), PLI_OK);
    assert_int_equal(pli_shape_create_triangle_mesh(f->context, 6, points, 8, triangles, 0.5f, &shapes[6]), PLI_OK);
    assert_int_equal(pli_shape_create_sampled_mesh(f->context, 6, points, 8, triangles, NULL, &shapes[7]), PLI_OK);
    assert_int_equal(pli_shape_create_triangle_mesh(f->context, 6, points, 6, triangles, 0.2f, &shapes[8]), PLI_OK);
    pli_vec3 places[COUNT];
    for (int i = 0; i < COUNT; ++i) {
        const float s = (float)i;
        places[i] = pli_vec3_scale(pli_vec3_make(sinf(7 * s), sinf(11 * s), sinf(13 * s)), 0.9f);
    }
    for (int k = 0; k < SHAPES; ++k) {
        pli_rigid* rigid = make_rigid(f, shapes[k], 0, pli_vec3_make(0, 0, 0));
        pli_body* body = make_nodes(f, COUNT, places, 1, 0.1f, 0, 1);
        assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
        assert_int_equal(pli_world_collide_rigid(f->world, body, rigid), PLI_OK);
        pli_rigid_contact contacts[COUNT];
        const int count = pli_body_get_rigid_contacts(body, COUNT, contacts);
        assert_in_range(count, 10, COUNT);
        for (int i = 0; i < count; ++i) {
            pli_vec3 normal;
            const float distance = pli_shape_distance(shapes[k], places[contacts[i].node], &normal);
            check_near(contacts[i].distance, distance - 0.1f, 1e-5);
            check_near(pli_vec3_dot(contacts[i].normal, normal), 1, 1e-4);
        }
        assert_int_equal(pli_world_solve(f->world), PLI_OK);
        pli_body_destroy(body);
        pli_rigid_destroy(rigid);
        if (k > 1) { pli_shape_release(shapes[k]); }
    }
}

static void test_rigid_contacts_do_not_depend_on_their_order(void** state) {
    fixture* f = *state;
    assert_true(hash_of_crowd(f, false) == hash_of_crowd(f, true));
}

static void test_rigid_contacts_without_memory_stay_as_they_were(void** state) {
    (void)state;
    failing_allocator allocator;
    pli_context* context = failing_context(&allocator);
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    const pli_vec3 from = {0, 0, 0}, to = {1, 0, 0};
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    assert_int_equal(pli_mesh_create_rope(context, from, to, 3, 0, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
    const int features = pli_body_get_features(body, 0, NULL);
    int failures = 0;
    for (;; ++failures) {
        allocator.fail_at = failures + 1;
        if (pli_body_enable_rigid_contacts(body, &def) == PLI_OK) { break; }
        assert_int_equal(pli_body_get_features(body, 0, NULL), features);
    }
    allocator.fail_at = 0;
    assert_in_range(failures, 1, 20);
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
    assert_int_equal(allocator.alive, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_rigid_contacts_keep_momentum, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_pinned_node_stops_a_rigid_body, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_coulomb_friction, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_friction_regimes, setup_reference, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_rest_on_a_plane, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_hold_against_links, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_shape_poses_and_kinematic_drag, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_behind_an_open_floor, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_survive_a_broken_shape, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_go_with_their_rigid_body, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_by_kept_boxes, setup_reference, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_are_of_their_own_nodes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_do_not_depend_on_their_order, setup, teardown),
        cmocka_unit_test(test_rigid_contacts_without_memory_stay_as_they_were),
        cmocka_unit_test_setup_teardown(test_rigid_contacts_refuse_bad_input, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
