/* Rigid proxies: what the host may change after they were made. */
#include "check.h"

#include "pliant/anchor.h"
#include "pliant/contact.h"
#include "pliant/generate.h"
#include "pliant/limits.h"
#include "pliant/rigid.h"
#include "pliant/world.h"

#include <math.h>
#include <string.h>

typedef struct scene {
    pli_context* context;
    pli_world* world;
    pli_rigid* rigid;
    pli_shape* shape;
} scene;

static scene scene_make(void) {
    scene s = {0};
    assert_int_equal(pli_context_create(NULL, &s.context), PLI_OK);
    assert_int_equal(pli_world_create(s.context, NULL, &s.world), PLI_OK);
    assert_int_equal(pli_shape_create_sphere(s.context, 0.5f, &s.shape), PLI_OK);
    const pli_rigid_def def = pli_rigid_def_default();
    assert_int_equal(pli_rigid_create(s.world, &def, &s.rigid), PLI_OK);
    return s;
}

static void scene_destroy(scene* s) {
    pli_shape_release(s->shape);
    pli_world_destroy(s->world);
    assert_int_equal(pli_context_allocated_bytes(s->context), 0);
    pli_context_destroy(s->context);
}

static pli_rigid_state dynamic_state(void) {
    pli_rigid_state state = {.pose = pli_transform_identity(), .inverse_mass = 0.5f};
    state.inverse_inertia_world = pli_mat3_identity();
    state.linear_velocity = pli_vec3_make(1, 2, 3);
    return state;
}

static void test_the_kind_may_change(void** unused) {
    (void)unused;
    scene s = scene_make();
    const pli_rigid_state state = dynamic_state();
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_DYNAMIC, &state), PLI_OK);
    assert_int_equal(pli_rigid_get_kind(s.rigid), PLI_RIGID_DYNAMIC);
    check_near(pli_rigid_get_state(s.rigid).inverse_mass, 0.5, 0);
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_KINEMATIC, &state), PLI_OK);
    check_near(pli_rigid_get_state(s.rigid).inverse_mass, 0, 0);
    check_near(pli_rigid_get_state(s.rigid).linear_velocity.y, 2, 0);
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_STATIC, &state), PLI_OK);
    check_near(pli_rigid_get_state(s.rigid).linear_velocity.y, 0, 0);

    pli_rigid_state bad = state;
    bad.inverse_mass = 0;
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_DYNAMIC, &bad), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_rigid_set_kind(s.rigid, (pli_rigid_kind)3, &state), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_DYNAMIC, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_rigid_set_kind(NULL, PLI_RIGID_DYNAMIC, &state), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_rigid_get_kind(s.rigid), PLI_RIGID_STATIC);
    scene_destroy(&s);
}

/* Gravity that waits for the next step, as of a body that was held, goes with the kind. */
static void test_what_was_dynamic_does_not_fall(void** unused) {
    (void)unused;
    const float dt = 1.0f / 60.0f;
    for (int kind = PLI_RIGID_STATIC; kind <= PLI_RIGID_KINEMATIC; ++kind) {
        scene s = scene_make();
        pli_rigid_state state = dynamic_state();
        state.linear_velocity = pli_vec3_make(0, 0, 0);
        assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_DYNAMIC, &state), PLI_OK);
        pli_mesh* mesh = NULL;
        pli_body* rope = NULL;
        const pli_vec3 from = pli_vec3_make(0, 1, 0), to = pli_vec3_make(0, 0, 0);
        assert_int_equal(pli_mesh_create_rope(s.context, from, to, 1, PLI_ROPE_PIN_FIRST, &mesh), PLI_OK);
        assert_int_equal(pli_body_create(s.world, mesh, NULL, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.rigid = s.rigid;
        anchor.node = 2;
        assert_int_equal(pli_body_add_anchor(rope, &anchor, NULL), PLI_OK);
        assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
        assert_int_equal(pli_rigid_integrate(s.rigid, pli_vec3_make(0, -10, 0), dt), PLI_OK);
        state = pli_rigid_get_state(s.rigid);
        state.linear_velocity = pli_vec3_make(0, 0, 0);
        assert_int_equal(pli_rigid_set_kind(s.rigid, (pli_rigid_kind)kind, &state), PLI_OK);
        assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
        check_near(pli_rigid_get_state(s.rigid).linear_velocity.y, 0, 0);
        scene_destroy(&s);
    }
}

static void test_factors_may_change(void** unused) {
    (void)unused;
    scene s = scene_make();
    const pli_vec3 one = pli_vec3_make(1, 1, 1), bad = pli_vec3_make(NAN, 1, 1);
    assert_int_equal(pli_rigid_set_factors(s.rigid, pli_vec3_make(0, 1, 2), one), PLI_OK);
    assert_int_equal(pli_rigid_set_factors(s.rigid, bad, one), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_rigid_set_factors(s.rigid, one, bad), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_rigid_set_factors(NULL, one, one), PLI_ERROR_NULL_ARGUMENT);
    scene_destroy(&s);
}

