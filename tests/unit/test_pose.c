/* Pose matching: rigid motion is recovered and left alone, the rest shape comes back, degenerate shapes stay finite. */

#include "failing_allocator.h"
#include "sample_mesh.h"
#include "solver_choice.h"

#include <string.h>

static const float dt = 1.0f / 60.0f;

/* Takes the mesh over. */
static pli_body* make_body(pli_mesh* mesh) {
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static pli_body* make_ball(float size) {
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_ellipsoid(context, pli_vec3_make(size, 1.4f * size, 0.7f * size), &mesh), PLI_OK);
    return make_body(mesh);
}

static pli_vec3 position_of(const pli_body* body, int node) {
    const pli_vec4 p = pli_body_get_view(body).positions[node];
    return pli_vec3_make(p.x, p.y, p.z);
}

static float rotation_distance(pli_mat3 a, pli_mat3 b) {
    float largest = 0.0f;
    for (int i = 0; i < 3; ++i) {
        largest = fmaxf(largest, pli_vec3_length(pli_vec3_sub(a.rows[i], b.rows[i])));
    }
    return largest;
}

static uint32_t random_state = 3;
static float random_float(float size) {
    random_state = random_state * 1664525u + 1013904223u;
    return ((float)(random_state >> 8) / 8388608.0f - 1.0f) * size;
}

static void test_the_pose_of_a_moved_body_is_the_motion(void** unused) {
    (void)unused;
    pli_body* body = make_ball(1);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    pli_transform pose;
    assert_int_equal(pli_body_get_pose(body, &pose), PLI_OK);
    check_near(rotation_distance(pose.rotation, pli_mat3_identity()), 0, 0);
    check_near(pli_vec3_length(pose.origin), 0, 1e-6);

    const pli_transform motion =
        pli_transform_make(pli_quat_from_yaw_pitch_roll(2.0f, -0.5f, 1.0f), pli_vec3_make(4, -2, 1));
    assert_int_equal(pli_body_transform(body, motion), PLI_OK);
    pli_vec3 before[SAMPLE_SPHERE_NODES];
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        before[i] = position_of(body, i);
    }
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_get_pose(body, &pose), PLI_OK);
    check_at_most(rotation_distance(pose.rotation, motion.rotation), 2e-6);
    check_at_most(pli_vec3_length(pli_vec3_sub(pose.origin, motion.origin)), 2e-6);
    /* The shape fits already: nothing moves. */
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        check_at_most(pli_vec3_length(pli_vec3_sub(position_of(body, i), before[i])), 3e-6);
    }
}

/* Without links, or their iterations, a full match returns to the rest shape in one step, half a match halves the
   distance. */
static void test_matching_is_the_share_of_the_distance_removed(void** unused) {
    (void)unused;
    for (int k = 1; k <= 4; ++k) {
        const float matching = k % 2 == 1 ? 0.5f : 1;
        pli_body* body = make_ball(1);
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.position_iterations = 0;
        assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
        if (k > 2) { assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK); }
        assert_int_equal(pli_body_enable_pose_matching(body, matching), PLI_OK);
        pli_vec3 rest[SAMPLE_SPHERE_NODES], moved[SAMPLE_SPHERE_NODES];
        for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
            rest[i] = position_of(body, i);
            moved[i] = pli_vec3_add(rest[i], pli_vec3_make(random_float(0.2f), random_float(0.2f), random_float(0.2f)));
        }
        assert_int_equal(pli_body_set_state(body, moved, NULL), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        pli_transform pose;
        assert_int_equal(pli_body_get_pose(body, &pose), PLI_OK);
        for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
            const pli_vec3 goal = pli_transform_point(pose, rest[i]);
            const pli_vec3 expected = pli_vec3_lerp(moved[i], goal, matching);
            check_at_most(pli_vec3_length(pli_vec3_sub(position_of(body, i), expected)), k > 2 ? 2e-6 : 1e-6);
        }
        pli_body_destroy(body);
    }
}

static void expect_kept_momentum(pli_body* body) {
    pli_vec3 velocities[SAMPLE_SPHERE_NODES], positions[SAMPLE_SPHERE_NODES];
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        positions[i] = position_of(body, i);
        velocities[i] = pli_vec3_make(2.0f + random_float(1), random_float(1), random_float(1));
    }
    assert_int_equal(pli_body_set_state(body, positions, velocities), PLI_OK);
    const pli_vec3 before = pli_body_momentum(body);
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    const pli_vec3 after = pli_body_momentum(body);
    check_at_most(pli_vec3_length(pli_vec3_sub(after, before)) / pli_vec3_length(before), 1e-4);
}

