#pragma once

#include "base/handle.h"
#include "body/all_features.h"
#include "mesh/topology.h"

/* 12 bytes. What follows from masses and material is made where it is needed. */
typedef struct plii_link {
    int nodes[2];
    float rest_length_squared; /* m^2 */
} plii_link;

/* Material and kind of a link; kept only where they differ from material 0, not bending. */
typedef uint16_t plii_link_tag;
#define PLII_LINK_TAG_BENDING 0x8000

/* How often a solver sweeps in a step. */
typedef struct plii_solver_pace {
    int substeps, sweeps; /* 1 without substeps; in each of them */
} plii_solver_pace;

/* How a body is stepped. One is chosen at a time; those other than the position-based one come with a feature. */
typedef struct plii_solver_class {
    const char* name;
    void (*predict)(pli_body* body, float dt); /* to where contacts are looked for; dt s, not yet scaled */
    plii_solver_pace (*pace)(const pli_body* body);
    void (*solve)(pli_body* first); /* bodies that touch, side by side, see plii_solve_island */
    int last_couples;               /* see plii_body_last_couples */
    bool has_substeps;              /* runs the substeps of features instead of PREPARE and POSITION */
    /* Of the margin: so much further out contacts with rigid bodies are looked for that sweeps do not solve. */
    float contact_reach;
    /* Takes the constraints of features (node_constraint.h) into its system; their position solves rest. */
    bool solves_constraints;
} plii_solver_class;

/* world/update_interval.c */
typedef struct plii_update_interval {
    int steps;       /* of the world, that a step of the body covers; 1: each */
    int first_steps; /* the next one; 0: as many */
    float step;      /* s, the last one of the body */
    float lead;      /* s, by which it is ahead of the world */
    bool is_waiting; /* takes no part in this step of the world */
    bool is_near;    /* has met a dynamic rigid body or another body since its step began */
} plii_update_interval;

struct pli_body {
    /* What hosts ask of every body and pair comes first, in one line of the cache. */
    uint32_t magic;
    bool is_frozen;
    bool is_asleep;            /* features/sleep.c */
    bool was_frozen;           /* just now, at `lost_node`: the event comes when all bodies are through */
    bool collides_with_bodies; /* a feature has collide_body */
    bool solves_rigids;        /* a feature has collide_rigid, and does not act with joints */
    bool may_be_joined;        /* a feature has visit_joined */
    bool has_crosses;          /* plii_normals_crosses are those of the positions */
    int world_index;           /* in the world's list */
    pli_bounds bounds;         /* of the nodes, grown by the margin; in a step see sweeping_features */
    pli_world* world;
    pli_context* context;
    void* user_data;

    int node_count, link_count, material_count;
    /* The next three are one block, see plii_body_node_block_size. */
    pli_vec4* positions;      /* [node_count] xyz, w = inverse mass */
    pli_vec4* previous;       /* [node_count] xyz at the start of the step */
    pli_vec4* velocities;     /* [node_count] xyz */
    plii_link* links;         /* [link_count] */
    plii_link_tag* link_tags; /* [link_count] or NULL */
    uint32_t link_revision;   /* counts changes of links, rest lengths and masses, */
    uint32_t length_revision; /* and those of links and rest lengths alone */
    /* One sweep over the links on positions: in their order unless a feature knows better. */
    void (*sweep_links)(pli_body* body, void* state);
    void* sweep_links_state;
    uint32_t sweep_revision; /* of the links, as of when it was chosen */
    pli_material* materials; /* [material_count] */
    plii_topology* topology;

    /* From here to `sleep_group` in snapshots (world/snapshot.c). */
    plii_update_interval interval;
    float collision_margin;
    pli_solver_settings solver;
    plii_step step;       /* of the step in progress */
    int joint_iterations; /* wanted in the joint solve; 0 without clusters */
    /* Features that look at the whole motion of the nodes. With them the bounds of a predicted body cover the start of
       the step too, as where it leaps, and rigid bodies are met along their motion. */
    int sweeping_features;
    bool is_resting;        /* for its time */
    bool is_woken;          /* since it fell asleep; it wakes in the next prediction */
    bool was_asleep;        /* as of the last event */
    uint32_t overlap_steps; /* in steps before it is 0 it may be inside of another body, where it was put */
    uint32_t sleep_group;   /* what fell asleep together, bodies and rigid bodies; 0: awake */

