/* Anchors: balance of momentum, pivots, ids, order of life, what they cost, bad input. */

#include "failing_allocator.h"
#include "solver_choice.h"

#include <string.h>

static const float dt = 1.0f / 60.0f;

/* Nodes 0 to 5 along x, 1 kg each. */
static pli_body* make_rope(int pins, int position_iterations) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(5, 0, 0), 4, pins, &mesh),
                     PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = position_iterations;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static pli_rigid* make_rigid(pli_world* w, pli_rigid_kind kind, pli_vec3 origin) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.state.pose = pli_transform_make(pli_quat_from_yaw_pitch_roll(0.5f, 0.3f, -0.2f), origin);
    def.state.inverse_mass = 0.25f;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 0.4f);
    }
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(w, &def, &rigid), PLI_OK);
    return rigid;
}

static pli_anchor_def anchor_def(int node, pli_rigid* rigid) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = node;
    def.rigid = rigid;
    return def;
}

static pli_anchor_id add_anchor(pli_body* body, int node, pli_rigid* rigid) {
    const pli_anchor_def def = anchor_def(node, rigid);
    pli_anchor_id id = {0, 0};
    assert_int_equal(pli_body_add_anchor(body, &def, &id), PLI_OK);
    return id;
}

static pli_vec3 position_of(const pli_body* body, int node) {
    const pli_vec4 p = pli_body_get_view(body).positions[node];
    return pli_vec3_make(p.x, p.y, p.z);
}

// ------------------------------------------------------------------------------------------------- mechanics

static void test_a_rope_and_a_box_keep_their_momentum(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 8);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0.3f, 0));
    add_anchor(rope, 5, box);
    assert_int_equal(pli_body_add_velocity(rope, pli_vec3_make(-3, 1, 2)), PLI_OK);
    const pli_vec3 before = pli_body_momentum(rope);
    pli_vec3 after = before, share = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < 120; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_true(pli_rigid_was_touched(box));
        share = pli_vec3_scale(pli_rigid_get_state(box).linear_velocity, 4.0f);
        after = pli_vec3_add(pli_body_momentum(rope), share);
        check_at_most(pli_vec3_length(pli_vec3_sub(after, before)) / pli_vec3_length(before), 2e-5);
        assert_int_equal(pli_rigid_integrate(box, pli_vec3_make(0, 0, 0), dt), PLI_OK);
    }
    /* 6 kg of rope and 4 kg of box end up moving together, more or less. */
    assert_true(pli_vec3_length(share) > 0.2f * pli_vec3_length(before));
    /* They still hold together. */
    const pli_transform pose = pli_rigid_get_state(box).pose;
    const pli_vec3 pivot = pli_transform_inverse_point(
        pli_transform_make(pli_quat_from_yaw_pitch_roll(0.5f, 0.3f, -0.2f), pli_vec3_make(6, 0.3f, 0)),
        pli_vec3_make(5, 0, 0));
    const pli_vec3 gap = pli_vec3_sub(pli_transform_point(pose, pivot), position_of(rope, 5));
    print_message("gap %.3g m\n", (double)pli_vec3_length(gap));
    check_at_most(pli_vec3_length(gap), 0.1);
}

static int setup_reference_world(void** unused) {
    (void)unused;
    if (pli_context_create(NULL, &context) != PLI_OK) { return -1; }
    pli_world_def def = pli_world_def_default();
    def.gravity = pli_vec3_make(0, 0, 0);
    def.reference_mode = true;
    return pli_world_create(context, &def, &world) == PLI_OK ? 0 : -1;
}

/* One iteration removes `hardness` of the error, and all of the difference of motion. So it is in reference mode;
   without it a wall has its node at once. */
