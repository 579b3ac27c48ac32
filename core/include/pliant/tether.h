#ifndef PLIANT_TETHER_H
#define PLIANT_TETHER_H

/// Tethers: no node gets farther from its origin, the nearest along the links of the nodes that are pinned or anchored
/// to a static or kinematic body, than the links are long. For ropes, cloth and capes that hang from these and are not
/// meant to stretch: what links carry only from one to the next, iteration by iteration, tethers see at once. Work with
/// each solver, whichever comes first. Source: Kim, Chentanez, Müller, "Long Range Attachments".

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How tight tethers are.
typedef struct pli_tethers_def {
    float slack;     ///< 0 to PLI_MAX_FACTOR, default 0.01: share of the length by which a tether is longer than the
                     ///< links
    uint32_t cookie; ///< set by the default function
} pli_tethers_def;

/// Defaults of the fields.
PLI_API pli_tethers_def pli_tethers_def_default(void);

/// Measures along the links that do not only resist bending, at their rest lengths, from the nodes that are pinned and
/// those that are anchored to a static or kinematic body. A node that hangs together with none of these is not held.
/// Cuts, and changes of rest lengths, of masses and of anchors are followed from the next step on. A dynamic body that
/// is anchored to a node is held where the anchor is. The implicit solver knows the weight of rigid bodies by itself:
/// under it a body that dynamic bodies are anchored to has no tethers. Enable, or measure anew and change when enabled.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 8 B per node, about 150 B per anchor; a distance per node and iteration or substep.
PLI_API pli_status pli_body_enable_tethers(pli_body* body, const pli_tethers_def* def);

/// Lets go of all nodes. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_tethers(pli_body* body);

/// What holds a node.
typedef struct pli_tether {
    int origin;   ///< node that it starts from; PLI_NULL_INDEX: there is none
    float length; ///< m, without slack
} pli_tether;

/// The tether of one node; none where the node is not held, is none itself, or tethers are not enabled.
PLI_API pli_tether pli_body_get_tether(const pli_body* body, int node);

#ifdef __cplusplus
}
#endif
#endif
