#ifndef PLIANT_DRAG_H
#define PLIANT_DRAG_H

/// Dragging: a damped spring between a point of a body and a point of the world that the user moves, as with a mouse.
/// The spring is implicit in time: stable for any stiffness and step, and while its goal stands still it takes energy
/// and gives none. Works with each solver.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Names a drag of one body; all zero is none.
typedef struct pli_drag_id {
    int32_t index1;      ///< index in the library's table plus one; 0: none
    uint32_t generation; ///< tells the drag from earlier ones at that index
} pli_drag_id;

/// What to drag, and how firmly.
typedef struct pli_drag_def {
    int node;        ///< of the body, default 0; used without a face
    int face;        ///< default PLI_NULL_INDEX: a node is dragged
    pli_vec3 point;  ///< m, up to PLI_MAX_COORDINATE: the point of the face that is nearest to this is dragged, as
                     ///< pli_ray_hit::point
    float frequency; ///< Hz, 0 to PLI_MAX_FACTOR, default 5: of all free nodes of the body on the spring; used where
                     ///< `stiffness` is 0
    float stiffness; ///< N/m, 0 to PLI_MAX_COEFFICIENT; default 0: from the frequency
    float damping_ratio; ///< 0 to PLI_MAX_FACTOR, default 1: share of the critical damping of the same mass
    uint32_t cookie;     ///< set by the default function
} pli_drag_def;

/// Defaults of the fields.
PLI_API pli_drag_def pli_drag_def_default(void);

/// Takes hold of a point of a body. The goal is at first where the point is now. A body may have several drags. After a
/// cut through the face the nearest of its nodes is dragged.
/// @param drag receives the id; required
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node, face), PLI_ERROR_INVALID_VALUE, PLI_ERROR_NOT_FINITE,
///         PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
/// Cost: about 150 B; in a step that of a constraint.
PLI_API pli_status pli_body_begin_drag(pli_body* body, const pli_drag_def* def, pli_drag_id* drag);

/// Moves the goal, in a straight line within the next step.
/// @param goal m, up to PLI_MAX_COORDINATE
/// @return PLI_ERROR_STALE_ID when the body has no such drag (any more), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_move_drag(pli_body* body, pli_drag_id drag, pli_vec3 goal);

/// Lets go. The point keeps its velocity.
/// @return as pli_body_move_drag
PLI_API pli_status pli_body_end_drag(pli_body* body, pli_drag_id drag);

/// The point that is dragged, and its goal, for drawing the spring between them.
/// @param point m; zero on an error; may be NULL
/// @param goal  likewise
PLI_API pli_status pli_body_get_drag(const pli_body* body, pli_drag_id drag, pli_vec3* point, pli_vec3* goal);

#ifdef __cplusplus
}
#endif
#endif
