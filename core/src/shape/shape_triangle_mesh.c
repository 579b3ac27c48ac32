/* Triangle surface: distance to the nearest triangle, sign by the angle-weighted pseudo-normal of the nearest vertex,
   edge or face (Baerentzen and Aanaes, Signed distance computation using the angle weighted pseudonormal, 2005).
   Points at equal positions count as one, so that unconnected triangles still make a surface. A connected part without
   a border is solid. A part with a border is a floor: its border never has an inside, and behind its faces only the
   first `thickness` is inside; farther behind there is nothing. */

#include "base/edge_map.h"
#include "base/union_find.h"
#include "geometry/closest_point.h"
#include "geometry/pair_cache.h"
#include "geometry/triangle_soup.h"
#include "math/bounds.h"
#include "math/range.h"
#include "shape/shape_impl.h"

/* Measuring that many one by one costs about as much as a walk through the tree. */
#define SURFACE_MAX_CANDIDATES 12
#define SURFACE_BOX_REACH 1.01f /* more than the reach, as planes of boxes are rounded */
/* Of the squared distance to the nearest triangle until now: other triangles of its plane are not looked at. */
#define SURFACE_SAME_PLANE 0.9999f
#define SURFACE_MIN_SUM 1e-6f /* of normals: shorter ones have no direction */

typedef struct surface_triangle {
    int vertices[3];
    pli_vec3 normal;          /* unit */
    pli_vec3 edge_normals[3]; /* unit; edges 01, 12, 20 */
    bool is_edge_border[3];
    bool is_open; /* part of a surface with a border */
} surface_triangle;

typedef struct surface_vertex {
    pli_vec3 position;
    pli_vec3 normal; /* unit pseudo-normal */
    bool is_border;
} surface_vertex;

typedef struct surface_data {
    pli_bounds bounds; /* first, see plii_shape_stored_bounds */
    pli_context* context;
    float thickness;
    float noise; /* m, rounding of a difference of coordinates: closer points have no direction of their own */
    bool has_closed_part, has_open_part;
    int vertex_count, triangle_count;
    surface_vertex* vertices;
    surface_triangle* triangles;
    plii_bvh tree;
    int vertex_capacity, triangle_capacity; /* as was asked for */
} surface_data;

// ------------------------------------------------------------------------------------------------------- queries

static pli_vec3 surface_closest(const surface_data* surface, int triangle, pli_vec3 p, plii_closest_feature* closest) {
    const int* v = surface->triangles[triangle].vertices;
    return plii_closest_point_on_triangle(p, surface->vertices[v[0]].position, surface->vertices[v[1]].position,
                                          surface->vertices[v[2]].position, closest);
}
static float surface_measure(int triangle, pli_vec3 p, const void* user) {
    plii_closest_feature closest;
    return pli_vec3_length_squared(pli_vec3_sub(p, surface_closest(user, triangle, p, &closest)));
}

/* Triangles near a batch of points, so that the tree is walked once and not for each point. */
typedef struct surface_candidates {
    const surface_data* surface;
    pli_vec3 middle, half; /* of the box around the points */
    float reach;           /* what is farther from all of them is left out */
    int count;             /* more than there is room for: the tree has to be asked */
    int triangles[SURFACE_MAX_CANDIDATES];
    /* Planes of four at a time: unit normals, and offsets so that dot(normal, p - middle) - offset is the height. */
    float normals[3][SURFACE_MAX_CANDIDATES], offsets[SURFACE_MAX_CANDIDATES];
} surface_candidates;

static void surface_add_candidate(int triangle, void* user) {
    surface_candidates* candidates = user;
    const surface_data* surface = candidates->surface;
    const surface_triangle* found = &surface->triangles[triangle];
    const pli_vec3 n = found->normal, corner = surface->vertices[found->vertices[0]].position;
    const float height = pli_vec3_dot(pli_vec3_sub(candidates->middle, corner), n);
    const float spread = pli_vec3_dot(candidates->half, pli_vec3_make(fabsf(n.x), fabsf(n.y), fabsf(n.z)));
    /* The whole box lies on one side of the triangle's plane. */
    if (fabsf(height) - spread > candidates->reach) { return; }
    const int place = candidates->count++;
    if (place >= SURFACE_MAX_CANDIDATES) { return; }
    candidates->triangles[place] = triangle;
    candidates->normals[0][place] = n.x;
    candidates->normals[1][place] = n.y;
    candidates->normals[2][place] = n.z;
    candidates->offsets[place] = -height;
}

