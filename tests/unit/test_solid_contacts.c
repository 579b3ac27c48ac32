/* Solids of tetrahedra that are pressed: contacts of nodes hold them in every step, whatever the solver; and what comes
   between two bodies without being pressed. */

#include "solver_choice.h"

#include <math.h>
#include <stddef.h>

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

enum { CELLS = 4, SIDE = CELLS + 1, CUBE_NODES = SIDE * SIDE * SIDE, CUBE_CELLS = CELLS * CELLS * CELLS };

static const float dt = 1.0f / 60, edge = 0.6f, margin = 0.02f;

static int node_of(int x, int y, int z) {
    return (x * SIDE + y) * SIDE + z;
}

/* Five in each cell, mirrored from one cell to the next so that diagonals meet. */
static void add_cell(int x, int y, int z, int* tetras) {
    static const int even[5][4] = {{0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}};
    static const int odd[5][4] = {{1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}, {0, 3, 5, 6}};
    for (int t = 0; t < 5; ++t) {
        for (int k = 0; k < 4; ++k) {
            const int corner = (x + y + z) % 2 == 0 ? even[t][k] : odd[t][k];
            tetras[4 * t + k] = node_of(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1));
        }
    }
}

/* Six in each cell around the same diagonal: what unfinished sweeps leave of the forces has a direction. */
static void add_leaning_cell(int x, int y, int z, int* tetras) {
    static const int around[6] = {1, 3, 2, 6, 4, 5};
    for (int t = 0; t < 6; ++t) {
        const int corners[4] = {0, around[t], around[(t + 1) % 6], 7};
        for (int k = 0; k < 4; ++k) {
            const int corner = corners[k];
            tetras[4 * t + k] = node_of(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1));
        }
    }
}

/* With contacts of nodes. Takes over the mesh. */
static pli_body* make_body(pli_mesh* mesh, solver_choice solver) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = 10;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    use_solver(body, solver);
    CHECK_OK(pli_body_enable_rigid_contacts(body, NULL));
    return body;
}

/* 2 kg, just over the ground at y = 0. */
static pli_body* make_block(pli_vec3 size, solver_choice solver, bool leans) {
    static pli_vec3 points[CUBE_NODES];
    static int tetras[4 * 6 * CUBE_CELLS];
    const int per_cell = leans ? 6 : 5;
    for (int x = 0; x < SIDE; ++x) {
        for (int y = 0; y < SIDE; ++y) {
            for (int z = 0; z < SIDE; ++z) {
                const pli_vec3 cell = pli_vec3_scale(size, 1.0f / CELLS);
                points[node_of(x, y, z)] = pli_vec3_make(cell.x * (float)x - size.x / 2, cell.y * (float)y + 0.05f,
                                                         cell.z * (float)z - size.z / 2);
                if (x == CELLS || y == CELLS || z == CELLS) { continue; }
                int* of_cell = tetras + (ptrdiff_t)4 * per_cell * ((x * CELLS + y) * CELLS + z);
                (leans ? add_leaning_cell : add_cell)(x, y, z, of_cell);
            }
        }
    }
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_from_tetras(context, CUBE_NODES, points, per_cell * CUBE_CELLS, tetras, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 2));
    pli_body* body = make_body(mesh, solver);
    if (solver == XPBD) { CHECK_OK(pli_body_enable_xpbd_tetras(body, 0)); }
    return body;
}

static pli_body* make_cube(solver_choice solver, bool leans) {
    return make_block(pli_vec3_make(edge, edge, edge), solver, leans);
}

static pli_rigid* make_box(pli_rigid_kind kind, pli_vec3 half, float height, float mass) {
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, half, &shape));
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose.origin.y = height;
    if (mass > 0) {
        const float inverse = 3 / (mass * (half.x * half.x + half.y * half.y));
        def.state.inverse_mass = 1 / mass;
        for (int i = 0; i < 3; ++i) {
            def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], inverse);
        }
    }
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

