/* Packed coordinates, and groups by splitting at the median along the longest side until the groups are small. */

#include "lanes.h"

#include "support_groups.h"

enum { SUPPORT_HALVES = PLII_SUPPORT_LANES / PLII_LANES };

static float support_coordinate(pli_vec4 x, int axis) {
    return axis == 0 ? x.x : axis == 1 ? x.y : x.z;
}

static pli_bounds support_bounds(const pli_vec4* positions, const int* nodes, int count) {
    pli_vec3 min = plii_xyz(positions[nodes[0]]), max = min;
    for (int i = 1; i < count; ++i) {
        min = plii_vec3_min(min, plii_xyz(positions[nodes[i]]));
        max = plii_vec3_max(max, plii_xyz(positions[nodes[i]]));
    }
    return (pli_bounds){min, max};
}

/* Brings the `rank` smallest along an axis to the front (quickselect; ties by index keep it deterministic). */
static void support_select(const pli_vec4* positions, int* nodes, int count, int rank, int axis) {
    int low = 0, high = count - 1;
    while (low < high) {
        const float pivot = support_coordinate(positions[nodes[low + (high - low) / 2]], axis);
        int i = low, k = high;
        while (i <= k) {
            while (support_coordinate(positions[nodes[i]], axis) < pivot) {
                ++i;
            }
            while (support_coordinate(positions[nodes[k]], axis) > pivot) {
                --k;
            }
            if (i <= k) {
                const int swapped = nodes[i];
                nodes[i++] = nodes[k];
                nodes[k--] = swapped;
            }
        }
        if (rank <= k) {
            high = k;
        } else if (rank >= i) {
            low = i;
        } else {
            return;
        }
    }
}

static void support_split(const pli_vec4* positions, plii_support_groups* groups, int begin, int count, int largest) {
    if (count <= largest) {
        groups->begin[groups->count++] = begin;
        return;
    }
    const pli_bounds bounds = support_bounds(positions, groups->nodes + begin, count);
    const pli_vec3 size = pli_vec3_sub(bounds.max, bounds.min);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int half = count / 2;
    support_select(positions, groups->nodes + begin, count, half, axis);
    support_split(positions, groups, begin, half, largest);
    support_split(positions, groups, begin + half, count - half, largest);
}

static size_t support_block_count(const plii_support_groups* groups) {
    return ((size_t)groups->node_count + PLII_SUPPORT_LANES - 1) / PLII_SUPPORT_LANES;
}

bool plii_support_groups_create(pli_context* context, const pli_vec4* positions, const int* nodes, int node_stride,
                                int node_count, plii_support_groups* groups) {
    *groups = (plii_support_groups){0};
    if (node_count < PLII_SUPPORT_PACKED_MIN) { return true; }
    groups->node_count = node_count;
    const size_t count = (size_t)node_count;
    const bool is_whole = node_count < PLII_SUPPORT_GROUPS_MIN;
    groups->nodes = plii_allocate(context, count * sizeof *groups->nodes);
    bool has_memory = groups->nodes != NULL;
    if (is_whole) {
        groups->packed = plii_allocate(context, support_block_count(groups) * sizeof *groups->packed);
        has_memory = has_memory && groups->packed != NULL;
    } else {
        groups->begin = plii_allocate(context, (count + 1) * sizeof *groups->begin);
        groups->bounds = plii_allocate(context, count * sizeof *groups->bounds);
        has_memory = has_memory && groups->begin != NULL && groups->bounds != NULL;
    }
    if (!has_memory) {
        plii_support_groups_release(context, groups);
        return false;
    }
    for (int i = 0; i < node_count; ++i) {
        groups->nodes[i] = nodes[i * node_stride];
    }
    if (is_whole) { return true; }
    const int largest = (int)sqrtf((float)node_count);
    support_split(positions, groups, 0, node_count, largest);
    groups->begin[groups->count] = node_count;
    return true;
}

static void support_pack(const pli_vec4* positions, plii_support_groups* groups) {
    const int block_count = (int)support_block_count(groups);
    for (int b = 0; b < block_count; ++b) {
        plii_support_block* block = &groups->packed[b];
        for (int lane = 0; lane < PLII_SUPPORT_LANES; ++lane) {
            const int i = b * PLII_SUPPORT_LANES + lane;
            const pli_vec4 x = positions[groups->nodes[i < groups->node_count ? i : 0]];
            block->x[lane] = x.x;
            block->y[lane] = x.y;
            block->z[lane] = x.z;
        }
    }
}

