/* A crate on cloth that is on the move: on a rug that is pulled over the floor, on a tarpaulin that is carried by its
   rim, on a rug on a platform. It goes along, and stays on it. And cloth on a body that moves. */

#include "level_sheet.h"
#include "solver_choice.h"

#include <math.h>

enum { SIDE = 15 };

/* Unoptimised programs run the harder half of the cases. */
#ifdef NDEBUG
static const bool is_fast = true;
#else
static const bool is_fast = false;
#endif

static const float dt = 1.0f / 60.0f, margin = 0.03f, half_crate = 0.15f;

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

/* Level, at the height of the margin, with its lower side at 0; 0.5 kg. */
static pli_body* make_cloth(solver_choice solver, bool has_faces, float size) {
    const float h = 0.5f * size;
    pli_patch_def patch = level_sheet(h, margin, SIDE);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 0.5f));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = 4;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
    pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
    nodes.friction = faces.friction = 1;
    CHECK_OK(pli_body_enable_rigid_contacts(body, &nodes));
    if (has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(body, &faces)); }
    use_solver(body, solver);
    return body;
}

/* Friction 1 with the cloth. Mass 0: kinematic. */
static pli_rigid* make_box(pli_vec3 half, float height, float mass) {
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, half, &shape));
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = mass > 0 ? PLI_RIGID_DYNAMIC : PLI_RIGID_KINEMATIC;
    def.shapes = &shape;
    def.shape_count = 1;
    def.friction = 1;
    def.state.pose.origin.y = height;
    if (mass > 0) {
        const float inverse = 1.5f / (mass * half.x * half.x);
        def.state.inverse_mass = 1 / mass;
        def.state.inverse_inertia_world =
            (pli_mat3){{pli_vec3_make(inverse, 0, 0), pli_vec3_make(0, inverse, 0), pli_vec3_make(0, 0, inverse)}};
    }
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

/* It lies on the cloth, as high as both margins. */
static pli_rigid* make_crate(float mass) {
    return make_box(pli_vec3_make(half_crate, half_crate, half_crate), 2 * margin + half_crate, mass);
}

/* To where it is at the end of the next step. */
static void move_platform(pli_rigid* rigid, pli_vec3 to) {
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.pose.origin = pli_vec3_add(state.pose.origin, pli_vec3_scale(state.linear_velocity, dt));
    state.linear_velocity = pli_vec3_scale(pli_vec3_sub(to, state.pose.origin), 1 / dt);
    CHECK_OK(pli_rigid_set_state(rigid, &state));
}

static void step_with(pli_rigid* crate) {
    CHECK_OK(pli_world_step(world, dt));
    CHECK_OK(pli_rigid_integrate(crate, pli_world_def_default().gravity, dt));
}

/* Pinned nodes go with `offset` from where they were: those of the last column, or of the whole rim. */
static bool is_led(bool rim, int node) {
    const int column = node % SIDE, row = node / SIDE;
    return column == SIDE - 1 || (rim && (column == 0 || row == 0 || row == SIDE - 1));
}

static void lead(pli_body* body, bool rim, pli_vec3 offset) {
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (!is_led(rim, i)) { continue; }
        const float x = (float)(i % SIDE) / (SIDE - 1) - 0.5f, z = (float)(i / SIDE) / (SIDE - 1) - 0.5f;
        CHECK_OK(pli_body_move_node(body, i, pli_vec3_add(pli_vec3_make(x, margin, z), offset)));
    }
}

static void pin(pli_body* body, bool rim) {
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (is_led(rim, i)) { CHECK_OK(pli_body_set_node_mass(body, i, 0)); }
    }
}

static float stands_upright(const pli_rigid* crate) {
    return pli_rigid_get_state(crate).pose.rotation.rows[1].y;
}

