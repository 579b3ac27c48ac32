/* Self-collision of faces: single pairs, the count of crossings, twisted and folding cloth, life and misuse. */

#include "self_cloth.h"

static int crossings(const pli_body* body) {
    int count = -1;
    assert_int_equal(pli_body_count_crossings(body, &count), PLI_OK);
    return count;
}

static pli_self_faces_def make_def(float thickness, float friction, float max_travel) {
    pli_self_faces_def def = pli_self_faces_def_default();
    def.thickness = thickness;
    def.friction = friction;
    def.max_travel = max_travel;
    return def;
}

/* Two triangles far apart at rest, put at `positions`. No gravity. */
static pli_body* make_triangles(self_scene* scene, const pli_vec3 positions[6], const pli_vec3 velocities[6]) {
    static const pli_vec3 rest[6] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 9, 0}, {1, 9, 0}, {0, 9, 1}};
    assert_int_equal(pli_world_set_gravity(scene->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(scene->context, &mesh), PLI_OK);
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, rest[i], 1, NULL), PLI_OK);
    }
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 3, 4, 5, 0, NULL), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 1;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(scene->world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    const pli_self_faces_def def = make_def(0.1f, 0, 2);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK);
    assert_int_equal(pli_body_set_state(body, positions, velocities), PLI_OK);
    return body;
}

static void test_node_is_kept_off_a_face(void** data) {
    self_scene* scene = *data;
    const pli_vec3 x[6] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0.25f, 0.04f, 0.25f}, {0.3f, 2, 0.3f}, {0.2f, 2, 0.3f}};
    pli_body* body = make_triangles(scene, x, NULL);
    assert_int_equal(crossings(body), 0);
    self_steps(scene, 1);
    const pli_vec4* p = pli_body_get_view(body).positions;
    /* Weights 1, -1/2, -1/4, -1/4: 0.06 / 1.375 along each. */
    check_near(p[3].y, 0.04 + 0.06 / 1.375, 1e-6);
    check_near(p[0].y, -0.5 * 0.06 / 1.375, 1e-6);
    check_near(p[1].y, -0.25 * 0.06 / 1.375, 1e-6);
    check_near(pli_body_momentum(body).y, 0.0, 1e-5);
    assert_int_equal(pli_body_get_self_faces_report(body).contacts, 1);
}

/* What is kept off slides on with the rest of its speed, and the other side gets what is lost. */
static void test_friction_takes_its_share_of_the_sliding(void** data) {
    self_scene* scene = *data;
    const pli_vec3 x[6] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0.25f, 0.04f, 0.25f}, {0.3f, 2, 0.3f}, {0.2f, 2, 0.3f}};
    const pli_vec3 velocities[6] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0.06f, 0, 0.03f}, {0, 0, 0}, {0, 0, 0}};
    pli_body* body = make_triangles(scene, x, velocities);
    for (int k = 0; k < 2; ++k) {
        const float friction = k == 0 ? 0.0f : 0.25f;
        const pli_self_faces_def def = make_def(0.1f, friction, 2);
        assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK);
        assert_int_equal(pli_body_set_state(body, x, velocities), PLI_OK);
        self_steps(scene, 1);
        const pli_vec4* v = pli_body_get_view(body).velocities;
        check_near(v[3].x - 0.5f * v[0].x - 0.25f * (v[1].x + v[2].x), 0.06 * (1.0 - (double)friction), 1e-5);
        check_near(v[3].z - 0.5f * v[0].z - 0.25f * (v[1].z + v[2].z), 0.03 * (1.0 - (double)friction), 1e-5);
        check_near(v[0].x, 0.5 / 1.375 * (double)friction * 0.06, 1e-5);
        check_near(pli_body_momentum(body).x, 0.06, 1e-5);
    }
}

static void test_edge_is_kept_off_an_edge(void** data) {
    self_scene* scene = *data;
    /* Edge 0-1 along x, edge 3-4 along z above its middle. */
    const pli_vec3 x[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -3, 0}, {0, 0.05f, -1}, {0, 0.05f, 1}, {0, 3, 0}};
    pli_body* body = make_triangles(scene, x, NULL);
    self_steps(scene, 1);
    const pli_vec4* p = pli_body_get_view(body).positions;
    check_near(p[3].y, 0.05 + 0.025, 1e-6);
    check_near(p[4].y, 0.05 + 0.025, 1e-6);
    check_near(p[0].y, -0.025, 1e-6);
    check_near(p[2].y, -3, 0);
}

