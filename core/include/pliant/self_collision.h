#ifndef PLIANT_SELF_COLLISION_H
#define PLIANT_SELF_COLLISION_H

/// Collision of a body with itself, in three modules. They are enabled one by one, before or after a solver, and work
/// with each of them:
///
/// - self-collision of nodes, found by hashing: for cloth whose nodes lie about a thickness apart;
/// - the same by two shifted grids, after the step, as published by Kang: cheaper, but it misses pairs;
/// - self-collision of faces (nodes with faces, edges with edges): for coarse meshes.
///
/// docs/self_collision.md has the methods and their cost.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

// ---------------------------------------------------------------------------------------------- nodes, hashed

/// How nodes of a body keep apart.
typedef struct pli_self_collision_def {
    /// m, > 0 to PLI_MAX_COORDINATE, default 0.01: distance that nodes keep, or their distance at rest where that is
    /// smaller. If it is much smaller than the distance of linked nodes, nodes fit between others.
    float thickness;
    /// [0, 1], default 0.1: share of their relative motion that two nodes in contact lose in each substep, or, with
    /// solvers without substeps, each time they are separated.
    float friction;
    /// 0 to PLI_MAX_FACTOR, default 0.2; 0: no limit. No node moves by more than this times the thickness in a step (or
    /// substep) relative to the mean motion of all nodes, so that none gets through a layer unseen. The body as a whole
    /// falls and flies freely, and turns freely if no node is pinned. But folding and swinging are slowed down: with 1
    /// cm at 60 steps a second to 0.12 m/s, with 10 substeps to 1.2 m/s. Without a limit a node that moves by more than
    /// half the thickness in a step may get through.
    float speed_limit_ratio;
    uint32_t cookie; ///< set by the default function
} pli_self_collision_def;

/// Defaults of the fields.
PLI_API pli_self_collision_def pli_self_collision_def_default(void);

/// Keeps nodes of a body apart that are not joined by a link; bending links do not count. Called again, it changes the
/// settings. Distances at rest are those at the time when it was first enabled; nodes that a cut adds have their place
/// in that shape. Source: Teschner and others, "Optimized Spatial Hashing for Collision Detection of Deformable
/// Objects"
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 72 B per node, about 50 B per node for the table, 16 B per link, 24 B per pair in reach.
PLI_API pli_status pli_body_enable_self_collision(pli_body* body, const pli_self_collision_def* def);

/// Lets nodes pass again. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_self_collision(pli_body* body);

/// How the last step went.
typedef struct pli_self_collision_report {
    int pairs;         ///< kept for the step, because they could come to touch in it
    int contacts;      ///< pairs that the last iteration or substep separated
    int searches;      ///< 0 while earlier pairs serve, else 1, or more when too many nodes left its reach
    int limited_nodes; ///< slowed by the speed limit, counted in each substep
    bool is_truncated; ///< some pairs were left out: a node had 512 neighbours, or there was no memory
} pli_self_collision_report;

/// Report of the last step, all zero before the first one and when not enabled.
PLI_API pli_self_collision_report pli_body_get_self_collision_report(const pli_body* body);

// ------------------------------------------------------------------------------------- nodes, two shifted grids

/// How nodes of a body keep apart, by grids.
typedef struct pli_self_grids_def {
    float distance; ///< m, > 0 to PLI_MAX_COORDINATE, default 0.01: smallest allowed distance, and the size of cells
    /// (0, 1], default 1/2: how far from their middle both nodes are put, in units of `distance`. With 1/2 they end up
    /// `distance` apart; 1 is the published rule, which puts them twice as far.
    float separation;
    uint32_t cookie; ///< set by the default function
} pli_self_grids_def;

/// Defaults of the fields.
PLI_API pli_self_grids_def pli_self_grids_def_default(void);

/// Separates, after each step of any solver, unlinked nodes in one cell of either grid that are nearer than `distance`,
/// and removes their approaching velocity. Shapes whose unlinked nodes are nearer than that at rest swell. Called
/// again, it changes the settings. Source: Kang, "Efficient Methods for Cloth Animation and Collision Handling"
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 12 B per node, about 50 B per node for the table, 16 B per link.
PLI_API pli_status pli_body_enable_self_grids(pli_body* body, const pli_self_grids_def* def);

/// Lets nodes pass again. Does nothing when not enabled.
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
    /// m, 0 to PLI_MAX_COORDINATE: the most that a node moves in a step relative to the mean motion of all nodes.
    /// Default 0: the mean length of edges.
    float max_travel;
    uint32_t cookie; ///< set by the default function
} pli_self_faces_def;

/// Defaults of the fields.
PLI_API pli_self_faces_def pli_self_faces_def_default(void);

/// Keeps nodes away from faces, and edges from edges. Called again, it changes the settings. Motions that would take
/// one through the other are shortened at the end of the step, so a body that starts without crossings stays without
/// under forces and contacts. Crossings are still possible where the caller places nodes, and where moved or anchored
/// nodes twist cloth tight. What crosses at the start stays crossed. Choose a thickness well below the length of edges:
/// pairs that are nearer than that at rest are solved all the time.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_WRONG_STATE while stepping
/// Cost: 44 B per node, 24 B per face, 80 B per pair in reach.
PLI_API pli_status pli_body_enable_self_faces(pli_body* body, const pli_self_faces_def* def);

/// Lets faces pass again. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_self_faces(pli_body* body);

/// How the last step went.
typedef struct pli_self_faces_report {
    int pairs;         ///< of node and face, or of two edges, in reach
    int contacts;      ///< pairs that the last iteration or substep separated
    int shortened;     ///< number of motions that were shortened
    bool is_truncated; ///< some pairs were left out for lack of memory; crossings are possible
} pli_self_faces_report;

/// Report of the last step, all zero before the first one and when not enabled.
PLI_API pli_self_faces_report pli_body_get_self_faces_report(const pli_body* body);

/// Counts the pairs of faces that cross each other now; faces with a common node do not count. Works with or without
/// self-collision. Takes n log n time.
/// @return PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_count_crossings(const pli_body* body, int* count);

#ifdef __cplusplus
}
#endif
#endif
