#ifndef PLIANT_WORLD_FILE_H
#define PLIANT_WORLD_FILE_H

/// A world as a file: levels, saved games, crash reports. From it alone another process makes the world again, and its
/// steps equal those of the world that was written, bit for bit, for every number of threads. docs/state.md has more.
///
/// In it are bodies with nodes, links, faces, tetrahedra and materials as they are, cut or not; their settings, and
/// every feature with its settings and its state: anchors, joints, drags and targets with their ids, clusters, pairs
/// and contacts that the next step starts from; rigid bodies with their shapes. Bodies and rigid bodies keep their
/// order. Numbers are little-endian and as wide as in memory; a file does not depend on compiler and processor.
///
/// Not in it: user data, callbacks (controllers of joints, pli_cluster_contacts_def.distance), and what is inside of
/// shapes other than plane, sphere, box, capsule and cylinder: of these a file has ids that the caller gives.
///
/// Programs that name a function of this header link every feature. Writing allocates nothing.

#include "world.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What the caller has to say about what a file cannot hold.
typedef struct pli_world_file_def {
    /// Of a shape that is no plane, sphere, box, capsule or cylinder: its id in the file. NULL, default: 0 for all.
    uint64_t (*shape_id)(const pli_shape* shape, void* user);
    /// The shape of such an id, which stays the caller's; NULL: there is none, which is an error. Default NULL.
    pli_shape* (*find_shape)(uint64_t id, void* user);
    /// Of a rigid body, its id in the file. NULL, default: its index.
    uint64_t (*rigid_id)(const pli_rigid* rigid, void* user);
    /// For pli_world_file_restore: the rigid body of an id. NULL, default: by its index.
    pli_rigid* (*find_rigid)(uint64_t id, void* user);
    /// While writing, before each part: its name, as "nodes" or a feature's; the index of its body, or PLI_NULL_INDEX;
    /// and where it begins in the file. To compare files. Default NULL.
    void (*begin_part)(const char* part, int body, size_t offset, void* user);
    void* user;      ///< handed to all callbacks, default NULL
    uint32_t cookie; ///< set by the default function
} pli_world_file_def;

/// The defaults.
PLI_API pli_world_file_def pli_world_file_def_default(void);

/// Bytes that the world would have as a file now. 0 for a wrong handle.
PLI_API size_t pli_world_file_size(const pli_world* world);
/// Writes a world. Not while stepping.
/// @param def      may be NULL: the defaults
/// @param buffer   [capacity] bytes, of any alignment
/// @param size     bytes that were written, or, when there is too little room, that are needed; may be NULL
/// @return PLI_ERROR_INVALID_VALUE when the buffer is too small, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_file_write(const pli_world* world, const pli_world_file_def* def, void* buffer,
                                        size_t capacity, size_t* size);
/// Makes a world from a file. pli_world_get_body and pli_world_get_rigid give its bodies. Every length and every index
/// in the file is checked: nothing is made of one that is truncated, damaged or of a newer version.
/// @param def      may be NULL: the defaults
/// @param buffer   [size] bytes
/// @return PLI_ERROR_FILE_FORMAT with what is wrong, and where; PLI_ERROR_INVALID_VALUE for a shape that find_shape
///         does not know; PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_world_file_create(pli_context* context, const pli_world_file_def* def, const void* buffer,
                                         size_t size, pli_world** world);
/// Brings a world to the state of a file, whatever its bodies have been through since they were made, or in which
/// process: for hosts that make their world themselves. Handles of bodies and rigid bodies stay valid, ids are those of
/// the file; user data and callbacks stay, as far as the same feature, or the joint of the same id, had them.
/// Rigid bodies keep their shapes; those that the file does not name stay as they are, after the others. On any error
/// the world stays as it is. Not while stepping.
/// @return as pli_world_file_create; PLI_ERROR_INVALID_VALUE where the world has another number of bodies, or lacks a
///         rigid body of the file, or one has another number of shapes
PLI_API pli_status pli_world_file_restore(pli_world* world, const pli_world_file_def* def, const void* buffer,
                                          size_t size);

#ifdef __cplusplus
}
#endif

#endif
