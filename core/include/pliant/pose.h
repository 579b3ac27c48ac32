#ifndef PLIANT_POSE_H
#define PLIANT_POSE_H

/// Pose matching: a body, or each part into which it is cut, is pulled towards the rigid motion of its rest shape that
/// fits best.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Takes the present shape as the rest shape and pulls the body back to it. Called again, it takes the rest shape anew.
/// - A cut after that gives each part a pose of its own, so that the parts come apart, as do pieces that only the pose
///   held together. Called again, parts stay apart; disabled and enabled again, they have one common pose.
/// - A pinned node weighs a thousand times the whole body.
/// - In reference mode (pli_world_def), as in Bullet, the matched shape shrinks to a point if a node is pinned or the
///   body is smaller than about 3 cm, and grows without bound above about 90 m; masses are those at the time when it
///   was enabled, and parts stay together.
///
/// Source: Müller and others, "Meshless Deformations Based on Shape Matching". Bullet name: kMT with setPose(false,
/// true)
/// @param matching [0, 1]: share of the distance to the matched pose that one step removes
PLI_API pli_status pli_body_enable_pose_matching(pli_body* body, float matching);

/// Ends pose matching, and forgets the rest shape. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_pose_matching(pli_body* body);

/// Rotation and centre of mass (m) of the best fit in the last step; if the body was cut, of the part with node 0.
/// @return PLI_ERROR_WRONG_STATE when pose matching is not enabled
PLI_API pli_status pli_body_get_pose(const pli_body* body, pli_transform* pose);

#ifdef __cplusplus
}
#endif
#endif
