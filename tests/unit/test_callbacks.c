/* Callbacks may read, and what they try to change is refused: each callback makes every call of the library. */

#include "all_calls.h"
#include "check.h"
#include "level_sheet.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum site {
    SITE_ALLOCATE,
    SITE_RELEASE,
    SITE_LOG,
    SITE_PARALLEL,
    SITE_PROFILE,
    SITE_STEER,
    SITE_SPEED,
    SITE_SURFACE,
    SITE_DISTANCES,
    SITE_BOUNDS,
    SITE_SUPPORT,
    SITE_DESTROY,
    SITE_CLUSTER_DISTANCE,
    SITE_COUNT
} site;

enum { SITE_VISITS = 2, SIDE = 7 };
static const float dt = 1.0f / 60.0f;

static struct {
    call_handles handles;
    bool is_armed, is_inside;
    int visits[SITE_COUNT];
    int attempts;
    char first_failure[256];
    char profile_stage[32]; /* try only in this stage; empty: in all */
} trial;

static void note_failure(site where, const char* call, const char* what) {
    if (trial.first_failure[0] != '\0') { return; }
    snprintf(trial.first_failure, sizeof trial.first_failure, "site %d, %s: %s", (int)where, call, what);
}

/* Retaining and releasing shapes is allowed where a shape is destroyed. */
static bool is_allowed(site where, const call_row* row) {
    return row->effect == CALL_READS || (where == SITE_DESTROY && (strcmp(row->name, "pli_shape_retain") == 0 ||
                                                                   strcmp(row->name, "pli_shape_release") == 0));
}

static void try_all_calls(site where) {
    if (!trial.is_armed || trial.is_inside || trial.visits[where] >= SITE_VISITS) { return; }
    trial.is_inside = true;
    trial.visits[where] += 1;
    for (int i = 0; i < CALL_COUNT; ++i) {
        const call_row* row = &call_rows[i];
        const call_result result = row->run(&trial.handles);
        if (is_allowed(where, row)) { continue; }
        trial.attempts += 1;
        if (result.has_status && result.status != PLI_ERROR_WRONG_STATE) {
            note_failure(where, row->name, pli_status_string(result.status));
        }
        const char* message = pli_last_error(trial.handles.context);
        if (strncmp(message, row->name, strlen(row->name)) != 0 || strstr(message, "callback") == NULL) {
            note_failure(where, row->name, message);
        }
    }
    trial.is_inside = false;
}

// ----------------------------------------------------------------------------------------------------- callbacks

static void* trying_allocate(size_t size, size_t alignment, void* user) {
    (void)user;
    try_all_calls(SITE_ALLOCATE);
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void trying_release(void* block, size_t size, void* user) {
    (void)size;
    (void)user;
    try_all_calls(SITE_RELEASE);
    free(block);
}

static void trying_log(pli_log_level level, const char* message, void* user) {
    (void)level;
    (void)user;
    char before[256];
    snprintf(before, sizeof before, "%s", message);
    try_all_calls(SITE_LOG);
    if (strncmp(before, message, sizeof before - 1) != 0) { note_failure(SITE_LOG, "log", "the message changed"); }
}

static void trying_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)grain;
    (void)user;
    try_all_calls(SITE_PARALLEL);
    range(0, count, task);
}

static void trying_profile(const char* stage, const char* feature, bool begins, void* user) {
    (void)feature;
    (void)begins;
    (void)user;
    if (trial.profile_stage[0] == '\0' || strcmp(stage, trial.profile_stage) == 0) { try_all_calls(SITE_PROFILE); }
}

static pli_vec3 trying_steer(pli_vec3 local_axis, void* user) {
    (void)user;
    try_all_calls(SITE_STEER);
    return local_axis;
}

static float trying_speed(float present, void* user) {
    (void)user;
    try_all_calls(SITE_SPEED);
    return present + 1.0f;
}

