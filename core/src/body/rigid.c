/* Rigid proxies: state, shapes, and free motion for programs without a rigid-body engine. */

#include "body/rigid_lanes.h"

#include "body/pipeline.h"
#include "math/bounds.h"
#include "math/dvec3.h"
#include "shape/shape_impl.h"

#include <stdio.h>

PLII_DEFINE_DEFAULT(pli_rigid_def, .kind = PLI_RIGID_STATIC, .state = {.pose = pli_transform_identity()},
                    .friction = 0.5f, .restitution = 1.0f, .linear_factor = {1, 1, 1}, .angular_factor = {1, 1, 1})

#define RIGID_MAX_ROTATION 2.0f /* of the numbers of a rotation */

/* Of the numbers of a state, in their order: static bodies use the first four, kinematic ones six. */
#define RIGID_STATE_LIMITS(VECTOR, NUMBER)                                                                             \
    VECTOR(pose.rotation.rows[0], RIGID_MAX_ROTATION)                                                                  \
    VECTOR(pose.rotation.rows[1], RIGID_MAX_ROTATION)                                                                  \
    VECTOR(pose.rotation.rows[2], RIGID_MAX_ROTATION)                                                                  \
    VECTOR(pose.origin, PLI_MAX_COORDINATE)                                                                            \
    VECTOR(linear_velocity, PLI_MAX_SPEED)                                                                             \
    VECTOR(angular_velocity, PLI_MAX_ANGULAR_SPEED)                                                                    \
    NUMBER(inverse_mass, 0.999f / PLI_MAX_MASS, 1.001f / PLI_MIN_MASS) /* plii_is_inverse_mass */                      \
    VECTOR(inverse_inertia_world.rows[0], PLI_MAX_INVERSE_INERTIA)                                                     \
    VECTOR(inverse_inertia_world.rows[1], PLI_MAX_INVERSE_INERTIA)                                                     \
    VECTOR(inverse_inertia_world.rows[2], PLI_MAX_INVERSE_INERTIA)

/* All but inverse masses that are too small; also what a body of its kind does not use. */
static bool rigid_state_is_within(const pli_rigid_state* state) {
#define RIGID_THREE(member, limit) limit, limit, limit,
#define RIGID_HIGHEST(member, lowest, highest) highest,
    static const float limits[] = {RIGID_STATE_LIMITS(RIGID_THREE, RIGID_HIGHEST)};
    _Static_assert(sizeof *state == sizeof limits, "a state consists of floats");
    const float* values = (const float*)state;
    int is_within = 1; /* without a branch: each body that takes part comes here twice in a step */
    for (size_t i = 0; i < sizeof limits / sizeof *limits; ++i) {
        is_within &= fabsf(values[i]) <= limits[i];
    }
    return is_within != 0;
}

#define RIGID_VECTOR_FIELD(member, limit) PLII_FIELD(pli_rigid_state, member, -limit, limit),
#define RIGID_NUMBER_FIELD(member, lowest, highest) PLII_FIELD(pli_rigid_state, member, lowest, highest),
static const plii_field rigid_fields[] = {RIGID_STATE_LIMITS(RIGID_VECTOR_FIELD, RIGID_NUMBER_FIELD)};
enum { RIGID_POSE_FIELDS = 4, RIGID_MOTION_FIELDS = 6, RIGID_FIELDS = sizeof rigid_fields / sizeof *rigid_fields };

pli_status plii_rigid_judge_state(pli_context* context, pli_rigid_kind kind, const pli_rigid_state* state,
                                  const char* function) {
    static const int counts[] = {[PLI_RIGID_STATIC] = RIGID_POSE_FIELDS,
                                 [PLI_RIGID_KINEMATIC] = RIGID_MOTION_FIELDS,
                                 [PLI_RIGID_DYNAMIC] = RIGID_FIELDS};
    PLII_TRY(plii_check_fields(context, state, counts[kind], rigid_fields, function));
    PLII_FAIL_IF(!plii_is_rotation(state->pose.rotation), context, PLI_ERROR_INVALID_VALUE, function,
                 "pose.rotation is scaled, sheared or mirrored");
    return PLI_OK;
}

