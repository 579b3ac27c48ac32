/* Joints: balance of momentum, what they hold, motors and steering, ids, life, what they cost, bad input. */

#include "test_cluster_world.h"

static const float dt = 1.0f / 60.0f;

static void check_error(pli_status status, pli_status expected, const char* part) {
    assert_int_equal(status, expected);
    if (strstr(pli_last_error(context), part) == NULL) {
        fail_msg("the message \"%s\" does not say \"%s\"", pli_last_error(context), part);
    }
}

/* A ball that keeps its shape, of one cluster and 86 kg. */
static pli_body* make_solid(pli_vec3 centre) {
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), centre, 0.1f);
    assert_int_equal(pli_body_generate_clusters(body, 1, 100, NULL), PLI_OK);
    match_clusters(body, 0.2f);
    return body;
}

static pli_joint_id add_linear(pli_body* body, pli_joint_end other, pli_vec3 position, float split) {
    pli_linear_joint_def def = pli_linear_joint_def_default();
    def.other = other;
    def.position = position;
    def.softness.split = split;
    pli_joint_id id = {0, 0};
    assert_int_equal(pli_body_add_linear_joint(body, &def, &id), PLI_OK);
    return id;
}

static pli_joint_id add_angular(pli_body* body, pli_joint_end other, pli_vec3 axis, float split,
                                pli_joint_controller controller) {
    pli_angular_joint_def def = pli_angular_joint_def_default();
    def.other = other;
    def.axis = axis;
    def.softness.split = split;
    def.controller = controller;
    pli_joint_id id = {0, 0};
    assert_int_equal(pli_body_add_angular_joint(body, &def, &id), PLI_OK);
    return id;
}

static const pli_joint_controller free_joint = {NULL, NULL, NULL};

static pli_joint_end end_of_body(pli_body* body) {
    return (pli_joint_end){.body = body};
}
static pli_joint_end end_of_rigid(pli_rigid* rigid) {
    return (pli_joint_end){.rigid = rigid};
}

static void spin(pli_body* body, pli_vec3 about, pli_vec3 angular_velocity, pli_vec3 velocity) {
    const int count = pli_body_get_view(body).node_count;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 arm = pli_vec3_sub(position_of(body, i), about);
        const pli_vec3 v = pli_vec3_add(velocity, pli_vec3_cross(angular_velocity, arm));
        assert_int_equal(pli_body_set_node_velocity(body, i, v), PLI_OK);
    }
}

// --------------------------------------------------------------------------------------------------------- mechanics

/* Positions are integrated, so angular momentum is kept but for terms with the length of the step; velocities are
   differences of positions, so momentum is kept but for the rounding of positions divided by the step. */
static void test_cluster_and_rigid_keep_their_momenta(void** unused) {
    (void)unused;
    const float small = 1.0f / 120.0f;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 40, 25, pli_vec3_make(2, 0.5f, 0), NULL);
    add_linear(body, end_of_rigid(rigid), pli_vec3_make(1, 0.2f, 0.1f), 1);
    add_angular(body, end_of_rigid(rigid), pli_vec3_make(0, 1, 0), 0.5f, free_joint);
    spin(body, pli_vec3_make(0, 0, 0), pli_vec3_make(0.3f, 0.5f, 1), pli_vec3_make(0, 1, 0.5f));
    momenta before = {{0}, {0}};
    momenta_add_body(&before, body);
    momenta_add_rigid(&before, rigid);
    double linear = 0, angular = 0;
    for (int i = 0; i < 500; ++i) {
        assert_int_equal(pli_world_step(world, small), PLI_OK);
        assert_true(pli_rigid_was_touched(rigid));
        momenta after = {{0}, {0}};
        momenta_add_body(&after, body);
        momenta_add_rigid(&after, rigid);
        linear = fmax(linear, largest_difference(after.linear, before.linear));
        angular = fmax(angular, largest_difference(after.angular, before.angular));
        assert_int_equal(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), small), PLI_OK);
    }
    print_message("           of 96 kg m/s, 61 kg m^2/s lost: %.3g, %.3g\n", linear, angular);
    check_at_most(linear, 0.06);
    check_at_most(angular, 0.5);
    /* A good part of it went over. */
    assert_true(pli_vec3_length(pli_rigid_get_state(rigid).linear_velocity) > 0.3f);
}