/* Into the place where they are used: there is much of them to copy. */
static void surface_find_candidates(const surface_data* surface, int count, const pli_vec3* points, float reach,
                                    surface_candidates* candidates) {
    const pli_bounds near = plii_bounds_of_points(count, points);
    candidates->surface = surface;
    candidates->middle = pli_vec3_scale(pli_vec3_add(near.min, near.max), 0.5f);
    candidates->half = pli_vec3_sub(near.max, candidates->middle);
    candidates->reach = SURFACE_BOX_REACH * reach;
    candidates->count = 0;
    plii_bvh_overlaps(&surface->tree, plii_bounds_grow(near, reach), surface_add_candidate, candidates);
    for (int i = candidates->count; i < SURFACE_MAX_CANDIDATES && i % PLII_LANES != 0; ++i) { /* nowhere near */
        candidates->normals[0][i] = candidates->normals[1][i] = candidates->normals[2][i] = 0.0f;
        candidates->offsets[i] = INFINITY;
    }
}

static int surface_nearest_candidate(const surface_candidates* candidates, pli_vec3 p, float max_squared) {
    const plii_vec3x4 q = plii_vec3x4_all(pli_vec3_sub(p, candidates->middle));
    float plane_squared = 1.001f * max_squared; /* triangles whose planes are farther are not nearer */
    int nearest = PLI_NULL_INDEX;
    for (int i = 0; i < candidates->count; i += PLII_LANES) {
        const plii_vec3x4 normals = {plii_float4_load(&candidates->normals[0][i]),
                                     plii_float4_load(&candidates->normals[1][i]),
                                     plii_float4_load(&candidates->normals[2][i])};
        const plii_float4 heights = plii_vec3x4_dot(normals, q) - plii_float4_load(&candidates->offsets[i]);
        const plii_float4 squares = heights * heights;
        for (int near = plii_lanes_bits(squares < plane_squared); near != 0; near &= near - 1) {
            const int lane = __builtin_ctz((unsigned)near), triangle = candidates->triangles[i + lane];
            if (squares[lane] >= plane_squared) { continue; }
            const float squared = surface_measure(triangle, p, candidates->surface);
            if (!(squared < max_squared)) { continue; }
            nearest = triangle;
            max_squared = squared;
            plane_squared = SURFACE_SAME_PLANE * squared;
        }
    }
    return nearest;
}

static float surface_distance(const surface_data* surface, pli_vec3 p, int nearest, pli_vec3* normal) {
    const surface_triangle* triangle = &surface->triangles[nearest];
    plii_closest_feature closest;
    const pli_vec3 foot = surface_closest(surface, nearest, p, &closest);
    const plii_triangle_feature feature = closest.feature;
    const pli_vec3 offset = pli_vec3_sub(p, foot);
    pli_vec3 pseudo_normal = triangle->normal;
    bool is_border = false;
    if (feature <= PLII_TRIANGLE_VERTEX_2) {
        const surface_vertex* vertex = &surface->vertices[triangle->vertices[feature]];
        pseudo_normal = vertex->normal;
        is_border = vertex->is_border;
    } else if (feature <= PLII_TRIANGLE_EDGE_20) {
        const int edge = (int)feature - (int)PLII_TRIANGLE_EDGE_01;
        pseudo_normal = triangle->edge_normals[edge];
        is_border = triangle->is_edge_border[edge];
    }

    const float length = pli_vec3_length(offset);
    const float along = pli_vec3_dot(offset, pseudo_normal);
    float distance = along;
    *normal = pseudo_normal;
    if (feature != PLII_TRIANGLE_FACE && length > surface->noise) {
        distance = along < 0.0f && !is_border ? -length : length;
        *normal = pli_vec3_scale(offset, 1.0f / distance);
    }
    return distance < -surface->thickness && triangle->is_open ? INFINITY : distance;
}

