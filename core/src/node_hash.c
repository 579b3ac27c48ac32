/* Dense hashing of an unbounded grid: count, prefix sum, fill. Teschner and others, "Optimized Spatial Hashing for
   Collision Detection of Deformable Objects"; Mueller, "Ten Minute Physics" 11 for the dense layout. Columns of cells
   are hashed, cells of a column follow each other. */

#include "node_hash.h"

typedef struct node_hash_cell {
    int x, y, z;
} node_hash_cell;

static int node_hash_coordinate(const plii_node_hash* hash, float x, float origin) {
    const float cell = (x - origin) * hash->inverse_cell_size;
    if (!(cell > -1e9f)) { return -1000000000; } /* NaN too */
    if (cell > 1e9f) { return 1000000000; }
    const int towards_zero = (int)cell;
    return towards_zero - ((float)towards_zero > cell);
}

static node_hash_cell node_hash_cell_of(const plii_node_hash* hash, pli_vec3 p) {
    return (node_hash_cell){node_hash_coordinate(hash, p.x, hash->origin.x),
                            node_hash_coordinate(hash, p.y, hash->origin.y),
                            node_hash_coordinate(hash, p.z, hash->origin.z)};
}

static unsigned node_hash_column(int x, int y) {
    unsigned h = (unsigned)x * 0x8da6b343u ^ (unsigned)y * 0xd8163841u;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    return h ^ h >> 13;
}

static unsigned node_hash_bucket(const plii_node_hash* hash, node_hash_cell cell) {
    return (node_hash_column(cell.x, cell.y) + (unsigned)cell.z) & hash->mask;
}

/* Coordinates are rounded when cells are computed. So much larger, cells of points within the radius still touch. */
static float node_hash_padded_size(float cell_size, pli_vec3 extent) {
    const float largest = plii_max(extent.x, plii_max(extent.y, extent.z));
    return cell_size + (cell_size + largest) * (4.0f * FLT_EPSILON);
}

static void node_hash_place_grid(plii_node_hash* hash, int count, const pli_vec3* positions, float cell_size,
                                 float shift) {
    pli_vec3 low = pli_vec3_make(FLT_MAX, FLT_MAX, FLT_MAX), high = pli_vec3_make(-FLT_MAX, -FLT_MAX, -FLT_MAX);
    for (int i = 0; i < count; ++i) {
        low = plii_vec3_min(positions[i], low);
        high = plii_vec3_max(positions[i], high);
    }
    const pli_vec3 extent = pli_vec3_sub(high, low);
    const bool is_finite = plii_vec3_is_finite(extent) && plii_vec3_is_finite(low);
    hash->cell_size = is_finite ? node_hash_padded_size(cell_size, extent) : cell_size;
    hash->inverse_cell_size = 1.0f / hash->cell_size;
    hash->origin = is_finite ? pli_vec3_sub(low, pli_vec3_make(shift, shift, shift)) : pli_vec3_make(0, 0, 0);
}

bool plii_node_hash_build(pli_context* context, plii_node_hash* hash, int count, const pli_vec3* positions,
                          float cell_size, float shift) {
    unsigned size = 64;
    while (size < 2u * (unsigned)count && size < 1u << 30) {
        size *= 2;
    }
    hash->count = 0;
    if (!PLII_RESERVE(context, &hash->starts, &hash->start_capacity, (int)size + 1) ||
        !PLII_RESERVE(context, &hash->entries, &hash->entry_capacity, count)) {
        return false;
    }
    hash->count = count;
    hash->mask = size - 1;
    node_hash_place_grid(hash, count, positions, cell_size, shift);

    for (unsigned i = 0; i <= size; ++i) {
        hash->starts[i] = 0;
    }
    for (int i = 0; i < count; ++i) {
        ++hash->starts[node_hash_bucket(hash, node_hash_cell_of(hash, positions[i]))];
    }
    int sum = 0;
    for (unsigned i = 0; i <= size; ++i) {
        sum += hash->starts[i];
        hash->starts[i] = sum;
    }
    /* Backwards, so that each bucket ends up in the order of nodes. */
    for (int i = count - 1; i >= 0; --i) {
        const node_hash_cell cell = node_hash_cell_of(hash, positions[i]);
        const int place = --hash->starts[node_hash_bucket(hash, cell)];
        hash->entries[place] = (plii_node_hash_entry){positions[i], i, {cell.x, cell.y}};
    }
    return true;
}

typedef struct node_hash_search {
    pli_context* context;
    const plii_node_hash* hash;
    plii_node_pairs* pairs;
    float radius_squared;
} node_hash_search;

/* Pairs of a node with those of a run of buckets that are in the column and have an index above `after`; that is looked
   at only where it ends the search, so `after` >= 0 goes with one bucket. */
