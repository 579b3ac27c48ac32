#ifndef PLII_XPBD_IMPL_H
#define PLII_XPBD_IMPL_H

/* What the kinds of constraints know of the XPBD solver: where nodes are, and how to take part in its sweeps. */

#include "body/body_impl.h"
#include "pliant/xpbd.h"
#include "solver/coloring/node_planes.h"

/* During the substeps nodes are at body->positions + displacements. Positions are those of the start of the substep;
   what their rounding left out is carried on in `carried`, so that nothing is lost however short a substep is. */
typedef struct plii_xpbd_planes {
    plii_planes positions, displacements, carried; /* m; w of the displacements: inverse mass, the others have none */
} plii_xpbd_planes;

/* All of the nodes in a step in planes, in the places of what is in records otherwise. Only displacements have w. */
typedef struct plii_xpbd_plane_nodes {
    plii_xpbd_planes moving;
    plii_planes velocities, accelerations;
    int block_count;      /* of PLII_LANES even and as many odd nodes */
    float dt, inverse_dt; /* s, of the substep */
    pli_body* body;
    const struct plii_xpbd_records* records;
} plii_xpbd_plane_nodes;

/* Records that a body has for XPBD, [plii_planes_record_count]. */
typedef struct plii_xpbd_records {
    pli_vec4 *displacements, *carried, *accelerations;
} plii_xpbd_records;

enum { PLII_XPBD_TAKES = 3, PLII_XPBD_GIVES = 2 };

/* What the solver does to nodes in planes; comes with the kinds that can do with planes. Ranges have
   plii_xpbd_plane_nodes as their task. */
typedef struct plii_xpbd_plane_moves {
    /* Where the planes are. Body, records and times are there already. */
    void (*lay_out)(plii_xpbd_plane_nodes* nodes);
    /* From records to planes and back, one after the other for all nodes; ranges are of nodes. */
    pli_range_fn *takes[PLII_XPBD_TAKES], *gives[PLII_XPBD_GIVES];
    void (*fill)(const plii_xpbd_plane_nodes* nodes); /* what lies behind the nodes, after the takes */
    pli_range_fn *move, *finish, *finish_and_move;    /* ranges are of blocks */
} plii_xpbd_plane_moves;

extern const plii_xpbd_plane_moves plii_xpbd_moves_in_planes;

typedef struct plii_xpbd_substep {
    float dt, inverse_dt;               /* s, of the substep */
    int index;                          /* of the substep in the step */
    bool is_first_sweep, is_last_sweep; /* of the substep: multipliers are 0 before, nobody needs them afterwards */
    pli_vec4* displacements;            /* [node_count] m; w = inverse mass */
    pli_vec4* carried; /* [node_count] m, the displacements at the start of the substep; w = inverse mass */
    const plii_xpbd_planes* planes; /* or NULL; if there, nodes are in them alone */
} plii_xpbd_substep;

typedef void plii_xpbd_run_fn(pli_body* body, void* state, const plii_xpbd_substep* substep);

/* Kinds that only XPBD has are enabled by plii_xpbd_enable_kind; features of other solvers name theirs in their class
   and take part whenever the body is stepped by XPBD. */
typedef struct plii_xpbd_kind {
    int order;
    const plii_feature_class* klass;
    void (*begin)(pli_body* body, void* state); /* before the first substep, positions still predicted; optional */
    plii_xpbd_run_fn* restart;                  /* before the sweeps of a substep: multipliers to zero; optional */
    plii_xpbd_run_fn* sweep;
    plii_xpbd_run_fn* finish; /* after a substep, velocities are those of its end; optional */
    /* After `begin`: there is nothing to do in this step. Optional. */
    bool (*is_idle)(const pli_body* body, const void* state);
    /* How nodes are moved in planes, where all that is to do in this step can be done there; or NULL. Optional. */
    const plii_xpbd_plane_moves* (*planes)(const pli_body* body, const void* state);
} plii_xpbd_kind;

/* Contacts come last, so that what is drawn does not penetrate. */
enum {
    PLII_XPBD_ORDER_BENDING = 10,
    PLII_XPBD_ORDER_TETRAS = 20,
    PLII_XPBD_ORDER_VOLUME = 30,
    PLII_XPBD_ORDER_LINKS = 40,
    PLII_XPBD_ORDER_TETHERS = 45, /* anchors take their nodes along after them */
    PLII_XPBD_ORDER_ANCHORS = 50,
    PLII_XPBD_ORDER_SELF_COLLISION = 55, /* rigid bodies have the last word */
    PLII_XPBD_ORDER_RIGID_CONTACTS = 60,
    PLII_XPBD_ORDER_SOFT_CONTACTS = 70,
    PLII_XPBD_ORDER_SELF_FACES = 1000 /* nothing may move nodes after this */
};

/* Enables the feature of a kind and lets it take part in sweeps; fails unless the body is stepped by XPBD. */
pli_status plii_xpbd_enable_kind(pli_body* body, const plii_xpbd_kind* kind, const char* function, void** state);
pli_status plii_xpbd_disable_kind(pli_body* body, const plii_xpbd_kind* kind, const char* function);
/* PLI_OK, or the error of a value that is negative or not finite. */
pli_status plii_xpbd_check_value(const pli_body* body, float value, float limit, const char* name,
                                 const char* function);

static inline pli_vec3 plii_xpbd_position(const pli_body* body, const plii_xpbd_substep* substep, int node) {
    return pli_vec3_add(plii_xyz(body->positions[node]), plii_xyz(substep->displacements[node]));
}
/* Since the start of the substep. */
static inline pli_vec3 plii_xpbd_motion(const plii_xpbd_substep* substep, int node) {
    return pli_vec3_sub(plii_xyz(substep->displacements[node]), plii_xyz(substep->carried[node]));
}
static inline void plii_xpbd_move(const plii_xpbd_substep* substep, int node, pli_vec3 gradient, float multiplier) {
    pli_vec4* displacement = &substep->displacements[node];
    plii_set_xyz(displacement,
                 pli_vec3_add(plii_xyz(*displacement), pli_vec3_scale(gradient, displacement->w * multiplier)));
}

/* Before the sweeps of a substep: moves a node as if it had started there, so that no velocity comes of it. */
static inline void plii_xpbd_shift(const plii_xpbd_substep* substep, int node, pli_vec3 shift) {
    pli_vec4 *displacement = &substep->displacements[node], *start = &substep->carried[node];
    plii_set_xyz(displacement, pli_vec3_add(plii_xyz(*displacement), shift));
    plii_set_xyz(start, pli_vec3_add(plii_xyz(*start), shift));
}

/* Change of the multiplier of a constraint (Macklin and others 2016, equations 18 and 26).
   c: its value; weight: sum of w |gradient|^2; c_motion: change of c by the motion in this substep. 0 where the
   constraint has nothing to act on. */
static inline float plii_xpbd_multiplier(float c, float weight, float compliance, float damping, float multiplier,
                                         float c_motion, const plii_xpbd_substep* substep) {
    const float alpha = compliance * substep->inverse_dt * substep->inverse_dt;
    const float gamma = compliance * damping * substep->inverse_dt;
    const float change = (-c - alpha * multiplier - gamma * c_motion) / ((1.0f + gamma) * weight + alpha);
    return weight > 0.0f && plii_is_finite(change) ? change : 0.0f;
}

#endif
