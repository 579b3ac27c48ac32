/* Tethers: what they measure, how far nodes and rigid bodies get under each solver, cuts, what they cost, bad input. */

#include "failing_allocator.h"
#include "test_world.h"

#include <string.h>

static const float dt = 1.0f / 60.0f;

/* Nodes 0 to 9 along x, 2 m, node 0 pinned, the others 10 g each. */
static pli_body* make_rope(void) {
    pli_mesh* mesh = NULL;
    assert_int_equal(
        pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 0, 0), 8, PLI_ROPE_PIN_FIRST, &mesh),
        PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.09f), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 10;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static pli_body* make_sheet(int pins) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(0, 0, 0);
    def.corner_10 = pli_vec3_make(5, 0, 0);
    def.corner_01 = pli_vec3_make(0, 0, 5);
    def.corner_11 = pli_vec3_make(5, 0, 5);
    def.columns = def.rows = 6;
    def.pins = pins;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static void tether(pli_body* body, float slack) {
    pli_tethers_def def = pli_tethers_def_default();
    def.slack = slack;
    assert_int_equal(pli_body_enable_tethers(body, &def), PLI_OK);
}

static pli_vec3 position(const pli_body* body, int node) {
    const pli_vec4 x = pli_body_get_view(body).positions[node];
    return pli_vec3_make(x.x, x.y, x.z);
}

typedef enum solver { POSITION, SWEEPS, GRADIENTS, XPBD, SOLVER_COUNT } solver;

static void use_solver(pli_body* body, solver which, float stiffness) {
    if (which == XPBD) {
        const pli_xpbd_def def = pli_xpbd_def_default();
        assert_int_equal(pli_body_enable_xpbd(body, &def), PLI_OK);
        const pli_xpbd_links_def links = pli_xpbd_links_def_default();
        assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
    } else if (which != POSITION) {
        pli_implicit_def def = pli_implicit_def_default();
        def.stiffness = stiffness;
        if (which == GRADIENTS) {
            def.method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
            def.sweeps = 200;
        }
        assert_int_equal(pli_body_enable_implicit(body, &def), PLI_OK);
    }
}

// ------------------------------------------------------------------------------------------------------- measuring

static void test_tethers_go_straight_across_faces(void** state) {
    (void)state;
    const pli_body* none = make_sheet(0);
    pli_body* sheet = make_sheet(PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10);
    tether(sheet, 0);
    for (int row = 0; row < 6; ++row) {
        for (int column = 0; column < 6; ++column) {
            const int near = column < 3 ? column : 5 - column, i = row * 6 + column;
            const pli_tether t = pli_body_get_tether(sheet, i);
            assert_true(t.origin == (column < 3 ? 0 : 5));
            check_near(t.length, hypotf((float)near, (float)row), 1e-5f); /* straight, where links go round corners */
        }
    }
    assert_int_equal(pli_body_get_tether(none, 7).origin, PLI_NULL_INDEX); /* not enabled */
    pli_body* loose = make_sheet(0);
    tether(loose, 0);
    assert_int_equal(pli_body_get_tether(loose, 7).origin, PLI_NULL_INDEX);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
}

/* Around a ball of 1 m, of which one node is pinned. */
static void test_tethers_follow_curved_faces(void** state) {
    (void)state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1), 1000, &mesh),
                     PLI_OK);
    assert_int_equal(pli_mesh_set_node_mass(mesh, 0, 0), PLI_OK);
    pli_body* ball = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &ball), PLI_OK);
    pli_mesh_destroy(mesh);
    tether(ball, 0);
    float largest = 0, smallest = 2, smallest_near = 2;
    for (int i = 1; i < pli_body_get_view(ball).node_count; ++i) {
        const float arc = 2 * asinf(0.5f * pli_vec3_length(pli_vec3_sub(position(ball, i), position(ball, 0))));
        const float ratio = pli_body_get_tether(ball, i).length / arc;
        largest = fmaxf(largest, ratio);
        smallest = fminf(smallest, ratio);
        if (arc < 1.57f) { smallest_near = fminf(smallest_near, ratio); }
    }
    print_message("%.4f to %.4f of the arc, from %.4f within a quarter\n", (double)smallest, (double)largest,
                  (double)smallest_near);
    check_at_most(largest, 1);
    check_at_most(-smallest_near, -0.993);
    check_at_most(-smallest, -0.975); /* opposite nodes, where paths of all directions meet */
}

