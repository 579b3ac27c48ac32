#ifndef RANDOM_CALLS_CALLS_H
#define RANDOM_CALLS_CALLS_H

/* What a sequence has made so far, and what its parts share. */

#include "byte_source.h"
#include "random_calls.h"

#include <pliant/pliant.h>

enum {
    CALLS_CONTEXTS = 2,
    CALLS_WORLDS = 3,
    CALLS_MESHES = 4,
    CALLS_BODIES = 5,
    CALLS_RIGIDS = 5,
    CALLS_SHAPES = 6,
    CALLS_IDS = 6,
    CALLS_MOST_NODES = 120, /* what has more is not refined any further */
    CALLS_MOST = 90         /* calls of a sequence */
};

struct calls;

/* With an allocator of its own, which may fail. */
typedef struct calls_context {
    struct calls* calls;
    pli_context* context;
    size_t alive;    /* bytes */
    int fail_in;     /* allocations until one fails; 0: none does */
    int fail_count;  /* how many fail then */
    uint64_t errors; /* that were logged */
} calls_context;

typedef struct calls_mesh {
    pli_mesh* mesh;
    calls_context* home;
} calls_mesh;

typedef struct calls_shape {
    pli_shape* shape;
    calls_context* home;
} calls_shape;

typedef struct calls_world {
    pli_world* world;
    calls_context* home;
} calls_world;

typedef struct calls_body {
    pli_body* body;
    calls_world* world;
} calls_body;

typedef struct calls_rigid {
    pli_rigid* rigid;
    calls_world* world;
} calls_rigid;

/* A state of a body, to be set back. */
typedef struct calls_state {
    pli_vec3 positions[CALLS_MOST_NODES], velocities[CALLS_MOST_NODES];
    int count;
} calls_state;

typedef struct calls {
    byte_source bytes;
    unsigned kinds;
    random_calls_report* report;
    int call_count;
    uint64_t digest;       /* of all that there is, after the last call */
    calls_context* active; /* whose call is under way */
    uint32_t whim;         /* of callbacks */
    int custom_shapes;     /* alive */
    calls_context contexts[CALLS_CONTEXTS];
    calls_world worlds[CALLS_WORLDS];
    calls_mesh meshes[CALLS_MESHES];
    calls_body bodies[CALLS_BODIES];
    calls_rigid rigids[CALLS_RIGIDS];
    calls_shape shapes[CALLS_SHAPES];
    pli_anchor_id anchors[CALLS_IDS];
    pli_joint_id joints[CALLS_IDS];
    calls_state saved;
} calls;

typedef void calls_fn(calls* c);

// -------------------------------------------------------------------------------------------- check.c

void calls_finding(calls* c, const char* format, ...) PLI_PRINTF_LIKE(2, 3);
bool calls_have_finding(const calls* c);
uint64_t calls_digest(calls* c);
/* Around each call; `home` is NULL where no context can know of the call. */
void calls_begin(calls* c, calls_context* home);
pli_status calls_end(calls* c, calls_context* home, const char* call, pli_status status);
/* Of the calls that make up a step: without memory they go on. */
pli_status calls_end_of_step(calls* c, calls_context* home, const char* call, pli_status status);

#define CALL(c, home, call) (calls_begin(c, home), calls_end(c, home, #call, call))
#define STEP_CALL(c, home, call) (calls_begin(c, home), calls_end_of_step(c, home, #call, call))
#define VOID_CALL(c, home, call)                                                                                       \
    do {                                                                                                               \
        calls_begin(c, home);                                                                                          \
        call;                                                                                                          \
        calls_end(c, home, #call, PLI_OK);                                                                             \
    } while (0)

// -------------------------------------------------------------------------------------------- objects.c

bool calls_open(calls* c);
/* Destroys everything, in an order that the bytes say. */
void calls_close(calls* c);

/* One of those that there are, which is made when there is none; NULL when that fails. */
calls_context* calls_any_context(calls* c);
calls_world* calls_any_world(calls* c);
calls_mesh* calls_any_mesh(calls* c);
calls_body* calls_any_body(calls* c);
calls_rigid* calls_any_rigid(calls* c);
calls_shape* calls_any_shape(calls* c);

/* A place for one more; what was there is destroyed. NULL when that is not allowed now. */
calls_mesh* calls_mesh_place(calls* c);
calls_shape* calls_shape_place(calls* c);

/* Whether a mesh or shape of `home` may be tried in `world`. */
bool calls_may_mix(const calls* c, const calls_context* home, const calls_world* world);
bool calls_is_stepping(const calls_world* world);

calls_fn calls_make_world, calls_make_body, calls_make_rigid, calls_destroy_something, calls_fail_allocations;

// -------------------------------------------------------------------------------------------- calls by subject

calls_fn calls_make_mesh, calls_edit_mesh;  /* mesh_calls.c */
calls_fn calls_make_shape, calls_use_shape; /* shape_calls.c */
calls_fn calls_set_up_body, calls_move_body, calls_save_state, calls_set_state_back,
    calls_measure_body;                                                       /* body_calls.c */
calls_fn calls_change_feature;                                                /* feature_calls.c */
calls_fn calls_change_solver;                                                 /* solver_calls.c */
calls_fn calls_change_clusters, calls_add_joint;                              /* cluster_calls.c */
calls_fn calls_cut;                                                           /* cut_calls.c */
calls_fn calls_change_rigid, calls_add_anchor;                                /* rigid_calls.c */
calls_fn calls_step, calls_step_in_parts, calls_set_up_world, calls_cast_ray; /* step_calls.c */

// -------------------------------------------------------------------------------------------- callbacks.c

/* From inside of a callback: reads something, and tries what is not allowed there. */
void calls_from_callback(calls* c);
pli_joint_controller calls_controller(calls* c);
pli_cluster_distance_fn calls_cluster_distance;
pli_profile_fn calls_profile;
float calls_surface(pli_vec3 point, void* user);
/* A sphere with functions of its own; some lie. */
pli_shape_def calls_custom_shape(calls* c);

#endif
