/* Coloured links: every link has its place and lanes of a colour share no node; results are those of the ordered links
   in the order of colours, the same for all instruction sets and partitions; bodies that are cut; memory. */

#include "check.h"
#include "failing_allocator.h"
#include "sample_mesh.h"

#include <pliant/pliant.h>

#include "body/pipeline.h"
#include "solver/coloring/link_coloring.h"
#include "solver/xpbd/xpbd_impl.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const float dt = 1.0f / 60.0f;

static int group_ranges; /* that were parted: nodes come in thousands, their bounds with a grain of 1 */

/* Runs ranges backwards in parts of at most `part`. */
static void cut_into_parts(pli_range_fn* range, void* task, int count, int grain, void* user) {
    const int part = *(const int*)user;
    group_ranges += grain > 1 && count < 1000;
    for (int end = count; end > 0; end -= part) {
        range(end > part ? end - part : 0, end, task);
    }
}

static pli_context* create_context(pli_simd simd, const int* part) {
    pli_context_def def = pli_context_def_default();
    def.simd = simd;
    if (part != NULL) {
        def.parallel_for = cut_into_parts;
        def.parallel_user = (void*)(uintptr_t)part;
    }
    pli_context* context = NULL;
    return pli_context_create(&def, &context) == PLI_OK ? context : NULL;
}

typedef pli_mesh* make_mesh_fn(pli_context* context);

static pli_mesh* make_sheet_of(pli_context* context, int size) {
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(context, size, 0.1f, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10, &mesh), PLI_OK);
    return mesh;
}
static pli_mesh* make_sheet(pli_context* context) {
    return make_sheet_of(context, 41);
}
static pli_mesh* make_large_sheet(pli_context* context) {
    return make_sheet_of(context, 70);
}
/* Of so many links that threads get parts of their colours. */
static pli_mesh* make_shared_sheet(pli_context* context) {
    return make_sheet_of(context, 130);
}
/* With bending links of another material. */
static pli_mesh* make_bending_sheet_of(pli_context* context, int size) {
    pli_mesh* mesh = make_sheet_of(context, size);
    pli_material material = pli_mesh_get_view(mesh).materials[0];
    material.linear_stiffness = 0.3f;
    int index = 0;
    assert_int_equal(pli_mesh_append_material(mesh, &material, &index), PLI_OK);
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, index, NULL), PLI_OK);
    return mesh;
}
static pli_mesh* make_bending_sheet(pli_context* context) {
    return make_bending_sheet_of(context, 41);
}
static pli_mesh* make_large_bending_sheet(pli_context* context) {
    return make_bending_sheet_of(context, 70);
}
static pli_mesh* make_large_shuffled_sheet(pli_context* context) {
    pli_mesh* mesh = make_large_sheet(context);
    assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK);
    return mesh;
}
static pli_mesh* make_sphere_of(pli_context* context, pli_vec3 radii, int nodes) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 3, 0), radii, nodes, &mesh), PLI_OK);
    return mesh;
}
static pli_mesh* make_sphere(pli_context* context) {
    pli_mesh* mesh = make_sphere_of(context, pli_vec3_make(1, 2, 1), 300);
    assert_int_equal(pli_mesh_set_node_mass(mesh, 7, 0.0f), PLI_OK);
    return mesh;
}
static pli_mesh* make_small_sphere(pli_context* context) {
    return make_sphere_of(context, pli_vec3_make(1, 1, 1), 200);
}
/* Of so many quads that threads get parts of their colours. */
static pli_mesh* make_large_sphere(pli_context* context) {
    return make_sphere_of(context, pli_vec3_make(1, 2, 1), 12000);
}
static pli_mesh* make_rope(pli_context* context) {
    pli_mesh* mesh = NULL;
    assert_int_equal(
        pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(3, 0, 0), 30, PLI_ROPE_PIN_FIRST, &mesh),
        PLI_OK);
    return mesh;
}
/* A node with more links than there are colours, one of them double, one between pinned nodes, and a long chain. */
enum { STAR_NODES = 400 };

