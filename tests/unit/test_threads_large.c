/* One large body on several threads: the same bits as on one, for each solver and both kinds of self-collision. */

#include "check.h"
#include "hash_mix.h"

#include <pliant/pliant.h>

#include <string.h>

enum { SIDE = 48, LAYER = 12 };
static const int teams[] = {3, 2, 8};
static const float spacing = 0.02f;

typedef enum sheet_kind {
    SHEET_COLORED,
    SHEET_SELF_NODES,
    SHEET_SELF_NODES_XPBD,
    SHEET_SELF_FACES,
    SHEET_JACOBI,
    SHEET_CHEBYSHEV,
    SHEET_GRADIENTS,
    SHEET_SELF_FACES_XPBD,
    SHEET_KINDS
} sheet_kind;

#ifdef __SANITIZE_THREAD__ /* takes a hundred times as long */
enum { KINDS = SHEET_SELF_FACES_XPBD, TEAMS = 1, STEPS = 2 };
#else
enum { KINDS = SHEET_KINDS, TEAMS = 3, STEPS = 4 };
#endif

typedef struct calls {
    pli_threads* threads;
    int parted; /* ranges that had more than one part to give away */
} calls;

static void counted_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    calls* made = user;
    made->parted += count >= 2 * grain;
    pli_threads_parallel_for(range, task, count, grain, made->threads);
}

/* Layers closer to each other than nodes keep, as of cloth that was folded up. */
static pli_vec3 place(int column, int row) {
    const int layer = row / LAYER, along = layer % 2 == 0 ? row % LAYER : LAYER - 1 - row % LAYER;
    const float wave = 0.1f * spacing * (float)((7 * column + 5 * row) % 11);
    return pli_vec3_make(spacing * (float)column, 0.3f + 0.7f * spacing * (float)layer + 0.3f * wave,
                         spacing * (float)along + wave);
}

static pli_mesh* make_sheet(pli_context* context) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, place(i % SIDE, i / SIDE), 1e-3f, NULL), PLI_OK);
    }
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const int column = i % SIDE, row = i / SIDE, below = i + SIDE;
        if (column + 1 < SIDE) { assert_int_equal(pli_mesh_append_link(mesh, i, i + 1, 0, NULL), PLI_OK); }
        if (row + 1 < SIDE) { assert_int_equal(pli_mesh_append_link(mesh, i, below, 0, NULL), PLI_OK); }
        if (column + 1 == SIDE || row + 1 == SIDE) { continue; }
        assert_int_equal(pli_mesh_append_link(mesh, i, below + 1, 0, NULL), PLI_OK);
        assert_int_equal(pli_mesh_append_face(mesh, i, below, below + 1, 0, NULL), PLI_OK);
        assert_int_equal(pli_mesh_append_face(mesh, i, below + 1, i + 1, 0, NULL), PLI_OK);
    }
    return mesh;
}

static void add_ball(pli_context* context, pli_world* world) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_sphere(context, 0.28f, &shape), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.state.pose.origin = pli_vec3_make(0.5f * spacing * SIDE, 0, 0.5f * spacing * LAYER);
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
}

static void use_implicit(pli_body* body, pli_implicit_method method) {
    pli_implicit_def def = pli_implicit_def_default();
    def.method = method;
    def.stiffness = 50;
    def.sweeps = method == PLI_IMPLICIT_CONJUGATE_GRADIENT ? 20 : 5;
    assert_int_equal(pli_body_enable_implicit(body, &def), PLI_OK);
}

static void enable(pli_body* body, sheet_kind kind) {
    const bool has_nodes = kind == SHEET_SELF_NODES || kind == SHEET_SELF_NODES_XPBD;
    const bool has_faces = kind == SHEET_SELF_FACES || kind == SHEET_SELF_FACES_XPBD;
    assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
    if (kind == SHEET_SELF_NODES_XPBD || kind == SHEET_SELF_FACES_XPBD) {
        assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(body, NULL), PLI_OK);
    } else if (kind == SHEET_JACOBI || kind == SHEET_CHEBYSHEV || kind == SHEET_GRADIENTS) {
        use_implicit(body, kind == SHEET_JACOBI      ? PLI_IMPLICIT_JACOBI
                           : kind == SHEET_CHEBYSHEV ? PLI_IMPLICIT_CHEBYSHEV
                                                     : PLI_IMPLICIT_CONJUGATE_GRADIENT);
    } else {
        assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
    }
    pli_self_collision_def nodes = pli_self_collision_def_default();
    nodes.thickness = 0.9f * spacing;
    if (has_nodes) { assert_int_equal(pli_body_enable_self_collision(body, &nodes), PLI_OK); }
    pli_self_faces_def faces = pli_self_faces_def_default();
    faces.thickness = 0.75f * spacing;
    if (has_faces) { assert_int_equal(pli_body_enable_self_faces(body, &faces), PLI_OK); }
}

