#pragma once

/* Files of worlds: numbers, one after the other, little-endian. One walk counts, writes, reads and re-points, so that
   these cannot differ. */

#include "body/world_state.h"

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
    /* What pointers are counted in. */
    pli_body* const* bodies;
    pli_rigid* const* rigids;
    int body_count, rigid_count;
    const pli_world* new_world; /* REPOINT: where they lead then */
    pli_rigid* const* new_rigids;
    const pli_body* body; /* that is walked over, or NULL */
    int body_index;       /* of it, for messages */
    int rigid_index;      /* likewise */
    const char* what;     /* is walked over, for messages */
    /* In WRITE, or NULL. */
    void (*begin_part)(const char* part, int body, size_t offset, void* user);
    void* begin_user;
    unsigned char* to;
    const unsigned char* from;
    size_t at, size; /* bytes; of the whole file */
    pli_status status;
} plii_file;

/* What is walked over from now on; for messages, and for those who want to know. */
void plii_file_begin_part(plii_file* file, const char* part);
/* The first error stays. */
PLII_COLD void plii_file_refuse(plii_file* file, const char* problem);
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

/* Structs by the letters of their members (body/feature.h). */
void plii_file_fields(plii_file* file, const char* fields, void* element);
void plii_file_parts(plii_file* file, const plii_state_part* parts, void* element);
void plii_file_elements(plii_file* file, const char* fields, void* elements, size_t count, size_t element_size);
/* Bytes that such a struct has in a file, and in memory; 0 in memory: `fields` has a letter that there is not. */
size_t plii_file_packed_size(const char* fields);
size_t plii_file_struct_size(const char* fields, size_t size);
