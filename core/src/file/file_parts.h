#pragma once

/* What a file of a world consists of. Each function counts, writes, reads or re-points what it is named after; in
   PLII_FILE_READ bodies and rigid bodies are made, in the world of the call. */

#include "file/file_stream.h"
#include "pliant/world_file.h"

/* Of all bytes after the header, for its last eight. */
enum { PLII_FILE_HEADER_SIZE = 32 };
uint64_t plii_file_checksum(const unsigned char* bytes, size_t size);

/* Rigid body `index` of the file: shapes and state. Reading takes the shapes of `source`, or makes them where it is
   NULL. */
void plii_file_rigid(plii_file* file, const pli_world_file_def* def, pli_world* world, int index,
                     const pli_rigid* source);
/* What of it comes after all bodies. */
void plii_file_rigid_end(plii_file* file, pli_rigid* rigid);
/* The state again, from one rigid body to another. */
void plii_file_copy_rigid(pli_rigid* to, const pli_rigid* from);

/* Nodes, links, faces, settings of the body that is walked over, without features. Reading makes it; NULL on error. */
pli_body* plii_file_body(plii_file* file, pli_world* world, pli_body* body);
/* What of it comes after its features. */
void plii_file_body_end(plii_file* file, pli_body* body);
/* Rigid bodies that it ignores. */
void plii_file_ignored_rigids(plii_file* file, pli_body* body);

/* Its features: which ones, and what they hold. Reading enables them. */
void plii_file_features(plii_file* file, pli_body* body);
/* After all bodies are read: what holds more than one number together. */
void plii_file_settle_features(plii_file* file, pli_body* body);
/* Of a body that is given up: its lists, which may be half read or not sound, hold nothing that its end would follow.
 */
void plii_file_empty_features(pli_body* body);
/* After pointers have changed: what follows from them, and callbacks of the body that had the same features before. */
void plii_file_take_over(pli_body* body, const pli_body* before);
