/* Convex hull of points, grown by a radius. Inside the hull the nearest side counts, outside the nearest triangle. */

#include "geometry/bvh.h"
#include "geometry/closest_point.h"
#include "geometry/convex_hull.h"
#include "math/bounds.h"
#include "math/range.h"
#include "shape/shape_impl.h"

/* Doubled area, of the longest edge squared, below which the normal is too rough for its plane to hold all points. */
#define HULL_ROUGH_TRIANGLE 1e-3f

typedef struct hull_plane {
    pli_vec3 normal; /* unit, outward */
    float offset;
} hull_plane;

typedef struct hull_data {
    pli_bounds bounds; /* first, see plii_shape_stored_bounds */
    pli_context* context;
    float radius;
    float noise; /* m, rounding of a coordinate */
    int point_count, triangle_count;
    pli_vec3* points; /* corners of the hull */
    int (*triangles)[3];
    hull_plane* planes; /* of the triangles */
    plii_bvh tree;
    int point_capacity, triangle_capacity; /* as was known before */
} hull_data;

static pli_vec3 hull_closest(const hull_data* hull, int triangle, pli_vec3 p) {
    const int* v = hull->triangles[triangle];
    plii_closest_feature closest;
    return plii_closest_point_on_triangle(p, hull->points[v[0]], hull->points[v[1]], hull->points[v[2]], &closest);
}
static float hull_measure(int triangle, pli_vec3 p, const void* user) {
    return pli_vec3_length_squared(pli_vec3_sub(p, hull_closest(user, triangle, p)));
}

static float hull_distance(const hull_data* hull, pli_vec3 p, float max_distance, pli_vec3* normal) {
    float height = -INFINITY;
    int side = 0;
    for (int i = 0; i < hull->triangle_count; ++i) {
        const float above = pli_vec3_dot(hull->planes[i].normal, p) - hull->planes[i].offset;
        if (above > height) {
            height = above;
            side = i;
        }
    }
    *normal = hull->planes[side].normal;
    if (height <= 0.0f || height - hull->radius > max_distance) { return height - hull->radius; }
    const int triangle = plii_bvh_nearest(&hull->tree, p, INFINITY, hull_measure, hull);
    if (triangle == PLI_NULL_INDEX) { return height - hull->radius; }
    const pli_vec3 offset = pli_vec3_sub(p, hull_closest(hull, triangle, p));
    const float length = pli_vec3_length(offset);
    /* Straight above a side its plane gives the better normal. */
    const pli_vec3 sideways = pli_vec3_sub(offset, pli_vec3_scale(*normal, height));
    if (pli_vec3_length(sideways) <= hull->noise + 4.0f * PLII_EPSILON * length) { return height - hull->radius; }
    *normal = plii_vec3_divide(offset, length);
    return length - hull->radius;
}

static void hull_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                           pli_vec3* normals) {
    for (int i = 0; i < count; ++i) {
        distances[i] = hull_distance(user, points[i], max_distance, &normals[i]);
    }
}

static pli_vec3 hull_support(const void* user, pli_vec3 direction) {
    const hull_data* hull = user;
    return plii_vec3_farthest(hull->point_count, hull->points, direction);
}

static float hull_plane_offset(const hull_data* hull, const int* triangle, pli_vec3 normal, bool is_rough) {
    float offset = -INFINITY;
    const int count = is_rough ? hull->point_count : 3;
    for (int i = 0; i < count; ++i) {
        offset = plii_max(offset, pli_vec3_dot(normal, hull->points[is_rough ? i : triangle[i]]));
    }
    return offset;
}

