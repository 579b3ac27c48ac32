/* The solid inside of triangles by distances on a dense grid (sdf_grid.c), trilinear; normals are its gradient. */

#include "geometry/triangle_soup.h"
#include "math/bounds.h"
#include "math/definition.h"
#include "shape/shape_impl.h"

/* Cells of padding when the user names none, and the least. */
#define SAMPLED_MESH_PADDING 4.0
#define SAMPLED_MESH_MIN_PADDING 1.0
#define SAMPLED_MESH_DIAGONAL_CELLS 64.0
/* Gradients shorter than this have no direction; that of a distance has length 1. */
#define SAMPLED_MESH_MIN_GRADIENT 1e-3f

typedef struct sampled_mesh {
    pli_bounds bounds; /* of the solid; first, see plii_shape_stored_bounds */
    pli_context* context;
    pli_vec3 origin; /* of sample (0, 0, 0) */
    float cell_size, inverse_cell_size;
    int counts[3];  /* of samples along each axis */
    float* samples; /* distances in cells, as plii_soup_sample gives them */
} sampled_mesh;

PLII_DEFINE_DEFAULT(pli_sampled_mesh_def, 0)

/* The cell of a coordinate within the grid, and how far along it. */
static int sampled_mesh_cell(float coordinate, int count, float* fraction) {
    const int cell = (int)coordinate < count - 1 ? (int)coordinate : count - 2;
    *fraction = coordinate - (float)cell;
    return cell;
}

/* Distance in cells and its gradient at a point of the grid, in cells. */
static float sampled_mesh_interpolate(const sampled_mesh* mesh, pli_vec3 p, pli_vec3* gradient) {
    pli_vec3 f;
    const size_t i = (size_t)sampled_mesh_cell(p.x, mesh->counts[0], &f.x);
    const size_t j = (size_t)sampled_mesh_cell(p.y, mesh->counts[1], &f.y);
    const size_t k = (size_t)sampled_mesh_cell(p.z, mesh->counts[2], &f.z);
    const size_t row = (size_t)mesh->counts[0], layer = row * (size_t)mesh->counts[1];
    const float* low = mesh->samples + i + row * j + layer * k;
    const float* high = low + layer;
    const float corners[8] = {low[0], low[1], low[row + 1], low[row], high[0], high[1], high[row + 1], high[row]};
    return plii_shape_interpolate(corners, f, gradient);
}

static float sampled_mesh_distance(const sampled_mesh* mesh, pli_vec3 point, pli_vec3* normal) {
    const int* counts = mesh->counts;
    const pli_vec3 last = pli_vec3_make((float)(counts[0] - 1), (float)(counts[1] - 1), (float)(counts[2] - 1));
    const pli_vec3 local = pli_vec3_sub(point, mesh->origin);
    const pli_vec3 p = pli_vec3_scale(local, mesh->inverse_cell_size);
    const pli_vec3 inside = plii_vec3_min(plii_vec3_max(p, pli_vec3_make(0, 0, 0)), last);
    pli_vec3 gradient;
    const float distance = sampled_mesh_interpolate(mesh, inside, &gradient) * mesh->cell_size;
    *normal = plii_vec3_unit_or(gradient, SAMPLED_MESH_MIN_GRADIENT, pli_vec3_make(1, 0, 0));
    if (p.x == inside.x && p.y == inside.y && p.z == inside.z) { return distance; }
    const pli_vec3 offset = pli_vec3_sub(local, pli_vec3_scale(inside, mesh->cell_size));
    const float largest = plii_max(fabsf(offset.x), plii_max(fabsf(offset.y), fabsf(offset.z)));
    if (!(largest > 0.0f)) { return distance; }
    /* Where the line to the surface enters the grid it goes on at an obtuse angle; far squares would overflow. */
    const pli_vec3 before = pli_vec3_make(offset.x / largest, offset.y / largest, offset.z / largest);
    const pli_vec3 after = pli_vec3_scale(*normal, plii_max(distance, 0.0f) / largest);
    const float length = sqrtf(pli_vec3_length_squared(before) + pli_vec3_length_squared(after));
    *normal = plii_vec3_unit_or(pli_vec3_add(before, after), SAMPLED_MESH_MIN_GRADIENT, pli_vec3_make(1, 0, 0));
    return length * largest;
}

static void sampled_mesh_distances(const void* user, int count, const pli_vec3* points, float max_distance,
                                   float* distances, pli_vec3* normals) {
    for (int i = 0; i < count; ++i) {
        distances[i] = sampled_mesh_distance(user, points[i], &normals[i]);
    }
}

static const plii_field sampled_mesh_fields[] = {
    PLII_FIELD(pli_sampled_mesh_def, cell_size, 0, PLI_MAX_COORDINATE),
    PLII_FIELD(pli_sampled_mesh_def, padding, 0, PLI_MAX_COORDINATE),
};

/* Of the points that triangles use. */
static pli_bounds sampled_mesh_used_bounds(const pli_vec3* points, int triangle_count, const int* triangles) {
    pli_bounds bounds = {points[triangles[0]], points[triangles[0]]};
    for (int i = 1; i < 3 * triangle_count; ++i) {
        bounds = plii_bounds_add(bounds, points[triangles[i]]);
    }
    return bounds;
}

