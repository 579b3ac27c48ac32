/* Signed distances sampled at lattice points and interpolated: Bullet's view of rigid shapes (btSparseSdf<3>). A cell
   of 3 x 3 x 3 voxels is sampled at its 64 corners when a point first falls into it, and kept. Index and interpolation
   arithmetic follow btSparseSdf, so that equal samples give equal results, bit for bit. At LATTICE_MAX_CELLS cells all
   are dropped and sampling starts again, which changes time only. */

#include "base/handle.h"
#include "base/key_table.h"
#include "math/bounds.h"
#include "math/range.h"
#include "pliant/bullet_reference.h"
#include "shape/shape_impl.h"

#define LATTICE_CELL_VOXELS 3
#define LATTICE_CELL_POINTS (LATTICE_CELL_VOXELS + 1)
#define LATTICE_SAMPLES (LATTICE_CELL_POINTS * LATTICE_CELL_POINTS * LATTICE_CELL_POINTS)
#define LATTICE_MAX_CELLS 32768 /* 9 MB */
/* In voxels: cells up to here have a key, and their coordinates are exact in float. Farther points ask the source. */
#define LATTICE_MAX_COORDINATE 3.1e6f

typedef struct lattice_cell {
    float samples[LATTICE_SAMPLES]; /* z first, then y */
} lattice_cell;

typedef struct lattice_data {
    pli_context* context;
    pli_shape* source;
    float voxel_size;
    /* What queries change. */
    lattice_cell* cells;
    int cell_capacity;
    plii_key_table table; /* of the cells */
} lattice_data;

/* Where a point lies along one axis. */
typedef struct lattice_position {
    int cell, voxel;
    float fraction;
} lattice_position;

/* btSparseSdf::Decompose: a floor by shifting into the positive. */
static lattice_position lattice_decompose(float voxels) {
    const float cells = voxels / (float)LATTICE_CELL_VOXELS;
    const int shift = cells < 0.0f ? (int)(-cells + 1.0f) : 0;
    const float positive = cells + (float)shift;
    lattice_position position;
    position.cell = (int)positive;
    const float within = (positive - (float)position.cell) * (float)LATTICE_CELL_VOXELS;
    position.voxel = (int)within;
    position.fraction = within - (float)position.voxel;
    /* Rounding may end on the far corner. */
    if (position.voxel >= LATTICE_CELL_VOXELS) {
        position.voxel = LATTICE_CELL_VOXELS - 1;
        position.fraction = 1.0f;
    }
    position.cell -= shift;
    return position;
}

static void lattice_sample(const lattice_data* lattice, const int key[3], lattice_cell* cell) {
    const float size = lattice->voxel_size;
    const pli_vec3 origin = pli_vec3_scale(
        pli_vec3_scale(pli_vec3_make((float)key[0], (float)key[1], (float)key[2]), (float)LATTICE_CELL_VOXELS), size);
    pli_vec3 points[LATTICE_SAMPLES], normals[LATTICE_SAMPLES];
    for (int n = 0; n < LATTICE_SAMPLES; ++n) {
        const int i = n / LATTICE_CELL_POINTS / LATTICE_CELL_POINTS, j = n / LATTICE_CELL_POINTS % LATTICE_CELL_POINTS;
        const int k = n % LATTICE_CELL_POINTS;
        points[n] = pli_vec3_make(size * (float)i + origin.x, size * (float)j + origin.y, size * (float)k + origin.z);
    }
    const pli_shape_def* source = &lattice->source->def;
    source->distances(source->user, LATTICE_SAMPLES, points, INFINITY, cell->samples, normals);
    for (int n = 0; n < LATTICE_SAMPLES; ++n) {
        /* An infinite sample would make NaN of its neighbours. */
        cell->samples[n] = plii_clamp(cell->samples[n], -FLT_MAX, FLT_MAX);
    }
}

