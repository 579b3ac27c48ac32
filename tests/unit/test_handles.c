/* Handles that are null, gone or of another kind give errors. What is gone is only tried in a checked build: others
   read the memory of the handle. */

#include "all_calls.h"
#include "check.h"

#include <stdlib.h>
#include <string.h>
#include <threads.h>

enum { SIDE = 3 };
static const pli_vec3 rest[SIDE * SIDE] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}, {1, 0, 1},
                                           {2, 0, 1}, {0, 0, 2}, {1, 0, 2}, {2, 0, 2}};

static pli_body* make_body(pli_world* world, const pli_mesh* mesh) {
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    assert_int_equal(pli_body_generate_clusters(body, 1, 1, NULL), PLI_OK);
    return body;
}

/* One handle of each kind. The world has settings that are no neutral values. */
static call_handles make_handles(void) {
    call_handles h = {.positions = rest};
    assert_int_equal(pli_context_create(NULL, &h.context), PLI_OK);
    assert_int_equal(pli_world_create(h.context, NULL, &h.world), PLI_OK);
    assert_int_equal(pli_shape_create_sphere(h.context, 1, &h.shape), PLI_OK);
    pli_rigid_def rigid = pli_rigid_def_default();
    assert_int_equal(pli_rigid_create(h.world, &rigid, &h.rigid), PLI_OK);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_10 = rest[2];
    patch.corner_01 = rest[6];
    patch.corner_11 = rest[8];
    patch.columns = patch.rows = SIDE;
    assert_int_equal(pli_mesh_create_patch(h.context, &patch, &h.mesh), PLI_OK);
    h.body = make_body(h.world, h.mesh);
    h.other = make_body(h.world, h.mesh);
    h.solver = pli_body_get_solver_settings(h.body);
    h.rigid_state = pli_rigid_get_state(h.rigid);
    assert_int_equal(pli_body_get_cluster_settings(h.body, 0, &h.cluster_settings), PLI_OK);
    return h;
}

static void drop_handles(call_handles* h) {
    pli_mesh_destroy(h->mesh);
    pli_shape_release(h->shape);
    pli_world_destroy(h->world);
    assert_int_equal(pli_context_allocated_bytes(h->context), 0);
    assert_int_equal(pli_context_destroy(h->context), PLI_OK);
}

static void* handle_of(const call_handles* h, call_kind kind) {
    void* const all[] = {h->context, h->world, h->body, h->other, h->rigid, h->mesh, h->shape};
    return all[kind];
}

static void set_handle(call_handles* h, call_kind kind, void* handle) {
    switch (kind) {
    case CALL_CONTEXT:
        h->context = handle;
        break;
    case CALL_WORLD:
        h->world = handle;
        break;
    case CALL_BODY:
        h->body = handle;
        break;
    case CALL_OTHER:
        h->other = handle;
        break;
    case CALL_RIGID:
        h->rigid = handle;
        break;
    case CALL_MESH:
        h->mesh = handle;
        break;
    case CALL_SHAPE:
        h->shape = handle;
        break;
    }
}

static bool takes_null(const char* name) {
    const size_t length = strlen(name);
    return (length > 8 && strcmp(name + length - 8, "_destroy") == 0) || strcmp(name, "pli_shape_release") == 0;
}

static bool is_about_joint(const call_row* row) {
    return strstr(row->name, "_joint") != NULL;
}

/* The message is where the context of the call's other handles keeps it, or where pli_last_error(NULL) reads. */
static void check_message(const call_row* row, const pli_context* context, const char* text) {
    const char* const messages[] = {pli_last_error(context), pli_last_error(NULL)};
    for (int i = 0; i < 2; ++i) {
        if (strncmp(messages[i], row->name, strlen(row->name)) == 0 && messages[i][strlen(row->name)] == ':' &&
            strstr(messages[i], text) != NULL) {
            return;
        }
    }
    fail_msg("%s: \"%s\" and \"%s\" do not say \"%s\"", row->name, messages[0], messages[1], text);
}