/* By one side, at half a metre per second over a metre. */
static void a_rug_that_is_pulled_takes_a_crate_along(void** unused) {
    (void)unused;
    pli_rigid* floor = make_box(pli_vec3_make(5, 0.5f, 5), -0.5f, 0);
    for (int c = is_fast ? 0 : 1; c < 2 * SOLVER_COUNT; c += is_fast ? 1 : 2) {
        const bool has_faces = c % 2 == 1;
        const float mass = has_faces ? 10 : 1;
        pli_body* rug = make_cloth((solver_choice)(c / 2), has_faces, 1);
        pli_rigid* crate = make_crate(mass);
        pin(rug, false);
        for (int i = 0; i < 240; ++i) {
            const float pulled = fminf(fmaxf(0.5f * dt * (float)(i - 59), 0), 1);
            lead(rug, false, pli_vec3_make(pulled, 0, 0));
            step_with(crate);
        }
        const pli_rigid_state state = pli_rigid_get_state(crate);
        print_message("solver %d, faces %d, %.0f kg: taken along by %.3f m, at last %.4f m/s, height %.3f m\n", c / 2,
                      has_faces, (double)mass, (double)state.pose.origin.x,
                      (double)pli_vec3_length(state.linear_velocity), (double)(state.pose.origin.y - half_crate));
        check_near(state.pose.origin.x, 1, 0.04);
        check_near(state.pose.origin.y, half_crate + 2 * margin, 0.002);
        check_at_most(pli_vec3_length(state.linear_velocity), 0.01);
        check_near(stands_upright(crate), 1, 1e-3);
        pli_rigid_destroy(crate);
        pli_body_destroy(rug);
    }
    pli_rigid_destroy(floor);
}

/* With tethers, 5 kg, from rest to 2 m/s in a second, over 6 m, and to rest again. */
static void a_tarpaulin_that_is_carried_keeps_a_crate(void** unused) {
    (void)unused;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* tarpaulin = make_cloth((solver_choice)solver, true, 1);
        pli_rigid* crate = make_crate(5);
        pin(tarpaulin, true);
        CHECK_OK(pli_body_enable_tethers(tarpaulin, NULL));
        float speed = 0, way = 0, most = 0;
        for (int i = 0; i < 360; ++i) {
            speed += i >= 60 && i < 120 ? 2 * dt : i >= 240 && i < 300 ? -2 * dt : 0;
            way += speed * dt;
            lead(tarpaulin, true, pli_vec3_make(way, 0, 0));
            step_with(crate);
            most = fmaxf(most, fabsf(pli_rigid_get_state(crate).pose.origin.x - way));
        }
        const pli_rigid_state state = pli_rigid_get_state(crate);
        print_message("solver %d: off by at most %.4f m of %.2f m, height %.3f m\n", solver, (double)most, (double)way,
                      (double)(state.pose.origin.y - half_crate));
        check_at_most(most, 0.015);
        assert_true(state.pose.origin.y - half_crate > -0.04f);
        pli_rigid_destroy(crate);
        pli_body_destroy(tarpaulin);
    }
}

/* 5 kg. The platform goes up and down by 0.3 m, and as the tarpaulin, or neither. `speed`: m/s, of all from the start.
 */
typedef struct ride {
    bool moves, lifts;
    float speed;
} ride;

static void ride_on_platform(ride r, int steps, solver_choice solver, bool has_faces) {
    pli_rigid* platform = make_box(pli_vec3_make(1, 0.5f, 1), -0.5f, 0);
    pli_body* rug = make_cloth(solver, has_faces, 1);
    pli_rigid* crate = make_crate(5);
    pli_rigid_state state = pli_rigid_get_state(crate);
    state.linear_velocity.x = r.speed;
    CHECK_OK(pli_rigid_set_state(crate, &state));
    state = pli_rigid_get_state(platform);
    state.pose.origin.x = -r.speed * dt;
    state.linear_velocity.x = r.speed;
    CHECK_OK(pli_rigid_set_state(platform, &state));
    CHECK_OK(pli_body_add_velocity(rug, pli_vec3_make(r.speed, 0, 0)));
    float speed = r.speed, way = 0, most = 0, height = 0;
    for (int i = 0; i < steps; ++i) {
        if (r.moves) { speed += i >= 60 && i < 120 ? 2 * dt : i >= 240 && i < 300 ? -2 * dt : 0; }
        way += speed * dt;
        height = r.lifts ? 0.3f * (1 - cosf(3.0f * dt * (float)(i + 1))) : 0;
        move_platform(platform, pli_vec3_make(way, height - 0.5f, 0));
        step_with(crate);
        most = fmaxf(most, fabsf(pli_rigid_get_state(crate).pose.origin.x - way));
    }
    const float above = pli_rigid_get_state(crate).pose.origin.y - half_crate - height;
    print_message("solver %d, faces %d, moves %d, lifts %d, %g m/s: off by at most %.4f m of %.2f m, %.3f m above\n",
                  solver, has_faces, r.moves, r.lifts, (double)r.speed, (double)most, (double)way, (double)above);
    check_at_most(most, r.moves ? 0.04 : 0.001);
    check_near(above, 2 * margin, 0.002);
    check_near(stands_upright(crate), 1, 1e-3);
    pli_rigid_destroy(crate);
    pli_body_destroy(rug);
    pli_rigid_destroy(platform);
}

