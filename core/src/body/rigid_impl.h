#pragma once

#include "base/handle.h"
#include "math/range.h"
#include "pliant/rigid.h"

/* A velocity, or a motion. */
typedef struct plii_twist {
    pli_vec3 linear, angular;
} plii_twist;

static inline plii_twist plii_twist_make(pli_vec3 linear, pli_vec3 angular) {
    const plii_twist twist = {linear, angular};
    return twist;
}
static inline plii_twist plii_twist_add(plii_twist a, plii_twist b) {
    return plii_twist_make(pli_vec3_add(a.linear, b.linear), pli_vec3_add(a.angular, b.angular));
}
static inline plii_twist plii_twist_sub(plii_twist a, plii_twist b) {
    return plii_twist_make(pli_vec3_sub(a.linear, b.linear), pli_vec3_sub(a.angular, b.angular));
}
static inline plii_twist plii_twist_scale(plii_twist a, float scale) {
    return plii_twist_make(pli_vec3_scale(a.linear, scale), pli_vec3_scale(a.angular, scale));
}

/* Motion of a rigid body through the substeps of a step. Its host moves it by one velocity per step; where it ends up
   against that is the shift, of which the host is told. */
typedef struct plii_rigid_path {
    pli_transform begin; /* of the step: before the host moved it */
    plii_twist begin_velocity;
    unsigned begin_version; /* of the pose */
    bool has_begun;
    pli_vec3 pull;      /* change of velocity by gravity, at the start of the step */
    plii_twist shift;   /* m, rad; by the soft bodies that have been solved */
    plii_twist carried; /* changes of velocity that the shift has in it */
    /* Of the soft body that is solved now, which follows it. */
    bool is_followed, is_pushed;
    pli_rigid* next;  /* of those that it follows */
    plii_twist start; /* velocity before its substeps */
    plii_twist gain;  /* of velocity in a substep: what the host did to it in the step */
    plii_twist drift; /* velocity with which it comes to the shift from before */
    plii_twist moved; /* in the substeps before this one; m, rad */
} plii_rigid_path;

struct pli_rigid {
    uint32_t magic;
    pli_world* world;
    pli_context* context;
    int world_index;
    void* user_data;
    /* From here to `rest_time` in snapshots (world/snapshot.c). */
    pli_rigid_kind kind;
    /* For static and kinematic bodies the inverse mass and inertia are zero, for static ones the velocities too. */
    pli_rigid_state state;
    float friction, restitution;
    pli_vec3 linear_factor, angular_factor;
    bool is_absent; /* pli_rigid_set_present */
    bool is_sensor; /* pli_rigid_set_sensor */
    bool is_asleep;
    bool has_changed; /* its shapes, mass or friction, or whether it is there: what sleeps on it wakes */
    bool was_touched, needs_reintegration;
    unsigned pose_version; /* counts changes of the pose by its host */
    plii_twist given;      /* velocity of the last pli_rigid_set_state */
    plii_twist start;      /* velocity before the impulses of this step; of one touched in it */
    plii_rigid_path path;
    pli_bounds step_bounds; /* where pairs of this step were looked for */
    pli_vec3 pull;          /* change of velocity by gravity in the next step */
    /* Of the feature that lets soft bodies sleep. */
    uint32_t sleep_group;    /* as of a body */
    unsigned seen_version;   /* of the pose, when it last was looked whether it wakes something */
    pli_transform rest_pose; /* and for how long it was near it; s */
    float rest_time;

    bool is_in_step;       /* a path, a touch or a pull of this step or the next is to be taken back */
    int first_body;        /* of those that meet it in this step (world/world_impl.h) */
    int first_island_body; /* the same of those with substeps (world/islands.c) */
    int shape_count, shape_capacity, shape_pose_capacity, shape_place_capacity;
    pli_shape** shapes;
    pli_transform* shape_poses;
    struct plii_shape_place* shape_places; /* [shape_count] in the world, see plii_rigid_place_shapes */
    pli_bounds bounds;                     /* of all shapes, likewise */
    bool are_shapes_placed;                /* since the pose or the shapes were changed */
};

