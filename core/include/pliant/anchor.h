#ifndef PLIANT_ANCHOR_H
#define PLIANT_ANCHOR_H

/// Anchors hold a node to a point of a rigid body, both ways.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Names an anchor of one body; all zero is no anchor.
typedef struct pli_anchor_id {
    int32_t index1;
    uint32_t generation;
} pli_anchor_id;

typedef struct pli_anchor_def {
    int node;
    pli_rigid* rigid;
    const pli_vec3* local_pivot; ///< in the frame of the rigid body; NULL: where the node is now
    float influence;             ///< default 1; scales the impulse
    bool disable_collision;      ///< the soft body ignores this rigid body from now on, default false
    uint32_t cookie;
} pli_anchor_def;

PLI_API pli_anchor_def pli_anchor_def_default(void);

/// An anchored node takes no part in rigid contacts. Bullet name: appendAnchor
/// @param anchor receives the id; may be NULL
PLI_API pli_status pli_body_add_anchor(pli_body* body, const pli_anchor_def* def, pli_anchor_id* anchor);
/// Collision with the rigid body stays switched as it is. @return PLI_ERROR_STALE_ID
PLI_API pli_status pli_body_remove_anchor(pli_body* body, pli_anchor_id anchor);
PLI_API int pli_body_anchor_count(const pli_body* body);

/// [0, 1], default 0.7: share of an anchor's position error that one iteration removes, for all anchors of the body.
/// Bullet name: kAHR
PLI_API pli_status pli_body_set_anchor_hardness(pli_body* body, float hardness);

#ifdef __cplusplus
}
#endif
#endif
