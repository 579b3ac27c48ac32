#ifndef PLIANT_SNAPSHOT_H
#define PLIANT_SNAPSHOT_H

/// What a world is at a moment between steps, as bytes, to go back to it: rollback in networked games, trials, undo.
/// Steps from a restored world equal those from the saved one bit for bit, for every number of threads.
///
/// A snapshot is of one world of one process, and holds copies of its memory: what steps, forces and settings change.
/// It fits as long as no body, no rigid body and no feature of a body has come or gone, also to be there again, and
/// nobody cut a body, changed its rest lengths (pli_body_set_rest_length), read a file into the world
/// (pli_world_file_restore), or gave lists less memory than they had. Forces, anchors, drags and moved nodes may come
/// and go. Anything else is refused with a message that names the body and what is different. Ids of anchors and joints
/// are those of the moment, pointers stay valid. Contacts of the last step are not in a snapshot: lists of them are
/// empty until the next one. Not in it either: user data, callbacks, the shapes of rigid bodies.
///
/// A buffer needs no alignment, and is the caller's; one on a multiple of 64 bytes is the fastest. Save and restore
/// allocate nothing. docs/state.md has a loop.

#include "world.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Bytes that a snapshot of the world would have now; grows and shrinks with its contacts and pairs. 0 for a wrong
/// handle.
PLI_API size_t pli_world_snapshot_size(const pli_world* world);
/// Writes a snapshot. Not while stepping.
/// @param buffer   [capacity] bytes
/// @param size     bytes that were written, or, when there is too little room, that are needed; may be NULL
/// @return PLI_ERROR_INVALID_VALUE when the buffer is too small, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_save(const pli_world* world, void* buffer, size_t capacity, size_t* size);
/// Goes back to a snapshot. Not while stepping. On any error the world stays as it is.
/// @param buffer [size] bytes, as pli_world_save has written them
/// @return PLI_ERROR_FILE_FORMAT for what is no snapshot of a world, is truncated or damaged;
///         PLI_ERROR_INVALID_VALUE for one that does not fit the world; PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_restore(pli_world* world, const void* buffer, size_t size);

/// As pli_world_snapshot_size, of one body. What it shares with others, as velocities of rigid bodies, is not in it. It
/// fits as long as no body, no rigid body and no cluster has left the world.
PLI_API size_t pli_body_snapshot_size(const pli_body* body);
/// As pli_world_save.
PLI_API pli_status pli_body_save(const pli_body* body, void* buffer, size_t capacity, size_t* size);
/// As pli_world_restore.
PLI_API pli_status pli_body_restore(pli_body* body, const void* buffer, size_t size);

#ifdef __cplusplus
}
#endif

#endif
