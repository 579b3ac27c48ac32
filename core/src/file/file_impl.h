#pragma once

/* Files of worlds: little-endian numbers. One walk counts, writes, reads and re-points, so that these cannot differ. */

#include "body/world_state.h"
#include "pliant/world_file.h"

typedef enum plii_file_mode {
    PLII_FILE_COUNT,
    PLII_FILE_WRITE,
    PLII_FILE_READ,
    PLII_FILE_REPOINT /* what was read, from the bodies it was read for to others */
} plii_file_mode;

/* A walk over a file, or over a world that becomes one. */
typedef struct plii_file {
    plii_file_mode mode;
    pli_context* context;
    const char* function;
    pli_world_file_def def;
    /* What pointers are counted in. */
    pli_body* const* bodies;
    pli_rigid* const* rigids;
    int body_count, rigid_count;
    pli_body* const* to_bodies; /* where they lead: to the same, but for REPOINT */
    pli_rigid* const* to_rigids;
    const pli_body* body; /* that is walked over, or NULL */
    int body_index;       /* of it, for messages */
    int rigid_index;      /* of the rigid body that is walked over */
    const char* what;     /* is walked over, for messages */
    unsigned char* to;
    const unsigned char* from;
    size_t at, size; /* bytes; of the whole file */
    pli_status status;
} plii_file;

/* What is walked over from now on; for messages, and for those who want to know. */
void plii_file_begin_part(plii_file* file, const char* part);
/* The first error stays. */
PLII_COLD void plii_file_refuse(plii_file* file, const char* problem);
/* What a call gave, which is an error of the file unless it is the lack of memory; whether it is none. */
bool plii_file_is_made(plii_file* file, pli_status status, const char* problem);
/* Another error, with its message; returns it. */
#define PLII_FILE_FAIL(file, error, ...)                                                                               \
    ((file)->status = plii_fail((file)->context, error, (file)->function, __VA_ARGS__))

/* Bytes of a number, least significant first. */
void plii_file_number(plii_file* file, void* number, size_t size);
static inline uint32_t plii_file_u32(plii_file* file, uint32_t number) {
    plii_file_number(file, &number, sizeof number);
    return number;
}
static inline uint64_t plii_file_u64(plii_file* file, uint64_t number) {
    plii_file_number(file, &number, sizeof number);
    return number;
}
/* How many things follow, of which each has `bytes` at least: what is read is no more than there are. */
int plii_file_count(plii_file* file, int count, size_t bytes);

/* What something is, for pointers that are only compared, and shapes that are shared: where it is first. */
typedef enum plii_file_identity_kind {
    PLII_FILE_NOTHING,
    PLII_FILE_RIGID,
    PLII_FILE_BODY,
    PLII_FILE_SHAPE
} plii_file_identity_kind;
typedef struct plii_file_identity {
    plii_file_identity_kind kind;
    uint32_t index, shape; /* of the body or rigid body; of its shapes */
} plii_file_identity;
plii_file_identity plii_file_identify(const plii_file* file, const void* pointer);

/* Structs by the letters of their members (body/feature.h). */
void plii_file_fields(plii_file* file, const char* fields, void* element);
void plii_file_parts(plii_file* file, const plii_state_part* parts, void* element); /* those that are kept */
static inline bool plii_file_is_kept(const char* fields, plii_snapshot_share share) {
    return fields != NULL && share != PLII_LEFT;
}
void plii_file_elements(plii_file* file, const char* fields, void* elements, size_t count, size_t element_size);
/* Bytes that such a struct has in a file. */
size_t plii_file_packed_size(const char* fields);

/* What a file of a world consists of. Each function counts, writes, reads or re-points what it is named after; in
   PLII_FILE_READ bodies and rigid bodies are made, in the world of the call. */

/* Of all bytes after the header, for its last eight. */
enum { PLII_FILE_HEADER_SIZE = 32 };
uint64_t plii_file_checksum(const unsigned char* bytes, size_t size);

/* Rigid body `index` of the file: shapes and state. Reading takes the shapes of `source`; NULL: it makes them. */
void plii_file_rigid(plii_file* file, pli_world* world, int index, const pli_rigid* source);
/* What of it comes after all bodies. */
void plii_file_rigid_end(plii_file* file, pli_rigid* rigid);
/* The state again, from one rigid body to another. */
void plii_file_copy_rigid(pli_rigid* to, const pli_rigid* from);

/* Nodes, links, faces, settings of the body that is walked over, without features. Reading makes it. */
void plii_file_body(plii_file* file, pli_world* world, pli_body* body);
/* What of it comes after its features. */
void plii_file_body_end(plii_file* file, pli_body* body);

/* Rigid bodies that it ignores, and its features: which ones, and what they hold. Reading enables them. */
void plii_file_features(plii_file* file, pli_body* body);
/* After all bodies are read: what holds more than one number together. */
void plii_file_settle_features(plii_file* file, pli_body* body);
/* Of a body that is given up: its lists, which may not be sound, hold nothing that its end would follow. */
void plii_file_empty_features(pli_body* body);
/* After pointers have changed: what follows from them, and callbacks of the body that had the same features before. */
void plii_file_take_over(pli_body* body, const pli_body* before);
