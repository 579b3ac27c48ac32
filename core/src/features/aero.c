/* Lift and drag of nodes or faces that move relative to the wind. Bullet: addAeroForceToNode, addAeroForceToFace, in
   their order of operations; two classes, as vertex models act before pressure and face models after it. */

#include "body/pipeline.h"
#include "math/simd_float4.h"
#include "pliant/forces.h"

/* Cosine of 10 degrees: below this angle of attack a lift-drag model has no lift. */
#define AERO_MAX_LIFT_COSINE 0.98480f

typedef struct aero_state {
    pli_aero_def def;
    pli_vec3* face_forces; /* [node_count] N, of all faces of a node; models of faces only */
} aero_state;

PLII_SIMD_INLINE plii_vec3x4 aero_face_wind(plii_vec3x4 normal, plii_vec3x4 velocity) {
    const plii_mask4 is_away = plii_vec3x4_dot(normal, velocity) < 0.0f;
    return plii_vec3x4_select(is_away, plii_vec3x4_neg(normal), normal);
}
PLII_SIMD_INLINE plii_vec3x4 aero_divide(plii_vec3x4 a, plii_float4 s) {
    return plii_vec3x4_scale(a, 1.0f / s);
}

/* Lift-drag models: forces on an area that moves at `velocity` relative to the air. */
PLII_SIMD_INLINE void aero_lift_and_drag(const aero_state* aero, float density, plii_float4 doubled_area,
                                         plii_vec3x4 normal, plii_vec3x4 velocity, plii_vec3x4* lift,
                                         plii_vec3x4* drag) {
    const plii_float4 speed_squared = plii_vec3x4_dot(velocity, velocity), speed = plii_float4_sqrt(speed_squared);
    const plii_vec3x4 direction = aero_divide(velocity, speed);
    normal = aero_face_wind(normal, velocity);
    const plii_float4 cosine = plii_vec3x4_dot(normal, direction);
    const plii_float4 area = 0.5f * doubled_area;

    const plii_float4 drag_share = 0.5f * aero->def.drag * density * speed_squared;
    *drag = plii_vec3x4_scale(plii_vec3x4_neg(direction), drag_share * area * cosine);
    const plii_mask4 has_lift = (cosine > 0.0f) & (cosine < AERO_MAX_LIFT_COSINE);
    *lift = (plii_vec3x4){0};
    if (plii_lanes_bits(has_lift) == 0) { return; }
    const plii_vec3x4 upward = plii_vec3x4_cross(plii_vec3x4_cross(normal, direction), direction);
    const plii_float4 lift_share = 0.5f * aero->def.lift * density * speed;
    const plii_float4 sine = plii_float4_sqrt(1.0f - cosine * cosine);
    const plii_float4 scale = lift_share * area * sine;
    *lift = plii_vec3x4_select(has_lift, plii_vec3x4_scale(upward, scale), *lift);
}

/* Drag that would do more than stop the node within the step is cut to 80 % of that. */
PLII_SIMD_INLINE plii_vec3x4 aero_limit_drag(plii_vec3x4 drag, plii_vec3x4 velocity, plii_float4 inverse_mass,
                                             float dt) {
    const plii_vec3x4 change = plii_vec3x4_scale(plii_vec3x4_scale(drag, inverse_mass), plii_float4_all(dt));
    const plii_float4 change_squared = plii_vec3x4_dot(change, change);
    const plii_float4 speed_squared = plii_vec3x4_dot(velocity, velocity);
    const plii_mask4 is_cut = (speed_squared <= change_squared) & (change_squared > 0.0f);
    if (plii_lanes_bits(is_cut) == 0) { return drag; }
    const plii_float4 ratio = plii_float4_sqrt(speed_squared) / plii_float4_sqrt(change_squared);
    return plii_vec3x4_select(is_cut, plii_vec3x4_scale(drag, 0.8f * ratio), drag);
}