/* A joint holds a body where it is now, though it was moved and turned since the step before. */
static void test_a_joint_starts_where_the_body_was_moved_to(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    pli_transform moved = pli_transform_identity();
    moved.rotation = (pli_mat3){{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
    moved.origin = pli_vec3_make(3, 4, 5);
    assert_int_equal(pli_body_transform(body, moved), PLI_OK);
    const pli_vec3 before = position_of(body, 0);
    add_linear(body, (pli_joint_end){0}, pli_vec3_make(3, 5, 5), 1);
    add_angular(body, (pli_joint_end){0}, pli_vec3_make(0, 1, 0), 1, free_joint);
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    check_at_most(pli_vec3_length(pli_vec3_sub(position_of(body, 0), before)), 1e-4);
}

static void test_two_bodies_keep_their_momenta(void** unused) {
    (void)unused;
    const float small = 1.0f / 120.0f;
    pli_body* a = make_solid(pli_vec3_make(0, 0, 0));
    pli_body* b = make_solid(pli_vec3_make(2.2f, 0.3f, 0));
    add_linear(a, end_of_body(b), pli_vec3_make(1.1f, 0.2f, 0.1f), 0);
    add_angular(b, end_of_body(a), pli_vec3_make(0, 0, 1), 0, free_joint);
    spin(a, pli_vec3_make(0, 0, 0), pli_vec3_make(0.3f, 0.5f, 1), pli_vec3_make(0, 1, 0.5f));
    momenta before = {{0}, {0}};
    momenta_add_body(&before, a);
    momenta_add_body(&before, b);
    double linear = 0, angular = 0;
    for (int i = 0; i < 500; ++i) {
        assert_int_equal(pli_world_step(world, small), PLI_OK);
        momenta after = {{0}, {0}};
        momenta_add_body(&after, a);
        momenta_add_body(&after, b);
        linear = fmax(linear, largest_difference(after.linear, before.linear));
        angular = fmax(angular, largest_difference(after.angular, before.angular));
    }
    print_message("           of 96 kg m/s, 61 kg m^2/s lost: %.3g, %.3g\n", linear, angular);
    check_at_most(linear, 0.4);
    check_at_most(angular, 1.0);
    assert_true(pli_vec3_length(cluster_of(b, 0).linear_velocity) > 0.3f);
}

/* Tied to a rigid body that moves as it does, a cluster is where it would be at rest, and neither pulls the other. */
static void test_what_flies_together_stays_together(void** unused) {
    (void)unused;
    const pli_rigid_kind kinds[] = {PLI_RIGID_KINEMATIC, PLI_RIGID_DYNAMIC};
    const pli_vec3 none = pli_vec3_make(0, 0, 0), velocity = pli_vec3_make(10, 0, 5), turn = pli_vec3_make(0, 0, 3);
    for (int k = 0; k < 4; ++k) {
        const bool turns = k >= 2;
        pli_body* body = make_solid(none);
        pli_rigid* rigid = make_rigid(kinds[k % 2], 20, 10, turns ? none : pli_vec3_make(2, 0, 0), NULL);
        pli_rigid_state state = pli_rigid_get_state(rigid);
        state.linear_velocity = turns ? none : velocity;
        state.angular_velocity = turns ? turn : none;
        assert_int_equal(pli_rigid_set_state(rigid, &state), PLI_OK);
        spin(body, none, state.angular_velocity, state.linear_velocity);
        if (turns) {
            add_angular(body, end_of_rigid(rigid), pli_vec3_make(1, 0, 0), 0.5f, free_joint);
        } else {
            add_linear(body, end_of_rigid(rigid), pli_vec3_make(1, 0, 0), 0.5f);
        }
        for (int i = 0; i < 60; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            assert_int_equal(pli_rigid_integrate(rigid, none, dt), PLI_OK);
            const pli_transform frame = cluster_of(body, 0).frame, pose = pli_rigid_get_state(rigid).pose;
            const pli_vec3 apart = pli_vec3_sub(pose.origin, frame.origin);
            check_near(pli_vec3_length(apart), turns ? 0 : 2, 1e-3);
            const pli_vec3 x = pli_vec3_make(1, 0, 0);
            const pli_vec3 axis = pli_mat3_mul_vec3(frame.rotation, x), other = pli_mat3_mul_vec3(pose.rotation, x);
            check_at_most(pli_vec3_length(pli_vec3_sub(axis, other)), 0.01);
        }
        check_near(cluster_of(body, 0).linear_velocity.x, turns ? 0 : 10, 1e-2);
        check_near(pli_rigid_get_state(rigid).angular_velocity.z, turns ? 3 : 0, 0.5);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

/* A body of any mass swings on a cluster of pinned nodes as on the world. */
static void test_pinned_cluster_holds_what_is_heavy(void** unused) {
    (void)unused;
    const float masses[] = {1, 100, 1e4f};
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 points[] = {{0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0.5f}};
        const int nodes[] = {0, 1, 2, 3};
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
        pli_body* body = make_points(points, 4, 0.05f);
        for (int i = 0; i < 4; ++i) {
            assert_int_equal(pli_body_set_node_mass(body, i, 0), PLI_OK);
        }
        assert_int_equal(pli_body_add_cluster(body, nodes, 4, NULL), PLI_OK);
        pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, masses[k], 0.1f * masses[k], pli_vec3_make(1.5f, 0, 0), NULL);
        add_linear(body, end_of_rigid(rigid), pli_vec3_make(0.5f, 0, 0), 1);
        double farthest = 0, lowest = 0;
        for (int i = 0; i < 240; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            assert_int_equal(pli_rigid_integrate(rigid, pli_world_get_gravity(world), dt), PLI_OK);
            const pli_vec3 arm = pli_vec3_sub(pli_rigid_get_state(rigid).pose.origin, pli_vec3_make(0.5f, 0, 0));
            farthest = fmax(farthest, fabs((double)pli_vec3_length(arm) - 1));
            lowest = fmin(lowest, (double)arm.y);
        }
        check_at_most(farthest, 0.02);
        check_at_most(lowest, -0.98);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

static void test_linear_joint_holds_a_pendulum(void** unused) {
    (void)unused;
    const float splits[] = {0.0f, 0.5f, 1.0f};
    for (int k = 0; k < 3; ++k) {
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
        pli_body* body = make_solid(pli_vec3_make(2, 0, 0));
        const pli_joint_end fixed = {NULL, 0, NULL};
        add_linear(body, fixed, pli_vec3_make(0, 0, 0), splits[k]);
        double farthest = 0, lowest = 0;
        for (int i = 0; i < 300; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            const pli_vec3 centre = cluster_of(body, 0).frame.origin;
            farthest = fmax(farthest, fabs((double)pli_vec3_length(centre) - 2.0));
            lowest = fmin(lowest, (double)centre.y);
        }
        print_message("           split %g: off by at most %.3g m\n", (double)splits[k], farthest);
        check_at_most(farthest, 0.01);
        assert_true(lowest < -1.8);
        pli_body_destroy(body);
    }
}

/* Of all pairs of nodes, m. */
static double longest_distance(const pli_body* body) {
    const int count = pli_body_get_view(body).node_count;
    double longest = 0;
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < i; ++k) {
            const pli_vec3 apart = pli_vec3_sub(position_of(body, i), position_of(body, k));
            longest = fmax(longest, (double)pli_vec3_length(apart));
        }
    }
    return longest;
}

/* A game puts what holds a body elsewhere at once. */
static void test_joint_follows_what_is_put_elsewhere(void** unused) {
    (void)unused;
    const float shifts[] = {1, 3, 10};
    for (int k = 0; k < 3; ++k) {
        pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
        pli_rigid* rigid = make_rigid(PLI_RIGID_KINEMATIC, 1, 1, pli_vec3_make(1, 0, 0), NULL);
        add_linear(body, end_of_rigid(rigid), pli_vec3_make(1, 0, 0), 1);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        const double size = longest_distance(body);
        pli_rigid_state state = pli_rigid_get_state(rigid);
        state.pose.origin.y = shifts[k];
        assert_int_equal(pli_rigid_set_state(rigid, &state), PLI_OK);
        double largest = 0, fastest = 0;
        for (int i = 0; i < 120; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            largest = fmax(largest, longest_distance(body));
            const pli_body_view view = pli_body_get_view(body);
            for (int n = 0; n < view.node_count; ++n) {
                const pli_vec4 v = view.velocities[n];
                fastest = fmax(fastest, (double)pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
            }
        }
        const pli_vec3 end = pli_transform_point(cluster_of(body, 0).frame, pli_vec3_make(1, 0, 0));
        print_message("           %g m off: %.3g times as large, nodes at %.3g m/s\n", (double)shifts[k],
                      largest / size, fastest);
        check_at_most(pli_vec3_length(pli_vec3_sub(end, state.pose.origin)), 1e-3);
        check_at_most(largest / size, 1.07);
        check_at_most(fastest, 3.6);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

/* The tips of an ellipsoid, clusters of 25 and of one of its nodes, hold it to the world. */
static void test_joints_hold_parts_of_a_body(void** unused) {
    (void)unused;
    const struct { double off, speed; /* m, m/s */ } most[] = {{0.02, 2.4}, {1.3, 7}, {0.006, 0.15}, {0.8, 2.5}};
    for (int k = 0; k < 4; ++k) {
        const float reach = k % 2 == 0 ? 1.2f : 1.9f;
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
        pli_body* body = make_ball(pli_vec3_make(0.5f, 2, 0.5f), pli_vec3_make(0, 0, 0), 0.05f);
        if (k >= 2) {
            assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK);
            const pli_xpbd_links_def links = pli_xpbd_links_def_default();
            assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
        }
        for (int side = -1; side <= 1; side += 2) {
            int nodes[SAMPLE_SPHERE_NODES], count = 0, cluster = 0;
            for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
                if (position_of(body, i).y * (float)side > reach) { nodes[count++] = i; }
            }
            assert_int_equal(pli_body_add_cluster(body, nodes, count, &cluster), PLI_OK);
            pli_linear_joint_def def = pli_linear_joint_def_default();
            def.cluster = cluster;
            def.position = pli_vec3_make(0, 2.0f * (float)side, 0);
            assert_int_equal(pli_body_add_linear_joint(body, &def, NULL), PLI_OK);
        }
        double fastest = 0, farthest = 0;
        for (int i = 0; i < 300; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            const pli_vec3 tip = position_of(body, 0);
            farthest = fmax(farthest, (double)pli_vec3_length(pli_vec3_sub(tip, pli_vec3_make(0, 2, 0))));
            const pli_body_view view = pli_body_get_view(body);
            for (int n = 0; n < view.node_count; ++n) {
                const pli_vec4 v = view.velocities[n];
                fastest = fmax(fastest, (double)pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
            }
        }
        print_message("           %s: upper tip off by %.3g m, nodes at %.3g m/s\n", k >= 2 ? "XPBD" : "position-based",
                      farthest, fastest);
        check_at_most(farthest, most[k].off);
        check_at_most(fastest, most[k].speed);
        pli_body_destroy(body);
    }
}

/* Five balls in a row on the world, the last of which is ten times as heavy, swing by their joints. */
static void test_chains_hold_what_is_heavy(void** unused) {
    (void)unused;
    enum { COUNT = 5 };
    const float masses[] = {1, 10, 50, 100}, most[] = {0.035f, 0.055f, 0.09f, 0.02f};
    for (int k = 0; k < 4; ++k) {
        const int sub_steps = k == 3 ? 4 : 1;
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
        pli_body* balls[COUNT];
        for (int i = 0; i < COUNT; ++i) {
            balls[i] = make_solid(pli_vec3_make(1.1f + 2.2f * (float)i, 0, 0));
            for (int n = 0; i + 1 == COUNT && n < pli_body_get_view(balls[i]).node_count; ++n) {
                assert_int_equal(pli_body_set_node_mass(balls[i], n, masses[k]), PLI_OK);
            }
            assert_int_equal(pli_body_reset_clusters(balls[i]), PLI_OK);
            add_linear(balls[i], i > 0 ? end_of_body(balls[i - 1]) : (pli_joint_end){0},
                       pli_vec3_make(2.2f * (float)i, 0, 0), 1);
        }
        double widest = 0;
        for (int i = 0; i < 300 * sub_steps; ++i) {
            assert_int_equal(pli_world_step(world, dt / (float)sub_steps), PLI_OK);
            for (int b = 0; b < COUNT; ++b) {
                const pli_vec3 left = pli_vec3_make(-1.1f, 0, 0), right = pli_vec3_make(1.1f, 0, 0);
                const pli_vec3 end = pli_transform_point(cluster_of(balls[b], 0).frame, left);
                const pli_vec3 other =
                    b > 0 ? pli_transform_point(cluster_of(balls[b - 1], 0).frame, right) : pli_vec3_make(0, 0, 0);
                widest = fmax(widest, (double)pli_vec3_length(pli_vec3_sub(end, other)));
            }
        }
        print_message("           last of %g times the mass: joints open by %.3g m\n", (double)masses[k], widest);
        check_at_most(widest, (double)most[k]);
        for (int i = COUNT - 1; i >= 0; --i) {
            pli_body_destroy(balls[i]);
        }
    }
}

static void test_joints_to_what_is_not_present_hold_nothing(void** unused) {
    (void)unused;
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 4, 2, pli_vec3_make(0, 3, 0), NULL);
    add_linear(body, end_of_rigid(rigid), pli_vec3_make(0, 1, 0), 0.5f);
    assert_int_equal(pli_rigid_set_present(rigid, false), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_false(pli_rigid_was_touched(rigid));
    check_near(pli_body_momentum(body).y, -10.0 * (double)dt * (double)pli_body_total_mass(body), 0.01);
    check_near(pli_rigid_get_state(rigid).linear_velocity.y, 0.0, 0.0);
    assert_int_equal(pli_rigid_set_present(rigid, true), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_true(pli_rigid_was_touched(rigid));
    assert_true(pli_rigid_get_state(rigid).linear_velocity.y < -0.1f);
}

/* The axes of two bodies that turn differently come together and stay. */
static void test_angular_joint_aligns_axes(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 40, 25, pli_vec3_make(5, 0, 0), NULL);
    /* Not of unit length. */
    add_angular(body, end_of_rigid(rigid), pli_vec3_make(0, 3, 0), 0.5f, free_joint);
    spin(body, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 2, 0.5f), pli_vec3_make(0, 0, 0));
    for (int i = 0; i < 120; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), dt), PLI_OK);
    }
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const pli_cluster_view view = cluster_of(body, 0);
    const pli_rigid_state state = pli_rigid_get_state(rigid);
    const pli_vec3 axis = pli_mat3_mul_vec3(view.frame.rotation, pli_vec3_make(0, 1, 0));
    const pli_vec3 other = pli_mat3_mul_vec3(state.pose.rotation, pli_vec3_make(0, 1, 0));
    print_message("           axes apart by %.3g rad\n", acos(fmin(1.0, (double)pli_vec3_dot(axis, other))));
    assert_true(pli_vec3_dot(axis, other) > 0.998f);
    /* Free about the axis, which now points elsewhere. */
    const float difference = pli_vec3_dot(pli_vec3_sub(view.angular_velocity, state.angular_velocity), axis);
    assert_true(fabsf(difference) > 1.0f);
}

