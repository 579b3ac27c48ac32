/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "body/world_state.h"
#include "math/simd_float4.h"

const plii_feature_class* const plii_surface_force_needs[] = {&plii_forces_class, &plii_normals_class,
                                                              &plii_areas_class, NULL};

const plii_feature_class plii_forces_class = {
    .name = "forces",
    .is_made_by_calls = true,
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(pli_body, forces), PLII_PER_NODE, .is_in_body = true, .is_kept = true, PLII_SAVED_AS("3f")})};

void plii_pressure_build(pli_body* body, void* state) {
    plii_pressure* pressure = state;
    const bool was_closed = pressure->is_closed;
    pressure->is_closed = plii_topology_is_closed(body->topology);
    if (was_closed && !pressure->is_closed && !body->world->def.reference_mode) { pressure->coefficient = 0.0f; }
}

pli_status plii_pressure_enable(pli_body* body, void* state) {
    ((plii_pressure*)state)->first_volume = plii_pressure_volume(body, plii_normals_crosses(body), 0.0f);
    return PLI_OK;
}

float plii_pressure_volume(const pli_body* body, const pli_vec4* crosses, float ahead) {
    if (crosses == NULL) { return plii_body_volume(body); }
    const plii_float4 origin = plii_float4_from(&body->positions[0]);
    float sum = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const plii_float4 motion = plii_float4_from(&body->velocities[i]) * (3.0f * ahead);
        sum += plii_lanes_dot(plii_float4_from(&body->positions[i]) - origin + motion, plii_float4_from(&crosses[i]));
    }
    return sum / 18.0f;
}

float plii_pressure_response(const pli_body* body, const pli_vec4* crosses) {
    float sum = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        sum += body->positions[i].w * pli_vec3_length_squared(plii_xyz(crosses[i]));
    }
    return body->step.dt * body->step.dt * sum / 36.0f;
}

void plii_pressure_apply(pli_body* body, const pli_vec4* crosses, float pressure) {
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const pli_vec3 force = crosses != NULL ? pli_vec3_scale(plii_xyz(crosses[i]), pressure / 6.0f)
                                               : pli_vec3_scale(body->normals[i], body->areas[i] * pressure);
        body->forces[i] = pli_vec3_add(body->forces[i], force);
    }
}
