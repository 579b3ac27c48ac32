/* Passes over all nodes or faces of a body that gather one figure: bounds, finiteness, volume. */

#include "body/body_impl.h"
#include "math/simd_float4.h"

typedef struct node_extent {
    plii_float4 low, high;
    plii_float4 sum; /* keeps a NaN, which the two above may lose */
} node_extent;

/* Inline: bodies of a few nodes would notice that it goes through memory. Of four nodes first: what is added to one
   extent waits for what was added before. */
PLII_SIMD_SHARED node_extent node_extent_of(const pli_body* body, const pli_vec4* records) {
    const int count = body->node_count;
    const plii_float4 first = plii_float4_from(&records[0]);
    node_extent extent = {first, first, first};
    int i = 1;
    for (; i + 4 <= count; i += 4) {
        const plii_float4 a = plii_float4_from(&records[i]), b = plii_float4_from(&records[i + 1]);
        const plii_float4 c = plii_float4_from(&records[i + 2]), d = plii_float4_from(&records[i + 3]);
        extent.low = plii_lanes_min(extent.low, plii_lanes_min(plii_lanes_min(a, b), plii_lanes_min(c, d)));
        extent.high = plii_lanes_max(extent.high, plii_lanes_max(plii_lanes_max(a, b), plii_lanes_max(c, d)));
        extent.sum += (a + b) + (c + d);
    }
    for (; i < count; ++i) {
        const plii_float4 x = plii_float4_from(&records[i]);
        extent.low = plii_lanes_min(extent.low, x);
        extent.high = plii_lanes_max(extent.high, x);
        extent.sum += x;
    }
    return extent;
}

/* Of all nodes; x, y and z of every record are numbers no larger than the limit. Then their sum is one too. */
static bool node_extent_is_within(const node_extent* extent, float limit) {
    const plii_mask4 is_within = (-limit <= extent->low) & (extent->high <= limit);
    const plii_mask4 is_number = extent->sum <= extent->sum;
    return (plii_lanes_bits(is_number & is_within) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

bool plii_body_update_bounds(pli_body* body) {
    const node_extent extent = node_extent_of(body, body->positions);
    plii_lanes_to_vec3(&body->bounds.min, extent.low - body->collision_margin);
    plii_lanes_to_vec3(&body->bounds.max, extent.high + body->collision_margin);
    return node_extent_is_within(&extent, PLI_MAX_COORDINATE);
}

pli_bounds plii_body_bounds_of(const pli_body* body, const pli_vec4* records) {
    const node_extent extent = node_extent_of(body, records);
    return (pli_bounds){plii_lanes_vec3(extent.low), plii_lanes_vec3(extent.high)};
}

float plii_body_measure_motion(const pli_body* body, pli_vec3* mean, pli_bounds* bounds) {
    plii_float4 sum = plii_float4_all(0.0f), low = plii_float4_all(INFINITY), high = plii_float4_all(-INFINITY);
    plii_float4 min = low, max = high;
    for (int i = 0; i < body->node_count; ++i) {
        const plii_float4 x = plii_float4_from(&body->positions[i]);
        const plii_float4 motion = x - plii_float4_from(&body->previous[i]);
        min = plii_lanes_min(x, min);
        max = plii_lanes_max(x, max);
        sum = sum + motion;
        low = plii_lanes_min(motion, low);
        high = plii_lanes_max(motion, high);
    }
    sum = sum * (1.0f / (float)body->node_count);
    *mean = plii_lanes_vec3(sum);
    *bounds = (pli_bounds){plii_lanes_vec3(min), plii_lanes_vec3(max)};
    return pli_vec3_length(plii_lanes_vec3(plii_lanes_max(high - sum, sum - low)));
}

bool plii_body_is_slow(const pli_body* body) {
    const node_extent extent = node_extent_of(body, body->velocities);
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

float plii_body_volume(const pli_body* body) {
    const plii_float4 origin = plii_float4_from(&body->positions[0]);
    float volume = 0.0f;
    for (int i = 0; i < body->topology->face_count; ++i) {
        const int* face = body->topology->faces[i];
        const plii_float4 a = plii_float4_from(&body->positions[face[0]]) - origin;
        const plii_float4 b = plii_float4_from(&body->positions[face[1]]) - origin;
        const plii_float4 c = plii_float4_from(&body->positions[face[2]]) - origin;
        volume += plii_lanes_dot(a, plii_lanes_cross(b, c));
    }
    return volume / 6.0f;
}
