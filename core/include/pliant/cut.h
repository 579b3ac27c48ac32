#ifndef PLIANT_CUT_H
#define PLIANT_CUT_H

/// Cutting and refining a body. Nodes are only added, so indices that the user holds stay valid; links and faces are
/// renumbered. Not while stepping. Views of the body are invalid afterwards.
///
/// A cut happens wholly or not at all, and all that is enabled on the body follows it; it is refused with
/// PLI_ERROR_WRONG_STATE where a feature cannot. Total mass is kept: new nodes
/// take theirs from the nodes beside them. Anchors stay with their node, and a copy of a pinned node is pinned.
/// Tetrahedra cannot be cut: a cut that meets one is refused with PLI_ERROR_INVALID_MESH. The faces of other bodies of
/// the same mesh stay as they are. Time is linear in the size of the body.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Where to refine, and whether to cut there.
typedef struct pli_refine_def {
    /// The surface: negative inside, positive outside, m or any other unit. Called once per node and a few times per
    /// link that crosses it; the same point must give the same value. May read only. Required.
    float (*surface)(pli_vec3 point, void* user);
    void* user;     ///< handed to `surface`
    float accuracy; ///< > 0, default 1e-4: how near to zero `surface` is at the new nodes, in its unit
    bool cut;       ///< default true: part the body along the surface; false: only refine
    /// Reference mode only: take the present lengths as rest lengths of all links, and the present areas, as btSoftBody
    /// does, and keep to its rules for what lies on the surface: all nodes there are doubled, which may leave nodes
    /// behind that hang on nothing; link 0 is not detached; links with a loose end go, even of a rope. Default false:
    /// links that are not cut keep their rest length, the parts of a link share its rest length, new links get the
    /// length they have in the rest shape of their face, and only what lies between two sides is doubled.
    bool reset_rest_lengths;
    uint32_t cookie; ///< set by the default function
} pli_refine_def;

/// Defaults of the fields; `surface` has to be set.
PLI_API pli_refine_def pli_refine_def_default(void);

/// Makes new nodes where links and faces cross a surface, and cuts along them. Bending links that cross it go. Nodes
/// with a value nearer to zero than the accuracy are on the surface, and are cut without a new node.
/// Bullet name: refine
/// @return PLI_ERROR_NOT_FINITE when the surface gives NaN or infinity somewhere, PLI_ERROR_INVALID_VALUE when it gives
///         more than PLI_MAX_SURFACE_VALUE, PLI_ERROR_INVALID_MESH (tetrahedra), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_refine(pli_body* body, const pli_refine_def* def);

/// Cuts one link (and the faces along it) in two. Its halves are as stretched as it was, so cloth does not tear by
/// this: cut wherever links are too long, one of 1,400 nodes has 30,000 after a dozen steps. Bullet name: cutLink
/// @param position (0, 1), share of its length from node a
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node), PLI_ERROR_INVALID_VALUE also when no link joins the nodes,
///         PLI_ERROR_INVALID_MESH (an edge of a tetrahedron), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_cut_link(pli_body* body, int node_a, int node_b, float position);

/// Cuts along the triangle strip swept by a ray from (from_start, from_end) to (to_start, to_end): what a mouse does
/// between two frames. Faces and links that the swept surface crosses are parted along it.
///
/// An edge that is crossed nearer to its end than 5 % of its length is cut at that end instead. A face in which the
/// sweep ends is refined but not opened; a sweep that goes on from there (its first ray is the last one of the call
/// before) opens it, so that short sweeps make one cut, and a cut that comes back to where it began closes. Between two
/// such calls the body may move, but not be cut otherwise: where its motion has taken the end of the cut off the ray,
/// the sweep starts there, unless that is past the sweep or farther away than the ray is long. Of several layers that
/// move apart one is followed. Sweeps inside of one face cut no face. Bending links, and links that are no edge of a
/// face but join two nodes with faces, go when they are crossed, and bending links also when one of their nodes is
/// parted.
/// @param from_start,from_end,to_start,to_end m, up to PLI_MAX_COORDINATE
/// @param parted receives the number of links that were parted or, along nodes, doubled; may be NULL
/// @return PLI_ERROR_INVALID_MESH (tetrahedra), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_cut_swept(pli_body* body, pli_vec3 from_start, pli_vec3 from_end, pli_vec3 to_start,
                                      pli_vec3 to_end, int* parted);

/// Counts the parts that hang together by links, faces or tetrahedra; a node without any is a part of its own and not
/// counted.
/// @return PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_count_parts(const pli_body* body, int* count);

#ifdef __cplusplus
}
#endif
#endif