typedef struct cube_motion {
    double highest, fastest, rms; /* m, m/s */
} cube_motion;

static cube_motion motion_of(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    cube_motion motion = {0};
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 v = view.velocities[i];
        const double square = (double)v.x * (double)v.x + (double)v.y * (double)v.y + (double)v.z * (double)v.z;
        motion.highest = fmax(motion.highest, (double)view.positions[i].y);
        motion.fastest = fmax(motion.fastest, sqrt(square));
        motion.rms += square / view.node_count;
    }
    motion.rms = sqrt(motion.rms);
    return motion;
}

/* The press comes down at half a metre per second, to 0.5 m over the ground, and stays. Links alone
   buckle under it. */
static void test_a_press_holds_what_it_presses(void** unused) {
    (void)unused;
    const float gap = 0.5f, start = edge + 0.1f;
    (void)make_box(PLI_RIGID_STATIC, pli_vec3_make(5, 1, 5), -1, 0);
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* body = make_cube((solver_choice)solver, false);
        pli_rigid* press = make_box(PLI_RIGID_KINEMATIC, pli_vec3_make(1, 0.5f, 1), start + 0.5f, 0);
        double fastest = 0, deepest = 0;
        cube_motion motion = {0};
        for (int i = 0; i < 300; ++i) {
            pli_rigid_state state = pli_rigid_get_state(press);
            state.linear_velocity.y = state.pose.origin.y - 0.5f > gap ? -0.5f : 0;
            state.pose.origin.y += state.linear_velocity.y * dt;
            CHECK_OK(pli_rigid_set_state(press, &state));
            CHECK_OK(pli_world_step(world, dt));
            motion = motion_of(body);
            fastest = fmax(fastest, motion.fastest);
            deepest = fmax(deepest, motion.highest - (double)(state.pose.origin.y - 0.5f));
        }
        print_message("solver %d: up to %.2f m/s, %.3f m in the press, %.2g m/s rms at the end\n", solver, fastest,
                      deepest, motion.rms);
        pli_rigid_destroy(press);
        pli_body_destroy(body);
        check_at_most(fastest, solver <= COLORS ? 12.0 : 1.2);
        check_at_most(deepest, 1e-4);
        check_at_most(motion.rms, 1e-3);
    }
}

/* What is pressed would fly into the press where that stops at once: the step would lead it away from there. */
static void test_a_press_that_stops_at_once_holds(void** unused) {
    (void)unused;
    (void)make_box(PLI_RIGID_STATIC, pli_vec3_make(5, 1, 5), -1, 0);
    for (int i = 0; i < 4; ++i) {
        const float gap = i % 2 == 0 ? 0.5f : 0.4f, start = edge + 0.1f, speed = 3;
        pli_body* body = make_cube(XPBD, i < 2);
        pli_rigid* press = make_box(PLI_RIGID_KINEMATIC, pli_vec3_make(1, 0.5f, 1), start + 0.5f, 0);
        double fastest = 0, deepest = 0;
        for (int k = 0; k < 60; ++k) {
            pli_rigid_state state = pli_rigid_get_state(press);
            state.linear_velocity.y = -fminf(speed, (state.pose.origin.y - 0.5f - gap) / dt);
            CHECK_OK(pli_rigid_set_state(press, &state));
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(press, pli_vec3_make(0, 0, 0), dt));
            const cube_motion motion = motion_of(body);
            fastest = fmax(fastest, motion.fastest);
            deepest = fmax(deepest, motion.highest - (double)(pli_rigid_get_state(press).pose.origin.y - 0.5f));
        }
        print_message("to %g m: up to %.2f m/s, %.3f m in the press\n", (double)gap, fastest, deepest);
        pli_rigid_destroy(press);
        pli_body_destroy(body);
        check_at_most(fastest, 4.5);
        check_at_most(deepest, 1e-4);
    }
}