static void test_shapes_may_change_and_anchors_stay(void** unused) {
    (void)unused;
    scene s = scene_make();
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    const pli_vec3 from = pli_vec3_make(0, 0, 0), to = pli_vec3_make(1, 0, 0);
    assert_int_equal(pli_mesh_create_rope(s.context, from, to, 3, 0, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(s.world, mesh, NULL, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = s.rigid;
    assert_int_equal(pli_body_add_anchor(rope, &anchor, NULL), PLI_OK);

    pli_shape* const shapes[3] = {s.shape, s.shape, s.shape};
    const pli_transform poses[3] = {pli_transform_identity(), pli_transform_identity(), pli_transform_identity()};
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 3, shapes, poses), PLI_OK);
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 1, shapes, NULL), PLI_OK);
    assert_int_equal(pli_body_anchor_count(rope), 1);

    /* In a steady state lists of changing length need no memory. */
    const uint64_t allocations = pli_context_allocation_count(s.context);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_rigid_set_shapes(s.rigid, i % 4, shapes, poses), PLI_OK);
    }
    assert_int_equal(pli_context_allocation_count(s.context), allocations);

    pli_shape* const with_null[2] = {s.shape, NULL};
    pli_transform bad_pose = pli_transform_identity();
    bad_pose.origin.x = INFINITY;
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 2, with_null, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 1, shapes, &bad_pose), PLI_ERROR_NOT_FINITE);
    bad_pose = pli_transform_identity();
    bad_pose.rotation.rows[1].y = 1.5f;
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 1, shapes, &bad_pose), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_rigid_set_shapes(s.rigid, -1, shapes, NULL), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 1, NULL, NULL), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_rigid_set_shapes(NULL, 1, shapes, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_non_null(strstr(pli_last_error(s.context), "pli_rigid_set_shapes"));
    scene_destroy(&s);
}

/* A ball that has grown between two steps, without a word of where it is: the rope stays on what is there now. */
static void test_new_shapes_count_from_the_next_step(void** unused) {
    (void)unused;
    scene s = scene_make();
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    pli_shape* large = NULL;
    const pli_vec3 from = pli_vec3_make(-0.1f, 1.1f, 0), to = pli_vec3_make(0.1f, 1.1f, 0);
    assert_int_equal(pli_mesh_create_rope(s.context, from, to, 3, 0, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(s.world, mesh, NULL, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_enable_rigid_contacts(rope, NULL), PLI_OK);
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 1, &s.shape, NULL), PLI_OK);
    assert_int_equal(pli_world_step(s.world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(pli_shape_create_sphere(s.context, 1, &large), PLI_OK);
    assert_int_equal(pli_rigid_set_shapes(s.rigid, 1, &large, NULL), PLI_OK);
    pli_shape_release(large);
    float nearest = 2;
    for (int i = 0; i < 30; ++i) {
        assert_int_equal(pli_world_step(s.world, 1.0f / 60.0f), PLI_OK);
        nearest = fminf(nearest, pli_body_get_view(rope).positions[1].y);
    }
    check_near(nearest, 1.0, 0.03);
    scene_destroy(&s);
}

/* When turned in single precision the first spin takes 0.26 % onto the trace. */
static void test_an_even_spin_keeps_the_inertia(void** unused) {
    (void)unused;
    const pli_vec3 spins[] = {{0, 3, 0}, {0.1f, 0.2f, -0.3f}, {0.01f, 0.02f, 0.015f}};
    for (int k = 0; k < 3; ++k) {
        scene s = scene_make();
        pli_rigid_state state = pli_rigid_get_state(s.rigid);
        const pli_mat3 principal = {{{1, 0, 0}, {0, 2, 0}, {0, 0, 4}}};
        state.inverse_mass = 1;
        state.inverse_inertia_world = principal;
        state.angular_velocity = spins[k];
        assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_DYNAMIC, &state), PLI_OK);
        for (int i = 0; i < 200000; ++i) {
            assert_int_equal(pli_rigid_integrate(s.rigid, pli_vec3_make(0, 0, 0), 1.0f / 60.0f), PLI_OK);
        }
        state = pli_rigid_get_state(s.rigid);
        const pli_mat3 rotation = state.pose.rotation, inertia = state.inverse_inertia_world;
        const pli_mat3 expected = pli_mat3_mul(pli_mat3_mul(rotation, principal), pli_mat3_transpose(rotation));
        check_near(inertia.rows[0].x + inertia.rows[1].y + inertia.rows[2].z, 7, 7e-4f);
        for (int i = 0; i < 3; ++i) {
            const pli_vec3 off = pli_vec3_sub(inertia.rows[i], expected.rows[i]);
            check_near(pli_vec3_length(off), 0, 2e-3f);
        }
        scene_destroy(&s);
    }
}

/* Largest difference of two rotations' numbers. */
static float rotation_error(pli_mat3 a, pli_mat3 b) {
    float most = 0;
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 d = pli_vec3_sub(a.rows[i], b.rows[i]);
        most = fmaxf(most, fmaxf(fabsf(d.x), fmaxf(fabsf(d.y), fabsf(d.z))));
    }
    return most;
}

