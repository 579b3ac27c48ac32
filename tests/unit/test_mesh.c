/* The mesh recipe: appends and their errors, cloning, masses, bending links, orders, motions. */

#include "failing_allocator.h"

#include "context_fixture.h"

#include <pliant/body.h>
#include <pliant/bullet_reference.h>
#include <pliant/generate.h>
#include <pliant/world.h>

#include <float.h>

static pli_mesh* make_empty(void) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    return mesh;
}

/* A tetrahedron of mass 1 per node, with 6 links, 4 faces and 1 tetra, and one node apart. */
static pli_mesh* make_tetra(void) {
    const pli_vec3 points[5] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {7, 7, 7}};
    const int corners[4] = {0, 1, 2, 3};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_from_tetras(context, 5, points, 1, corners, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 0, 2, 1, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 3, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 1, 2, 3, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 2, 0, 3, 0, NULL), PLI_OK);
    return mesh;
}

/* Everything that a mesh holds, to see that a failed call changed nothing. */
static uint64_t mesh_hash(const pli_mesh* mesh) {
    const pli_mesh_view v = pli_mesh_get_view(mesh);
    const struct {
        const void* data;
        size_t size;
    } blocks[] = {
        {v.positions, (size_t)v.node_count * sizeof *v.positions},
        {v.inverse_masses, (size_t)v.node_count * sizeof *v.inverse_masses},
        {v.faces, (size_t)v.face_count * sizeof *v.faces},
        {v.tetras, (size_t)v.tetra_count * sizeof *v.tetras},
        {v.materials, (size_t)v.material_count * sizeof *v.materials},
    };
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) {
        for (size_t k = 0; k < blocks[i].size; ++k) {
            hash = (hash ^ ((const unsigned char*)blocks[i].data)[k]) * UINT64_C(1099511628211);
        }
        hash = (hash ^ blocks[i].size) * UINT64_C(1099511628211);
    }
    for (int i = 0; i < v.link_count; ++i) { /* has padding */
        const int values[4] = {v.links[i].nodes[0], v.links[i].nodes[1], v.links[i].material, v.links[i].is_bending};
        for (int k = 0; k < 4; ++k) {
            hash = (hash ^ (uint32_t)values[k]) * UINT64_C(1099511628211);
        }
    }
    return hash;
}

/* The call must give `status`, a message with `text` in it, and leave the mesh as it is. */
#define check_refused(mesh, call, status, text)                                                                        \
    do {                                                                                                               \
        const uint64_t check_before = mesh_hash(mesh);                                                                 \
        assert_int_equal(call, status);                                                                                \
        if (strstr(pli_last_error(context), text) == NULL) {                                                           \
            fail_msg("'%s' does not contain '%s'", pli_last_error(context), text);                                     \
        }                                                                                                              \
        assert_true(mesh_hash(mesh) == check_before);                                                                  \
    } while (0)

static void test_appends_give_indices_and_values(void** state) {
    (void)state;
    pli_mesh* mesh = make_empty();
    const pli_material soft = {0.25f};
    int index = -1;
    for (int i = 0; i < 100; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make((float)i, 2, 3), (float)(i % 4), &index), PLI_OK);
        assert_int_equal(index, i);
    }
    assert_int_equal(pli_mesh_append_material(mesh, &soft, &index), PLI_OK);
    assert_int_equal(index, 1);
    assert_int_equal(pli_mesh_append_link(mesh, 7, 3, 1, &index), PLI_OK);
    assert_int_equal(index, 0);
    assert_int_equal(pli_mesh_append_face(mesh, 7, 3, 5, 1, &index), PLI_OK);
    assert_int_equal(index, 0);
    assert_int_equal(pli_mesh_append_tetra(mesh, 7, 3, 5, 99, 0, &index), PLI_OK);
    assert_int_equal(index, 0);
    assert_int_equal(pli_mesh_set_node_position(mesh, 4, pli_vec3_make(9, 8, 7)), PLI_OK);
    assert_int_equal(pli_mesh_set_material(mesh, 0, &soft), PLI_OK);
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    assert_int_equal(view.node_count, 100);
    check_near(view.positions[99].x, 99, 0);
    check_near(view.positions[4].z, 7, 0);
    check_near(view.inverse_masses[2], 0.5, 0);
    check_near(view.inverse_masses[4], 0, 0);
    assert_int_equal(view.links[0].nodes[0], 7);
    assert_int_equal(view.links[0].nodes[1], 3);
    assert_int_equal(view.links[0].material, 1);
    assert_false(view.links[0].is_bending);
    assert_int_equal(view.faces[0].nodes[2], 5);
    assert_int_equal(view.tetras[0].nodes[3], 99);
    check_near(view.materials[0].linear_stiffness, 0.25, 0);
    pli_mesh_destroy(mesh);
    pli_mesh_destroy(NULL);
}

