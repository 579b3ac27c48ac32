/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "body/body_impl.h"
#include "math/simd_float4.h"

const plii_feature_class* const plii_surface_force_needs[] = {&plii_forces_class, &plii_normals_class,
                                                              &plii_areas_class, NULL};

const plii_feature_class plii_forces_class = {
    .name = "forces",
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(pli_body, forces), PLII_PER_NODE, .is_in_body = true, .is_kept = true, PLII_SAVED_AS("3f")})};

float plii_forces_volume_response(const pli_body* body, float dt) {
    float sum = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        sum += body->positions[i].w * body->areas[i] * body->areas[i];
    }
    return dt * dt * sum;
}

void plii_forces_add_along_normals(pli_body* body, float scale) {
    const pli_vec4* restrict positions = body->positions;
    const pli_vec3* restrict normals = body->normals;
    const float* restrict areas = body->areas;
    pli_vec3* restrict forces = body->forces;
    const int count = body->node_count;
    int i = 0;
    for (; i + PLII_LANES <= count; i += PLII_LANES) {
        const plii_vec3x4 force = plii_vec3x4_from(&forces[i]);
        const plii_float4 scaled_areas = plii_float4_load(&areas[i]) * scale;
        const plii_vec3x4 added = plii_vec3x4_scale(plii_vec3x4_from(&normals[i]), scaled_areas);
        const plii_mask4 is_free =
            plii_lanes_xyzw(positions[i].w, positions[i + 1].w, positions[i + 2].w, positions[i + 3].w) > 0.0f;
        plii_vec3x4_to(&forces[i], plii_vec3x4_select(is_free, plii_vec3x4_add(force, added), force));
    }
    for (; i < count; ++i) {
        if (!(positions[i].w > 0.0f)) { continue; }
        forces[i] = pli_vec3_add(forces[i], pli_vec3_scale(normals[i], areas[i] * scale));
    }
}
