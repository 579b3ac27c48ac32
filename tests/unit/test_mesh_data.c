/* The mesh in demos/data: counts, closed and manifold surface, outward faces, size and place. */

#include "check.h"

#include <pliant/io.h>

#include <stdlib.h>
#include <string.h>

#define NODES 453
#define FACES 902

static int compare_edges(const void* a, const void* b) {
    return memcmp(a, b, 2 * sizeof(int));
}

static void bunny_is_a_closed_surface(void** state) {
    (void)state;
    pli_context* context = NULL;
    pli_triangles bunny;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    assert_int_equal(pli_triangles_read_obj(context, PLIANT_DATA_DIR "/bunny.obj", &bunny), PLI_OK);
    assert_int_equal(bunny.point_count, NODES);
    assert_int_equal(bunny.triangle_count, FACES);

    /* Each directed edge once, and its opposite once: closed, of one orientation, no edge with more than two faces. */
    static int edges[3 * FACES][2];
    for (int i = 0; i < 3 * FACES; ++i) {
        edges[i][0] = bunny.indices[i];
        edges[i][1] = bunny.indices[i % 3 == 2 ? i - 2 : i + 1];
    }
    qsort(edges, 3 * FACES, sizeof edges[0], compare_edges);
    for (int i = 0; i < 3 * FACES; ++i) {
        const int opposite[2] = {edges[i][1], edges[i][0]};
        if (i > 0) { assert_memory_not_equal(edges[i - 1], edges[i], sizeof edges[0]); }
        assert_non_null(bsearch(opposite, edges, 3 * FACES, sizeof edges[0], compare_edges));
    }
    static int faces_around[NODES], fan[NODES];
    for (int i = 0; i < 3 * FACES; ++i) {
        ++faces_around[bunny.indices[i]];
    }
    /* The faces around a node, walked from one to the next, come back to the first after all of them: one fan. */
    for (int i = 0; i < 3 * FACES; ++i) {
        const int center = bunny.indices[i], first = bunny.indices[i % 3 == 2 ? i - 2 : i + 1];
        int at = first, steps = 0;
        do {
            for (int j = 0; j < 3 * FACES; ++j) {
                if (bunny.indices[j] == center && bunny.indices[j % 3 == 2 ? j - 2 : j + 1] == at) {
                    at = bunny.indices[j % 3 == 0 ? j + 2 : j - 1];
                    break;
                }
            }
        } while (++steps < FACES && at != first);
        fan[center] = steps;
    }
    for (int i = 0; i < NODES; ++i) {
        assert_true(faces_around[i] >= 3);
        assert_int_equal(fan[i], faces_around[i]);
    }
    pli_triangles_destroy(&bunny);
    pli_context_destroy(context);
}

static void bunny_has_size_and_place(void** state) {
    (void)state;
    pli_context* context = NULL;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    assert_int_equal(pli_mesh_read_obj(context, PLIANT_DATA_DIR "/bunny.obj", &mesh), PLI_OK);
    assert_int_equal(pli_mesh_get_view(mesh).link_count, 3 * FACES / 2);
    check_near(pli_mesh_volume(mesh), 0.6380, 1e-4); /* positive: outward */
    const pli_bounds bounds = pli_mesh_bounds(mesh);
    check_near(bounds.max.y - bounds.min.y, 1.443, 1e-5);
    check_near(0.5f * (bounds.min.x + bounds.max.x), 0, 1e-5);
    check_near(0.5f * (bounds.min.y + bounds.max.y), 0.055, 1e-5);
    check_near(0.5f * (bounds.min.z + bounds.max.z), 0.028, 1e-5);
    pli_mesh_destroy(mesh);
    pli_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bunny_is_a_closed_surface),
        cmocka_unit_test(bunny_has_size_and_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