static void hull_copy_triangles(hull_data* hull, const plii_convex_hull* source, const int* map, pli_bounds* boxes) {
    for (int i = 0; i < source->triangle_count; ++i) {
        const int v[3] = {map[source->triangles[i][0]], map[source->triangles[i][1]], map[source->triangles[i][2]]};
        const pli_vec3 a = hull->points[v[0]], b = hull->points[v[1]], c = hull->points[v[2]];
        const plii_triangle_size size = plii_measure_triangle(a, b, c);
        if (!(size.doubled_area > FLT_MIN)) { continue; }
        const int index = hull->triangle_count++;
        memcpy(hull->triangles[index], v, sizeof v);
        boxes[index] = plii_bounds_of_triangle(a, b, c);
        const bool is_rough = size.doubled_area < HULL_ROUGH_TRIANGLE * size.longest_squared;
        hull->planes[index] = (hull_plane){size.normal, hull_plane_offset(hull, v, size.normal, is_rough)};
    }
}

static void hull_measure_extent(hull_data* hull) {
    float extent = 0.0f;
    for (int i = 0; i < hull->point_count; ++i) {
        extent = plii_max(extent, pli_vec3_length(hull->points[i]));
    }
    hull->bounds = plii_bounds_grow(plii_bounds_of_points(hull->point_count, hull->points), hull->radius);
    hull->noise = 4.0f * PLII_EPSILON * extent;
}

static bool hull_copy(hull_data* hull, const plii_convex_hull* source, int point_count, const pli_vec3* points) {
    plii_scratch scratch = {.context = hull->context};
    int* map = PLII_TAKE(&scratch, int, point_count);
    pli_bounds* boxes = PLII_TAKE(&scratch, pli_bounds, source->triangle_count);
    bool has_memory = !scratch.is_short && PLII_ALLOCATE(hull->context, &hull->points, point_count) &&
                      PLII_ALLOCATE(hull->context, &hull->triangles, source->triangle_count) &&
                      PLII_ALLOCATE(hull->context, &hull->planes, source->triangle_count);
    if (has_memory) {
        hull->point_count = plii_convex_hull_corners(source, point_count, map);
        for (int i = 0; i < point_count; ++i) {
            if (map[i] != PLI_NULL_INDEX) { hull->points[map[i]] = points[i]; }
        }
        hull_copy_triangles(hull, source, map, boxes);
        has_memory = plii_bvh_build(hull->context, &hull->tree, hull->triangle_count, boxes);
    }
    plii_scratch_free(&scratch);
    return has_memory;
}

static void hull_destroy(void* user) {
    hull_data* hull = user;
    PLII_RELEASE(hull->context, hull->points, hull->point_capacity);
    PLII_RELEASE(hull->context, hull->triangles, hull->triangle_capacity);
    PLII_RELEASE(hull->context, hull->planes, hull->triangle_capacity);
    plii_bvh_free(hull->context, &hull->tree);
}

pli_status pli_shape_create_convex_hull(pli_context* context, int point_count, const pli_vec3* points, float radius,
                                        pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    if (points == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "points is null"); }
    PLII_TRY(plii_check_between(context, radius, 0.0f, PLI_MAX_COORDINATE, "radius", __func__));
    PLII_TRY(plii_check_finite_points(context, point_count, points, "point", __func__));
    plii_convex_hull source = {0};
    PLII_TRY(plii_convex_hull_create(context, point_count, points, 0.0f, __func__, &source));
    hull_data hull = {.context = context,
                      .radius = radius,
                      .point_capacity = point_count,
                      .triangle_capacity = source.triangle_count};
    pli_status status = PLI_OK;
    if (!hull_copy(&hull, &source, point_count, points)) {
        status = PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for a hull of %d points", point_count);
    } else if (hull.triangle_count < 4) {
        status = PLII_FAIL(context, PLI_ERROR_INVALID_MESH, "the hull of the %d points has no volume", point_count);
    } else {
        hull_measure_extent(&hull);
        const pli_shape_def def = {.distances = hull_distances,
                                   .bounds = plii_shape_stored_bounds,
                                   .support = hull_support,
                                   .radius = radius,
                                   .destroy = hull_destroy};
        status = plii_shape_create_owning(context, PLII_SHAPE_OTHER, &def, &hull, sizeof hull, __func__, shape);
    }
    if (status != PLI_OK) { hull_destroy(&hull); }
    plii_convex_hull_destroy(context, &source);
    return status;
}
