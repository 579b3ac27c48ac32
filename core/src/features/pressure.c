/* Pressure of a gas in a closed surface: coefficient / |volume| on its faces. Bullet: kPR in applyForces. */

#include "body/pipeline.h"
#include "pliant/forces.h"

static void pressure_run(pli_body* body, void* state) {
    const plii_pressure* pressure = state;
    if (body->solver_class->has_substeps && body->gas != NULL) {
        *body->gas = pressure->coefficient;
        return;
    }
    const pli_vec4* crosses = plii_normals_crosses(body);
    const float volume = fabsf(plii_pressure_volume(body, crosses, 0.0f));
    float scale = 1.0f / volume * pressure->coefficient;
    /* No volume, no pressure: instead of an infinite one. */
    if (!plii_is_finite(scale)) { return; }
    if (crosses != NULL) {
        const float response = plii_pressure_response(body, crosses);
        /* What is pressed flat is held up by as much as what is full, unless by the pressure of the volume after the
           step the body grew by less: else it would get more energy than is in the gas. */
        const float work = 4.0f * response * fabsf(pressure->coefficient);
        const float growth = 0.5f * (sqrtf(volume * volume + work) - volume);
        const float most = plii_min(PLII_MAX_VOLUME_CHANGE * fabsf(pressure->first_volume), growth);
        const float limit = plii_max(PLII_MAX_VOLUME_CHANGE * volume, most) / response;
        scale = plii_clamp(scale, -limit, limit);
    }
    plii_pressure_apply(body, crosses, scale);
}

enum { PRESSURE_ORDER = 20 }; /* between vertex and face aerodynamics */
const plii_feature_class plii_pressure_class = {
    .name = "pressure",
    .state_size = sizeof(plii_pressure),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(plii_pressure, coefficient, -PLI_MAX_COEFFICIENT, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_PRESSURE_STATE_PARTS,
    .build = plii_pressure_build,
    .enable = plii_pressure_enable,
    .needs = plii_surface_force_needs,
    .stages = {[PLII_STAGE_FORCES] = {pressure_run, PRESSURE_ORDER}},
};

pli_status pli_body_enable_pressure(pli_body* body, float coefficient) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &coefficient, &plii_pressure_class.settings, __func__));
    PLII_TRY(plii_check_faces(body, "pressure acts on faces", __func__));
    return plii_feature_enable_with(body, &plii_pressure_class, &coefficient, sizeof coefficient, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_pressure, plii_check_body_change, plii_pressure_class)