/* 60 m/s against each other, 0.3 m apart: through in one step but for the cut. Where the nodes are beside `speed`. */
static void meet_fast(self_scene* scene, pli_vec3 speed, pli_vec3 places[6]) {
    const pli_vec3 x[6] = {{0, 0, 0},          {1, 0, 0},         {0, 0, 1}, {0.25f, 0.3f, 0.25f},
                           {0.3f, 0.9f, 0.3f}, {0.2f, 0.9f, 0.3f}};
    pli_vec3 v[6];
    for (int i = 0; i < 6; ++i) {
        v[i] = pli_vec3_add(speed, pli_vec3_make(0, i < 3 ? 30 : -30, 0));
    }
    pli_body* body = make_triangles(scene, x, v);
    for (int i = 0; i < 20; ++i) {
        self_steps(scene, 1);
        assert_int_equal(crossings(body), 0);
        const pli_vec4* p = pli_body_get_view(body).positions;
        assert_true(p[3].y > p[0].y);
    }
    assert_false(pli_body_is_frozen(body));
    const pli_vec3 way = pli_vec3_scale(speed, 20.0f / 60.0f);
    for (int i = 0; i < 6; ++i) {
        const pli_vec4 p = pli_body_get_view(body).positions[i];
        places[i] = pli_vec3_sub(pli_vec3_make(p.x, p.y, p.z), way);
    }
    pli_body_destroy(body);
}

/* At rest as a whole, or in flight. */
static void test_fast_pairs_do_not_cross(void** data) {
    pli_vec3 still[6], fast[6];
    meet_fast(*data, pli_vec3_make(0, 0, 0), still);
    meet_fast(*data, pli_vec3_make(20, -15, 10), fast);
    for (int i = 0; i < 6; ++i) {
        check_at_most(pli_vec3_length(pli_vec3_sub(fast[i], still[i])), 1e-3);
    }
}

/* Two triangles, one above the other, are led past each other, and stop. Then the upper one is let go, downwards. */
static void test_what_was_pinned_does_not_go_through(void** data) {
    self_scene* scene = *data;
    for (int is_xpbd = 0; is_xpbd < 2; ++is_xpbd) {
        const pli_vec3 x[6] = {{-0.5f, 0, 0},       {1.5f, 0, 0},        {0.5f, 0, 2},
                               {1.4f, 0.08f, 0.2f}, {1.6f, 0.08f, 0.2f}, {1.5f, 0.08f, 0.5f}};
        pli_vec3 v[6];
        for (int i = 0; i < 6; ++i) {
            v[i] = pli_vec3_make(i < 3 ? 30 : -30, 0, 0);
        }
        pli_body* body = make_triangles(scene, x, v);
        if (is_xpbd == 1) { assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK); }
        for (int i = 0; i < 6; ++i) {
            assert_int_equal(pli_body_set_node_mass(body, i, 0), PLI_OK);
        }
        self_steps(scene, 1);
        for (int i = 0; i < 6; ++i) {
            if (i >= 3) { assert_int_equal(pli_body_set_node_mass(body, i, 1), PLI_OK); }
            assert_int_equal(pli_body_set_node_velocity(body, i, pli_vec3_make(0, i >= 3 ? -6 : 0, 0)), PLI_OK);
        }
        self_steps(scene, 3);
        const pli_vec4* p = pli_body_get_view(body).positions;
        for (int i = 3; i < 6; ++i) {
            assert_true(p[i].y > 0.01f);
        }
        pli_body_destroy(body);
    }
}