/* `good`: a rotation that is known to be one, mostly the same, or NULL. */
static inline pli_status rigid_check_state(pli_context* context, pli_rigid_kind kind, const pli_mat3* good,
                                           const pli_rigid_state* state, const char* function) {
    const pli_mat3* rotation = &state->pose.rotation;
    const bool is_known = good != NULL && memcmp(rotation, good, sizeof *good) == 0;
    const bool is_good = rigid_state_is_within(state) && (is_known || plii_is_rotation(*rotation)) &&
                         (kind != PLI_RIGID_DYNAMIC || plii_is_inverse_mass(state->inverse_mass));
    return is_good ? PLI_OK : plii_rigid_judge_state(context, kind, state, function);
}

/* Bit for bit. */
static bool rigid_is_same_pose(const pli_transform* a, const pli_transform* b) {
    return memcmp(a, b, sizeof *a) == 0;
}
static void rigid_note_pose(pli_rigid* rigid) {
    ++rigid->pose_version;
    rigid->are_shapes_placed = false;
}

static void rigid_store_state(pli_rigid* rigid, const pli_rigid_state* state) {
    const bool is_same_pose = rigid_is_same_pose(&rigid->state.pose, &state->pose);
    const bool is_as_heavy = rigid->kind != PLI_RIGID_DYNAMIC || rigid->state.inverse_mass == state->inverse_mass;
    if (!is_same_pose) { rigid_note_pose(rigid); }
    rigid->has_changed = rigid->has_changed || !is_as_heavy;
    rigid->is_asleep = rigid->is_asleep && is_same_pose && is_as_heavy && plii_vec3_is_zero(state->linear_velocity) &&
                       plii_vec3_is_zero(state->angular_velocity);
    rigid->state = *state;
    /* From where they came: reading a part of what was stored as a whole has to wait. */
    rigid->given = plii_twist_make(state->linear_velocity, state->angular_velocity);
    if (rigid->kind != PLI_RIGID_DYNAMIC) {
        rigid->state.inverse_mass = 0.0f;
        rigid->state.inverse_inertia_world = plii_mat3_diagonal(0, 0, 0);
        rigid->pull = pli_vec3_make(0, 0, 0); /* of when it was dynamic */
    }
    if (rigid->kind == PLI_RIGID_STATIC) {
        rigid->given = (plii_twist){0};
        plii_rigid_set_velocity(rigid, rigid->given);
    }
    if (rigid->was_touched || rigid->kind == PLI_RIGID_STATIC) { rigid->start = rigid->given; }
}

static pli_status rigid_check_shapes(pli_context* context, int count, pli_shape* const* shapes,
                                     const pli_transform* poses, const char* function) {
    PLII_FAIL_IF(count < 0 || (count > 0 && shapes == NULL), context, PLI_ERROR_INVALID_VALUE, function,
                 "%d shapes, but no array of them", count);
    for (int i = 0; i < count; ++i) {
        if (!plii_handle_is_alive(shapes[i], PLII_HANDLE_SHAPE)) {
            char name[32];
            snprintf(name, sizeof name, "shape %d", i);
            return plii_handle_refuse(shapes[i], PLII_HANDLE_SHAPE, context, name, function);
        }
        if (poses == NULL) { continue; }
        const pli_rigid_state placed = {.pose = poses[i]};
        const pli_status status = plii_transform_is_finite(poses[i]) ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE;
        PLII_FAIL_IF(!rigid_state_is_within(&placed), context, status, function,
                     "the pose of shape %d is beyond the limits or not finite", i);
        PLII_FAIL_IF(!plii_is_rotation(poses[i].rotation), context, PLI_ERROR_INVALID_VALUE, function,
                     "the pose of shape %d is scaled, sheared or mirrored", i);
    }
    return PLI_OK;
}

