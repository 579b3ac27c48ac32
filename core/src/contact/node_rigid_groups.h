#pragma once

/* Contacts with rigid bodies that nothing moves, eight at a time: planes, as they change their own node only. */

#include "body/substep.h"
#include "math/simd_float8.h"

enum { PLII_RIGID_GROUP_SIZE = 8 };

/* Of eight nodes, by components: all x, all y, all z. Contact k is in the lane of record k (plii_simd_record). A group
   that is not full repeats its first contact: both get the same results. */
typedef struct plii_rigid_group {
    float normal[3 * PLII_RIGID_GROUP_SIZE];
    float offset[PLII_RIGID_GROUP_SIZE];            /* m: gap = dot(normal, node) + offset, at the start of the step */
    float height[PLII_RIGID_GROUP_SIZE];            /* m: the gap at the positions that displacements count from */
    float friction[PLII_RIGID_GROUP_SIZE];          /* Coulomb's coefficient */
    float squeeze[PLII_RIGID_GROUP_SIZE];           /* m in the step: see node_rigid_squeeze.c */
    uint32_t scaled_indices[PLII_RIGID_GROUP_SIZE]; /* of the nodes, see plii_scaled_index */
    int surface;                                    /* index of what moves, PLI_NULL_INDEX: all stand still */
    /* What it has moved its nodes by in a substep, m, from sweep to sweep: along the normal, without what recovers. */
    float pushed[PLII_RIGID_GROUP_SIZE], rubbed[3 * PLII_RIGID_GROUP_SIZE];
} plii_rigid_group;

typedef struct plii_rigid_surface {
    float velocity[3 * PLII_RIGID_GROUP_SIZE]; /* m/s, where the contacts are */
} plii_rigid_surface;

typedef struct plii_rigid_groups {
    plii_rigid_group* groups;
    plii_rigid_surface* surfaces;
    int count, capacity, surface_count, surface_capacity;
    int filled; /* contacts of the last group, while they are added */
} plii_rigid_groups;

/* One sweep of a substep. */
typedef struct plii_rigid_groups_pass {
    const plii_substep* substep;
    const pli_vec4* positions;
    float share;      /* of the step */
    float alpha;      /* compliance / dt^2, 1/kg */
    float recovery;   /* m, in a substep at most */
    bool leaves_sums; /* somebody asks for them */
} plii_rigid_groups_pass;

/* One sweep with the instructions of every processor of the target or with more; all with the same results. */
typedef void plii_rigid_groups_sweep(plii_rigid_groups* groups, const plii_rigid_groups_pass* pass);
plii_rigid_groups_sweep plii_rigid_groups_sweep_base, plii_rigid_groups_sweep_avx2;
