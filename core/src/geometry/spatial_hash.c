/* Dense hashing of an unbounded grid: count, prefix sum, fill. Teschner and others, "Optimized Spatial Hashing for
   Collision Detection of Deformable Objects". Columns of cells are hashed, cells of a column follow each other. */

#include "geometry/spatial_hash.h"

#include "base/csr.h"
#include "math/simd_float4.h"

static int spatial_hash_coordinate(const plii_spatial_hash* hash, float from_origin) {
    const float cell = from_origin * hash->inverse_cell_size;
    if (!(cell > -1e9f)) { return -1000000000; } /* NaN too */
    return cell < 1e9f ? (int)cell : 1000000000; /* never negative but where something is not finite */
}
static plii_spatial_hash_cell spatial_hash_cell_of(const plii_spatial_hash* hash, pli_vec3 p) {
    return (plii_spatial_hash_cell){spatial_hash_coordinate(hash, p.x - hash->origin.x),
                                    spatial_hash_coordinate(hash, p.y - hash->origin.y),
                                    spatial_hash_coordinate(hash, p.z - hash->origin.z)};
}
static uint64_t spatial_hash_column_name(int x, int y) {
    return (uint64_t)(uint32_t)x << 32 | (uint32_t)y;
}
static bool spatial_hash_is_grid(const plii_spatial_hash* hash) {
    return hash->strides[0] != 0;
}

static unsigned spatial_hash_column(const plii_spatial_hash* hash, int x, int y) {
    if (spatial_hash_is_grid(hash)) { return (unsigned)x * hash->strides[0] + (unsigned)y * hash->strides[1]; }
    unsigned h = (unsigned)x * 0x8da6b343u ^ (unsigned)y * 0xd8163841u;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    return h ^ h >> 13;
}

static unsigned spatial_hash_bucket(const plii_spatial_hash* hash, plii_spatial_hash_cell cell) {
    return (spatial_hash_column(hash, cell.x, cell.y) + (unsigned)cell.z) & hash->mask;
}

/* Coordinates are rounded when cells are computed. So much larger, cells of points within the radius still touch. */
static float spatial_hash_pad(float size, pli_vec3 v) {
    const float largest = plii_max(fabsf(v.x), plii_max(fabsf(v.y), fabsf(v.z)));
    return size + (size + largest) * (4.0f * FLT_EPSILON);
}

/* Where the grid has at most `most` cells, it is the table. An empty cell is between rows. */
static void spatial_hash_choose_table(plii_spatial_hash* hash, pli_vec3 extent, unsigned most) {
    const pli_vec3 cells = pli_vec3_scale(extent, hash->inverse_cell_size);
    unsigned size = 64;
    hash->strides[0] = hash->strides[1] = 0;
    hash->mask = most - 1;
    if (!((cells.x + 3.0f) * (cells.y + 3.0f) * (cells.z + 3.0f) < (float)most)) { return; }
    const unsigned x = (unsigned)cells.x + 2, y = (unsigned)cells.y + 3, z = (unsigned)cells.z + 3;
    while (size < x * y * z) {
        size *= 2;
    }
    hash->strides[0] = y * z;
    hash->strides[1] = z;
    hash->mask = size - 1;
}

static void spatial_hash_set_grid(plii_spatial_hash* hash, int count, const pli_vec3* positions, float cell_size,
                                  float shift, unsigned most) {
    pli_vec3 low = pli_vec3_make(FLT_MAX, FLT_MAX, FLT_MAX), high = pli_vec3_make(-FLT_MAX, -FLT_MAX, -FLT_MAX);
    for (int i = 0; i < count; ++i) {
        low = plii_vec3_min(positions[i], low);
        high = plii_vec3_max(positions[i], high);
    }
    const pli_vec3 extent = pli_vec3_sub(high, low);
    const bool is_finite = plii_vec3_is_finite(extent) && plii_vec3_is_finite(low);
    hash->cell_size = is_finite ? spatial_hash_pad(cell_size, extent) : cell_size;
    hash->inverse_cell_size = 1.0f / hash->cell_size;
    hash->origin = is_finite ? pli_vec3_sub(low, pli_vec3_make(shift, shift, shift)) : pli_vec3_make(0, 0, 0);
    const pli_vec3 from_origin = pli_vec3_add(extent, pli_vec3_make(shift, shift, shift));
    spatial_hash_choose_table(hash, is_finite ? from_origin : pli_vec3_make(FLT_MAX, FLT_MAX, FLT_MAX), most);
}

static bool spatial_hash_reserve(pli_context* context, plii_spatial_hash* hash, int count, int size) {
    if (count > INT32_MAX / 3 - PLII_LANES) { return false; }
    hash->stride = count + PLII_LANES - 1;
    return PLII_RESERVE(context, &hash->starts, &hash->start_capacity, size + 1) &&
           PLII_RESERVE(context, &hash->cells, &hash->cell_capacity, count) &&
           PLII_RESERVE(context, &hash->nodes, &hash->node_capacity, hash->stride) &&
           PLII_RESERVE(context, &hash->columns, &hash->column_capacity, hash->stride) &&
           PLII_RESERVE(context, &hash->components, &hash->component_capacity, 3 * hash->stride);
}