static const plii_field rigid_def_fields[] = {
    PLII_FIELD(pli_rigid_def, kind, PLI_RIGID_STATIC, PLI_RIGID_DYNAMIC),
    PLII_FIELD(pli_rigid_def, friction, 0, PLI_MAX_FACTOR),
    PLII_FIELD(pli_rigid_def, restitution, 0, PLI_MAX_FACTOR),
    PLII_FIELD(pli_rigid_def, linear_factor, -PLI_MAX_FACTOR, PLI_MAX_FACTOR),
    PLII_FIELD(pli_rigid_def, angular_factor, -PLI_MAX_FACTOR, PLI_MAX_FACTOR),
};

static void rigid_release(pli_rigid* rigid) {
    pli_context* context = rigid->context;
    for (int i = 0; i < rigid->shape_count; ++i) {
        plii_shape_release(rigid->shapes[i]);
    }
    plii_release(context, rigid->shapes, (size_t)rigid->shape_capacity * sizeof(pli_shape*));
    PLII_RELEASE(context, rigid->shape_poses, rigid->shape_pose_capacity);
    PLII_RELEASE(context, rigid->shape_places, rigid->shape_place_capacity);
    plii_handle_release(context, rigid, PLII_HANDLE_RIGID, sizeof *rigid);
}

typedef enum rigid_shapes_change { RIGID_SAME_SHAPES, RIGID_SHAPES_MOVED, RIGID_OTHER_SHAPES } rigid_shapes_change;

static rigid_shapes_change rigid_compare_shapes(const pli_rigid* rigid, int count, pli_shape* const* shapes,
                                                const pli_transform* poses) {
    const pli_transform identity = pli_transform_identity();
    if (count != rigid->shape_count) { return RIGID_OTHER_SHAPES; }
    rigid_shapes_change change = RIGID_SAME_SHAPES;
    for (int i = 0; i < count; ++i) {
        if (shapes[i] != rigid->shapes[i]) { return RIGID_OTHER_SHAPES; }
        const bool stays = rigid_is_same_pose(&rigid->shape_poses[i], poses != NULL ? &poses[i] : &identity);
        if (!stays) { change = RIGID_SHAPES_MOVED; }
    }
    return change;
}

static bool rigid_store_shapes(pli_rigid* rigid, int count, pli_shape* const* shapes, const pli_transform* poses) {
    if (!PLII_RESERVE(rigid->context, &rigid->shapes, &rigid->shape_capacity, count) ||
        !PLII_RESERVE(rigid->context, &rigid->shape_poses, &rigid->shape_pose_capacity, count) ||
        !PLII_RESERVE(rigid->context, &rigid->shape_places, &rigid->shape_place_capacity, count)) {
        return false;
    }
    const rigid_shapes_change change = rigid_compare_shapes(rigid, count, shapes, poses);
    if (rigid->shape_count > 0 && change != RIGID_SAME_SHAPES) {
        const plii_notice notice = change == RIGID_OTHER_SHAPES ? PLII_SHAPES_REPLACED : PLII_SHAPES_MOVED;
        plii_features_notify(rigid->world, notice, rigid);
    }
    /* Retain first: a shape may be in the old list and in the new one. */
    for (int i = 0; i < count; ++i) {
        plii_shape_retain(shapes[i]);
    }
    for (int i = 0; i < rigid->shape_count; ++i) {
        plii_shape_release(rigid->shapes[i]);
    }
    rigid->shape_count = count;
    rigid->world->needs_reserve = true;
    rigid->has_changed = true;
    rigid->are_shapes_placed = false;
    for (int i = 0; i < count; ++i) {
        rigid->shapes[i] = shapes[i];
        rigid->shape_poses[i] = poses != NULL ? poses[i] : pli_transform_identity();
    }
    return true;
}

