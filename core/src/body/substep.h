#pragma once

/* The hook of solvers that part a step into substeps: where nodes are meanwhile, and how features take part. */

#include "body/body_impl.h"

typedef struct plii_substep plii_substep;

/* How far what cannot move at all lets a node go along a unit vector, m; INFINITY: nothing is in its way. A rigid body
   that presses on the node meets with that, which light nodes between would be many sweeps about. Straight on; where
   that is less than `wanted`, m, also by sliding aside. */
typedef float plii_substep_room_fn(const pli_body* body, const void* state, const plii_substep* substep, int node,
                                   pli_vec3 direction, float wanted);

/* `motion`, m in the substep, of that where it does not stand still; `own`, that of the node before. True: it takes the
   node along, and is not slid over. Else what slides away along `direction` does so. */
typedef bool plii_substep_carry_fn(const pli_body* body, const void* state, const plii_substep* substep, int node,
                                   pli_vec3 direction, pli_vec3 own, pli_vec3* motion);

/* The features that limit it in this step. */
enum { PLII_MAX_SUBSTEP_LIMITS = 4 };
typedef struct plii_substep_limits {
    int count;
    const plii_pipeline_entry* at[PLII_MAX_SUBSTEP_LIMITS];
} plii_substep_limits;

/* Nodes are at body->positions + displacements. Positions are those of the start of this substep or of one not long
   before; what rounding left out is in the displacements, so that nothing is lost however short a substep is. */
struct plii_substep {
    float dt, inverse_dt;               /* s, of the substep */
    float host_dt, inverse_host_dt;     /* s, the same for rigid bodies */
    float remaining;                    /* s, of the step after it */
    int index;                          /* of the substep in the step */
    float lag;                          /* what softens XPBD in a step that is short, from 0 on: see xpbd_find_lag */
    bool is_absolute;                   /* displacements are positions, as positions are where nodes are */
    bool has_new_positions;             /* since the substep before, or the first one */
    bool is_first_sweep, is_last_sweep; /* of the substep: multipliers are 0 before, nobody needs them afterwards */
    pli_vec4* displacements;            /* [node_count] m; w = inverse mass */
    pli_vec4* start_displacements;      /* [node_count] m, the displacements at the start of the substep */
    const plii_substep_limits* limits;
};

/* A whole step as one substep, to solvers that have none; inline, so that they do not bring in those that do. */
static inline plii_substep plii_substep_of_step(const pli_body* body, pli_vec4* positions, pli_vec4* starts) {
    return (plii_substep){.dt = body->step.dt,
                          .inverse_dt = body->step.inverse_dt,
                          .host_dt = body->host_dt,
                          .inverse_host_dt = 1.0f / body->host_dt,
                          .is_absolute = true,
                          .has_new_positions = true,
                          .displacements = positions,
                          .start_displacements = starts};
}

typedef void plii_substep_fn(pli_body* body, void* state, const plii_substep* substep);

/* Features that name one in their class take part whenever the body is stepped by XPBD. */
typedef struct plii_substep_class {
    /* Of the sweep, an enum constant in the feature's own file: to 49 what holds the body together, from 50 on anchors
       and contacts, so that what is drawn does not penetrate. */
    int order;
    bool is_of_xpbd;       /* enabled by plii_xpbd_enable_kind; goes when another solver steps the body */
    bool is_in_iterations; /* of the position-based solver too, but in reference mode: see plii_follows_rigids */
    void (*begin)(pli_body* body, void* state); /* before the first substep, positions still predicted; optional */
    plii_substep_fn* restart;                   /* before the sweeps of a substep: multipliers to zero; optional */
    plii_substep_fn* sweep;                     /* NULL: it only begins with the step */
    plii_substep_fn* after_links;               /* of XPBD, in each sweep; optional */
    plii_substep_fn* finish;                    /* after a substep, velocities are those of its end; optional */
    plii_substep_room_fn* room;                 /* optional */
    plii_substep_carry_fn* carry;               /* optional: what limits the node may move */
    bool (*is_limit)(const void* state);        /* after `begin`, if not idle: asked for room; NULL: yes */
    /* After `begin`: there is nothing to do in this step. Optional. */
    bool (*is_idle)(const void* state);
} plii_substep_class;
/* What a class says of them. */
#define PLII_SUBSTEPPED(...) (&(const plii_substep_class){__VA_ARGS__})

static inline pli_vec3 plii_substep_place(const pli_body* body, const plii_substep* substep,
                                          const pli_vec4* displacements, int node) {
    const pli_vec3 displacement = plii_xyz(displacements[node]);
    return substep->is_absolute ? displacement : pli_vec3_add(plii_xyz(body->positions[node]), displacement);
}
static inline pli_vec3 plii_substep_position(const pli_body* body, const plii_substep* substep, int node) {
    return plii_substep_place(body, substep, substep->displacements, node);
}
static inline pli_vec3 plii_substep_start(const pli_body* body, const plii_substep* substep, int node) {
    return plii_substep_place(body, substep, substep->start_displacements, node);
}
/* Since the start of the substep. */
static inline pli_vec3 plii_substep_motion(const plii_substep* substep, int node) {
    return pli_vec3_sub(plii_xyz(substep->displacements[node]), plii_xyz(substep->start_displacements[node]));
}
static inline void plii_substep_move(const plii_substep* substep, int node, pli_vec3 gradient, float multiplier) {
    pli_vec4* displacement = &substep->displacements[node];
    plii_add_xyz(displacement, pli_vec3_scale(gradient, displacement->w * multiplier));
}

/* Before the sweeps of a substep: moves a node as if it had started there, so that no velocity comes of it. */
static inline void plii_substep_shift(const plii_substep* substep, int node, pli_vec3 shift) {
    plii_add_xyz(&substep->displacements[node], shift);
    plii_add_xyz(&substep->start_displacements[node], shift);
}

/* Before the sweeps of a substep: how far what limits the node goes in it, m, along the normal of what presses on the
   node. Across it, how far the node has gone before, as a cloth that is pulled over the ground. */
pli_vec3 plii_substep_carried(const pli_body* body, const plii_substep* substep, int node, pli_vec3 normal);
/* The least that features leave. */
float plii_substep_room(const pli_body* body, const plii_substep* substep, int node, pli_vec3 direction, float wanted);

/* What takes part in the substeps of a body. */

enum { PLII_MAX_SUBSTEP_KINDS = 16 };

/* Features of the body that take part, by order; equals as they came. */
typedef struct plii_substep_kinds {
    int count;
    const plii_pipeline_entry* at[PLII_MAX_SUBSTEP_KINDS];
    plii_substep_limits limits;
} plii_substep_kinds;

/* All but those that have nothing to do in this step. */
void plii_substep_kinds_begin(pli_body* body, plii_substep_kinds* kinds, bool in_iterations);
void plii_substep_kinds_restart(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep);
void plii_substep_kinds_sweep(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep);