static pli_mesh* make_star(pli_context* context) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < STAR_NODES; ++i) {
        const float angle = 0.1f * (float)i;
        const pli_vec3 position = pli_vec3_make((float)i * cosf(angle), (float)i * sinf(angle), 0.1f * (float)i);
        assert_int_equal(pli_mesh_append_node(mesh, position, i < 2 ? 0.0f : 1.0f + (float)i, NULL), PLI_OK);
    }
    for (int i = 1; i < STAR_NODES; ++i) {
        assert_int_equal(
            pli_mesh_append_link(mesh, i % 2 == 0 ? 40 : i, i % 2 == 0 ? i - (i == 40) : 40 + (i == 40), 0, NULL),
            PLI_OK);
    }
    assert_int_equal(pli_mesh_append_link(mesh, 0, 1, 0, NULL), PLI_OK);
    for (int i = 0; i < 2400; ++i) {
        int node = 0;
        assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make((float)i, -1, 0), 1.0f, &node), PLI_OK);
        if (i > 0) { assert_int_equal(pli_mesh_append_link(mesh, node - 1, node, 0, NULL), PLI_OK); }
    }
    return mesh;
}
static pli_mesh* make_point(pli_context* context) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(0, 0, 0), 1.0f, NULL), PLI_OK);
    return mesh;
}

static pli_mesh* make_small_bending_sheet(pli_context* context) {
    return make_bending_sheet_of(context, 9);
}
/* Links between any nodes, some of them twice, of three materials. */
static pli_mesh* make_tangle(pli_context* context) {
    enum { nodes = 70, links = 200 };
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < nodes; ++i) {
        const pli_vec3 position = pli_vec3_make((float)(i % 7), (float)(i % 11), 0.3f * (float)i);
        assert_int_equal(pli_mesh_append_node(mesh, position, 1.0f, NULL), PLI_OK);
    }
    const pli_material material = pli_mesh_get_view(mesh).materials[0];
    for (int i = 1; i < 3; ++i) {
        assert_int_equal(pli_mesh_append_material(mesh, &material, NULL), PLI_OK);
    }
    uint32_t seed = 1;
    for (int i = 0; i < links; ++i) {
        seed = seed * 1664525u + 1013904223u;
        const int a = (int)(seed >> 8) % nodes, b = (a + 1 + (int)(seed >> 16) % (nodes - 1)) % nodes;
        assert_int_equal(pli_mesh_append_link(mesh, a, b, i % 3, NULL), PLI_OK);
    }
    return mesh;
}

static make_mesh_fn* const meshes[] = {
    make_sheet,  make_bending_sheet, make_large_sheet, make_large_shuffled_sheet, make_large_bending_sheet,
    make_sphere, make_rope,          make_star,        make_small_sphere,         make_small_bending_sheet,
    make_tangle, make_point};
enum { MESH_COUNT = sizeof meshes / sizeof *meshes };

typedef struct sample {
    pli_context* context;
    pli_world* world;
    pli_body* body;
} sample;

static bool sample_create(sample* s, make_mesh_fn* make_mesh, bool is_colored, pli_simd simd, const int* part) {
    s->context = create_context(simd, part);
    if (s->context == NULL) { return false; }
    assert_int_equal(pli_world_create(s->context, NULL, &s->world), PLI_OK);
    pli_mesh* mesh = make_mesh(s->context);
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 3;
    assert_int_equal(pli_body_create(s->world, mesh, &def, &s->body), PLI_OK);
    pli_mesh_destroy(mesh);
    if (is_colored) { assert_int_equal(pli_body_enable_colored_links(s->body), PLI_OK); }
    return true;
}

static void sample_destroy(sample* s) {
    pli_world_destroy(s->world);
    assert_int_equal(pli_context_allocated_bytes(s->context), 0);
    pli_context_destroy(s->context);
}