static void test_hardness_and_influence_are_shares_of_the_error(void** unused) {
    (void)unused;
    const float hardness[] = {1.0f, 0.7f, 0.25f};
    const float influence[] = {1.0f, 1.0f, 0.5f};
    for (int k = 0; k < 3; ++k) {
        pli_body* rope = make_rope(0, 1);
        pli_rigid* wall = make_rigid(world, PLI_RIGID_STATIC, pli_vec3_make(5, 2, 0));
        const pli_vec3 pivot = pli_vec3_make(0, 0, 0);
        pli_anchor_def def = anchor_def(5, wall);
        def.local_pivot = &pivot;
        def.influence = influence[k];
        assert_int_equal(pli_body_add_anchor(rope, &def, NULL), PLI_OK);
        if (k != 1) { assert_int_equal(pli_body_set_anchor_hardness(rope, hardness[k]), PLI_OK); }
        assert_int_equal(pli_world_step(world, 1e-3f), PLI_OK);
        const float moved = 2.0f * hardness[k] * influence[k];
        const float link = sqrtf(1.0f + moved * moved);
        /* The last link then pulls back by half of its stretch, as Bullet's quotient of squares has it. */
        const float correction = (1.0f - link * link) / (2.0f * (1.0f + link * link));
        check_near(position_of(rope, 5).y, moved + moved * correction, 1e-5);
        pli_body_destroy(rope);
        pli_rigid_destroy(wall);
    }
}

/* A node that nothing else holds, 1 cm from its point of a box that flies. Bullet's share of the way from where it is
   now would take it 1.06 times as far to the other side in each step. */
static void test_a_node_alone_comes_to_its_point(void** unused) {
    (void)unused;
    for (int iterations = 1; iterations <= 4; iterations *= 4) {
        pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(0, 0, 0));
        pli_rigid_state state = pli_rigid_get_state(box);
        state.linear_velocity = pli_vec3_make(10, 0, 0);
        assert_int_equal(pli_rigid_set_state(box, &state), PLI_OK);
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(0, 0.01f, 0), 0.001f, NULL), PLI_OK);
        pli_body_def body_def = pli_body_def_default();
        body_def.solver.position_iterations = iterations;
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        assert_int_equal(pli_body_add_velocity(body, state.linear_velocity), PLI_OK);
        const pli_vec3 pivot = pli_vec3_make(0, 0, 0);
        pli_anchor_def def = anchor_def(0, box);
        def.local_pivot = &pivot;
        assert_int_equal(pli_body_add_anchor(body, &def, NULL), PLI_OK);
        float off = 0.0f;
        for (int i = 0; i < 60; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            assert_int_equal(pli_rigid_integrate(box, pli_vec3_make(0, 0, 0), dt), PLI_OK);
            off = pli_vec3_length(pli_vec3_sub(position_of(body, 0), pli_rigid_get_state(box).pose.origin));
            check_at_most(off, 0.01 * pow(0.3, i + 1) + 1e-5);
        }
        pli_body_destroy(body);
        pli_rigid_destroy(box);
    }
}

/* A rope hangs on a point 0.5 m beside the centre of a kinematic body that flies at 50 m/s and turns with 20 rad/s,
   which its host moves within the step or after it. It is cut on the way. */
static void check_is_where_its_point_is(solver_choice which, bool moves_within, bool is_smoothed) {
    pli_rigid* hand = make_rigid(world, PLI_RIGID_KINEMATIC, pli_vec3_make(-0.5f, 0, 0));
    pli_rigid_state state = pli_rigid_get_state(hand);
    state.pose.rotation = pli_mat3_identity();
    state.linear_velocity = pli_vec3_make(0, 0, 50);
    state.angular_velocity = pli_vec3_make(0, 20, 0);
    assert_int_equal(pli_rigid_set_state(hand, &state), PLI_OK);
    pli_body* rope = make_rope(0, 8);
    use_solver(rope, which);
    pli_solver_settings settings = pli_body_get_solver_settings(rope);
    settings.velocity_damping = 0.1f;
    assert_int_equal(pli_body_set_solver_settings(rope, &settings), PLI_OK);
    if (is_smoothed) { assert_int_equal(pli_body_enable_step_smoothing(rope), PLI_OK); }
    add_anchor(rope, 0, hand);
    const pli_vec3 none = pli_vec3_make(0, 0, 0), pivot = pli_vec3_make(0.5f, 0, 0);
    for (int i = 0; i < 30; ++i) {
        const float step = is_smoothed && i % 2 == 1 ? 0.25f * dt : dt;
        assert_int_equal(pli_world_predict(world, step), PLI_OK);
        if (moves_within) { assert_int_equal(pli_rigid_integrate(hand, none, step), PLI_OK); }
        assert_int_equal(pli_world_solve(world), PLI_OK);
        if (!moves_within) { assert_int_equal(pli_rigid_integrate(hand, none, step), PLI_OK); }
        if (i == 15) { assert_int_equal(pli_body_cut_link(rope, 2, 3, 0.5f), PLI_OK); }
        state = pli_rigid_get_state(hand);
        const pli_vec3 goal = pli_transform_point(state.pose, pivot), offset = pli_vec3_sub(goal, state.pose.origin);
        check_at_most(pli_vec3_length(pli_vec3_sub(position_of(rope, 0), goal)), 1e-5);
        const pli_vec4 v = pli_body_get_view(rope).velocities[0];
        const pli_vec3 wanted = pli_vec3_add(state.linear_velocity, pli_vec3_cross(state.angular_velocity, offset));
        check_at_most(pli_vec3_length(pli_vec3_sub(pli_vec3_make(v.x, v.y, v.z), wanted)), 1e-4);
    }
    assert_false(pli_body_is_frozen(rope));
    pli_body_destroy(rope);
    pli_rigid_destroy(hand);
}

