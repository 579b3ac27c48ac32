/* Targets: where nodes are after each step under each solver, backstops, energy, teleports, cuts, what they cost, bad
   input. */

#include "failing_allocator.h"
#include "hanging_cape.h"

enum { FRAMES = 120, MOST = COLUMNS * ROWS };

static pli_target targets[MOST];
static pli_vec3 places[MOST], normals[MOST];

/* The first `count` nodes, at distances from 0 on; where they are. */
static pli_targets_def targets_of(const pli_body* body, int count, float max_distance) {
    for (int i = 0; i < count; ++i) {
        targets[i] = (pli_target){.node = i, .max_distance = max_distance};
        places[i] = xyz(pli_body_get_view(body).positions[i]);
        normals[i] = pli_vec3_make(0, 0, 1);
    }
    pli_targets_def def = pli_targets_def_default();
    def.targets = targets;
    def.count = count;
    return def;
}

/* As a skeleton that runs along x at 6 m/s and turns about y. */
static pli_transform pose_at(int frame, float spin) {
    const float time = (float)frame * dt;
    return pli_transform_make(pli_quat_from_yaw_pitch_roll(spin * time, 0, 0), pli_vec3_make(6 * time, 0, 0));
}

static void move_to(pli_body* body, const pli_vec3* rest, int count, int frame, float spin) {
    for (int i = 0; i < count; ++i) {
        places[i] = pli_transform_point(pose_at(frame, spin), rest[i]);
        normals[i] = pli_mat3_mul_vec3(pose_at(frame, spin).rotation, pli_vec3_make(0, 0, 1));
    }
    assert_int_equal(pli_body_move_targets(body, places, normals, count), PLI_OK);
}

static float farthest(const pli_body* body, int count) {
    float most = 0;
    for (int i = 0; i < count; ++i) {
        most = fmaxf(most, distance(xyz(pli_body_get_view(body).positions[i]), places[i]));
    }
    return most;
}

static void test_nodes_are_at_their_targets_under_each_solver(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* cape = make_cape(ROWS);
        use_solver(cape, (solver_choice)which);
        const pli_targets_def def = targets_of(cape, COLUMNS, 0);
        pli_vec3 rest[COLUMNS];
        memcpy(rest, places, sizeof rest);
        const float weight = pli_body_get_view(cape).positions[3].w;
        assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
        assert_int_equal(pli_body_enable_tethers(cape, NULL), PLI_OK);
        assert_int_equal(pli_body_get_tether(cape, 3 + 5 * COLUMNS).origin, 3);
        float apart = 0, longer = 0;
        for (int frame = 1; frame <= FRAMES; ++frame) {
            move_to(cape, rest, COLUMNS, 3 * frame, 9);
            move_to(cape, rest, COLUMNS, frame, 20); /* the last call counts */
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            apart = fmaxf(apart, farthest(cape, COLUMNS));
            longer = fmaxf(longer, longest_tether(cape));
        }
        print_message("solver %d: %.1e m from targets, tethers %.2f %% longer\n", which, (double)apart,
                      100 * (double)longer);
        check_at_most(apart, 1e-5);
        check_at_most(longer, 0.03);
        for (int k = 0; k < 3; ++k) { /* nobody calls: they stay */
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            check_at_most(farthest(cape, COLUMNS), 1e-5);
            check_near(pli_vec3_length(xyz(pli_body_get_view(cape).velocities[3])), 0, 0);
        }
        assert_int_equal(pli_body_disable_targets(cape), PLI_OK);
        check_near(pli_body_get_view(cape).positions[3].w, weight, 0);
        for (int k = 0; k < 5; ++k) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        assert_true(farthest(cape, COLUMNS) > 1e-3f);
        pli_body_destroy(cape);
    }
}

/* All nodes within 5 cm of a skin that runs and turns: none gets further away, and those that are drawn along go as
   fast as their targets, without a jerk. */
static void test_no_node_is_further_than_its_distance(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* cape = make_cape(ROWS);
        use_solver(cape, (solver_choice)which);
        const pli_targets_def def = targets_of(cape, MOST, 0.05f);
        static pli_vec3 rest[MOST];
        memcpy(rest, places, sizeof rest);
        assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
        float apart = 0, slowest = 1e9f, fastest = 0;
        for (int frame = 1; frame <= FRAMES; ++frame) {
            move_to(cape, rest, MOST, frame, frame < FRAMES / 2 ? 0.0f : 2.0f);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            apart = fmaxf(apart, farthest(cape, MOST));
            if (frame < 30 || frame >= FRAMES / 2) { continue; }
            for (int i = 0; i < MOST; ++i) {
                const float speed = xyz(pli_body_get_view(cape).velocities[i]).x;
                slowest = fminf(slowest, speed);
                fastest = fmaxf(fastest, speed);
            }
        }
        print_message("solver %d: %.4f m from targets at most, %.2f to %.2f m/s at 6\n", which, (double)apart,
                      (double)slowest, (double)fastest);
        check_at_most(apart, 0.05 + 1e-4);
        assert_true(slowest > 4.5f && fastest < 7.5f);
        assert_false(pli_body_is_frozen(cape));
        pli_body_destroy(cape);
    }
}

