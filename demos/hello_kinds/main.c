// The four kinds of the guide: a rope, a cape, a balloon and a solid, each in a world of its own with a floor.
#include <math.h>
#include <pliant/pliant.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static pli_context* context;
static double step_us; // processor time of the last run, mean

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s\n", pli_last_error(context));
    exit(1);
}

static pli_world* make_world(void) {
    pli_world* world;
    pli_shape* plane;
    pli_rigid* floor;
    check(pli_world_create(context, NULL, &world));
    check(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &plane));
    pli_rigid_def def = pli_rigid_def_default(); // static
    def.shapes = &plane;
    def.shape_count = 1;
    check(pli_rigid_create(world, &def, &floor));
    pli_shape_release(plane); // the floor holds a reference
    return world;
}

// Of all threads together.
static double now_us(void) {
    return 1e6 * (double)clock() / CLOCKS_PER_SEC;
}

static void run(pli_world* world, float seconds) {
    const int steps = (int)(seconds * 60);
    const double begin = now_us();
    for (int i = 0; i < steps; ++i) {
        check(pli_world_step(world, 1.0f / 60.0f));
    }
    step_us = (now_us() - begin) / steps;
}

// A rope of 2 m that hangs from its first node, with a weight of 5 kg at the other end.
static pli_body* make_rope(pli_world* world) {
    pli_mesh* mesh;
    pli_body* rope;
    check(pli_mesh_create_rope(context, pli_vec3_make(0, 3, 0), pli_vec3_make(2, 3, 0), 30, PLI_ROPE_PIN_FIRST, &mesh));
    check(pli_mesh_set_total_mass(mesh, 0.2f));
    check(pli_mesh_set_node_mass(mesh, 31, 5));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;        // the radius of the rope
    def.solver.velocity_damping = 0.01f; // of air, per step
    check(pli_body_create(world, mesh, &def, &rope));
    pli_mesh_destroy(mesh);
    check(pli_body_enable_xpbd(rope, NULL)); // 10 substeps
    check(pli_body_enable_xpbd_links(rope, NULL));
    check(pli_body_enable_tethers(rope, NULL));
    check(pli_body_enable_rigid_contacts(rope, NULL));
    return rope;
}

// A cape of 1 m by 1.2 m, whose upper edge is led by the game.
enum { CAPE_COLUMNS = 26, CAPE_ROWS = 31 };

static pli_body* make_cape(pli_world* world) {
    pli_mesh* mesh;
    pli_body* cape;
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-0.5f, 2, 0);
    patch.corner_10 = pli_vec3_make(0.5f, 2, 0);
    patch.corner_01 = pli_vec3_make(-0.5f, 0.8f, 0);
    patch.corner_11 = pli_vec3_make(0.5f, 0.8f, 0);
    patch.columns = CAPE_COLUMNS;
    patch.rows = CAPE_ROWS;
    check(pli_mesh_create_patch(context, &patch, &mesh));
    check(pli_mesh_set_total_mass(mesh, 0.6f));
    for (int x = 0; x < CAPE_COLUMNS; ++x) {
        check(pli_mesh_set_node_mass(mesh, x, 0)); // pinned: led, not pulled
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    check(pli_body_create(world, mesh, &def, &cape));
    pli_mesh_destroy(mesh);

    check(pli_body_enable_xpbd(cape, NULL));
    check(pli_body_enable_xpbd_links(cape, NULL)); // does not stretch
    pli_xpbd_bending_def bending = pli_xpbd_bending_def_default();
    bending.compliance = 10; // rad/(N m): folds easily
    check(pli_body_enable_xpbd_bending(cape, &bending));
    check(pli_body_enable_tethers(cape, NULL));
    check(pli_body_enable_rigid_contacts(cape, NULL));
    pli_self_collision_def self = pli_self_collision_def_default();
    self.thickness = 0.03f; // below the 4 cm between linked nodes
    check(pli_body_enable_self_collision(cape, &self));
    return cape;
}

static void lead_cape(pli_body* cape, float z) {
    for (int x = 0; x < CAPE_COLUMNS; ++x) {
        const float place = -0.5f + (float)x / (CAPE_COLUMNS - 1);
        check(pli_body_move_node(cape, x, pli_vec3_make(place, 2, z)));
    }
}

// A balloon of 0.3 m radius under pressure, dropped from 1 m.
static pli_body* make_balloon(pli_world* world) {
    pli_mesh* mesh;
    pli_body* balloon;
    check(pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 1, 0), pli_vec3_make(0.3f, 0.3f, 0.3f), 400, &mesh));
    check(pli_mesh_set_total_mass(mesh, 0.3f));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    def.solver.position_iterations = 10;
    def.solver.velocity_damping = 0.005f;
    check(pli_body_create(world, mesh, &def, &balloon));
    pli_mesh_destroy(mesh);
    check(pli_body_enable_colored_links(balloon));
    check(pli_body_enable_pressure(balloon, 1.5f)); // N m: the pressure times the volume
    check(pli_body_enable_rigid_contacts(balloon, NULL));
    return balloon;
}

// A cube of 0.5 m: cells of six tetrahedra around one diagonal.
enum { CELLS = 4, POINTS = CELLS + 1 };

static int point(int x, int y, int z) {
    return (z * POINTS + y) * POINTS + x;
}