pli_status pli_rigid_create(pli_world* world, const pli_rigid_def* def, pli_rigid** rigid) {
    PLII_TRY(plii_check_world_change(world, __func__));
    pli_context* context = world->context;
    if (def == NULL || rigid == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def or rigid is null"); }
    PLII_TRY_DEF(context, pli_rigid_def, def, rigid_def_fields, __func__);
    PLII_TRY(rigid_check_state(context, def->kind, NULL, &def->state, __func__));
    PLII_TRY(rigid_check_shapes(context, def->shape_count, def->shapes, def->shape_poses, __func__));
    pli_rigid* made = plii_handle_create(context, PLII_HANDLE_RIGID, sizeof *made);
    if (made == NULL) { return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for the rigid body"); }
    made->world = world;
    made->context = context;
    made->user_data = def->user_data;
    made->kind = def->kind;
    made->friction = def->friction;
    made->restitution = def->restitution;
    made->linear_factor = def->linear_factor;
    made->angular_factor = def->angular_factor;
    made->step_bounds = (pli_bounds){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}; /* none yet */
    rigid_store_state(made, &def->state);
    const bool complete = rigid_store_shapes(made, def->shape_count, def->shapes, def->shape_poses) &&
                          plii_world_add_rigid(world, made) == PLI_OK;
    if (!complete) {
        rigid_release(made);
        return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for a rigid body of %d shapes", def->shape_count);
    }
    *rigid = made;
    return PLI_OK;
}

void pli_rigid_destroy(pli_rigid* rigid) {
    if (rigid == NULL || plii_check_rigid(rigid, __func__) != PLI_OK) { return; }
    if (plii_check_world_idle(rigid->world, __func__) != PLI_OK) { return; }
    plii_world_remove_rigid(rigid->world, rigid);
    plii_handle_retire(rigid);
    rigid_release(rigid);
}

pli_status plii_rigid_change(pli_rigid* rigid, pli_rigid_kind kind, const pli_rigid_state* state,
                             const char* function) {
    PLII_TRY(rigid_check_state(rigid->context, kind, &rigid->state.pose.rotation, state, function));
    if (rigid->kind != kind) { rigid->world->has_groups = false; } /* were made by kinds */
    rigid->kind = kind;
    rigid_store_state(rigid, state);
    return PLI_OK;
}

pli_status pli_rigid_set_state(pli_rigid* rigid, const pli_rigid_state* state) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    if (state == NULL) { return PLII_FAIL(rigid->context, PLI_ERROR_NULL_ARGUMENT, "state is null"); }
    const bool stays = rigid->kind == PLI_RIGID_STATIC && rigid_is_same_pose(&rigid->state.pose, &state->pose);
    return stays ? PLI_OK : plii_rigid_change(rigid, rigid->kind, state, __func__);
}

PLII_DEFINE_GET(pli_rigid_state, pli_rigid_get_state, rigid, rigid->state,
                (pli_rigid_state){.pose = pli_transform_identity()})

pli_status pli_rigid_set_friction(pli_rigid* rigid, float friction) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    PLII_TRY(plii_check_between(rigid->context, friction, 0.0f, PLI_MAX_FACTOR, "friction", __func__));
    rigid->has_changed = rigid->has_changed || rigid->friction != friction;
    rigid->friction = friction;
    return PLI_OK;
}
pli_status pli_rigid_set_restitution(pli_rigid* rigid, float restitution) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    PLII_TRY(plii_check_between(rigid->context, restitution, 0.0f, PLI_MAX_FACTOR, "restitution", __func__));
    rigid->restitution = restitution;
    return PLI_OK;
}
pli_status pli_rigid_set_factors(pli_rigid* rigid, pli_vec3 linear_factor, pli_vec3 angular_factor) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    PLII_TRY(plii_check_vec3_within(rigid->context, linear_factor, PLI_MAX_FACTOR, "linear_factor", __func__));
    PLII_TRY(plii_check_vec3_within(rigid->context, angular_factor, PLI_MAX_FACTOR, "angular_factor", __func__));
    rigid->linear_factor = linear_factor;
    rigid->angular_factor = angular_factor;
    return PLI_OK;
}