/* PLI_OK, or the error of a null or wrong handle. */
static inline pli_status plii_check_rigid(const pli_rigid* rigid, const char* function) {
    return plii_check_handle(rigid, PLII_HANDLE_RIGID, NULL, NULL, function);
}
/* The error of a state, if there is one. */
pli_status plii_rigid_judge_state(pli_context* context, pli_rigid_kind kind, const pli_rigid_state* state,
                                  const char* function);
/* Takes the state if it has no error. */
pli_status plii_rigid_change(pli_rigid* rigid, pli_rigid_kind kind, const pli_rigid_state* state, const char* function);
/* In the world: pose of shape `index`, and bounds over all. */
pli_transform plii_rigid_shape_transform(const pli_rigid* rigid, int index);
pli_bounds plii_rigid_bounds(const pli_rigid* rigid);
void plii_rigid_find_places(pli_rigid* rigid);
/* To be called before pairs meet, which threads may do side by side: fills shape_places and bounds. */
static inline void plii_rigid_place_shapes(pli_rigid* rigid) {
    if (!rigid->are_shapes_placed) { plii_rigid_find_places(rigid); }
}
/* Where velocities bring a body. */
pli_transform plii_rigid_advance(pli_transform pose, plii_twist velocity, float dt);
/* After the solve of a step: puts into the shift what else has changed its velocities. */
void plii_rigid_end_path(pli_rigid* rigid, float dt);
/* What moves it from its pose to where it ends up in the step, as far as that is known. */
plii_twist plii_rigid_end_velocity(const pli_rigid* rigid, float dt);
pli_transform plii_rigid_end_pose(const pli_rigid* rigid, float dt);
/* Of the body here and there. */
pli_bounds plii_rigid_swept_bounds(const pli_rigid* rigid, float dt);

/* False for velocities that are NaN or beyond the limits. */
static inline bool plii_rigid_is_slow(const pli_rigid* rigid) {
    return plii_vec3_is_within(rigid->state.linear_velocity, PLI_MAX_SPEED) &&
           plii_vec3_is_within(rigid->state.angular_velocity, PLI_MAX_ANGULAR_SPEED);
}
static inline plii_twist plii_rigid_velocity(const pli_rigid* rigid) {
    return plii_twist_make(rigid->state.linear_velocity, rigid->state.angular_velocity);
}
static inline void plii_rigid_set_velocity(pli_rigid* rigid, plii_twist velocity) {
    rigid->state.linear_velocity = velocity.linear;
    rigid->state.angular_velocity = velocity.angular;
}
static inline void plii_rigid_begin_step(pli_rigid* rigid) {
    if (!rigid->is_in_step) { return; }
    rigid->was_touched = rigid->needs_reintegration = rigid->path.has_begun = false;
    rigid->state.linear_velocity = pli_vec3_add(rigid->state.linear_velocity, rigid->pull);
    rigid->given.linear = pli_vec3_add(rigid->given.linear, rigid->pull);
    rigid->path.pull = rigid->pull;
    rigid->is_in_step = !plii_vec3_is_zero(rigid->pull);
    rigid->pull = pli_vec3_make(0, 0, 0);
}
void plii_rigid_start_path(pli_rigid* rigid);
void plii_rigid_start_touch(pli_rigid* rigid);
/* To be called where a feature first meets it in a step, if possible before its host moves it. Bodies on several
   threads may do so in a prediction, and of static ones in a solve. */
