/* Conservation of volume: a pressure of (rest volume - volume) * coefficient on the faces. Bullet: kVC. */

#include "body/pipeline.h"
#include "pliant/forces.h"

/* The pressure is at most twice the one that brings the volume back within the step. From four times on each step would
   overshoot more than the one before; btSoftBody explodes there. */
static void volume_run(pli_body* body, void* state) {
    const plii_pressure* volume = state;
    const pli_vec4* crosses = plii_normals_crosses(body);
    /* A force that acts all through the step, in substeps, is that of its middle, or what swings by it gets energy. */
    const float ahead = body->solver_class->has_substeps ? 0.5f * body->step.dt : 0.0f;
    const float missing = volume->first_volume - plii_pressure_volume(body, crosses, ahead);
    float pressure = missing * volume->coefficient;
    if (crosses != NULL) {
        const float response = plii_pressure_response(body, crosses);
        const float limit = PLII_MAX_VOLUME_CHANGE * fabsf(volume->first_volume) / response;
        if (response * volume->coefficient > 2.0f) { pressure = missing * (2.0f / response); }
        pressure = plii_clamp(pressure, -limit, limit);
    }
    plii_pressure_apply(body, crosses, pressure);
}

enum { VOLUME_ORDER = 30 }; /* after pressure */
const plii_feature_class plii_volume_class = {
    .name = "volume",
    .state_size = sizeof(plii_pressure),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(plii_pressure, coefficient, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_PRESSURE_STATE_PARTS,
    .build = plii_pressure_build,
    .enable = plii_pressure_enable,
    .needs = plii_surface_force_needs,
    .stages = {[PLII_STAGE_FORCES] = {volume_run, VOLUME_ORDER}},
};

pli_status pli_body_enable_volume_conservation(pli_body* body, float coefficient) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &coefficient, &plii_volume_class.settings, __func__));
    PLII_TRY(plii_check_faces(body, "conservation of volume acts on faces", __func__));
    return plii_feature_enable_with(body, &plii_volume_class, &coefficient, sizeof coefficient, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_volume_conservation, plii_check_body_change, plii_volume_class)
