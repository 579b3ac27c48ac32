/* Searches of packed coordinates, eight at a time, with what the including file has to offer. */

#include "lanes_twice.h"

#include "support_groups.h"

static inline plii_twice3x4 support_nodes(const plii_support_block* block) {
    return (plii_twice3x4){plii_twice4_load(block->x), plii_twice4_load(block->y), plii_twice4_load(block->z)};
}

static inline float support_least(plii_twice4 a) {
    plii_float4 four = plii_lanes_min(plii_twice4_low(a), plii_twice4_high(a));
    four = plii_lanes_min(four, plii_lanes_all_w(four));
    return plii_lanes_first(plii_lanes_min(plii_lanes_min(four, plii_lanes_all_y(four)), plii_lanes_all_z(four)));
}
static inline float support_largest(plii_twice4 a) {
    plii_float4 four = plii_lanes_max(plii_twice4_low(a), plii_twice4_high(a));
    four = plii_lanes_max(four, plii_lanes_all_w(four));
    return plii_lanes_first(plii_lanes_max(plii_lanes_max(four, plii_lanes_all_y(four)), plii_lanes_all_z(four)));
}

/* The first of the farthest nodes, as a search one by one finds it: each lane keeps the first of its farthest. Places
   are counted in floats, and nothing branches: which lane has the farthest node is anybody's guess. */
static int support_farthest(const plii_support_groups* groups, pli_vec3 direction) {
    const plii_twice3x4 along = plii_twice3x4_all(direction);
    const plii_twice4 step = plii_twice4_all((float)PLII_SUPPORT_LANES);
    plii_twice4 place = plii_twice4_of(plii_lanes_xyzw(0, 1, 2, 3), plii_lanes_xyzw(4, 5, 6, 7));
    plii_twice4 best = plii_twice4_all(-INFINITY), found = place;
    const plii_support_block* end = groups->packed + plii_support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        const plii_twice4 reach = plii_twice3x4_dot(support_nodes(block), along);
        found = plii_twice4_select_less(best, reach, place, found);
        best = plii_twice4_max(reach, best);
        place = plii_twice4_add(place, step);
    }
    const plii_twice4 farthest = plii_twice4_all(support_largest(best));
    return (int)support_least(plii_twice4_select_less(best, farthest, plii_twice4_all(INFINITY), found));
}

static float support_reach(const plii_support_groups* groups, pli_vec3 direction) {
    const plii_twice3x4 along = plii_twice3x4_all(direction);
    plii_twice4 best = plii_twice4_all(-INFINITY);
    const plii_support_block* end = groups->packed + plii_support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        best = plii_twice4_max(plii_twice3x4_dot(support_nodes(block), along), best);
    }
    return support_largest(best);
}

static float support_find_way(const plii_support_groups* groups, pli_vec3 hub, pli_vec3 point, pli_vec3* gap) {
    const plii_twice3x4 from = plii_twice3x4_all(hub), arm = plii_twice3x4_all(pli_vec3_sub(point, hub));
    const plii_twice4 zero = plii_twice4_all(0.0f), one = plii_twice4_all(1.0f), tiny = plii_twice4_all(FLT_MIN);
    plii_twice4 nearest = plii_twice4_all(INFINITY);
    plii_twice3x4 ways = {zero, zero, zero};
    const plii_support_block* end = groups->packed + plii_support_block_count(groups);
    for (const plii_support_block* block = groups->packed; block < end; ++block) {
        const plii_twice3x4 spoke = plii_twice3x4_sub(support_nodes(block), from);
        const plii_twice4 length_squared = plii_twice4_max(plii_twice3x4_dot(spoke, spoke), tiny);
        const plii_twice4 along = plii_twice4_div(plii_twice3x4_dot(arm, spoke), length_squared);
        const plii_twice4 share = plii_twice4_min(plii_twice4_max(along, zero), one);
        const plii_twice3x4 way = plii_twice3x4_sub(arm, plii_twice3x4_scale(spoke, share));
        const plii_twice4 squared = plii_twice3x4_dot(way, way);
        ways = (plii_twice3x4){plii_twice4_select_less(squared, nearest, way.x, ways.x),
                               plii_twice4_select_less(squared, nearest, way.y, ways.y),
                               plii_twice4_select_less(squared, nearest, way.z, ways.z)};
        nearest = plii_twice4_min(squared, nearest);
    }
    float squares[PLII_SUPPORT_LANES], x[PLII_SUPPORT_LANES], y[PLII_SUPPORT_LANES], z[PLII_SUPPORT_LANES];
    plii_twice4_store(squares, nearest);
    plii_twice4_store(x, ways.x);
    plii_twice4_store(y, ways.y);
    plii_twice4_store(z, ways.z);
    const float least = support_least(nearest);
    int lane = 0;
    while (lane < PLII_SUPPORT_LANES - 1 && squares[lane] > least) {
        ++lane;
    }
    *gap = pli_vec3_make(x[lane], y[lane], z[lane]);
    return squares[lane];
}

static int support_find_below(const plii_support_groups* groups, pli_vec3 foot, pli_vec3 normal, float limit,
                              pli_vec3* points, float* heights) {
    const plii_twice3x4 from = plii_twice3x4_all(foot), up = plii_twice3x4_all(normal);
    const plii_twice4 limits = plii_twice4_all(limit);
    int count = 0, left = groups->node_count;
    for (const plii_support_block* block = groups->packed; left > 0; ++block, left -= PLII_SUPPORT_LANES) {
        const plii_twice4 above = plii_twice3x4_dot(plii_twice3x4_sub(support_nodes(block), from), up);
        int bits = plii_twice4_less_bits(above, limits);
        if (left < PLII_SUPPORT_LANES) { bits &= (1 << left) - 1; }
        if (bits == 0) { continue; }
        float lanes[PLII_SUPPORT_LANES];
        plii_twice4_store(lanes, above);
        for (int lane = 0; lane < PLII_SUPPORT_LANES; ++lane) {
            if ((bits >> lane & 1) == 0) { continue; }
            points[count] = pli_vec3_make(block->x[lane], block->y[lane], block->z[lane]);
            heights[count++] = lanes[lane];
        }
    }
    return count;
}