static void test_crossings_are_counted(void** data) {
    self_scene* scene = *data;
    pli_vec3 x[6] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0.25f, -0.5f, 0.25f}, {0.25f, 0.5f, 0.25f}, {0.25f, 0.5f, 2}};
    pli_body* body = make_triangles(scene, x, NULL);
    assert_int_equal(crossings(body), 1);
    x[3].y = 0.001f;
    assert_int_equal(pli_body_set_state(body, x, NULL), PLI_OK);
    assert_int_equal(crossings(body), 0);
    x[3] = x[4] = x[5] = x[0]; /* degenerate: touches, does not cross */
    assert_int_equal(pli_body_set_state(body, x, NULL), PLI_OK);
    assert_int_equal(crossings(body), 0);
    assert_int_equal(pli_body_count_crossings(body, NULL), PLI_ERROR_NULL_ARGUMENT);
    self_steps(scene, 3); /* nothing to push along, nothing that is not finite */
    assert_false(pli_body_is_frozen(body));
}

// ------------------------------------------------------------------------------------------------------ twisted cloth

enum { TWIST_COLUMNS = 25, TWIST_ROWS = 9, TWIST_STEPS = 480 };

typedef struct twist {
    pli_body* body;
    pli_vec3 rest[TWIST_COLUMNS * TWIST_ROWS];
} twist;

static void make_twist(self_scene* scene, bool has_self_collision, twist* out) {
    assert_int_equal(pli_world_set_gravity(scene->world, pli_vec3_make(0, -1, 0)), PLI_OK);
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-0.3f, 0, -0.1f);
    def.corner_10 = pli_vec3_make(0.3f, 0, -0.1f);
    def.corner_01 = pli_vec3_make(-0.3f, 0, 0.1f);
    def.corner_11 = pli_vec3_make(0.3f, 0, 0.1f);
    def.columns = TWIST_COLUMNS;
    def.rows = TWIST_ROWS;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(scene->context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
    for (int r = 0; r < TWIST_ROWS; ++r) {
        assert_int_equal(pli_mesh_set_node_mass(mesh, r * TWIST_COLUMNS, 0), PLI_OK);
        assert_int_equal(pli_mesh_set_node_mass(mesh, r * TWIST_COLUMNS + TWIST_COLUMNS - 1, 0), PLI_OK);
    }
    out->body = self_make_body(scene, mesh, 0.01f, 0.02f);
    pli_solver_settings settings = pli_body_get_solver_settings(out->body);
    settings.position_iterations = 10;
    assert_int_equal(pli_body_set_solver_settings(out->body, &settings), PLI_OK);
    for (int i = 0; i < TWIST_COLUMNS * TWIST_ROWS; ++i) {
        const pli_vec4 x = pli_body_get_view(out->body).positions[i];
        out->rest[i] = pli_vec3_make(x.x, x.y, x.z);
    }
    const pli_self_faces_def faces = make_def(0.006f, 0.1f, 0);
    if (has_self_collision) { assert_int_equal(pli_body_enable_self_faces(out->body, &faces), PLI_OK); }
}

/* Both ends turn by a full turn against each other's, and come nearer. */
static void turn_twist(const twist* t, int step) {
    const float share = (float)(step + 1) / (float)TWIST_STEPS;
    for (int end = 0; end < 2; ++end) {
        const float angle = (end == 0 ? 1.0f : -1.0f) * 6.2831853f * share;
        for (int r = 0; r < TWIST_ROWS; ++r) {
            const int node = r * TWIST_COLUMNS + end * (TWIST_COLUMNS - 1);
            const pli_vec3 x = t->rest[node];
            const pli_vec3 at = pli_vec3_make(x.x * (1.0f - 0.3f * share), -x.z * sinf(angle), x.z * cosf(angle));
            assert_int_equal(pli_body_set_node_position(t->body, node, at), PLI_OK);
        }
    }
}

static int run_twist(self_scene* scene, const twist* t) {
    int worst = 0;
    for (int i = 0; i < TWIST_STEPS + 60; ++i) {
        if (i < TWIST_STEPS) { turn_twist(t, i); }
        self_steps(scene, 1);
        if (i % 10 == 9) {
            const int now = crossings(t->body);
            worst = now > worst ? now : worst;
        }
    }
    assert_false(pli_body_is_frozen(t->body));
    return worst;
}