/* Origin, cells and number of samples of the grid. */
static pli_status sampled_mesh_fit_grid(sampled_mesh* mesh, pli_bounds bounds, const pli_sampled_mesh_def* def,
                                        const char* function) {
    const double extents[3] = {(double)bounds.max.x - (double)bounds.min.x, (double)bounds.max.y - (double)bounds.min.y,
                               (double)bounds.max.z - (double)bounds.min.z};
    const double diagonal = sqrt(extents[0] * extents[0] + extents[1] * extents[1] + extents[2] * extents[2]);
    const double cell_size = def->cell_size > 0.0f ? (double)def->cell_size : diagonal / SAMPLED_MESH_DIAGONAL_CELLS;
    mesh->cell_size = (float)cell_size;
    mesh->inverse_cell_size = 1.0f / mesh->cell_size;
    const float largest = plii_max(pli_vec3_length(plii_vec3_max(bounds.max, pli_vec3_neg(bounds.min))), 0.0f);
    const bool is_finite = plii_is_finite(mesh->inverse_cell_size) && plii_is_finite(mesh->cell_size);
    PLII_FAIL_IF(!is_finite || !(mesh->cell_size > FLT_EPSILON * 16.0f * largest), mesh->context,
                 PLI_ERROR_INVALID_VALUE, function, "cells of %g m are too small for coordinates up to %g m", cell_size,
                 (double)largest);
    double padding = def->padding > 0.0f ? (double)def->padding / cell_size : SAMPLED_MESH_PADDING;
    if (padding < SAMPLED_MESH_MIN_PADDING) { padding = SAMPLED_MESH_MIN_PADDING; }
    double counts[3], total = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        counts[axis] = ceil(extents[axis] / cell_size + 2.0 * padding) + 1.0;
        total *= counts[axis];
    }
    PLII_FAIL_IF(!(total <= (double)PLI_SAMPLED_MESH_MAX_SAMPLES), mesh->context, PLI_ERROR_INVALID_VALUE, function,
                 "cells of %g m and a padding of %g m need %.0f x %.0f x %.0f samples, more than %d", cell_size,
                 padding * cell_size, counts[0], counts[1], counts[2], PLI_SAMPLED_MESH_MAX_SAMPLES);
    for (int axis = 0; axis < 3; ++axis) {
        mesh->counts[axis] = (int)counts[axis];
    }
    const float shift = (float)(padding * cell_size);
    mesh->origin = pli_vec3_sub(bounds.min, pli_vec3_make(shift, shift, shift));
    /* The surface of the interpolant may lie outside of that of the mesh by less than a cell. */
    mesh->bounds = plii_bounds_grow(bounds, mesh->cell_size);
    return PLI_OK;
}

static size_t sampled_mesh_bytes(const sampled_mesh* mesh) {
    const int* counts = mesh->counts;
    return (size_t)counts[0] * (size_t)counts[1] * (size_t)counts[2] * sizeof *mesh->samples;
}
static void sampled_mesh_destroy(void* user) {
    sampled_mesh* mesh = user;
    plii_release(mesh->context, mesh->samples, sampled_mesh_bytes(mesh));
}

static pli_status sampled_mesh_sample(sampled_mesh* mesh, const pli_vec3* points, int triangle_count,
                                      const int* triangles, const char* function) {
    plii_soup soup = {.context = mesh->context};
    pli_status status = PLI_ERROR_OUT_OF_MEMORY;
    mesh->samples = plii_allocate(mesh->context, sampled_mesh_bytes(mesh));
    if (mesh->samples != NULL &&
        plii_soup_build(&soup, points, triangle_count, triangles, mesh->origin, mesh->inverse_cell_size)) {
        status = plii_soup_sample(&soup, mesh->counts, mesh->samples);
    }
    plii_soup_free(&soup);
    PLII_FAIL_IF(status == PLI_ERROR_OUT_OF_MEMORY, mesh->context, status, function,
                 "no memory for %d x %d x %d samples", mesh->counts[0], mesh->counts[1], mesh->counts[2]);
    PLII_FAIL_IF(status != PLI_OK, mesh->context, status, function,
                 "the %d triangles enclose nothing that cells of %g m show", triangle_count, (double)mesh->cell_size);
    return PLI_OK;
}

pli_status pli_shape_create_sampled_mesh(pli_context* context, int point_count, const pli_vec3* points,
                                         int triangle_count, const int* triangles, const pli_sampled_mesh_def* def,
                                         pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    const pli_sampled_mesh_def used = def != NULL ? *def : pli_sampled_mesh_def_default();
    PLII_TRY_DEF(context, pli_sampled_mesh_def, &used, sampled_mesh_fields, __func__);
    PLII_TRY(plii_shape_check_triangles(context, point_count, points, triangle_count, triangles, __func__));
    sampled_mesh mesh = {.context = context};
    const pli_bounds bounds = sampled_mesh_used_bounds(points, triangle_count, triangles);
    PLII_TRY(sampled_mesh_fit_grid(&mesh, bounds, &used, __func__));
    pli_status status = sampled_mesh_sample(&mesh, points, triangle_count, triangles, __func__);
    if (status == PLI_OK) {
        const pli_shape_def shape_def = {
            .distances = sampled_mesh_distances, .bounds = plii_shape_stored_bounds, .destroy = sampled_mesh_destroy};
        status = plii_shape_create_owning(context, PLII_SHAPE_OTHER, &shape_def, &mesh, sizeof mesh, __func__, shape);
    }
    if (status != PLI_OK) { sampled_mesh_destroy(&mesh); }
    return status;
}