pli_status pli_rigid_set_kind(pli_rigid* rigid, pli_rigid_kind kind, const pli_rigid_state* state) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    if (state == NULL) { return PLII_FAIL(rigid->context, PLI_ERROR_NULL_ARGUMENT, "state is null"); }
    PLII_FAIL_IF(kind < PLI_RIGID_STATIC || kind > PLI_RIGID_DYNAMIC, rigid->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "unknown kind %d", (int)kind);
    return plii_rigid_change(rigid, kind, state, __func__);
}

pli_status pli_rigid_set_shapes(pli_rigid* rigid, int shape_count, pli_shape* const* shapes,
                                const pli_transform* shape_poses) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    PLII_TRY(rigid_check_shapes(rigid->context, shape_count, shapes, shape_poses, __func__));
    PLII_FAIL_IF(!rigid_store_shapes(rigid, shape_count, shapes, shape_poses), rigid->context, PLI_ERROR_OUT_OF_MEMORY,
                 __func__, "no memory for %d shapes", shape_count);
    return PLI_OK;
}

pli_status pli_rigid_set_present(pli_rigid* rigid, bool is_present) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    rigid->has_changed = rigid->has_changed || rigid->is_absent == is_present;
    rigid->is_absent = !is_present;
    return PLI_OK;
}
PLII_DEFINE_GET(bool, pli_rigid_is_present, rigid, !rigid->is_absent, false)

pli_status pli_rigid_set_sensor(pli_rigid* rigid, bool is_sensor) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    rigid->has_changed = rigid->has_changed || rigid->is_sensor != is_sensor;
    rigid->is_sensor = is_sensor;
    return PLI_OK;
}
PLII_DEFINE_GET(bool, pli_rigid_is_sensor, rigid, rigid->is_sensor, false)
PLII_DEFINE_GET(pli_rigid_kind, pli_rigid_get_kind, rigid, rigid->kind, PLI_RIGID_STATIC)
PLII_DEFINE_GET(void*, pli_rigid_get_user_data, rigid, rigid->user_data, NULL)
PLII_DEFINE_GET(bool, pli_rigid_was_touched, rigid, rigid->was_touched, false)

/* Against other threads of a step, where there may be some. */
static bool rigid_lock(const pli_rigid* rigid) {
    return rigid->context->def.parallel_for != NULL && plii_context_lock(rigid->context);
}

/* All who come here at once write the same, the first one does. */
void plii_rigid_start_path(pli_rigid* rigid) {
    plii_rigid_path* path = &rigid->path;
    const bool was_locked = rigid_lock(rigid);
    if (!path->has_begun) {
        rigid->is_in_step = true;
        path->shift = path->carried = (plii_twist){0};
        /* A static one is followed by nobody, and stays. */
        path->moved = path->drift = (plii_twist){0};
        path->is_followed = false;
        path->begin = rigid->state.pose;
        path->begin_velocity = plii_rigid_velocity(rigid);
        path->begin_velocity.linear = pli_vec3_sub(path->begin_velocity.linear, path->pull);
        path->begin_version = rigid->pose_version;
        __atomic_store_n(&path->has_begun, true, __ATOMIC_RELEASE);
    }
    plii_context_unlock(rigid->context, was_locked);
}

void plii_rigid_start_touch(pli_rigid* rigid) {
    const bool was_locked = rigid_lock(rigid);
    if (!rigid->was_touched) {
        rigid->start = plii_rigid_velocity(rigid);
        PLII_STORE(&rigid->was_touched, true);
    }
    plii_context_unlock(rigid->context, was_locked);
}

/* To be called after the solve. */
void plii_rigid_end_path(pli_rigid* rigid, float dt) {
    plii_rigid_path* path = &rigid->path;
    if (!rigid->needs_reintegration || !path->has_begun) { return; }
    const plii_twist change = plii_twist_sub(plii_rigid_velocity(rigid), rigid->start);
    path->shift = plii_twist_add(path->shift, plii_twist_scale(plii_twist_sub(change, path->carried), dt));
    path->carried = change;
}