/* A cape that lies on a level skin sinks to its backstop, and no deeper; a sphere, or a plane by its radius. */
static void check_backstop(solver_choice which, float radius, float behind) {
    pli_body* cape = make_cape(ROWS);
    use_solver(cape, which);
    assert_int_equal(
        pli_body_transform(cape, pli_transform_make(pli_quat_from_yaw_pitch_roll(0, 1.5707963f, 0), places[0])),
        PLI_OK);
    pli_targets_def def = targets_of(cape, MOST, 0.1f);
    for (int i = 0; i < MOST; ++i) {
        targets[i].backstop_radius = radius;
        targets[i].backstop_distance = behind;
        normals[i] = pli_vec3_make(0, 3, 0);
    }
    def.normals = normals;
    assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
    float lowest = 0, deepest = 0, apart = 0;
    for (int frame = 0; frame < FRAMES; ++frame) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        for (int i = 0; i < MOST; ++i) {
            const pli_vec3 x = xyz(pli_body_get_view(cape).positions[i]);
            const double up = (double)(x.y - places[i].y), dx = (double)(x.x - places[i].x),
                         dz = (double)(x.z - places[i].z), h = (double)behind + (double)radius + up;
            deepest = fmaxf(deepest, (float)((double)radius - sqrt(h * h + dx * dx + dz * dz)));
            lowest = fminf(lowest, (float)up);
        }
        apart = fmaxf(apart, farthest(cape, MOST));
    }
    print_message("solver %d, radius %g: lowest %.5f m, %.1e m in the backstop\n", (int)which, (double)radius,
                  (double)lowest, (double)deepest);
    check_at_most(apart, 0.1 + 1e-5);
    check_at_most(deepest, 1e-5);
    if (behind > 0) { assert_true(lowest < -0.9f * behind); }
    assert_false(pli_body_is_frozen(cape));
    pli_body_destroy(cape);
}

/* Pushed aside and down, nodes go along the backstop until the ball around their targets ends: they come to lie on the
   circle where both meet. */
static void test_a_backstop_and_a_distance_hold_together(void** unused) {
    (void)unused;
    const double radius = 0.3, behind = 0.01, most = 0.1;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* cape = make_cape(ROWS);
        use_solver(cape, (solver_choice)which);
        pli_targets_def def = targets_of(cape, MOST, (float)most);
        for (int i = 0; i < MOST; ++i) {
            targets[i].backstop_radius = (float)radius;
            targets[i].backstop_distance = (float)behind;
            normals[i] = pli_vec3_make(0, 1, 0);
        }
        def.normals = normals;
        assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(10, -10, 0)), PLI_OK);
        for (int frame = 0; frame < FRAMES; ++frame) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        const double height = behind + radius;
        const double along = (radius * radius - height * height - most * most) / (2 * height);
        for (int i = 0; i < MOST; ++i) {
            const pli_vec3 apart = pli_vec3_sub(xyz(pli_body_get_view(cape).positions[i]), places[i]);
            check_near(apart.y, along, 2e-4);
            check_near(hypotf(apart.x, apart.z), sqrt(most * most - along * along), 2e-4);
        }
        pli_body_destroy(cape);
    }
}

static void test_no_node_enters_its_backstop(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        check_backstop((solver_choice)which, 1e6f, 0.02f);
        check_backstop((solver_choice)which, 40, 0.02f);
        check_backstop((solver_choice)which, 0.3f, 0.02f);
        check_backstop((solver_choice)which, 0.3f, -0.05f); /* the sphere lifts them */
    }
}

static float energy_of(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float sum = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const float mass = view.positions[i].w > 0 ? 1 / view.positions[i].w : 0;
        sum += mass * (0.5f * pli_vec3_length_squared(xyz(view.velocities[i])) + 10 * view.positions[i].y);
    }
    return sum;
}

static void test_targets_that_stand_give_no_energy(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* cape = make_cape(ROWS);
        use_solver(cape, (solver_choice)which);
        const pli_targets_def def = targets_of(cape, MOST, 0.2f);
        assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
        assert_int_equal(pli_body_add_velocity(cape, pli_vec3_make(3, 0, 5)), PLI_OK);
        const float start = energy_of(cape);
        float most = -1e9f;
        for (int frame = 0; frame < 3 * FRAMES; ++frame) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            most = fmaxf(most, energy_of(cape));
        }
        print_message("solver %d: energy %.3f, at most %.3f J, in the end %.3f J\n", which, (double)start, (double)most,
                      (double)energy_of(cape));
        assert_true(most <= start + 0.01f * fabsf(start));
        pli_body_destroy(cape);
    }
}

