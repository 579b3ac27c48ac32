#ifndef TESTS_SAMPLE_MESH_H
#define TESTS_SAMPLE_MESH_H

/* Meshes that several tests use. For C and C++. */

#include <pliant/generate.h>

enum { SAMPLE_RINGS = 7, SAMPLE_SEGMENTS = 12, SAMPLE_SPHERE_NODES = 2 + SAMPLE_RINGS * SAMPLE_SEGMENTS };

/* Index of a point on a ring; segments wrap round. */
static inline int sample_sphere_node(int ring, int segment) {
    return 1 + ring * SAMPLE_SEGMENTS + segment % SAMPLE_SEGMENTS;
}

static inline int sample_append_triangle(int* triangles, int count, int a, int b, int c) {
    triangles[3 * count] = a;
    triangles[3 * count + 1] = b;
    triangles[3 * count + 2] = c;
    return count + 1;
}

/* A closed surface of rings on an ellipsoid round the origin, faces outward, a link per edge; 1 kg per node. */
static inline pli_status sample_create_ellipsoid(pli_context* context, pli_vec3 radii, pli_mesh** mesh) {
    pli_vec3 points[SAMPLE_SPHERE_NODES];
    int triangles[3 * 2 * SAMPLE_SEGMENTS * SAMPLE_RINGS];
    int count = 0;
    const float pi = 3.14159265f;
    const int last = SAMPLE_SPHERE_NODES - 1;
    points[0] = pli_vec3_make(0, radii.y, 0);
    points[last] = pli_vec3_make(0, -radii.y, 0);
    for (int r = 0; r < SAMPLE_RINGS; ++r) {
        const float polar = pi * (float)(r + 1) / (float)(SAMPLE_RINGS + 1);
        for (int s = 0; s < SAMPLE_SEGMENTS; ++s) {
            const float turn = 2.0f * pi * (float)s / (float)SAMPLE_SEGMENTS;
            points[sample_sphere_node(r, s)] = pli_vec3_make(radii.x * sinf(polar) * cosf(turn), radii.y * cosf(polar),
                                                             radii.z * sinf(polar) * sinf(turn));
        }
    }
    for (int s = 0; s < SAMPLE_SEGMENTS; ++s) {
        const int next = s + 1;
        count = sample_append_triangle(triangles, count, 0, sample_sphere_node(0, next), sample_sphere_node(0, s));
        for (int r = 0; r + 1 < SAMPLE_RINGS; ++r) {
            const int a = sample_sphere_node(r, s), b = sample_sphere_node(r, next);
            const int c = sample_sphere_node(r + 1, s), d = sample_sphere_node(r + 1, next);
            count = sample_append_triangle(triangles, count, a, b, c);
            count = sample_append_triangle(triangles, count, b, d, c);
        }
        count = sample_append_triangle(triangles, count, last, sample_sphere_node(SAMPLE_RINGS - 1, s),
                                       sample_sphere_node(SAMPLE_RINGS - 1, next));
    }
    return pli_mesh_create_from_triangles(context, SAMPLE_SPHERE_NODES, points, count, triangles, false, mesh);
}

/* 1 m by 0.4 m by 1 m on the plane y = 0: cubes of six tetrahedra, whose links are askew in one direction. */
static inline pli_status sample_create_slab(pli_context* context, pli_mesh** mesh) {
    enum { SIDE = 6, LAYERS = 4, NODES = SIDE * LAYERS * SIDE, CUBES = (SIDE - 1) * (LAYERS - 1) * (SIDE - 1) };
    static const int corners[24] = {0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7};
    pli_vec3 points[NODES];
    int tetras[24 * CUBES], count = 0;
    for (int n = 0; n < NODES; ++n) {
        const int x = n / (LAYERS * SIDE), y = n / SIDE % LAYERS, z = n % SIDE;
        points[n] = pli_vec3_make((float)x / 5.0f - 0.5f, 0.4f * (float)y / 3.0f, (float)z / 5.0f - 0.5f);
        for (int k = 0; x + 1 < SIDE && y + 1 < LAYERS && z + 1 < SIDE && k < 24; ++k) {
            const int c = corners[k];
            tetras[count++] = n + (c & 1) * LAYERS * SIDE + (c >> 1 & 1) * SIDE + (c >> 2);
        }
    }
    return pli_mesh_create_from_tetras(context, NODES, points, 6 * CUBES, tetras, mesh);
}

/* A sheet of `nodes` x `nodes` nodes and 0.5 m cells at height `y`, with diagonals. */
static inline pli_status sample_create_sheet(pli_context* context, int nodes, float y, int pins, pli_mesh** mesh) {
    const float half = 0.25f * (float)(nodes - 1);
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-half, y, -half);
    def.corner_10 = pli_vec3_make(half, y, -half);
    def.corner_01 = pli_vec3_make(-half, y, half);
    def.corner_11 = pli_vec3_make(half, y, half);
    def.columns = def.rows = nodes;
    def.pins = pins;
    def.diagonals = true;
    return pli_mesh_create_patch(context, &def, mesh);
}

#endif
