#ifndef PLIANT_TETHER_H
#define PLIANT_TETHER_H

/// Tethers, for ropes, cloth and capes that hang and are not meant to stretch. Origins are the nodes that are pinned or
/// anchored to a static or kinematic body. No node gets farther from its origins than the body at rest reaches from
/// there to it. Links pass a load on only from one to the next, iteration by iteration; tethers feel it at once. They
/// bound the distance to the origins, not the length of each link: at speed some links stretch and others get slack. A
/// node is held by the nearest origin and by up to eight that are far from each other. They work with each solver, and
/// may be enabled before or after it. Source: Kim, Chentanez, Müller, "Long Range Attachments"; distances after Novotni
/// and Klein, "Computing Geodesic Distances on Triangular Meshes".

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How tight tethers are.
typedef struct pli_tethers_def {
    float slack;     ///< 0 to PLI_MAX_FACTOR, default 0.01: a tether is longer than measured by this share
    uint32_t cookie; ///< set by the default function
} pli_tethers_def;

/// Defaults of the fields.
PLI_API pli_tethers_def pli_tethers_def_default(void);

/// Measures the tethers and holds nodes by them. Called again, it measures anew and changes the settings.
/// - Lengths are measured at the rest lengths of links, along links and straight across faces whose edges are links.
///   Bending links do not count. Where origins are farther apart than the body reaches, tethers are longer by as much.
/// - A node that is not connected with any origin is not held.
/// - Enable them while the body is not stretched: cloth that is longer by 40 % leaps back with 5 m/s.
/// - Cuts and changes of rest lengths, masses and anchors are followed from the next step on.
/// - A dynamic body that is anchored to a node is held at the anchor by the nearest origin.
/// - Where there are no origins, as in a rope between two crates, dynamic bodies that are anchored are held together:
///   at their anchors none is farther from the first anchor than the body between is long. Nodes are not held then.
///   Not under the implicit solver.
/// - Under the implicit solver tethers are springs of its system, 100 times as stiff as its links, and give a little.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
/// Cost: 40 B per node, about 150 B per anchor; two tests of distances per node and iteration or substep. Measuring
/// is a search of shortest paths for the nearest origins, and one for each of the others.
PLI_API pli_status pli_body_enable_tethers(pli_body* body, const pli_tethers_def* def);

/// Ends tethers. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_tethers(pli_body* body);

/// What holds a node.
typedef struct pli_tether {
    int origin;   ///< node that it starts from; PLI_NULL_INDEX: no tether
    float length; ///< m, without slack
} pli_tether;

/// The tether of one node to the nearest origin. That of an origin is itself, at length 0. No tether if the node is not
/// held or tethers are not enabled.
PLI_API pli_tether pli_body_get_tether(const pli_body* body, int node);

#ifdef __cplusplus
}
#endif
#endif