static void test_tethers_follow_rest_lengths_and_masses(void** state) {
    (void)state;
    pli_body* rope = make_rope();
    tether(rope, 0);
    check_near(pli_body_get_tether(rope, 9).length, 2.0f, 1e-5f);
    assert_int_equal(pli_body_set_rest_length(rope, 0, 0.5f), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    check_near(pli_body_get_tether(rope, 9).length, 2.5f - 2.0f / 9.0f, 1e-5f);
    /* Without its pinned node the rope falls. */
    assert_int_equal(pli_body_set_node_mass(rope, 0, 0.01f), PLI_OK);
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    check_at_most(position(rope, 5).y, -4.5f);
}

static void test_tethers_follow_cuts(void** state) {
    (void)state;
    pli_body* rope = make_rope();
    tether(rope, 0);
    assert_int_equal(pli_body_cut_link(rope, 4, 5, 0.5f), PLI_OK);
    assert_int_equal(pli_body_get_tether(rope, 4).origin, 0);
    assert_int_equal(pli_body_get_tether(rope, 6).origin, PLI_NULL_INDEX);
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    check_at_most(position(rope, 7).y, -4.5f);
    assert_true(pli_vec3_length(position(rope, 4)) < 0.95f);
}

// --------------------------------------------------------------------------------------------------------- holding

/* A heavy node at the end of a light rope swings like a pendulum. */
static void test_tethers_hold_a_heavy_node(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* rope = make_rope();
        use_solver(rope, (solver)which, 1e7f);
        assert_int_equal(pli_body_set_node_mass(rope, 9, 1e4f), PLI_OK);
        tether(rope, 0.01f);
        float most = 0;
        for (int i = 0; i < 300; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            most = fmaxf(most, pli_vec3_length(position(rope, 9)));
        }
        /* The implicit solver has springs of 1e9 N/m for 1e5 N and its swing. */
        check_at_most(most, 2.0f * 1.01f + 3e-4f);
        pli_body_destroy(rope);
    }
}

/* The same with a rigid body of 1 t at the end, moved after each step as its host would. */
static void test_tethers_hold_a_rigid_body(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* rope = make_rope();
        use_solver(rope, (solver)which, 1e7f);
        pli_rigid_def rigid_def = pli_rigid_def_default();
        rigid_def.kind = PLI_RIGID_DYNAMIC;
        rigid_def.state.pose.origin = pli_vec3_make(2, 0, 0);
        rigid_def.state.inverse_mass = 1e-3f;
        pli_rigid* rigid = NULL;
        assert_int_equal(pli_rigid_create(world, &rigid_def, &rigid), PLI_OK);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.node = 9;
        anchor.rigid = rigid;
        assert_int_equal(pli_body_add_anchor(rope, &anchor, NULL), PLI_OK);
        tether(rope, 0.01f);
        float most = 0;
        for (int i = 0; i < 300; ++i) {
            pli_rigid_state rigid_state = pli_rigid_get_state(rigid);
            rigid_state.linear_velocity.y -= 10 * dt;
            assert_int_equal(pli_rigid_set_state(rigid, &rigid_state), PLI_OK);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            rigid_state = pli_rigid_get_state(rigid);
            rigid_state.pose.origin =
                pli_vec3_add(rigid_state.pose.origin, pli_vec3_scale(rigid_state.linear_velocity, dt));
            assert_int_equal(pli_rigid_set_state(rigid, &rigid_state), PLI_OK);
            most = fmaxf(most, pli_vec3_length(rigid_state.pose.origin));
        }
        check_at_most(most, 2.0f * 1.03f);
        pli_body_destroy(rope);
        pli_rigid_destroy(rigid);
    }
}

