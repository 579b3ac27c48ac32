/* Pairs of triangles that cross: an edge of one goes through the other. */

#include "body/body_impl.h"
#include "geometry/bvh.h"
#include "geometry/orient3d.h"
#include "pliant/self_collision.h"

static bool crossings_edge_through(pli_vec3 p, pli_vec3 q, const pli_vec3 t[3]) {
    if (plii_orient3d(t[0], t[1], t[2], p) * plii_orient3d(t[0], t[1], t[2], q) >= 0) { return false; }
    const int side = plii_orient3d(p, q, t[0], t[1]);
    return side != 0 && plii_orient3d(p, q, t[1], t[2]) == side && plii_orient3d(p, q, t[2], t[0]) == side;
}

typedef struct crossings_search {
    const pli_body* body;
    int face, count;
} crossings_search;

static void crossings_corners(const pli_body* body, int face, pli_vec3 corners[3]) {
    for (int k = 0; k < 3; ++k) {
        corners[k] = plii_xyz(body->positions[body->topology->faces[face][k]]);
    }
}

static void crossings_test(int other, void* user) {
    crossings_search* search = user;
    const int(*faces)[3] = (const int(*)[3])search->body->topology->faces;
    if (other <= search->face) { return; }
    for (int k = 0; k < 9; ++k) {
        if (faces[search->face][k / 3] == faces[other][k % 3]) { return; }
    }
    pli_vec3 a[3], b[3];
    crossings_corners(search->body, search->face, a);
    crossings_corners(search->body, other, b);
    bool is_crossing = false;
    for (int k = 0; k < 3 && !is_crossing; ++k) {
        is_crossing =
            crossings_edge_through(a[k], a[(k + 1) % 3], b) || crossings_edge_through(b[k], b[(k + 1) % 3], a);
    }
    search->count += is_crossing;
}

pli_status pli_body_count_crossings(const pli_body* body, int* count) {
    PLII_TRY(plii_check_body(body, __func__));
    if (count == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "count is null"); }
    const int face_count = body->topology->face_count;
    plii_bvh tree = {0};
    const bool has_memory = plii_bvh_build_from(body->context, &tree, face_count, plii_body_face_box, body);
    crossings_search search = {body, 0, 0};
    for (; has_memory && search.face < face_count; ++search.face) {
        plii_bvh_overlaps(&tree, plii_body_face_box(search.face, body), crossings_test, &search);
    }
    plii_bvh_free(body->context, &tree);
    if (!has_memory) { return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory to look for crossings"); }
    *count = search.count;
    return PLI_OK;
}
