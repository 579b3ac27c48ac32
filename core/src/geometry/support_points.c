/* Packed coordinates, searched eight at a time, and groups by splitting at the median along the longest side until the
 * groups are small. */

#include "math/simd_float8.h"

#include "geometry/support_points.h"

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

static void support_split(const pli_vec4* positions, plii_support_points* groups, int begin, int count, int largest) {
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

bool plii_support_points_create(pli_context* context, const pli_vec4* positions, const int* nodes, int node_stride,
                                int node_count, plii_support_points* groups) {
    *groups = (plii_support_points){0};
    if (node_count < PLII_SUPPORT_PACKED_MIN) { return true; }
    groups->node_count = node_count;
    const bool is_whole = node_count < PLII_SUPPORT_POINTS_MIN;
    const bool has_memory = PLII_ALLOCATE(context, &groups->nodes, node_count) &&
                            (is_whole ? PLII_ALLOCATE(context, &groups->packed, plii_support_block_count(groups))
                                      : PLII_ALLOCATE(context, &groups->begin, (size_t)node_count + 1) &&
                                            PLII_ALLOCATE(context, &groups->bounds, node_count));
    if (!has_memory) {
        plii_support_points_release(context, groups);
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

static void support_pack(const pli_vec4* positions, plii_support_points* groups) {
    const int block_count = (int)plii_support_block_count(groups);
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

void plii_support_points_update(const pli_vec4* positions, plii_support_points* groups) {
    if (groups->packed != NULL) { support_pack(positions, groups); }
    for (int i = 0; i < groups->count; ++i) {
        const int begin = groups->begin[i];
        groups->bounds[i] = support_bounds(positions, groups->nodes + begin, groups->begin[i + 1] - begin);
    }
    groups->is_current = true;
}

static inline plii_vec3x8 support_nodes(const plii_support_block* block) {
    return (plii_vec3x8){plii_float8_load(block->x), plii_float8_load(block->y), plii_float8_load(block->z)};
}

static inline float support_least(plii_float8 a) {
    plii_float4 four = plii_lanes_min(plii_float8_low(a), plii_float8_high(a));
    four = plii_lanes_min(four, plii_lanes_all_w(four));
    return plii_lanes_first(plii_lanes_min(plii_lanes_min(four, plii_lanes_all_y(four)), plii_lanes_all_z(four)));
}
static inline float support_largest(plii_float8 a) {
    plii_float4 four = plii_lanes_max(plii_float8_low(a), plii_float8_high(a));
    four = plii_lanes_max(four, plii_lanes_all_w(four));
    return plii_lanes_first(plii_lanes_max(plii_lanes_max(four, plii_lanes_all_y(four)), plii_lanes_all_z(four)));
}

/* The first of the farthest nodes, as a search one by one finds it: each lane keeps the first of its farthest. Places
   are counted in floats, and nothing branches: which lane has the farthest node is anybody's guess. */
static int support_farthest(const plii_support_points* groups, pli_vec3 direction) {
    const plii_vec3x8 along = plii_vec3x8_all(direction);
    const plii_float8 step = plii_float8_all((float)PLII_SUPPORT_LANES);
    plii_float8 place = plii_float8_of(plii_lanes_xyzw(0, 1, 2, 3), plii_lanes_xyzw(4, 5, 6, 7));
    plii_float8 best = plii_float8_all(-INFINITY), found = place;
    const plii_support_block* end = groups->packed + plii_support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        const plii_float8 reach = plii_vec3x8_dot(support_nodes(block), along);
        found = plii_float8_select_less(best, reach, place, found);
        best = plii_float8_max(reach, best);
        place = plii_float8_add(place, step);
    }
    const plii_float8 farthest = plii_float8_all(support_largest(best));
    return (int)support_least(plii_float8_select_less(best, farthest, plii_float8_all(INFINITY), found));
}

static int support_query_groups(const pli_vec4* positions, const plii_support_points* groups, pli_vec3 direction) {
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

int plii_support_points_query(const pli_vec4* positions, const plii_support_points* groups, pli_vec3 direction) {
    return groups->packed != NULL ? groups->nodes[support_farthest(groups, direction)]
                                  : support_query_groups(positions, groups, direction);
}

float plii_support_points_reach(const plii_support_points* groups, pli_vec3 direction) {
    const plii_vec3x8 along = plii_vec3x8_all(direction);
    plii_float8 best = plii_float8_all(-INFINITY);
    const plii_support_block* end = groups->packed + plii_support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        best = plii_float8_max(plii_vec3x8_dot(support_nodes(block), along), best);
    }
    return support_largest(best);
}

/* Returns the square of the length of the gap. */
static float support_find_gap(const plii_support_points* groups, pli_vec3 hub, pli_vec3 point, pli_vec3* gap) {
    const plii_vec3x8 from = plii_vec3x8_all(hub), arm = plii_vec3x8_all(pli_vec3_sub(point, hub));
    const plii_float8 zero = plii_float8_all(0.0f), one = plii_float8_all(1.0f), tiny = plii_float8_all(FLT_MIN);
    plii_float8 nearest = plii_float8_all(INFINITY);
    plii_vec3x8 nearest_offset = {zero, zero, zero};
    const plii_support_block* end = groups->packed + plii_support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        const plii_vec3x8 spoke = plii_vec3x8_sub(support_nodes(block), from);
        const plii_float8 length_squared = plii_float8_max(plii_vec3x8_dot(spoke, spoke), tiny);
        const plii_float8 along = plii_float8_div(plii_vec3x8_dot(arm, spoke), length_squared);
        const plii_float8 share = plii_float8_min(plii_float8_max(along, zero), one);
        const plii_vec3x8 offset = plii_vec3x8_sub(arm, plii_vec3x8_scale(spoke, share));
        const plii_float8 squared = plii_vec3x8_dot(offset, offset);
        nearest_offset = (plii_vec3x8){plii_float8_select_less(squared, nearest, offset.x, nearest_offset.x),
                                       plii_float8_select_less(squared, nearest, offset.y, nearest_offset.y),
                                       plii_float8_select_less(squared, nearest, offset.z, nearest_offset.z)};
        nearest = plii_float8_min(squared, nearest);
    }
    float squares[PLII_SUPPORT_LANES], x[PLII_SUPPORT_LANES], y[PLII_SUPPORT_LANES], z[PLII_SUPPORT_LANES];
    plii_float8_store(squares, nearest);
    plii_float8_store(x, nearest_offset.x);
    plii_float8_store(y, nearest_offset.y);
    plii_float8_store(z, nearest_offset.z);
    const float least = support_least(nearest);
    int lane = 0;
    while (lane < PLII_SUPPORT_LANES - 1 && squares[lane] > least) {
        ++lane;
    }
    *gap = pli_vec3_make(x[lane], y[lane], z[lane]);
    return squares[lane];
}

bool plii_support_points_has_near(const plii_support_points* groups, pli_vec3 hub, pli_vec3 point, float distance,
                                  pli_vec3* gap) {
    *gap = pli_vec3_make(0, 0, 0);
    if (groups->packed == NULL) { return false; }
    return support_find_gap(groups, hub, point, gap) < distance * distance;
}

int plii_support_points_find_below(const plii_support_points* groups, pli_vec3 foot, pli_vec3 normal, float limit,
                                   pli_vec3* points, float* heights) {
    const plii_vec3x8 from = plii_vec3x8_all(foot), up = plii_vec3x8_all(normal);
    const plii_float8 limits = plii_float8_all(limit);
    int count = 0, left = groups->node_count;
    for (const plii_support_block* block = groups->packed; left > 0; ++block, left -= PLII_SUPPORT_LANES) {
        const plii_float8 above = plii_vec3x8_dot(plii_vec3x8_sub(support_nodes(block), from), up);
        int bits = plii_float8_less_bits(above, limits);
        if (left < PLII_SUPPORT_LANES) { bits &= (1 << left) - 1; }
        if (bits == 0) { continue; }
        float lanes[PLII_SUPPORT_LANES];
        plii_float8_store(lanes, above);
        for (int lane = 0; lane < PLII_SUPPORT_LANES; ++lane) {
            if ((bits >> lane & 1) == 0) { continue; }
            points[count] = pli_vec3_make(block->x[lane], block->y[lane], block->z[lane]);
            heights[count++] = lanes[lane];
        }
    }
    return count;
}

void plii_support_points_release(pli_context* context, plii_support_points* groups) {
    const size_t count = (size_t)groups->node_count;
    plii_release(context, groups->nodes, count * sizeof *groups->nodes);
    plii_release(context, groups->packed, plii_support_block_count(groups) * sizeof *groups->packed);
    plii_release(context, groups->begin, (count + 1) * sizeof *groups->begin);
    plii_release(context, groups->bounds, count * sizeof *groups->bounds);
    *groups = (plii_support_points){0};
}

size_t plii_support_points_bytes(const plii_support_points* groups) {
    const size_t count = (size_t)groups->node_count;
    size_t bytes = count * sizeof *groups->nodes;
    if (groups->packed != NULL) { bytes += plii_support_block_count(groups) * sizeof *groups->packed; }
    if (groups->begin != NULL) { bytes += count * sizeof *groups->bounds + (count + 1) * sizeof *groups->begin; }
    return bytes;
}
