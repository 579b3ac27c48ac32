#ifndef PLIANT_SELF_COLLISION_H
#define PLIANT_SELF_COLLISION_H

/// Collision of a body with itself, in three modules that are enabled one by one and work with each solver, whichever
/// comes first:
///
/// - self-collision of nodes, found by hashing: for cloth whose nodes lie about a thickness apart;
/// - the same by two shifted grids, after the step, in the way of Kang: cheaper, and it misses pairs;
/// - self-collision of faces (nodes with faces, edges with edges): for coarse meshes.
///
/// docs/self_collision.md has the rules and what they cost.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---------------------------------------------------------------------------------------------- nodes, hashed

/// How nodes of a body keep apart.
typedef struct pli_self_collision_def {
    /// m, > 0 to PLI_MAX_COORDINATE, default 0.01: distance that nodes keep, or their distance at rest where that is
    /// smaller. Nodes alone are impenetrable for each other when it is not much smaller than the distance of linked
    /// nodes.
    float thickness;
    /// [0, 1], default 0.1: share of their relative motion that two nodes in contact lose in each substep, and under
    /// solvers without substeps each time they are parted.
    float friction;
    /// 0 to PLI_MAX_FACTOR, default 0.2: no node moves by more than this times the thickness in a step (or substep)
    /// beside the mean motion of all nodes, so none gets through a layer unseen; 0: no limit. The body as a whole falls
    /// and flies freely, and turns too where no node is pinned, but what swings or folds is slow: at 60 steps a second
    /// and 1 cm 0.12 m/s beside that, with 10 substeps 1.2 m/s. Without a limit a node that moves by more than half the
    /// thickness in a step may get through.
    float speed_limit_ratio;
    uint32_t cookie; ///< set by the default function
} pli_self_collision_def;

/// Defaults of the fields.
PLI_API pli_self_collision_def pli_self_collision_def_default(void);

/// Keeps nodes of a body apart that no link joins, other than those that only resist bending. Enable, or change when
/// enabled. Distances at rest are those of the present shape when first enabled; nodes that a cut adds lie where it
/// parts the shape at rest. Source: Teschner and others, "Optimized Spatial Hashing for Collision Detection of
/// Deformable Objects"
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 72 B per node, about 50 B per node for the table, 16 B per link, 8 B per pair in reach and as much per pair
/// under XPBD.
PLI_API pli_status pli_body_enable_self_collision(pli_body* body, const pli_self_collision_def* def);

/// Lets nodes pass again. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_self_collision(pli_body* body);

/// How the last step went.
typedef struct pli_self_collision_report {
    int pairs;         ///< kept for the step: closer than what they could come to touch in it
    int contacts;      ///< pairs that the last iteration or substep parted
    int searches;      ///< 0 while pairs found before serve, 1, and once more when too many nodes left the reach of it
    int limited_nodes; ///< slowed by the speed limit, in each substep
    bool is_truncated; ///< a node with 512 neighbours, or no memory: some pairs were left out
} pli_self_collision_report;

/// Report of the last step, all zero before the first one and when not enabled.
PLI_API pli_self_collision_report pli_body_get_self_collision_report(const pli_body* body);

// ------------------------------------------------------------------------------------- nodes, two shifted grids

/// How nodes of a body keep apart, by grids.
typedef struct pli_self_grids_def {
    float distance; ///< m, > 0 to PLI_MAX_COORDINATE, default 0.01: smallest allowed distance, and the size of cells
    /// (0, 1], default 1/2: how far from their middle both nodes are put, over `distance`. With 1/2 they end up
    /// `distance` apart; 1 is the rule as published, which puts them twice as far.
    float separation;
    uint32_t cookie; ///< set by the default function
} pli_self_grids_def;

/// Defaults of the fields.
PLI_API pli_self_grids_def pli_self_grids_def_default(void);

/// After each step, whatever the solver, unlinked nodes in one cell of either grid that are nearer than `distance` are
/// put apart, and what brings them nearer is taken from their velocities. Shapes at rest with unlinked nodes nearer
/// than that swell. Enable, or change when enabled. Source: Kang, "Efficient Methods for Cloth Animation and Collision
/// Handling"
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 12 B per node, about 50 B per node for the table, 16 B per link.
PLI_API pli_status pli_body_enable_self_grids(pli_body* body, const pli_self_grids_def* def);

/// Lets nodes pass again. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_self_grids(pli_body* body);

/// How the last step went.
typedef struct pli_self_grids_report {
    int pairs;         ///< seen by the first grid or, failing that, by the second
    bool is_truncated; ///< as in pli_self_collision_report
} pli_self_grids_report;

/// Report of the last step, all zero before the first one and when not enabled.
PLI_API pli_self_grids_report pli_body_get_self_grids_report(const pli_body* body);

// ----------------------------------------------------------------------------------------------------- faces

/// How faces of a body keep apart.
typedef struct pli_self_faces_def {
    float thickness; ///< m, > 0 to PLI_MAX_COORDINATE, default 0.01: distance to keep, or the one at rest where that is
                     ///< smaller
    float friction;  ///< [0, 1], default 0.1: share of the sliding that a contact takes away each time it is solved
    /// m, 0 to PLI_MAX_COORDINATE, default 0: the mean edge. How far a node moves in a step at most beside the mean
    /// motion of all nodes; the search reaches as far as they do move.
    float max_travel;
    uint32_t cookie; ///< set by the default function
} pli_self_faces_def;

/// Defaults of the fields.
PLI_API pli_self_faces_def pli_self_faces_def_default(void);

/// Nodes keep their distance from faces, and edges from edges. Motions that would take one through the other are cut
/// short at the end of the step, so a body that starts without crossings stays so under forces and contacts. Nodes that
/// the caller places, and cloth that is twisted tight by nodes that are pinned and moved, or anchored to what moves,
/// may still cross. What crosses at the start stays crossed. Enable, or change when enabled. Take a thickness well
/// below the length of edges: pairs that are nearer than that at rest are solved all the time.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_WRONG_STATE while stepping
/// Cost: 56 B per node, 24 B per face, 80 B per pair in reach.
PLI_API pli_status pli_body_enable_self_faces(pli_body* body, const pli_self_faces_def* def);

/// Lets faces pass again. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_self_faces(pli_body* body);

/// How the last step went.
typedef struct pli_self_faces_report {
    int pairs;         ///< of node and face or of two edges in reach
    int contacts;      ///< pairs that the last iteration or substep parted
    int shortened;     ///< times that a motion was cut short
    bool is_truncated; ///< no memory: some pairs were left out, crossings are possible
} pli_self_faces_report;

/// Report of the last step, all zero before the first one and when not enabled.
PLI_API pli_self_faces_report pli_body_get_self_faces_report(const pli_body* body);

/// Number of pairs of faces that cross each other now; faces with a common node do not count. n log n. Whatever is
/// enabled.
/// @return PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_count_crossings(const pli_body* body, int* count);

#ifdef __cplusplus
}
#endif
#endif
