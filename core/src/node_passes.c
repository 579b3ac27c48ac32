/* Passes over all nodes or faces of a body that gather one figure: bounds, finiteness, volume. */

#include "lanes.h"

#include "body_impl.h"

/* Two chains, since each comparison waits for the one before. */
bool plii_body_update_bounds(pli_body* body) {
    const pli_vec4* positions = body->positions;
    const int count = body->node_count;
    plii_float4 low[2], high[2];
    plii_mask4 finite[2];
    low[0] = low[1] = high[0] = high[1] = plii_float4_from(&positions[0]);
    finite[0] = finite[1] = plii_lanes_finite(low[0]);
    for (int i = 1; i + 1 < count; i += 2) {
        const plii_float4 a = plii_float4_from(&positions[i]), b = plii_float4_from(&positions[i + 1]);
        low[0] = plii_lanes_min(a, low[0]);
        high[0] = plii_lanes_max(a, high[0]);
        low[1] = plii_lanes_min(b, low[1]);
        high[1] = plii_lanes_max(b, high[1]);
        finite[0] = plii_lanes_both(finite[0], plii_lanes_finite(a));
        finite[1] = plii_lanes_both(finite[1], plii_lanes_finite(b));
    }
    const plii_float4 last = plii_float4_from(&positions[count - 1]);
    pli_bounds bounds;
    plii_lanes_to_vec3(&bounds.min, plii_lanes_min(last, plii_lanes_min(low[1], low[0])));
    plii_lanes_to_vec3(&bounds.max, plii_lanes_max(last, plii_lanes_max(high[1], high[0])));
    body->bounds = plii_bounds_grow(bounds, body->collision_margin);
    const plii_mask4 all = plii_lanes_both(plii_lanes_finite(last), plii_lanes_both(finite[0], finite[1]));
    return (plii_lanes_bits(all) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

int plii_body_find_non_finite_node(const pli_body* body) {
    for (int i = 0; i < body->node_count; ++i) {
        if (!plii_vec3_is_finite(plii_xyz(body->positions[i]))) { return i; }
    }
    return PLI_NULL_INDEX;
}

/* Corners of four faces, from the origin. */
PLII_SIMD_INLINE plii_vec3x4 body_corners(const pli_vec4* positions, const int (*faces)[3], int corner,
                                          plii_vec3x4 origin) {
    plii_float4 rows[4] = {
        plii_float4_from(&positions[faces[0][corner]]), plii_float4_from(&positions[faces[1][corner]]),
        plii_float4_from(&positions[faces[2][corner]]), plii_float4_from(&positions[faces[3][corner]])};
    plii_float4_turn(rows);
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