    const plii_solver_class* solver_class;
    plii_pipeline pipeline;
    float host_dt, rigid_pace; /* s, of the step for rigid bodies; how many times as fast the body sees them */
    bool has_swept_contacts;   /* found in this step, see plii_iterated_sweeps_class */
    bool leaps;                /* in this step its bounds move by more than the margin, where plii_follows_rigids */
    bool has_early_bounds;     /* those of this step are taken already; see pli_world_def.reference_mode */
    bool damps_links;          /* under XPBD, in this step */
    float soft_slack;          /* m, by which soft contacts look farther at rest; 0: they do not look ahead */

    /* Filled by services, NULL while nobody needs them. */
    pli_vec3* forces;       /* [node_count] N, consumed by integration */
    pli_vec3* normals;      /* [node_count] unit, zero for nodes without faces; after each step */
    pli_vec3* face_normals; /* [face_count] unit; likewise */
    float* areas;           /* [node_count] mean of the doubled areas of the faces around, at rest */
    float* face_areas;      /* [face_count] doubled area, at rest */
    /* As Bullet keeps them, for comparisons (contact/bullet_boxes.c). */
    pli_bounds* node_boxes; /* [node_count] rigid bodies are met by the nodes whose boxes they touch */
    pli_bounds* face_boxes; /* [face_count] */
    pli_vec3* soft_shifts;  /* [node_count] m, or NULL: by which soft contacts have taken overlaps back in this solve */
    bool records_contacts;  /* a feature asks for it, see contact_report.h */
    bool is_parting;        /* soft contacts took much of their shifts out in the last SETTLE */
    struct plii_clusters* clusters;                  /* NULL unless they are enabled */
    const struct plii_rigid_contacts* node_contacts; /* with rigid bodies; likewise */
    uint8_t* anchored;                               /* [node_count] 1 where an anchor holds the node */
    bool (*is_anchored_to)(const pli_body* body, int node, const pli_rigid* rigid); /* set when `anchored` is */

    uint32_t collide_call; /* the last one of many pairs that it was in */
    int pair_wave;         /* of the last of its pairs with other bodies in this step (world/collide.c); -1: none */
    /* Of the feature that lets bodies sleep. */
    bool can_sleep;
    bool is_group_resting; /* of the first one of bodies that touch each other */
    int lost_node;
    bool is_solved;                     /* in this step, while others are */
    const struct plii_substep* substep; /* in it; NULL outside of substeps */
    float* gas; /* N m: under XPBD, where a constraint on the volume asks for the gas in it in this step, or NULL */
    /* The first of the bodies that are solved together in this step, NULL: alone; and the next one of them. */
    pli_body *island, *island_next;
    pli_rigid* followed_rigids;                      /* list by path.next, see body/substep_rigid.h */
    void (*finish_rigids)(pli_body* body, float dt); /* set when there are some; s, of a substep for them */
    const pli_rigid** ignored_rigids;
    int ignored_rigid_count, ignored_rigid_capacity;
};

/* The services that forces on the surface need. */
extern const plii_feature_class* const plii_surface_force_needs[];

/* Of each node, the sum of the cross products of its faces, six times the gradient of the volume; valid until the next
   call or step. Needs normals. NULL in reference mode. */
const pli_vec4* plii_normals_crosses(pli_body* body);

/* One Gauss-Seidel sweep over all links in their order (btSoftBody::PSolve_Links); no state. */
void plii_links_sweep(pli_body* body, void* state);
/* A sweep as the body has it. */
void plii_links_run(pli_body* body, void* state);

