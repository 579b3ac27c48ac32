#pragma once

/* What the parts of the cluster contacts share: cluster_contacts.c is the feature, cluster_contacts_rigid.c and
   cluster_contacts_body.c look for pairs, cluster_distance.c measures them, cluster_contacts_pair.c knows them from
   step to step and makes their contacts, cluster_contact_batches.c solves these. */

#include "cluster/joint_end.h"
#include "geometry/bvh.h"
#include "geometry/pair_cache.h"

/* In reference mode 1. */
#define PLII_CLUSTER_CONTACTS_PER_PAIR 4

typedef struct plii_cluster_contact_as_reference {
    float friction;   /* the fraction of the sliding velocity removed, 1 when it sticks */
    float erp, split; /* Bullet: m_erp, m_split */
    pli_vec3 drift, split_drift;
    pli_mat3 impulse_matrix;
} plii_cluster_contact_as_reference;

typedef struct plii_cluster_contact {
    pli_cluster_contact info;
    plii_joint_target targets[2];
    pli_vec3 arms[2]; /* from each side's centre to where impulses act */
    pli_vec3 normal;
    bool is_self, reference_mode;
    float other_speed; /* m/s, of side 1 along the normal, as far as the depth has it; not in reference mode */
    union {
        plii_cluster_contact_as_reference reference;
        /* x: speed that takes the depth back in a step, m/s; y: hardness; z: fraction of the correction that is a
           displacement; w: Coulomb's friction. */
        pli_vec4 terms;
    } as;
} plii_cluster_contact;

/* Contacts prepared for the iterations of a step, four pairs side by side that share nothing movable. */

/* A contact of each pair of a batch; lanes without one have no mass. Directions: the normal to side 0, and tangents. */
typedef struct plii_contact_block {
    plii_vec3x4 directions[3];
    plii_vec3x4 arms[2];         /* of the sides */
    plii_vec3x4 rotations[2][3]; /* and their angular velocity per impulse along the directions */
    plii_float4 masses[3];       /* that impulses along the directions meet, kg; 0 where nothing can move */
    plii_float4 impulses[3];     /* along the directions so far, N s */
    plii_float4 wanted_speeds;   /* along the normal, m/s */
    plii_float4 drifts;          /* displacing impulse along the normal, at the end of the step, N s */
} plii_contact_block;

/* One side of four pairs. */
typedef struct plii_batch_side {
    pli_vec4* linear[PLII_LANES]; /* the velocities that are read and changed */
    pli_vec4* angular[PLII_LANES];
    plii_cluster* clusters[PLII_LANES]; /* NULL where there is none */
    plii_float4 splits;
} plii_batch_side;

typedef struct plii_contact_batch {
    const plii_cluster_contact* contacts[PLII_LANES]; /* the first of each pair */
    int counts[PLII_LANES];                           /* of contacts; 0 for a lane that is free */
    int lane_count;
    int block_count, first_block;
    plii_batch_side sides[2];
    plii_vec3x4 inverse_masses[2]; /* along the axes, of side 1 negative, as the impulse on it is */
    plii_float4 frictions;         /* Coulomb's coefficient */
    plii_float4 limits;            /* of the impulse along the normal, N s */
    bool is_split;                 /* some rigid body is in more than one lane */
    plii_float4 shares;            /* of the change of velocity of side 1, that its body gets */
} plii_contact_batch;

/* A rigid body while contacts are solved. */
typedef struct plii_batch_rigid {
    pli_rigid* rigid; /* NULL: not met in this step */
    pli_vec4 linear_velocity, angular_velocity;
    uint64_t open_batches; /* as in plii_cluster */
} plii_batch_rigid;

typedef struct plii_contact_batches {
    plii_contact_batch* items;
    int count, capacity;
    plii_contact_block* blocks;
    int block_capacity;
    plii_batch_rigid* rigids; /* [rigid_count] by their index in the world */
    int rigid_count, rigid_capacity;
    pli_vec4 still[2];                     /* velocities of what does not move */
    bool keeps_momentum;                   /* some clusters do */
    int open[64];                          /* the batches with room for pairs, by the bits of open_batches */
    uint64_t open_batches, open_counts[8]; /* bits in use, and those of batches with so many blocks */
} plii_contact_batches;

/* Contacts are added pair by pair: [count] of the same two sides, not in reference mode, which stay where they are
   until the step ends. False when out of memory: contacts that were not added, or prepared, are not solved. */
bool plii_contact_batches_start(pli_context* context, plii_contact_batches* batches, int rigid_count);
bool plii_contact_batches_add(pli_context* context, plii_contact_batches* batches, const plii_cluster_contact* contacts,
                              int count);
void plii_contact_batches_prepare(pli_context* context, plii_contact_batches* batches);
/* One iteration. */
void plii_contact_batches_solve(plii_contact_batches* batches);
/* Hands impulses and displacements on to the clusters. */
void plii_contact_batches_finish(plii_contact_batches* batches);
void plii_contact_batches_reserve(pli_context* context, plii_contact_batches* batches, int contacts);

typedef struct plii_contact_terms {
    float margin; /* of both sides, `radius` included */
    float radius; /* of the other side's shape round its core */
    float friction, hardness, split;
    float inverse_dt;    /* 1/s, of the step in which both sides move; bodies have steps of their own */
    plii_twist velocity; /* that has brought the other side to where it is measured, where it is a rigid body */
} plii_contact_terms;

#define PLII_MANIFOLD_POINTS 7