static void test_bad_appends_change_nothing(void** state) {
    (void)state;
    pli_mesh* mesh = make_tetra();
    const pli_vec3 origin = {0, 0, 0};
    int index = -5;
    check_refused(mesh, pli_mesh_append_node(mesh, pli_vec3_make(NAN, 0, 0), 1, &index), PLI_ERROR_NOT_FINITE,
                  "pli_mesh_append_node: the position is (nan");
    check_refused(mesh, pli_mesh_append_node(mesh, pli_vec3_make(0, 0, INFINITY), 1, &index), PLI_ERROR_NOT_FINITE,
                  "inf");
    check_refused(mesh, pli_mesh_append_node(mesh, origin, -1, &index), PLI_ERROR_INVALID_VALUE, "the mass is -1");
    check_refused(mesh, pli_mesh_append_node(mesh, origin, NAN, &index), PLI_ERROR_NOT_FINITE, "the mass is nan");
    check_refused(mesh, pli_mesh_append_node(mesh, origin, 1e-45f, &index), PLI_ERROR_INVALID_VALUE,
                  "pli_mesh_append_node: the mass is 1.4013e-45, the limits are 1e-09 and 1e+12");
    check_refused(mesh, pli_mesh_append_link(mesh, 0, 5, 0, &index), PLI_ERROR_INDEX_OUT_OF_RANGE,
                  "pli_mesh_append_link: node 5 is out of range, the mesh has 5 nodes");
    check_refused(mesh, pli_mesh_append_link(mesh, -1, 0, 0, &index), PLI_ERROR_INDEX_OUT_OF_RANGE, "node -1");
    check_refused(mesh, pli_mesh_append_link(mesh, 2, 2, 0, &index), PLI_ERROR_INVALID_VALUE, "node 2 is named twice");
    check_refused(mesh, pli_mesh_append_link(mesh, 0, 1, 1, &index), PLI_ERROR_INDEX_OUT_OF_RANGE,
                  "material 1 is out of range, the mesh has 1 materials");
    check_refused(mesh, pli_mesh_append_face(mesh, 0, 1, 9, 0, &index), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 9");
    check_refused(mesh, pli_mesh_append_face(mesh, 0, 1, 0, 0, &index), PLI_ERROR_INVALID_VALUE, "node 0 is named");
    check_refused(mesh, pli_mesh_append_face(mesh, 0, 1, 2, -1, &index), PLI_ERROR_INDEX_OUT_OF_RANGE, "material -1");
    check_refused(mesh, pli_mesh_append_tetra(mesh, 0, 1, 2, 5, 0, &index), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 5");
    check_refused(mesh, pli_mesh_append_tetra(mesh, 0, 1, 2, 1, 0, &index), PLI_ERROR_INVALID_VALUE, "node 1 is named");
    check_refused(mesh, pli_mesh_append_tetra(mesh, 0, 1, 2, 3, 2, &index), PLI_ERROR_INDEX_OUT_OF_RANGE, "material 2");
    const float stiffnesses[] = {0, -1, 1.0001f};
    for (int i = 0; i < 3; ++i) {
        const pli_material material = {stiffnesses[i]};
        check_refused(mesh, pli_mesh_append_material(mesh, &material, &index), PLI_ERROR_INVALID_VALUE,
                      "the limits are 1e-09 and 1");
        check_refused(mesh, pli_mesh_set_material(mesh, 0, &material), PLI_ERROR_INVALID_VALUE,
                      "the limits are 1e-09 and 1");
    }
    const pli_material none = {NAN}, good = {1};
    check_refused(mesh, pli_mesh_append_material(mesh, &none, &index), PLI_ERROR_NOT_FINITE, "nan");
    check_refused(mesh, pli_mesh_append_material(mesh, NULL, &index), PLI_ERROR_NULL_ARGUMENT, "null");
    check_refused(mesh, pli_mesh_set_material(mesh, 1, &good), PLI_ERROR_INDEX_OUT_OF_RANGE, "material 1");
    check_refused(mesh, pli_mesh_set_node_position(mesh, 5, origin), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 5");
    check_refused(mesh, pli_mesh_set_node_position(mesh, 0, pli_vec3_make(0, NAN, 0)), PLI_ERROR_NOT_FINITE, "nan");
    check_refused(mesh, pli_mesh_set_node_mass(mesh, 5, 1), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 5");
    check_refused(mesh, pli_mesh_set_node_mass(mesh, 0, -0.5f), PLI_ERROR_INVALID_VALUE, "-0.5");
    check_refused(mesh, pli_mesh_set_node_mass(mesh, 0, INFINITY), PLI_ERROR_NOT_FINITE, "inf");
    assert_int_equal(index, -5);
    pli_mesh_destroy(mesh);
}

static void test_null_meshes_are_refused(void** state) {
    (void)state;
    const pli_material material = {1};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(NULL, &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_create(context, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_clone(NULL, &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_node(NULL, pli_vec3_make(0, 0, 0), 1, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_link(NULL, 0, 1, 0, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_face(NULL, 0, 1, 2, 0, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_tetra(NULL, 0, 1, 2, 3, 0, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_material(NULL, &material, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_material(NULL, 0, &material), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_node_position(NULL, 0, pli_vec3_make(0, 0, 0)), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_bending_links(NULL, 2, 0, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_shuffle_links(NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_interleave_links(NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_node_mass(NULL, 0, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_total_mass(NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_total_mass_from_faces(NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_total_mass_from_tetras(NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_density_from_faces(NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_set_density_from_tetras(NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_transform(NULL, pli_transform_identity()), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_translate(NULL, pli_vec3_make(0, 0, 0)), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_rotate(NULL, pli_quat_identity()), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_scale(NULL, pli_vec3_make(1, 1, 1)), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_get_view(NULL).node_count, 0);
    check_near(pli_mesh_total_mass(NULL), 0, 0);
    check_near(pli_mesh_volume(NULL), 0, 0);
    check_near(pli_mesh_bounds(NULL).max.x, 0, 0);
    assert_null(mesh);
}

static void test_empty_mesh_is_harmless(void** state) {
    (void)state;
    pli_mesh* mesh = make_empty();
    int added = -1;
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, &added), PLI_OK);
    assert_int_equal(added, 0);
    assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK);
    assert_int_equal(pli_mesh_interleave_links(mesh), PLI_OK);
    assert_int_equal(pli_mesh_scale(mesh, pli_vec3_make(2, 2, 2)), PLI_OK);
    check_near(pli_mesh_volume(mesh), 0, 0);
    check_near(pli_mesh_bounds(mesh).min.x, 0, 0);
    check_near(pli_mesh_total_mass(mesh), 0, 0);
    check_refused(mesh, pli_mesh_set_total_mass(mesh, 1), PLI_ERROR_INVALID_MESH, "0 nodes");
    check_refused(mesh, pli_mesh_set_total_mass_from_faces(mesh, 1), PLI_ERROR_INVALID_MESH, "face");
    check_refused(mesh, pli_mesh_set_total_mass_from_tetras(mesh, 1), PLI_ERROR_INVALID_MESH, "tetrahedron");
    pli_mesh* copy = NULL;
    assert_int_equal(pli_mesh_clone(mesh, &copy), PLI_OK);
    assert_int_equal(pli_mesh_get_view(copy).material_count, 1);
    pli_mesh_destroy(copy);
    pli_mesh_destroy(mesh);
}

static void test_clone_is_equal_and_apart(void** state) {
    (void)state;
    pli_mesh* mesh = make_tetra();
    const pli_material soft = {0.5f};
    pli_mesh_append_material(mesh, &soft, NULL);
    pli_mesh_append_bending_links(mesh, 2, 1, NULL);
    pli_mesh* copy = NULL;
    assert_int_equal(pli_mesh_clone(mesh, &copy), PLI_OK);
    const uint64_t hash = mesh_hash(mesh);
    assert_true(mesh_hash(copy) == hash);
    assert_int_equal(pli_mesh_append_node(copy, pli_vec3_make(1, 2, 3), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_translate(copy, pli_vec3_make(1, 1, 1)), PLI_OK);
    assert_true(mesh_hash(mesh) == hash);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_mesh_get_view(copy).node_count, 6);
    pli_mesh_destroy(copy);
}

static const int* body_faces(pli_world* world, pli_mesh* mesh, int* count) {
    const pli_body_def def = pli_body_def_default();
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    *count = pli_body_get_view(body).face_count;
    return pli_body_get_view(body).face_nodes;
}

static void test_bodies_share_faces_until_the_mesh_changes(void** state) {
    (void)state;
    const pli_world_def world_def = pli_world_def_default();
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, &world_def, &world), PLI_OK);
    pli_mesh* mesh = make_tetra();
    int counts[4];
    const int* first = body_faces(world, mesh, &counts[0]);
    const int* second = body_faces(world, mesh, &counts[1]);
    assert_ptr_equal(first, second);
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 4, 0, NULL), PLI_OK);
    const int* third = body_faces(world, mesh, &counts[2]);
    assert_ptr_not_equal(first, third);
    const int last[3] = {third[12], third[13], third[14]};
    assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK);
    const int* fourth = body_faces(world, mesh, &counts[3]);
    assert_ptr_not_equal(third, fourth);
    pli_mesh_destroy(mesh);
    assert_int_equal(counts[0], 4);
    assert_int_equal(counts[1], 4);
    assert_int_equal(counts[2], 5);
    assert_int_equal(counts[3], 5);
    assert_int_equal(first[2], 1); /* the faces outlive the mesh */
    assert_memory_equal(third + 12, last, sizeof last);
    pli_world_destroy(world);
}

static void test_bending_links_of_a_chain(void** state) {
    (void)state;
    pli_mesh* mesh = make_empty();
    for (int i = 0; i < 7; ++i) {
        pli_mesh_append_node(mesh, pli_vec3_make((float)i, 0, 0), 1, NULL);
    }
    for (int i = 1; i < 5; ++i) {
        pli_mesh_append_link(mesh, i - 1, i, 0, NULL);
    }                                          /* nodes 5 and 6 are alone */
    pli_mesh_append_link(mesh, 1, 0, 0, NULL); /* twice */
    int added = -1;
    assert_int_equal(pli_mesh_append_bending_links(mesh, 3, 0, &added), PLI_OK);
    assert_int_equal(added, 2);
    const pli_link* links = pli_mesh_get_view(mesh).links;
    assert_int_equal(links[5].nodes[0], 3);
    assert_int_equal(links[5].nodes[1], 0);
    assert_int_equal(links[6].nodes[0], 4);
    assert_int_equal(links[6].nodes[1], 1);
    assert_true(links[5].is_bending);
    assert_false(links[4].is_bending);
    /* 0-4 were four links apart, now two: the new links count. */
    assert_int_equal(pli_mesh_append_bending_links(mesh, 4, 0, &added), PLI_OK);
    assert_int_equal(added, 0);
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, &added), PLI_OK);
    assert_int_equal(added, 4); /* 2-0, 4-0, 3-1, 4-2 */
    check_refused(mesh, pli_mesh_append_bending_links(mesh, 1, 0, &added), PLI_ERROR_INVALID_VALUE, "distance is 1");
    check_refused(mesh, pli_mesh_append_bending_links(mesh, -3, 0, &added), PLI_ERROR_INVALID_VALUE, "distance is -3");
    check_refused(mesh, pli_mesh_append_bending_links(mesh, 2, 1, &added), PLI_ERROR_INDEX_OUT_OF_RANGE, "material 1");
    pli_mesh_destroy(mesh);
}

/* A table of all pairs would need 40 GB here. */
static void test_bending_links_of_a_large_sheet(void** state) {
    (void)state;
    pli_patch_def def = pli_patch_def_default();
    def.columns = 250;
    def.rows = 400;
    def.diagonals = false;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    int added = 0;
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, &added), PLI_OK);
    assert_int_equal(added, 248 * 400 + 398 * 250 + 2 * 249 * 399);
    check_at_most(pli_context_allocated_bytes(context), 60e6);
    pli_mesh_destroy(mesh);
}

/* Every two of a star's ends; in the order of the smaller node, then of the larger one, though the star has them
   backwards. */
static void test_bending_links_of_a_star_are_in_order(void** state) {
    (void)state;
    enum { ends = 100 };
    pli_mesh* mesh = make_empty();
    for (int i = 0; i <= ends; ++i) {
        pli_mesh_append_node(mesh, pli_vec3_make((float)i, 1.0f / (float)(i + 1), 0), 1, NULL);
    }
    for (int i = 0; i < ends; ++i) {
        pli_mesh_append_link(mesh, i * 37 % ends, ends, 0, NULL);
    }
    int added = 0;
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, &added), PLI_OK);
    assert_int_equal(added, ends * (ends - 1) / 2);
    const pli_link* link = pli_mesh_get_view(mesh).links + ends;
    for (int a = 0; a < ends; ++a) {
        for (int b = a + 1; b < ends; ++b, ++link) {
            assert_int_equal(link->nodes[0], b);
            assert_int_equal(link->nodes[1], a);
        }
    }
    pli_mesh_destroy(mesh);
}

static void test_shuffle_is_a_fixed_permutation(void** state) {
    (void)state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 9, 0, &mesh),
                     PLI_OK);
    assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK);
    uint32_t seed = 243703;
    int order[10];
    for (int i = 0; i < 10; ++i) {
        order[i] = i;
    }
    for (int i = 0; i < 10; ++i) {
        seed = UINT32_C(1664525) * seed + UINT32_C(1013904223);
        const int other = (int)(seed % 10), kept = order[i];
        order[i] = order[other];
        order[other] = kept;
    }
    int moved = 0;
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_mesh_get_view(mesh).links[i].nodes[0], order[i]);
        moved += order[i] != i;
    }
    assert_true(moved > 4);
    pli_mesh_destroy(mesh);
}

static void test_interleave_keeps_the_order_at_each_node(void** state) {
    (void)state;
    pli_mesh* mesh = NULL;
    pli_patch_def def = pli_patch_def_default();
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    pli_mesh* ordered = NULL;
    assert_int_equal(pli_mesh_clone(mesh, &ordered), PLI_OK);
    assert_int_equal(pli_mesh_interleave_links(ordered), PLI_OK);
    const pli_mesh_view before = pli_mesh_get_view(mesh), after = pli_mesh_get_view(ordered);
    int moved = 0;
    for (int i = 0; i < before.link_count; ++i) {
        moved += memcmp(before.links[i].nodes, after.links[i].nodes, sizeof before.links[i].nodes) != 0;
    }
    assert_true(moved > before.link_count / 2);
    for (int node = 0; node < before.node_count; ++node) {
        for (int i = 0, k = 0; i < before.link_count; ++i) {
            if (before.links[i].nodes[0] != node && before.links[i].nodes[1] != node) { continue; }
            while (after.links[k].nodes[0] != node && after.links[k].nodes[1] != node) {
                ++k;
            }
            assert_memory_equal(before.links[i].nodes, after.links[k].nodes, sizeof before.links[i].nodes);
            ++k;
        }
    }
    pli_mesh_destroy(mesh);
    pli_mesh_destroy(ordered);
}

static void test_pins_and_loose_nodes_survive_mass_functions(void** state) {
    (void)state;
    pli_mesh* mesh = make_tetra();
    assert_int_equal(pli_mesh_set_node_mass(mesh, 0, 0), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 8), PLI_OK);
    check_near(pli_mesh_total_mass(mesh), 8, 1e-6);
    assert_int_equal(pli_mesh_set_total_mass_from_faces(mesh, 8), PLI_OK);
    pli_mesh_view view = pli_mesh_get_view(mesh);
    check_near(view.inverse_masses[0], 0, 0);
    check_near(view.inverse_masses[4], 0.5, 0); /* a quarter of 8 kg, nodes 1 to 3 share the rest evenly */
    check_near(view.inverse_masses[1], 0.5, 1e-7);
    check_near(pli_mesh_total_mass(mesh), 8, 2e-6);
    assert_int_equal(pli_mesh_set_total_mass_from_tetras(mesh, 2), PLI_OK);
    view = pli_mesh_get_view(mesh);
    check_near(view.inverse_masses[0], 0, 0);
    check_near(view.inverse_masses[4], 2, 0);
    check_near(pli_mesh_total_mass(mesh), 2, 1e-6);
    assert_int_equal(pli_mesh_set_density_from_tetras(mesh, 600), PLI_OK); /* 1/6 m^3 */
    check_near(pli_mesh_total_mass(mesh), 100, 1e-4);
    assert_int_equal(pli_mesh_set_density_from_faces(mesh, 1200), PLI_OK);
    check_near(pli_mesh_total_mass(mesh), 200, 1e-4);
    pli_mesh_destroy(mesh);
}

