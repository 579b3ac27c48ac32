#ifndef PLIANT_TETHER_H
#define PLIANT_TETHER_H

/// Tethers: no node gets farther from the nodes that are pinned or anchored to a static or kinematic body, its origins,
/// than the body reaches from there to it. For ropes, cloth and capes that hang from these and are not meant to
/// stretch: what links carry only from one to the next, iteration by iteration, tethers see at once. They bound the
/// distance to the origins, not the length of each link: at speed some links stretch, others get slack. A node is held
/// by the nearest origin and by up to eight that are far from each other. Work with each solver, whichever comes first.
/// Source: Kim, Chentanez, Müller, "Long Range Attachments"; distances after Novotni and Klein, "Computing Geodesic
/// Distances on Triangular Meshes".

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How tight tethers are.
typedef struct pli_tethers_def {
    float slack;     ///< 0 to PLI_MAX_FACTOR, default 0.01: share of the length by which a tether is longer than it was
                     ///< measured
    uint32_t cookie; ///< set by the default function
} pli_tethers_def;

/// Defaults of the fields.
PLI_API pli_tethers_def pli_tethers_def_default(void);

/// Measures, at the rest lengths of the links that do not only resist bending, along links and straight across faces
/// whose edges are links, from the nodes that are pinned and those that are anchored to a static or kinematic body. A
/// node that hangs together with none of these is not held. Cuts, and changes of rest lengths, of masses and of anchors
/// are followed from the next step on. Where origins are farther apart than the body reaches, tethers are longer by as
/// much. A dynamic body that is anchored to a node is held where the anchor is, by the nearest origin. Under the
/// implicit solver tethers are springs of its system, 100 times as stiff as its links, and give a little. Enable, or
/// measure anew and change when enabled.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
/// Cost: 40 B per node, about 150 B per anchor; two looks at distances per node and iteration or substep. Measuring
/// is a search of shortest paths for the nearest origins, and one for each of the others.
PLI_API pli_status pli_body_enable_tethers(pli_body* body, const pli_tethers_def* def);

/// Lets go of all nodes. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_tethers(pli_body* body);

/// What holds a node.
typedef struct pli_tether {
    int origin;   ///< node that it starts from; PLI_NULL_INDEX: there is none
    float length; ///< m, without slack
} pli_tether;

/// The tether of one node to the nearest origin, which for an origin is itself at length 0; none where the node is not
/// held, or tethers are not enabled.
PLI_API pli_tether pli_body_get_tether(const pli_body* body, int node);

#ifdef __cplusplus
}
#endif
#endif