static void test_twisted_cloth_does_not_cross_itself(void** data) {
    self_scene* scene = *data;
    twist t;
    make_twist(scene, true, &t);
    const int worst = run_twist(scene, &t);
    const pli_self_faces_report report = pli_body_get_self_faces_report(t.body);
    print_message("crossings %d, pairs %d, contacts %d, shortened %d\n", worst, report.pairs, report.contacts,
                  report.shortened);
    assert_int_equal(worst, 0);
}

static void test_twisted_cloth_without_self_collision_crosses(void** data) {
    self_scene* scene = *data;
    twist t;
    make_twist(scene, false, &t);
    const int worst = run_twist(scene, &t);
    print_message("without: %d crossings\n", worst);
    assert_true(worst > 20);
}

// ------------------------------------------------------------------------------------------------------ folding cloth

static int run_fold(self_scene* scene, bool has_self_collision, bool is_implicit, uint64_t* hash) {
    self_scene_add_floor(scene);
    pli_mesh* mesh = self_sheet_mesh(scene->context, 10, 0.05f, pli_vec3_make(0, 0.27f, 0), true);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0.02f);
    pli_implicit_def implicit = pli_implicit_def_default();
    implicit.stiffness = 200;
    if (is_implicit) { assert_int_equal(pli_body_enable_implicit(body, &implicit), PLI_OK); }
    const pli_self_faces_def def = make_def(0.01f, 0.1f, 0);
    if (has_self_collision) { assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK); }
    int worst = 0;
    uint64_t allocations = 0;
    for (int i = 0; i < 300; ++i) {
        if (i == 240) { allocations = pli_context_allocation_count(scene->context); }
        self_steps(scene, 1);
        if (i < 240 && i % 5 == 0) {
            const int now = crossings(body);
            worst = now > worst ? now : worst;
        }
    }
    assert_true(pli_context_allocation_count(scene->context) == allocations);
    assert_false(pli_body_is_frozen(body));
    *hash = pli_body_state_hash(body);
    return worst;
}

static void test_coarse_folds_do_not_cross_and_repeat(void** unused) {
    (void)unused;
    uint64_t hashes[4];
    int worst[4];
    for (int run = 0; run < 4; ++run) {
        void* data = NULL;
        assert_int_equal(self_scene_setup(&data), 0);
        worst[run] = run_fold(data, run < 3, run == 2, &hashes[run]);
        assert_int_equal(self_scene_teardown(&data), 0);
    }
    print_message("crossings %d, implicit %d, without self-collision %d\n", worst[0], worst[2], worst[3]);
    assert_true(hashes[0] == hashes[1]);
    assert_int_equal(worst[0], 0);
    assert_int_equal(worst[2], 0);
    assert_true(worst[3] > 10);
}

// ------------------------------------------------------------------------------------------------ life and misuse

static void test_cut_body_goes_on(void** data) {
    self_scene* scene = *data;
    pli_mesh* mesh = self_sheet_mesh(scene->context, 8, 0.1f, pli_vec3_make(0, 1, 0), false);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0);
    const pli_self_faces_def def = make_def(0.02f, 0, 0);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK);
    self_steps(scene, 1);
    int parted = 0;
    assert_int_equal(pli_body_cut_swept(body, pli_vec3_make(-1, 2, 0.04f), pli_vec3_make(-1, 0, 0.04f),
                                        pli_vec3_make(1, 2, 0.04f), pli_vec3_make(1, 0, 0.04f), &parted),
                     PLI_OK);
    assert_true(parted > 0);
    self_steps(scene, 30);
    assert_false(pli_body_is_frozen(body));
    assert_int_equal(crossings(body), 0);
}

