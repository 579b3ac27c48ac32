/* Tearing: where, into what, and what stays as it is. */

#include "sample_mesh.h"

#include "heavy_bodies.h"
#include "manifold.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;

static int part_count(const pli_body* body) {
    int count = -1;
    CHECK_OK(pli_body_count_parts(body, &count));
    return count;
}

static pli_body* make_body(pli_mesh* mesh) {
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, NULL, &body));
    pli_mesh_destroy(mesh);
    return body;
}

/* Nodes whose x is above `border` go by `way` along x. */
static void pull_apart(pli_body* body, float border, float way) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i];
        if (x.x > border) { CHECK_OK(pli_body_set_node_position(body, i, pli_vec3_make(x.x + way, x.y, x.z))); }
    }
}

static int tear(pli_body* body, float stretch, int most) {
    int torn = -1;
    CHECK_OK(pli_body_tear(body, stretch, most, &torn));
    return torn;
}

static pli_mesh* make_rope_mesh(void) {
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(10, 0, 0), 9, 0, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1.1f));
    return mesh;
}

static void a_rope_parts_at_an_end_of_its_longest_link(void** unused) {
    (void)unused;
    for (int has_bending = 0; has_bending < 2; ++has_bending) {
        pli_mesh* mesh = make_rope_mesh();
        if (has_bending) { CHECK_OK(pli_mesh_append_bending_links(mesh, 2, 0, NULL)); }
        pli_body* rope = make_body(mesh);
        pull_apart(rope, 4.5f, 1); /* link 4 is twice as long as it was */
        assert_int_equal(tear(rope, 1.1f, 5), 0);
        assert_int_equal(part_count(rope), 1);
        assert_int_equal(tear(rope, 0.9f, 5), 1);
        assert_int_equal(part_count(rope), 2);
        check_manifold(rope);
        const pli_body_view view = pli_body_get_view(rope);
        assert_int_equal(view.node_count, 12);
        /* The node at x = 4 shares its mass with its copy, which goes with the link. */
        check_near(view.positions[11].x, 4, 0);
        check_near(view.positions[11].w, 20, 1e-4);
        check_near(view.positions[4].w, 20, 1e-4);
        check_near(pli_body_total_mass(rope), 1.1, 1e-6);
        pli_body_destroy(rope);
    }
}

/* Two nodes of a rope that may not be parted: a pinned one, and the last one. */
static void ends_and_pinned_nodes_stay(void** unused) {
    (void)unused;
    pli_mesh* mesh = make_rope_mesh();
    CHECK_OK(pli_mesh_set_node_mass(mesh, 9, 0));
    pli_body* rope = make_body(mesh);
    pull_apart(rope, 9.5f, 5);
    assert_int_equal(tear(rope, 0.5f, 5), 0);
    assert_int_equal(pli_body_get_view(rope).node_count, 11);
    pli_body_destroy(rope);
}

static void a_sheet_parts_along_its_edges(void** unused) {
    (void)unused;
    for (int has_bending = 0; has_bending < 2; ++has_bending) {
        const pli_patch_def patch = level_sheet(1, 0, 9);
        pli_mesh* mesh = NULL;
        CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
        if (has_bending) { CHECK_OK(pli_mesh_append_bending_links(mesh, 2, 0, NULL)); }
        CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
        pli_body* sheet = make_body(mesh);
        pull_apart(sheet, 0.1f, 1); /* all links between two columns are long */
        const int torn = tear(sheet, 0.5f, 100);
        const pli_body_view view = pli_body_get_view(sheet);
        print_message("%d torn, %d nodes, %d parts\n", torn, view.node_count, part_count(sheet));
        check_manifold(sheet);
        assert_int_equal(torn, 9);
        assert_in_range(view.node_count, 81 + 9, 81 + 11); /* where the tear turns, a node is parted in three */
        assert_int_equal(view.face_count, 128);
        assert_int_equal(part_count(sheet), 2);
        check_near(pli_body_total_mass(sheet), 1, 1e-6);
        pli_body_destroy(sheet);
    }
}

/* Weightless, pinned along two edges, one of which goes away at 1 m/s. */
static void a_sheet_that_is_pulled_apart_tears_in_two(void** unused) {
    (void)unused;
    enum { SIDE = 17 };
    for (int solver = 0; solver < 2; ++solver) {
        const pli_patch_def patch = level_sheet(1, 0, SIDE);
        pli_mesh* mesh = NULL;
        CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
        CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
        for (int row = 0; row < SIDE; ++row) {
            CHECK_OK(pli_mesh_set_node_mass(mesh, row * SIDE, 0));
            CHECK_OK(pli_mesh_set_node_mass(mesh, row * SIDE + SIDE - 1, 0));
        }
        pli_body* sheet = make_body(mesh);
        if (solver == 1) {
            CHECK_OK(pli_body_enable_xpbd(sheet, NULL));
            CHECK_OK(pli_body_enable_xpbd_links(sheet, NULL));
        } else {
            CHECK_OK(pli_body_enable_colored_links(sheet));
        }
        int torn = 0;
        for (int i = 0; i < 240; ++i) {
            for (int row = 0; row < SIDE; ++row) {
                const int node = row * SIDE + SIDE - 1;
                const pli_vec4 x = pli_body_get_view(sheet).positions[node];
                CHECK_OK(pli_body_move_node(sheet, node, pli_vec3_make(x.x + dt, x.y, x.z)));
            }
            CHECK_OK(pli_world_step(world, dt));
            torn += tear(sheet, 0.5f, 4);
        }
        check_manifold(sheet);
        const int parts = part_count(sheet);
        print_message("%d torn, %d parts, stretch %.2f\n", torn, parts, (double)pli_body_max_stretch(sheet));
        assert_in_range(torn, SIDE - 4, 4 * SIDE);
        assert_in_range(parts, 2, 10);
        assert_int_equal(tear(sheet, 0.5f, 4), 0);
        check_at_most(pli_body_kinetic_energy(sheet), 1); /* 1 kg at 1 m/s has half of it */
        pli_body_destroy(sheet);
    }
}