static void test_matching_keeps_the_momentum(void** unused) {
    (void)unused;
    pli_body* body = make_ball(1);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.3f), PLI_OK);
    expect_kept_momentum(body);
}

/* Weights are those of the masses that there are: else what pulls at the nodes moves the whole. */
static void test_matching_keeps_the_momentum_of_other_masses(void** unused) {
    (void)unused;
    pli_body* body = make_ball(1);
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.position_iterations = 1; /* floats lose more in each */
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.3f), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(body, 0, 20.0f), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(body, 5, 0.01f), PLI_OK);
    expect_kept_momentum(body);
}

/* A kilometre away floats are 0.06 mm apart; what many nodes sum up to is no worse. */
static void test_matching_pulls_at_nothing_far_away(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(context, 50, 1.0f, 0, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_translate(mesh, pli_vec3_make(1000, 0, 0)), PLI_OK);
    pli_body* body = make_body(mesh);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    assert_int_equal(pli_body_add_velocity(body, pli_vec3_make(10, 0, 0)), PLI_OK);
    for (int i = 0; i < 120; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    check_near(pli_body_momentum(body).x / pli_body_total_mass(body), 10, 0.01);
}

/* From 2 cm to 200 m, hung up by a node. */
static void test_a_pinned_body_of_any_size_keeps_its_shape(void** unused) {
    (void)unused;
    for (float size = 0.01f; size < 150; size *= 10) {
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10 * size, 0)), PLI_OK);
        pli_body* body = make_ball(size);
        const float volume = pli_body_volume(body);
        assert_int_equal(pli_body_set_node_mass(body, 0, 0), PLI_OK);
        assert_int_equal(pli_body_enable_pose_matching(body, 0.3f), PLI_OK);
        for (int i = 0; i < 120; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        const float left = pli_body_volume(body) / volume, stretch = pli_body_max_stretch(body);
        print_message("%g m: volume %.4f of that at rest, stretch %.4f\n", (double)size, (double)left, (double)stretch);
        check_near(left, 1, 0.01);
        check_at_most(stretch, 0.05);
        pli_body_destroy(body);
    }
}

/* A ball of 1 m has come to lie after ten seconds: friction holds the nodes that matching pushes about on the ground.
 */