static void surface_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                              pli_vec3* normals) {
    const surface_data* surface = user;
    /* The inside of a closed part may be far from its surface. */
    const bool has_reach = !surface->has_closed_part;
    const float reach = has_reach ? 1.001f * plii_max(max_distance, surface->thickness) : INFINITY;
    const pli_bounds near = plii_bounds_grow(surface->bounds, max_distance);
    surface_candidates candidates;
    candidates.count = SURFACE_MAX_CANDIDATES + 1;
    if (has_reach && count > 0) { surface_find_candidates(surface, count, points, reach, &candidates); }
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        normals[i] = pli_vec3_make(1, 0, 0);
        distances[i] = INFINITY;
        if (candidates.count == 0 || !plii_bounds_overlap(near, (pli_bounds){p, p})) { continue; }
        const int nearest = candidates.count <= SURFACE_MAX_CANDIDATES
                                ? surface_nearest_candidate(&candidates, p, reach * reach)
                                : plii_bvh_nearest(&surface->tree, p, reach * reach, surface_measure, surface);
        if (nearest != PLI_NULL_INDEX) { distances[i] = surface_distance(surface, p, nearest, &normals[i]); }
    }
}

typedef struct surface_visit {
    const surface_data* surface;
    plii_shape_triangle_fn* visit;
    void* context;
} surface_visit;

static void surface_visit_triangle(int item, void* user) {
    const surface_visit* visit = user;
    const surface_triangle* triangle = &visit->surface->triangles[item];
    plii_shape_triangle found = {.index = item, .normal = triangle->normal};
    for (int k = 0; k < 3; ++k) {
        found.corners[k] = visit->surface->vertices[triangle->vertices[k]].position;
    }
    visit->visit(&found, visit->context);
}

static void surface_triangles(const void* user, pli_bounds box, plii_shape_triangle_fn* visit, void* context) {
    surface_visit all = {user, visit, context};
    plii_bvh_overlaps(&((const surface_data*)user)->tree, box, surface_visit_triangle, &all);
}

// ------------------------------------------------------------------------------------------------------ building

/* One vertex per position; `vertex_of_point` [point_count] receives where each point went. */
static bool surface_weld(surface_data* surface, int point_count, const pli_vec3* points, int* vertex_of_point) {
    surface->vertex_count = plii_weld_points(surface->context, point_count, points, vertex_of_point);
    for (int i = point_count - 1; i >= 0 && surface->vertex_count > 0; --i) {
        surface->vertices[vertex_of_point[i]].position = points[i];
    }
    return surface->vertex_count >= 0;
}

static float surface_corner_angle(pli_vec3 a, pli_vec3 b, pli_vec3 c) {
    const pli_vec3 u = pli_vec3_sub(b, a), v = pli_vec3_sub(c, a);
    return atan2f(pli_vec3_length(pli_vec3_cross(u, v)), pli_vec3_dot(u, v));
}

/* The same for all triangles with these corners that face the same way. */
static plii_pair_key surface_triangle_key(const int v[3]) {
    const int first = v[0] < v[1] && v[0] < v[2] ? 0 : v[1] < v[2] ? 1 : 2;
    return (plii_pair_key){v[first], v[(first + 1) % 3], NULL, v[(first + 2) % 3]};
}

/* Triangles with an area, their normals and the weighted sums at the vertices; the edges of all, with the number of
   triangles in `flags`, and the sums of their normals. Triangles without an area have edges too, or their neighbours
   would seem to end there; those that come again have none, or a border would seem to go on. `known`: indices of
   triangles by key. False when out of memory. */
