#pragma once

#include "body/body_impl.h"
#include "body/rigid_impl.h"
#include "pliant/world.h"

/* Sleep, as a step sees it. A program that enables no sleep has none of it (features/sleep.c). */
typedef struct plii_world_sleep {
    void (*begin_step)(pli_world* world, float dt); /* before the prediction: wakes */
    /* After it: wakes those whom predicted bodies meet, and predicts them. */
    void (*wake_met)(pli_world* world, void (*predict)(pli_body* body));
    void (*end_step)(pli_world* world, float dt); /* after the solve: puts to sleep */
} plii_world_sleep;

struct pli_world {
    uint32_t magic;
    pli_context* context;
    pli_world_def def;
    bool is_stepping;
    float dt;           /* s, of the step in progress, or of the last one */
    bool needs_reserve; /* what features make room for has changed since the last step, or there was no memory for it */
    /* As of when room was made. */
    int most_nodes, most_faces; /* of a body */
    bool has_convex_shapes, has_other_shapes;
    int joint_iterations;  /* of the joint solve in progress */
    uint32_t collide_call; /* counts those of many pairs */
    uint32_t revision;     /* counts bodies and rigid bodies that come and go, */
    uint32_t removals;     /* and what goes that features of other bodies may keep: these, and clusters */
    pli_body** bodies;
    int body_count, body_capacity;
    pli_body** sweep; /* [body_count] sorted by the lower x bound */
    int sweep_capacity;
    pli_body_pair* pairs; /* that overlap, in a step */
    int* pair_orders;     /* [2 * pairs] their order in waves, and their waves */
    int pair_capacity, pair_order_capacity;
    int* islands; /* [body_count] parents of disjoint sets (union_find.h) of bodies that touch, when there are some */
    int island_capacity;
    bool has_islands; /* in this step, or the last one */
    /* What is solved by one thread (world/world_impl.h). Not there without threads. */
    bool has_groups;         /* in this step */
    bool are_groups_parted;  /* by the last solve: no group had most of the nodes */
    int* group_roots;        /* [body_count] parents of disjoint sets of bodies */
    int* group_begin;        /* [group_count + 1] of each group in group_bodies */
    pli_body** group_bodies; /* [body_count] */
    int group_count, group_root_capacity, group_begin_capacity, group_body_capacity;
    const plii_world_sleep* sleep;                             /* NULL until a body may sleep */
    uint32_t sleep_group;                                      /* the last one */
    void (*take_update_intervals)(pli_world* world, float dt); /* NULL until a body has one */
    bool has_frozen; /* bodies froze, and their events are not in the list yet */
    bool is_entered; /* a thread is in a call of a step */
    pli_rigid** rigids;
    int rigid_count, rigid_capacity;
    pli_event* events;
    int event_count, event_capacity;
    plii_shortage shortage;  /* of memory in this step, the first; count 0: none */
    pli_profile_fn* profile; /* NULL: off */
    void* profile_user;
};

/* In a `for`: each body of a world, and each rigid body. */
#define PLII_EACH_BODY(body, world) PLII_EACH_AT(pli_body, body, (world)->bodies, (world)->body_count)
#define PLII_EACH_RIGID(rigid, world) PLII_EACH_AT(pli_rigid, rigid, (world)->rigids, (world)->rigid_count)

/* Bodies and rigid proxies keep their index in the list as `world_index`; removal closes the gap, order is kept. */
pli_status plii_world_add_body(pli_world* world, pli_body* body);
void plii_world_remove_body(pli_world* world, pli_body* body);
pli_status plii_world_add_rigid(pli_world* world, pli_rigid* rigid);
void plii_world_remove_rigid(pli_world* world, pli_rigid* rigid);
void plii_world_use_update_intervals(pli_world* world);
bool plii_update_interval_is_valid(const plii_update_interval* interval);
/* The last allocation failed, and not only room for later is missing: the step tells. */
void plii_world_note_shortage(pli_world* world);
/* A body has frozen, on any thread: adds the event as soon as it may. */
void plii_world_note_frozen(pli_world* world);
/* Not from parts of a range. */
void plii_world_add_event(pli_world* world, pli_event event);
/* Anchors or joints of a body have gone with their rigid body: one event, however often it is told. */
void plii_world_add_anchors_lost(pli_body* body);

/* The bodies touch: they are solved side by side in this step, where they can be. */
void plii_world_join_bodies(pli_world* world, pli_body* body, pli_body* other);

/* What memory is missing from now on is missing for this body. */
static inline void plii_world_begin_body(const pli_body* body) {
    const plii_pass pass = {body->world_index, NULL};
    plii_thread.pass = pass;
}
/* Of a point of a rigid body in this step, m; m/s and N s in the time of the soft body, see rigid_pace. */
static inline pli_vec3 plii_rigid_motion_at(const pli_body* body, const pli_rigid* rigid, pli_vec3 offset) {
    return pli_vec3_scale(plii_rigid_velocity_at(rigid, offset), body->host_dt);
}
static inline pli_vec3 plii_rigid_pace_at(const pli_body* body, const pli_rigid* rigid, pli_vec3 offset) {
    return pli_vec3_scale(plii_rigid_velocity_at(rigid, offset), body->rigid_pace);
}
static inline void plii_rigid_push_at(const pli_body* body, pli_rigid* rigid, pli_vec3 impulse, pli_vec3 offset) {
    plii_rigid_apply_impulse(rigid, pli_vec3_scale(impulse, 1.0f / body->rigid_pace), offset);
}
/* Rigid bodies that take impulses go along while the body is solved (substep_rigid.h). */
static inline bool plii_follows_rigids(const pli_body* body) {
    const plii_solver_class* solver = body->solver_class;
    return solver->has_substeps || !(solver->solves_constraints || body->world->def.reference_mode);
}
static inline void plii_world_profile(const pli_world* world, const char* stage, const char* feature, bool begins) {
    if (world->profile != NULL) { world->profile(stage, feature, begins, world->profile_user); }
}

/* The error of a call while another thread steps the world. */
PLII_COLD pli_status plii_refuse_entered(const pli_world* world, const char* function);
/* PLI_OK, or the error of a null or wrong handle. */
static inline pli_status plii_check_world(const pli_world* world, const char* function) {
    return plii_check_handle(world, PLII_HANDLE_WORLD, NULL, NULL, function);
}
/* The same for a call that changes something, which must not come from a callback ... */
static inline pli_status plii_check_world_change(const pli_world* world, const char* function) {
    PLII_TRY(plii_check_world(world, function));
    PLII_TRY(plii_check_change(world->context, function));
    return PLII_LOAD(&world->is_entered) ? plii_refuse_entered(world, function) : PLI_OK;
}
/* ... nor between predict and solve. */
pli_status plii_check_world_idle(const pli_world* world, const char* function);
/* As plii_check_world_change, for a rigid body. */
static inline pli_status plii_check_rigid_change(const pli_rigid* rigid, const char* function) {
    PLII_TRY(plii_check_rigid(rigid, function));
    return plii_check_world_change(rigid->world, function);
}

/* A number of a group that falls asleep now; never 0. */
uint32_t plii_world_next_sleep_group(pli_world* world);
/* With the others of the group. */
void plii_body_fall_asleep(pli_body* body, uint32_t group);

/* m, what a body at rest falls in the step. */
static inline float plii_step_fall(const pli_body* body) {
    return pli_vec3_length(body->world->def.gravity) * body->step.dt * body->step.dt;
}