/* A rope of 0.1 kg between 10 and 20 kg, the heavier one thrown off at 6 m/s: it takes the other one along. */
static void test_tethers_hold_rigid_bodies_together(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        if (which == SWEEPS || which == GRADIENTS) { continue; } /* have springs alone */
        pli_body* rope = make_rope();
        assert_int_equal(pli_body_set_node_mass(rope, 0, 0.01f), PLI_OK);
        use_solver(rope, (solver)which, 0);
        pli_rigid* rigids[2];
        for (int i = 0; i < 2; ++i) {
            pli_rigid_def def = pli_rigid_def_default();
            def.kind = PLI_RIGID_DYNAMIC;
            def.state.pose.origin = position(rope, 9 * i);
            def.state.inverse_mass = i == 0 ? 0.1f : 0.05f;
            def.state.linear_velocity.x = i == 0 ? 0.0f : 6.0f;
            assert_int_equal(pli_rigid_create(world, &def, &rigids[i]), PLI_OK);
            assert_int_equal(pli_body_attach_nodes(rope, &(int){9 * i}, 1, rigids[i]), PLI_OK);
        }
        tether(rope, 0.01f);
        float most = 0;
        for (int i = 0; i < 120; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            for (int k = 0; k < 2; ++k) {
                assert_int_equal(pli_rigid_integrate(rigids[k], pli_vec3_make(0, 0, 0), dt), PLI_OK);
            }
            const pli_rigid_state a = pli_rigid_get_state(rigids[0]), b = pli_rigid_get_state(rigids[1]);
            most = fmaxf(most, pli_vec3_length(pli_vec3_sub(a.pose.origin, b.pose.origin)));
            const float momentum = 10 * a.linear_velocity.x + 20 * b.linear_velocity.x + pli_body_momentum(rope).x;
            check_near(momentum, 120, 1e-2f);
        }
        print_message("solver %d: %.3f m apart\n", which, (double)most);
        check_at_most(most, 2.0f * 1.02f);
        assert_int_equal(pli_body_get_tether(rope, 5).origin, PLI_NULL_INDEX);
        pli_body_destroy(rope);
        pli_rigid_destroy(rigids[0]);
        pli_rigid_destroy(rigids[1]);
    }
}

/* 40 by 38 nodes, 1.2 m by 1 m, that hang from a kinematic body along their upper edge. */
static pli_body* make_cape(pli_rigid* rigid) {
    enum { COLUMNS = 40, ROWS = 38 };
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-0.6f, 0, 0);
    def.corner_10 = pli_vec3_make(0.6f, 0, 0);
    def.corner_01 = pli_vec3_make(-0.6f, -1, 0);
    def.corner_11 = pli_vec3_make(0.6f, -1, 0);
    def.columns = COLUMNS;
    def.rows = ROWS;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 8;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    for (int i = 0; i < COLUMNS; ++i) {
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.node = i;
        anchor.rigid = rigid;
        assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK);
    }
    return body;
}

/* Of all tethers, as a share of their length. */
static float longest(const pli_body* body) {
    float most = 0;
    for (int i = 0; i < pli_body_get_view(body).node_count; ++i) {
        const pli_tether t = pli_body_get_tether(body, i);
        if (t.origin == PLI_NULL_INDEX || t.origin == i) { continue; }
        const float distance = pli_vec3_length(pli_vec3_sub(position(body, i), position(body, t.origin)));
        most = fmaxf(most, distance / t.length - 1);
    }
    return most;
}

static pli_rigid* make_kinematic(pli_vec3 origin) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_KINEMATIC;
    def.state.pose.origin = origin;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    return rigid;
}

/* A rope that is held at both ends, which are a fifth farther apart than it is long: its nodes stay in proportion. Not
   so under the implicit solver, which has tethers to the nearest end alone. */