/* One- and two-sided models: force on a surface, where it moves against the air with its front. */
PLII_SIMD_INLINE plii_mask4 aero_resistance(const aero_state* aero, float density, plii_float4 doubled_area,
                                            float area_share, plii_vec3x4 normal, plii_vec3x4 velocity,
                                            plii_vec3x4* force) {
    const plii_float4 approach = plii_vec3x4_dot(velocity, normal);
    const plii_float4 speed_squared = plii_vec3x4_dot(velocity, velocity);
    const plii_float4 scale = -(doubled_area * approach * speed_squared * area_share * density);
    const plii_vec3x4 direction = aero_divide(velocity, plii_float4_sqrt(speed_squared));
    *force = plii_vec3x4_add(plii_vec3x4_scale(normal, scale * aero->def.lift),
                             plii_vec3x4_scale(direction, scale * aero->def.drag));
    return approach > 0.0f;
}

/* The sum with a force; one that would change the velocity by more than its amount only cancels the velocity along
   itself. One whose square is too small for a float has no direction. */
PLII_SIMD_INLINE plii_vec3x4 aero_add_clamped(plii_vec3x4 sum, plii_vec3x4 force, plii_vec3x4 velocity,
                                              plii_float4 inverse_mass, float dt) {
    const plii_float4 response = dt * inverse_mass;
    const plii_vec3x4 change = plii_vec3x4_scale(force, response);
    const plii_float4 force_squared = plii_vec3x4_dot(force, force);
    const plii_mask4 is_cut =
        (plii_vec3x4_dot(velocity, velocity) < plii_vec3x4_dot(change, change)) & (force_squared > 0.0f);
    if (plii_lanes_bits(is_cut) == 0) { return plii_vec3x4_add(sum, force); }
    const plii_vec3x4 axis = aero_divide(force, plii_float4_sqrt(force_squared));
    const plii_vec3x4 along = plii_vec3x4_scale(axis, plii_vec3x4_dot(velocity, axis));
    return plii_vec3x4_select(is_cut, plii_vec3x4_sub(sum, aero_divide(along, response)), plii_vec3x4_add(sum, force));
}

/* Air takes energy from what moves through it. A step that is too long for its forces would give some: of the change of
   velocity, what is against the velocity does no more than stop the node in the air, and what is across it turns the
   velocity without making it larger. A node at rest in the air stays so, though its faces move. */
PLII_SIMD_INLINE plii_vec3x4 aero_limit(plii_vec3x4 force, plii_vec3x4 velocity, plii_float4 inverse_mass, float dt) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_float4 response = plii_float4_all(dt) * inverse_mass;
    const plii_vec3x4 after = plii_vec3x4_add(velocity, plii_vec3x4_scale(force, response)), none = {0};
    const plii_float4 speed_squared = plii_vec3x4_dot(velocity, velocity);
    const plii_float4 along = plii_vec3x4_dot(after, velocity);
    const plii_mask4 turns_back = along < zero;
    const plii_mask4 is_faster = speed_squared < plii_vec3x4_dot(after, after);
    const plii_mask4 is_cut = (turns_back | is_faster) & (zero < response);
    if (plii_lanes_bits(is_cut) == 0) { return force; }
    const plii_vec3x4 across = plii_vec3x4_sub(after, plii_vec3x4_scale(velocity, along / speed_squared));
    const plii_vec3x4 kept = plii_vec3x4_select(turns_back, across, after);
    const plii_float4 kept_squared = plii_vec3x4_dot(kept, kept);
    const plii_float4 ratio = plii_float4_sqrt(speed_squared / kept_squared);
    const plii_mask4 is_too_fast = speed_squared < kept_squared;
    const plii_vec3x4 reached = plii_vec3x4_select(is_too_fast, plii_vec3x4_scale(kept, ratio), kept);
    const plii_vec3x4 change =
        plii_vec3x4_select(speed_squared > PLII_EPSILON, plii_vec3x4_sub(reached, velocity), none);
    return plii_vec3x4_select(is_cut, plii_vec3x4_scale(change, one / response), force);
}

typedef struct aero_nodes {
    const pli_vec4* positions;
    pli_vec4* velocities;
    const pli_vec3* normals;
    const float* areas;
    pli_vec3* forces;
} aero_nodes;

typedef struct aero_step {
    float density, dt, half_dt; /* the last: s, through which the forces so far act before the air does */
    bool is_limited, is_impulse;
} aero_step;

/* aero_limit holds for a force that acts as an impulse at the start of the step. In substeps it acts bit by bit, while
   nodes of stiff bodies swing: what was to turn one velocity pushes along with the next. So under solvers with them air
   changes velocities at once, before all else. Under the others velocities are half a step behind positions: what
   swings by pressure gets energy, unless air turns and brakes those of the same time. */