/* 10 kg from a metre above a sheet of 1 kg that is pinned along its rim: through, with a hole, and little that is
 * loose. */
static void a_heavy_ball_tears_through(void** unused) {
    (void)unused;
    enum { SIDE = 41 };
    const pli_patch_def patch = level_sheet(1, 0, SIDE);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (level_sheet_is_rim(i, SIDE)) { CHECK_OK(pli_mesh_set_node_mass(mesh, i, 0)); }
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    def.solver.position_iterations = 16;
    def.solver.velocity_damping = 0.005f;
    pli_body* sheet = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &sheet));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_colored_links(sheet));
    CHECK_OK(pli_body_enable_rigid_contacts(sheet, NULL));
    CHECK_OK(pli_body_enable_rigid_face_contacts(sheet, NULL));
    CHECK_OK(pli_body_enable_soft_contacts(sheet, NULL));
    pli_rigid* ball = make_ball(1, 10);
    int torn = 0;
    for (int i = 0; i < 60; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(ball, pli_vec3_make(0, -10, 0), dt));
        torn += tear(sheet, 0.5f, 8);
        check_manifold(sheet);
    }
    const float height = pli_rigid_get_state(ball).pose.origin.y;
    print_message("%d torn, %d parts, ball at %.1f m\n", torn, part_count(sheet), (double)height);
    check_at_most(height, -2);
    assert_in_range(torn, 60, 120);
    assert_in_range(part_count(sheet), 1, 12);
    pli_rigid_destroy(ball);
    pli_body_destroy(sheet);
}

/* Links that are long, but not too long; that are too short; bending links that are too long. */
static void what_is_not_too_long_costs_nothing(void** unused) {
    (void)unused;
    const float ways[] = {0.4f, -0.6f, 0};
    for (int way = 0; way < 3; ++way) {
        pli_mesh* mesh = make_rope_mesh();
        CHECK_OK(pli_mesh_append_bending_links(mesh, 2, 0, NULL));
        pli_body* rope = make_body(mesh);
        pull_apart(rope, 4.5f, ways[way]);
        if (way == 2) { CHECK_OK(pli_body_set_rest_length(rope, 10, 1)); } /* of the first bending link, 2 m */
        const uint64_t hash = pli_body_state_hash(rope), allocations = pli_context_allocation_count(context);
        assert_int_equal(tear(rope, 0.5f, 5), 0);
        assert_true(pli_context_allocation_count(context) == allocations);
        assert_true(pli_body_state_hash(rope) == hash);
        pli_body_destroy(rope);
    }
}

static void bad_input_is_refused(void** unused) {
    (void)unused;
    pli_body* rope = make_body(make_rope_mesh());
    pull_apart(rope, 4.5f, 1);
    assert_int_equal(pli_body_tear(rope, 0, 1, NULL), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_tear(rope, NAN, 1, NULL), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_body_tear(rope, 0.5f, 0, NULL), PLI_ERROR_INVALID_VALUE);
    assert_string_equal(pli_last_error(context), "pli_body_tear: most is 0, 1 at least");
    assert_int_equal(pli_body_get_view(rope).node_count, 11);
    CHECK_OK(pli_body_tear(rope, 0.5f, 1, NULL));
    assert_int_equal(pli_body_get_view(rope).node_count, 12);
    pli_body_destroy(rope);
    pli_mesh* mesh = NULL;
    CHECK_OK(sample_create_slab(context, &mesh));
    pli_body* slab = make_body(mesh);
    CHECK_OK(pli_body_tear(slab, 0.5f, 1, NULL));
    pull_apart(slab, 0, 1);
    assert_int_equal(pli_body_tear(slab, 0.5f, 1, NULL), PLI_ERROR_INVALID_MESH);
    pli_body_destroy(slab);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_rope_parts_at_an_end_of_its_longest_link, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(ends_and_pinned_nodes_stay, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_sheet_parts_along_its_edges, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_sheet_that_is_pulled_apart_tears_in_two, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(a_heavy_ball_tears_through, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(what_is_not_too_long_costs_nothing, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(bad_input_is_refused, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
