#pragma once

/* Contacts prepared for the iterations of one step: those of four pairs that share nothing movable are solved side by
   side, and those of a pair one after the other. */

#include "cluster/joint_end.h"
#include "math/simd_float4.h"

enum { PLII_GROUP_LANES = 4 };

/* One contact of each pair of a group; lanes without one have no mass. Directions are the normal, from side 1 to side
   0, and two tangents. */
typedef struct plii_contact_block {
    plii_vec3x4 directions[3];
    plii_vec3x4 arms[2];         /* of the sides */
    plii_vec3x4 rotations[2][3]; /* and their angular velocity per impulse along the directions */
    plii_float4 masses[3];       /* that impulses along the directions meet, kg; 0 where nothing can move */
    plii_float4 impulses[3];     /* along the directions so far, N s */
    plii_float4 wanted_speeds;   /* along the normal, m/s */
    plii_float4 drifts;          /* displacing impulse along the normal, at the end of the step, N s */
} plii_contact_block;

typedef struct plii_cluster_contact plii_cluster_contact;

/* One side of four pairs. */
typedef struct plii_group_side {
    pli_vec4* linear[PLII_GROUP_LANES]; /* the velocities that are read and changed */
    pli_vec4* angular[PLII_GROUP_LANES];
    plii_cluster* clusters[PLII_GROUP_LANES]; /* NULL where there is none */
} plii_group_side;

typedef struct plii_contact_batch {
    const plii_cluster_contact* contacts[PLII_GROUP_LANES]; /* the first of each pair */
    int counts[PLII_GROUP_LANES];                           /* of contacts; 0 for a lane that is free */
    int lane_count;
    int block_count, first_block;
    plii_group_side sides[2];
    plii_vec3x4 inverse_masses[2]; /* along the axes, of side 1 negative, as the impulse on it is */
    plii_float4 frictions;         /* Coulomb's coefficient */
    plii_float4 limits;            /* of the impulse along the normal, N s */
    bool is_split;                 /* some rigid body is in more than one lane */
    plii_float4 shares;            /* of the change of velocity of side 1, that its body gets */
} plii_contact_batch;

/* A rigid body while contacts are solved. */
typedef struct plii_group_rigid {
    pli_rigid* rigid; /* NULL: not met in this step */
    pli_vec4 linear_velocity, angular_velocity;
    uint64_t open_groups; /* as in plii_cluster */
} plii_group_rigid;

typedef struct plii_contact_batches {
    plii_contact_batch* groups;
    int count, capacity;
    plii_contact_block* blocks;
    int block_count, block_capacity;
    plii_group_rigid* rigids; /* [rigid_count] by their index in the world */
    int rigid_count, rigid_capacity;
    pli_vec4 still[2];                    /* velocities of what does not move */
    int open[64];                         /* the groups with room for pairs, by the bits of open_groups */
    uint64_t open_groups, open_counts[8]; /* bits in use, and those of groups with so many blocks */
} plii_contact_batches;

/* Parts of the below (cluster_contact_solve.c): fill the blocks; one iteration, on the clusters and on rigids. */
void plii_contact_groups_prepare(plii_contact_batches* groups, const plii_step* step);
void plii_contact_groups_solve(plii_contact_batches* groups);

/* Contacts are added pair by pair: [count] of the same two sides, not in reference mode, which stay where they are
   until the step ends. All are false when out of memory: contacts that were not added, or prepared, are not solved. */
bool plii_contact_batches_start(pli_context* context, plii_contact_batches* groups, int rigid_count);
bool plii_contact_batches_add(pli_context* context, plii_contact_batches* groups, const plii_cluster_contact* contacts,
                              int count);
bool plii_contact_batches_prepare(pli_context* context, plii_contact_batches* groups, const plii_step* step);
/* One iteration. */
void plii_contact_batches_solve(plii_contact_batches* groups);
/* Hands impulses and displacements on to the clusters. */
void plii_contact_batches_finish(plii_contact_batches* groups);
bool plii_contact_batches_reserve(pli_context* context, plii_contact_batches* groups, int contacts);