static void test_masses_that_cannot_be_given(void** state) {
    (void)state;
    pli_mesh* mesh = make_tetra();
    const float bad[] = {0, -1};
    for (int i = 0; i < 2; ++i) {
        check_refused(mesh, pli_mesh_set_total_mass(mesh, bad[i]), PLI_ERROR_INVALID_VALUE, "the mass is");
        check_refused(mesh, pli_mesh_set_total_mass_from_faces(mesh, bad[i]), PLI_ERROR_INVALID_VALUE, "the mass is");
        check_refused(mesh, pli_mesh_set_total_mass_from_tetras(mesh, bad[i]), PLI_ERROR_INVALID_VALUE, "the mass is");
        check_refused(mesh, pli_mesh_set_density_from_faces(mesh, bad[i]), PLI_ERROR_INVALID_VALUE, "density");
        check_refused(mesh, pli_mesh_set_density_from_tetras(mesh, bad[i]), PLI_ERROR_INVALID_VALUE, "density");
    }
    check_refused(mesh, pli_mesh_set_total_mass(mesh, NAN), PLI_ERROR_NOT_FINITE, "nan");
    check_refused(mesh, pli_mesh_set_total_mass(mesh, 1e-37f), PLI_ERROR_INVALID_VALUE, "inverse mass");
    check_refused(mesh, pli_mesh_set_total_mass_from_faces(mesh, 1e-37f), PLI_ERROR_INVALID_VALUE, "inverse mass");
    pli_mesh_scale(mesh, pli_vec3_make(1, 0, 1)); /* flat: no volume, but areas */
    check_refused(mesh, pli_mesh_set_density_from_faces(mesh, 1), PLI_ERROR_INVALID_MESH, "enclose 0 m^3");
    check_refused(mesh, pli_mesh_set_density_from_tetras(mesh, 1), PLI_ERROR_INVALID_MESH, "hold 0 m^3");
    check_refused(mesh, pli_mesh_set_total_mass_from_tetras(mesh, 1), PLI_ERROR_INVALID_MESH, "with a volume");
    pli_mesh_scale(mesh, pli_vec3_make(1, 1, 0)); /* a line */
    check_refused(mesh, pli_mesh_set_total_mass_from_faces(mesh, 1), PLI_ERROR_INVALID_MESH, "with an area");
    for (int i = 0; i < 5; ++i) {
        pli_mesh_set_node_mass(mesh, i, 0);
    }
    check_refused(mesh, pli_mesh_set_total_mass(mesh, 1), PLI_ERROR_INVALID_MESH, "all are pinned");
    pli_mesh_destroy(mesh);
}

