/* Pressures on the faces: of a gas in a closed surface, coefficient / |volume|, and one of (rest volume - volume) *
   coefficient that conserves the volume. Bullet: kPR and kVC in applyForces. Two classes, as they come one after the
   other, and a body may have both. */

#include "body/pipeline.h"
#include "math/simd_float4.h"
#include "pliant/forces.h"

typedef struct pressure_state {
    float coefficient;
    bool is_closed;     /* follows from the faces */
    float first_volume; /* m^3, when it was enabled */
} pressure_state;

/* m^3, signed; `ahead` s from now, were velocities to stay; without the cross products now, in Bullet's order. */
static float pressure_volume(const pli_body* body, const pli_vec4* crosses, float ahead) {
    if (crosses == NULL) { return plii_body_volume(body); }
    const plii_float4 origin = plii_float4_from(&body->positions[0]);
    float sum = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const plii_float4 motion = plii_float4_from(&body->velocities[i]) * (3.0f * ahead);
        sum += plii_lanes_dot(plii_float4_from(&body->positions[i]) - origin + motion, plii_float4_from(&crosses[i]));
    }
    return sum / 18.0f;
}

/* m^3/Pa: change of the volume in a step by such a pressure. Steps add dt^2 w times the force to positions. */
static float pressure_response(const pli_body* body, const pli_vec4* crosses) {
    float sum = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        sum += body->positions[i].w * pli_vec3_length_squared(plii_xyz(crosses[i]));
    }
    return body->step.dt * body->step.dt * sum / 36.0f;
}

/* Adds what a pressure on the faces does to the forces on the nodes that are not pinned: the gradient of the volume, so
   that it moves and turns nothing as a whole. Without the cross products normal * area, as btSoftBody. */
static void pressure_apply(pli_body* body, const pli_vec4* crosses, float pressure) {
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const pli_vec3 force = crosses != NULL ? pli_vec3_scale(plii_xyz(crosses[i]), pressure / 6.0f)
                                               : pli_vec3_scale(body->normals[i], body->areas[i] * pressure);
        body->forces[i] = pli_vec3_add(body->forces[i], force);
    }
}

static void pressure_run(pli_body* body, void* data) {
    const pressure_state* state = data;
    if (body->solver_class->has_substeps && body->gas != NULL) {
        *body->gas = state->coefficient;
        return;
    }
    const pli_vec4* crosses = plii_normals_crosses(body);
    const float volume = fabsf(pressure_volume(body, crosses, 0.0f));
    float pressure = 1.0f / volume * state->coefficient;
    /* No volume, no pressure: instead of an infinite one. */
    if (!plii_is_finite(pressure)) { return; }
    if (crosses != NULL) {
        const float response = pressure_response(body, crosses);
        /* What is pressed flat is held up by as much as what is full, unless by the pressure of the volume after the
           step the body grew by less: else it would get more energy than is in the gas. */
        const float work = 4.0f * response * fabsf(state->coefficient);
        const float growth = 0.5f * (sqrtf(volume * volume + work) - volume);
        const float most = plii_min(PLII_MAX_VOLUME_CHANGE * fabsf(state->first_volume), growth);
        const float limit = plii_max(PLII_MAX_VOLUME_CHANGE * volume, most) / response;
        pressure = plii_clamp(pressure, -limit, limit);
    }
    pressure_apply(body, crosses, pressure);
}

/* The pressure is at most twice the one that brings the volume back within the step. From four times on each step would
   overshoot more than the one before; btSoftBody explodes there. */
static void volume_run(pli_body* body, void* data) {
    const pressure_state* state = data;
    const pli_vec4* crosses = plii_normals_crosses(body);
    /* A force that acts all through the step, in substeps, is that of its middle, or what swings by it gets energy. */
    const float ahead = body->solver_class->has_substeps ? 0.5f * body->step.dt : 0.0f;
    const float missing = state->first_volume - pressure_volume(body, crosses, ahead);
    float pressure = missing * state->coefficient;
    if (crosses != NULL) {
        const float response = pressure_response(body, crosses);
        const float limit = PLII_MAX_VOLUME_CHANGE * fabsf(state->first_volume) / response;
        if (response * state->coefficient > 2.0f) { pressure = missing * (2.0f / response); }
        pressure = plii_clamp(pressure, -limit, limit);
    }
    pressure_apply(body, crosses, pressure);
}

static void pressure_enable(pli_body* body, void* state) {
    ((pressure_state*)state)->first_volume = pressure_volume(body, plii_normals_crosses(body), 0.0f);
}

/* A cut that opens a closed surface lets the pressure out, but in reference mode. */
static void pressure_build(pli_body* body, void* data) {
    pressure_state* state = data;
    const bool was_closed = state->is_closed;
    state->is_closed = plii_topology_is_closed(body->topology);
    if (was_closed && !state->is_closed && !body->world->def.reference_mode) { state->coefficient = 0.0f; }
}

/* What both classes have. */
#define PRESSURE_CLASS                                                                                                 \
    .state_size = sizeof(pressure_state),                                                                              \
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(pressure_state, coefficient, PLII_SAVED, "f"),                       \
                                    PLII_STATE(pressure_state, is_closed, PLII_LEFT),                                  \
                                    PLII_STATE_OF(pressure_state, first_volume, PLII_SAVED, "f")),                     \
    .build = pressure_build, .enable = pressure_enable, .needs = plii_surface_force_needs

enum { PRESSURE_ORDER = 20, VOLUME_ORDER = 30 }; /* between vertex and face aerodynamics */
const plii_feature_class plii_pressure_class = {
    .name = "pressure",
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(pressure_state, coefficient, -PLI_MAX_COEFFICIENT, PLI_MAX_COEFFICIENT)),
    .stages = {[PLII_STAGE_FORCES] = {pressure_run, PRESSURE_ORDER}},
    PRESSURE_CLASS,
};
const plii_feature_class plii_volume_class = {
    .name = "volume",
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(pressure_state, coefficient, 0, PLI_MAX_COEFFICIENT)),
    .stages = {[PLII_STAGE_FORCES] = {volume_run, VOLUME_ORDER}},
    PRESSURE_CLASS,
};

static pli_status pressure_enable_class(pli_body* body, const plii_feature_class* klass, float coefficient,
                                        const char* need, const char* function) {
    PLII_TRY(plii_check_body_change(body, function));
    PLII_TRY(plii_check_limits(body->context, &coefficient, &klass->settings, function));
    PLII_TRY(plii_check_faces(body, need, function));
    return plii_feature_enable_with(body, klass, &coefficient, sizeof coefficient, NULL);
}
pli_status pli_body_enable_pressure(pli_body* body, float coefficient) {
    return pressure_enable_class(body, &plii_pressure_class, coefficient, "pressure acts on faces", __func__);
}
pli_status pli_body_enable_volume_conservation(pli_body* body, float coefficient) {
    const char* need = "conservation of volume acts on faces";
    return pressure_enable_class(body, &plii_volume_class, coefficient, need, __func__);
}
PLII_DEFINE_DISABLE(pli_body_disable_pressure, plii_check_body_change, plii_pressure_class)
PLII_DEFINE_DISABLE(pli_body_disable_volume_conservation, plii_check_body_change, plii_volume_class)
