#pragma once

/* What the modules of self-collision share. To solvers without substeps the step is one. */

#include "body/substep.h"
#include "pliant/self_collision.h"

/* From node a to node b; small differences are not lost in large positions. */
static inline pli_vec3 plii_self_difference(const pli_body* body, const plii_substep* substep, int a, int b) {
    const pli_vec4* displacements = substep->displacements;
    const pli_vec3 difference = pli_vec3_sub(plii_xyz(displacements[b]), plii_xyz(displacements[a]));
    if (substep->is_absolute) { return difference; }
    return pli_vec3_add(pli_vec3_sub(plii_xyz(body->positions[b]), plii_xyz(body->positions[a])), difference);
}
/* From `from` to the start, or (NULL) from there on; and the mean of all nodes, which brings no two nearer. */
static inline pli_vec3 plii_self_motion_from(const pli_body* body, const plii_substep* substep, const pli_vec3* from,
                                             int node) {
    return from != NULL ? pli_vec3_sub(plii_substep_start(body, substep, node), from[node])
                        : plii_substep_motion(substep, node);
}
pli_vec3 plii_self_common_motion(const pli_body* body, const plii_substep* substep, const pli_vec3* from);
/* Cuts motions beside the common one to at most `longest`, m, but for pinned nodes; velocities, where given, follow.
   The common motion of a free body that is to keep momentum is that of a rigid body, which then gets what others lose.
   Returns how many were longer. */
int plii_self_limit_motions(const pli_body* body, const plii_substep* substep, float longest, pli_vec4* velocities,
                            bool keeps_momentum);

/* Lists of a plii_spatial_hash and a plii_node_pairs of a state: nothing in them is needed by the next step. */
#define PLII_SPATIAL_HASH_LISTS(type, hash, near)                                                                      \
    {PLII_LIST_OF(type, hash.starts, hash.start_capacity), .is_kept = true, .snapshot = PLII_LEFT},                    \
        {PLII_LIST_OF(type, hash.cells, hash.cell_capacity), .is_kept = true, .snapshot = PLII_LEFT},                  \
        {PLII_LIST_OF(type, hash.nodes, hash.node_capacity), .is_kept = true, .snapshot = PLII_LEFT},                  \
        {PLII_LIST_OF(type, hash.columns, hash.column_capacity), .is_kept = true, .snapshot = PLII_LEFT},              \
        {PLII_LIST_OF(type, hash.components, hash.component_capacity), .is_kept = true, .snapshot = PLII_LEFT}, {      \
        PLII_LIST_OF(type, near.pairs, near.capacity), .is_kept = true, .snapshot = PLII_LEFT                          \
    }

/* A unit vector that depends on the indices only, for points that coincide. */
pli_vec3 plii_self_direction(int a, int b);

/* Positions at rest of new nodes, after those of old ones. */
void plii_self_carry_rest(const pli_body* body, const plii_topology_change* change, pli_vec3* rest);
