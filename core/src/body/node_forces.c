/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "body/body_impl.h"

const plii_feature_class* const plii_surface_force_needs[] = {&plii_forces_class, &plii_normals_class,
                                                              &plii_areas_class, NULL};

const plii_feature_class plii_forces_class = {
    .name = "forces",
    .is_made_by_calls = true,
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
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        body->forces[i] = pli_vec3_add(body->forces[i], pli_vec3_scale(body->normals[i], body->areas[i] * scale));
    }
}