static void test_a_node_is_where_its_point_of_a_kinematic_body_is(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        for (int variant = 0; variant < 4; ++variant) {
            check_is_where_its_point_is((solver_choice)which, variant % 2 == 1, variant / 2 == 1);
        }
    }
}

/* A node that is 2 m off its point is there after one step, at rest; so it is when its wall has jumped. */
static void test_a_node_is_where_its_point_of_a_wall_is(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* rope = make_rope(0, 8);
        use_solver(rope, (solver_choice)which);
        pli_rigid* wall = make_rigid(world, PLI_RIGID_STATIC, pli_vec3_make(0, 2, 0));
        const pli_vec3 pivot = pli_vec3_make(0, 0, 0);
        pli_anchor_def def = anchor_def(0, wall);
        def.local_pivot = &pivot;
        assert_int_equal(pli_body_add_anchor(rope, &def, NULL), PLI_OK);
        for (int i = 0; i < 10; ++i) {
            pli_rigid_state state = pli_rigid_get_state(wall);
            if (i == 5) { state.pose.origin.x = 1; }
            assert_int_equal(pli_rigid_set_state(wall, &state), PLI_OK);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            check_near(pli_vec3_length(pli_vec3_sub(position_of(rope, 0), state.pose.origin)), 0, 0);
            const pli_vec4 v = pli_body_get_view(rope).velocities[0];
            check_near(pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)), 0, 0);
        }
        pli_body_destroy(rope);
        pli_rigid_destroy(wall);
    }
}