/* By small, large and half turns, from where the step before has left it; a node that is anchored is there too. */
static void test_kinematic_bodies_are_led_to_poses(void** unused) {
    (void)unused;
    static const pli_quat turns[] = {{0, 0, 0, 1},  {0.01f, 0, 0, 1},     {0, 0, 0.3f, 0.7f},
                                     {1, 0, 0, 0},  {0, 1, 0, 0},         {0, 0, 1, 0},
                                     {1, -1, 0, 0}, {0.5f, 2, -1, -0.2f}, {-1, -1, -1, 0.1f}};
    enum { TURNS = sizeof turns / sizeof *turns };
    const float dt = 1.0f / 60;
    const pli_vec3 none = pli_vec3_make(0, 0, 0), pivot = pli_vec3_make(0, 0.5f, 0.25f);
    scene s = scene_make();
    const pli_rigid_state start = dynamic_state();
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_KINEMATIC, &start), PLI_OK);
    pli_mesh* mesh;
    pli_body* rope;
    assert_int_equal(pli_mesh_create_rope(s.context, none, pli_vec3_make(0, -1, 0), 2, 0, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(s.world, mesh, NULL, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = s.rigid;
    anchor.local_pivot = &pivot;
    assert_int_equal(pli_body_add_anchor(rope, &anchor, NULL), PLI_OK);
    for (int from = 0; from < TURNS; ++from) {
        for (int to = 0; to < TURNS; ++to) {
            pli_rigid_state state = pli_rigid_get_state(s.rigid);
            state.pose = pli_transform_make(turns[from], pli_vec3_make((float)from, 1, 0));
            assert_int_equal(pli_rigid_set_state(s.rigid, &state), PLI_OK);
            const pli_transform goal = pli_transform_make(turns[to], pli_vec3_make(3, (float)to, -2));
            assert_int_equal(pli_rigid_move(s.rigid, goal, dt), PLI_OK);
            assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
            assert_int_equal(pli_rigid_integrate(s.rigid, none, dt), PLI_OK);
            state = pli_rigid_get_state(s.rigid);
            check_at_most(pli_vec3_length(pli_vec3_sub(state.pose.origin, goal.origin)), 2e-6);
            check_at_most(rotation_error(state.pose.rotation, goal.rotation), 2e-6);
            check_at_most(pli_vec3_length(state.angular_velocity), (double)(3.1416f / dt));
            const pli_vec4 node = pli_body_get_view(rope).positions[0];
            const pli_vec3 held = pli_transform_point(goal, pivot);
            check_at_most(pli_vec3_length(pli_vec3_sub(pli_vec3_make(node.x, node.y, node.z), held)), 2e-5);

            /* Led to where it is, it stays to the bit. */
            assert_int_equal(pli_rigid_move(s.rigid, goal, dt), PLI_OK);
            state = pli_rigid_get_state(s.rigid);
            check_near(pli_vec3_length(state.linear_velocity), 0, 0);
            check_near(pli_vec3_length(state.angular_velocity), 0, 0);
        }
    }
    scene_destroy(&s);
}

static void test_what_cannot_be_led_is_refused(void** unused) {
    (void)unused;
    scene s = scene_make();
    const pli_rigid_state start = dynamic_state();
    pli_transform goal = pli_transform_identity();
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0.1f), PLI_ERROR_WRONG_STATE); /* static */
    assert_string_equal(pli_last_error(s.context), "pli_rigid_move: the rigid body is not kinematic");
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_DYNAMIC, &start), PLI_OK);
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0.1f), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_rigid_set_kind(s.rigid, PLI_RIGID_KINEMATIC, &start), PLI_OK);
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_rigid_move(s.rigid, goal, NAN), PLI_ERROR_NOT_FINITE);
    goal.origin.y = NAN;
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0.1f), PLI_ERROR_NOT_FINITE);
    goal.origin.y = 2 * PLI_MAX_COORDINATE;
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0.1f), PLI_ERROR_INVALID_VALUE);
    goal.origin.y = 1e5f; /* in a microsecond: 1e11 m/s */
    assert_int_equal(pli_rigid_move(s.rigid, goal, PLI_MIN_TIME_STEP), PLI_ERROR_INVALID_VALUE);
    goal.rotation.rows[0].x = 2;
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0.1f), PLI_ERROR_INVALID_VALUE);
    goal.rotation.rows[0].x = NAN;
    assert_int_equal(pli_rigid_move(s.rigid, goal, 0.1f), PLI_ERROR_NOT_FINITE);
    const pli_rigid_state state = pli_rigid_get_state(s.rigid);
    assert_memory_equal(&state.linear_velocity, &start.linear_velocity, sizeof start.linear_velocity);
    scene_destroy(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_kind_may_change),
        cmocka_unit_test(test_kinematic_bodies_are_led_to_poses),
        cmocka_unit_test(test_what_cannot_be_led_is_refused),
        cmocka_unit_test(test_what_was_dynamic_does_not_fall),
        cmocka_unit_test(test_factors_may_change),
        cmocka_unit_test(test_shapes_may_change_and_anchors_stay),
        cmocka_unit_test(test_new_shapes_count_from_the_next_step),
        cmocka_unit_test(test_an_even_spin_keeps_the_inertia),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
