#ifndef PLIANT_WORLD_FILE_H
#define PLIANT_WORLD_FILE_H

/// A world as a file: levels, saved games, crash reports. Another process makes the world again from the file alone,
/// and its steps equal those of the written world bit for bit, for every number of threads. docs/state.md has more.
///
/// A file holds bodies with nodes, links, faces, tetrahedra and materials as they are, cut or not; their settings;
/// every feature with its settings and its state (anchors, joints, drags and targets with their ids, clusters, pairs
/// and contacts that the next step starts from); and rigid bodies with their shapes. Bodies and rigid bodies keep their
/// order. Numbers are little-endian; a file does not depend on compiler and processor.
///
/// It does not hold user data, callbacks (controllers of joints, pli_cluster_contacts_def.distance), and the contents
/// of shapes other than plane, sphere, box, capsule and cylinder. For these it has ids that the caller gives.
///
/// Programs that name a function of this header link every feature. Writing allocates nothing.

#include "world.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What the caller adds for things that a file cannot hold.
typedef struct pli_world_file_def {
    /// The id in the file of a shape that is no plane, sphere, box, capsule or cylinder. Default NULL: 0 for all.
    uint64_t (*shape_id)(const pli_shape* shape, void* user);
    /// The shape with such an id, which stays the caller's; returning NULL is an error. Default NULL: no shape is
    /// known.
    pli_shape* (*find_shape)(uint64_t id, void* user);
    /// The id of a rigid body in the file. Default NULL: its index.
    uint64_t (*rigid_id)(const pli_rigid* rigid, void* user);
    /// For pli_world_file_restore: the rigid body with an id. Default NULL: by its index.
    pli_rigid* (*find_rigid)(uint64_t id, void* user);
    /// Called while writing, before each part, with its name ("nodes", or that of a feature), the index of its body or
    /// PLI_NULL_INDEX, and where it begins in the file. For comparing files. Default NULL.
    void (*begin_part)(const char* part, int body, size_t offset, void* user);
    void* user;      ///< handed to all callbacks, default NULL
    uint32_t cookie; ///< set by the default function
} pli_world_file_def;

/// The defaults.
PLI_API pli_world_file_def pli_world_file_def_default(void);

/// Size in bytes of the world as a file now. 0 for an invalid handle.
PLI_API size_t pli_world_file_size(const pli_world* world);
/// Writes a world. Not while stepping.
/// @param def      may be NULL: the defaults
/// @param buffer   [capacity] bytes, of any alignment
/// @param size     receives the bytes written, or, when the buffer is too small, needed; may be NULL
/// @return PLI_ERROR_INVALID_VALUE when the buffer is too small, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_file_write(const pli_world* world, const pli_world_file_def* def, void* buffer,
                                        size_t capacity, size_t* size);
/// Makes a world from a file. pli_world_get_body and pli_world_get_rigid return its bodies. Every length and every
/// index in the file is checked: a file that is truncated, damaged or of a newer version makes nothing.
/// @param def      may be NULL: the defaults
/// @param buffer   [size] bytes
/// @return PLI_ERROR_FILE_FORMAT, with a message that says what is wrong and where; PLI_ERROR_INVALID_VALUE for a shape
///         that find_shape does not know; PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_world_file_create(pli_context* context, const pli_world_file_def* def, const void* buffer,
                                         size_t size, pli_world** world);
/// Brings an existing world to the state of a file, for hosts that make their world themselves. It does not matter what
/// the bodies have been through, or in which process. Handles of bodies and rigid bodies stay valid; ids are those of
/// the file. User data and callbacks stay where the same feature, or the joint with the same id, had them. Rigid bodies
/// keep their shapes; those that the file does not name stay as they are, after the others. On any error the world
/// stays as it is. Not while stepping.
/// @return as pli_world_file_create; PLI_ERROR_INVALID_VALUE also when the world has another number of bodies, lacks a
///         rigid body of the file, or has one with another number of shapes
PLI_API pli_status pli_world_file_restore(pli_world* world, const pli_world_file_def* def, const void* buffer,
                                          size_t size);

#ifdef __cplusplus
}
#endif

#endif