static void test_a_kinematic_body_pulls_and_is_not_pulled(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 4);
    pli_rigid* hand = make_rigid(world, PLI_RIGID_KINEMATIC, pli_vec3_make(0, 0, 0));
    add_anchor(rope, 0, hand);
    pli_rigid_state state = pli_rigid_get_state(hand);
    for (int i = 1; i <= 300; ++i) {
        state.linear_velocity = pli_vec3_make(-1, 0, 0);
        state.pose.origin.x = -(float)i * dt;
        assert_int_equal(pli_rigid_set_state(hand, &state), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    check_near(pli_rigid_get_state(hand).linear_velocity.x, -1, 0);
    check_near(position_of(rope, 0).x, -5, 0.02);
    check_near(position_of(rope, 5).x, 0, 0.3);
    check_near(pli_body_momentum(rope).x, -6, 0.5);
}

static void test_a_pinned_node_on_a_static_body_stays_finite(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(PLI_ROPE_PIN_FIRST, 2);
    pli_rigid* wall = make_rigid(world, PLI_RIGID_STATIC, pli_vec3_make(0, 3, 0));
    const pli_vec3 pivot = pli_vec3_make(0, 0, 0);
    pli_anchor_def def = anchor_def(0, wall);
    def.local_pivot = &pivot;
    assert_int_equal(pli_body_add_anchor(rope, &def, NULL), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_false(pli_body_is_frozen(rope));
    check_near(pli_vec3_length(position_of(rope, 0)), 0, 0);
}

static void test_a_body_that_blows_up_does_not_take_the_rigid_along(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 4);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    pli_rigid_state state = pli_rigid_get_state(box);
    state.linear_velocity = pli_vec3_make(1, 2, 3);
    state.angular_velocity = pli_vec3_make(-1, 0.5f, 0);
    assert_int_equal(pli_rigid_set_state(box, &state), PLI_OK);
    /* Within the world when predicted; then 10 m of error, a million times. */
    const pli_vec3 pivot = pli_vec3_make(0, 10, 0);
    pli_anchor_def def = pli_anchor_def_default();
    def.node = 3;
    def.rigid = box;
    def.local_pivot = &pivot;
    def.influence = PLI_MAX_FACTOR;
    assert_int_equal(pli_body_add_anchor(rope, &def, NULL), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_true(pli_body_is_frozen(rope));
    int count = 0;
    const pli_event* events = pli_world_get_events(world, &count);
    assert_int_equal(count, 2);
    assert_int_equal(events[0].kind, PLI_EVENT_BODY_FROZEN);
    assert_ptr_equal(events[0].body, rope);
    assert_null(events[0].rigid);
    assert_int_equal(events[1].kind, PLI_EVENT_RIGID_RESTORED);
    assert_ptr_equal(events[1].rigid, box);
    assert_null(events[1].body);
    const pli_rigid_state after = pli_rigid_get_state(box);
    assert_memory_equal(&after.linear_velocity, &state.linear_velocity, sizeof state.linear_velocity);
    assert_memory_equal(&after.angular_velocity, &state.angular_velocity, sizeof state.angular_velocity);
    /* Nothing is left to happen, and what names the rigid body goes with it. */
    pli_rigid_destroy(box);
    events = pli_world_get_events(world, &count);
    assert_int_equal(count, 2);
    assert_int_equal(events[0].kind, PLI_EVENT_BODY_FROZEN);
    assert_int_equal(events[1].kind, PLI_EVENT_ANCHORS_LOST);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    pli_world_get_events(world, &count);
    assert_int_equal(count, 0);
}

// ------------------------------------------------------------------------------------------------------- life

static void test_ids_go_stale(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 1);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    assert_int_equal(pli_body_anchor_count(rope), 0);
    const pli_anchor_id none = {0, 0};
    assert_int_equal(pli_body_remove_anchor(rope, none), PLI_ERROR_STALE_ID);
    const pli_anchor_id a = add_anchor(rope, 0, box), b = add_anchor(rope, 3, box), c = add_anchor(rope, 3, box);
    assert_int_equal(pli_body_anchor_count(rope), 3);
    assert_int_equal(pli_body_remove_anchor(rope, none), PLI_ERROR_STALE_ID);
    assert_int_equal(pli_body_remove_anchor(rope, b), PLI_OK);
    assert_int_equal(pli_body_remove_anchor(rope, b), PLI_ERROR_STALE_ID);
    assert_non_null(strstr(pli_last_error(context), "no anchor"));
    assert_int_equal(pli_body_anchor_count(rope), 2);
    /* The place is used again, under another name. */
    const pli_anchor_id d = add_anchor(rope, 4, box);
    assert_int_equal(d.index1, b.index1);
    assert_true(d.generation != b.generation);
    assert_int_equal(pli_body_remove_anchor(rope, b), PLI_ERROR_STALE_ID);
    const pli_anchor_id invented[] = {{-1, 1}, {99, 1}, {INT32_MIN, 0}, {INT32_MAX, 1}, {a.index1, a.generation + 1}};
    for (size_t i = 0; i < sizeof invented / sizeof invented[0]; ++i) {
        assert_int_equal(pli_body_remove_anchor(rope, invented[i]), PLI_ERROR_STALE_ID);
    }
    assert_int_equal(pli_body_remove_anchor(rope, c), PLI_OK);
    assert_int_equal(pli_body_remove_anchor(rope, a), PLI_OK);
    assert_int_equal(pli_body_remove_anchor(rope, d), PLI_OK);
    assert_int_equal(pli_body_anchor_count(rope), 0);
    /* Old names stay stale after the last one went. */
    add_anchor(rope, 1, box);
    const pli_anchor_id old[] = {a, b, c, d};
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(pli_body_remove_anchor(rope, old[i]), PLI_ERROR_STALE_ID);
    }
    assert_int_equal(pli_body_anchor_count(rope), 1);
    assert_int_equal(pli_body_remove_anchor(NULL, a), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_anchor_count(NULL), 0);
}