static aero_step aero_begin(const pli_body* body) {
    const bool is_limited = !body->world->def.reference_mode, has_substeps = body->solver_class->has_substeps;
    return (aero_step){body->world->def.air_density, body->step.dt, has_substeps ? 0.0f : 0.5f * body->step.dt,
                       is_limited, is_limited && has_substeps};
}

static void aero_push(const aero_step* step, pli_vec3 force, float inverse_mass, pli_vec4* velocity) {
    plii_add_xyz(velocity, pli_vec3_scale(force, inverse_mass * step->dt));
}

PLII_SIMD_SHARED void aero_run_four(const aero_state* aero, const aero_step* step, aero_nodes nodes) {
    const float density = step->density, dt = step->dt;
    const plii_float4 inverse_mass =
        plii_lanes_xyzw(nodes.positions[0].w, nodes.positions[1].w, nodes.positions[2].w, nodes.positions[3].w);
    const plii_vec3x4 own_velocity = plii_vec3x4_from_vec4s(nodes.velocities);
    const plii_vec3x4 wind = plii_vec3x4_all(aero->def.wind);
    const plii_vec3x4 velocity = plii_vec3x4_sub(own_velocity, wind);
    const plii_mask4 moves = plii_vec3x4_dot(velocity, velocity) > PLII_EPSILON;
    plii_mask4 is_active = (inverse_mass > 0.0f) & moves;

    /* In the air. Bullet limits by the velocity in the world, and so keeps what stands still from the wind. */
    const plii_vec3x4 limiting = step->is_limited ? velocity : own_velocity;
    plii_vec3x4 normal = plii_vec3x4_from(nodes.normals);
    const plii_float4 areas = plii_float4_load(nodes.areas);
    const plii_vec3x4 before = plii_vec3x4_from(nodes.forces);
    plii_vec3x4 after;
    if (aero->def.model == PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG) {
        plii_vec3x4 lift, drag;
        aero_lift_and_drag(aero, density, areas, normal, velocity, &lift, &drag);
        drag = aero_limit_drag(drag, limiting, inverse_mass, dt);
        after = plii_vec3x4_add(plii_vec3x4_add(before, drag), lift);
    } else {
        if (aero->def.model == PLI_AERO_VERTEX_TWO_SIDED) { normal = aero_face_wind(normal, velocity); }
        plii_vec3x4 force;
        is_active &= aero_resistance(aero, density, areas, 0.5f, normal, velocity, &force);
        after = aero_add_clamped(before, force, limiting, inverse_mass, dt);
    }
    if (step->is_limited) {
        const plii_vec3x4 other = plii_vec3x4_scale(before, plii_float4_all(step->half_dt) * inverse_mass);
        const plii_vec3x4 force =
            aero_limit(plii_vec3x4_sub(after, before), plii_vec3x4_add(velocity, other), inverse_mass, dt);
        if (step->is_impulse) {
            pli_vec3 forces[PLII_LANES];
            plii_vec3x4_to(forces, plii_vec3x4_select(is_active, force, (plii_vec3x4){0}));
            for (int k = 0; k < PLII_LANES; ++k) {
                aero_push(step, forces[k], nodes.positions[k].w, &nodes.velocities[k]);
            }
            return;
        }
        after = plii_vec3x4_add(before, force);
    }
    plii_vec3x4_to(nodes.forces, plii_vec3x4_select(is_active, after, before));
}

static void aero_run_vertices(pli_body* body, void* state) {
    const aero_state aero = *(const aero_state*)state;
    const aero_step step = aero_begin(body);
    int i = 0;
    for (; i + PLII_LANES <= body->node_count; i += PLII_LANES) {
        const aero_nodes nodes = {&body->positions[i], &body->velocities[i], &body->normals[i], &body->areas[i],
                                  &body->forces[i]};
        aero_run_four(&aero, &step, nodes);
    }
    if (i == body->node_count) { return; }
    /* The rest, and pinned nodes beside them. */
    const size_t rest = (size_t)(body->node_count - i);
    pli_vec4 positions[PLII_LANES] = {0}, velocities[PLII_LANES] = {0};
    pli_vec3 normals[PLII_LANES] = {0}, forces[PLII_LANES] = {0};
    float areas[PLII_LANES] = {0};
    memcpy(positions, &body->positions[i], rest * sizeof *positions);
    memcpy(velocities, &body->velocities[i], rest * sizeof *velocities);
    memcpy(normals, &body->normals[i], rest * sizeof *normals);
    memcpy(areas, &body->areas[i], rest * sizeof *areas);
    memcpy(forces, &body->forces[i], rest * sizeof *forces);
    aero_run_four(&aero, &step, (aero_nodes){positions, velocities, normals, areas, forces});
    memcpy(&body->velocities[i], velocities, rest * sizeof *velocities);
    memcpy(&body->forces[i], forces, rest * sizeof *forces);
}