bool pli_rigid_get_shift(const pli_rigid* rigid, pli_vec3* shift, pli_vec3* rotation) {
    static const plii_twist none;
    const bool has_shift = plii_check_rigid(rigid, __func__) == PLI_OK && rigid->path.has_begun;
    const plii_twist* twist = has_shift ? &rigid->path.shift : &none;
    if (shift != NULL) { *shift = twist->linear; }
    if (rotation != NULL) { *rotation = twist->angular; }
    return !plii_vec3_is_zero(twist->linear) || !plii_vec3_is_zero(twist->angular);
}

pli_transform plii_rigid_shape_transform(const pli_rigid* rigid, int index) {
    return pli_transform_mul(rigid->state.pose, rigid->shape_poses[index]);
}

static pli_bounds rigid_bounds_at(const pli_rigid* rigid, pli_transform pose) {
    pli_bounds all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < rigid->shape_count; ++i) {
        const pli_shape* shape = rigid->shapes[i];
        const pli_transform place = pli_transform_mul(pose, rigid->shape_poses[i]);
        all = plii_bounds_join(all, plii_bounds_transform(shape->def.bounds(shape->def.user), place));
    }
    return all;
}

pli_bounds plii_rigid_bounds(const pli_rigid* rigid) {
    return rigid->are_shapes_placed ? rigid->bounds : rigid_bounds_at(rigid, rigid->state.pose);
}

void plii_rigid_find_places(pli_rigid* rigid) {
    rigid->bounds = (pli_bounds){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < rigid->shape_count; ++i) {
        const pli_shape_def* def = &rigid->shapes[i]->def;
        plii_shape_place* place = &rigid->shape_places[i];
        const pli_bounds own = def->bounds(def->user);
        const pli_vec3 half = pli_vec3_scale(pli_vec3_sub(own.max, own.min), 0.5f);
        place->least_extent = plii_min(half.x, plii_min(half.y, half.z));
        place->radius = plii_min(pli_vec3_length(half), PLI_MAX_COORDINATE); /* planes have no end */
        place->pose = plii_rigid_shape_transform(rigid, i);
        const pli_bounds bounds = plii_bounds_transform(own, place->pose);
        place->low = plii_lanes_from_vec3(&bounds.min);
        place->high = plii_lanes_from_vec3(&bounds.max);
        rigid->bounds = plii_bounds_join(rigid->bounds, bounds);
    }
    rigid->are_shapes_placed = true;
}

/* A velocity that leads to the shift, instead of what the shift has in it. */
static plii_twist rigid_with_shift(const plii_rigid_path* path, plii_twist velocity, float dt) {
    return plii_twist_add(plii_twist_sub(velocity, path->carried), plii_twist_scale(path->shift, 1.0f / dt));
}
plii_twist plii_rigid_end_velocity(const pli_rigid* rigid, float dt) {
    plii_twist velocity = plii_rigid_velocity(rigid);
    if (plii_rigid_is_moved_by_host(rigid)) { velocity = plii_twist_sub(velocity, rigid->given); }
    return rigid_with_shift(&rigid->path, velocity, dt);
}
pli_transform plii_rigid_end_pose(const pli_rigid* rigid, float dt) {
    return plii_rigid_advance(rigid->state.pose, plii_rigid_end_velocity(rigid, dt), dt);
}
pli_bounds plii_rigid_swept_bounds(const pli_rigid* rigid, float dt) {
    const pli_transform end = plii_rigid_advance(rigid->state.pose, plii_rigid_velocity(rigid), dt);
    return plii_bounds_join(plii_rigid_bounds(rigid), rigid_bounds_at(rigid, end));
}

// ---------------------------------------------------------------------------------------------- free motion

/* Transpose of a matrix whose rows go round by a vector, axis times angle in radians; twice, a tensor goes round. In
   double, as an even spin makes the same errors in every step; the angle may have those of float. */
