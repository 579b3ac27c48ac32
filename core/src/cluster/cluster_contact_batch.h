#pragma once

/* Contacts prepared for the iterations of one step: those of four pairs that share nothing movable are solved side by
   side, and those of a pair one after the other. */

#include "cluster/joint_end.h"
#include "math/simd_float4.h"

enum { PLII_GROUP_LANES = 4 };

/* Of each lane, by components. */
typedef struct plii_group_vec3 {
    float x[PLII_GROUP_LANES], y[PLII_GROUP_LANES], z[PLII_GROUP_LANES];
} plii_group_vec3;

static inline plii_vec3x4 plii_group_vec3_load(const plii_group_vec3* v) {
    return (plii_vec3x4){plii_float4_load(v->x), plii_float4_load(v->y), plii_float4_load(v->z)};
}

/* Of each lane on side 0, then of each on side 1. */
typedef struct plii_group_sides3 {
    float x[2 * PLII_GROUP_LANES], y[2 * PLII_GROUP_LANES], z[2 * PLII_GROUP_LANES];
} plii_group_sides3;

/* One contact of each pair of a group; lanes without one have no mass. Directions are the normal, from side 1 to side
   0, and two tangents. */
typedef struct plii_contact_block {
    plii_group_vec3 directions[3];
    plii_group_sides3 arms;
    plii_group_sides3 rotations[3];        /* angular velocity per impulse along the directions */
    float masses[3][PLII_GROUP_LANES];     /* that impulses along the directions meet, kg; 0 where nothing can move */
    float impulses[3][PLII_GROUP_LANES];   /* along the directions so far, N s */
    float wanted_speeds[PLII_GROUP_LANES]; /* along the normal, m/s */
    float drifts[PLII_GROUP_LANES];        /* displacing impulse along the normal, at the end of the step, N s */
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
    plii_group_sides3 inverse_masses;  /* along the axes, of side 1 negative, as the impulse on it is */
    float frictions[PLII_GROUP_LANES]; /* Coulomb's coefficient */
    float limits[PLII_GROUP_LANES];    /* of the impulse along the normal, N s */
    bool is_split;                     /* some rigid body is in more than one lane */
    float shares[PLII_GROUP_LANES];    /* of the change of velocity of side 1, that its body gets */
} plii_contact_batch;

/* A rigid body while contacts are solved. */
typedef struct plii_group_rigid {
    pli_rigid* rigid; /* NULL: not met in this step */
    pli_vec4 linear_velocity, angular_velocity;
    uint64_t open_groups; /* as in plii_cluster */
} plii_group_rigid;

typedef struct plii_contact_kernel plii_contact_kernel;

typedef struct plii_contact_batches {
    const plii_contact_kernel* kernel; /* of the step in progress */
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

/* What groups of contacts do in a step, with the instructions of every processor of the target or with more, from
   cluster_contact_kernel.inl; all with the same results. */
struct plii_contact_kernel {
    void (*prepare)(plii_contact_batches* groups, const plii_step* step); /* fills the blocks */
    void (*solve)(plii_contact_batches* groups);  /* one iteration, on the clusters and on groups->rigids */
    void (*finish)(plii_contact_batches* groups); /* adds to the impulses of the clusters */
};

extern const plii_contact_kernel plii_contact_kernel_base, plii_contact_kernel_avx2;

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
