/* Packed coordinates, searched eight at a time. */

#include "math/simd_float8.h"

#include "geometry/support_points.h"

bool plii_support_points_create(pli_context* context, const int* nodes, int node_stride, int node_count,
                                plii_support_points* set) {
    *set = (plii_support_points){0};
    if (node_count < PLII_SUPPORT_POINTS_MIN) { return true; }
    set->node_count = node_count;
    if (!PLII_ALLOCATE(context, &set->nodes, node_count) ||
        !PLII_ALLOCATE(context, &set->packed, plii_support_block_count(set))) {
        plii_support_points_release(context, set);
        return false;
    }
    for (int i = 0; i < node_count; ++i) {
        set->nodes[i] = nodes[i * node_stride];
    }
    return true;
}

void plii_support_points_update(const pli_vec4* positions, plii_support_points* set) {
    const int block_count = (int)plii_support_block_count(set);
    for (int b = 0; b < block_count; ++b) {
        plii_support_block* block = &set->packed[b];
        for (int lane = 0; lane < PLII_SUPPORT_LANES; ++lane) {
            const int i = b * PLII_SUPPORT_LANES + lane;
            const pli_vec4 x = positions[set->nodes[i < set->node_count ? i : 0]];
            block->x[lane] = x.x;
            block->y[lane] = x.y;
            block->z[lane] = x.z;
        }
    }
    set->is_current = true;
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

/* The first of the farthest nodes, as a search one by one finds it: each lane keeps the first of its farthest. Indices
   are counted in floats, and nothing branches: which lane has the farthest node is anybody's guess. */
static int support_farthest(const plii_support_points* set, pli_vec3 direction) {
    const plii_vec3x8 along = plii_vec3x8_all(direction);
    const plii_float8 step = plii_float8_all((float)PLII_SUPPORT_LANES);
    plii_float8 index = plii_float8_of(plii_lanes_xyzw(0, 1, 2, 3), plii_lanes_xyzw(4, 5, 6, 7));
    plii_float8 best = plii_float8_all(-INFINITY), found = index;
    const plii_support_block* end = set->packed + plii_support_block_count(set);
    for (const plii_support_block* block = set->packed; block < end; ++block) {
        const plii_float8 reach = plii_vec3x8_dot(support_nodes(block), along);
        found = plii_float8_select_less(best, reach, index, found);
        best = plii_float8_max(reach, best);
        index = plii_float8_add(index, step);
    }
    const plii_float8 farthest = plii_float8_all(support_largest(best));
    return (int)support_least(plii_float8_select_less(best, farthest, plii_float8_all(INFINITY), found));
}

int plii_support_points_query(const plii_support_points* set, pli_vec3 direction) {
    return set->nodes[support_farthest(set, direction)];
}

float plii_support_points_reach(const plii_support_points* set, pli_vec3 direction) {
    const plii_vec3x8 along = plii_vec3x8_all(direction);
    plii_float8 best = plii_float8_all(-INFINITY);
    const plii_support_block* end = set->packed + plii_support_block_count(set);
    for (const plii_support_block* block = set->packed; block < end; ++block) {
        best = plii_float8_max(plii_vec3x8_dot(support_nodes(block), along), best);
    }
    return support_largest(best);
}

void plii_support_points_release(pli_context* context, plii_support_points* set) {
    PLII_RELEASE(context, set->nodes, set->node_count);
    PLII_RELEASE(context, set->packed, plii_support_block_count(set));
    *set = (plii_support_points){0};
}

size_t plii_support_points_bytes(const plii_support_points* set) {
    return (size_t)set->node_count * sizeof *set->nodes + plii_support_block_count(set) * sizeof *set->packed;
}