static void test_misuse_is_refused(void** data) {
    self_scene* scene = *data;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    assert_int_equal(pli_mesh_create_rope(scene->context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 3, 0, &mesh),
                     PLI_OK);
    assert_int_equal(pli_body_create(scene->world, mesh, NULL, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_self_faces_def def = pli_self_faces_def_default();
    assert_int_equal(pli_body_enable_self_faces(rope, &def), PLI_ERROR_INVALID_MESH);
    assert_int_equal(crossings(rope), 0);
    mesh = self_sheet_mesh(scene->context, 4, 0.1f, pli_vec3_make(0, 1, 0), false);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0);
    const size_t bytes = pli_body_bytes(body);
    def.cookie = 0;
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_ERROR_INVALID_DEF);
    def = make_def(-1, 0, 0);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_ERROR_INVALID_VALUE);
    def = make_def(1, 2, 0);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_ERROR_INVALID_VALUE);
    def = make_def(1, 0, INFINITY);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_ERROR_NOT_FINITE);
    assert_true(pli_body_bytes(body) == bytes);
    def = make_def(0.01f, 0, 0);
    assert_int_equal(pli_world_predict(scene->world, 0.01f), PLI_OK);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_solve(scene->world), PLI_OK);
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK);
    assert_int_equal(pli_body_disable_self_faces(body), PLI_OK);
    assert_int_equal(pli_body_get_self_faces_report(body).pairs, 0);
}

static pli_status enable_once(pli_context* context, void* user) {
    (void)user;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    int count = 0;
    const pli_patch_def patch = pli_patch_def_default();
    pli_status status = pli_world_create(context, NULL, &world);
    if (status == PLI_OK) { status = pli_mesh_create_patch(context, &patch, &mesh); }
    if (status == PLI_OK) { status = pli_body_create(world, mesh, NULL, &body); }
    if (status == PLI_OK) {
        const pli_self_faces_def def = pli_self_faces_def_default();
        status = pli_body_enable_self_faces(body, &def);
    }
    if (status == PLI_OK) { status = pli_body_count_crossings(body, &count); }
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    return status;
}

static void test_without_memory_nothing_is_left(void** unused) {
    (void)unused;
    assert_true(check_survives_failing_allocator(enable_once, NULL) > 10);
}

enum { MODULES = 2, SOLVERS = 3 };

static void use_module(pli_body* body, int module) {
    assert_int_equal(module == 0 ? pli_body_enable_self_collision(body, NULL) : pli_body_enable_self_faces(body, NULL),
                     PLI_OK);
}

static void use_solver(pli_body* body, int solver) {
    if (solver == 1) { assert_int_equal(pli_body_enable_implicit(body, NULL), PLI_OK); }
    if (solver == 2) {
        assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(body, NULL), PLI_OK);
    }
}

/* A pinned node comes too near to a face right beside its pinned edge: the third node, which bears next to nothing of
   the nearest point, does not go far for that point to get away. The same for the end of an edge. */
static void test_a_node_that_bears_little_is_not_thrown_away(void** data) {
    self_scene* scene = *data;
    static const float shares[] = {1e-6f, 1e-4f, 1e-3f};
    for (int i = 0; i < 6 * SOLVERS; ++i) {
        const float share = shares[i % 3];
        const pli_vec3 face[6] = {{0, 0, 0},       {1, 0, 0},      {0, 0, 1}, {0.3f, 0.05f, share},
                                  {0.3f, 2, 0.3f}, {0.2f, 2, 0.3f}};
        const pli_vec3 edge[6] = {{0, 0, 0}, {0, -3, -3}, {1, 0, 0}, {share, 0.05f, -1}, {share, 0.05f, 1}, {0, 3, 0}};
        const bool is_face = i / 3 % 2 == 0;
        pli_body* body = make_triangles(scene, is_face ? face : edge, NULL);
        for (int k = 0; k < 6; ++k) {
            assert_int_equal(pli_body_set_node_mass(body, k, k == 2 ? 0.01f : 0.0f), PLI_OK);
        }
        use_solver(body, i / 6);
        double farthest = 0;
        for (int k = 0; k < 30; ++k) {
            self_steps(scene, 1);
            const pli_vec4 x = pli_body_get_view(body).positions[2];
            const pli_vec3 start = is_face ? face[2] : edge[2];
            farthest = fmax(farthest, (double)pli_vec3_length(pli_vec3_sub(pli_vec3_make(x.x, x.y, x.z), start)));
        }
        print_message("solver %d, %s, share %g: %.3g m\n", i / 6, is_face ? "face" : "edge", (double)share, farthest);
        check_at_most(farthest, (i / 6 == 2 ? 400 : 30) * (double)share); /* XPBD: 300 substeps instead of 30 steps */
        pli_body_destroy(body);
    }
}