static bool node_hash_search_run(const node_hash_search* search, pli_vec3 p, int x, int y, unsigned bucket,
                                 unsigned bucket_count, int after) {
    const plii_node_hash* hash = search->hash;
    plii_node_pairs* pairs = search->pairs;
    const int begin = hash->starts[bucket], end = hash->starts[bucket + bucket_count];
    if (begin == end) { return true; }
    const int room = pairs->begin[pairs->row_count] + PLII_NODE_PAIRS_MAX_ROW;
    const int wanted = end - begin < room - pairs->count ? pairs->count + end - begin : room;
    if (!PLII_RESERVE(search->context, &pairs->pairs, &pairs->capacity, wanted)) { return false; }
    for (int k = end - 1; k >= begin && hash->entries[k].node > after; --k) {
        const plii_node_hash_entry* entry = &hash->entries[k];
        const float squared = pli_vec3_length_squared(pli_vec3_sub(entry->position, p));
        if (!(squared < search->radius_squared) || entry->column[0] != x || entry->column[1] != y) { continue; }
        if (pairs->count == wanted) {
            pairs->is_cut_short = true;
            break;
        }
        pairs->pairs[pairs->count++] = (plii_node_pair){entry->node, squared};
    }
    return true;
}

static bool node_hash_search_half(const node_hash_search* search, pli_vec3 p, int node) {
    static const int columns[4][2] = {{0, 1}, {1, -1}, {1, 0}, {1, 1}};
    const plii_node_hash* hash = search->hash;
    const node_hash_cell cell = node_hash_cell_of(hash, p);
    const unsigned own = node_hash_bucket(hash, cell);
    bool is_complete = node_hash_search_run(search, p, cell.x, cell.y, own, 1, node) &&
                       node_hash_search_run(search, p, cell.x, cell.y, (own + 1) & hash->mask, 1, -1);
    for (int c = 0; is_complete && c < 4; ++c) {
        const int x = cell.x + columns[c][0], y = cell.y + columns[c][1];
        const unsigned below = (node_hash_column(x, y) + (unsigned)cell.z - 1u) & hash->mask;
        const unsigned before_end = hash->mask + 1 - below; /* of the table, where runs go on at its start */
        if (before_end >= 3) {
            is_complete = node_hash_search_run(search, p, x, y, below, 3, -1);
        } else {
            is_complete = node_hash_search_run(search, p, x, y, below, before_end, -1) &&
                          node_hash_search_run(search, p, x, y, 0, 3 - before_end, -1);
        }
    }
    return is_complete;
}

static bool node_hash_search_own(const node_hash_search* search, pli_vec3 p, int node) {
    const node_hash_cell cell = node_hash_cell_of(search->hash, p);
    return node_hash_search_run(search, p, cell.x, cell.y, node_hash_bucket(search->hash, cell), 1, node);
}

static bool node_hash_search_all(const node_hash_search* search, const pli_vec3* positions,
                                 bool (*search_node)(const node_hash_search*, pli_vec3, int)) {
    plii_node_pairs* pairs = search->pairs;
    const int count = search->hash->count;
    pairs->row_count = 0;
    pairs->count = 0;
    pairs->is_cut_short = false;
    if (!PLII_RESERVE(search->context, &pairs->begin, &pairs->begin_capacity, count + 1)) { return false; }
    pairs->begin[0] = 0;
    for (int i = 0; i < count; ++i) {
        if (pairs->count > INT32_MAX - PLII_NODE_PAIRS_MAX_ROW || !search_node(search, positions[i], i)) {
            return false;
        }
        pairs->row_count = i + 1;
        pairs->begin[i + 1] = pairs->count;
    }
    return true;
}

bool plii_node_hash_find(pli_context* context, const plii_node_hash* hash, const pli_vec3* positions, float radius,
                         plii_node_pairs* pairs) {
    const node_hash_search search = {context, hash, pairs, radius * radius};
    return node_hash_search_all(&search, positions, node_hash_search_half);
}

bool plii_node_hash_find_in_cells(pli_context* context, const plii_node_hash* hash, const pli_vec3* positions,
                                  float radius, plii_node_pairs* pairs) {
    const node_hash_search search = {context, hash, pairs, radius * radius};
    return node_hash_search_all(&search, positions, node_hash_search_own);
}

bool plii_node_hash_same_cell(const plii_node_hash* hash, pli_vec3 a, pli_vec3 b) {
    const node_hash_cell i = node_hash_cell_of(hash, a), j = node_hash_cell_of(hash, b);
    return i.x == j.x && i.y == j.y && i.z == j.z;
}

void plii_node_hash_free(pli_context* context, plii_node_hash* hash) {
    plii_release(context, hash->starts, (size_t)hash->start_capacity * sizeof *hash->starts);
    plii_release(context, hash->entries, (size_t)hash->entry_capacity * sizeof *hash->entries);
    *hash = (plii_node_hash){0};
}

size_t plii_node_hash_bytes(const plii_node_hash* hash) {
    return (size_t)hash->start_capacity * sizeof *hash->starts + (size_t)hash->entry_capacity * sizeof *hash->entries;
}

void plii_node_pairs_free(pli_context* context, plii_node_pairs* pairs) {
    plii_release(context, pairs->begin, (size_t)pairs->begin_capacity * sizeof *pairs->begin);
    plii_release(context, pairs->pairs, (size_t)pairs->capacity * sizeof *pairs->pairs);
    *pairs = (plii_node_pairs){0};
}

size_t plii_node_pairs_bytes(const plii_node_pairs* pairs) {
    return (size_t)pairs->begin_capacity * sizeof *pairs->begin + (size_t)pairs->capacity * sizeof *pairs->pairs;
}
