/* Rigid bodies on pinned cloth under XPBD: what falls on it is not thrown higher than it came from, and comes to rest.
 */

#include "heavy_bodies.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;

/* Unoptimised programs run the shorter cases only. */
#ifdef NDEBUG
static const bool is_fast = true;
#else
static const bool is_fast = false;
#endif

typedef struct fall {
    float mass, height; /* kg, m above the sheet */
    int substeps;
    bool has_faces, has_tethers, has_rim; /* or its corners alone are pinned */
    float damping;
} fall;

static pli_body* make_cloth(const fall* f) {
    pli_solver_settings settings = pli_body_def_default().solver;
    settings.velocity_damping = f->damping;
    pli_body* body = make_sheet(f->has_rim ? SHEET_RIM : SHEET_CORNERS, &settings, true, f->has_faces);
    pli_xpbd_def solver = pli_xpbd_def_default();
    solver.substeps = f->substeps;
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = 1.0f / (1000.0f * (1.0f + f->mass));
    CHECK_OK(pli_body_enable_xpbd(body, &solver));
    CHECK_OK(pli_body_enable_xpbd_links(body, &links));
    if (f->has_tethers) { CHECK_OK(pli_body_enable_tethers(body, NULL)); }
    return body;
}

static float step_ball(pli_rigid* ball, float damping) {
    CHECK_OK(pli_world_step(world, dt));
    CHECK_OK(pli_rigid_integrate(ball, pli_world_def_default().gravity, dt));
    pli_rigid_state state = pli_rigid_get_state(ball);
    state.linear_velocity = pli_vec3_scale(state.linear_velocity, 1.0f - damping);
    state.angular_velocity = pli_vec3_scale(state.angular_velocity, 1.0f - damping);
    CHECK_OK(pli_rigid_set_state(ball, &state));
    return state.pose.origin.y;
}

static void check_never_rises(fall f) {
    pli_body* sheet = make_cloth(&f);
    pli_rigid* ball = make_ball(ball_radius + f.height, f.mass);
    const float start = pli_rigid_get_state(ball).pose.origin.y;
    for (int i = 0; i < 150; ++i) {
        const float height = step_ball(ball, 0);
        if (height > start) {
            fail_msg("%g kg, %d substeps, step %d: %g m above its start", (double)f.mass, f.substeps, i,
                     (double)(height - start));
        }
    }
    pli_body_destroy(sheet);
    pli_rigid_destroy(ball);
}

static void test_trampolines_throw_nothing_higher_than_it_fell(void** unused) {
    (void)unused;
    static const float masses[] = {0.1f, 1, 5, 100};
    static const int substeps[] = {1, 5, 10, 30, 60};
    for (int variant = 0; variant < (is_fast ? 4 : 1); ++variant) {
        for (int m = 0; m < 4; ++m) {
            for (int s = 0; s < (is_fast ? 5 : 3); ++s) {
                check_never_rises((fall){.mass = masses[m],
                                         .height = 1.5f,
                                         .substeps = substeps[s],
                                         .has_faces = variant % 2 == 1,
                                         .has_tethers = variant >= 2,
                                         .has_rim = true});
            }
        }
    }
}

/* The faces that it lies on keep the points where it touches them. */
static void test_ball_rests_on_faces(void** unused) {
    (void)unused;
    const fall f = {.mass = 10,
                    .height = 0.2f,
                    .substeps = 20,
                    .has_faces = true,
                    .has_tethers = true,
                    .has_rim = true,
                    .damping = 0.05f};
    pli_body* sheet = make_cloth(&f);
    pli_rigid* ball = make_ball(ball_radius + f.height, f.mass);
    for (int i = 0; i < 600; ++i) {
        (void)step_ball(ball, f.damping);
    }
    const pli_body_view view = pli_body_get_view(sheet);
    double sum = 0.0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 v = view.velocities[i];
        sum += (double)(v.x * v.x + v.y * v.y + v.z * v.z);
    }
    check_at_most(sqrt(sum / view.node_count), 1e-3);
    check_at_most(pli_vec3_length(pli_rigid_get_state(ball).linear_velocity), 1e-3); /* its weight is not in it */
    check_at_most(pli_vec3_length(pli_rigid_get_state(ball).angular_velocity), 0.01);
    assert_true(pli_body_get_rigid_face_contacts(sheet, 0, NULL) > 10);
}

