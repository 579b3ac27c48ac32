#ifndef PLIANT_CUT_H
#define PLIANT_CUT_H

/// Cutting and refining a body. Nodes are only added, so indices that the user holds stay valid; links and faces are
/// renumbered. Not while stepping. Views of the body are invalid afterwards.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_refine_def {
    /// The surface: negative inside, positive outside, m or any other unit.
    float (*surface)(pli_vec3 point, void* user);
    void* user;
    float accuracy; ///< > 0, default 1e-4: how near to zero `surface` is at the new nodes, in its unit
    bool cut;       ///< default true: part the body along the surface; false: only refine
    /// Take the present lengths as rest lengths of all links, and the present areas, as btSoftBody does; default
    /// false: links that are not cut keep their rest length, the parts of a link share its rest length.
    bool reset_rest_lengths;
    uint32_t cookie;
} pli_refine_def;

PLI_API pli_refine_def pli_refine_def_default(void);

/// New nodes where links and faces cross the surface, which is then cut along them. Bending links that cross it go.
/// Bullet name: refine
/// @return PLI_ERROR_NOT_FINITE when the surface gives NaN somewhere; the body is unchanged then
PLI_API pli_status pli_body_refine(pli_body* body, const pli_refine_def* def);

/// Cut one link (and the faces along it) in two at `position` of its length from node a. Bullet name: cutLink
/// @param position (0, 1)
/// @return PLI_ERROR_INVALID_VALUE when no link joins the nodes
PLI_API pli_status pli_body_cut_link(pli_body* body, int node_a, int node_b, float position);

/// Cut along the triangle-strip swept by a ray from (from_start, from_end) to (to_start, to_end): what a mouse does
/// between two frames. Faces and links that the swept surface crosses are parted along it.
/// @param parted receives the number of links that were parted; may be NULL
PLI_API pli_status pli_body_cut_swept(pli_body* body, pli_vec3 from_start, pli_vec3 from_end, pli_vec3 to_start,
                                      pli_vec3 to_end, int* parted);

/// Number of parts that hang together by links or faces; a node without either is a part of its own and not counted.
PLI_API int pli_body_part_count(const pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