/* One face at a time, since faces share nodes: all lanes are equal. */
static void aero_add_faces(const pli_body* body, const aero_state* aero, pli_vec3* forces) {
    const float density = body->world->def.air_density;
    /* Of what the limits count as at rest. */
    const pli_vec3 still = body->world->def.reference_mode ? pli_vec3_make(0, 0, 0) : aero->def.wind;
    const plii_topology* topology = body->topology;
    for (int f = 0; f < topology->face_count; ++f) {
        const int* nodes = topology->faces[f];
        const pli_vec3 sum =
            pli_vec3_add(pli_vec3_add(plii_xyz(body->velocities[nodes[0]]), plii_xyz(body->velocities[nodes[1]])),
                         plii_xyz(body->velocities[nodes[2]]));
        const pli_vec3 motion = pli_vec3_sub(plii_vec3_divide(sum, 3.0f), aero->def.wind);
        if (!(pli_vec3_length_squared(motion) > PLII_EPSILON)) { continue; }

        const plii_vec3x4 velocity = plii_vec3x4_all(motion);
        const plii_float4 area = plii_float4_all(body->face_areas[f]), three = plii_float4_all(3.0f);
        plii_vec3x4 normal = plii_vec3x4_all(body->face_normals[f]);
        const bool has_lift = aero->def.model == PLI_AERO_FACE_TWO_SIDED_LIFT_DRAG;
        plii_vec3x4 lift, force; /* force: the drag, with lift */
        if (has_lift) {
            aero_lift_and_drag(aero, density, area, normal, velocity, &lift, &force);
            lift = aero_divide(lift, three);
        } else {
            if (aero->def.model == PLI_AERO_FACE_TWO_SIDED) { normal = aero_face_wind(normal, velocity); }
            const plii_mask4 is_front = aero_resistance(aero, density, area, 1.0f, normal, velocity, &force);
            if (plii_lanes_bits(is_front) == 0) { continue; }
            lift = velocity; /* not used */
        }
        force = aero_divide(force, three);
        for (int k = 0; k < 3; ++k) {
            const float inverse_mass = body->positions[nodes[k]].w;
            /* A pinned node has no response to divide by. */
            if (!(inverse_mass > 0.0f)) { continue; }
            const plii_vec3x4 limiting = plii_vec3x4_all(pli_vec3_sub(plii_xyz(body->velocities[nodes[k]]), still));
            const plii_float4 response = plii_float4_all(inverse_mass);
            plii_vec3x4 total = plii_vec3x4_all(forces[nodes[k]]);
            if (has_lift) {
                /* As in Bullet, what one node limits stays limited for the next. */
                force = aero_limit_drag(force, limiting, response, body->step.dt);
                total = plii_vec3x4_add(plii_vec3x4_add(total, force), lift);
            } else {
                total = aero_add_clamped(total, force, limiting, response, body->step.dt);
            }
            forces[nodes[k]] = plii_vec3x4_first(total);
        }
    }
}

static void aero_run_faces(pli_body* body, void* data) {
    aero_state* aero = data;
    if (body->world->def.reference_mode) {
        aero_add_faces(body, aero, body->forces);
        return;
    }
    aero_add_faces(body, aero, aero->face_forces);
    const aero_step step = aero_begin(body);
    for (int i = 0; i < body->node_count; ++i) {
        const float inverse_mass = body->positions[i].w;
        const pli_vec3 other = pli_vec3_scale(body->forces[i], step.half_dt * inverse_mass);
        const pli_vec3 velocity = pli_vec3_add(pli_vec3_sub(plii_xyz(body->velocities[i]), aero->def.wind), other);
        const pli_vec3 force = plii_vec3x4_first(aero_limit(
            plii_vec3x4_all(aero->face_forces[i]), plii_vec3x4_all(velocity), plii_float4_all(inverse_mass), step.dt));
        if (step.is_impulse) {
            aero_push(&step, force, inverse_mass, &body->velocities[i]);
        } else {
            body->forces[i] = pli_vec3_add(body->forces[i], force);
        }
        aero->face_forces[i] = pli_vec3_make(0, 0, 0);
    }
}