/* Over the nodes, on several threads where they are more than `grain`. */
static inline void plii_body_run_nodes(const pli_body* body, pli_range_fn* range, void* task, int grain) {
    plii_parallel_for(body->context, range, task, body->node_count, grain);
}
static inline void plii_body_copy_positions(const pli_body* body, pli_vec3* positions) {
    for (int i = 0; i < body->node_count; ++i) {
        positions[i] = plii_xyz(body->positions[i]);
    }
}
/* Moves a node from where it is predicted, a part of the way to a goal. XPBD starts from velocities, not from there. */
static inline void plii_body_pull_predicted(pli_body* body, int node, pli_vec3 goal, float share) {
    const pli_vec3 from = plii_xyz(body->positions[node]), to = pli_vec3_lerp(from, goal, share);
    plii_set_xyz(&body->positions[node], to);
    if (!body->solver_class->has_substeps) { return; }
    plii_add_xyz(&body->velocities[node], pli_vec3_scale(pli_vec3_sub(to, from), body->step.inverse_dt));
}
/* To be looked at in its next step. */
static inline void plii_body_was_put(pli_body* body) {
    body->overlap_steps = 2; /* the step itself takes one */
}
/* True when all nodes are where nodes may be. */
bool plii_body_update_bounds(pli_body* body);
pli_bounds plii_body_bounds_of(const pli_body* body, const pli_vec4* records);
/* The mean motion of the nodes in the step, and the bounds of their positions; returns how much motions differ from
   that mean, m. */
float plii_body_measure_motion(const pli_body* body, pli_vec3* mean, pli_bounds* bounds);
/* Of a face as it is now, for trees. */
pli_bounds plii_body_face_box(int face, const void* body);
static inline pli_status plii_check_margin(pli_context* context, float margin, const char* function) {
    return plii_check_between(context, margin, 0.0f, PLI_MAX_COORDINATE, "the collision margin", function);
}
/* True when no node is faster than nodes may be. */
bool plii_body_is_slow(const pli_body* body);
/* The first node that is too far out, too fast or not finite, or PLI_NULL_INDEX. */
int plii_body_find_lost_node(const pli_body* body);
static inline float plii_link_stiffness(const pli_body* body, int link) {
    const int material = body->link_tags != NULL ? body->link_tags[link] & (PLII_LINK_TAG_BENDING - 1) : 0;
    return body->materials[material].linear_stiffness;
}
/* It resists bending only, and keeps no distance. */
static inline bool plii_link_is_bending(const pli_body* body, int link) {
    return body->link_tags != NULL && (body->link_tags[link] & PLII_LINK_TAG_BENDING) != 0;
}
/* How much longer than at rest it is: 0.1 by a tenth; negative where it is shorter, 0 without a length. */
float plii_body_stretch(const pli_body* body, int link);
/* (inverse mass a + inverse mass b) / stiffness */
static inline float plii_link_mass_term(const pli_body* body, int link) {
    const int* nodes = body->links[link].nodes;
    return (body->positions[nodes[0]].w + body->positions[nodes[1]].w) / plii_link_stiffness(body, link);
}
/* Inverse of the mass that some nodes show at a point, 1/kg; `pinned`: what counts for nodes that are. */
static inline float plii_point_weight(const pli_vec4* nodes, int count, const int* indices, const float* weights,
                                      float pinned) {
    float sum = 0.0f;
    for (int k = 0; k < count; ++k) {
        const float inverse_mass = nodes[indices[k]].w;
        sum += weights[k] * weights[k] * (inverse_mass > 0.0f ? inverse_mass : pinned);
    }
    return sum;
}
/* If pinned ones were as light as the lightest of the others. Where the point moves by what this tells, no node goes
   much farther than the point would; without it, a node that bears a thousandth of it beside pinned ones goes a
   thousand times as far. `nodes`: w = inverse mass. */
static inline float plii_point_weight_unpinned(const pli_vec4* nodes, int count, const int* indices,
                                               const float* weights) {
    float lightest = 0.0f;
    for (int k = 0; k < count; ++k) {
        lightest = plii_max(lightest, nodes[indices[k]].w);
    }
    return plii_point_weight(nodes, count, indices, weights, lightest);
}
/* What follows from positions, after they were set. */
void plii_body_refresh(pli_body* body);
void plii_body_refresh_in_step(pli_body* body); /* the thread is in a walk */

/* Signed volume of the closed surface, relative to node 0, in Bullet's order of summation (getVolume). */
float plii_body_volume(const pli_body* body);
/* Share of its volume (of that at rest where it is conserved) by which pressures may change a free body in a step. From
   four on each step would overshoot more than the one before; a body that was crushed shall not burst. */
#define PLII_MAX_VOLUME_CHANGE 0.25f