/* The cell at some coordinates; sampled into `fallback` when there is no memory to keep it. */
static const lattice_cell* lattice_find(lattice_data* lattice, const int cell[3], lattice_cell* fallback) {
    uint64_t key = 0; /* 21 bits of each coordinate */
    for (int axis = 0; axis < 3; ++axis) {
        key = key << 21 | ((uint64_t)(uint32_t)cell[axis] & 0x1fffffu);
    }
    int index = plii_key_table_find(&lattice->table, key);
    if (index != PLI_NULL_INDEX) { return &lattice->cells[index]; }
    if (lattice->table.count >= LATTICE_MAX_CELLS) { plii_key_table_clear(&lattice->table); }
    index = (int)lattice->table.count;
    const bool is_kept = PLII_RESERVE(lattice->context, &lattice->cells, &lattice->cell_capacity, index + 1) &&
                         plii_key_table_add(&lattice->table, key, index) != PLI_NULL_INDEX;
    lattice_cell* found = is_kept ? &lattice->cells[index] : fallback;
    lattice_sample(lattice, cell, found);
    return found;
}

/* btSparseSdf::Evaluate without its margin. */
static float lattice_interpolate(const lattice_cell* cell, lattice_position x, lattice_position y, lattice_position z,
                                 pli_vec3* normal) {
    enum { Y = LATTICE_CELL_POINTS, X = Y * LATTICE_CELL_POINTS }; /* strides */
    const float* low = &cell->samples[X * x.voxel + Y * y.voxel + z.voxel];
    const float d[8] = {low[0], low[X], low[X + Y], low[Y], low[1], low[X + 1], low[X + Y + 1], low[Y + 1]};
    pli_vec3 gradient;
    const pli_vec3 fractions = pli_vec3_make(x.fraction, y.fraction, z.fraction);
    const float distance = plii_shape_interpolate(d, fractions, &gradient);
    *normal = plii_vec3_safe_normalize(gradient);
    return distance;
}

static void lattice_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                              pli_vec3* normals) {
    lattice_data* lattice = (lattice_data*)(uintptr_t)user; /* cells are kept from query to query */
    const float limit = LATTICE_MAX_COORDINATE * lattice->voxel_size;
    lattice_cell fallback;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        if (!(fabsf(p.x) < limit && fabsf(p.y) < limit && fabsf(p.z) < limit)) {
            const pli_shape_def* source = &lattice->source->def;
            source->distances(source->user, 1, &p, max_distance, &distances[i], &normals[i]);
            continue;
        }
        const pli_vec3 voxels = plii_vec3_divide(p, lattice->voxel_size);
        const lattice_position x = lattice_decompose(voxels.x);
        const lattice_position y = lattice_decompose(voxels.y);
        const lattice_position z = lattice_decompose(voxels.z);
        const int key[3] = {x.cell, y.cell, z.cell};
        distances[i] = lattice_interpolate(lattice_find(lattice, key, &fallback), x, y, z, &normals[i]);
    }
}

/* The core is that of the source; only distances are sampled. */
static pli_vec3 lattice_support(const void* user, pli_vec3 direction) {
    const pli_shape* source = ((const lattice_data*)user)->source;
    return source->def.support(source->def.user, direction);
}

/* The surface of the interpolant may lie outside that of the source by less than a voxel. */
static pli_bounds lattice_bounds(const void* user) {
    const lattice_data* lattice = user;
    return plii_bounds_grow(lattice->source->def.bounds(lattice->source->def.user), lattice->voxel_size);
}

static void lattice_destroy(void* user) {
    lattice_data* lattice = user;
    PLII_RELEASE(lattice->context, lattice->cells, lattice->cell_capacity);
    plii_key_table_free(&lattice->table);
    plii_shape_release(lattice->source);
}

pli_status pli_shape_create_lattice(pli_context* context, pli_shape* source, float voxel_size, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(plii_check_handle(source, PLII_HANDLE_SHAPE, context, NULL, __func__));
    /* The smallest normal number has a finite inverse. */
    PLII_TRY(plii_check_between(context, voxel_size, PLII_ABOVE_0, PLI_MAX_COORDINATE, "voxel_size", __func__));
    const lattice_data lattice = {context, source, voxel_size, .table.context = context};
    const pli_shape_def def = {.distances = lattice_distances,
                               .bounds = lattice_bounds,
                               .support = source->def.support != NULL ? lattice_support : NULL,
                               .radius = source->def.radius,
                               .destroy = lattice_destroy};
    PLII_TRY(plii_shape_create_owning(context, PLII_SHAPE_OTHER, &def, &lattice, sizeof lattice, __func__, shape));
    (*shape)->source = source;
    plii_shape_retain(source);
    return PLI_OK;
}