/* A second, at a m/s^2 from rest. */
static void test_limits_of_motion_do_not_hold_back_the_whole_body(void** data) {
    self_scene* scene = *data;
    for (int i = 0; i < MODULES * SOLVERS; ++i) {
        pli_mesh* mesh = self_sheet_mesh(scene->context, 15, 0.05f, pli_vec3_make(0, 0, 0), false);
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(scene->world, mesh, NULL, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(body, i / MODULES);
        use_module(body, i % MODULES);
        self_steps(scene, 60);
        const float mass = pli_body_total_mass(body), fallen = pli_vec3_length(pli_body_momentum(body)) / mass;
        print_message("solver %d, module %d: %.4f m/s\n", i / MODULES, i % MODULES, (double)fallen);
        check_near(fallen, 10, 0.01);
        pli_body_destroy(body);
    }
}

/* A cape on a bar that gets to 3 m/s in half a second and then stops. Limits of motion in the world made it 54 times as
 * long. */
static void test_a_cape_follows_a_runner(void** data) {
    static const double most[SOLVERS][MODULES] = {{0.15, 0.2}, {0.25, 0.25}, {0.2, 0.15}};
    for (int i = 0; i < MODULES * SOLVERS; ++i) {
        self_scene* scene = *data;
        pli_rigid_def def = pli_rigid_def_default();
        def.kind = PLI_RIGID_KINEMATIC;
        pli_rigid* bar = NULL;
        assert_int_equal(pli_rigid_create(scene->world, &def, &bar), PLI_OK);
        pli_patch_def sheet = pli_patch_def_default();
        sheet.corner_00 = pli_vec3_make(-0.5f, 0, 0);
        sheet.corner_10 = pli_vec3_make(0.5f, 0, 0);
        sheet.corner_01 = pli_vec3_make(-0.5f, -1, 0);
        sheet.corner_11 = pli_vec3_make(0.5f, -1, 0);
        sheet.columns = sheet.rows = 21;
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create_patch(scene->context, &sheet, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
        pli_body* cape = NULL;
        pli_body_def cape_def = pli_body_def_default();
        cape_def.solver.position_iterations = 10;
        assert_int_equal(pli_body_create(scene->world, mesh, &cape_def, &cape), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(cape, i / MODULES);
        int top[21];
        for (int k = 0; k < 21; ++k) {
            top[k] = k;
        }
        assert_int_equal(pli_body_attach_nodes(cape, top, 21, bar), PLI_OK);
        assert_int_equal(pli_body_enable_tethers(cape, NULL), PLI_OK);
        use_module(cape, i % MODULES);
        float stretch = 0;
        for (int k = 0; k < 200; ++k) {
            pli_rigid_state state = pli_rigid_get_state(bar);
            state.linear_velocity.z = k < 150 ? 3 * fminf(1, (float)k / 30) : 0;
            assert_int_equal(pli_rigid_set_state(bar, &state), PLI_OK);
            self_steps(scene, 1);
            state.pose.origin.z += state.linear_velocity.z / 60;
            assert_int_equal(pli_rigid_set_state(bar, &state), PLI_OK);
            stretch = fmaxf(stretch, pli_body_max_stretch(cape));
        }
        print_message("solver %d, module %d: %.3f\n", i / MODULES, i % MODULES, (double)stretch);
        check_at_most(stretch, most[i / MODULES][i % MODULES]);
        pli_body_destroy(cape);
        pli_rigid_destroy(bar);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_node_is_kept_off_a_face, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_friction_takes_its_share_of_the_sliding, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_edge_is_kept_off_an_edge, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_fast_pairs_do_not_cross, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_what_was_pinned_does_not_go_through, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_crossings_are_counted, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_twisted_cloth_does_not_cross_itself, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_twisted_cloth_without_self_collision_crosses, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test(test_coarse_folds_do_not_cross_and_repeat),
        cmocka_unit_test_setup_teardown(test_cut_body_goes_on, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_a_node_that_bears_little_is_not_thrown_away, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_limits_of_motion_do_not_hold_back_the_whole_body, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_a_cape_follows_a_runner, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_misuse_is_refused, self_scene_setup, self_scene_teardown),
        cmocka_unit_test(test_without_memory_nothing_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