static void test_tethers_stretch_with_their_origins(void** state) {
    (void)state;
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)), PLI_OK);
    static const solver solvers[] = {POSITION, XPBD};
    for (int which = 0; which < 2; ++which) {
        pli_body* rope = make_rope();
        use_solver(rope, solvers[which], 1e5f);
        assert_int_equal(pli_body_set_node_mass(rope, 9, 0), PLI_OK);
        tether(rope, 0.01f);
        for (int i = 0; i < 240; ++i) {
            const float x = 2.0f + 0.4f * fminf(1, (float)i / 60);
            assert_int_equal(pli_body_move_node(rope, 9, pli_vec3_make(x, 0, 0)), PLI_OK);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        for (int i = 1; i < 10; ++i) {
            check_near(position(rope, i).x, 2.4f / 9 * (float)i, 0.025f);
        }
        pli_body_destroy(rope);
    }
}

/* At rest, 90 steps at 6 m/s, at rest again; without tethers a position-based cape gets three times as long. */
static void test_tethers_hold_a_cape(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_rigid* rigid = make_kinematic(pli_vec3_make(0, 0, 0));
        pli_body* cape = make_cape(rigid);
        use_solver(cape, (solver)which, 1e3f);
        tether(cape, 0.01f);
        assert_int_equal(pli_body_get_tether(cape, 40 * 37 + 7).origin, 7);
        float most = 0;
        for (int i = 0; i < 150; ++i) {
            pli_rigid_state rigid_state = pli_rigid_get_state(rigid);
            rigid_state.linear_velocity.z = i >= 30 && i < 120 ? 6.0f : 0.0f;
            assert_int_equal(pli_rigid_set_state(rigid, &rigid_state), PLI_OK);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            assert_int_equal(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), dt), PLI_OK);
            most = fmaxf(most, longest(cape));
        }
        print_message("solver %d: %.2f %% longer\n", which, 100 * (double)most);
        check_at_most(most, 0.03);
        pli_body_destroy(cape);
        pli_rigid_destroy(rigid);
    }
}

/* Carried steadily at 20 m/s it hangs as at rest. */
static void test_tethers_leave_a_carried_cape_calm(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        float most[2] = {0, 0};
        for (int run = 0; run < 2; ++run) {
            const pli_vec3 carried = pli_vec3_make(0, 0, run == 0 ? 0.0f : 20.0f);
            pli_rigid* rigid = make_kinematic(pli_vec3_make(0, 0, 0));
            pli_body* cape = make_cape(rigid);
            use_solver(cape, (solver)which, 1e3f);
            tether(cape, 0.01f);
            pli_rigid_state rigid_state = pli_rigid_get_state(rigid);
            rigid_state.linear_velocity = carried;
            assert_int_equal(pli_rigid_set_state(rigid, &rigid_state), PLI_OK);
            assert_int_equal(pli_body_add_velocity(cape, carried), PLI_OK);
            for (int i = 0; i < 90; ++i) {
                assert_int_equal(pli_world_step(world, dt), PLI_OK);
                assert_int_equal(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), dt), PLI_OK);
                const pli_body_view view = pli_body_get_view(cape);
                for (int k = 0; k < view.node_count; ++k) {
                    const pli_vec4 v = view.velocities[k];
                    most[run] = fmaxf(most[run], pli_vec3_length(pli_vec3_sub(pli_vec3_make(v.x, v.y, v.z), carried)));
                }
            }
            pli_body_destroy(cape);
            pli_rigid_destroy(rigid);
        }
        print_message("solver %d: %.2f m/s at rest, %.2f carried\n", which, (double)most[0], (double)most[1]);
        check_at_most(most[1], 1.1f * most[0] + 0.05f);
    }
}