typedef struct plii_manifold_point {
    pli_vec3 on_a, on_b; /* m, each in the frame of its side */
    pli_vec3 normal;     /* from b to a, in the frame of b */
    float distance;      /* m, along the normal */
} plii_manifold_point;

/* The contacts of a pair as they were measured, to be followed while the sides hardly move. */
typedef struct plii_manifold {
    int count, age;             /* points; steps since they were measured */
    pli_mat3 relative_rotation; /* of a in the frame of b */
    const void* key;            /* what else must be the same */
    float margin;
    plii_manifold_point points[PLII_MANIFOLD_POINTS];
} plii_manifold;
typedef struct plii_manifolds {
    plii_manifold* items;
    int count, capacity;
} plii_manifolds;

/* Of a node to a rigid shape. */
typedef struct plii_nearest_surface_point {
    float distance;  /* m; INFINITY when it is not near */
    pli_vec3 normal; /* world */
} plii_nearest_surface_point;

typedef struct plii_cluster_contacts {
    pli_cluster_contacts_def def;
    plii_cluster_contact* contacts;
    int count, capacity;
    bool leads;                   /* solves the contacts of all bodies, but for those in reference mode */
    plii_contact_batches batches; /* of these */
    plii_pair_cache memory;
    /* Of the pairs that are followed in this step, and were in the last one: each at `slot` - 1 of its record. */
    plii_manifolds manifolds, manifolds_before;
    plii_bvh4 tree; /* over the clusters' bounds */
    /* Of the rigid body and the shape that are met: where the step takes them; in reference mode its start. */
    pli_transform rigid_pose, shape_pose;
    plii_twist rigid_velocity; /* which takes them there */
    bool has_tree;             /* of this step */
    pli_bounds* boxes;
    int* candidates;
    int box_capacity, candidate_capacity, candidate_count;
    plii_nearest_surface_point* surface; /* [surface_capacity] of the nodes, at the shape that is met */
    int surface_capacity;
    int clusters_with_neighbours; /* so many have been looked at */
    int (*neighbour_pairs)[2];    /* clusters of this body that never meet, the smaller index first */
    int neighbour_pair_count, neighbour_pair_capacity;
    plii_key_table neighbours; /* of these pairs; empty after they were restored */
} plii_cluster_contacts;

/* Of contacts in reference mode. */
void plii_cluster_contact_prepare(plii_cluster_contact* contact, float dt, int iterations);
void plii_cluster_contact_solve(plii_cluster_contact* contact);
void plii_cluster_contact_finish(plii_cluster_contact* contact);

/* The convex hull of a cluster's nodes, in world axes from `origin`. */
typedef struct plii_cluster_hull {
    const pli_body* body;
    const plii_cluster* cluster;
    const plii_cluster_member* members; /* of it */
    pli_vec3 origin;
} plii_cluster_hull;

plii_cluster_hull plii_cluster_hull_of(const pli_body* body, int cluster, pli_vec3 origin);
plii_convex plii_cluster_hull_convex(const plii_cluster_hull* hull);
/* The point is inside, or nearer than `margin`. */
bool plii_cluster_hull_is_near(pli_vec3 point, const plii_cluster_hull* hull, float margin);

#define PLII_MEASURED_NODES 64

/* Members of a cluster at a rigid shape. */
typedef struct plii_measured_nodes {
    int count;
    float distances[PLII_MEASURED_NODES];  /* m, to the surface, as the shape's function tells */
    pli_vec3 normals[PLII_MEASURED_NODES]; /* in the frame of the shape */
} plii_measured_nodes;

/* Members from `first` on, as many as there is room for. */
void plii_cluster_contacts_measure_nodes(const pli_body* body, const plii_cluster_contacts* state,
                                         const pli_cluster_contact* info, int first, plii_measured_nodes* nodes);

/* `cache` may be NULL. Fill witnesses, normal and distance of the pair that `info` names; false when farther apart than
   `max_distance` or when there is no answer. Ask def.distance when it is set. `nodes` becomes what had to be measured
   of them, from the first on; `count` is 0 before, and where nothing was. */
bool plii_cluster_contacts_measure_rigid(pli_body* body, plii_cluster_contacts* state, plii_convex_cache* cache,
                                         float max_distance, pli_cluster_contact* info, plii_measured_nodes* nodes);
bool plii_cluster_contacts_measure_cluster(pli_body* body, plii_cluster_contacts* state, plii_convex_cache* cache,
                                           float max_distance, pli_cluster_contact* info);

/* The farthest point of the core of a shape along a unit direction; world. */
pli_vec3 plii_cluster_contacts_rigid_point(const pli_shape* shape, pli_transform pose, pli_vec3 direction);
/* Overlapping, or apart by less than `margin`. */
bool plii_cluster_contacts_are_near(const plii_convex* a, const plii_convex* b, float margin);

/* For a search among the clusters of the body. False when out of memory. */
bool plii_cluster_contacts_reserve_search(pli_body* body, plii_cluster_contacts* state);
/* What the step before knew of pairs becomes what is known; that of pairs it did not meet is dropped. */
void plii_cluster_contacts_begin_step(pli_body* body, void* state);
void plii_cluster_contacts_clear(pli_body* body, void* data);
void plii_cluster_contacts_collide_rigid(pli_body* body, void* state, pli_rigid* rigid);
void plii_cluster_contacts_prepare_pair(pli_body* body, void* state, pli_body* other, void* other_state);
void plii_cluster_contacts_collide_body(pli_body* body, void* state, pli_body* other, void* other_state);
void plii_cluster_contacts_collide_self(pli_body* body, plii_cluster_contacts* state);
