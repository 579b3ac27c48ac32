#ifndef PLIANT_SNAPSHOT_H
#define PLIANT_SNAPSHOT_H

/// Snapshots: the state of a world between two steps, as bytes, for rollback in networked games, undo and trials. Steps
/// from a restored world equal those from the saved one bit for bit, for every number of threads.
///
/// A snapshot belongs to one world of one process, and holds copies of the memory that steps, forces and settings
/// change. It does not hold user data, callbacks, the shapes of rigid bodies, and contacts of the last step: after a
/// restore lists of contacts are empty until the next step. Ids of anchors and joints are those of the saved moment;
/// pointers stay valid.
///
/// It fits as long as no body, rigid body or feature of a body has come or gone (not even to return), no body was cut
/// or got other rest lengths (pli_body_set_rest_length), no file was read into the world (pli_world_file_restore), and
/// no list got less memory than it had. Forces, anchors, drags and moved nodes may come and go. Otherwise it is refused
/// with a message that names the body and what is different.
///
/// The buffer belongs to the caller and needs no alignment; one aligned to 64 bytes is the fastest. Save and restore
/// allocate nothing. docs/state.md has an example.

#include "world.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Size in bytes of a snapshot of the world now. It grows and shrinks with contacts and pairs. 0 for an invalid handle.
PLI_API size_t pli_world_snapshot_size(const pli_world* world);
/// Writes a snapshot. Not while stepping.
/// @param buffer   [capacity] bytes
/// @param size     receives the bytes written, or, when the buffer is too small, needed; may be NULL
/// @return PLI_ERROR_INVALID_VALUE when the buffer is too small, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_save(const pli_world* world, void* buffer, size_t capacity, size_t* size);
/// Goes back to a snapshot. Not while stepping. On any error the world stays as it is.
/// @param buffer [size] bytes, as pli_world_save has written them
/// @return PLI_ERROR_FILE_FORMAT when the buffer is no snapshot of a world, or is truncated or damaged;
///         PLI_ERROR_INVALID_VALUE when it does not fit the world; PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_restore(pli_world* world, const void* buffer, size_t size);

/// As pli_world_snapshot_size, for one body. Such a snapshot does not hold what the body shares with others, as
/// velocities of rigid bodies. It fits as long as no body, rigid body or cluster has left the world.
PLI_API size_t pli_body_snapshot_size(const pli_body* body);
/// As pli_world_save.
PLI_API pli_status pli_body_save(const pli_body* body, void* buffer, size_t capacity, size_t* size);
/// As pli_world_restore.
PLI_API pli_status pli_body_restore(pli_body* body, const void* buffer, size_t size);

#ifdef __cplusplus
}
#endif

#endif