static float trying_surface(pli_vec3 point, void* user) {
    (void)user;
    try_all_calls(SITE_SURFACE);
    return point.x - 0.4f;
}

static bool trying_cluster_distance(const pli_body* body, pli_cluster_contact* contact, void* user) {
    (void)body;
    (void)contact;
    (void)user;
    try_all_calls(SITE_CLUSTER_DISTANCE);
    return false;
}

/* A ball of radius 1. */
static void trying_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                             pli_vec3* normals) {
    (void)user;
    (void)max_distance;
    try_all_calls(SITE_DISTANCES);
    for (int i = 0; i < count; ++i) {
        const float length = pli_vec3_length(points[i]);
        distances[i] = length - 1.0f;
        normals[i] = length > 0.0f ? pli_vec3_scale(points[i], 1.0f / length) : pli_vec3_make(0, 1, 0);
    }
}

static pli_bounds trying_bounds(const void* user) {
    (void)user;
    try_all_calls(SITE_BOUNDS);
    return (pli_bounds){{-1, -1, -1}, {1, 1, 1}};
}

static pli_vec3 trying_support(const void* user, pli_vec3 direction) {
    (void)user;
    (void)direction;
    try_all_calls(SITE_SUPPORT);
    return pli_vec3_make(0, 0, 0);
}

static void trying_destroy(void* user) {
    (void)user;
    try_all_calls(SITE_DESTROY);
}

// ---------------------------------------------------------------------------------------------------- the scene

static pli_vec3 scene_positions[SIDE * SIDE];

static pli_shape* make_ball(pli_context* context) {
    pli_shape_def def = pli_shape_def_default();
    def.distances = trying_distances;
    def.bounds = trying_bounds;
    def.support = trying_support;
    def.radius = 1.0f;
    def.destroy = trying_destroy;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create(context, &def, &shape), PLI_OK);
    return shape;
}

static pli_rigid* make_rigid(pli_world* world, pli_shape* shape, float height) {
    pli_rigid_def def = pli_rigid_def_default();
    def.state.pose.origin = pli_vec3_make(0, height, 0);
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    return rigid;
}

static pli_mesh* make_sheet_mesh(pli_context* context) {
    pli_patch_def patch = level_sheet(1, 0, SIDE);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
    return mesh;
}

static pli_body* make_sheet(pli_world* world, const pli_mesh* mesh) {
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    assert_int_equal(pli_body_enable_rigid_contacts(body, CALL_DEF(pli_rigid_contacts)), PLI_OK);
    assert_int_equal(pli_body_enable_rigid_face_contacts(body, CALL_DEF(pli_rigid_face_contacts)), PLI_OK);
    assert_int_equal(pli_body_enable_soft_contacts(body, CALL_DEF(pli_soft_contacts)), PLI_OK);
    assert_int_equal(pli_body_enable_pressure(body, 0.01f), PLI_OK); /* refreshes normals */
    assert_int_equal(pli_body_generate_clusters(body, 1, 1, NULL), PLI_OK);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    contacts.distance = trying_cluster_distance;
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    return body;
}

/* Two sheets over a ball, one driven by a controller. */
static call_handles make_scene(void) {
    call_handles h = {0};
    pli_context_def def = pli_context_def_default();
    def.allocator = (pli_allocator){trying_allocate, trying_release, NULL};
    def.log = trying_log;
    def.parallel_for = trying_parallel_for;
    assert_int_equal(pli_context_create(&def, &h.context), PLI_OK);
    assert_int_equal(pli_world_create(h.context, NULL, &h.world), PLI_OK);
    h.shape = make_ball(h.context);
    h.rigid = make_rigid(h.world, h.shape, -1.1f);
    h.mesh = make_sheet_mesh(h.context);
    h.body = make_sheet(h.world, h.mesh);
    h.other = make_sheet(h.world, h.mesh);
    pli_angular_joint_def joint = pli_angular_joint_def_default();
    joint.axis = pli_vec3_make(0, 1, 0);
    joint.controller = (pli_joint_controller){trying_steer, trying_speed, NULL};
    assert_int_equal(pli_body_add_angular_joint(h.body, &joint, NULL), PLI_OK);
    assert_int_equal(pli_world_set_profile(h.world, trying_profile, NULL), PLI_OK);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const pli_vec4 p = pli_body_get_view(h.body).positions[i];
        scene_positions[i] = pli_vec3_make(p.x, p.y, p.z);
    }
    h.positions = scene_positions;
    h.solver = pli_body_get_solver_settings(h.body);
    h.rigid_state = pli_rigid_get_state(h.rigid);
    assert_int_equal(pli_body_get_cluster_settings(h.body, 0, &h.cluster_settings), PLI_OK);
    return h;
}