/* The row with `handle` in the place of the right one. */
static void check_refused(const call_row* row, const call_handles* h, void* handle, pli_status status,
                          const char* text) {
    call_handles used = *h;
    set_handle(&used, row->kind, handle);
    const uint64_t body_hash = h->body != NULL ? pli_body_state_hash(h->body) : 0;
    const size_t bytes = pli_context_allocated_bytes(h->context);
    const call_result result = row->run(&used);
    if (result.has_status && result.status != status) {
        fail_msg("%s gives %s, expected %s", row->name, pli_status_string(result.status), pli_status_string(status));
    }
    if (result.has_value && !result.is_neutral) { fail_msg("%s gives no neutral value", row->name); }
    if (text != NULL) { check_message(row, h->context, text); }
    assert_int_equal(pli_context_allocated_bytes(h->context), bytes);
    assert_true(h->body == NULL || pli_body_state_hash(h->body) == body_hash);
}

static void test_null_is_refused_by_every_call(void** state) {
    (void)state;
    call_handles h = make_handles();
    for (int i = 0; i < CALL_COUNT; ++i) {
        const call_row* row = &call_rows[i];
        if (takes_null(row->name)) {
            call_handles used = h;
            set_handle(&used, row->kind, NULL);
            const call_result result = row->run(&used);
            assert_int_equal(result.status, PLI_OK);
        } else if (!is_about_joint(row) || row->kind == CALL_BODY) { /* the other end of a joint may be null */
            check_refused(row, &h, NULL, PLI_ERROR_NULL_ARGUMENT, PLIANT_CHECKED ? "null" : NULL);
        }
    }
    drop_handles(&h);
}

/* Memory of another handle is there to be read in every build. */
static void test_handles_of_another_kind_are_refused_by_every_call(void** state) {
    (void)state;
    call_handles h = make_handles();
    for (int i = 0; i < CALL_COUNT; ++i) {
        const call_row* row = &call_rows[i];
        for (int kind = CALL_CONTEXT; kind <= CALL_SHAPE; ++kind) {
            const bool is_same = kind == (int)row->kind || (kind == CALL_OTHER && row->kind == CALL_BODY) ||
                                 (kind == CALL_BODY && row->kind == CALL_OTHER);
            if (is_same) { continue; }
            check_refused(row, &h, handle_of(&h, (call_kind)kind), PLI_ERROR_STALE_ID,
                          PLIANT_CHECKED ? " is a " : NULL);
        }
    }
    drop_handles(&h);
}

#if PLIANT_CHECKED

static void destroy_kind(call_handles* h, call_kind kind) {
    switch (kind) {
    case CALL_CONTEXT:
        drop_handles(h);
        break;
    case CALL_WORLD:
        pli_world_destroy(h->world);
        break;
    case CALL_BODY:
        pli_body_destroy(h->body);
        break;
    case CALL_OTHER:
        pli_body_destroy(h->other);
        break;
    case CALL_RIGID:
        pli_rigid_destroy(h->rigid);
        break;
    case CALL_MESH:
        pli_mesh_destroy(h->mesh);
        break;
    case CALL_SHAPE:
        pli_shape_release(h->shape);
        break;
    }
}

/* The message is kept by the context of the handle, or, where a call takes others too, by theirs. */
static void check_gone(call_kind kind) {
    call_handles gone = make_handles();
    call_handles alive = make_handles();
    void* const handle = handle_of(&gone, kind);
    destroy_kind(&gone, kind);
    for (int i = 0; i < CALL_COUNT; ++i) {
        if (call_rows[i].kind == kind) {
            check_refused(&call_rows[i], &alive, handle, PLI_ERROR_STALE_ID, NULL);
            const pli_context* owner = kind == CALL_CONTEXT ? NULL : gone.context;
            const char* messages[] = {pli_last_error(owner), pli_last_error(alive.context)};
            const char* name = call_rows[i].name;
            if (strncmp(messages[0], name, strlen(name)) != 0 && strncmp(messages[1], name, strlen(name)) != 0) {
                fail_msg("%s: \"%s\" and \"%s\" do not name it", name, messages[0], messages[1]);
            }
        }
    }
    drop_handles(&alive);
    if (kind == CALL_CONTEXT) { return; }
    if (kind != CALL_MESH) { pli_mesh_destroy(gone.mesh); }
    if (kind != CALL_SHAPE) { pli_shape_release(gone.shape); }
    if (kind != CALL_WORLD) { pli_world_destroy(gone.world); }
    assert_int_equal(pli_context_allocated_bytes(gone.context), 0);
    assert_int_equal(pli_context_destroy(gone.context), PLI_OK);
}