static void test_a_ball_on_the_ground_stays_where_it_lies(void** unused) {
    (void)unused;
    static const solver_choice solvers[] = {POSITION, SWEEPS, GRADIENTS, XPBD};
    pli_shape* box = NULL;
    assert_int_equal(pli_shape_create_box(context, pli_vec3_make(20, 1, 20), &box), PLI_OK);
    pli_rigid_def ground = pli_rigid_def_default();
    ground.shapes = &box;
    ground.shape_count = 1;
    ground.state.pose.origin.y = -1;
    assert_int_equal(pli_rigid_create(world, &ground, &(pli_rigid*){NULL}), PLI_OK);
    pli_shape_release(box);
    for (size_t k = 0; k < sizeof solvers / sizeof *solvers; ++k) {
        pli_mesh* mesh = NULL;
        pli_body* ball = NULL;
        const pli_vec3 centre = pli_vec3_make(0, 1.1f, 0), radii = pli_vec3_make(1, 1, 1);
        assert_int_equal(pli_mesh_create_ellipsoid(context, centre, radii, 150, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 1), PLI_OK);
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.02f;
        def.solver.position_iterations = 4;
        def.solver.velocity_damping = 0.05f;
        assert_int_equal(pli_body_create(world, mesh, &def, &ball), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        contacts.friction = 0.5f;
        assert_int_equal(pli_body_enable_rigid_contacts(ball, &contacts), PLI_OK);
        use_solver(ball, solvers[k]);
        assert_int_equal(pli_body_enable_pose_matching(ball, 0.3f), PLI_OK);
        pli_vec3 before = {0, 0, 0};
        for (int i = 0; i < 1200; ++i) {
            if (i == 600) { before = middle_of(ball); }
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        const float way = pli_vec3_length(pli_vec3_sub(middle_of(ball), before));
        print_message("solver %d: %.2g mm in ten seconds\n", (int)solvers[k], 1000 * (double)way);
        check_at_most(way, 0.002);
        pli_body_destroy(ball);
    }
}

/* A flat body may be taken out of the world, where it freezes. */
static void check_stays_finite(pli_body* body, float matching) {
    assert_int_equal(pli_body_enable_pose_matching(body, matching), PLI_OK);
    for (int i = 0; i < 30; ++i) {
        const pli_transform turn =
            pli_transform_make(pli_quat_from_yaw_pitch_roll(0.3f, 0.7f, -0.4f), pli_vec3_make(0.1f, 0, 0));
        const bool was_frozen = pli_body_is_frozen(body);
        const pli_status moved = pli_body_transform(body, turn);
        assert_true(moved == PLI_OK || (moved == PLI_ERROR_INVALID_VALUE && was_frozen));
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        int events = 0;
        (void)pli_world_get_events(world, &events);
        assert_true(pli_body_is_frozen(body) == (was_frozen || events > 0));
        for (int k = 0; k < pli_body_get_view(body).node_count; ++k) {
            assert_true(isfinite(pli_vec3_length(position_of(body, k))));
        }
        pli_transform pose;
        assert_int_equal(pli_body_get_pose(body, &pose), PLI_OK);
        for (int r = 0; r < 3; ++r) {
            assert_true(isfinite(pli_vec3_length(pose.rotation.rows[r])));
        }
        assert_true(isfinite(pli_vec3_length(pose.origin)));
    }
    pli_body_destroy(body);
}

static void test_degenerate_shapes_stay_finite(void** unused) {
    (void)unused;
    for (int k = 0; k < 6; ++k) {
        pli_mesh* mesh = NULL;
        if (k == 0) { /* flat in a coordinate plane */
            assert_int_equal(sample_create_sheet(context, 7, 0.5f, 0, &mesh), PLI_OK);
        } else if (k == 1) { /* flat and tilted */
            assert_int_equal(sample_create_sheet(context, 7, 0.5f, 0, &mesh), PLI_OK);
            assert_int_equal(pli_mesh_rotate(mesh, pli_quat_from_yaw_pitch_roll(1, 2, 3)), PLI_OK);
        } else if (k == 2) { /* a line */
            assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(1, 1, 1), pli_vec3_make(4, 3, 2), 9, 0, &mesh),
                             PLI_OK);
        } else if (k == 3) { /* all pinned */
            assert_int_equal(sample_create_sheet(context, 2, 0.5f, PLI_PATCH_PIN_CORNERS, &mesh), PLI_OK);
        } else { /* one node, or two in one place */
            assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
            for (int i = 3; i < k; ++i) {
                assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(2, 2, 2), 1.0f, NULL), PLI_OK);
            }
        }
        check_stays_finite(make_body(mesh), 0.4f);
    }
}

/* Whole numbers and a power of two of nodes keep the covariance of a folded sheet singular without rounding. */
static void test_a_shape_squashed_flat_stays_finite(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < 8; ++i) {
        const pli_vec3 corner =
            pli_vec3_make((i & 1) != 0 ? 2.0f : -2.0f, (i & 2) != 0 ? 2.0f : -2.0f, (i & 4) != 0 ? 2.0f : -2.0f);
        assert_int_equal(pli_mesh_append_node(mesh, corner, 1.0f, NULL), PLI_OK);
    }
    pli_body* body = make_body(mesh);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    pli_vec3 squashed[8];
    for (int i = 0; i < 8; ++i) { /* onto the plane y = z */
        const pli_vec3 p = position_of(body, i);
        squashed[i] = pli_vec3_make(p.x, p.z, p.z);
    }
    assert_int_equal(pli_body_set_state(body, squashed, NULL), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_false(pli_body_is_frozen(body));
    pli_transform pose;
    assert_int_equal(pli_body_get_pose(body, &pose), PLI_OK);
    for (int r = 0; r < 3; ++r) {
        check_near(pli_vec3_length(pose.rotation.rows[r]), 1, 1e-5);
    }
}

static float height_above(pli_vec3 point, void* level) {
    return point.y - *(float*)level;
}
static void refine_at(pli_body* body, float level, bool cut) {
    pli_refine_def def = pli_refine_def_default();
    def.surface = height_above;
    def.user = &level;
    def.cut = cut;
    assert_int_equal(pli_body_refine(body, &def), PLI_OK);
}

