#ifndef PLIANT_POSE_H
#define PLIANT_POSE_H

/// Pose matching: a body, or each part into which it is cut, is pulled towards the rigid motion of its rest shape that
/// fits best.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Takes the present shape as the rest shape and pulls the body back to it. Enable, or change when enabled (the rest
/// shape is taken anew). Parts into which the body is cut from then on have a pose each, and come apart; so do pieces
/// that the pose alone held together. Enabled again they stay apart, disabled and enabled they have one pose.
/// A pinned node weighs a thousand times the whole body. In reference mode (pli_world_def) the matched shape shrinks to
/// a point then, as in Bullet, and when the body is smaller than about 3 cm, and grows without bound above about 90 m;
/// masses count as they were when this was enabled, and parts stay together.
/// Source: Müller and others, "Meshless Deformations Based on Shape Matching". Bullet name: kMT with
/// setPose(false, true)
/// @param matching [0, 1]: share of the distance to the matched pose that one step removes
PLI_API pli_status pli_body_enable_pose_matching(pli_body* body, float matching);

/// Ends pose matching, and forgets the rest shape. Nothing when not enabled.
PLI_API pli_status pli_body_disable_pose_matching(pli_body* body);

/// Rotation and centre of mass (m) of the best fit in the last step; of a body that was cut, of the part of node 0.
/// @return PLI_ERROR_WRONG_STATE when pose matching is not enabled
PLI_API pli_status pli_body_get_pose(const pli_body* body, pli_transform* pose);

#ifdef __cplusplus
}
#endif
#endif