static void drop_scene(call_handles* h) {
    pli_mesh_destroy(h->mesh);
    pli_shape_release(h->shape);
    pli_world_destroy(h->world);
    assert_int_equal(pli_context_allocated_bytes(h->context), 0);
    assert_int_equal(pli_context_destroy(h->context), PLI_OK);
}

/* What the body is after steps, a transform, a new state and a cut. */
static uint64_t run_scene(call_handles* h) {
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_world_step(h->world, dt), PLI_OK);
    }
    assert_int_equal(pli_world_predict(h->world, dt), PLI_OK);
    assert_int_equal(pli_world_collide_rigid(h->world, h->body, h->rigid), PLI_OK);
    assert_int_equal(pli_world_collide_bodies(h->world, h->body, h->other), PLI_OK);
    assert_int_equal(pli_world_solve(h->world), PLI_OK);
    assert_int_equal(pli_body_transform(h->body, pli_transform_identity()), PLI_OK);
    assert_int_equal(pli_body_set_state(h->other, h->positions, NULL), PLI_OK);
    pli_refine_def def = pli_refine_def_default();
    def.surface = trying_surface;
    assert_int_equal(pli_body_refine(h->body, &def), PLI_OK);
    assert_int_equal(pli_world_step(h->world, dt), PLI_OK);
    return pli_body_state_hash(h->body) ^ (pli_body_state_hash(h->other) << 1);
}

static int setup_trial(void** state) {
    (void)state;
    memset(&trial, 0, sizeof trial);
    return 0;
}

static void check_trial(site where) {
    trial.is_armed = false;
    if (trial.first_failure[0] != '\0') { fail_msg("%s", trial.first_failure); }
    assert_in_range(trial.visits[where], 1, SITE_VISITS);
    assert_true(trial.attempts >= 150);
}

// ------------------------------------------------------------------------------------------------------- tests

/* Nothing changes: bits, the number of allocations and the bytes held are those of a run whose callbacks try nothing.
 */
static void check_site(site where) {
    call_handles plain = make_scene();
    const uint64_t expected = run_scene(&plain);
    const size_t bytes = pli_context_allocated_bytes(plain.context);
    drop_scene(&plain);
    call_handles h = make_scene();
    trial.handles = h;
    for (int i = 0; i < SITE_COUNT; ++i) {
        trial.visits[i] = i == (int)where ? 0 : SITE_VISITS;
    }
    trial.is_armed = true;
    const uint64_t hash = run_scene(&h);
    check_trial(where);
    assert_true(hash == expected);
    assert_int_equal(pli_context_allocated_bytes(h.context), bytes);
    drop_scene(&h);
}

#define SITE_TEST(name, site)                                                                                          \
    static void test_##name##_may_read_only(void** state) {                                                            \
        (void)state;                                                                                                   \
        check_site(site);                                                                                              \
    }
SITE_TEST(allocate, SITE_ALLOCATE)
SITE_TEST(release, SITE_RELEASE)
SITE_TEST(profile, SITE_PROFILE)
SITE_TEST(steer, SITE_STEER)
SITE_TEST(speed, SITE_SPEED)
SITE_TEST(surface, SITE_SURFACE)
SITE_TEST(distances, SITE_DISTANCES)
SITE_TEST(bounds, SITE_BOUNDS)
SITE_TEST(support, SITE_SUPPORT)
SITE_TEST(cluster_distance, SITE_CLUSTER_DISTANCE)

