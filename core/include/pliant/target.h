#ifndef PLIANT_TARGET_H
#define PLIANT_TARGET_H

/// Targets: nodes stay near points that the game moves, as clothes near a skinned mesh. Each node has a maximum
/// distance and, if wanted, a backstop: a sphere behind its target that it does not enter, in place of the limb there.
/// Names and meaning are those of the field: PhysX cloth (motion and separation constraints), Jolt
/// (SoftBodySharedSettings::Skinned). Targets work with each solver, and may be enabled before or after it.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How near one node stays.
typedef struct pli_target {
    int node;                ///< of the body, 0 or more
    float max_distance;      ///< m, 0 to PLI_MAX_COORDINATE, from the target; 0: the node is at its target
    float backstop_distance; ///< m, -max_distance to PLI_MAX_COORDINATE: from the target back along its normal to the
                             ///< sphere
    float backstop_radius;   ///< m, 0 to PLI_MAX_COORDINATE; 0: no backstop; large: nearly a plane
} pli_target;

/// Which nodes have targets, and where these are to begin with.
typedef struct pli_targets_def {
    const pli_target* targets; ///< [count], no node twice
    int count;                 ///< 1 or more
    const pli_vec3* positions; ///< [count] m, up to PLI_MAX_COORDINATE; default NULL: where the nodes are
    const pli_vec3* normals;   ///< [count] of any length but 0, out of the skin; NULL only without backstops
    uint32_t cookie;           ///< set by the default function
} pli_targets_def;

/// Defaults of the fields; `targets` and `count` have to be set.
PLI_API pli_targets_def pli_targets_def_default(void);

/// Gives nodes their targets. Called again, it replaces them.
/// - Nodes with a maximum distance of 0 are pinned from now on (tethers start from them, links see them as infinitely
///   heavy) and are at their targets at the end of each step. They get their masses back with another distance or
///   without a target.
/// - Other nodes are kept within their distance, and then out of the backstop, after all other constraints of an
///   iteration or substep; only self-collision of faces and drift_iterations come later. A node that is too far now is
///   moved at once. Under the implicit solver the load of such a node reaches its neighbours a step late: pin some
///   nodes (distance 0) if the whole body hangs from its targets.
/// - A new node of a cut gets a target between those of its parents.
/// @param def copied with its arrays
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node), PLI_ERROR_INVALID_VALUE (also for a node twice, a normal of length 0,
///         missing normals), PLI_ERROR_NULL_ARGUMENT, PLI_ERROR_NOT_FINITE, PLI_ERROR_WRONG_STATE while stepping,
///         PLI_ERROR_OUT_OF_MEMORY
/// Cost: 4 B per node, about 100 B per target; a distance per target and iteration or substep.
PLI_API pli_status pli_body_enable_targets(pli_body* body, const pli_targets_def* def);

/// Removes all targets. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_targets(pli_body* body);

/// Moves all targets to new places within the next step, in straight lines at one speed, through all substeps. After
/// that they stay there. The last call before a step counts.
/// @param positions [count] m, up to PLI_MAX_COORDINATE, in the order of the definition
/// @param normals   [count] as in the definition; NULL: as they were
/// @param count     that of the definition
/// @return the errors of pli_body_enable_targets; PLI_ERROR_INVALID_VALUE also for another count, or without targets
PLI_API pli_status pli_body_move_targets(pli_body* body, const pli_vec3* positions, const pli_vec3* normals, int count);

/// The same at once, without a motion: for a character that appears elsewhere. Call pli_body_transform first, so that
/// the nodes come along. Nodes that are still too far from the new places are moved into their range and keep their
/// velocities; pinned ones are at rest.
PLI_API pli_status pli_body_teleport_targets(pli_body* body, const pli_vec3* positions, const pli_vec3* normals,
                                             int count);

#ifdef __cplusplus
}
#endif
#endif
