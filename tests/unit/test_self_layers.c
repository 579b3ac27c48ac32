/* Two layers of one body, with self-collision of nodes and of faces, under each solver: what starts too near parts
   without speed, and in flight they are against each other as at rest. */

#include "solver_choice.h"
#include "test_world.h"

#include <pliant/generate.h>
#include <pliant/self_collision.h>

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

enum { SIDE = 12, LAYER = SIDE * SIDE, LAYER_TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1) };
static const float dt = 1.0f / 60.0f, thickness = 0.04f;

/* Loose, level, 2 m wide, 2 kg, one above the other at `height`. */
static pli_body* make_layers(float height) {
    static pli_vec3 points[2 * LAYER];
    static int triangles[2 * LAYER_TRIANGLES][3];
    int count = 0;
    for (int i = 0; i < 2 * LAYER; ++i) {
        const int column = i % SIDE, row = i / SIDE % SIDE;
        points[i] =
            pli_vec3_make((float)column * 2 / (SIDE - 1) - 1, i < LAYER ? 0 : height, (float)row * 2 / (SIDE - 1) - 1);
        if (column == SIDE - 1 || row == SIDE - 1) { continue; }
        const int halves[2][3] = {{i, i + 1, i + SIDE}, {i + 1, i + SIDE + 1, i + SIDE}};
        memcpy(triangles[count], halves, sizeof halves);
        count += 2;
    }
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_from_triangles(context, 2 * LAYER, points, count, triangles[0], false, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 2));
    pli_body_def def = pli_body_def_default();
    def.solver.velocity_damping = 0;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    return body;
}

/* A second of both layers with a common velocity, the upper one `approach` slower: where it is against the lower. */
static void fly(solver_choice solver, bool has_faces, float height, float approach, pli_vec3 velocity,
                pli_vec3 apart[LAYER]) {
    pli_body* body = make_layers(fmaxf(height, thickness));
    use_solver(body, solver);
    pli_self_collision_def nodes = pli_self_collision_def_default();
    pli_self_faces_def faces = pli_self_faces_def_default();
    nodes.thickness = faces.thickness = thickness;
    if (has_faces) {
        CHECK_OK(pli_body_enable_self_faces(body, &faces));
    } else {
        CHECK_OK(pli_body_enable_self_collision(body, &nodes));
    }
    pli_vec3 places[2 * LAYER], velocities[2 * LAYER];
    for (int i = 0; i < 2 * LAYER; ++i) {
        const pli_vec4 p = pli_body_get_view(body).positions[i];
        places[i] = pli_vec3_make(p.x, i < LAYER ? 0 : height, p.z);
        velocities[i] = velocity;
        if (i >= LAYER) { velocities[i].y -= approach; }
    }
    CHECK_OK(pli_body_set_state(body, places, velocities));
    for (int i = 0; i < 60; ++i) {
        CHECK_OK(pli_world_step(world, dt));
    }
    const pli_vec4* p = pli_body_get_view(body).positions;
    for (int i = 0; i < LAYER; ++i) {
        const pli_vec4 a = p[i], b = p[LAYER + i];
        apart[i] = pli_vec3_make(b.x - a.x, b.y - a.y, b.z - a.z);
    }
    pli_body_destroy(body);
}

/* Layers that start 2 mm too near flew apart with up to 1.2 m/s. */
static void test_overlaps_leave_no_speed(void** unused) {
    (void)unused;
    static pli_vec3 apart[LAYER];
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        fly((solver_choice)(c / 2), c % 2 == 1, thickness - 0.002f, 0, pli_vec3_make(0, 0, 0), apart);
        for (int i = 0; i < LAYER; ++i) {
            check_near(apart[i].y, thickness, 1e-4);
        }
    }
}

static void test_layers_are_in_flight_as_at_rest(void** unused) {
    (void)unused;
    static const pli_vec3 velocities[] = {{0, 5, 0}, {100, 0, 0}, {0, 300, 0}, {-123, 201, -170}};
    static const struct { float height, approach; } starts[] = {{0.038f, 0}, {0.3f, 1}};
    static pli_vec3 at_rest[LAYER], flying[LAYER];
    float most = 0;
    for (int c = 0; c < 4 * SOLVER_COUNT; ++c) {
        const solver_choice solver = (solver_choice)(c / 4);
        const bool has_faces = c % 4 >= 2;
        const float height = starts[c % 2].height, approach = starts[c % 2].approach;
        fly(solver, has_faces, height, approach, pli_vec3_make(0, 0, 0), at_rest);
        for (int v = 0; v < 4; ++v) {
            fly(solver, has_faces, height, approach, velocities[v], flying);
            for (int i = 0; i < LAYER; ++i) {
                most = fmaxf(most, pli_vec3_length(pli_vec3_sub(flying[i], at_rest[i])));
            }
        }
    }
    print_message("at most %.2g m off\n", (double)most);
    check_at_most(most, 1e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_overlaps_leave_no_speed, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_layers_are_in_flight_as_at_rest, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