/* In Bullet of vertices before pressure and volume, of faces after them. */
enum { AERO_VERTEX_ORDER = 10, AERO_FACE_ORDER = 40 };

/* Models of faces, and these only, have forces of faces. */
static bool aero_is_sound(const pli_body* body, const void* data) {
    const aero_state* aero = data;
    return (aero->def.model >= PLI_AERO_FACE_TWO_SIDED) == (aero->face_forces != NULL);
}

static const plii_field aero_fields[] = {
    PLII_FIELD(pli_aero_def, model, PLI_AERO_VERTEX_POINT, PLI_AERO_FACE_ONE_SIDED),
    PLII_FIELD(pli_aero_def, lift, 0, PLI_MAX_FACTOR),
    PLII_FIELD(pli_aero_def, drag, 0, PLI_MAX_FACTOR),
    PLII_FIELD(pli_aero_def, wind, -PLI_MAX_SPEED, PLI_MAX_SPEED),
};
/* What both classes have. */
#define AERO_CLASS                                                                                                     \
    .state_size = sizeof(aero_state), .settings = PLII_LIMITS(aero_state, def, aero_fields),                           \
    .is_sound = aero_is_sound, .acts_on_motion = true
const plii_feature_class plii_aero_vertex_class = {
    .name = "vertex aerodynamics",
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(aero_state, def, PLII_SAVED, "e6ff3f*"),
                                    PLII_STATE(aero_state, face_forces, PLII_LEFT)),
    .needs = plii_surface_force_needs,
    .stages = {[PLII_STAGE_FORCES] = {aero_run_vertices, AERO_VERTEX_ORDER}},
    AERO_CLASS,
};

const plii_feature_class plii_aero_face_class = {
    .name = "face aerodynamics",
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(aero_state, def, PLII_SAVED, "e6ff3f*")),
    .needs = PLII_NEEDS(&plii_forces_class, &plii_normals_class, &plii_face_normals_class, &plii_areas_class),
    .arrays = PLII_ARRAYS(PLII_LEFT_PER_NODE(aero_state, face_forces)),
    .stages = {[PLII_STAGE_FORCES] = {aero_run_faces, AERO_FACE_ORDER}},
    AERO_CLASS,
};

PLII_DEFINE_DEFAULT(pli_aero_def, 0)
pli_status pli_body_enable_aero(pli_body* body, const pli_aero_def* def) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY_SETTINGS(body, pli_aero_def, used, def, plii_aero_vertex_class);
    PLII_TRY(plii_check_faces(body, "aerodynamics act on faces", __func__));
    const bool on_faces = (int)used.model >= (int)PLI_AERO_FACE_TWO_SIDED;
    const plii_feature_class* klass = on_faces ? &plii_aero_face_class : &plii_aero_vertex_class;
    PLII_TRY(plii_feature_enable_with(body, klass, &used, sizeof used, NULL));
    plii_feature_disable(body, on_faces ? &plii_aero_vertex_class : &plii_aero_face_class);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_set_wind(pli_body* body, pli_vec3 wind) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_vec3_within(body->context, wind, PLI_MAX_SPEED, "wind", __func__));
    aero_state* aero = plii_feature_state(body, &plii_aero_vertex_class);
    if (aero == NULL) { aero = plii_feature_state(body, &plii_aero_face_class); }
    if (aero == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "aerodynamics are not enabled"); }
    if (memcmp(&aero->def.wind, &wind, sizeof wind) != 0) { plii_body_note_change(body); }
    aero->def.wind = wind;
    return PLI_OK;
}

pli_status pli_body_disable_aero(pli_body* body) {
    PLII_TRY(plii_check_body_change(body, __func__));
    const bool was_on =
        plii_feature_disable(body, &plii_aero_vertex_class) || plii_feature_disable(body, &plii_aero_face_class);
    return was_on ? plii_body_changed(body, PLI_OK) : PLI_OK;
}