static inline void plii_rigid_begin_path(pli_rigid* rigid) {
    if (!__atomic_load_n(&rigid->path.has_begun, __ATOMIC_ACQUIRE)) { plii_rigid_start_path(rigid); }
}
static inline bool plii_rigid_is_moved_by_host(const pli_rigid* rigid) {
    return rigid->path.begin_version != rigid->pose_version;
}
/* To be called before the first impulse of a step. Bodies on several threads may do so where contacts are made. */
static inline void plii_rigid_touch(pli_rigid* rigid) {
    plii_rigid_begin_path(rigid);
    if (PLII_LOAD(&rigid->was_touched)) { return; }
    plii_rigid_start_touch(rigid);
}
/* Velocity at an offset from the centre of mass. */
static inline pli_vec3 plii_rigid_velocity_at(const pli_rigid* rigid, pli_vec3 offset) {
    return pli_vec3_add(rigid->state.linear_velocity, pli_vec3_cross(rigid->state.angular_velocity, offset));
}
/* btRigidBody::applyTorqueImpulse. */
static inline void plii_rigid_apply_torque_impulse(pli_rigid* rigid, pli_vec3 impulse) {
    const pli_vec3 spin = pli_mat3_mul_vec3(rigid->state.inverse_inertia_world, impulse);
    rigid->state.angular_velocity =
        pli_vec3_add(rigid->state.angular_velocity, pli_vec3_mul(spin, rigid->angular_factor));
}
/* btRigidBody::applyImpulse, same order of operations. Nothing unless the body is dynamic. */
static inline void plii_rigid_apply_impulse(pli_rigid* rigid, pli_vec3 impulse, pli_vec3 offset) {
    if (rigid->state.inverse_mass == 0.0f) { return; }
    const pli_vec3 scaled = pli_vec3_mul(impulse, rigid->linear_factor);
    rigid->state.linear_velocity =
        pli_vec3_add(rigid->state.linear_velocity, pli_vec3_scale(scaled, rigid->state.inverse_mass));
    plii_rigid_apply_torque_impulse(rigid, pli_vec3_cross(offset, scaled));
}
/* The angular velocity that a unit impulse along a unit vector brings; 1/(kg m). */
static inline pli_vec3 plii_rigid_spin_of(const pli_rigid* rigid, pli_vec3 direction, pli_vec3 offset) {
    const pli_vec3 torque = pli_vec3_cross(offset, pli_vec3_mul(direction, rigid->linear_factor));
    return pli_vec3_mul(pli_mat3_mul_vec3(rigid->state.inverse_inertia_world, torque), rigid->angular_factor);
}
/* The velocity along a unit vector that a unit impulse along it brings to the centre, 1/kg; along another one times its
   squared length. */
static inline float plii_rigid_linear_response(const pli_rigid* rigid, pli_vec3 direction) {
    return rigid->state.inverse_mass * pli_vec3_dot(direction, pli_vec3_mul(direction, rigid->linear_factor));
}
/* plii_rigid_apply_impulse along a direction. */
static inline void plii_rigid_apply_along(pli_rigid* rigid, pli_vec3 direction, pli_vec3 spin, float impulse) {
    const float change = rigid->state.inverse_mass * impulse;
    if (change == 0.0f) { return; }
    rigid->state.linear_velocity = pli_vec3_add(rigid->state.linear_velocity,
                                                pli_vec3_scale(pli_vec3_mul(direction, rigid->linear_factor), change));
    rigid->state.angular_velocity = pli_vec3_add(rigid->state.angular_velocity, pli_vec3_scale(spin, impulse));
}

/* Velocity at an offset from the centre of mass per impulse there: inverse_mass * I - [offset]x W [offset]x. */
pli_mat3 plii_point_response(float inverse_mass, const pli_mat3* inverse_inertia, pli_vec3 offset);
/* The same with the factors of a rigid body. */
pli_mat3 plii_rigid_response(const pli_rigid* rigid, pli_vec3 offset);
pli_mat3 plii_rigid_inertia(const pli_rigid* rigid); /* the inverse one */
/* Impulse that changes the relative displacement of a point mass and a rigid body at `offset` by one unit per step:
   (1/dt) * inverse((point_inverse_mass + rigid_inverse_mass) * I - [offset]x rigid_inverse_inertia [offset]x). Bullet:
   ImpulseMatrix(dt, ...), which leaves the factors out: where they hold a light body, it would seem to give way. Equal
   bit for bit where all factors are 1. */
void plii_effective_mass(float dt, float point_inverse_mass, const pli_rigid* rigid, bool has_factors, pli_vec3 offset,
                         pli_mat3* matrix);