static pli_mat3 rigid_turn(pli_mat3 matrix, pli_vec3 rotation) {
    const plii_dvec3 axis = plii_dvec3_from(rotation);
    const double half = fmax(0.5 * plii_dvec3_length(axis), 1e-9);
    const double s = (double)sinf((float)half), c = (double)cosf((float)half), unit = 1.0 / sqrt(s * s + c * c);
    const double sine = s * unit / half, cosine = c * unit;
    for (int i = 0; i < 3; ++i) {
        const plii_dvec3 row = plii_dvec3_from(matrix.rows[i]), across = plii_dvec3_cross(axis, row);
        const plii_dvec3 turned = plii_dvec3_add_scaled(row, across, sine * cosine);
        const plii_dvec3 inwards = plii_dvec3_cross(axis, across);
        matrix.rows[i] = plii_dvec3_to_float(plii_dvec3_add_scaled(turned, inwards, 0.5 * sine * sine));
    }
    return pli_mat3_transpose(matrix);
}

pli_transform plii_rigid_advance(pli_transform pose, plii_twist velocity, float dt) {
    const pli_mat3 turned = rigid_turn(pli_mat3_transpose(pose.rotation), pli_vec3_scale(velocity.angular, dt));
    /* Orthonormal rows closest to the first row, then the second. */
    const pli_vec3 x = plii_vec3_safe_normalize(turned.rows[0]), y = turned.rows[1];
    const pli_vec3 across = plii_vec3_safe_normalize(pli_vec3_sub(y, pli_vec3_scale(x, pli_vec3_dot(x, y))));
    return (pli_transform){{{x, across, pli_vec3_cross(x, across)}},
                           pli_vec3_add(pose.origin, pli_vec3_scale(velocity.linear, dt))};
}

pli_status pli_rigid_integrate(pli_rigid* rigid, pli_vec3 gravity, float dt) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    PLII_TRY(plii_check_vec3_within(rigid->context, gravity, PLI_MAX_ACCELERATION, "gravity", __func__));
    PLII_TRY(plii_check_between(rigid->context, dt, PLI_MIN_TIME_STEP, PLI_MAX_TIME_STEP, "dt", __func__));
    if (rigid->kind == PLI_RIGID_STATIC || rigid->is_asleep) { return PLI_OK; }
    pli_rigid_state state = rigid->state;
    /* Within a step it moves as a host's body does, before soft bodies have their say. */
    const bool ends_step = !rigid->world->is_stepping;
    /* What holds it has to know of its weight first. */
    const bool waits = ends_step && rigid->was_touched;
    const pli_vec3 pull = pli_vec3_scale(gravity, rigid->kind == PLI_RIGID_DYNAMIC ? dt : 0.0f);
    if (!waits) { state.linear_velocity = pli_vec3_add(state.linear_velocity, pull); }
    plii_twist velocity = {state.linear_velocity, state.angular_velocity};
    if (rigid->path.has_begun && ends_step) { velocity = rigid_with_shift(&rigid->path, velocity, dt); }
    state.pose = plii_rigid_advance(state.pose, velocity, dt);
    const pli_vec3 rotation = pli_vec3_scale(velocity.angular, dt);
    state.inverse_inertia_world = rigid_turn(rigid_turn(state.inverse_inertia_world, rotation), rotation);
    PLII_TRY(rigid_check_state(rigid->context, rigid->kind, NULL, &state, __func__));
    rigid->state = state;
    rigid->given = plii_rigid_velocity(rigid);
    rigid->pull = waits ? pull : pli_vec3_make(0, 0, 0);
    rigid->is_in_step = true;
    if (ends_step) { rigid->path.has_begun = false; }
    rigid_note_pose(rigid);
    return PLI_OK;
}

/* Bullet: ImpulseMatrix(dt, ima, imb, iwi, r) and MassMatrix, in their order of operations. Rows stay in lanes: of a
   matrix in memory, what was stored in parts would be slow to read. */