/* Bullet's: what every body starts with. */
extern const plii_solver_class plii_position_solver;
/* By `position_iterations`. */
plii_solver_pace plii_solver_iterations(const pli_body* body);
/* POSITION, and COUPLE. */
void plii_solver_sweep(pli_body* body);
void plii_solver_couple(pli_body* body);
/* How many more a body has after its iterations, if it touches others: what these leave of the contacts between soft
   bodies makes piles tremble. With one or two nothing comes to rest anyway. */
static inline int plii_body_last_couples(const pli_body* body) {
    return body->island != NULL && body->solver.position_iterations > 2 ? body->solver_class->last_couples : 0;
}
/* Of one in which the world goes on by `dt`. */
void plii_solver_set_step(pli_body* body, float dt);

/* PLI_OK when an idle body may start or stop to be stepped by `solver_class`: not from a third solver. */
pli_status plii_solver_check_change(const pli_body* body, const plii_solver_class* solver_class, const char* function);

/* Bounds of the nodes. False when one is beyond the largest coordinate: then the body is put back and frozen. */
bool plii_solver_update_bounds(pli_body* body);
/* The same for velocities, at the end of a step; where they follow from positions in bounds nothing is looked at. */
bool plii_solver_check_velocities(pli_body* body);
/* Puts all nodes back to the start of the step, at rest. */
void plii_solver_set_start(pli_body* body);
/* At the end of a prediction: the same, of the whole motion where a feature looks at it. */
void plii_solver_update_predicted_bounds(pli_body* body);

bool plii_body_ignores_rigid(const pli_body* body, const pli_rigid* rigid);
void plii_body_stop_ignoring(pli_body* body, const pli_rigid* rigid);

static inline bool plii_body_is_stopped(const pli_body* body) {
    return body->is_frozen || body->is_asleep;
}
/* Not stepped. */
static inline bool plii_body_is_idle(const pli_body* body) {
    return plii_body_is_stopped(body) || body->interval.is_waiting;
}
/* Wakes what is asleep. */
static inline void plii_body_note_change(pli_body* body) {
    body->is_woken = true;
    body->is_resting = body->has_crosses = false;
}

/* PLI_OK, or the error of a null or wrong handle; context messages name `function`. */
static inline pli_status plii_check_body(const pli_body* body, const char* function) {
    return plii_check_handle(body, PLII_HANDLE_BODY, NULL, NULL, function);
}
/* The same for a call that changes something, which must not come from a callback ... */
pli_status plii_check_body_change(const pli_body* body, const char* function);
/* ... nor between predict and solve. */
pli_status plii_check_body_idle(const pli_body* body, const char* function);
/* For the end of such a call: a body that it has changed wakes. Returns `status`. */
static inline pli_status plii_body_changed(pli_body* body, pli_status status) {
    if (status == PLI_OK) { plii_body_note_change(body); }
    return status;
}
pli_status plii_check_node(const pli_body* body, int node, const char* function);
/* As plii_check_between, of a value that is named by its index too: "position of node 3". */
pli_status plii_body_check_between(const pli_body* body, const char* what, int index, float value, float low,
                                   float high, const char* function);
/* PLI_OK, or the error of a body without faces, for something that needs them: "pressure acts on faces". */
pli_status plii_check_faces(const pli_body* body, const char* need, const char* function);

/* For contacts of how many nodes there is room ahead: of large bodies most nodes are far from everything. */
static inline int plii_body_contact_bound(const pli_body* body) {
    const int most = 1024;
    return body->node_count < most ? body->node_count : most;
}
/* Bytes from `positions` to the end of `velocities`; each array begins on a line of the cache. */
static inline size_t plii_body_node_block_size(const pli_body* body) {
    const size_t size = (size_t)body->node_count * sizeof(pli_vec4);
    return 3 * ((size + PLII_ALIGNMENT - 1) / PLII_ALIGNMENT * PLII_ALIGNMENT);
}

/* Nodes and links by the counts, which are set. False when out of memory; what there is then is to be released. */
bool plii_body_allocate_arrays(pli_body* body, bool has_tags);
/* With the topology. */
void plii_body_release_arrays(pli_body* body);
/* As the mesh and the definition tell; without them (NULL) nothing is enabled, not even links, and arrays are zeroed.
   Takes the topology over, which is NULL for lack of memory. NULL when out of memory. */
pli_body* plii_body_make(pli_world* world, int node_count, int link_count, int material_count, bool has_tags,
                         plii_topology* topology, const pli_mesh* mesh, const pli_body_def* def);