static bool surface_add_triangles(surface_data* surface, int triangle_count, const int* triangles,
                                  const int* vertex_of_point, plii_key_table* known, plii_edge_map* edges,
                                  pli_vec3* edge_sums) {
    for (int i = 0; i < triangle_count; ++i) {
        const int v[3] = {vertex_of_point[triangles[3 * i]], vertex_of_point[triangles[3 * i + 1]],
                          vertex_of_point[triangles[3 * i + 2]]};
        const pli_vec3 a = surface->vertices[v[0]].position, b = surface->vertices[v[1]].position,
                       c = surface->vertices[v[2]].position;
        const plii_triangle_size size = plii_measure_triangle(a, b, c);
        const pli_vec3 normal = size.is_usable ? size.normal : pli_vec3_make(0, 0, 0);
        if (size.is_usable) {
            const plii_pair_key key = surface_triangle_key(v);
            const int index = plii_key_table_add(known, plii_pair_key_hash(key), surface->triangle_count);
            if (index == PLI_NULL_INDEX) { return false; }
            const bool is_known = index < surface->triangle_count;
            if (is_known && plii_pair_keys_equal(surface_triangle_key(surface->triangles[index].vertices), key)) {
                continue;
            }
        }
        for (int k = 0; k < 3; ++k) {
            if (v[k] == v[(k + 1) % 3]) { continue; }
            plii_edge* edge = plii_edge_map_add(edges, v[k], v[(k + 1) % 3]);
            if (edge == NULL) { return false; }
            edge->flags += 1;
            edge_sums[edge - edges->edges] = pli_vec3_add(edge_sums[edge - edges->edges], normal);
        }
        if (!size.is_usable) { continue; }
        surface_triangle* triangle = &surface->triangles[surface->triangle_count++];
        triangle->normal = normal;
        const float angles[3] = {surface_corner_angle(a, b, c), surface_corner_angle(b, c, a),
                                 surface_corner_angle(c, a, b)};
        for (int k = 0; k < 3; ++k) {
            surface_vertex* vertex = &surface->vertices[v[k]];
            triangle->vertices[k] = v[k];
            vertex->normal = pli_vec3_add(vertex->normal, pli_vec3_scale(normal, angles[k]));
        }
    }
    return true;
}

/* Normals and flags of the edges; borders of the vertices; `parents` becomes the forest of connected parts. */
static void surface_join_edges(surface_data* surface, const plii_edge_map* edges, const pli_vec3* edge_sums,
                               int* parents) {
    plii_union_start(surface->vertex_count, parents);
    for (PLII_EACH(const plii_edge, edge, edges->edges, edges->count)) {
        plii_union_join(parents, edge->a, edge->b);
        if (edge->flags == 1) { surface->vertices[edge->a].is_border = surface->vertices[edge->b].is_border = true; }
    }
    for (PLII_EACH(surface_triangle, triangle, surface->triangles, surface->triangle_count)) {
        for (int k = 0; k < 3; ++k) {
            const plii_edge* edge = plii_edge_map_find(edges, triangle->vertices[k], triangle->vertices[(k + 1) % 3]);
            triangle->edge_normals[k] =
                plii_vec3_unit_or(edge_sums[edge - edges->edges], SURFACE_MIN_SUM, triangle->normal);
            triangle->is_edge_border[k] = edge->flags == 1;
        }
    }
}

/* A part is open when one of its vertices is on a border. */
static void surface_find_open_parts(surface_data* surface, int* parents, bool* is_open) {
    plii_union_flatten(surface->vertex_count, parents);
    for (int i = 0; i < surface->vertex_count; ++i) {
        if (surface->vertices[i].is_border) { is_open[parents[i]] = true; }
    }
    for (PLII_EACH(surface_triangle, triangle, surface->triangles, surface->triangle_count)) {
        triangle->is_open = is_open[parents[triangle->vertices[0]]];
        surface->has_closed_part = surface->has_closed_part || !triangle->is_open;
        surface->has_open_part = surface->has_open_part || triangle->is_open;
    }
}

static pli_bounds surface_box(int triangle, const void* user) {
    const surface_data* surface = user;
    const int* v = surface->triangles[triangle].vertices;
    return plii_bounds_of_triangle(surface->vertices[v[0]].position, surface->vertices[v[1]].position,
                                   surface->vertices[v[2]].position);
}

