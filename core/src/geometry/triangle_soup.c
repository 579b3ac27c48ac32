/* Triangles without connections: repeated and empty ones are sorted out, distances go through a tree. And welding. */

#include "geometry/triangle_soup.h"

#include "geometry/closest_point.h"
#include "math/bounds.h"

#include <stdlib.h>

static int soup_compare_corners(const void* left, const void* right) {
    const plii_soup_triangle *a = left, *b = right;
    for (int k = 0; k < 3; ++k) {
        const int order = plii_vec3_compare(a->corners[k], b->corners[k]);
        if (order != 0) { return order; }
    }
    return 0;
}

static void soup_order_pair(plii_soup_triangle* triangle, int i, int j) {
    if (plii_vec3_compare(triangle->corners[i], triangle->corners[j]) <= 0) { return; }
    PLII_SWAP(pli_vec3, triangle->corners[i], triangle->corners[j]);
    triangle->is_turned = !triangle->is_turned;
}

/* Those with an area, with their corners in ascending order. */
static void soup_collect(plii_soup* soup, const pli_vec3* points, int triangle_count, const int* triangles,
                         pli_vec3 origin, float scale) {
    for (int i = 0; i < triangle_count; ++i) {
        plii_soup_triangle* triangle = &soup->triangles[soup->count];
        *triangle = (plii_soup_triangle){.is_turned = false};
        for (int k = 0; k < 3; ++k) {
            triangle->corners[k] = pli_vec3_scale(pli_vec3_sub(points[triangles[3 * i + k]], origin), scale);
        }
        soup_order_pair(triangle, 0, 1);
        soup_order_pair(triangle, 1, 2);
        soup_order_pair(triangle, 0, 1);
        const pli_vec3* c = triangle->corners;
        if (plii_measure_triangle(c[0], c[1], c[2]).is_usable) { ++soup->count; }
    }
}

static void soup_keep_once(plii_soup* soup) {
    plii_soup_triangle* triangles = soup->triangles;
    const int count = soup->count;
    qsort(triangles, (size_t)count, sizeof *triangles, soup_compare_corners);
    soup->count = 0;
    for (int begin = 0, end = 0; begin < count; begin = end) {
        int parity = 0; /* of those with the same corners */
        for (; end < count && soup_compare_corners(&triangles[begin], &triangles[end]) == 0; ++end) {
            parity += triangles[end].is_turned ? -1 : 1;
        }
        if (parity == 0) { continue; }
        const pli_vec3 a = triangles[begin].corners[0], b = triangles[begin].corners[parity > 0 ? 1 : 2],
                       c = triangles[begin].corners[parity > 0 ? 2 : 1];
        triangles[soup->count++] = (plii_soup_triangle){.corners = {a, b, c}};
    }
}

static pli_bounds soup_box(int triangle, const void* user) {
    const pli_vec3* c = ((const plii_soup*)user)->triangles[triangle].corners;
    return plii_bounds_of_triangle(c[0], c[1], c[2]);
}

bool plii_soup_build(plii_soup* soup, const pli_vec3* points, int triangle_count, const int* triangles, pli_vec3 origin,
                     float scale) {
    if (!PLII_RESERVE(soup->context, &soup->triangles, &soup->capacity, triangle_count)) { return false; }
    soup_collect(soup, points, triangle_count, triangles, origin, scale);
    soup_keep_once(soup);
    return plii_bvh_build_from(soup->context, &soup->tree, soup->count, soup_box, soup);
}

void plii_soup_free(plii_soup* soup) {
    PLII_RELEASE(soup->context, soup->triangles, soup->capacity);
    plii_bvh_free(soup->context, &soup->tree);
}

static float soup_measure(int triangle, pli_vec3 point, const void* user) {
    const plii_soup_triangle* t = &((const plii_soup*)user)->triangles[triangle];
    if (t->is_hidden) { return FLT_MAX; }
    plii_closest_feature closest;
    const pli_vec3 foot = plii_closest_point_on_triangle(point, t->corners[0], t->corners[1], t->corners[2], &closest);
    return pli_vec3_length_squared(pli_vec3_sub(point, foot));
}

int plii_soup_nearest(const plii_soup* soup, pli_vec3 point, int guess, float* distance) {
    const float reach = guess != PLI_NULL_INDEX ? soup_measure(guess, point, soup) : FLT_MAX;
    int nearest = plii_bvh_nearest(&soup->tree, point, reach, soup_measure, soup);
    if (nearest == PLI_NULL_INDEX) { nearest = guess; }
    *distance = nearest != PLI_NULL_INDEX ? sqrtf(soup_measure(nearest, point, soup)) : INFINITY;
    return nearest;
}

typedef struct weld_point {
    pli_vec3 position;
    int index;
} weld_point;

static int weld_compare(const void* left, const void* right) {
    const weld_point *a = left, *b = right;
    const int order = plii_vec3_compare(a->position, b->position);
    return order != 0 ? order : (a->index > b->index) - (a->index < b->index);
}

int plii_weld_points(pli_context* context, int count, const pli_vec3* points, int* places) {
    weld_point* sorted = NULL;
    if (!PLII_ALLOCATE(context, &sorted, count)) { return PLI_NULL_INDEX; }
    for (int i = 0; i < count; ++i) {
        sorted[i] = (weld_point){points[i], i};
    }
    qsort(sorted, (size_t)count, sizeof *sorted, weld_compare);
    for (int i = 0; i < count; ++i) {
        const bool is_first = i == 0 || plii_vec3_compare(sorted[i].position, sorted[i - 1].position) != 0;
        places[sorted[i].index] = is_first ? sorted[i].index : places[sorted[i - 1].index];
    }
    PLII_RELEASE(context, sorted, count);
    int place_count = 0;
    for (int i = 0; i < count; ++i) {
        places[i] = places[i] == i ? place_count++ : places[places[i]];
    }
    return place_count;
}