static void test_a_teleport_is_no_motion(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* cape = make_cape(ROWS);
        use_solver(cape, (solver_choice)which);
        const pli_targets_def def = targets_of(cape, MOST, 0.05f);
        for (int i = 0; i < COLUMNS; ++i) {
            targets[i].max_distance = 0;
        }
        assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
        for (int i = 0; i < MOST; ++i) {
            places[i].x += 100;
        }
        const pli_transform away = pli_transform_make(pli_quat_identity(), pli_vec3_make(100, 0, 0));
        assert_int_equal(pli_body_transform(cape, away), PLI_OK);
        assert_int_equal(pli_body_teleport_targets(cape, places, NULL, MOST), PLI_OK);
        check_at_most(farthest(cape, MOST), 0.05 + 1e-5);
        check_near(farthest(cape, COLUMNS), 0, 0);
        for (int frame = 0; frame < 10; ++frame) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            check_at_most(farthest(cape, MOST), 0.05 + 1e-4);
            for (int i = 0; i < MOST; ++i) {
                check_at_most(fabsf(pli_body_get_view(cape).velocities[i].x), 0.5);
            }
            check_near(farthest(cape, COLUMNS), 0, 0);
        }
        pli_body_destroy(cape);
    }
}

static void test_a_cut_gives_new_nodes_the_targets_between(void** unused) {
    (void)unused;
    pli_body* cape = make_cape(ROWS);
    const pli_targets_def def = targets_of(cape, MOST, 0.05f);
    for (int i = 0; i < COLUMNS; ++i) {
        targets[i].max_distance = 0;
    }
    static pli_vec3 rest[MOST];
    memcpy(rest, places, sizeof rest);
    assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
    assert_int_equal(pli_body_cut_swept(cape, pli_vec3_make(0.01f, -0.8f, -1), pli_vec3_make(0.01f, -0.8f, 1),
                                        pli_vec3_make(0.01f, 0.1f, -1), pli_vec3_make(0.01f, 0.1f, 1), NULL),
                     PLI_OK);
    assert_true(pli_body_get_view(cape).node_count > MOST);
    for (int frame = 1; frame <= FRAMES; ++frame) {
        move_to(cape, rest, MOST, frame, 0);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    const pli_body_view view = pli_body_get_view(cape);
    for (int i = MOST; i < view.node_count; ++i) {
        const pli_vec3 x = xyz(view.positions[i]);
        assert_true(fabsf(x.x - 12) < 0.12f && x.y < 0.06f && x.y > -0.81f); /* 6 m/s for 2 s */
    }
    assert_int_equal(pli_body_disable_targets(cape), PLI_OK);
    for (int i = 0; i < view.node_count; ++i) {
        assert_true(view.positions[i].w > 0);
    }
}

/* Masses that nodes have again when they are let go. */
static void test_a_cut_between_held_nodes_keeps_the_mass(void** unused) {
    (void)unused;
    pli_body* cape = make_cape(ROWS);
    const float mass = pli_body_total_mass(cape);
    const pli_targets_def def = targets_of(cape, MOST, 0.05f);
    for (int i = 0; i < COLUMNS; ++i) {
        targets[i].max_distance = 0;
    }
    assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
    for (int i = 0; i + 1 < COLUMNS; ++i) {
        assert_int_equal(pli_body_cut_link(cape, i, i + 1, 0.3f), PLI_OK);
    }
    assert_int_equal(pli_body_disable_targets(cape), PLI_OK);
    check_near(pli_body_total_mass(cape), mass, 1e-4f * mass);
}

static void test_steps_take_no_memory(void** unused) {
    (void)unused;
    pli_body* cape = make_cape(ROWS);
    const size_t before = pli_context_allocated_bytes(context);
    const pli_targets_def def = targets_of(cape, MOST, 0.05f);
    assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
    const size_t used = pli_context_allocated_bytes(context) - before;
    print_message("%.1f B per target\n", (double)used / MOST);
    check_at_most((double)used / MOST, 150);
    const uint64_t count = pli_context_allocation_count(context);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_body_move_targets(cape, places, NULL, MOST), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_true(pli_context_allocation_count(context) == count);
    assert_int_equal(pli_body_disable_targets(cape), PLI_OK);
    assert_true(pli_context_allocated_bytes(context) <= before + 256);
}

static void test_bad_input_changes_nothing(void** unused) {
    (void)unused;
    pli_body* cape = make_cape(ROWS);
    pli_targets_def def = targets_of(cape, 3, 0.1f);
    const pli_status value = PLI_ERROR_INVALID_VALUE;
    check_refused(pli_body_move_targets(cape, places, NULL, 3), value, "the body has 0 targets");
    assert_int_equal(pli_body_enable_targets(NULL, &def), PLI_ERROR_NULL_ARGUMENT);
    check_refused(pli_body_enable_targets(cape, NULL), PLI_ERROR_NULL_ARGUMENT, "def");
    check_refused(pli_body_enable_targets(cape, &(pli_targets_def){0}), PLI_ERROR_INVALID_DEF, "default");
    def.targets = NULL;
    check_refused(pli_body_enable_targets(cape, &def), PLI_ERROR_NULL_ARGUMENT, "targets is null");
    def.targets = targets;
    def.count = -2;
    check_refused(pli_body_enable_targets(cape, &def), value, "count is -2");
    def.count = 3;
    targets[2].node = MOST;
    check_refused(pli_body_enable_targets(cape, &def), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 1000 of target 2");
    targets[2].node = 0;
    check_refused(pli_body_enable_targets(cape, &def), value, "targets 0 and 2 are both of node 0");
    targets[2].node = 2;
    targets[1].max_distance = -1;
    check_refused(pli_body_enable_targets(cape, &def), value, "max_distance of target 1");
    targets[1].max_distance = NAN;
    check_refused(pli_body_enable_targets(cape, &def), PLI_ERROR_NOT_FINITE, "max_distance of target 1");
    targets[1].max_distance = 0.1f;
    targets[1].backstop_radius = 1;
    check_refused(pli_body_enable_targets(cape, &def), value, "normals is null, target 1");
    def.normals = normals;
    targets[1].backstop_distance = -0.2f;
    check_refused(pli_body_enable_targets(cape, &def), value, "backstop_distance of target 1");
    targets[1].backstop_distance = 0;
    normals[1] = pli_vec3_make(0, 0, 0);
    check_refused(pli_body_enable_targets(cape, &def), value, "normal 1 has no length");
    normals[1] = pli_vec3_make(0, 0, 1);
    places[2].x = INFINITY;
    def.positions = places;
    check_refused(pli_body_enable_targets(cape, &def), PLI_ERROR_NOT_FINITE, "position 2");
    places[2].x = 0;
    def.positions = NULL;
    assert_true(pli_body_get_view(cape).positions[0].w > 0);

    assert_int_equal(pli_body_enable_targets(cape, &def), PLI_OK);
    check_refused(pli_body_move_targets(cape, places, NULL, 2), value, "count is 2, the body has 3");
    check_refused(pli_body_move_targets(cape, NULL, NULL, 3), PLI_ERROR_NULL_ARGUMENT, "positions is null");
    places[1].y = 2e6f;
    check_refused(pli_body_teleport_targets(cape, places, NULL, 3), value, "position 1");
    places[1].y = 0;
    normals[1] = pli_vec3_make(0, 0, 0);
    check_refused(pli_body_move_targets(cape, places, normals, 3), value, "normal 1 has no length");
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_refused(pli_body_move_targets(cape, places, NULL, 3), PLI_ERROR_WRONG_STATE, "between predict and solve");
    assert_int_equal(pli_world_solve(world), PLI_OK);
}

static pli_status target_and_release(pli_context* own, void* unused) {
    (void)unused;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    const pli_target two[] = {{.node = 0}, {.node = 3, .max_distance = 1}};
    pli_targets_def def = pli_targets_def_default();
    def.targets = two;
    def.count = 2;
    pli_status status = pli_world_create(own, NULL, &w);
    if (status == PLI_OK) {
        status = pli_mesh_create_rope(own, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 4, 0, &mesh);
    }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &rope); }
    if (status == PLI_OK) {
        status = pli_body_enable_targets(rope, &def);
        assert_true((pli_body_get_view(rope).positions[0].w == 0) == (status == PLI_OK));
    }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_running_out_of_memory_leaves_nothing(void** unused) {
    (void)unused;
    assert_true(check_survives_failing_allocator(target_and_release, NULL) > 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_nodes_are_at_their_targets_under_each_solver, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_no_node_is_further_than_its_distance, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_no_node_enters_its_backstop, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_backstop_and_a_distance_hold_together, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_targets_that_stand_give_no_energy, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_teleport_is_no_motion, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_cut_gives_new_nodes_the_targets_between, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_cut_between_held_nodes_keeps_the_mass, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_steps_take_no_memory, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_input_changes_nothing, setup_world, teardown_world),
        cmocka_unit_test(test_running_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
