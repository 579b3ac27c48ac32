/* Passes over all nodes or faces of a body that gather one figure: bounds, finiteness, volume. */

#include "body/body_impl.h"
#include "math/range.h"
#include "math/simd_float4.h"

#include <string.h>

enum { NODE_PASSES_BLOCK = 4096, NODE_PASSES_MAX_BLOCKS = 32 };

typedef struct node_extent {
    plii_float4 low, high;
    plii_float4 sum; /* keeps a NaN, which the two above may lose */
} node_extent;

typedef struct node_extents_task {
    const pli_vec4* records;
    int count, block;
    node_extent* extents; /* [blocks] */
} node_extents_task;

PLII_SIMD_INLINE node_extent node_extent_of(const pli_vec4* records, int begin, int end) {
    const plii_float4 first = plii_float4_from(&records[begin]);
    node_extent extent = {first, first, first};
    for (int i = begin + 1; i < end; ++i) {
        const plii_float4 x = plii_float4_from(&records[i]);
        extent.low = plii_lanes_min(extent.low, x);
        extent.high = plii_lanes_max(extent.high, x);
        extent.sum += x;
    }
    return extent;
}

static void node_extents_range(int begin, int end, void* data) {
    const node_extents_task* task = data;
    for (int b = begin; b < end; ++b) {
        const int first = b * task->block, rest = task->count - first;
        task->extents[b] = node_extent_of(task->records, first, first + (rest < task->block ? rest : task->block));
    }
}

/* Blocks depend on the number of nodes alone, so that the bits do not depend on threads. */
static node_extent node_extent_in_blocks(const pli_body* body, const pli_vec4* records) {
    const int count = body->node_count, least = (count + NODE_PASSES_MAX_BLOCKS - 1) / NODE_PASSES_MAX_BLOCKS;
    const int block = least > NODE_PASSES_BLOCK ? least : NODE_PASSES_BLOCK, block_count = (count + block - 1) / block;
    node_extent extents[NODE_PASSES_MAX_BLOCKS];
    memset(extents, 0, sizeof extents);
    node_extents_task task = {records, count, block, extents};
    plii_parallel_for(body->context, node_extents_range, &task, block_count, 1);
    node_extent all = extents[0];
    for (int b = 1; b < block_count; ++b) {
        all.low = plii_lanes_min(all.low, extents[b].low);
        all.high = plii_lanes_max(all.high, extents[b].high);
        all.sum += extents[b].sum;
    }
    return all;
}

/* Of all nodes; x, y and z of every record are numbers no larger than the limit. Then their sum is one too. */
static bool node_extent_is_within(const node_extent* extent, float limit) {
    const plii_mask4 is_within = (-limit <= extent->low) & (extent->high <= limit);
    const plii_mask4 is_number = extent->sum <= extent->sum;
    return (plii_lanes_bits(is_number & is_within) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

/* Inline: bodies of a few nodes would notice that it goes through memory. */
PLII_SIMD_INLINE node_extent node_extent_all(const pli_body* body, const pli_vec4* records) {
    return body->node_count > NODE_PASSES_BLOCK ? node_extent_in_blocks(body, records)
                                                : node_extent_of(records, 0, body->node_count);
}

bool plii_body_update_bounds(pli_body* body) {
    const node_extent extent = node_extent_all(body, body->positions);
    plii_lanes_to_vec3(&body->bounds.min, extent.low - body->collision_margin);
    plii_lanes_to_vec3(&body->bounds.max, extent.high + body->collision_margin);
    return node_extent_is_within(&extent, PLI_MAX_COORDINATE);
}

bool plii_body_is_slow(const pli_body* body) {
    const node_extent extent = node_extent_all(body, body->velocities);
    return node_extent_is_within(&extent, PLI_MAX_SPEED);
}

int plii_body_find_lost_node(const pli_body* body) {
    for (int i = 0; i < body->node_count; ++i) {
        if (!plii_is_point(plii_xyz(body->positions[i])) ||
            !plii_vec3_is_within(plii_xyz(body->velocities[i]), PLI_MAX_SPEED)) {
            return i;
        }
    }
    return PLI_NULL_INDEX;
}

/* Corners of four faces, from the origin. */
PLII_SIMD_INLINE plii_vec3x4 body_corners(const pli_vec4* positions, const int (*faces)[3], int corner,
                                          plii_vec3x4 origin) {
    plii_float4 rows[4] = {
        plii_float4_from(&positions[faces[0][corner]]), plii_float4_from(&positions[faces[1][corner]]),
        plii_float4_from(&positions[faces[2][corner]]), plii_float4_from(&positions[faces[3][corner]])};
    plii_float4_transpose(rows);
    return plii_vec3x4_sub((plii_vec3x4){rows[0], rows[1], rows[2]}, origin);
}

float plii_body_volume(const pli_body* body) {
    const pli_vec4* positions = body->positions;
    const int(*faces)[3] = (const int(*)[3])body->topology->faces;
    const int count = body->topology->face_count;
    const plii_vec3x4 origin = plii_vec3x4_all(plii_xyz(positions[0]));
    float volume = 0.0f;
    int i = 0;
    for (; i + PLII_LANES <= count; i += PLII_LANES) {
        const plii_vec3x4 a = body_corners(positions, &faces[i], 0, origin);
        const plii_vec3x4 b = body_corners(positions, &faces[i], 1, origin);
        const plii_vec3x4 c = body_corners(positions, &faces[i], 2, origin);
        float parts[PLII_LANES];
        plii_float4_store(parts, plii_vec3x4_dot(a, plii_vec3x4_cross(b, c)));
        volume = volume + parts[0] + parts[1] + parts[2] + parts[3];
    }
    for (; i < count; ++i) {
        const pli_vec3 x = plii_xyz(positions[0]);
        const pli_vec3 a = pli_vec3_sub(plii_xyz(positions[faces[i][0]]), x);
        const pli_vec3 b = pli_vec3_sub(plii_xyz(positions[faces[i][1]]), x);
        const pli_vec3 c = pli_vec3_sub(plii_xyz(positions[faces[i][2]]), x);
        volume += pli_vec3_dot(a, pli_vec3_cross(b, c));
    }
    return volume / 6.0f;
}