static uint64_t hash_after(pli_world* some_world, int steps) {
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(some_world, dt), PLI_OK);
    }
    return pli_body_state_hash(pli_world_get_body(some_world, 0));
}

/* A ball hangs from its top and is cut in two: the lower half falls as one piece, the upper one stays. So it does from
   a snapshot and from a file. */
static void test_parts_of_a_cut_body_have_a_pose_each(void** unused) {
    (void)unused;
    static const solver_choice solvers[] = {POSITION, SWEEPS, GRADIENTS, XPBD};
    static unsigned char snapshot[1 << 16], file[1 << 16];
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
    const int low = SAMPLE_SPHERE_NODES - 1, side = sample_sphere_node(SAMPLE_RINGS - 2, 0);
    for (int k = 0; k < 4; ++k) {
        pli_body* body = make_ball(1);
        const float width = pli_vec3_length(pli_vec3_sub(position_of(body, low), position_of(body, side)));
        assert_int_equal(pli_body_set_node_mass(body, 0, 0), PLI_OK);
        use_solver(body, solvers[k]);
        assert_int_equal(pli_body_enable_pose_matching(body, 0.3f), PLI_OK);
        (void)hash_after(world, 30);
        refine_at(body, 0.3f, false); /* does not part it */
        (void)hash_after(world, 30);
        check_near(position_of(body, low).y, -1.4, 0.05);
        refine_at(body, 0.1f, true);
        int parts = 0;
        assert_int_equal(pli_body_count_parts(body, &parts), PLI_OK);
        assert_int_equal(parts, 2);
        const float start = position_of(body, low).y;
        (void)hash_after(world, 10);
        size_t size = 0, file_size = 0;
        assert_int_equal(pli_world_save(world, snapshot, sizeof snapshot, &size), PLI_OK);
        assert_int_equal(pli_world_file_write(world, NULL, file, sizeof file, &file_size), PLI_OK);
        const uint64_t hash = hash_after(world, 20);
        assert_int_equal(pli_world_restore(world, snapshot, size), PLI_OK);
        assert_true(hash_after(world, 20) == hash);
        pli_world* other = NULL;
        assert_int_equal(pli_world_file_create(context, NULL, file, file_size, &other), PLI_OK);
        assert_true(hash_after(other, 20) == hash);
        pli_world_destroy(other);
        const float fallen = start - position_of(body, low).y;
        const float left = pli_vec3_length(pli_vec3_sub(position_of(body, low), position_of(body, side))) / width;
        print_message("solver %d: the lower half falls %.3f m, its width %.4f, the upper one is at %.3f m\n",
                      (int)solvers[k], (double)fallen, (double)left, (double)position_of(body, 1).y);
        check_near(fallen, 1.29, 0.015);
        check_near(left, 1, 0.001);
        check_near(position_of(body, 1).y, 1.286, 0.015);
        /* A snapshot in which all is pinned has them apart too. */
        const int node_count = pli_body_get_view(body).node_count;
        float masses[4 * SAMPLE_SPHERE_NODES];
        assert_true(node_count <= 4 * SAMPLE_SPHERE_NODES);
        for (int i = 0; i < node_count; ++i) {
            const float inverse_mass = pli_body_get_view(body).positions[i].w;
            masses[i] = inverse_mass > 0.0f ? 1.0f / inverse_mass : 0.0f;
            assert_int_equal(pli_body_set_node_mass(body, i, 0), PLI_OK);
            assert_int_equal(pli_body_set_node_velocity(body, i, pli_vec3_make(0, 0, 0)), PLI_OK);
        }
        (void)hash_after(world, 1);
        assert_int_equal(pli_world_save(world, snapshot, sizeof snapshot, &size), PLI_OK);
        assert_int_equal(pli_world_restore(world, snapshot, size), PLI_OK);
        for (int i = 0; i < node_count; ++i) {
            assert_int_equal(pli_body_set_node_mass(body, i, masses[i]), PLI_OK);
        }
        const float pinned = position_of(body, low).y;
        (void)hash_after(world, 30);
        check_near(pinned - position_of(body, low).y, 1.28, 0.03);
        pli_body_destroy(body);
    }
}