static void test_a_plate_on_a_cube_comes_to_rest(void** unused) {
    (void)unused;
    (void)make_box(PLI_RIGID_STATIC, pli_vec3_make(5, 1, 5), -1, 0);
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* body = make_cube((solver_choice)solver, false);
        pli_rigid* plate = make_box(PLI_RIGID_DYNAMIC, pli_vec3_make(0.3f, 0.05f, 0.3f), edge + 0.15f, 1);
        double rms = 0;
        for (int i = 0; i < 360; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(plate, pli_world_get_gravity(world), dt));
            if (i >= 300) { rms = fmax(rms, motion_of(body).rms); }
        }
        const double height = (double)pli_rigid_get_state(plate).pose.origin.y;
        print_message("solver %d: %.2g m/s rms at most in the last second, plate at %.3f m\n", solver, rms, height);
        pli_rigid_destroy(plate);
        pli_body_destroy(body);
        check_at_most(rms, 2e-3);
        assert_true(height > 0.6 && height < 0.75);
    }
}

/* A press of 100 kg that can only go up and down falls on the cube. */
static void test_a_plate_on_rails_is_not_thrown(void** unused) {
    (void)unused;
    (void)make_box(PLI_RIGID_STATIC, pli_vec3_make(5, 1, 5), -1, 0);
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* body = make_cube((solver_choice)solver, true);
        pli_rigid* plate = make_box(PLI_RIGID_DYNAMIC, pli_vec3_make(0.5f, 0.05f, 0.5f), edge + 0.3f, 100);
        CHECK_OK(pli_rigid_set_factors(plate, pli_vec3_make(0, 1, 0), pli_vec3_make(0, 0, 0)));
        double fastest = 0, highest = 0;
        for (int i = 0; i < 240; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(plate, pli_world_get_gravity(world), dt));
            const pli_rigid_state state = pli_rigid_get_state(plate);
            fastest = fmax(fastest, fabs((double)state.linear_velocity.y));
            highest = fmax(highest, (double)state.pose.origin.y);
        }
        print_message("solver %d: plate up to %.2f m/s and %.3f m\n", solver, fastest, highest);
        pli_rigid_destroy(plate);
        pli_body_destroy(body);
        check_at_most(fastest, 4);
        check_at_most(highest, (double)edge + 0.3);
    }
}

/* As docs/manual/solids.md says of cushions: 30 kg that fall half a metre on to 2 kg, level or leaning. */
static void test_a_heavy_box_stays_on_a_cushion(void** unused) {
    (void)unused;
    const pli_vec3 size = pli_vec3_make(0.5f, 0.12f, 0.5f);
    const float half = 0.15f, lean = 0.2f;
    (void)make_box(PLI_RIGID_STATIC, pli_vec3_make(5, 1, 5), -1, 0);
    for (int c = 0; c < 8; ++c) {
        const bool is_tilted = c % 2 == 1, has_faces = c / 2 % 2 == 1;
        const solver_choice solver = c < 4 ? SWEEPS : GRADIENTS;
        pli_body* cushion = make_block(size, solver, false);
        pli_implicit_def def = pli_implicit_def_default();
        def.stiffness = 2e4f;
        def.filter_compression = true;
        if (solver == GRADIENTS) {
            def.method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
            def.sweeps = 100;
        }
        CHECK_OK(pli_body_enable_implicit(cushion, &def));
        if (has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(cushion, NULL)); }
        pli_rigid* box = make_box(PLI_RIGID_DYNAMIC, pli_vec3_make(half, half, half), 0.67f + 1.2f * half, 30);
        pli_rigid_state state = pli_rigid_get_state(box);
        state.pose.origin.x = 0.01f;
        state.pose.origin.z = 0.02f;
        if (is_tilted) {
            state.pose.rotation.rows[0] = pli_vec3_make(cosf(lean), -sinf(lean), 0);
            state.pose.rotation.rows[1] = pli_vec3_make(sinf(lean), cosf(lean), 0);
        }
        CHECK_OK(pli_rigid_set_state(box, &state));
        for (int i = 0; i < 300; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(box, pli_world_get_gravity(world), dt));
        }
        state = pli_rigid_get_state(box);
        const pli_vec3 at = state.pose.origin;
        print_message("solver %d, tilted %d, faces %d: box at (%.3f, %.3f, %.3f), %.2g m/s\n", solver, is_tilted,
                      has_faces, (double)at.x, (double)(at.y - half), (double)at.z,
                      (double)pli_vec3_length(state.linear_velocity));
        check_near(at.y - half, size.y + 2 * margin, 0.02);
        check_at_most(hypotf(at.x, at.z), 0.2);
        check_at_most(pli_vec3_length(state.linear_velocity), 0.01);
        pli_rigid_destroy(box);
        pli_body_destroy(cushion);
    }
}

