/* Conservation of volume: a pressure of (rest volume - volume) * coefficient on the faces. Bullet: kVC. */

#include "body/pipeline.h"
#include "pliant/forces.h"

typedef struct volume_state {
    plii_pressure pressure;
    float rest_volume; /* m^3 */
} volume_state;

/* The pressure is at most twice the one that brings the volume back within the step. From four times on each step would
   overshoot more than the one before; btSoftBody explodes there. */
static void volume_run(pli_body* body, void* state) {
    const volume_state* volume = state;
    const pli_vec4* crosses = plii_normals_crosses(body);
    const float missing = volume->rest_volume - plii_pressure_volume(body, crosses);
    float pressure = missing * volume->pressure.coefficient;
    if (crosses != NULL) {
        const float response = plii_pressure_response(body, crosses);
        const float limit = PLII_MAX_VOLUME_CHANGE * fabsf(volume->rest_volume) / response;
        if (response * volume->pressure.coefficient > 2.0f) { pressure = missing * (2.0f / response); }
        pressure = plii_clamp(pressure, -limit, limit);
    }
    plii_pressure_apply(body, crosses, pressure);
}

static pli_status volume_enable(pli_body* body, void* state) {
    ((volume_state*)state)->rest_volume = plii_pressure_volume(body, plii_normals_crosses(body));
    return PLI_OK;
}

enum { VOLUME_ORDER = 30 }; /* after pressure */
const plii_feature_class plii_volume_class = {
    .name = "volume",
    .state_size = sizeof(volume_state),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(plii_pressure, coefficient, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(volume_state, pressure.coefficient, PLII_SAVED, "f"),
                                    PLII_STATE(volume_state, pressure.is_closed, PLII_LEFT),
                                    PLII_STATE_OF(volume_state, rest_volume, PLII_SAVED, "f")),
    .build = plii_pressure_build,
    .needs = plii_surface_force_needs,
    .stages = {[PLII_STAGE_FORCES] = {volume_run, VOLUME_ORDER}},
    .enable = volume_enable,
};

pli_status pli_body_enable_volume_conservation(pli_body* body, float coefficient) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &coefficient, &plii_volume_class.settings, __func__));
    PLII_TRY(plii_check_faces(body, "conservation of volume acts on faces", __func__));
    return plii_feature_enable_with(body, &plii_volume_class, &coefficient, sizeof coefficient, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_volume_conservation, plii_check_body_change, plii_volume_class)