static void test_anchors_go_with_their_rigid_body(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 1);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    pli_rigid* wall = make_rigid(world, PLI_RIGID_STATIC, pli_vec3_make(-1, 0, 0));
    const pli_anchor_id lost = add_anchor(rope, 5, box);
    const pli_anchor_id kept = add_anchor(rope, 0, wall);
    add_anchor(rope, 4, box);
    pli_rigid_destroy(box);
    assert_int_equal(pli_body_anchor_count(rope), 1);
    assert_int_equal(pli_body_remove_anchor(rope, lost), PLI_ERROR_STALE_ID);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_remove_anchor(rope, kept), PLI_OK);
}

static void check_lost(int index, const pli_body* body) {
    const pli_event event = pli_world_get_events(world, NULL)[index];
    assert_int_equal(event.kind, PLI_EVENT_ANCHORS_LOST);
    assert_ptr_equal(event.body, body);
    assert_int_equal(event.node, PLI_NULL_INDEX);
}

static void test_a_body_that_loses_anchors_is_told_of_once(void** unused) {
    (void)unused;
    pli_body* ropes[3];
    pli_rigid* boxes[4];
    for (int i = 0; i < 4; ++i) {
        boxes[i] = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    }
    for (int i = 0; i < 3; ++i) {
        ropes[i] = make_rope(0, 1);
        for (int k = 0; k < i; ++k) {
            add_anchor(ropes[i], 3 + k, boxes[k]);
        }
    }
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    int count = 1;
    pli_world_get_events(world, &count);
    assert_int_equal(count, 0);
    /* The first two bodies are held to, the others are not. */
    for (int i = 3; i >= 0; --i) {
        pli_rigid_destroy(boxes[i]);
        pli_world_get_events(world, &count);
        assert_int_equal(count, i > 1 ? 0 : i == 1 ? 1 : 2);
    }
    check_lost(0, ropes[2]);
    check_lost(1, ropes[1]);
    pli_body_destroy(ropes[2]);
    pli_world_get_events(world, &count);
    assert_int_equal(count, 1);
    check_lost(0, ropes[1]);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    pli_world_get_events(world, &count);
    assert_int_equal(count, 0);
}

/* The first node of a rope that flies past is held to a wall. */
static float drift_after_steps(pli_body* rope, int steps) {
    const float before = position_of(rope, 0).y;
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    return position_of(rope, 0).y - before;
}