static pli_mesh* make_cube(void) {
    static const int corners[6][4][3] = {
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 1, 1}},
        {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {1, 1, 1}}, {{0, 0, 0}, {0, 1, 1}, {0, 0, 1}, {1, 1, 1}},
        {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}}, {{0, 0, 0}, {1, 0, 1}, {1, 0, 0}, {1, 1, 1}}};
    static pli_vec3 points[POINTS * POINTS * POINTS];
    static int tetras[CELLS * CELLS * CELLS * 6 * 4];
    int count = 0;
    for (int z = 0; z < POINTS; ++z) {
        for (int y = 0; y < POINTS; ++y) {
            for (int x = 0; x < POINTS; ++x) {
                points[point(x, y, z)] = pli_vec3_make(0.125f * (float)x, 1 + 0.125f * (float)y, 0.125f * (float)z);
                for (int t = 0; t < 6 && x < CELLS && y < CELLS && z < CELLS; ++t) {
                    for (int c = 0; c < 4; ++c) {
                        const int* o = corners[t][c];
                        tetras[count++] = point(x + o[0], y + o[1], z + o[2]);
                    }
                }
            }
        }
    }
    pli_mesh* mesh;
    check(pli_mesh_create_from_tetras(context, POINTS * POINTS * POINTS, points, count / 4, tetras, &mesh));
    check(pli_mesh_set_total_mass(mesh, 10));
    return mesh;
}

static pli_body* make_solid(pli_world* world) {
    pli_mesh* mesh = make_cube();
    pli_body* solid;
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.01f;
    check(pli_body_create(world, mesh, &def, &solid));
    pli_mesh_destroy(mesh);
    check(pli_body_enable_xpbd(solid, NULL));
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = 1e-4f; // m/N: edges give way
    links.damping = 5;        // N s/m
    check(pli_body_enable_xpbd_links(solid, &links));
    check(pli_body_enable_xpbd_tetras(solid, 0)); // volumes do not
    check(pli_body_enable_rigid_contacts(solid, NULL));
    return solid;
}

// The same cube out of clusters, which keep their shapes and meet as convex hulls.
static pli_body* make_clustered(pli_world* world) {
    pli_mesh* mesh = make_cube();
    pli_body* solid;
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.01f;
    def.solver.position_iterations = 4;
    check(pli_body_create(world, mesh, &def, &solid));
    pli_mesh_destroy(mesh);
    int made;
    check(pli_body_enable_colored_links(solid));
    check(pli_body_generate_clusters(solid, 8, 100, &made));
    for (int i = 0; i < made; ++i) {
        pli_cluster_settings settings;
        check(pli_body_get_cluster_settings(solid, i, &settings));
        settings.matching = 0.1f; // share of the way back to its shape, per step
        check(pli_body_set_cluster_settings(solid, i, &settings));
    }
    check(pli_body_enable_cluster_contacts(solid, NULL));
    return solid;
}

// What a body looks like from outside: is it where it should be, as long as it should be, and calm?
static void print_body(const char* name, const pli_body* body) {
    const pli_bounds bounds = pli_body_get_bounds(body);
    const float speed = sqrtf(2 * pli_body_kinetic_energy(body) / pli_body_total_mass(body));
    printf("%-9s from y = %4.2f to %4.2f m, stretch %4.1f %%, speed %4.2f m/s\n", name, (double)bounds.min.y,
           (double)bounds.max.y, 100.0 * (double)pli_body_max_stretch(body), (double)speed);
}

static void print_cost(const pli_body* body) {
    printf("          %d nodes, %.0f us a step\n", pli_body_get_view(body).node_count, step_us);
}

int main(int argument_count, char** arguments) {
    const int thread_count = argument_count > 1 ? atoi(arguments[1]) : 2;
    // Without this everything is on one thread, with the same results.
    pli_threads* threads;
    check(pli_threads_create(thread_count, &threads));
    pli_context_def def = pli_context_def_default();
    def.parallel_for = pli_threads_parallel_for;
    def.parallel_user = threads;
    check(pli_context_create(&def, &context));

    pli_world* world = make_world();
    const pli_body* rope = make_rope(world);
    run(world, 10);
    print_body("rope", rope);
    print_cost(rope);
    pli_world_destroy(world);

    world = make_world();
    pli_body* cape = make_cape(world);
    const double begin = now_us();
    for (int step = 0; step < 180; ++step) {
        lead_cape(cape, fminf((float)step, 120) / 60); // 1 m/s for two seconds
        check(pli_world_step(world, 1.0f / 60.0f));
    }
    step_us = (now_us() - begin) / 180;
    print_body("cape", cape);
    print_cost(cape);
    pli_world_destroy(world);

    world = make_world();
    const pli_body* balloon = make_balloon(world);
    const float volume = pli_body_volume(balloon);
    run(world, 5);
    print_body("balloon", balloon);
    print_cost(balloon);
    printf("          holds %.2f times its volume\n", (double)(pli_body_volume(balloon) / volume));
    pli_world_destroy(world);

    world = make_world();
    const pli_body* solid = make_solid(world);
    run(world, 5);
    print_body("solid", solid);
    print_cost(solid);
    pli_world_destroy(world);

    world = make_world();
    const pli_body* clustered = make_clustered(world);
    const uint64_t before = pli_context_allocation_count(context);
    run(world, 5);
    print_body("clustered", clustered);
    print_cost(clustered);
    printf("          %.0f kB, %llu allocations in 300 steps\n", (double)pli_body_bytes(clustered) / 1000,
           (unsigned long long)(pli_context_allocation_count(context) - before));
    pli_world_destroy(world);

    check(pli_context_destroy(context));
    pli_threads_destroy(threads);
    return 0;
}