static void a_rug_on_a_platform_keeps_a_crate(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        const bool has_faces = c % 2 == 1;
        if (is_fast) { ride_on_platform((ride){.moves = true}, 360, (solver_choice)(c / 2), has_faces); }
        if (is_fast || has_faces) {
            ride_on_platform((ride){.moves = true, .lifts = true}, 360, (solver_choice)(c / 2), has_faces);
        }
    }
}

/* As it lies on one that stands still. */
static void a_crate_on_a_rug_rides_at_any_speed(void** unused) {
    (void)unused;
    static const float speeds[] = {5, 50, 1, 20};
    for (int c = 0; c < (is_fast ? 4 : 1) * SOLVER_COUNT; ++c) {
        ride_on_platform((ride){.speed = speeds[c / SOLVER_COUNT]}, 120, (solver_choice)(c % SOLVER_COUNT),
                         c / SOLVER_COUNT % 2 == 0);
    }
}

/* Where a cloth comes to lie on a body, against its centre, after three seconds at `speed`. */
static pli_vec3 drape_over(bool is_dynamic, float speed, solver_choice solver) {
    pli_shape* shape = NULL;
    if (is_dynamic) {
        CHECK_OK(pli_shape_create_sphere(context, 0.3f, &shape));
    } else {
        CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.25f, 0.3f, 0.25f), &shape));
    }
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = is_dynamic ? PLI_RIGID_DYNAMIC : PLI_RIGID_KINEMATIC;
    def.shapes = &shape;
    def.shape_count = 1;
    def.friction = 1;
    def.state.pose.origin.y = -0.3f;
    def.state.linear_velocity.x = speed;
    if (is_dynamic) { def.state.inverse_mass = 1e-3f; } /* nor does it turn */
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    pli_body* cloth = make_cloth(solver, !is_dynamic, 1);
    CHECK_OK(pli_body_add_velocity(cloth, pli_vec3_make(speed, 0, 0)));
    for (int i = 0; i < 180; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        if (is_dynamic) {
            CHECK_OK(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), dt));
        } else {
            pli_rigid_state state = pli_rigid_get_state(rigid);
            state.pose.origin.x = speed * dt * (float)(i + 1);
            CHECK_OK(pli_rigid_set_state(rigid, &state));
        }
    }
    const pli_vec3 place = pli_vec3_sub(middle_of(cloth), pli_rigid_get_state(rigid).pose.origin);
    pli_body_destroy(cloth);
    pli_rigid_destroy(rigid);
    return place;
}

static void cloth_lies_over_a_body_at_any_speed(void** unused) {
    (void)unused;
    for (int c = 0; c < (is_fast ? 2 : 1) * SOLVER_COUNT; ++c) {
        const bool is_dynamic = c / SOLVER_COUNT == 0;
        const solver_choice solver = (solver_choice)(c % SOLVER_COUNT);
        const pli_vec3 still = drape_over(is_dynamic, 0, solver), fast = drape_over(is_dynamic, 20, solver);
        print_message("solver %d, dynamic %d: at (%.3f, %.3f) still, at (%.3f, %.3f) at 20 m/s\n", solver, is_dynamic,
                      (double)still.x, (double)still.y, (double)fast.x, (double)fast.y);
        assert_true(still.y > 0);
        check_near(fast.x, still.x, 0.02);
        check_near(fast.y, still.y, 0.01);
    }
}

/* How far a cloth that comes down at 3.2 m/s against a plate of 10 cm, from `height`, is above its margin in the end.
 */
static float falls_onto_plate(float speed, float height, solver_choice solver) {
    pli_rigid* plate = make_box(pli_vec3_make(2, 0.05f, 2), -0.05f, 0);
    pli_rigid_state state = pli_rigid_get_state(plate);
    state.linear_velocity.y = speed;
    CHECK_OK(pli_rigid_set_state(plate, &state));
    pli_body* cloth = make_cloth(solver, false, 1);
    CHECK_OK(pli_body_transform(cloth, pli_transform_make(pli_quat_identity(), pli_vec3_make(0, height, 0))));
    CHECK_OK(pli_body_add_velocity(cloth, pli_vec3_make(0, speed - 3.2f, 0)));
    for (int i = 0; i < 90; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(plate, pli_vec3_make(0, 0, 0), dt));
    }
    const float above = middle_of(cloth).y - pli_rigid_get_state(plate).pose.origin.y - 0.05f - margin;
    pli_body_destroy(cloth);
    pli_rigid_destroy(plate);
    return above;
}

