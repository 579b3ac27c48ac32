#ifndef PLIANT_CUT_H
#define PLIANT_CUT_H

/// Cutting and refining a body. Nodes are only added, so indices of nodes stay valid; links and faces are renumbered.
/// Not while stepping. Views of the body are invalid afterwards.
///
/// A cut is done completely or not at all. Everything that is enabled on the body follows it; if a feature cannot, the
/// cut is refused with PLI_ERROR_WRONG_STATE. Total mass is kept: new nodes take theirs from the nodes beside them.
/// Anchors stay with their node, and a copy of a pinned node is pinned. Tetrahedra cannot be cut: a cut that meets one
/// is refused with PLI_ERROR_INVALID_MESH. Other bodies of the same mesh stay as they are. Time is linear in the size
/// of the body.

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
    /// Default false: links that are not cut keep their rest length, the parts of a link share its rest length, new
    /// links get the length that they have in the rest shape of their face, and only nodes between two sides are
    /// doubled. True, reference mode only: the present lengths become the rest lengths of all links, likewise areas,
    /// and btSoftBody's rules hold for what lies on the surface: all nodes there are doubled, which may leave nodes
    /// without links behind; link 0 is not detached; links with a loose end go, even of a rope.
    bool reset_rest_lengths;
    uint32_t cookie; ///< set by the default function
} pli_refine_def;

/// Defaults of the fields; `surface` has to be set.
PLI_API pli_refine_def pli_refine_def_default(void);

/// Makes new nodes where links and faces cross a surface, and cuts along them. Bending links that cross it are removed.
/// Nodes with a value nearer to zero than the accuracy lie on the surface, and are cut without a new node.
/// Bullet name: refine
/// @return PLI_ERROR_NOT_FINITE when the surface gives NaN or infinity somewhere, PLI_ERROR_INVALID_VALUE when it gives
///         more than PLI_MAX_SURFACE_VALUE, PLI_ERROR_INVALID_MESH (tetrahedra), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_refine(pli_body* body, const pli_refine_def* def);

/// Cuts one link (and the faces along it) in two. Bullet name: cutLink
/// Its halves are as stretched as it was: to tear what is too long, see pli_body_tear.
/// @param position (0, 1), share of its length from node a
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node), PLI_ERROR_INVALID_VALUE also when no link joins the nodes,
///         PLI_ERROR_INVALID_MESH (an edge of a tetrahedron), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_cut_link(pli_body* body, int node_a, int node_b, float position);

/// Cuts along the strip swept by a ray from (from_start, from_end) to (to_start, to_end), as a mouse does between two
/// frames. Faces and links that the swept surface crosses are parted along it.
/// - An edge that is crossed nearer to its end than 5 % of its length is cut at that end instead.
/// - A face in which the sweep ends is refined but not opened. A sweep that continues there (its first ray is the last
///   one of the call before) opens it. So short sweeps make one cut, and a cut that comes back to its start closes.
/// - Between two such calls the body may move, but must not be cut otherwise. If its motion has taken the end of the
///   cut off the ray, the sweep starts at that end, unless it lies past the sweep or farther away than the ray is long.
///   Of several layers that move apart one is followed.
/// - A sweep inside one face cuts no face.
/// - Bending links, and links that are no edge of a face but join two nodes with faces, are removed when they are
///   crossed; bending links also when one of their nodes is parted.
/// @param from_start,from_end,to_start,to_end m, up to PLI_MAX_COORDINATE
/// @param parted receives the number of links that were parted or, along nodes, doubled; may be NULL
/// @return PLI_ERROR_INVALID_MESH (tetrahedra), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_cut_swept(pli_body* body, pli_vec3 from_start, pli_vec3 from_end, pli_vec3 to_start,
                                      pli_vec3 to_end, int* parted);

/// Tears cloth, nets and ropes where they are stretched most. A link that is too long is taken off one of its ends: the
/// node there is copied, and what lies beyond it, seen along the link, stays with one of the two, the rest with the
/// other. Faces are parted along their edges and none are made, so cloth frays in the pattern of its mesh. Bending
/// links across the tear are removed. Call it after each step: torn links shorten in the steps that follow, and each
/// end is parted once per call.
/// @param stretch > 0, up to PLI_MAX_FACTOR: links longer than (1 + stretch) times their rest length tear, but for
///        bending links. Well above what cloth is stretched by in use, as 0.5, or it goes to pieces at its own weight
/// @param most    >= 1, nodes that are parted at most: the larger, the faster a tear runs
/// @param torn    receives how many were; may be NULL
/// @return PLI_ERROR_INVALID_MESH (tetrahedra), PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
/// Cost: a pass over the links while none is too long, else a copy of the body and a pass over it for each node.
PLI_API pli_status pli_body_tear(pli_body* body, float stretch, int most, int* torn);

/// Counts the parts that are connected by links, faces or tetrahedra. A node without any is not counted.
/// @return PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_count_parts(const pli_body* body, int* count);

#ifdef __cplusplus
}
#endif
#endif