typedef struct motor {
    float goal, largest_change;
    int calls;
} motor;

static float motor_speed(float present, void* user) {
    motor* self = user;
    self->calls += 1;
    const float change = self->goal - present;
    const float limit = self->largest_change;
    return present + (change > limit ? limit : change < -limit ? -limit : change);
}

static void test_motor_reaches_its_speed(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    pli_rigid* axle = make_rigid(PLI_RIGID_STATIC, 1, 1, pli_vec3_make(0, 0, 0), NULL);
    motor drive = {4, 0.05f, 0};
    const pli_joint_controller controller = {NULL, motor_speed, &drive};
    add_linear(body, end_of_rigid(axle), pli_vec3_make(0, 0, 0), 1);
    add_angular(body, end_of_rigid(axle), pli_vec3_make(0, 0, 1), 1, controller);
    float speeds[2] = {0, 0};
    for (int i = 0; i < 120; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        if (i == 9) { speeds[0] = cluster_of(body, 0).angular_velocity.z; }
    }
    speeds[1] = cluster_of(body, 0).angular_velocity.z;
    /* Four iterations a step, 0.05 rad/s each. */
    print_message("           %.3f rad/s after 10 steps, %.3f after 120\n", (double)speeds[0], (double)speeds[1]);
    check_near(speeds[0], 2, 0.3);
    check_near(speeds[1], 4, 0.2);
    assert_int_equal(drive.calls, 120 * 4);
}