static void spatial_hash_put(plii_spatial_hash* hash, int entry, int node, uint64_t column, pli_vec3 position) {
    hash->nodes[entry] = node;
    if (!spatial_hash_is_grid(hash)) { hash->columns[entry] = column; }
    float* components = hash->components + entry;
    components[0] = position.x;
    components[hash->stride] = position.y;
    components[2 * hash->stride] = position.z;
}

bool plii_spatial_hash_build(pli_context* context, plii_spatial_hash* hash, int count, const pli_vec3* positions,
                             float cell_size, float shift) {
    unsigned most = 64;
    while (most < 2u * (unsigned)count && most < 1u << 30) {
        most *= 2;
    }
    hash->count = 0;
    if (!spatial_hash_reserve(context, hash, count, (int)most)) { return false; }
    hash->count = count;
    spatial_hash_set_grid(hash, count, positions, cell_size, shift, most);
    const unsigned size = hash->mask + 1;
    memset(hash->starts, 0, ((size_t)size + 1) * sizeof *hash->starts);
    for (int i = 0; i < count; ++i) {
        hash->cells[i] = spatial_hash_cell_of(hash, positions[i]);
        ++hash->starts[spatial_hash_bucket(hash, hash->cells[i])];
    }
    plii_csr_sum((int)size, hash->starts);
    for (int i = count - 1; i >= 0; --i) {
        const plii_spatial_hash_cell cell = hash->cells[i];
        spatial_hash_put(hash, --hash->starts[spatial_hash_bucket(hash, cell)], i,
                         spatial_hash_column_name(cell.x, cell.y), positions[i]);
    }
    for (int i = count; i < hash->stride; ++i) {
        spatial_hash_put(hash, i, 0, 0, pli_vec3_make(0, 0, 0));
    }
    return true;
}

/* Entries that lie side by side, and the column that those of interest belong to. */
typedef struct spatial_hash_run {
    int begin, end;
    uint64_t column;
} spatial_hash_run;

enum { SPATIAL_HASH_MAX_RUNS = 10 };

typedef struct spatial_hash_search {
    pli_context* context;
    const plii_spatial_hash* hash;
    plii_node_pairs* pairs;
    float radius_squared;
} spatial_hash_search;

static plii_float4 spatial_hash_squared_distances(const plii_spatial_hash* hash, int first, plii_vec3x4 p) {
    const float* components = hash->components + first;
    const plii_vec3x4 at = {plii_float4_load(components), plii_float4_load(components + hash->stride),
                            plii_float4_load(components + 2 * hash->stride)};
    const plii_vec3x4 apart = plii_vec3x4_sub(at, p);
    return plii_vec3x4_dot(apart, apart);
}

/* Without branches by positions: every point is written, those too far are written over. False: more than `most`. */
PLII_SIMD_INLINE bool spatial_hash_scan(const spatial_hash_search* search, const spatial_hash_run* run, plii_vec3x4 p,
                                        int most, bool is_grid) {
    static const unsigned lanes_left[PLII_LANES] = {0, 1, 3, 7};
    const plii_spatial_hash* hash = search->hash;
    const plii_float4 limit = plii_float4_all(search->radius_squared);
    plii_node_pairs* pairs = search->pairs;
    for (int first = run->begin; first < run->end; first += PLII_LANES) {
        const plii_float4 squared = spatial_hash_squared_distances(hash, first, p);
        const int left = run->end - first;
        const unsigned in_run = left < PLII_LANES ? lanes_left[left] : 15u;
        const unsigned bits = (unsigned)plii_lanes_bits(squared < limit) & in_run;
        float distances[PLII_LANES];
        plii_float4_store(distances, squared);
        int count = pairs->count;
        for (int lane = 0; lane < PLII_LANES; ++lane) {
            const int is_near = (int)(bits >> lane & 1u);
            pairs->pairs[count] = (plii_node_pair){hash->nodes[first + lane], distances[lane]};
            count += is_grid ? is_near : is_near & (hash->columns[first + lane] == run->column);
        }
        pairs->count = count < most ? count : most;
        if (count > most) { return false; }
    }
    return true;
}