static const pli_vec3 rigid_no_factors = {1, 1, 1};

PLII_SIMD_SHARED plii_lanes_mat3 rigid_response(float inverse_mass, const pli_mat3* inverse_inertia, pli_vec3 r,
                                                const pli_vec3* linear_factor, const pli_vec3* angular_factor) {
    const plii_lanes_mat3 cross = {{{0, -r.z, r.y}, {r.z, 0, -r.x}, {-r.y, r.x, 0}}};
    plii_lanes_mat3 inertia = plii_lanes_rows(inverse_inertia);
    inertia.at[0] *= angular_factor->x;
    inertia.at[1] *= angular_factor->y;
    inertia.at[2] *= angular_factor->z;
    plii_lanes_mat3 response = {{{inverse_mass, 0, 0}, {0, inverse_mass, 0}, {0, 0, inverse_mass}}};
    PLII_UNROLL(3)
    for (int i = 0; i < 3; ++i) {
        response.at[i] -= plii_lanes_combine(cross, plii_lanes_combine(inertia, cross.at[i]));
        response.at[i] *= plii_lanes_from_vec3(linear_factor);
    }
    return response;
}
static pli_mat3 rigid_mat3(plii_lanes_mat3 m) {
    return (pli_mat3){{plii_lanes_vec3(m.at[0]), plii_lanes_vec3(m.at[1]), plii_lanes_vec3(m.at[2])}};
}
pli_mat3 plii_point_response(float inverse_mass, const pli_mat3* inverse_inertia, pli_vec3 offset) {
    return rigid_mat3(rigid_response(inverse_mass, inverse_inertia, offset, &rigid_no_factors, &rigid_no_factors));
}
pli_mat3 plii_rigid_response(const pli_rigid* rigid, pli_vec3 offset) {
    return rigid_mat3(rigid_response(rigid->state.inverse_mass, &rigid->state.inverse_inertia_world, offset,
                                     &rigid->linear_factor, &rigid->angular_factor));
}
pli_mat3 plii_rigid_inertia(const pli_rigid* rigid) {
    const pli_vec3 factor = rigid->angular_factor;
    const pli_mat3* inertia = &rigid->state.inverse_inertia_world;
    return (pli_mat3){{pli_vec3_scale(inertia->rows[0], factor.x), pli_vec3_scale(inertia->rows[1], factor.y),
                       pli_vec3_scale(inertia->rows[2], factor.z)}};
}

void plii_effective_mass(float dt, float point_inverse_mass, const pli_rigid* rigid, bool has_factors, pli_vec3 offset,
                         pli_mat3* matrix) {
    const plii_lanes_mat3 response = rigid_response(rigid->state.inverse_mass, &rigid->state.inverse_inertia_world,
                                                    offset, has_factors ? &rigid->linear_factor : &rigid_no_factors,
                                                    has_factors ? &rigid->angular_factor : &rigid_no_factors);
    const plii_float4 a = response.at[0] + (plii_float4){point_inverse_mass, 0, 0};
    const plii_float4 b = response.at[1] + (plii_float4){0, point_inverse_mass, 0};
    const plii_float4 c = response.at[2] + (plii_float4){0, 0, point_inverse_mass}, cofactors = plii_lanes_cross(b, c);
    const float s = 1.0f / plii_lanes_dot(a, cofactors), rate = 1.0f / dt; /* as plii_mat3_inverse */
    plii_float4 rows[4] = {cofactors * s * rate, plii_lanes_cross(c, a) * s * rate, plii_lanes_cross(a, b) * s * rate};
    plii_float4_transpose(rows);
    *matrix = rigid_mat3((plii_lanes_mat3){{rows[0], rows[1], rows[2]}});
    if (!has_factors || plii_lanes_xyz_finite(rows[0] + rows[1] + rows[2])) { return; }
    /* A pinned point, and a body that is held along an axis: impulses along that do nothing, whatever they are. */
    plii_effective_mass(dt, point_inverse_mass, rigid, false, offset, matrix);
}