static void test_anchors_to_what_is_not_present_hold_nothing(void** unused) {
    (void)unused;
    for (int solver = 0; solver < 3; ++solver) {
        pli_rigid* wall = make_rigid(world, PLI_RIGID_STATIC, pli_vec3_make(-1, 0, 0));
        pli_body* rope = make_rope(0, 8);
        const pli_implicit_def implicit = pli_implicit_def_default();
        const pli_xpbd_def xpbd = pli_xpbd_def_default();
        if (solver == 1) { assert_int_equal(pli_body_enable_xpbd(rope, &xpbd), PLI_OK); }
        if (solver == 2) { assert_int_equal(pli_body_enable_implicit(rope, &implicit), PLI_OK); }
        add_anchor(rope, 0, wall);
        assert_int_equal(pli_rigid_set_present(wall, false), PLI_OK);
        assert_false(pli_rigid_is_present(wall));
        assert_int_equal(pli_body_add_velocity(rope, pli_vec3_make(0, 1, 0)), PLI_OK);
        check_near(drift_after_steps(rope, 30), 0.5, 1e-4);
        assert_false(pli_rigid_was_touched(wall));
        assert_int_equal(pli_body_anchor_count(rope), 1);
        assert_int_equal(pli_rigid_set_present(wall, true), PLI_OK);
        check_at_most(drift_after_steps(rope, 30), -0.4);
        assert_true(pli_rigid_was_touched(wall));
        /* In the middle of a step. */
        const float before = position_of(rope, 0).y;
        assert_int_equal(pli_body_set_node_velocity(rope, 0, pli_vec3_make(0, 60, 0)), PLI_OK);
        assert_int_equal(pli_world_predict(world, dt), PLI_OK);
        assert_int_equal(pli_rigid_set_present(wall, false), PLI_OK);
        assert_int_equal(pli_world_solve(world), PLI_OK);
        if (solver < 2) { /* the implicit solver holds nodes in its prediction already */
            assert_false(pli_rigid_was_touched(wall));
            assert_true(position_of(rope, 0).y - before > 0.1f);
        }
        pli_body_destroy(rope);
        pli_rigid_destroy(wall);
    }
    assert_int_equal(pli_rigid_set_present(NULL, true), PLI_ERROR_NULL_ARGUMENT);
    assert_false(pli_rigid_is_present(NULL));
}

static void test_collision_with_the_rigid_body_can_be_switched_off(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 1);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    add_anchor(rope, 5, box);
    assert_false(pli_body_ignores_rigid(rope, box));
    pli_anchor_def def = anchor_def(4, box);
    def.disable_collision = true;
    pli_anchor_id id;
    assert_int_equal(pli_body_add_anchor(rope, &def, &id), PLI_OK);
    assert_true(pli_body_ignores_rigid(rope, box));
    assert_int_equal(pli_body_remove_anchor(rope, id), PLI_OK);
    assert_true(pli_body_ignores_rigid(rope, box));
}

static void test_only_anchored_rigid_bodies_are_touched(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 1);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    pli_rigid* other = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(60, 0, 0));
    const pli_anchor_id id = add_anchor(rope, 5, box);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_true(pli_rigid_was_touched(box));
    assert_false(pli_rigid_was_touched(other));
    assert_int_equal(pli_body_remove_anchor(rope, id), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_false(pli_rigid_was_touched(box));
}

// ------------------------------------------------------------------------------------------------------- cost

static void test_steps_do_not_allocate(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 3);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    for (int i = 0; i < 20; ++i) {
        add_anchor(rope, i % 6, box);
    }
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const uint64_t count = pli_context_allocation_count(context);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_context_allocation_count(context), count);
}

static void test_anchors_that_come_again_need_no_memory(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 1);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    assert_int_equal(pli_body_remove_anchor(rope, add_anchor(rope, 0, box)), PLI_OK);
    const size_t allocated = pli_context_allocated_bytes(context), bytes = pli_body_bytes(rope);
    const pli_anchor_id id = add_anchor(rope, 2, box);
    assert_int_equal(pli_body_bytes(rope), bytes);
    assert_int_equal(pli_context_allocated_bytes(context), allocated);
    assert_int_equal(pli_body_remove_anchor(rope, id), PLI_OK);
    assert_int_equal(pli_context_allocated_bytes(context), allocated);
    assert_int_equal(pli_body_bytes(rope), bytes);
}

static pli_status anchor_and_release(pli_context* c, void* unused) {
    (void)unused;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    pli_rigid* box = NULL;
    pli_status status = pli_world_create(c, NULL, &w);
    if (status == PLI_OK) {
        status = pli_mesh_create_rope(c, pli_vec3_make(0, 0, 0), pli_vec3_make(5, 0, 0), 4, 0, &mesh);
    }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &rope); }
    if (status == PLI_OK) {
        const pli_rigid_def def = pli_rigid_def_default();
        status = pli_rigid_create(w, &def, &box);
    }
    for (int i = 0; i < 40 && status == PLI_OK; ++i) {
        pli_anchor_def def = anchor_def(i % 6, box);
        def.disable_collision = i == 30;
        status = pli_body_add_anchor(rope, &def, NULL);
        assert_int_equal(pli_body_anchor_count(rope), status == PLI_OK ? i + 1 : i);
        if (status != PLI_OK && i == 30) { assert_false(pli_body_ignores_rigid(rope, box)); }
    }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_running_out_of_memory_leaves_nothing(void** unused) {
    (void)unused;
    assert_true(check_survives_failing_allocator(anchor_and_release, NULL) > 12);
}

