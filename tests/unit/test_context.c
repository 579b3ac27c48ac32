/* Context: hooks, accounting, messages, status texts. */

#include "check.h"

#include <pliant/pliant.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct counting {
    int live, calls, log_calls;
    size_t live_bytes;
    char last_line[512];
} counting;

static void* counting_allocate(size_t size, size_t alignment, void* user) {
    counting* c = user;
    c->live += 1;
    c->calls += 1;
    c->live_bytes += size;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void counting_release(void* block, size_t size, void* user) {
    counting* c = user;
    c->live -= 1;
    c->live_bytes -= size;
    free(block);
}

static void counting_log(pli_log_level level, const char* message, void* user) {
    counting* c = user;
    c->log_calls += level == PLI_LOG_ERROR;
    strncpy(c->last_line, message, sizeof c->last_line - 1);
}

static pli_context* counting_context(counting* c) {
    memset(c, 0, sizeof *c);
    pli_context_def def = pli_context_def_default();
    def.allocator = (pli_allocator){counting_allocate, counting_release, c};
    def.log = counting_log;
    def.log_user = c;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    return context;
}

static void test_definition_has_to_start_from_the_defaults(void** unused) {
    (void)unused;
    const pli_context_def def = {.log = counting_log};
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_ERROR_INVALID_DEF);
    assert_null(context);
}

static void test_context_returns_every_byte(void** unused) {
    (void)unused;
    counting c;
    pli_context* context = counting_context(&c);
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 30, 0, &mesh),
                     PLI_OK);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(world, 0.01f), PLI_OK);
    }
    assert_true(pli_context_allocated_bytes(context) > 0);
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
    assert_int_equal(c.live, 0);
    assert_int_equal(c.live_bytes, 0);
}

static void test_context_steady_step_allocates_nothing(void** unused) {
    (void)unused;
    counting c;
    pli_context* context = counting_context(&c);
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 30, 1, &mesh),
                     PLI_OK);
    pli_body* bodies[3];
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_body_create(world, mesh, NULL, &bodies[i]), PLI_OK);
    }
    assert_int_equal(pli_world_step(world, 0.01f), PLI_OK);
    const int calls = c.calls;
    for (int i = 0; i < 50; ++i) {
        assert_int_equal(pli_world_step(world, 0.01f), PLI_OK);
    }
    assert_int_equal(c.calls, calls);
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
}

static void test_context_keeps_and_logs_the_last_error(void** unused) {
    (void)unused;
    counting c;
    pli_context* context = counting_context(&c);
    assert_string_equal(pli_last_error(context), "");
    pli_world_def def = pli_world_def_default();
    def.air_density = -1.0f;
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, &def, &world), PLI_ERROR_INVALID_VALUE);
    assert_null(world);
    assert_non_null(strstr(pli_last_error(context), "pli_world_create"));
    assert_non_null(strstr(pli_last_error(context), "-1"));
    assert_int_equal(c.log_calls, 1);
    assert_string_equal(c.last_line, pli_last_error(context));
    pli_context_destroy(context);
}

/* A shape's pose has the limits of that of its body, whose error it is not. */
static void test_one_failure_is_logged_once(void** unused) {
    (void)unused;
    const float places[] = {1e9f, -INFINITY, NAN};
    for (int i = 0; i < 3; ++i) {
        counting c;
        pli_context* context = counting_context(&c);
        pli_world* world = NULL;
        pli_shape* shape = NULL;
        assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
        assert_int_equal(pli_shape_create_sphere(context, 1.0f, &shape), PLI_OK);
        pli_transform pose = pli_transform_identity();
        pose.origin.x = places[i];
        pli_rigid_def def = pli_rigid_def_default();
        def.shape_count = 1;
        def.shapes = &shape;
        def.shape_poses = &pose;
        pli_rigid* rigid = NULL;
        assert_int_equal(pli_rigid_create(world, &def, &rigid),
                         i == 0 ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE);
        assert_int_equal(c.log_calls, 1);
        assert_string_equal(c.last_line, "pli_rigid_create: the pose of shape 0 is beyond the limits or not finite");
        pli_shape_release(shape);
        pli_world_destroy(world);
        pli_context_destroy(context);
    }
}

