#pragma once

/* Self-collision as solvers see it: solvers differ in where they keep nodes, and in how often a step solves. */

#include "body/substep.h"
#include "pliant/self_collision.h"

/* A node is at base + offset. */
typedef struct plii_self_nodes {
    const pli_vec4* bases;  /* [node_count] or NULL: zero */
    pli_vec4* offsets;      /* [node_count] w = inverse mass */
    const pli_vec4* starts; /* [node_count] offsets at the start of the step or substep */
} plii_self_nodes;

static inline pli_vec3 plii_self_position(const plii_self_nodes* nodes, int node) {
    const pli_vec3 offset = plii_xyz(nodes->offsets[node]);
    return nodes->bases != NULL ? pli_vec3_add(plii_xyz(nodes->bases[node]), offset) : offset;
}
static inline pli_vec3 plii_self_start(const plii_self_nodes* nodes, int node) {
    const pli_vec3 offset = plii_xyz(nodes->starts[node]);
    return nodes->bases != NULL ? pli_vec3_add(plii_xyz(nodes->bases[node]), offset) : offset;
}
/* From node a to node b; small differences are not lost in large positions. */
static inline pli_vec3 plii_self_difference(const plii_self_nodes* nodes, int a, int b) {
    const pli_vec3 offset = pli_vec3_sub(plii_xyz(nodes->offsets[b]), plii_xyz(nodes->offsets[a]));
    if (nodes->bases == NULL) { return offset; }
    return pli_vec3_add(pli_vec3_sub(plii_xyz(nodes->bases[b]), plii_xyz(nodes->bases[a])), offset);
}
static inline pli_vec3 plii_self_motion(const plii_self_nodes* nodes, int node) {
    return pli_vec3_sub(plii_xyz(nodes->offsets[node]), plii_xyz(nodes->starts[node]));
}
/* From `from` to the start, or (NULL) from there on; and the mean of all nodes, which brings no two nearer. */
static inline pli_vec3 plii_self_motion_from(const plii_self_nodes* nodes, const pli_vec3* from, int node) {
    return from != NULL ? pli_vec3_sub(plii_self_start(nodes, node), from[node]) : plii_self_motion(nodes, node);
}
pli_vec3 plii_self_common_motion(const pli_body* body, const plii_self_nodes* nodes, const pli_vec3* from);
/* Cuts motions beside the common one to at most `longest`, m, but for pinned nodes; velocities, where given, follow.
   The common motion of a free body that is to keep momentum is that of a rigid body, which then gets what others lose.
   Returns how many were longer. */
int plii_self_limit_motions(const pli_body* body, const plii_self_nodes* nodes, float longest, pli_vec4* velocities,
                            bool keeps_momentum);
static inline void plii_self_move(const plii_self_nodes* nodes, int node, pli_vec3 direction, float length) {
    plii_add_xyz(&nodes->offsets[node], pli_vec3_scale(direction, length));
}
/* As the solvers without substeps see it. */
static inline plii_self_nodes plii_self_nodes_of_body(pli_body* body, const pli_vec4* starts) {
    return (plii_self_nodes){NULL, body->positions, starts};
}
/* And as XPBD does in a substep. */
static inline plii_self_nodes plii_self_nodes_of_substep(const pli_body* body, const plii_substep* substep) {
    return (plii_self_nodes){body->positions, substep->displacements, substep->start_displacements};
}

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