static void test_enabling_again_takes_a_new_rest_shape(void** unused) {
    (void)unused;
    pli_body* body = make_ball(1);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    const size_t bytes = pli_body_bytes(body);
    pli_vec3 stretched[SAMPLE_SPHERE_NODES];
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        const pli_vec3 p = position_of(body, i);
        stretched[i] = pli_vec3_make(2.0f * p.x, p.y, p.z);
    }
    assert_int_equal(pli_body_set_state(body, stretched, NULL), PLI_OK);
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.position_iterations = 0;
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    assert_int_equal(pli_body_enable_pose_matching(body, 1.0f), PLI_OK);
    assert_int_equal(pli_body_bytes(body), bytes);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        check_at_most(pli_vec3_length(pli_vec3_sub(position_of(body, i), stretched[i])), 2e-6);
    }
}

static void test_memory_is_counted_and_given_back(void** unused) {
    (void)unused;
    pli_body* body = make_ball(1);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    assert_int_equal(pli_body_disable_pose_matching(body), PLI_OK);
    const size_t allocated = pli_context_allocated_bytes(context), bytes = pli_body_bytes(body);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    assert_int_equal(pli_context_allocated_bytes(context) - allocated, pli_body_bytes(body) - bytes);
    assert_true(pli_body_bytes(body) >= bytes + SAMPLE_SPHERE_NODES * 4 * sizeof(float));
    const uint64_t count = pli_context_allocation_count(context);
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_context_allocation_count(context), count);
    assert_int_equal(pli_body_disable_pose_matching(body), PLI_OK);
    assert_int_equal(pli_context_allocated_bytes(context), allocated);
}

static pli_status enable(pli_context* c, void* unused) {
    (void)unused;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    pli_status status = pli_world_create(c, NULL, &w);
    if (status == PLI_OK) { status = sample_create_ellipsoid(c, pli_vec3_make(1, 1, 1), &mesh); }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &body); }
    if (status == PLI_OK) { status = pli_body_enable_pose_matching(body, 0.5f); }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_running_out_of_memory_leaves_nothing(void** unused) {
    (void)unused;
    assert_true(check_survives_failing_allocator(enable, NULL) > 10);
}

static void test_bad_input_is_refused(void** unused) {
    (void)unused;
    pli_body* body = make_ball(1);
    const size_t bytes = pli_context_allocated_bytes(context);
    pli_transform pose;
    memset(&pose, 1, sizeof pose);
    const pli_transform untouched = pose;
    assert_int_equal(pli_body_enable_pose_matching(NULL, 0.5f), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_get_pose(NULL, &pose), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_get_pose(body, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_non_null(strstr(pli_last_error(context), "pose is null"));
    assert_int_equal(pli_body_get_pose(body, &pose), PLI_ERROR_WRONG_STATE);
    assert_non_null(strstr(pli_last_error(context), "not enabled"));
    assert_int_equal(memcmp(&pose, &untouched, sizeof pose), 0);
    assert_int_equal(pli_body_enable_pose_matching(body, NAN), PLI_ERROR_NOT_FINITE);
    assert_non_null(strstr(pli_last_error(context), "matching is nan"));
    assert_int_equal(pli_body_enable_pose_matching(body, 1.5f), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(context), "matching is 1.5"));
    assert_int_equal(pli_body_enable_pose_matching(body, -0.1f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_context_allocated_bytes(context), bytes);
    assert_int_equal(pli_body_disable_pose_matching(body), PLI_OK);
    assert_int_equal(pli_body_disable_pose_matching(NULL), PLI_ERROR_NULL_ARGUMENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_the_pose_of_a_moved_body_is_the_motion, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_matching_is_the_share_of_the_distance_removed, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_matching_keeps_the_momentum, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_matching_keeps_the_momentum_of_other_masses, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_matching_pulls_at_nothing_far_away, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_pinned_body_of_any_size_keeps_its_shape, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_ball_on_the_ground_stays_where_it_lies, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_degenerate_shapes_stay_finite, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_shape_squashed_flat_stays_finite, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_parts_of_a_cut_body_have_a_pose_each, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_enabling_again_takes_a_new_rest_shape, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_memory_is_counted_and_given_back, setup_weightless_world, teardown_world),
        cmocka_unit_test(test_running_out_of_memory_leaves_nothing),
        cmocka_unit_test_setup_teardown(test_bad_input_is_refused, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
