/* Lift and drag of nodes or faces that move relative to the wind.
   Bullet: addAeroForceToNode and addAeroForceToFace, in their order of operations. Two classes, because the vertex
   models act before pressure and the face models after it. */

#include "pliant/forces.h"

#include "body_impl.h"
#include "world_impl.h"

/* Cosine of 10 degrees: below this angle of attack a lift-drag model has no lift. */
#define AERO_MAX_LIFT_COSINE 0.98480f

typedef struct aero_state {
    pli_aero_model model;
    float lift, drag;
    pli_vec3 wind;
} aero_state;

static pli_vec3 aero_face_wind(pli_vec3 normal, pli_vec3 velocity) {
    return pli_vec3_dot(normal, velocity) < 0.0f ? pli_vec3_neg(normal) : normal;
}

/* Lift-drag models: forces on an area that moves at `velocity` relative to the air. */
static void aero_lift_and_drag(const aero_state* aero, float density, float doubled_area, pli_vec3 normal,
                               pli_vec3 velocity, pli_vec3* lift, pli_vec3* drag) {
    const float speed = pli_vec3_length(velocity);
    const float speed_squared = pli_vec3_length_squared(velocity);
    const pli_vec3 direction = plii_vec3_divide(velocity, speed);
    normal = aero_face_wind(normal, velocity);
    const float cosine = pli_vec3_dot(normal, direction);
    const float area = 0.5f * doubled_area;

    *drag = pli_vec3_scale(pli_vec3_neg(direction), 0.5f * aero->drag * density * speed_squared * area * cosine);
    *lift = pli_vec3_make(0, 0, 0);
    if (0.0f < cosine && cosine < AERO_MAX_LIFT_COSINE) {
        const pli_vec3 upward = pli_vec3_cross(pli_vec3_cross(normal, direction), direction);
        *lift = pli_vec3_scale(upward, 0.5f * aero->lift * density * speed * area * sqrtf(1.0f - cosine * cosine));
    }
}

/* Drag that would do more than stop the node within the step is cut to 80 % of that. */
static pli_vec3 aero_limit_drag(pli_vec3 drag, pli_vec3 velocity, float inverse_mass, float dt) {
    const pli_vec3 change = pli_vec3_scale(pli_vec3_scale(drag, inverse_mass), dt);
    const float change_squared = pli_vec3_length_squared(change);
    if (change_squared >= pli_vec3_length_squared(velocity) && change_squared > 0.0f) {
        return pli_vec3_scale(drag, 0.8f * (pli_vec3_length(velocity) / pli_vec3_length(change)));
    }
    return drag;
}

/* One- and two-sided models: force on a surface that moves against the air with its front, false when it does not. */
static bool aero_resistance(const aero_state* aero, float density, float doubled_area, float area_share,
                            pli_vec3 normal, pli_vec3 velocity, pli_vec3* force) {
    const float approach = pli_vec3_dot(velocity, normal);
    if (!(approach > 0.0f)) { return false; }
    const float scale = doubled_area * approach * pli_vec3_length_squared(velocity) * area_share * density;
    const pli_vec3 direction = plii_vec3_divide(velocity, pli_vec3_length(velocity));
    *force = pli_vec3_add(pli_vec3_scale(normal, -scale * aero->lift), pli_vec3_scale(direction, -scale * aero->drag));
    return true;
}

/* A force that would change the velocity by more than its amount only cancels the velocity along itself. */
static void aero_add_clamped(pli_body* body, int node, pli_vec3 force, float dt) {
    const float response = dt * body->positions[node].w;
    const pli_vec3 velocity = plii_xyz(body->velocities[node]);
    pli_vec3* sum = &body->forces[node];
    if (pli_vec3_length_squared(pli_vec3_scale(force, response)) > pli_vec3_length_squared(velocity)) {
        const pli_vec3 axis = plii_vec3_divide(force, pli_vec3_length(force));
        const pli_vec3 along = pli_vec3_scale(axis, pli_vec3_dot(velocity, axis));
        *sum = pli_vec3_sub(*sum, plii_vec3_divide(along, response));
    } else {
        *sum = pli_vec3_add(*sum, force);
    }
}

static void aero_run_vertices(pli_body* body, void* state, const plii_step* step) {
    const aero_state* aero = state;
    const float density = body->world->def.air_density;
    for (int i = 0; i < body->node_count; ++i) {
        const float inverse_mass = body->positions[i].w;
        const pli_vec3 own_velocity = plii_xyz(body->velocities[i]);
        const pli_vec3 velocity = pli_vec3_sub(own_velocity, aero->wind);
        if (!(inverse_mass > 0.0f) || !(pli_vec3_length_squared(velocity) > PLII_EPSILON)) { continue; }

        pli_vec3 normal = body->normals[i];
        if (aero->model == PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG) {
            pli_vec3 lift, drag;
            aero_lift_and_drag(aero, density, body->areas[i], normal, velocity, &lift, &drag);
            drag = aero_limit_drag(drag, own_velocity, inverse_mass, step->dt);
            body->forces[i] = pli_vec3_add(pli_vec3_add(body->forces[i], drag), lift);
        } else {
            if (aero->model == PLI_AERO_VERTEX_TWO_SIDED) { normal = aero_face_wind(normal, velocity); }
            pli_vec3 force;
            if (aero_resistance(aero, density, body->areas[i], 0.5f, normal, velocity, &force)) {
                aero_add_clamped(body, i, force, step->dt);
            }
        }
    }
}