/* Without any damping: what is anchored above its centre rocks on as it began. */
static void test_weight_on_an_arm_rocks_no_wilder(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    CHECK_OK(
        pli_mesh_create_rope(context, pli_vec3_make(0, 1, 0), pli_vec3_make(0, 0, 0), 0, PLI_ROPE_PIN_FIRST, &mesh));
    pli_body_def def = pli_body_def_default();
    pli_body* rope = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &rope));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_xpbd(rope, NULL));
    CHECK_OK(pli_body_enable_xpbd_links(rope, NULL));
    pli_rigid* weight = make_ball(-ball_radius, 10);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.node = 1;
    anchor.rigid = weight;
    CHECK_OK(pli_body_add_anchor(rope, &anchor, NULL));
    pli_rigid_state state = pli_rigid_get_state(weight);
    state.angular_velocity.z = 0.2f;
    CHECK_OK(pli_rigid_set_state(weight, &state));
    float most = 0;
    for (int i = 0; i < 900; ++i) {
        (void)step_ball(weight, 0);
        const float spin = pli_vec3_length(pli_rigid_get_state(weight).angular_velocity);
        if (i >= 840) { most = fmaxf(most, spin); }
    }
    check_at_most(most, 0.22);
    assert_true(most > 0.02f);
}

static void add_strip(int index, int count) {
    pli_patch_def patch = pli_patch_def_default();
    const float width = 1.6f / (float)count, x = (float)index * width - 0.8f;
    patch.corner_00 = pli_vec3_make(x, 0.03f, -0.8f);
    patch.corner_10 = pli_vec3_make(x + 0.95f * width, 0.03f, -0.8f);
    patch.corner_01 = pli_vec3_make(x, 0.03f, 0.8f);
    patch.corner_11 = pli_vec3_make(x + 0.95f * width, 0.03f, 0.8f);
    patch.columns = 3;
    patch.rows = 16;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    pli_body_def def = pli_body_def_default();
    def.collision_margin = sheet_margin;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1 / (float)count));
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_xpbd(body, NULL));
    CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
    CHECK_OK(pli_body_enable_rigid_contacts(body, NULL));
}

/* A box of 50 kg falls half a metre on strips of cloth that lie side by side. Solved one after the other, each threw it
   back: up to 2.4 m, with 3.4 times its energy. */
static void test_many_strips_stop_a_box_once(void** unused) {
    (void)unused;
    const pli_vec3 gravity = pli_world_def_default().gravity;
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(5, 1, 5), &shape));
    (void)make_rigid(shape, -1, 0);
    for (int count = 1; count <= 8; count *= 2) {
        for (int i = 0; i < count; ++i) {
            add_strip(i, count);
        }
        for (int i = 0; i < 60; ++i) {
            CHECK_OK(pli_world_step(world, dt));
        }
        CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.6f, 0.2f, 0.6f), &shape));
        pli_rigid* box = make_rigid(shape, 0.75f, 50);
        double most = 0, highest = 0;
        bool has_hit = false;
        for (int i = 0; i < 90; ++i) {
            (void)step_ball(box, 0);
            const pli_rigid_state state = pli_rigid_get_state(box);
            const double y = (double)state.pose.origin.y, v = (double)state.linear_velocity.y;
            most = fmax(most, 0.5 * v * v - (double)gravity.y * y);
            has_hit = has_hit || y < 0.3;
            if (has_hit) { highest = fmax(highest, y); }
        }
        print_message("%d strips: at most %.3f J/kg of 7.5, up to %.3f m after the hit\n", count, most, highest);
        check_at_most(most, 7.5);
        check_at_most(highest, 0.28);
        pli_rigid_destroy(box);
        while (pli_world_body_count(world) > 0) {
            pli_body_destroy(pli_world_get_body(world, 0));
        }
    }
}