static void test_motions_volume_and_bounds(void** state) {
    (void)state;
    pli_mesh* mesh = make_tetra();
    check_near(pli_mesh_volume(mesh), 1.0 / 6.0, 1e-8);
    pli_mesh_scale(mesh, pli_vec3_make(2, 3, 4));
    check_near(pli_mesh_volume(mesh), 4, 1e-6);
    pli_mesh_rotate(mesh, pli_quat_from_yaw_pitch_roll(0, 1.57079633f, 0)); /* y to z, z to -y */
    pli_mesh_translate(mesh, pli_vec3_make(10, 20, 30));
    check_near(pli_mesh_volume(mesh), 4, 1e-5);
    const pli_bounds bounds = pli_mesh_bounds(mesh);
    check_near(bounds.min.x, 10, 1e-5);
    check_near(bounds.min.y, 20 - 28, 1e-5);
    check_near(bounds.max.y, 20, 1e-5);
    check_near(bounds.max.z, 30 + 21, 1e-5);
    pli_transform bad = pli_transform_identity();
    bad.rotation.rows[1].z = NAN;
    const pli_quat zero = {0, 0, 0, 0};
    check_refused(mesh, pli_mesh_transform(mesh, bad), PLI_ERROR_NOT_FINITE, "transform");
    check_refused(mesh, pli_mesh_rotate(mesh, zero), PLI_ERROR_NOT_FINITE, "transform");
    check_refused(mesh, pli_mesh_translate(mesh, pli_vec3_make(0, INFINITY, 0)), PLI_ERROR_NOT_FINITE, "transform");
    check_refused(mesh, pli_mesh_scale(mesh, pli_vec3_make(1, NAN, 1)), PLI_ERROR_NOT_FINITE, "factors");
    check_refused(mesh, pli_mesh_scale(mesh, pli_vec3_make(FLT_MAX, 1, 1)), PLI_ERROR_NOT_FINITE, "range of float");
    bad = pli_transform_identity();
    bad.rotation.rows[0].x = FLT_MAX;
    check_refused(mesh, pli_mesh_transform(mesh, bad), PLI_ERROR_NOT_FINITE, "node 0 would leave the range");
    pli_mesh_destroy(mesh);
}