/* Nodes are faster than the plate that they come after, and in a step deeper than half of it where that was before. */
static void cloth_falls_onto_a_plate_that_sinks(void** unused) {
    (void)unused;
    float most = 0;
    for (int c = 0; c < 6 * SOLVER_COUNT; ++c) {
        const float height = 0.3f + 0.02f * (float)(c / SOLVER_COUNT);
        for (int k = 0; k <= 4; k += 2) {
            most = fmaxf(most, fabsf(falls_onto_plate((float)-k, height, (solver_choice)(c % SOLVER_COUNT))));
        }
    }
    print_message("at most %.2g m off\n", (double)most);
    check_at_most(most, 1e-4);
}

/* Contacts of nodes in a second, with a box in whose margin a cloth flies along; nothing falls. */
static int contacts_in_flight(pli_vec3 velocity, solver_choice solver, float mass) {
    const pli_vec3 half = pli_vec3_make(0.25f, 0.2f, 0.25f);
    pli_rigid* box = make_box(half, 0.001f - half.y, mass);
    pli_rigid_state state = pli_rigid_get_state(box);
    state.linear_velocity = velocity;
    CHECK_OK(pli_rigid_set_state(box, &state));
    pli_body* cloth = make_cloth(solver, false, 1);
    CHECK_OK(pli_body_add_velocity(cloth, velocity));
    int count = 0;
    for (int i = 0; i < 60; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(box, pli_vec3_make(0, 0, 0), dt));
        count += pli_body_get_rigid_contacts(cloth, 0, NULL);
    }
    pli_body_destroy(cloth);
    pli_rigid_destroy(box);
    return count;
}

/* By the speed of the box, which nodes that go along do not have against it, they were up to 2.3 times as many. */
static void cloth_in_flight_has_the_contacts_that_it_has_at_rest(void** unused) {
    (void)unused;
    static const pli_vec3 velocities[] = {{5, 0, 0}, {0, -50, 0}, {-123, 201, -170}};
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        const solver_choice solver = (solver_choice)(c % SOLVER_COUNT);
        const float mass = c < SOLVER_COUNT ? 0 : 2;
        const int still = contacts_in_flight(pli_vec3_make(0, 0, 0), solver, mass);
        assert_true(still > 0);
        for (int v = 0; v < 3; ++v) {
            const int flying = contacts_in_flight(velocities[v], solver, mass);
            print_message("solver %d, %g kg: %d contacts, at rest %d\n", solver, (double)mass, flying, still);
            check_near((double)flying / still, 1, 0.05);
        }
    }
}

/* How far cloth and box are apart a second after the cloth lay a centimetre inside its margin; nothing falls. */
static float parts_to(solver_choice solver, bool has_faces, float mass) {
    const pli_vec3 half = pli_vec3_make(0.25f, 0.2f, 0.25f);
    pli_rigid* box = make_box(half, 0.01f - half.y, mass);
    pli_body* cloth = make_cloth(solver, has_faces, 1);
    for (int i = 0; i < 60; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(box, pli_vec3_make(0, 0, 0), dt));
    }
    const float apart = pli_body_get_view(cloth).positions[SIDE * SIDE / 2].y - pli_rigid_get_state(box).pose.origin.y;
    pli_body_destroy(cloth);
    pli_rigid_destroy(box);
    return apart - half.y;
}

/* Implicit cloth leaves a box that yields with some 0.2 m/s (docs/solvers.md). */
static void cloth_that_starts_in_a_box_parts_without_speed(void** unused) {
    (void)unused;
    for (int c = 0; c < 4 * SOLVER_COUNT; ++c) {
        const solver_choice solver = (solver_choice)(c % SOLVER_COUNT);
        const bool has_faces = c / SOLVER_COUNT % 2 == 1;
        const bool is_implicit = solver == SWEEPS || solver == GRADIENTS;
        const float mass = c / SOLVER_COUNT >= 2 ? 2 : 0, apart = parts_to(solver, has_faces, mass);
        const float most = is_implicit && mass > 0 ? 0.26f : has_faces ? 0.03f : 0.012f;
        print_message("solver %d, faces %d, %g kg: %.4f m apart\n", solver, has_faces, (double)mass, (double)apart);
        check_at_most(margin, apart + 1e-4f);
        check_at_most(apart, margin + most);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_rug_that_is_pulled_takes_a_crate_along, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_tarpaulin_that_is_carried_keeps_a_crate, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_rug_on_a_platform_keeps_a_crate, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_crate_on_a_rug_rides_at_any_speed, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(cloth_lies_over_a_body_at_any_speed, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(cloth_that_starts_in_a_box_parts_without_speed, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(cloth_in_flight_has_the_contacts_that_it_has_at_rest, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(cloth_falls_onto_a_plate_that_sinks, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