/* Index of the link of every slot, -1 where there is none. */
static int list_slots(const plii_link_colors* colors, int** slots) {
    const int count = plii_link_colors_slot_count(colors);
    *slots = calloc((size_t)count + 1, sizeof **slots);
    assert_non_null(*slots);
    for (int i = 0; i < count; ++i) {
        (*slots)[i] = plii_link_colors_link(colors, i);
    }
    return count;
}

/* What a link of a colour touches: which nodes, and from which lane. */
typedef struct node_use {
    int color, lane;
} node_use;

static void use_link(const pli_body* body, int link, int color, int lane, node_use* uses, int* seen) {
    seen[link] += 1;
    for (int k = 0; k < 2; ++k) {
        node_use* use = &uses[body->links[link].nodes[k]];
        assert_false(use->color == color && use->lane != lane);
        *use = (node_use){color, lane};
    }
}

/* Every link has one slot, and nodes of a colour are in one lane only. */
static void check_colors(pli_body* body) {
    const plii_link_colors* colors = plii_link_colors_of(body);
    assert_non_null(colors);
    int* slots = NULL;
    list_slots(colors, &slots);
    int* seen = calloc((size_t)body->link_count + 1, sizeof *seen);
    node_use* uses = calloc((size_t)body->node_count, sizeof *uses);
    assert_true(seen != NULL && uses != NULL);
    int color = 0;
    for (int c = 0; c < colors->color_count; ++c) {
        ++color;
        const int first = colors->colors[c].first_group, end = first + colors->colors[c].group_count;
        assert_true(first < end);
        for (int g = first; g < end; ++g) {
            const plii_link_group* group = &colors->groups[g];
            const int end_row = g + 1 < colors->group_count ? group[1].first_row : colors->row_count;
            for (int i = 8 * group->first_row; i < 8 * end_row; ++i) {
                const int link = slots[i];
                if (link < 0) { continue; }
                use_link(body, link, color, 8 * g + i % 8, uses, seen);
            }
        }
    }
    for (int i = 0; i < body->link_count; ++i) {
        assert_int_equal(seen[i], 1);
    }
    free(slots);
    free(seen);
    free(uses);
}

static void test_no_two_lanes_of_a_color_share_a_node(void** state) {
    (void)state;
    for (int m = 0; m < MESH_COUNT; ++m) {
        sample s;
        assert_true(sample_create(&s, meshes[m], true, PLI_SIMD_BEST, NULL));
        check_colors(s.body);
        sample_destroy(&s);
    }
}

static void test_many_links_of_a_node_wait(void** state) {
    (void)state;
    sample s;
    assert_true(sample_create(&s, make_star, true, PLI_SIMD_PORTABLE, NULL));
    const plii_link_colors* colors = plii_feature_state(s.body, &plii_link_colors_class);
    int own_links = 0; /* of colours beyond the 64 that are shared, which took three or two links each */
    for (int c = 64; c < colors->color_count; ++c) {
        assert_int_equal(colors->colors[c].group_count, 1);
        own_links += __builtin_popcount(colors->groups[colors->colors[c].first_group].pairs);
    }
    assert_int_equal(own_links, 208);
    sample_destroy(&s);
}

static void test_meshes_become_quads_and_small_bodies_single_links(void** state) {
    (void)state;
    make_mesh_fn* const quads[] = {make_sheet, make_sphere};
    for (int m = 0; m < 2; ++m) {
        sample s;
        assert_true(sample_create(&s, quads[m], true, PLI_SIMD_PORTABLE, NULL));
        const plii_link_colors* colors = plii_feature_state(s.body, &plii_link_colors_class);
        assert_true(colors->color_count <= 64);
        assert_true(s.body->link_count > 8 * colors->row_count * 85 / 100); /* few lanes without a link */
        assert_true(s.body->link_count > 25 * colors->group_count);         /* more than three links per quad */
        sample_destroy(&s);
    }
    sample s;
    assert_true(sample_create(&s, make_rope, true, PLI_SIMD_BEST, NULL));
    const plii_link_colors* colors = plii_feature_state(s.body, &plii_link_colors_class);
    assert_int_equal(colors->color_count, 2);
    for (int g = 0; g < colors->group_count; ++g) {
        assert_int_equal(colors->groups[g].pairs, PLII_LINK_SINGLE);
    }
    sample_destroy(&s);
}