static float speed_nan(float present, void* user) {
    (void)present;
    (void)user;
    return NAN;
}
static pli_vec3 steer_nan(pli_vec3 axis, void* user) {
    (void)axis;
    ++*(int*)user;
    return pli_vec3_make(NAN, 0, 0);
}
static pli_vec3 steer_zero(pli_vec3 axis, void* user) {
    (void)axis;
    ++*(int*)user;
    return pli_vec3_make(0, 0, 0);
}

static void test_useless_controllers_are_harmless(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    const pli_joint_end fixed = {NULL, 0, NULL};
    int calls = 0;
    const pli_joint_controller bad[2] = {{steer_nan, speed_nan, &calls}, {steer_zero, NULL, &calls}};
    add_angular(body, fixed, pli_vec3_make(1, 0, 0), 1, bad[0]);
    add_angular(body, fixed, pli_vec3_make(1, 0, 0), 1, bad[1]);
    spin(body, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 0.5f, 0), pli_vec3_make(0, 0, 0));
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_true(is_finite_body(body));
    }
    assert_int_equal(calls, 120);
    /* The old axis stayed, and the joints are free about it. */
    assert_true(cluster_of(body, 0).angular_velocity.x > 1.5f);
}

static void test_frozen_body_takes_no_impulses(void** unused) {
    (void)unused;
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, -10, 0)), PLI_OK);
    pli_body* frozen = make_solid(pli_vec3_make(0, 3, 0));
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    add_linear(body, end_of_body(frozen), pli_vec3_make(0, 2, 0), 1);
    add_linear(frozen, end_of_body(body), pli_vec3_make(0.5f, 2, 0), 1);
    assert_int_equal(pli_body_set_frozen(frozen, true), PLI_OK);
    const uint64_t hash = pli_body_state_hash(frozen);
    for (int i = 0; i < 200; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_true(pli_body_state_hash(frozen) == hash);
    /* Its own joints rest, that of the other body holds. */
    const pli_vec3 arm = pli_vec3_sub(cluster_of(body, 0).frame.origin, pli_vec3_make(0, 2, 0));
    check_near(pli_vec3_length(arm), 2, 0.35);
    assert_int_equal(pli_body_set_frozen(frozen, false), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_true(pli_body_state_hash(frozen) != hash);
}

// -------------------------------------------------------------------------------------------------------------- life

static void test_ids_become_stale(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    const pli_joint_end fixed = {NULL, 0, NULL};
    const pli_joint_id a = add_linear(body, fixed, pli_vec3_make(1, 0, 0), 1);
    const pli_joint_id b = add_linear(body, fixed, pli_vec3_make(0, 1, 0), 1);
    const pli_joint_id c = add_angular(body, fixed, pli_vec3_make(0, 1, 0), 1, free_joint);
    assert_int_equal(pli_body_joint_count(body), 3);
    assert_int_equal(pli_body_remove_joint(body, a), PLI_OK);
    check_error(pli_body_remove_joint(body, a), PLI_ERROR_STALE_ID, "joint 1 of generation 1 is gone");
    const pli_joint_id d = add_linear(body, fixed, pli_vec3_make(0, 0, 1), 1);
    assert_int_equal(d.index1, a.index1);
    assert_int_not_equal(d.generation, a.generation);
    check_error(pli_body_remove_joint(body, a), PLI_ERROR_STALE_ID, "is gone");
    assert_int_equal(pli_body_remove_joint(body, c), PLI_OK);
    assert_int_equal(pli_body_remove_joint(body, b), PLI_OK);
    assert_int_equal(pli_body_remove_joint(body, d), PLI_OK);
    assert_int_equal(pli_body_joint_count(body), 0);
    const pli_joint_id none = {0, 0}, negative = {-1, 1}, outside = {9, 1};
    check_error(pli_body_remove_joint(body, none), PLI_ERROR_STALE_ID, "is gone");
    check_error(pli_body_remove_joint(body, negative), PLI_ERROR_STALE_ID, "is gone");
    check_error(pli_body_remove_joint(body, outside), PLI_ERROR_STALE_ID, "is gone");
}

static void test_joints_go_with_what_they_hold(void** unused) {
    (void)unused;
    pli_body* a = make_solid(pli_vec3_make(0, 0, 0));
    pli_body* b = make_solid(pli_vec3_make(3, 0, 0));
    pli_body* c = make_solid(pli_vec3_make(6, 0, 0));
    pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 4, 2, pli_vec3_make(0, 3, 0), NULL);
    const pli_joint_end fixed = {NULL, 0, NULL};
    const pli_joint_id held = add_linear(a, fixed, pli_vec3_make(0, -1, 0), 1);
    const pli_joint_id to_rigid = add_linear(a, end_of_rigid(rigid), pli_vec3_make(0, 1, 0), 1);
    add_linear(a, end_of_body(b), pli_vec3_make(1, 0, 0), 1);
    add_linear(b, end_of_body(a), pli_vec3_make(1, 1, 0), 1);
    add_linear(c, end_of_body(b), pli_vec3_make(5, 0, 0), 1);
    add_linear(c, end_of_body(a), pli_vec3_make(5, 1, 0), 1);
    assert_int_equal(pli_body_joint_count(a), 3);
    pli_rigid_destroy(rigid);
    assert_int_equal(pli_body_joint_count(a), 2);
    int count = 0;
    const pli_event* events = pli_world_get_events(world, &count);
    assert_int_equal(count, 1);
    assert_int_equal(events[0].kind, PLI_EVENT_ANCHORS_LOST);
    assert_ptr_equal(events[0].body, a);
    check_error(pli_body_remove_joint(a, to_rigid), PLI_ERROR_STALE_ID, "is gone");
    pli_body_destroy(b);
    assert_int_equal(pli_body_joint_count(a), 1);
    assert_int_equal(pli_body_joint_count(c), 1);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_generate_clusters(a, 3, 100, NULL), PLI_OK);
    assert_int_equal(pli_body_joint_count(a), 0);
    assert_int_equal(pli_body_joint_count(c), 0);
    check_error(pli_body_remove_joint(a, held), PLI_ERROR_STALE_ID, "is gone");
    add_linear(a, fixed, pli_vec3_make(0, -1, 0), 1);
    add_linear(c, end_of_body(a), pli_vec3_make(5, 1, 0), 1);
    assert_int_equal(pli_body_disable_clusters(a), PLI_OK);
    assert_int_equal(pli_body_joint_count(a), 0);
    assert_int_equal(pli_body_joint_count(c), 0);
    add_linear(c, fixed, pli_vec3_make(5, 1, 0), 1);
    assert_int_equal(pli_body_remove_clusters(c), PLI_OK);
    assert_int_equal(pli_body_joint_count(c), 0);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_true(is_finite_body(a) && is_finite_body(c));
}