void plii_support_groups_update(const pli_vec4* positions, plii_support_groups* groups) {
    if (groups->packed != NULL) { support_pack(positions, groups); }
    for (int i = 0; i < groups->count; ++i) {
        const int begin = groups->begin[i];
        groups->bounds[i] = support_bounds(positions, groups->nodes + begin, groups->begin[i + 1] - begin);
    }
    groups->is_current = true;
}

static float support_least(plii_float4 a) {
    float lanes[PLII_LANES];
    plii_float4_store(lanes, a);
    return plii_min(plii_min(lanes[0], lanes[1]), plii_min(lanes[2], lanes[3]));
}
static float support_largest(plii_float4 a) {
    float lanes[PLII_LANES];
    plii_float4_store(lanes, a);
    return plii_max(plii_max(lanes[0], lanes[1]), plii_max(lanes[2], lanes[3]));
}

/* The first of the farthest nodes, as a search one by one finds it: each lane keeps the first of its farthest. Places
   are counted in floats, and nothing branches: which lane has the farthest node is anybody's guess. */
static int support_query_packed(const plii_support_groups* groups, pli_vec3 direction) {
    const plii_float4 x = plii_float4_all(direction.x), y = plii_float4_all(direction.y);
    const plii_float4 z = plii_float4_all(direction.z);
    const plii_float4 step = plii_float4_all((float)PLII_SUPPORT_LANES), nowhere = plii_float4_all(INFINITY);
    plii_float4 place[SUPPORT_HALVES] = {plii_lanes_xyzw(0, 1, 2, 3), plii_lanes_xyzw(4, 5, 6, 7)};
    plii_float4 best[SUPPORT_HALVES] = {plii_float4_all(-INFINITY), plii_float4_all(-INFINITY)};
    plii_float4 found[SUPPORT_HALVES] = {place[0], place[1]};
    const plii_support_block* end = groups->packed + support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        for (int h = 0; h < SUPPORT_HALVES; ++h) {
            const plii_float4 reach =
                plii_float4_add(plii_float4_add(plii_float4_mul(plii_float4_load(&block->x[PLII_LANES * h]), x),
                                                plii_float4_mul(plii_float4_load(&block->y[PLII_LANES * h]), y)),
                                plii_float4_mul(plii_float4_load(&block->z[PLII_LANES * h]), z));
            found[h] = plii_lanes_select(plii_lanes_less(best[h], reach), place[h], found[h]);
            best[h] = plii_lanes_max(reach, best[h]);
            place[h] = plii_float4_add(place[h], step);
        }
    }
    const plii_float4 farthest = plii_float4_all(support_largest(plii_lanes_max(best[0], best[1])));
    for (int h = 0; h < SUPPORT_HALVES; ++h) {
        found[h] = plii_lanes_select(plii_lanes_at_most(farthest, best[h]), found[h], nowhere);
    }
    return groups->nodes[(int)support_least(plii_lanes_min(found[0], found[1]))];
}

static plii_vec3x4 support_nodes(const plii_support_block* block, int half) {
    return (plii_vec3x4){plii_float4_load(&block->x[PLII_LANES * half]), plii_float4_load(&block->y[PLII_LANES * half]),
                         plii_float4_load(&block->z[PLII_LANES * half])};
}

float plii_support_groups_reach(const plii_support_groups* groups, pli_vec3 direction) {
    const plii_vec3x4 along = plii_vec3x4_all(direction);
    plii_float4 best[SUPPORT_HALVES] = {plii_float4_all(-INFINITY), plii_float4_all(-INFINITY)};
    const plii_support_block* end = groups->packed + support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        for (int h = 0; h < SUPPORT_HALVES; ++h) {
            best[h] = plii_lanes_max(plii_vec3x4_dot(support_nodes(block, h), along), best[h]);
        }
    }
    return support_largest(plii_lanes_max(best[0], best[1]));
}

static int support_query_groups(const pli_vec4* positions, const plii_support_groups* groups, pli_vec3 direction) {
    float best = -INFINITY;
    int farthest = groups->nodes[0];
    for (int i = 0; i < groups->count; ++i) {
        const pli_bounds b = groups->bounds[i];
        const float reach = direction.x * (direction.x > 0.0f ? b.max.x : b.min.x) +
                            direction.y * (direction.y > 0.0f ? b.max.y : b.min.y) +
                            direction.z * (direction.z > 0.0f ? b.max.z : b.min.z);
        if (!(reach > best)) { continue; }
        for (int k = groups->begin[i]; k < groups->begin[i + 1]; ++k) {
            const float along = pli_vec3_dot(plii_xyz(positions[groups->nodes[k]]), direction);
            if (along > best) {
                best = along;
                farthest = groups->nodes[k];
            }
        }
    }
    return farthest;
}