static void aero_run_faces(pli_body* body, void* state, const plii_step* step) {
    const aero_state* aero = state;
    const float density = body->world->def.air_density;
    const plii_topology* topology = body->topology;
    for (int f = 0; f < topology->face_count; ++f) {
        const int* nodes = topology->faces[f];
        const pli_vec3 sum =
            pli_vec3_add(pli_vec3_add(plii_xyz(body->velocities[nodes[0]]), plii_xyz(body->velocities[nodes[1]])),
                         plii_xyz(body->velocities[nodes[2]]));
        const pli_vec3 velocity = pli_vec3_sub(plii_vec3_divide(sum, 3.0f), aero->wind);
        if (!(pli_vec3_length_squared(velocity) > PLII_EPSILON)) { continue; }

        pli_vec3 normal = body->face_normals[f];
        if (aero->model == PLI_AERO_FACE_TWO_SIDED_LIFT_DRAG) {
            pli_vec3 lift, drag;
            aero_lift_and_drag(aero, density, body->face_areas[f], normal, velocity, &lift, &drag);
            drag = plii_vec3_divide(drag, 3.0f);
            lift = plii_vec3_divide(lift, 3.0f);
            for (int k = 0; k < 3; ++k) {
                const float inverse_mass = body->positions[nodes[k]].w;
                if (!(inverse_mass > 0.0f)) { continue; }
                /* As in Bullet, what one node limits stays limited for the next. */
                drag = aero_limit_drag(drag, plii_xyz(body->velocities[nodes[k]]), inverse_mass, step->dt);
                body->forces[nodes[k]] = pli_vec3_add(pli_vec3_add(body->forces[nodes[k]], drag), lift);
            }
        } else {
            if (aero->model == PLI_AERO_FACE_TWO_SIDED) { normal = aero_face_wind(normal, velocity); }
            pli_vec3 force;
            if (!aero_resistance(aero, density, body->face_areas[f], 1.0f, normal, velocity, &force)) { continue; }
            force = plii_vec3_divide(force, 3.0f);
            for (int k = 0; k < 3; ++k) {
                /* A pinned node has no response to divide by. */
                if (body->positions[nodes[k]].w > 0.0f) { aero_add_clamped(body, nodes[k], force, step->dt); }
            }
        }
    }
}

static const plii_feature_class* const aero_needs[] = {&plii_forces_class, &plii_normals_class, &plii_areas_class,
                                                       NULL};

static const plii_feature_class aero_vertex_class = {
    .name = "vertex aerodynamics",
    .state_size = sizeof(aero_state),
    .needs = aero_needs,
    .stages = {[PLII_STAGE_FORCES] = {aero_run_vertices, PLII_ORDER_AERO}},
};

static const plii_feature_class aero_face_class = {
    .name = "face aerodynamics",
    .state_size = sizeof(aero_state),
    .needs = aero_needs,
    .stages = {[PLII_STAGE_FORCES] = {aero_run_faces, PLII_ORDER_FACE_AERO}},
};

pli_aero_def pli_aero_def_default(void) {
    pli_aero_def def = {0};
    def.cookie = PLII_DEF_COOKIE;
    return def;
}

static pli_status aero_check(pli_context* context, const pli_aero_def* def, const char* function) {
    if (def == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "def was not made by pli_aero_def_default");
    }
    const int model = (int)def->model;
    if (model < (int)PLI_AERO_VERTEX_POINT || model > (int)PLI_AERO_FACE_ONE_SIDED) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "there is no model %d, the last one is %d", model,
                         (int)PLI_AERO_FACE_ONE_SIDED);
    }
    if (!plii_is_finite(def->lift) || !plii_is_finite(def->drag)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "lift is %g and drag is %g", (double)def->lift,
                         (double)def->drag);
    }
    if (def->lift < 0.0f || def->drag < 0.0f) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "lift is %g and drag is %g, at least 0 is allowed",
                         (double)def->lift, (double)def->drag);
    }
    if (!plii_vec3_is_finite(def->wind)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "wind is (%g, %g, %g)", (double)def->wind.x,
                         (double)def->wind.y, (double)def->wind.z);
    }
    return PLI_OK;
}

pli_status pli_body_enable_aero(pli_body* body, const pli_aero_def* def) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(aero_check(body->context, def, __func__));
    if (body->topology->face_count == 0) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_MESH, "aerodynamics act on faces, the body has none");
    }
    const bool on_faces = (int)def->model >= (int)PLI_AERO_FACE_TWO_SIDED;
    void* state = NULL;
    PLII_TRY(plii_feature_enable(body, on_faces ? &aero_face_class : &aero_vertex_class, &state));
    plii_feature_disable(body, on_faces ? &aero_vertex_class : &aero_face_class);
    aero_state* aero = state;
    aero->model = def->model;
    aero->lift = def->lift;
    aero->drag = def->drag;
    aero->wind = def->wind;
    return PLI_OK;
}

pli_status pli_body_set_wind(pli_body* body, pli_vec3 wind) {
    PLII_TRY(plii_check_body(body, __func__));
    if (!plii_vec3_is_finite(wind)) {
        return PLII_FAIL(body->context, PLI_ERROR_NOT_FINITE, "wind is (%g, %g, %g)", (double)wind.x, (double)wind.y,
                         (double)wind.z);
    }
    aero_state* aero = plii_feature_state(body, &aero_vertex_class);
    if (aero == NULL) { aero = plii_feature_state(body, &aero_face_class); }
    if (aero == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "aerodynamics are not enabled"); }
    aero->wind = wind;
    return PLI_OK;
}

void pli_body_disable_aero(pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return; }
    plii_feature_disable(body, &aero_vertex_class);
    plii_feature_disable(body, &aero_face_class);
}