static void check_stays(pli_context* context, const char* message) {
    assert_int_equal(pli_context_destroy(context), PLI_ERROR_WRONG_STATE);
    assert_string_equal(pli_last_error(context), message);
}

static void test_context_stays_while_something_of_it_lives(void** unused) {
    (void)unused;
    counting c;
    pli_context* context = counting_context(&c);
    pli_world* worlds[2];
    pli_mesh* mesh = NULL;
    pli_shape* shapes[3];
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pli_world_create(context, NULL, &worlds[i]), PLI_OK);
    }
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_shape_create_sphere(context, 1, &shapes[i]), PLI_OK);
    }
    const int live = c.live;
    check_stays(context, "pli_context_destroy: still alive are worlds: 2, meshes: 1, shapes: 3, sets of triangles: 0");
    assert_int_equal(c.live, live);
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 1;
    def.shapes = &shapes[0];
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(worlds[1], &def, &rigid), PLI_OK);
    for (int i = 0; i < 3; ++i) {
        pli_shape_release(shapes[i]);
    }
    check_stays(
        context,
        "pli_context_destroy: still alive are worlds: 2, meshes: 1, shapes: 1, sets of triangles: 0"); /* the rigid
                                                                                                          body's */
    pli_mesh_destroy(mesh);
    pli_world_destroy(worlds[1]);
    check_stays(context, "pli_context_destroy: still alive are worlds: 1, meshes: 0, shapes: 0, sets of triangles: 0");
    pli_world_destroy(worlds[0]);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    assert_int_equal(c.live, 0);
    assert_int_equal(pli_context_destroy(NULL), PLI_OK);
}

static void test_context_stays_while_triangles_are_held(void** unused) {
    (void)unused;
    const char* path = "test_context.obj";
    FILE* file = fopen(path, "w");
    assert_non_null(file);
    fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", file);
    fclose(file);
    counting c;
    pli_context* context = counting_context(&c);
    pli_triangles triangles;
    assert_int_equal(pli_triangles_read_obj(context, path, &triangles), PLI_OK);
    remove(path);
    check_stays(context, "pli_context_destroy: still alive are worlds: 0, meshes: 0, shapes: 0, sets of triangles: 1");
    pli_triangles_destroy(&triangles);
    pli_triangles_destroy(&triangles);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    assert_int_equal(c.live, 0);
}

static void test_context_needs_both_memory_hooks(void** unused) {
    (void)unused;
    pli_context_def def = pli_context_def_default();
    def.allocator.release = NULL;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_context_create(&def, NULL), PLI_ERROR_NULL_ARGUMENT);
    /* The C library's, which the default has, does not go with one of the user. */
    def = pli_context_def_default();
    def.allocator.allocate = counting_allocate;
    assert_int_equal(pli_context_create(&def, &context), PLI_ERROR_INVALID_VALUE);
    def = pli_context_def_default();
    def.allocator.release = counting_release;
    assert_int_equal(pli_context_create(&def, &context), PLI_ERROR_INVALID_VALUE);
    assert_null(context);
}

static void test_context_names_every_status(void** unused) {
    (void)unused;
#define CHECK_STATUS(name, value, text)                                                                                \
    assert_int_equal(name, value);                                                                                     \
    assert_string_equal(pli_status_string(name), text);
    PLI_STATUS_LIST(CHECK_STATUS)
#undef CHECK_STATUS
    assert_string_equal(pli_status_string((pli_status)99), "unknown status");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_definition_has_to_start_from_the_defaults),
        cmocka_unit_test(test_context_returns_every_byte),
        cmocka_unit_test(test_context_steady_step_allocates_nothing),
        cmocka_unit_test(test_context_keeps_and_logs_the_last_error),
        cmocka_unit_test(test_one_failure_is_logged_once),
        cmocka_unit_test(test_context_stays_while_something_of_it_lives),
        cmocka_unit_test(test_context_stays_while_triangles_are_held),
        cmocka_unit_test(test_context_needs_both_memory_hooks),
        cmocka_unit_test(test_context_names_every_status),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