/* The same mesh with its links in the order of slots, each once. */
static pli_mesh* reorder(const sample* s, pli_context* context, make_mesh_fn* make_mesh) {
    const plii_link_colors* colors = plii_feature_state(s->body, &plii_link_colors_class);
    int* slots = NULL;
    const int count = list_slots(colors, &slots);
    pli_mesh* source = make_mesh(context);
    const pli_mesh_view view = pli_mesh_get_view(source);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < view.node_count; ++i) {
        const float inverse_mass = s->body->positions[i].w;
        assert_int_equal(
            pli_mesh_append_node(mesh, view.positions[i], inverse_mass > 0.0f ? 1.0f / inverse_mass : 0.0f, NULL),
            PLI_OK);
    }
    for (int i = 1; i < view.material_count; ++i) {
        assert_int_equal(pli_mesh_append_material(mesh, &view.materials[i], NULL), PLI_OK);
    }
    for (int i = 0; i < count; ++i) {
        if (slots[i] >= 0) {
            const pli_link* link = &view.links[slots[i]];
            assert_int_equal(pli_mesh_append_link(mesh, link->nodes[0], link->nodes[1], link->material, NULL), PLI_OK);
        }
    }
    free(slots);
    pli_mesh_destroy(source);
    return mesh;
}

/* The arithmetic differs only in when masses are divided by. */
static void test_colored_links_are_ordered_links_in_the_order_of_colors(void** state) {
    (void)state;
    for (int m = 0; m < MESH_COUNT; ++m) {
        if (meshes[m] == make_point) { continue; }
        sample s;
        assert_true(sample_create(&s, meshes[m], true, PLI_SIMD_BEST, NULL));
        pli_mesh* mesh = reorder(&s, s.context, meshes[m]);
        pli_body_def def = pli_body_def_default();
        def.solver.position_iterations = 3;
        pli_body* ordered = NULL;
        assert_int_equal(pli_body_create(s.world, mesh, &def, &ordered), PLI_OK);
        pli_mesh_destroy(mesh);
        for (int i = 0; i < s.body->node_count; ++i) {
            ordered->positions[i].w = s.body->positions[i].w; /* bits */
        }
        for (int i = 0; i < 10; ++i) {
            assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
            for (int k = 0; k < s.body->node_count; ++k) {
                const pli_vec3 apart = pli_vec3_sub(plii_xyz(s.body->positions[k]), plii_xyz(ordered->positions[k]));
                check_near(pli_vec3_length(apart), 0,
                           1e-4f * (1.0f + pli_vec3_length(plii_xyz(ordered->positions[k]))));
            }
        }
        sample_destroy(&s);
    }
}

typedef enum link_solver { LINKS_ON_POSITIONS, XPBD_RIGID, XPBD_SOFT, LINK_SOLVER_COUNT } link_solver;

static void use_xpbd(pli_body* body, bool is_soft) {
    pli_xpbd_def def = pli_xpbd_def_default();
    def.substeps = 3;
    assert_int_equal(pli_body_enable_xpbd(body, &def), PLI_OK);
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = is_soft ? 1e-3f : 0.0f;
    links.bending_compliance = 1e-2f;
    links.damping = is_soft ? 2.0f : 0.0f;
    assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
}