/* The profile function is also called where nodes are placed or a body is cut. */
static void test_profile_outside_of_steps_may_read_only(void** state) {
    (void)state;
    call_handles h = make_scene();
    trial.handles = h;
    strcpy(trial.profile_stage, "refresh");
    trial.is_armed = true;
    for (int i = 0; i < SITE_COUNT; ++i) {
        trial.visits[i] = i == SITE_PROFILE ? 0 : SITE_VISITS;
    }
    assert_int_equal(pli_body_transform(h.body, pli_transform_identity()), PLI_OK);
    check_trial(SITE_PROFILE);
    trial.is_armed = true;
    trial.visits[SITE_PROFILE] = 0;
    assert_int_equal(pli_body_set_state(h.body, h.positions, NULL), PLI_OK);
    check_trial(SITE_PROFILE);
    trial.is_armed = true;
    trial.visits[SITE_PROFILE] = 0;
    assert_int_equal(pli_body_cut_link(h.body, 0, 1, 0.5f), PLI_OK);
    check_trial(SITE_PROFILE);
    assert_int_equal(pli_world_step(h.world, dt), PLI_OK);
    drop_scene(&h);
}

/* Callbacks of one kind alone try. */
static void arm_at(const call_handles* handles, site where) {
    trial.handles = *handles;
    trial.is_armed = true;
    for (int i = 0; i < SITE_COUNT; ++i) {
        trial.visits[i] = i == (int)where ? 0 : SITE_VISITS;
    }
}

static void test_log_may_read_only_and_the_first_message_stays(void** state) {
    (void)state;
    call_handles h = make_scene();
    arm_at(&h, SITE_LOG);
    assert_int_equal(pli_body_set_rest_length(h.body, -1, 1.0f), PLI_ERROR_INDEX_OUT_OF_RANGE);
    check_trial(SITE_LOG);
    assert_non_null(strstr(pli_last_error(h.context), "pli_body_set_rest_length: link -1 is out of range"));
    drop_scene(&h);
}