// ------------------------------------------------------------------------------------------------------ errors

#define check_anchor_refused(call, expected_status, expected_text)                                                     \
    do {                                                                                                               \
        check_refused(call, expected_status, expected_text);                                                           \
        assert_int_equal(pli_body_anchor_count(rope), 0);                                                              \
    } while (0)

static void test_bad_input_is_refused(void** unused) {
    (void)unused;
    pli_body* rope = make_rope(0, 1);
    pli_rigid* box = make_rigid(world, PLI_RIGID_DYNAMIC, pli_vec3_make(6, 0, 0));
    pli_world* other_world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &other_world), PLI_OK);
    pli_rigid* stranger = make_rigid(other_world, PLI_RIGID_DYNAMIC, pli_vec3_make(0, 0, 0));
    pli_anchor_id id = {7, 7};

    pli_anchor_def def = anchor_def(0, box);
    assert_int_equal(pli_body_add_anchor(NULL, &def, &id), PLI_ERROR_NULL_ARGUMENT);
    check_anchor_refused(pli_body_add_anchor(rope, NULL, &id), PLI_ERROR_NULL_ARGUMENT, "definition is null");
    def.cookie = 1;
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_INVALID_DEF, "pli_anchor_def_default");
    def = anchor_def(6, box);
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 6");
    def = anchor_def(-1, box);
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_INDEX_OUT_OF_RANGE, "node -1");
    def = anchor_def(0, NULL);
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_NULL_ARGUMENT, "rigid");
    def = anchor_def(0, stranger);
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_INVALID_VALUE, "another world");
    const pli_vec3 nowhere = pli_vec3_make(0, INFINITY, 0);
    def = anchor_def(0, box);
    def.local_pivot = &nowhere;
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_NOT_FINITE, "local_pivot is (0, inf, 0)");
    def = anchor_def(0, box);
    def.influence = NAN;
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_NOT_FINITE, "influence is nan");
    def.influence = -1.0f;
    check_anchor_refused(pli_body_add_anchor(rope, &def, &id), PLI_ERROR_INVALID_VALUE, "influence is -1");
    assert_int_equal(id.index1, 7);
    assert_int_equal(id.generation, 7);

    assert_int_equal(pli_body_set_anchor_hardness(NULL, 0.5f), PLI_ERROR_NULL_ARGUMENT);
    check_anchor_refused(pli_body_set_anchor_hardness(rope, NAN), PLI_ERROR_NOT_FINITE, "hardness is nan");
    check_anchor_refused(pli_body_set_anchor_hardness(rope, 1.5f), PLI_ERROR_INVALID_VALUE, "hardness is 1.5");
    check_anchor_refused(pli_body_set_anchor_hardness(rope, -0.5f), PLI_ERROR_INVALID_VALUE, "hardness is -0.5");
    pli_world_destroy(other_world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_rope_and_a_box_keep_their_momentum, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_node_alone_comes_to_its_point, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_hardness_and_influence_are_shares_of_the_error, setup_reference_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_node_is_where_its_point_of_a_kinematic_body_is, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_node_is_where_its_point_of_a_wall_is, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_kinematic_body_pulls_and_is_not_pulled, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_pinned_node_on_a_static_body_stays_finite, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_body_that_blows_up_does_not_take_the_rigid_along, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_ids_go_stale, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_anchors_go_with_their_rigid_body, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_body_that_loses_anchors_is_told_of_once, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_anchors_to_what_is_not_present_hold_nothing, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_collision_with_the_rigid_body_can_be_switched_off, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_only_anchored_rigid_bodies_are_touched, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_steps_do_not_allocate, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_anchors_that_come_again_need_no_memory, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test(test_running_out_of_memory_leaves_nothing),
        cmocka_unit_test_setup_teardown(test_bad_input_is_refused, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