static void test_tethers_follow_anchors(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* rope = make_rope();
        use_solver(rope, (solver)which, 1e3f);
        tether(rope, 0.01f);
        assert_int_equal(pli_body_get_tether(rope, 8).origin, 0);
        pli_rigid* rigid = make_kinematic(pli_vec3_make(2, 0, 0));
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.node = 9;
        anchor.rigid = rigid;
        pli_anchor_id id;
        assert_int_equal(pli_body_add_anchor(rope, &anchor, &id), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_body_get_tether(rope, 4).origin, 0);
        assert_int_equal(pli_body_get_tether(rope, 8).origin, 9);
        check_near(pli_body_get_tether(rope, 8).length, 2.0f / 9, 1e-5f);
        /* It counts as none while its rigid body is not present, nor on a dynamic one. */
        assert_int_equal(pli_rigid_set_present(rigid, false), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_body_get_tether(rope, 8).origin, 0);
        assert_int_equal(pli_rigid_set_present(rigid, true), PLI_OK);
        pli_rigid_state rigid_state = pli_rigid_get_state(rigid);
        rigid_state.inverse_mass = 1;
        assert_int_equal(pli_rigid_set_kind(rigid, PLI_RIGID_DYNAMIC, &rigid_state), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_body_get_tether(rope, 8).origin, 0);
        assert_int_equal(pli_rigid_set_kind(rigid, PLI_RIGID_KINEMATIC, &rigid_state), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_body_get_tether(rope, 8).origin, 9);
        const uint64_t allocations = pli_context_allocation_count(context);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_context_allocation_count(context), allocations);
        assert_int_equal(pli_body_remove_anchor(rope, id), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_body_get_tether(rope, 8).origin, 0);
        pli_body_destroy(rope);
        pli_rigid_destroy(rigid);
    }
}

/* Nodes that start too far away come back slowly. */
static void test_tethers_pull_back_slowly(void** state) {
    (void)state;
    for (int which = 0; which < 2; ++which) {
        pli_body* rope = make_rope();
        if (which == 1) {
            const pli_xpbd_def def = pli_xpbd_def_default();
            assert_int_equal(pli_body_enable_xpbd(rope, &def), PLI_OK);
        } else {
            assert_int_equal(pli_body_enable_velocity_links(rope), PLI_OK); /* none on positions */
        }
        tether(rope, 0);
        assert_int_equal(pli_body_set_node_position(rope, 9, pli_vec3_make(4, 0, 0)), PLI_OK);
        assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)), PLI_OK);
        for (int i = 1; i <= 60; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            check_near(position(rope, 9).x, 4 - (float)i * dt, 1e-4f);
        }
        pli_body_destroy(rope);
    }
}

/* m/s, of a rope without gravity that is let go at twice its length. */
static float fastest_of_stretched(solver which, bool has_tethers) {
    pli_body* rope = make_rope();
    use_solver(rope, which, 10);
    for (int i = 1; i < 10; ++i) {
        assert_int_equal(pli_body_set_node_position(rope, i, pli_vec3_make(4.0f * (float)i / 9, 0, 0)), PLI_OK);
    }
    if (has_tethers) { tether(rope, 0); }
    float fastest = 0;
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        for (int node = 1; node < 10; ++node) {
            const pli_vec4 v = pli_body_get_view(rope).velocities[node];
            fastest = fmaxf(fastest, pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
        }
    }
    pli_body_destroy(rope);
    return fastest;
}

/* Under the implicit solver tethers are springs 100 times as stiff as links. They would shoot what is too long already:
   the rope that its own links make 7.1 m/s fast, at 116 m/s. */
static void test_tethers_do_not_shoot_a_stretched_rope(void** state) {
    (void)state;
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)), PLI_OK);
    for (int which = SWEEPS; which <= GRADIENTS; ++which) {
        const float without = fastest_of_stretched((solver)which, false);
        assert_true(fastest_of_stretched((solver)which, true) < without + 1.1f);
    }
}