static uint64_t hash_after_steps(make_mesh_fn* make_mesh, link_solver solver, pli_simd simd, const int* part,
                                 bool is_cut) {
    sample s;
    if (!sample_create(&s, make_mesh, solver == LINKS_ON_POSITIONS, simd, part)) { return 0; }
    if (solver != LINKS_ON_POSITIONS) { use_xpbd(s.body, solver == XPBD_SOFT); }
    assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
    if (is_cut) {
        const int* nodes = s.body->links[s.body->link_count / 2].nodes;
        assert_int_equal(pli_body_cut_link(s.body, nodes[0], nodes[1], 0.5f), PLI_OK);
        check_colors(s.body);
    }
    assert_int_equal(pli_body_set_rest_length(s.body, s.body->link_count / 3, 0.2f), PLI_OK);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
    }
    const uint64_t hash = pli_body_state_hash(s.body);
    sample_destroy(&s);
    return hash;
}

static int check_equal_results(make_mesh_fn* make_mesh, link_solver solver, bool is_cut) {
    const pli_simd paths[] = {PLI_SIMD_BEST, PLI_SIMD_SSE2, PLI_SIMD_AVX2, PLI_SIMD_AVX512, PLI_SIMD_NEON};
    const int parts[] = {1, 37};
    const uint64_t expected = hash_after_steps(make_mesh, solver, PLI_SIMD_PORTABLE, NULL, is_cut);
    int compared = 0;
    for (size_t p = 0; p < sizeof paths / sizeof *paths; ++p) {
        const uint64_t hash = hash_after_steps(make_mesh, solver, paths[p], NULL, is_cut);
        if (hash != 0) {
            assert_true(hash == expected);
            ++compared;
        }
    }
    for (size_t p = 0; p < sizeof parts / sizeof *parts; ++p) {
        assert_true(hash_after_steps(make_mesh, solver, PLI_SIMD_BEST, &parts[p], is_cut) == expected);
    }
    return compared;
}

static void test_results_are_equal_for_all_instruction_sets_and_partitions(void** state) {
    (void)state;
    for (int m = 0; m < MESH_COUNT; ++m) {
        if (meshes[m] == make_point) { continue; }
        for (int solver = 0; solver < LINK_SOLVER_COUNT; ++solver) {
            const bool is_cut = meshes[m] != make_star;
            assert_true(check_equal_results(meshes[m], (link_solver)solver, is_cut) >= 1);
        }
    }
}

static void test_parts_of_colors_have_equal_results(void** state) {
    (void)state;
    make_mesh_fn* const large[] = {make_large_sphere, make_shared_sheet};
    for (int m = 0; m < 2; ++m) {
        for (int solver = 0; solver < LINK_SOLVER_COUNT; ++solver) {
            const int part = 37;
            const uint64_t expected = hash_after_steps(large[m], (link_solver)solver, PLI_SIMD_BEST, NULL, false);
            group_ranges = 0;
            assert_true(hash_after_steps(large[m], (link_solver)solver, PLI_SIMD_BEST, &part, false) == expected);
            assert_true(group_ranges > 0);
        }
    }
}

static void test_rest_lengths_and_stiffness_follow_their_changes(void** state) {
    (void)state;
    sample s;
    assert_true(sample_create(&s, make_rope, true, PLI_SIMD_BEST, NULL));
    pli_solver_settings settings = pli_body_get_solver_settings(s.body);
    settings.position_iterations = 400;
    assert_int_equal(pli_body_set_solver_settings(s.body, &settings), PLI_OK);
    assert_int_equal(pli_world_set_gravity(s.world, pli_vec3_make(0, 0, 0)), PLI_OK);
    assert_int_equal(pli_body_set_rest_length(s.body, 3, 0.5f), PLI_OK);
    assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
    const int* nodes = s.body->links[3].nodes;
    check_near(
        pli_vec3_length(pli_vec3_sub(plii_xyz(s.body->positions[nodes[0]]), plii_xyz(s.body->positions[nodes[1]]))),
        0.5f, 2e-2);
    sample_destroy(&s);
}