/* -------------------------------------------------------------------------------------------- out of memory */

/* A call on a mesh that exists: it must fail without changing the mesh, for every failing allocation in it. */
static void check_call_survives(pli_status (*call)(pli_mesh*)) {
    failing_allocator allocator;
    pli_context* own_context = failing_context(&allocator);
    pli_patch_def def = pli_patch_def_default();
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(own_context, &def, &mesh), PLI_OK);
    for (int n = 1;; ++n) {
        const uint64_t before = mesh_hash(mesh);
        const long alive = allocator.alive;
        allocator.fail_at = n;
        const pli_status status = call(mesh);
        if (status == PLI_OK) {
            assert_true(n > 1); /* the call does allocate */
            break;
        }
        assert_int_equal(status, PLI_ERROR_OUT_OF_MEMORY);
        assert_true(mesh_hash(mesh) == before);
        assert_int_equal(allocator.alive, alive);
    }
    allocator.fail_at = 0;
    pli_mesh_destroy(mesh);
    pli_context_destroy(own_context);
    assert_int_equal(allocator.alive, 0);
}

static pli_status call_bending(pli_mesh* mesh) {
    return pli_mesh_append_bending_links(mesh, 2, 0, NULL);
}
static pli_status call_mass(pli_mesh* mesh) {
    return pli_mesh_set_total_mass_from_faces(mesh, 3);
}
static pli_status call_interleave(pli_mesh* mesh) {
    return pli_mesh_interleave_links(mesh);
}
static pli_status call_clone(pli_mesh* mesh) {
    pli_mesh* copy = NULL;
    const pli_status status = pli_mesh_clone(mesh, &copy);
    pli_mesh_destroy(copy);
    return status;
}
/* Until the first failure, so that the array must grow at some time. */
static pli_status call_append_link(pli_mesh* mesh) {
    return pli_mesh_append_link(mesh, 0, 5, 0, NULL);
}
static pli_status call_append_tetra(pli_mesh* mesh) {
    return pli_mesh_append_tetra(mesh, 0, 5, 6, 7, 0, NULL);
}
static pli_status call_append_face(pli_mesh* mesh) {
    return pli_mesh_append_face(mesh, 0, 5, 6, 0, NULL);
}