static void test_tethers_leave_slack_bodies_alone(void** state) {
    (void)state;
    uint64_t hashes[2];
    for (int k = 0; k < 2; ++k) {
        pli_body* rope = make_rope();
        for (int i = 1; i < 10; ++i) { /* rolled up */
            const float angle = 0.6f * (float)i;
            assert_int_equal(
                pli_body_set_node_position(rope, i, pli_vec3_make(0.2f * cosf(angle), 0.2f * sinf(angle), 0)), PLI_OK);
        }
        if (k == 1) { tether(rope, 0.5f); }
        for (int i = 0; i < 10; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        hashes[k] = pli_body_state_hash(rope);
        pli_body_destroy(rope);
    }
    assert_true(hashes[0] == hashes[1]);
}

// --------------------------------------------------------------------------------------------------- costs, errors

static void test_tethers_cost_little(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(PLI_PATCH_PIN_00);
    const size_t before = pli_body_bytes(sheet);
    tether(sheet, 0);
    check_at_most(pli_body_bytes(sheet) - before, (size_t)(36 * 40 + 2500)); /* and the list of features */
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const size_t settled = pli_context_allocated_bytes(context);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_context_allocated_bytes(context), settled);
    assert_int_equal(pli_body_disable_tethers(sheet), PLI_OK);
    assert_int_equal(pli_body_get_features(sheet, 0, NULL), 1);
}

static pli_status tether_under_failure(pli_context* failing, void* user) {
    (void)user;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    const pli_tethers_def def = pli_tethers_def_default();
    pli_status status = pli_world_create(failing, NULL, &w);
    if (status == PLI_OK) {
        status =
            pli_mesh_create_rope(failing, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 0, 0), 8, PLI_ROPE_PIN_FIRST, &mesh);
    }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &body); }
    if (status == PLI_OK) { status = pli_body_enable_tethers(body, &def); }
    for (int i = 0; status == PLI_OK && i < 2; ++i) { /* again, with as much slack, and with another origin */
        const pli_tether before = pli_body_get_tether(body, 5);
        if (i > 0) { assert_int_equal(pli_body_set_node_mass(body, 9, 0), PLI_OK); }
        status = pli_body_enable_tethers(body, &def);
        const pli_tether after = pli_body_get_tether(body, 5);
        if (i == 0) { assert_true(after.origin == before.origin && after.length == before.length); }
        if (status == PLI_OK) { assert_int_equal(after.origin, i == 0 ? 0 : 9); }
    }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_tethers_survive_failing_memory(void** state) {
    (void)state;
    assert_true(check_survives_failing_allocator(tether_under_failure, NULL) > 3);
}

static void test_tethers_refuse_bad_input(void** state) {
    (void)state;
    pli_body* rope = make_rope();
    pli_tethers_def def = pli_tethers_def_default();
    assert_int_equal(pli_body_enable_tethers(NULL, &def), PLI_ERROR_NULL_ARGUMENT);
    def.slack = -1;
    assert_int_equal(pli_body_enable_tethers(rope, &def), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(context), "slack is -1"));
    def.slack = NAN;
    assert_int_equal(pli_body_enable_tethers(rope, &def), PLI_ERROR_NOT_FINITE);
    def = pli_tethers_def_default();
    def.cookie = 0;
    assert_int_equal(pli_body_enable_tethers(rope, &def), PLI_ERROR_INVALID_DEF);
    def = pli_tethers_def_default();
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    assert_int_equal(pli_body_enable_tethers(rope, &def), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_body_disable_tethers(rope), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_solve(world), PLI_OK);
    assert_int_equal(pli_body_get_features(rope, 0, NULL), 1);
    assert_int_equal(pli_body_disable_tethers(NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_get_tether(rope, 10).origin, PLI_NULL_INDEX);
    assert_int_equal(pli_body_get_tether(NULL, 0).origin, PLI_NULL_INDEX);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_tethers_go_straight_across_faces, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_follow_curved_faces, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_follow_rest_lengths_and_masses, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_follow_cuts, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_hold_a_heavy_node, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_hold_a_rigid_body, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_hold_rigid_bodies_together, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_stretch_with_their_origins, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_hold_a_cape, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_leave_a_carried_cape_calm, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_follow_anchors, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_pull_back_slowly, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_do_not_shoot_a_stretched_rope, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_leave_slack_bodies_alone, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_cost_little, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_survive_failing_memory, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_tethers_refuse_bad_input, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