static bool surface_build_tree(surface_data* surface) {
    if (!plii_bvh_build_from(surface->context, &surface->tree, surface->triangle_count, surface_box, surface)) {
        return false;
    }
    float extent = 0.0f;
    for (int i = 0; i < 3 * surface->triangle_count; ++i) {
        const int vertex = surface->triangles[i / 3].vertices[i % 3];
        extent = plii_max(extent, pli_vec3_length(surface->vertices[vertex].position));
    }
    /* The inside of an open part reaches behind its faces. */
    surface->bounds =
        plii_bounds_grow(plii_bvh4_bounds(&surface->tree.boxes), surface->has_open_part ? surface->thickness : 0.0f);
    surface->noise = 4.0f * PLII_EPSILON * extent;
    return true;
}

/* False when out of memory. With no usable triangle there is no tree. */
static bool surface_build(surface_data* surface, int point_count, const pli_vec3* points, int triangle_count,
                          const int* triangles) {
    plii_scratch scratch = {.context = surface->context};
    plii_edge_map edges = {.table.context = surface->context};
    plii_key_table known = {.context = surface->context};
    int* map = PLII_TAKE(&scratch, int, point_count); /* vertex of point, then forest of parts */
    pli_vec3* edge_sums = PLII_TAKE(&scratch, pli_vec3, (size_t)triangle_count * 3);
    bool* is_open = PLII_TAKE(&scratch, bool, point_count); /* by root of a part */
    bool is_built = !scratch.is_short && PLII_ALLOCATE(surface->context, &surface->vertices, point_count) &&
                    PLII_ALLOCATE(surface->context, &surface->triangles, triangle_count) &&
                    surface_weld(surface, point_count, points, map) &&
                    surface_add_triangles(surface, triangle_count, triangles, map, &known, &edges, edge_sums);
    if (is_built) {
        surface_join_edges(surface, &edges, edge_sums, map);
        for (int i = 0; i < surface->vertex_count; ++i) {
            surface->vertices[i].normal =
                plii_vec3_unit_or(surface->vertices[i].normal, SURFACE_MIN_SUM, pli_vec3_make(1, 0, 0));
        }
        surface_find_open_parts(surface, map, is_open);
        is_built = surface->triangle_count == 0 || surface_build_tree(surface);
    }
    plii_key_table_free(&known);
    plii_edge_map_free(&edges);
    plii_scratch_free(&scratch);
    return is_built;
}

static void surface_destroy(void* user) {
    surface_data* surface = user;
    PLII_RELEASE(surface->context, surface->vertices, surface->vertex_capacity);
    PLII_RELEASE(surface->context, surface->triangles, surface->triangle_capacity);
    plii_bvh_free(surface->context, &surface->tree);
}

pli_status pli_shape_create_triangle_mesh(pli_context* context, int point_count, const pli_vec3* points,
                                          int triangle_count, const int* triangles, float thickness,
                                          pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(plii_shape_check_triangles(context, point_count, points, triangle_count, triangles, __func__));
    PLII_TRY(plii_check_between(context, thickness, PLII_ABOVE_0, PLI_MAX_COORDINATE, "thickness", __func__));
    surface_data surface = {.context = context,
                            .thickness = thickness,
                            .vertex_capacity = point_count,
                            .triangle_capacity = triangle_count};
    pli_status status = PLI_OK;
    if (!surface_build(&surface, point_count, points, triangle_count, triangles)) {
        status = PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d triangles", triangle_count);
    } else if (surface.triangle_count == 0) {
        status = PLII_FAIL(context, PLI_ERROR_INVALID_MESH, "none of the %d triangles has an area", triangle_count);
    } else {
        const pli_shape_def def = {
            .distances = surface_distances, .bounds = plii_shape_stored_bounds, .destroy = surface_destroy};
        status = plii_shape_create_owning(context, PLII_SHAPE_OTHER, &def, &surface, sizeof surface, __func__, shape);
        if (status == PLI_OK) { (*shape)->triangles = surface_triangles; }
    }
    if (status != PLI_OK) { surface_destroy(&surface); }
    return status;
}