static void test_handles_that_are_gone_are_refused_by_every_call(void** state) {
    (void)state;
    for (int kind = CALL_CONTEXT; kind <= CALL_SHAPE; ++kind) {
        check_gone((call_kind)kind);
    }
}

static void test_bodies_and_rigids_go_with_their_world(void** state) {
    (void)state;
    call_handles h = make_handles();
    pli_world_destroy(h.world);
    assert_int_equal(pli_body_set_solver_settings(h.body, &h.solver), PLI_ERROR_STALE_ID);
    assert_string_equal(pli_last_error(h.context), "pli_body_set_solver_settings: the body was destroyed before");
    assert_int_equal(pli_rigid_set_friction(h.rigid, 1), PLI_ERROR_STALE_ID);
    assert_string_equal(pli_last_error(h.context), "pli_rigid_set_friction: the rigid body was destroyed before");
    pli_body_destroy(h.body);
    assert_string_equal(pli_last_error(h.context), "pli_body_destroy: the body was destroyed before");
    pli_mesh_destroy(h.mesh);
    pli_shape_release(h.shape);
    pli_shape_release(h.shape);
    assert_string_equal(pli_last_error(h.context), "pli_shape_release: the shape was destroyed before");
    assert_int_equal(pli_context_destroy(h.context), PLI_OK);
}

/* A shape that a rigid body holds lives on. */
static void test_shapes_live_as_long_as_somebody_holds_them(void** state) {
    (void)state;
    call_handles h = make_handles();
    assert_int_equal(pli_rigid_set_shapes(h.rigid, 1, &h.shape, NULL), PLI_OK);
    pli_shape_release(h.shape);
    check_near(pli_shape_bounds(h.shape).max.x, 1, 1e-6);
    pli_shape* none = h.shape;
    assert_int_equal(pli_rigid_set_shapes(h.rigid, 0, NULL, NULL), PLI_OK);
    assert_true(pli_shape_bounds(h.shape).max.x == 0.0f);
    assert_int_equal(pli_rigid_set_shapes(h.rigid, 1, &none, NULL), PLI_ERROR_STALE_ID);
    assert_string_equal(pli_last_error(h.context), "pli_rigid_set_shapes: shape 0 was destroyed before");
    pli_mesh_destroy(h.mesh);
    pli_world_destroy(h.world);
    assert_int_equal(pli_context_destroy(h.context), PLI_OK);
}

static void test_messages_about_lost_contexts_can_be_read(void** state) {
    (void)state;
    call_handles h = make_handles();
    pli_world* world = h.world;
    drop_handles(&h);
    assert_int_equal(pli_world_step(world, 0.01f), PLI_ERROR_STALE_ID);
    assert_string_equal(pli_last_error(NULL), "pli_world_step: the world was destroyed before");
    assert_int_equal(pli_context_destroy(h.context), PLI_ERROR_STALE_ID);
    assert_string_equal(pli_last_error(h.context), "pli_context_destroy: the context was destroyed before");
    int not_a_handle[64] = {0};
    assert_int_equal(pli_body_bytes((pli_body*)(void*)not_a_handle), 0);
    assert_string_equal(pli_last_error(NULL), "pli_body_bytes: the body is not a body, or one that is gone");
    assert_int_equal(pli_mesh_scale(NULL, pli_vec3_make(1, 1, 1)), PLI_ERROR_NULL_ARGUMENT);
    assert_string_equal(pli_last_error(NULL), "pli_mesh_scale: the mesh is null");
}

/* New handles do not come to lie where old ones were a short time ago. */
static void test_new_bodies_are_not_taken_for_old_ones(void** state) {
    (void)state;
    call_handles h = make_handles();
    for (int i = 0; i < 100; ++i) {
        pli_body* body = make_body(h.world, h.mesh);
        pli_body_destroy(body);
        pli_body* next = make_body(h.world, h.mesh);
        assert_ptr_not_equal(body, next);
        assert_true(pli_body_total_mass(body) == 0.0f);
        assert_true(pli_body_total_mass(next) > 0.0f);
        pli_body_destroy(next);
    }
    drop_handles(&h);
}