/* Passes over nodes are handed out from 4,096 nodes on. */
static void test_parallel_for_may_read_only(void** state) {
    (void)state;
    call_handles h = make_scene();
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_10 = pli_vec3_make(1, 0, 0);
    patch.corner_01 = pli_vec3_make(0, 0, 1);
    patch.corner_11 = pli_vec3_make(1, 0, 1);
    patch.columns = patch.rows = 96;
    pli_mesh* mesh = NULL;
    pli_body* large = NULL;
    assert_int_equal(pli_mesh_create_patch(h.context, &patch, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(h.world, mesh, NULL, &large), PLI_OK);
    pli_mesh_destroy(mesh);
    arm_at(&h, SITE_PARALLEL);
    assert_int_equal(pli_world_step(h.world, dt), PLI_OK);
    check_trial(SITE_PARALLEL);
    drop_scene(&h);
}

static void test_destroy_of_a_shape_may_release_other_shapes_only(void** state) {
    (void)state;
    call_handles h = make_scene();
    pli_shape* shape = make_ball(h.context);
    pli_rigid* rigid = make_rigid(h.world, shape, -9);
    pli_shape_release(shape);
    arm_at(&h, SITE_DESTROY);
    pli_rigid_destroy(rigid);
    check_trial(SITE_DESTROY);
    assert_int_equal(trial.visits[SITE_DESTROY], 1);
    drop_scene(&h);
}

/* Bodies that may sleep ask where a rigid body was that goes. */
static void test_bounds_of_what_goes_may_read_only(void** state) {
    (void)state;
    call_handles h = make_scene();
    assert_int_equal(pli_body_enable_sleep(h.body, CALL_DEF(pli_sleep)), PLI_OK);
    pli_rigid* rigid = make_rigid(h.world, h.shape, 0);
    arm_at(&h, SITE_BOUNDS);
    pli_rigid_destroy(rigid);
    check_trial(SITE_BOUNDS);
    drop_scene(&h);
}

/* Questions to a shape come from anywhere, without a step. */
static void test_shapes_that_are_asked_may_read_only(void** state) {
    (void)state;
    call_handles h = make_scene();
    pli_shape* lattice = NULL;
    arm_at(&h, SITE_DISTANCES);
    assert_int_equal(pli_shape_create_lattice(h.context, h.shape, 0.25f, &lattice), PLI_OK);
    trial.handles.shape = lattice;
    check_near(pli_shape_distance(lattice, pli_vec3_make(3, 0, 0), NULL), 2.0, 1e-3);
    check_trial(SITE_DISTANCES);
    trial.is_armed = true;
    trial.visits[SITE_BOUNDS] = 0;
    assert_true(pli_shape_bounds(h.shape).max.x == 1.0f);
    check_trial(SITE_BOUNDS);
    pli_shape_release(lattice);
    drop_scene(&h);
}

/* Between predict and solve only what needs an idle world is refused. */
static void test_calls_between_predict_and_solve(void** state) {
    (void)state;
    call_handles h = make_scene();
    assert_int_equal(pli_world_predict(h.world, dt), PLI_OK);
    for (int i = 0; i < CALL_COUNT; ++i) {
        const call_row* row = &call_rows[i];
        if (row->effect != CALL_CHANGES_IDLE) { continue; }
        const call_result result = row->run(&h);
        if (result.has_status && result.status != PLI_ERROR_WRONG_STATE) { fail_msg("%s", row->name); }
        assert_non_null(strstr(pli_last_error(h.context), "between predict and solve"));
        assert_memory_equal(pli_last_error(h.context), row->name, strlen(row->name));
    }
    assert_int_equal(pli_rigid_set_state(h.rigid, &h.rigid_state), PLI_OK);
    assert_int_equal(pli_rigid_set_shapes(h.rigid, 1, &h.shape, NULL), PLI_OK);
    assert_int_equal(pli_world_set_gravity(h.world, pli_vec3_make(0, -9, 0)), PLI_OK);
    assert_int_equal(pli_body_add_force(h.body, pli_vec3_make(0, 1, 0)), PLI_OK);
    assert_int_equal(pli_body_ignore_rigid(h.body, h.rigid, true), PLI_OK);
    assert_int_equal(pli_world_solve(h.world), PLI_OK);
    drop_scene(&h);
}

#define CALLBACK_TEST(name) cmocka_unit_test_setup(name, setup_trial)

int main(void) {
    const struct CMUnitTest tests[] = {
        CALLBACK_TEST(test_allocate_may_read_only),
        CALLBACK_TEST(test_release_may_read_only),
        CALLBACK_TEST(test_profile_may_read_only),
        CALLBACK_TEST(test_steer_may_read_only),
        CALLBACK_TEST(test_speed_may_read_only),
        CALLBACK_TEST(test_surface_may_read_only),
        CALLBACK_TEST(test_distances_may_read_only),
        CALLBACK_TEST(test_bounds_may_read_only),
        CALLBACK_TEST(test_support_may_read_only),
        CALLBACK_TEST(test_cluster_distance_may_read_only),
        CALLBACK_TEST(test_profile_outside_of_steps_may_read_only),
        CALLBACK_TEST(test_log_may_read_only_and_the_first_message_stays),
        CALLBACK_TEST(test_parallel_for_may_read_only),
        CALLBACK_TEST(test_destroy_of_a_shape_may_release_other_shapes_only),
        CALLBACK_TEST(test_bounds_of_what_goes_may_read_only),
        CALLBACK_TEST(test_shapes_that_are_asked_may_read_only),
        CALLBACK_TEST(test_calls_between_predict_and_solve),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