static void test_out_of_memory_changes_nothing(void** state) {
    (void)state;
    check_call_survives(call_bending);
    check_call_survives(call_mass);
    check_call_survives(call_interleave);
    check_call_survives(call_clone);
    check_call_survives(call_append_link);
    check_call_survives(call_append_tetra);
    check_call_survives(call_append_face);
}

static pli_status build_by_hand(pli_context* own_context, void* user) {
    (void)user;
    pli_mesh* mesh = NULL;
    const pli_material material = {0.5f};
    pli_status status = pli_mesh_create(own_context, &mesh);
    if (status != PLI_OK) { return status; }
    for (int i = 0; status == PLI_OK && i < 40; ++i) {
        status = pli_mesh_append_node(mesh, pli_vec3_make((float)i, (float)(i * i), 0), 1, NULL);
        if (status == PLI_OK) { status = pli_mesh_append_material(mesh, &material, NULL); }
        if (status == PLI_OK && i > 2) { status = pli_mesh_append_face(mesh, i - 2, i - 1, i, 0, NULL); }
    }
    pli_mesh_destroy(mesh);
    return status;
}

static void test_out_of_memory_while_building(void** state) {
    (void)state;
    assert_in_range(check_survives_failing_allocator(build_by_hand, NULL), 8, 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_appends_give_indices_and_values),
        cmocka_unit_test(test_bad_appends_change_nothing),
        cmocka_unit_test(test_null_meshes_are_refused),
        cmocka_unit_test(test_empty_mesh_is_harmless),
        cmocka_unit_test(test_clone_is_equal_and_apart),
        cmocka_unit_test(test_bodies_share_faces_until_the_mesh_changes),
        cmocka_unit_test(test_bending_links_of_a_chain),
        cmocka_unit_test(test_bending_links_of_a_large_sheet),
        cmocka_unit_test(test_bending_links_of_a_star_are_in_order),
        cmocka_unit_test(test_shuffle_is_a_fixed_permutation),
        cmocka_unit_test(test_interleave_keeps_the_order_at_each_node),
        cmocka_unit_test(test_pins_and_loose_nodes_survive_mass_functions),
        cmocka_unit_test(test_masses_that_cannot_be_given),
        cmocka_unit_test(test_motions_volume_and_bounds),
        cmocka_unit_test(test_out_of_memory_changes_nothing),
        cmocka_unit_test(test_out_of_memory_while_building),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