int plii_support_groups_query(const pli_vec4* positions, const plii_support_groups* groups, pli_vec3 direction) {
    return groups->packed != NULL ? support_query_packed(groups, direction)
                                  : support_query_groups(positions, groups, direction);
}

bool plii_support_groups_has_near(const plii_support_groups* groups, pli_vec3 hub, pli_vec3 point, float distance,
                                  pli_vec3* gap) {
    *gap = pli_vec3_make(0, 0, 0);
    if (groups->packed == NULL) { return false; }
    const plii_vec3x4 from = plii_vec3x4_all(hub), arm = plii_vec3x4_all(pli_vec3_sub(point, hub));
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_float4 tiny = plii_float4_all(FLT_MIN);
    plii_float4 nearest = plii_float4_all(INFINITY);
    plii_vec3x4 ways = {zero, zero, zero};
    const plii_support_block* end = groups->packed + support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        for (int h = 0; h < SUPPORT_HALVES; ++h) {
            const plii_vec3x4 spoke = plii_vec3x4_sub(support_nodes(block, h), from);
            const plii_float4 length_squared = plii_lanes_max(plii_vec3x4_dot(spoke, spoke), tiny);
            plii_float4 share = plii_float4_div(plii_vec3x4_dot(arm, spoke), length_squared);
            share = plii_lanes_min(plii_lanes_max(share, zero), one);
            const plii_vec3x4 way = plii_vec3x4_sub(arm, plii_vec3x4_scale(spoke, share));
            const plii_float4 squared = plii_vec3x4_dot(way, way);
            ways = plii_vec3x4_select(plii_lanes_less(squared, nearest), way, ways);
            nearest = plii_lanes_min(squared, nearest);
        }
    }
    float squares[PLII_LANES];
    plii_float4_store(squares, nearest);
    int lane = 0;
    for (int i = 1; i < PLII_LANES; ++i) {
        if (squares[i] < squares[lane]) { lane = i; }
    }
    pli_vec3 vectors[PLII_LANES];
    plii_vec3x4_to(vectors, ways);
    *gap = vectors[lane];
    return squares[lane] < distance * distance;
}

int plii_support_groups_find_below(const plii_support_groups* groups, pli_vec3 foot, pli_vec3 normal, float limit,
                                   pli_vec3* points, float* heights) {
    const plii_vec3x4 from = plii_vec3x4_all(foot), up = plii_vec3x4_all(normal);
    int count = 0;
    for (int begin = 0; begin < groups->node_count; begin += PLII_LANES) {
        const int half = begin / PLII_LANES % SUPPORT_HALVES;
        const plii_vec3x4 nodes = support_nodes(&groups->packed[begin / PLII_SUPPORT_LANES], half);
        const plii_float4 above = plii_vec3x4_dot(plii_vec3x4_sub(nodes, from), up);
        int bits = plii_lanes_bits(plii_lanes_less(above, plii_float4_all(limit)));
        const int left = groups->node_count - begin;
        if (left < PLII_LANES) { bits &= (1 << left) - 1; }
        if (bits == 0) { continue; }
        float lanes[PLII_LANES];
        pli_vec3 vectors[PLII_LANES];
        plii_float4_store(lanes, above);
        plii_vec3x4_to(vectors, nodes);
        for (int lane = 0; lane < PLII_LANES; ++lane) {
            if ((bits >> lane & 1) == 0) { continue; }
            points[count] = vectors[lane];
            heights[count++] = lanes[lane];
        }
    }
    return count;
}

void plii_support_groups_release(pli_context* context, plii_support_groups* groups) {
    const size_t count = (size_t)groups->node_count;
    plii_release(context, groups->nodes, count * sizeof *groups->nodes);
    plii_release(context, groups->packed, support_block_count(groups) * sizeof *groups->packed);
    plii_release(context, groups->begin, (count + 1) * sizeof *groups->begin);
    plii_release(context, groups->bounds, count * sizeof *groups->bounds);
    *groups = (plii_support_groups){0};
}

size_t plii_support_groups_bytes(const plii_support_groups* groups) {
    const size_t count = (size_t)groups->node_count;
    size_t bytes = count * sizeof *groups->nodes;
    if (groups->packed != NULL) { bytes += support_block_count(groups) * sizeof *groups->packed; }
    if (groups->begin != NULL) { bytes += count * sizeof *groups->bounds + (count + 1) * sizeof *groups->begin; }
    return bytes;
}