/* Many more handles than are remembered. */
static void test_many_handles_come_and_go(void** state) {
    (void)state;
    enum { COUNT = 20000, KEPT = 1500 };
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    pli_mesh** kept = calloc(KEPT, sizeof *kept);
    for (int i = 0; i < COUNT; ++i) {
        pli_mesh** place = &kept[i % KEPT];
        pli_mesh_destroy(*place);
        assert_int_equal(pli_mesh_create(context, place), PLI_OK);
        assert_int_equal(pli_mesh_append_node(*place, pli_vec3_make(0, 0, 0), 1, NULL), PLI_OK);
    }
    for (int i = 0; i < KEPT; ++i) {
        check_near(pli_mesh_total_mass(kept[i]), 1, 1e-6);
        pli_mesh_destroy(kept[i]);
        assert_true(pli_mesh_total_mass(kept[i]) == 0.0f);
    }
    free(kept);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
}

/* A context for each thread; the register is for all. Gives the number of failures. */
static int use_handles_in_a_thread(void* unused) {
    (void)unused;
    int failures = 0;
    for (int i = 0; i < 50; ++i) {
        pli_context* context = NULL;
        pli_world* world = NULL;
        pli_mesh* mesh = NULL;
        pli_body* body = NULL;
        failures += pli_context_create(NULL, &context) != PLI_OK;
        failures += pli_world_create(context, NULL, &world) != PLI_OK;
        failures += pli_mesh_create_rope(context, rest[0], rest[1], 2, 0, &mesh) != PLI_OK;
        failures += pli_body_create(world, mesh, NULL, &body) != PLI_OK;
        failures += pli_world_step(world, 0.01f) != PLI_OK;
        failures += pli_body_bytes(body) == 0;
        pli_body_destroy(body);
        pli_mesh_destroy(mesh);
        pli_world_destroy(world);
        failures += pli_context_destroy(context) != PLI_OK;
        failures += pli_mesh_scale(NULL, rest[1]) != PLI_ERROR_NULL_ARGUMENT;
        failures += strcmp(pli_last_error(NULL), "pli_mesh_scale: the mesh is null") != 0;
    }
    return failures;
}

static void test_threads_share_the_register(void** state) {
    (void)state;
    thrd_t threads[3];
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(thrd_create(&threads[i], use_handles_in_a_thread, NULL), thrd_success);
    }
    for (int i = 0; i < 3; ++i) {
        int failures = -1;
        assert_int_equal(thrd_join(threads[i], &failures), thrd_success);
        assert_int_equal(failures, 0);
    }
}

#endif

/* What bodies share with their mesh they do not share between contexts, which end one by one. */
static void test_meshes_of_another_context_are_copied_wholly(void** state) {
    (void)state;
    call_handles a = make_handles(), b = make_handles();
    pli_body* body = NULL;
    const size_t bytes = pli_context_allocated_bytes(b.context);
    assert_int_equal(pli_body_create(a.world, b.mesh, NULL, &body), PLI_OK);
    assert_int_equal(pli_context_allocated_bytes(b.context), bytes);
    drop_handles(&b);
    assert_int_equal(pli_body_get_view(body).face_count, 2 * (SIDE - 1) * (SIDE - 1));
    assert_int_equal(pli_world_step(a.world, 0.01f), PLI_OK);
    drop_handles(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_null_is_refused_by_every_call),
        cmocka_unit_test(test_handles_of_another_kind_are_refused_by_every_call),
        cmocka_unit_test(test_meshes_of_another_context_are_copied_wholly),
#if PLIANT_CHECKED
        cmocka_unit_test(test_handles_that_are_gone_are_refused_by_every_call),
        cmocka_unit_test(test_bodies_and_rigids_go_with_their_world),
        cmocka_unit_test(test_shapes_live_as_long_as_somebody_holds_them),
        cmocka_unit_test(test_messages_about_lost_contexts_can_be_read),
        cmocka_unit_test(test_new_bodies_are_not_taken_for_old_ones),
        cmocka_unit_test(test_many_handles_come_and_go),
        cmocka_unit_test(test_threads_share_the_register),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