/* Clusters that are made while only contacts need them stay when contacts end, with their joints. */
static void test_joints_go_with_clusters_not_with_contacts(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    pli_body* other = make_solid(pli_vec3_make(3, 0, 0));
    assert_int_equal(pli_body_enable_clusters(body, NULL), PLI_OK);
    assert_int_equal(pli_body_enable_cluster_contacts(body, NULL), PLI_OK);
    assert_int_equal(pli_body_disable_clusters(body), PLI_OK);
    assert_int_equal(pli_body_generate_clusters(body, 1, 100, NULL), PLI_OK);
    add_linear(body, end_of_body(other), pli_vec3_make(1.5f, 0, 0), 1);
    add_linear(other, end_of_body(body), pli_vec3_make(1.5f, 0, 0), 1);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_disable_cluster_contacts(body), PLI_OK);
    assert_int_equal(pli_body_cluster_count(body), 1);
    assert_int_equal(pli_body_joint_count(body), 1);
    assert_int_equal(pli_body_joint_count(other), 1);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_disable_clusters(body), PLI_OK);
    assert_int_equal(pli_body_cluster_count(body), 0);
    assert_int_equal(pli_body_joint_count(body), 0);
    assert_int_equal(pli_body_joint_count(other), 0);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
}

/* A cluster that is added leaves the joints of the others alone. */
static void test_added_clusters_keep_joints(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    const pli_joint_end fixed = {NULL, 0, NULL};
    add_linear(body, fixed, pli_vec3_make(1, 0, 0), 1);
    const int nodes[] = {0, 1, 2, 3, 4};
    for (int i = 0; i < 20; ++i) {
        assert_int_equal(pli_body_add_cluster(body, nodes, 5, NULL), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_body_joint_count(body), 1);
    assert_true(is_finite_body(body));
}

// ---------------------------------------------------------------------------------------------------- memory, errors

static void test_steady_steps_allocate_nothing(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    const pli_joint_end fixed = {NULL, 0, NULL};
    add_linear(body, fixed, pli_vec3_make(1, 0, 0), 1);
    add_angular(body, fixed, pli_vec3_make(0, 1, 0), 1, free_joint);
    const uint64_t count = pli_context_allocation_count(context);
    for (int i = 0; i < 20; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_context_allocation_count(context), count);
}

static pli_status make_joints(pli_context* c, void* user) {
    (void)user;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    pli_status status = pli_world_create(c, NULL, &w);
    if (status == PLI_OK) { status = sample_create_ellipsoid(c, pli_vec3_make(1, 1, 1), &mesh); }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &body); }
    if (status == PLI_OK) { status = pli_body_generate_clusters(body, 1, 100, NULL); }
    for (int i = 0; i < 12 && status == PLI_OK; ++i) {
        pli_linear_joint_def linear = pli_linear_joint_def_default();
        pli_angular_joint_def angular = pli_angular_joint_def_default();
        angular.axis = pli_vec3_make(0, 1, 0);
        const bool is_linear = i % 2 == 0;
        const int features = pli_body_get_features(body, 0, NULL);
        status = is_linear ? pli_body_add_linear_joint(body, &linear, NULL)
                           : pli_body_add_angular_joint(body, &angular, NULL);
        assert_int_equal(pli_body_joint_count(body), status == PLI_OK ? i + 1 : i);
        if (status != PLI_OK) { assert_int_equal(pli_body_get_features(body, 0, NULL), features); }
    }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_out_of_memory_leaves_joints_as_they_were(void** unused) {
    (void)unused;
    const int failures = check_survives_failing_allocator(make_joints, NULL);
    print_message("           %d failures\n", failures);
    assert_true(failures > 20);
}