/* No node may be farther than 5 cm from where it began: a ball that falls on the sheet comes to lie there. */
static void test_targets_bear_a_heavy_ball(void** unused) {
    (void)unused;
    for (int has_faces = 0; has_faces < 2; ++has_faces) {
        const fall f = {.mass = 50, .substeps = 10, .has_faces = has_faces != 0};
        pli_body* sheet = make_cloth(&f);
        pli_rigid* ball = make_ball(ball_radius + 0.1f, f.mass);
        static pli_target targets[SHEET_NODES];
        static pli_vec3 places[SHEET_NODES];
        for (int i = 0; i < SHEET_NODES; ++i) {
            const pli_vec4 x = pli_body_get_view(sheet).positions[i];
            targets[i] = (pli_target){.node = i, .max_distance = 0.05f};
            places[i] = pli_vec3_make(x.x, x.y, x.z);
        }
        pli_targets_def def = pli_targets_def_default();
        def.targets = targets;
        def.positions = places;
        def.count = SHEET_NODES;
        CHECK_OK(pli_body_enable_targets(sheet, &def));
        float lowest = 1;
        for (int i = 0; i < 180; ++i) {
            lowest = fminf(lowest, step_ball(ball, 0));
        }
        /* 0.27: its radius and the margin above the 5 cm. */
        check_near(lowest, has_faces != 0 ? 0.2686f : 0.2644f, 0.003);
        check_near(pli_rigid_get_state(ball).pose.origin.y, 0.2675, 0.004);
        pli_body_destroy(sheet);
        pli_rigid_destroy(ball);
    }
}

/* Of 3 m and 3 kg, with cells of 15 cm and no diagonals, held at its rim: its tethers are as long as the ways along its
   ropes, and leave to these what moves its cells aside. */
static pli_body* make_net(int substeps) {
    enum { SIDE = 21 };
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create(context, &mesh));
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const int x = i % SIDE, z = i / SIDE;
        const bool is_rim = x == 0 || z == 0 || x == SIDE - 1 || z == SIDE - 1;
        const pli_vec3 place = pli_vec3_make(0.15f * (float)x - 1.5f, 0, 0.15f * (float)z - 1.5f);
        CHECK_OK(pli_mesh_append_node(mesh, place, is_rim ? 0 : 3.0f / (SIDE * SIDE), NULL));
        if (x > 0) { CHECK_OK(pli_mesh_append_link(mesh, i - 1, i, 0, NULL)); }
        if (z > 0) { CHECK_OK(pli_mesh_append_link(mesh, i - SIDE, i, 0, NULL)); }
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    def.solver.velocity_damping = 0.01f;
    pli_body* net = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &net));
    pli_mesh_destroy(mesh);
    pli_xpbd_def solver = pli_xpbd_def_default();
    solver.substeps = substeps;
    CHECK_OK(pli_body_enable_xpbd(net, &solver));
    CHECK_OK(pli_body_enable_xpbd_links(net, NULL));
    CHECK_OK(pli_body_enable_tethers(net, NULL));
    CHECK_OK(pli_body_enable_rigid_contacts(net, NULL));
    CHECK_OK(pli_body_enable_rigid_face_contacts(net, NULL)); /* of its links */
    return net;
}

/* Four of 50 kg that fall half a metre, at 60 steps a second, as docs/manual/ropes.md tells. */
static void test_a_net_holds_four_boxes(void** unused) {
    (void)unused;
    enum { BOXES = 4 };
    const float half = 0.2f;
    const pli_body* net = make_net(40);
    pli_rigid* boxes[BOXES];
    for (int i = 0; i < BOXES; ++i) {
        pli_shape* shape = NULL;
        CHECK_OK(pli_shape_create_box(context, pli_vec3_make(half, half, half), &shape));
        boxes[i] = make_rigid(shape, half + 0.53f, 50);
        pli_rigid_state state = pli_rigid_get_state(boxes[i]);
        state.pose.origin.x = (i % 2 == 0 ? -0.5f : 0.5f) + 0.01f * (float)i;
        state.pose.origin.z = (i < 2 ? -0.5f : 0.5f) - 0.013f * (float)i;
        CHECK_OK(pli_rigid_set_state(boxes[i], &state));
    }
    float lowest = 0, stretch = 0;
    for (int i = 0; i < 300; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        for (int k = 0; k < BOXES; ++k) {
            CHECK_OK(pli_rigid_integrate(boxes[k], pli_world_def_default().gravity, dt));
            lowest = fminf(lowest, pli_rigid_get_state(boxes[k]).pose.origin.y);
        }
        if (i >= 240) { stretch = fmaxf(stretch, pli_body_max_stretch(net)); }
    }
    print_message("lowest at %.3f m, links stretched by %.3f in the last second\n", (double)lowest, (double)stretch);
    check_at_most(-lowest, 0.25);
    check_at_most(stretch, 0.25);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_trampolines_throw_nothing_higher_than_it_fell, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_ball_rests_on_faces, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_targets_bear_a_heavy_ball, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_many_strips_stop_a_box_once, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_net_holds_four_boxes, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_weight_on_an_arm_rocks_no_wilder, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
