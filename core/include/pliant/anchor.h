#ifndef PLIANT_ANCHOR_H
#define PLIANT_ANCHOR_H

/// Anchors hold nodes to points of rigid bodies; both pull.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Names an anchor of one body; all zero is no anchor.
typedef struct pli_anchor_id {
    int32_t index1;      ///< index in the library's table plus one; 0: no anchor
    uint32_t generation; ///< tells the anchor from earlier ones at that index
} pli_anchor_id;

/// What to hold to what.
typedef struct pli_anchor_def {
    int node;                    ///< of the body, default 0
    pli_rigid* rigid;            ///< of the same world, required
    const pli_vec3* local_pivot; ///< m, up to PLI_MAX_COORDINATE, in the frame of the rigid body; default NULL: where
                                 ///< the node is now
    float influence;             ///< 0 to PLI_MAX_FACTOR, default 1: factor of the impulses on both; not with XPBD
    float compliance;            ///< m/N, 0 to PLI_MAX_COEFFICIENT, default 0 (rigid). XPBD only
    bool disable_collision;      ///< default false; true: pli_body_ignore_rigid for this pair from now on
    uint32_t cookie;             ///< set by the default function
} pli_anchor_def;

/// Defaults of the fields; `rigid` has to be set.
PLI_API pli_anchor_def pli_anchor_def_default(void);

/// Holds a node to a rigid body until the anchor is removed, with any solver. The node takes no part in contacts with
/// rigid bodies; it may have several anchors. Allowed between pli_world_predict and pli_world_solve too.
/// Bullet name: appendAnchor
///
/// A node on a static or kinematic body is where the body's point is at the end of the step, with any solver. It is not
/// if the anchor yields (compliance, influence below 1), nor in reference mode, where it lags by about a step's motion,
/// as in Bullet.
/// @param anchor receives the id; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node), PLI_ERROR_INVALID_VALUE (also for a rigid body of another world),
///         PLI_ERROR_OUT_OF_MEMORY
/// Cost: about 150 B per anchor, 1 B per node.
PLI_API pli_status pli_body_add_anchor(pli_body* body, const pli_anchor_def* def, pli_anchor_id* anchor);

/// Removes one anchor. A pair that `disable_collision` has switched off stays off.
/// @return PLI_ERROR_STALE_ID when the body has no such anchor (any more)
PLI_API pli_status pli_body_remove_anchor(pli_body* body, pli_anchor_id anchor);

/// Holds many nodes to one rigid body where they are now, as a collar to a bone: an anchor with the defaults for each.
/// Either all nodes get one or none.
/// @param nodes [count] of the body, none twice, none that has an anchor; may be NULL when count is 0
/// @param count 0 or more
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node), PLI_ERROR_INVALID_VALUE (count, a node twice or anchored already, a
///         rigid body of another world), PLI_ERROR_NULL_ARGUMENT, PLI_ERROR_OUT_OF_MEMORY
/// Cost: about 150 B per node.
PLI_API pli_status pli_body_attach_nodes(pli_body* body, const int* nodes, int count, pli_rigid* rigid);

/// Removes all anchors of many nodes; their ids are stale afterwards. Either all nodes are released or none.
/// @param nodes [count], none twice, each with an anchor; may be NULL when count is 0
/// @return as pli_body_attach_nodes
PLI_API pli_status pli_body_detach_nodes(pli_body* body, const int* nodes, int count);

/// Number of anchors.
PLI_API int pli_body_anchor_count(const pli_body* body);

/// Share of its position error at the start of a step that an anchor to a dynamic body removes in the step, with the
/// position-based and the implicit solver. It holds for all anchors of the body, present and future. Unless the anchor
/// yields (influence, compliance), the error is removed at 10 m/s at most, or at four times its length per second where
/// that is more, under XPBD too. Anchors with an influence below 1, and all in reference mode, have it with static and
/// kinematic bodies as well; in reference mode it is a share of the error per iteration. Bullet name: kAHR
/// @param hardness [0, 1], default 0.7
PLI_API pli_status pli_body_set_anchor_hardness(pli_body* body, float hardness);

#ifdef __cplusplus
}
#endif
#endif
