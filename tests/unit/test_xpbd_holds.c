/* Rigid bodies on pinned cloth under XPBD: what falls on it is not thrown higher than it came from, and comes to rest.
 */

#include "test_world.h"

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

enum { NODES_PER_SIDE = 21 };
static const float dt = 1.0f / 60.0f, radius = 0.3f;

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

static bool is_pinned(const fall* f, int node) {
    const int last = NODES_PER_SIDE - 1, column = node % NODES_PER_SIDE, row = node / NODES_PER_SIDE;
    const bool ends_row = column == 0 || column == last, ends_column = row == 0 || row == last;
    return f->has_rim ? ends_row || ends_column : ends_row && ends_column;
}

/* 2 m by 2 m and 1 kg at height 0. */
static pli_body* make_sheet(const fall* f) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-1, 0, -1);
    patch.corner_10 = pli_vec3_make(1, 0, -1);
    patch.corner_01 = pli_vec3_make(-1, 0, 1);
    patch.corner_11 = pli_vec3_make(1, 0, 1);
    patch.columns = patch.rows = NODES_PER_SIDE;
    patch.diagonals = true;
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    for (int i = 0; i < NODES_PER_SIDE * NODES_PER_SIDE; ++i) {
        if (is_pinned(f, i)) { CHECK_OK(pli_mesh_set_node_mass(mesh, i, 0)); }
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    def.solver.velocity_damping = f->damping;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    pli_xpbd_def solver = pli_xpbd_def_default();
    solver.substeps = f->substeps;
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = 1.0f / (1000.0f * (1.0f + f->mass));
    pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
    pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
    nodes.friction = faces.friction = 1;
    CHECK_OK(pli_body_enable_xpbd(body, &solver));
    CHECK_OK(pli_body_enable_xpbd_links(body, &links));
    CHECK_OK(pli_body_enable_rigid_contacts(body, &nodes));
    if (f->has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(body, &faces)); }
    if (f->has_tethers) { CHECK_OK(pli_body_enable_tethers(body, NULL)); }
    return body;
}

static pli_rigid* make_ball(const fall* f) {
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_sphere(context, radius, &shape));
    const float inverse = 1.0f / (0.4f * f->mass * radius * radius);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.pose.origin.y = radius + f->height;
    def.state.inverse_mass = 1.0f / f->mass;
    def.state.inverse_inertia_world =
        (pli_mat3){{pli_vec3_make(inverse, 0, 0), pli_vec3_make(0, inverse, 0), pli_vec3_make(0, 0, inverse)}};
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
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
    pli_body* sheet = make_sheet(&f);
    pli_rigid* ball = make_ball(&f);
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
    pli_body* sheet = make_sheet(&f);
    pli_rigid* ball = make_ball(&f);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_trampolines_throw_nothing_higher_than_it_fell, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_ball_rests_on_faces, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