static uint64_t run_on(int threads, sheet_kind kind, calls* made) {
    *made = (calls){0};
    pli_context_def def = pli_context_def_default();
    if (threads > 1) {
        assert_int_equal(pli_threads_create(threads, &made->threads), PLI_OK);
        def.parallel_for = counted_parallel_for;
        def.parallel_user = made;
    }
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_body* body = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = make_sheet(context);
    pli_body_def body_def = pli_body_def_default();
    body_def.collision_margin = 0.5f * spacing;
    body_def.solver.position_iterations = 4;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    add_ball(context, world);
    enable(body, kind);
    uint64_t hash = HASH_START;
    for (int i = 0; i < STEPS; ++i) {
        assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
        const uint64_t state = pli_body_state_hash(body);
        const pli_self_collision_report nodes = pli_body_get_self_collision_report(body);
        const pli_self_faces_report faces = pli_body_get_self_faces_report(body);
        const int counts[] = {nodes.pairs,        nodes.contacts,
                              nodes.searches,     nodes.limited_nodes,
                              faces.pairs,        faces.contacts,
                              faces.shortened,    (int)nodes.is_truncated,
                              faces.is_truncated, pli_body_get_implicit_report(body).iterations};
        hash = hash_mix(hash_mix(hash, &state, sizeof state), counts, sizeof counts);
        if (kind == SHEET_SELF_NODES || kind == SHEET_SELF_NODES_XPBD) { assert_true(nodes.contacts > 100); }
        if (kind == SHEET_SELF_FACES || kind == SHEET_SELF_FACES_XPBD) { assert_true(faces.pairs > 1000); }
    }
    assert_false(pli_body_is_frozen(body));
    assert_true(pli_body_get_rigid_contacts(body, 0, NULL) > 0);
    const size_t all = pli_context_allocated_bytes(context);
    pli_world_destroy(world);
    assert_true(all > 0);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    pli_threads_destroy(made->threads);
    return hash;
}

static void bits_do_not_depend_on_threads(void** unused) {
    (void)unused;
    for (int kind = 0; kind < KINDS; ++kind) {
        calls made;
        const uint64_t expected = run_on(1, (sheet_kind)kind, &made);
        for (int i = 0; i < TEAMS; ++i) {
            const int threads = teams[i];
            const uint64_t hash = run_on(threads, (sheet_kind)kind, &made);
            if (hash != expected) { fail_msg("sheet %d: other bits with %d threads", kind, threads); }
            if (kind != SHEET_COLORED) { assert_true(made.parted >= 4 * STEPS); }
            /* In each substep pairs are parted and lose speed in even parts and in odd ones. */
            if (kind == SHEET_SELF_NODES_XPBD) { assert_true(made.parted >= 40 * STEPS); }
        }
    }
}

// ------------------------------------------------------------------------------------------- which nodes a part has

enum { WIDE = 80 };

typedef struct moves {
    const pli_body* body;
    pli_vec4 before[WIDE * WIDE];
    int count, astray;
} moves;

/* As two threads would: each has a half of every range. Counts the nodes that a half moves among those of the other. */
static void count_moves(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)grain;
    moves* all = user;
    for (int half = 0; half < 2; ++half) {
        const pli_vec4* nodes = all->body != NULL ? pli_body_get_view(all->body).positions : NULL;
        if (nodes != NULL) { memcpy(all->before, nodes, sizeof all->before); }
        range(half * (count / 2), half == 0 ? count / 2 : count, task);
        for (int i = 0; nodes != NULL && i < WIDE * WIDE; ++i) {
            const bool has_moved = memcmp(&all->before[i], &nodes[i], sizeof nodes[i]) != 0;
            all->count += has_moved;
            all->astray += has_moved && half != 2 * i / (WIDE * WIDE);
        }
    }
}

static uint64_t step_wide(moves* all) {
    pli_context_def def = pli_context_def_default();
    if (all != NULL) {
        def.parallel_for = count_moves;
        def.parallel_user = all;
    }
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_patch_def patch = pli_patch_def_default();
    patch.columns = patch.rows = WIDE;
    assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, NULL), PLI_OK);
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
    for (int i = 0; i < WIDE * WIDE; ++i) {
        const pli_vec3 velocity = pli_vec3_make((float)(i % 7) - 3, (float)(i % 11) - 5, (float)(i % 13) - 6);
        assert_int_equal(pli_body_set_node_velocity(body, i, velocity), PLI_OK);
    }
    if (all != NULL) { all->body = body; }
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    const uint64_t hash = pli_body_state_hash(body);
    pli_world_destroy(world);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    return hash;
}

static void parts_of_all_colors_have_the_same_nodes(void** unused) {
    (void)unused;
    static moves all;
    assert_true(step_wide(&all) == step_wide(NULL));
    print_message("%d of %d nodes were moved by the other half\n", all.astray, all.count);
    assert_true(all.count > 9 * WIDE * WIDE);
    assert_true(all.astray < all.count / 20); /* links between the halves */
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bits_do_not_depend_on_threads),
                                       cmocka_unit_test(parts_of_all_colors_have_the_same_nodes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