/* One that lies is not moved along the ground by forces of its own. */
static void test_a_leaning_cube_stays(void** unused) {
    (void)unused;
    (void)make_box(PLI_RIGID_STATIC, pli_vec3_make(5, 1, 5), -1, 0);
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* body = make_cube((solver_choice)solver, true);
        const pli_body_view view = pli_body_get_view(body);
        double x[2] = {0}, z[2] = {0};
        for (int i = 0; i < 480; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            for (int n = 0; n < view.node_count && (i == 179 || i == 479); ++n) {
                x[i == 479] += (double)view.positions[n].x / view.node_count;
                z[i == 479] += (double)view.positions[n].z / view.node_count;
            }
        }
        const double way = hypot(x[1] - x[0], z[1] - z[0]);
        print_message("solver %d: %.2g m in five seconds\n", solver, way);
        pli_body_destroy(body);
        check_at_most(way, 1e-5);
    }
}

/* A gram at the lower front edge of a box that comes along the ground is pushed along, and takes no speed. */
static void test_a_node_in_a_wedge_stops_no_box(void** state) {
    (void)state;
    static const float heights[] = {0.01f, 0.02f, 0.025f, 0.03f, 0.039f};
    for (int i = 0; i < 2 * 5; ++i) {
        pli_mesh* mesh = NULL;
        CHECK_OK(pli_mesh_create(context, &mesh));
        CHECK_OK(pli_mesh_append_node(mesh, pli_vec3_make(0, margin + 1e-4f, 0), 1e-3f, NULL));
        pli_body* body = make_body(mesh, i < 5 ? POSITION : XPBD);
        pli_rigid* ground = make_box(PLI_RIGID_STATIC, pli_vec3_make(50, 0.5f, 50), -0.5f, 0);
        pli_rigid* box = make_box(PLI_RIGID_DYNAMIC, pli_vec3_make(0.9f, 0.3f, 1.5f), heights[i % 5] + 0.3f, 1000);
        CHECK_OK(pli_rigid_set_factors(box, pli_vec3_make(0, 0, 1), pli_vec3_make(0, 0, 0)));
        pli_rigid_state moving = pli_rigid_get_state(box);
        moving.pose.origin.z = -2.1f;
        moving.linear_velocity.z = 10;
        CHECK_OK(pli_rigid_set_state(box, &moving));
        for (int k = 0; k < 60; ++k) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(box, pli_vec3_make(0, 0, 0), dt));
        }
        check_near(pli_rigid_get_state(box).linear_velocity.z, 10, 0.01);
        pli_rigid_destroy(box);
        pli_rigid_destroy(ground);
        pli_body_destroy(body);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_press_holds_what_it_presses, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_press_that_stops_at_once_holds, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_plate_on_a_cube_comes_to_rest, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_plate_on_rails_is_not_thrown, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_heavy_box_stays_on_a_cushion, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_leaning_cube_stays, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_node_in_a_wedge_stops_no_box, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