static void test_bad_input(void** unused) {
    (void)unused;
    pli_body* body = make_solid(pli_vec3_make(0, 0, 0));
    pli_body* bare = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 4, 2, pli_vec3_make(0, 3, 0), NULL);
    pli_linear_joint_def linear = pli_linear_joint_def_default();
    pli_angular_joint_def angular = pli_angular_joint_def_default();
    assert_int_equal(pli_body_add_linear_joint(NULL, &linear, NULL), PLI_ERROR_NULL_ARGUMENT);
    check_error(pli_body_add_linear_joint(body, NULL, NULL), PLI_ERROR_NULL_ARGUMENT, "the definition is null");
    check_error(pli_body_add_angular_joint(body, NULL, NULL), PLI_ERROR_NULL_ARGUMENT, "the definition is null");
    linear.cookie = angular.cookie = 7;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_DEF, "pli_linear_joint_def_default");
    check_error(pli_body_add_angular_joint(body, &angular, NULL), PLI_ERROR_INVALID_DEF,
                "pli_angular_joint_def_default");
    angular = pli_angular_joint_def_default();
    check_error(pli_body_add_angular_joint(body, &angular, NULL), PLI_ERROR_INVALID_VALUE, "no direction");
    angular.axis = pli_vec3_make(NAN, 0, 1);
    check_error(pli_body_add_angular_joint(body, &angular, NULL), PLI_ERROR_INVALID_VALUE, "no direction");
    angular.axis = pli_vec3_make(1e30f, 0, 1);
    check_error(pli_body_add_angular_joint(body, &angular, NULL), PLI_ERROR_INVALID_VALUE, "no direction");

    linear = pli_linear_joint_def_default();
    check_error(pli_body_add_linear_joint(bare, &linear, NULL), PLI_ERROR_INDEX_OUT_OF_RANGE, "has 0 clusters");
    linear.cluster = 1;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INDEX_OUT_OF_RANGE, "cluster 1");
    linear.cluster = 0;
    linear.other.body = bare;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INDEX_OUT_OF_RANGE, "has 0 clusters");
    linear.other.body = body;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_VALUE, "both ends are cluster 0");
    linear.other.rigid = rigid;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_VALUE, "both a body and a rigid");
    linear.other.body = NULL;
    linear.position.y = INFINITY;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_NOT_FINITE, "inf");
    linear.position.y = 0;
    linear.softness.error_reduction = 1.5f;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_VALUE, "error_reduction is 1.5");
    linear.softness.error_reduction = 1;
    linear.softness.velocity_factor = NAN;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_NOT_FINITE, "velocity_factor is nan");
    linear.softness.velocity_factor = 1;
    linear.softness.split = -0.5f;
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_VALUE, "split is -0.5");

    pli_world* elsewhere = NULL;
    assert_int_equal(pli_world_create(context, NULL, &elsewhere), PLI_OK);
    pli_rigid_def rigid_def = pli_rigid_def_default();
    linear = pli_linear_joint_def_default();
    assert_int_equal(pli_rigid_create(elsewhere, &rigid_def, &linear.other.rigid), PLI_OK);
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_VALUE, "not in the body's world");
    pli_world_destroy(elsewhere);

    pli_context* foreign = NULL; /* its log is not the place for what is wrong with a call of another context */
    assert_int_equal(pli_context_create(NULL, &foreign), PLI_OK);
    assert_int_equal(pli_world_create(foreign, NULL, &elsewhere), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(foreign, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 1, 0, &mesh),
                     PLI_OK);
    linear = pli_linear_joint_def_default();
    assert_int_equal(pli_body_create(elsewhere, mesh, NULL, &linear.other.body), PLI_OK);
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_INVALID_VALUE, "in another world");
    pli_mesh_destroy(mesh);
    pli_world_destroy(elsewhere);
    pli_context_destroy(foreign);
    linear.other.body = NULL;

    linear.other.rigid = rigid;
    assert_int_equal(pli_body_joint_count(body), 0);
    pli_joint_id id = {0, 0};
    assert_int_equal(pli_body_add_linear_joint(body, &linear, &id), PLI_OK);
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_error(pli_body_add_linear_joint(body, &linear, NULL), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_error(pli_body_remove_joint(body, id), PLI_ERROR_WRONG_STATE, "between predict and solve");
    assert_int_equal(pli_world_solve(world), PLI_OK);
    assert_int_equal(pli_body_joint_count(NULL), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_cluster_and_rigid_keep_their_momenta, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_joint_starts_where_the_body_was_moved_to, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_two_bodies_keep_their_momenta, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_what_flies_together_stays_together, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_pinned_cluster_holds_what_is_heavy, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_linear_joint_holds_a_pendulum, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_joint_follows_what_is_put_elsewhere, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_joints_hold_parts_of_a_body, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_chains_hold_what_is_heavy, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_joints_to_what_is_not_present_hold_nothing, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_angular_joint_aligns_axes, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_motor_reaches_its_speed, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_useless_controllers_are_harmless, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_frozen_body_takes_no_impulses, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_ids_become_stale, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_joints_go_with_what_they_hold, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_joints_go_with_clusters_not_with_contacts, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_added_clusters_keep_joints, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_steady_steps_allocate_nothing, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_out_of_memory_leaves_joints_as_they_were, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_input, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