/* Appends the pairs of a point with the points of some runs. */
static void spatial_hash_append(const spatial_hash_search* search, pli_vec3 p, const spatial_hash_run* runs,
                                int run_count) {
    plii_node_pairs* pairs = search->pairs;
    const plii_vec3x4 lanes = plii_vec3x4_all(p);
    const bool is_grid = spatial_hash_is_grid(search->hash);
    const int most = pairs->count + PLII_NODE_PAIRS_MAX_ROW;
    if (pairs->count > INT32_MAX - PLII_NODE_PAIRS_ROOM ||
        !PLII_RESERVE(search->context, &pairs->pairs, &pairs->capacity, pairs->count + PLII_NODE_PAIRS_ROOM)) {
        pairs->is_truncated = true;
        return;
    }
    bool is_whole = true;
    for (int r = 0; r < run_count && is_whole; ++r) {
        is_whole = is_grid ? spatial_hash_scan(search, &runs[r], lanes, most, true)
                           : spatial_hash_scan(search, &runs[r], lanes, most, false);
    }
    pairs->is_truncated = pairs->is_truncated || !is_whole;
}

/* Of the bucket of a node, those of larger index. */
static spatial_hash_run spatial_hash_run_after(const plii_spatial_hash* hash, int node) {
    const plii_spatial_hash_cell cell = hash->cells[node];
    const int* starts = &hash->starts[spatial_hash_bucket(hash, cell)];
    spatial_hash_run run = {starts[1], starts[1], spatial_hash_column_name(cell.x, cell.y)};
    while (run.begin > starts[0] && hash->nodes[run.begin - 1] > node) {
        --run.begin;
    }
    return run;
}

/* Entries of the cells of a column from z on, in one run or, at the end of the table, two. Returns how many. */
static int spatial_hash_column_runs(const plii_spatial_hash* hash, int x, int y, int z, int cells,
                                    spatial_hash_run runs[2]) {
    const unsigned size = hash->mask + 1, length = (unsigned)cells < size ? (unsigned)cells : size;
    const unsigned first = (spatial_hash_column(hash, x, y) + (unsigned)z) & hash->mask, before_end = size - first;
    const uint64_t column = spatial_hash_column_name(x, y);
    const bool wraps = length > before_end;
    runs[0] = (spatial_hash_run){hash->starts[first], hash->starts[first + (wraps ? before_end : length)], column};
    if (wraps) { runs[1] = (spatial_hash_run){0, hash->starts[length - before_end], column}; }
    return wraps ? 2 : 1;
}

void plii_spatial_hash_find(pli_context* context, const plii_spatial_hash* hash, int node, pli_vec3 position,
                            float radius, plii_node_pairs* pairs) {
    const spatial_hash_search search = {context, hash, pairs, radius * radius};
    static const int columns[4][2] = {{0, 1}, {1, -1}, {1, 0}, {1, 1}};
    const plii_spatial_hash_cell cell = hash->cells[node];
    spatial_hash_run runs[SPATIAL_HASH_MAX_RUNS] = {spatial_hash_run_after(hash, node)};
    int run_count = 1 + spatial_hash_column_runs(hash, cell.x, cell.y, cell.z + 1, 1, &runs[1]);
    for (int c = 0; c < 4; ++c) {
        run_count += spatial_hash_column_runs(hash, cell.x + columns[c][0], cell.y + columns[c][1], cell.z - 1, 3,
                                              &runs[run_count]);
    }
    spatial_hash_append(&search, position, runs, run_count);
}

void plii_spatial_hash_find_in_cell(pli_context* context, const plii_spatial_hash* hash, int node, pli_vec3 position,
                                    float radius, plii_node_pairs* pairs) {
    const spatial_hash_search search = {context, hash, pairs, radius * radius};
    const spatial_hash_run run = spatial_hash_run_after(hash, node);
    spatial_hash_append(&search, position, &run, 1);
}

#define SPATIAL_HASH_MAX_CELLS 16.0f /* a search from farther away would go through more than there are nodes */

bool plii_spatial_hash_find_near(pli_context* context, const plii_spatial_hash* hash, pli_vec3 point, float radius,
                                 plii_node_pairs* pairs) {
    const spatial_hash_search search = {context, hash, pairs, radius * radius};
    const float padded = spatial_hash_pad(radius, pli_vec3_sub(point, hash->origin));
    if (hash->count == 0) { return true; }
    if (!(padded <= SPATIAL_HASH_MAX_CELLS * hash->cell_size)) { return false; }
    const pli_vec3 reach = pli_vec3_make(padded, padded, padded);
    const plii_spatial_hash_cell low = spatial_hash_cell_of(hash, pli_vec3_sub(point, reach)),
                                 high = spatial_hash_cell_of(hash, pli_vec3_add(point, reach));
    for (int x = low.x; x <= high.x; ++x) {
        for (int y = low.y; y <= high.y; ++y) {
            spatial_hash_run runs[2];
            const int run_count = spatial_hash_column_runs(hash, x, y, low.z, high.z - low.z + 1, runs);
            spatial_hash_append(&search, point, runs, run_count);
        }
    }
    return true;
}

bool plii_spatial_hash_same_cell(const plii_spatial_hash* hash, pli_vec3 a, pli_vec3 b) {
    const plii_spatial_hash_cell i = spatial_hash_cell_of(hash, a), j = spatial_hash_cell_of(hash, b);
    return i.x == j.x && i.y == j.y && i.z == j.z;
}