static void test_unknown_instruction_sets_are_refused(void** state) {
    (void)state;
    pli_context_def def = pli_context_def_default();
    pli_context* context = NULL;
    def.simd = (pli_simd)99;
    assert_int_equal(pli_context_create(&def, &context), PLI_ERROR_INVALID_VALUE);
    assert_null(context);
}

/* Six nodes, each linked with each other: five colours at least for fifteen links. */
static pli_mesh* make_knot(pli_context* context) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < 6; ++i) {
        const pli_vec3 position = pli_vec3_make((float)(i % 2), (float)(i % 3), 0.5f * (float)i);
        assert_int_equal(pli_mesh_append_node(mesh, position, 1.0f, NULL), PLI_OK);
        for (int k = 0; k < i; ++k) {
            assert_int_equal(pli_mesh_append_link(mesh, k, i, 0, NULL), PLI_OK);
        }
    }
    return mesh;
}

static void test_few_links_that_all_meet_keep_their_order(void** state) {
    (void)state;
    uint64_t hashes[2];
    for (int is_colored = 0; is_colored < 2; ++is_colored) {
        sample s;
        assert_true(sample_create(&s, make_knot, is_colored == 1, PLI_SIMD_BEST, NULL));
        assert_int_equal(pli_body_add_velocity(s.body, pli_vec3_make(1, 2, 3)), PLI_OK);
        assert_int_equal(pli_body_set_node_velocity(s.body, 2, pli_vec3_make(0, 20, 0)), PLI_OK);
        for (int i = 0; i < 5; ++i) {
            assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
        }
        hashes[is_colored] = pli_body_state_hash(s.body);
        sample_destroy(&s);
    }
    assert_true(hashes[0] == hashes[1]);
}

static pli_mesh* make_rope_of(pli_context* context, int link_count) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0),
                                          pli_vec3_make(0.1f * (float)link_count, 0, 0), link_count - 1,
                                          PLI_ROPE_PIN_FIRST, &mesh),
                     PLI_OK);
    assert_int_equal(pli_mesh_get_view(mesh).link_count, link_count);
    return mesh;
}

/* In two colours they would be held worse at their ends. */
static void test_short_ropes_keep_their_order(void** state) {
    (void)state;
    pli_context* context = create_context(PLI_SIMD_BEST, NULL);
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    for (int link_count = 1; link_count < 16; ++link_count) {
        uint64_t hashes[2];
        for (int is_colored = 0; is_colored < 2; ++is_colored) {
            pli_mesh* mesh = make_rope_of(context, link_count);
            pli_body* body = NULL;
            assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
            pli_mesh_destroy(mesh);
            if (is_colored == 1) { assert_int_equal(pli_body_enable_colored_links(body), PLI_OK); }
            for (int i = 0; i < 10; ++i) {
                assert_int_equal(pli_world_step(world, dt), PLI_OK);
            }
            hashes[is_colored] = pli_body_state_hash(body);
            pli_body_destroy(body);
        }
        assert_true(hashes[0] == hashes[1]);
    }
    pli_world_destroy(world);
    pli_context_destroy(context);
}

static void test_a_box_hangs_on_a_long_rope(void** state) {
    (void)state;
    enum { links = 24 };
    pli_context* context = create_context(PLI_SIMD_BEST, NULL);
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = make_rope_of(context, links);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 60;
    body_def.solver.velocity_damping = 0.02f;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.pose.origin = plii_xyz(body->positions[links]);
    def.state.inverse_mass = 1.0f;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 100.0f);
    }
    pli_rigid* box = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &box), PLI_OK);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.node = links;
    anchor.rigid = box;
    assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK);
    for (int i = 0; i < 600; ++i) {
        pli_rigid_state own = pli_rigid_get_state(box);
        own.linear_velocity.y -= 10.0f * dt;
        own.linear_velocity = pli_vec3_scale(own.linear_velocity, 0.99f);
        own.pose.origin = pli_vec3_add(own.pose.origin, pli_vec3_scale(own.linear_velocity, dt));
        assert_int_equal(pli_rigid_set_state(box, &own), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    const float length = 0.1f * (float)links;
    check_near(pli_vec3_length(plii_xyz(body->positions[links])), length, 0.03f * length);
    check_near(body->positions[links].y, -length, 0.05f * length);
    pli_world_destroy(world);
    pli_context_destroy(context);
}

static void test_steps_allocate_nothing(void** state) {
    (void)state;
    sample s;
    assert_true(sample_create(&s, make_bending_sheet, true, PLI_SIMD_BEST, NULL));
    assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
    const uint64_t before = pli_context_allocation_count(s.context);
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
    }
    assert_true(pli_context_allocation_count(s.context) == before);
    sample_destroy(&s);
}

static void test_switching_back_restores_the_ordered_links(void** state) {
    (void)state;
    uint64_t hashes[2];
    for (int i = 0; i < 2; ++i) {
        sample s;
        assert_true(sample_create(&s, make_sphere, i == 1, PLI_SIMD_BEST, NULL));
        const size_t bytes = pli_body_bytes(s.body);
        if (i == 1) {
            assert_int_equal(pli_body_enable_colored_links(s.body), PLI_OK);
            assert_int_equal(pli_body_disable_colored_links(s.body), PLI_OK);
            assert_true(pli_body_bytes(s.body) < bytes);
        }
        assert_int_equal(pli_world_step(s.world, dt), PLI_OK);
        hashes[i] = pli_body_state_hash(s.body);
        sample_destroy(&s);
    }
    assert_true(hashes[0] == hashes[1]);
}

/* Fails, or does without the block. */
static void test_coloring_survives_a_lack_of_memory(void** state) {
    (void)state;
    for (long fail_at = 0; fail_at < 12; ++fail_at) {
        failing_allocator allocator;
        pli_context* context = failing_context(&allocator);
        pli_world* world = NULL;
        assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
        pli_mesh* mesh = make_sheet(context);
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        allocator.fail_at = fail_at;
        const pli_status status = pli_body_enable_colored_links(body);
        assert_true(status == PLI_OK || status == PLI_ERROR_OUT_OF_MEMORY);
        if (fail_at == 0) { assert_int_equal(status, PLI_OK); }
        allocator.fail_at = 0;
        if (status == PLI_OK) {
            check_colors(body);
            allocator.fail_at = fail_at;
            const int* nodes = body->links[10].nodes;
            const pli_status cut = pli_body_cut_link(body, nodes[0], nodes[1], 0.5f);
            allocator.fail_at = 0;
            assert_true(cut == PLI_OK || cut == PLI_ERROR_OUT_OF_MEMORY);
            check_colors(body);
        }
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        pli_world_destroy(world);
        pli_context_destroy(context);
        assert_int_equal(allocator.alive, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_two_lanes_of_a_color_share_a_node),
        cmocka_unit_test(test_many_links_of_a_node_wait),
        cmocka_unit_test(test_meshes_become_quads_and_small_bodies_single_links),
        cmocka_unit_test(test_colored_links_are_ordered_links_in_the_order_of_colors),
        cmocka_unit_test(test_results_are_equal_for_all_instruction_sets_and_partitions),
        cmocka_unit_test(test_parts_of_colors_have_equal_results),
        cmocka_unit_test(test_rest_lengths_and_stiffness_follow_their_changes),
        cmocka_unit_test(test_unknown_instruction_sets_are_refused),
        cmocka_unit_test(test_few_links_that_all_meet_keep_their_order),
        cmocka_unit_test(test_short_ropes_keep_their_order),
        cmocka_unit_test(test_a_box_hangs_on_a_long_rope),
        cmocka_unit_test(test_steps_allocate_nothing),
        cmocka_unit_test(test_switching_back_restores_the_ordered_links),
        cmocka_unit_test(test_coloring_survives_a_lack_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
