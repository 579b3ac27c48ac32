/* Numbers of files, and structs by the letters of their members. */

#include "file/file_impl.h"

#include "cluster/joint_impl.h"

#include <ctype.h>
#include <stdio.h>

void plii_file_refuse(plii_file* file, const char* problem) {
    if (file->status != PLI_OK) { return; }
    char of_body[32] = "";
    if (file->body_index != PLI_NULL_INDEX) { snprintf(of_body, sizeof of_body, "body %d: ", file->body_index); }
    file->status = plii_fail(file->context, PLI_ERROR_FILE_FORMAT, file->function, "%s%s: %s, before byte %zu", of_body,
                             file->what != NULL ? file->what : "the world", problem, file->at);
}

bool plii_file_is_made(plii_file* file, pli_status status, const char* problem) {
    if (status == PLI_ERROR_OUT_OF_MEMORY) { file->status = status; }
    if (status != PLI_OK) { plii_file_refuse(file, problem); }
    return status == PLI_OK;
}
void plii_file_begin_part(plii_file* file, const char* part) {
    file->what = part;
    if (file->mode == PLII_FILE_WRITE && file->def.begin_part != NULL) {
        file->def.begin_part(part, file->body_index, file->at, file->def.user);
    }
}

// -------------------------------------------------------------------------------------------------------- numbers

static void file_copy_number(unsigned char* to, const unsigned char* from, size_t size) {
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    for (size_t i = 0; i < size; ++i) {
        to[i] = from[size - 1 - i];
    }
#else
    memcpy(to, from, size);
#endif
}

void plii_file_number(plii_file* file, void* number, size_t size) {
    if (file->status != PLI_OK || file->mode == PLII_FILE_REPOINT) { return; }
    if (file->mode == PLII_FILE_WRITE) { file_copy_number(file->to + file->at, number, size); }
    if (file->mode == PLII_FILE_READ) {
        if (size > file->size - file->at) {
            plii_file_refuse(file, "the file ends in the middle");
            return;
        }
        file_copy_number(number, file->from + file->at, size);
    }
    file->at += size;
}

int plii_file_count(plii_file* file, int count, size_t bytes) {
    const uint32_t read = plii_file_u32(file, (uint32_t)count);
    if (file->mode != PLII_FILE_READ) { return count; }
    if (file->status == PLI_OK && (read > INT32_MAX || read > (file->size - file->at) / bytes)) {
        plii_file_refuse(file, "it has more than the file has room for");
    }
    return file->status == PLI_OK ? (int)read : 0;
}

// ------------------------------------------------------------------------------------------------------- pointers

/* PLI_NULL_INDEX: it is not there. One that may be gone must not be looked into. */
static int file_find_body(const plii_file* file, const pli_body* body, bool may_be_gone) {
    for (int i = may_be_gone || body == NULL ? 0 : body->world_index; i < file->body_count && body != NULL; ++i) {
        if (file->bodies[i] == body) { return i; }
    }
    return PLI_NULL_INDEX;
}

/* The index of what is found, of so many, + 1; 0: none. */
static int file_index(plii_file* file, int found, int count) {
    if (file->mode == PLII_FILE_REPOINT) { return found; }
    const uint32_t index1 = plii_file_u32(file, (uint32_t)(found + 1));
    if (file->mode == PLII_FILE_READ && index1 > (uint32_t)count) {
        plii_file_refuse(file, "an index is out of range");
        return PLI_NULL_INDEX;
    }
    return (int)index1 - 1;
}

static const void* file_body_pointer(plii_file* file, const void* body, bool may_be_gone) {
    const int found = file->mode != PLII_FILE_READ ? file_find_body(file, body, may_be_gone) : PLI_NULL_INDEX;
    if (body != NULL && file->mode != PLII_FILE_READ && found == PLI_NULL_INDEX && !may_be_gone) {
        plii_file_refuse(file, "a body is not of this world");
    }
    const int index = file_index(file, found, file->body_count);
    return index != PLI_NULL_INDEX ? file->to_bodies[index] : NULL;
}

static const void* file_rigid_pointer(plii_file* file, const pli_rigid* rigid, bool may_be_null) {
    const bool is_known = file->mode != PLII_FILE_READ && rigid != NULL && rigid->world_index < file->rigid_count;
    const int found = is_known && file->rigids[rigid->world_index] == rigid ? rigid->world_index : PLI_NULL_INDEX;
    const int index = file_index(file, found, file->rigid_count);
    if (index != PLI_NULL_INDEX) { return file->to_rigids[index]; }
    if (file->mode == PLII_FILE_READ && !may_be_null) { plii_file_refuse(file, "a rigid body is missing"); }
    return NULL;
}

plii_file_identity plii_file_identify(const plii_file* file, const void* pointer) {
    const int body = file_find_body(file, pointer, true);
    if (body != PLI_NULL_INDEX) { return (plii_file_identity){PLII_FILE_BODY, (uint32_t)body, 0}; }
    for (int i = 0; i < file->rigid_count && pointer != NULL; ++i) {
        const pli_rigid* rigid = file->rigids[i];
        if (rigid == pointer) { return (plii_file_identity){PLII_FILE_RIGID, (uint32_t)i, 0}; }
        for (int k = 0; k < rigid->shape_count; ++k) {
            if (rigid->shapes[k] == pointer) { return (plii_file_identity){PLII_FILE_SHAPE, (uint32_t)i, (uint32_t)k}; }
        }
    }
    return (plii_file_identity){PLII_FILE_NOTHING, 0, 0}; /* gone */
}

static const void* file_find_identity(plii_file* file, plii_file_identity identity) {
    const bool is_body = identity.kind == PLII_FILE_BODY;
    if (identity.kind == PLII_FILE_NOTHING) { return NULL; }
    if (identity.index < (uint32_t)(is_body ? file->body_count : file->rigid_count)) {
        if (is_body) { return file->to_bodies[identity.index]; }
        const pli_rigid* rigid = file->to_rigids[identity.index];
        if (identity.kind == PLII_FILE_RIGID) { return rigid; }
        const bool is_shape = identity.kind == PLII_FILE_SHAPE && identity.shape < (uint32_t)rigid->shape_count;
        if (is_shape) { return rigid->shapes[identity.shape]; }
    }
    plii_file_refuse(file, "an index is out of range");
    return NULL;
}

static const void* file_compared_pointer(plii_file* file, const void* pointer) {
    plii_file_identity identity = {PLII_FILE_NOTHING, 0, 0};
    if (file->mode != PLII_FILE_READ) { identity = plii_file_identify(file, pointer); }
    plii_file_fields(file, "3u", &identity);
    const bool is_wanted = file->mode >= PLII_FILE_READ && file->status == PLI_OK;
    return is_wanted ? file_find_identity(file, identity) : NULL;
}

static const void* file_joint_class(plii_file* file, const void* klass) {
    const plii_joint_class* const classes[] = {&plii_linear_joint_class, &plii_angular_joint_class};
    if (file->mode == PLII_FILE_REPOINT) { return klass; }
    const uint32_t index = plii_file_u32(file, klass == classes[1]);
    if (index > 1) { plii_file_refuse(file, "there is no such kind of joint"); }
    return classes[index == 1];
}

/* Only reading and re-pointing change where it leads. */
static void file_pointer(plii_file* file, char letter, void* at) {
    const void* pointer;
    memcpy(&pointer, at, sizeof pointer);
    if (letter == 'P' || letter == 'Q') {
        pointer = file_body_pointer(file, pointer, letter == 'Q');
    } else if (letter == 'R' || letter == 'S') {
        pointer = file_rigid_pointer(file, pointer, letter == 'R');
    } else {
        pointer = letter == 'O' ? file_compared_pointer(file, pointer) : file_joint_class(file, pointer);
    }
    if (file->mode >= PLII_FILE_READ) { memcpy(at, &pointer, sizeof pointer); }
}

// --------------------------------------------------------------------------------------------------------- structs

/* Of one, in memory and in a file; 0: there is no such letter. */
typedef struct file_letter_kind {
    unsigned char size, packed;
    bool is_pointer;
} file_letter_kind;

static file_letter_kind file_letter_kind_of(char c) {
    if (strchr("nNFHLfgiue", c) != NULL) { return (file_letter_kind){4, 4, false}; }
    if (c == 'B') { return (file_letter_kind){sizeof(bool), sizeof(bool), false}; }
    if (c == 'h') { return (file_letter_kind){2, 2, false}; }
    if (c == 'd' || c == 'U') { return (file_letter_kind){8, 8, false}; }
    if (c == 'O') { return (file_letter_kind){sizeof(void*), 12, true}; }
    if (strchr("PQRSJ", c) != NULL) { return (file_letter_kind){sizeof(void*), 4, true}; }
    if (c == 'X' || c == '|') { return (file_letter_kind){sizeof(void*), 0, false}; }
    return (file_letter_kind){c == '*', 0, false};
}

typedef struct file_letter {
    char letter;
    int count;   /* how often */
    int largest; /* of 'e' */
    file_letter_kind kind;
} file_letter;

static int file_read_digits(const char** fields) {
    int number = 0;
    while (isdigit((unsigned char)**fields)) {
        number = 10 * number + (*(*fields)++ - '0');
    }
    return number;
}

static file_letter file_next_letter(const char** fields) {
    const bool has_count = isdigit((unsigned char)**fields);
    file_letter next = {.count = has_count ? file_read_digits(fields) : 1};
    next.letter = *(*fields)++;
    next.kind = file_letter_kind_of(next.letter);
    if (next.letter == '|') { next.count = 0; }
    if (next.letter == 'e') { next.largest = file_read_digits(fields); }
    return next;
}

size_t plii_file_packed_size(const char* fields) {
    size_t size = 0;
    while (*fields != '\0') {
        const file_letter next = file_next_letter(&fields);
        size += (size_t)next.count * next.kind.packed;
    }
    return size;
}

static void file_check(plii_file* file, const file_letter* letter, const void* at) {
    union {
        float f;
        double d;
        unsigned char truth;
        int index;
    } value;
    memcpy(&value, at, letter->kind.size);
    const char which = letter->letter;
    if ((which == 'f' && !(value.f == value.f)) || (which == 'd' && !(value.d == value.d))) {
        plii_file_refuse(file, "something is not a number");
    }
    if (which == 'B' && value.truth > 1) { plii_file_refuse(file, "something is neither true nor false"); }
    if (strchr("nNFHLe", which) == NULL) { return; }
    const int low = strchr("NHL", which) != NULL ? -1 : 0;
    int high = letter->largest; /* of 'e' */
    if (which == 'n' || which == 'N') { high = file->body->node_count - 1; }
    if (which == 'F' || which == 'H') { high = file->body->topology->face_count - 1; }
    if (which == 'L') { high = file->body->link_count - 1; }
    if (value.index < low || value.index > high) { plii_file_refuse(file, "an index is out of range"); }
}

/* What is wrong becomes zero, which fits everything, so that nothing wrong is ever there. */
static void file_value(plii_file* file, const file_letter* letter, unsigned char* at) {
    if (letter->kind.is_pointer) {
        file_pointer(file, letter->letter, at);
        return;
    }
    plii_file_number(file, at, letter->kind.size);
    if (file->mode != PLII_FILE_READ) { return; }
    if (file->status == PLI_OK) { file_check(file, letter, at); }
    if (file->status != PLI_OK) { memset(at, 0, letter->kind.size); }
}

void plii_file_fields(plii_file* file, const char* fields, void* element) {
    unsigned char* bytes = element;
    size_t offset = 0;
    while (*fields != '\0' && file->status == PLI_OK) {
        const file_letter letter = file_next_letter(&fields);
        if (letter.letter == '*') { return; }
        offset = (offset + letter.kind.size - 1) / letter.kind.size * letter.kind.size; /* aligned */
        for (int i = 0; i < letter.count && letter.letter != 'X'; ++i) {
            file_value(file, &letter, bytes + offset + (size_t)i * letter.kind.size);
        }
        offset += (size_t)letter.count * letter.kind.size;
    }
}

void plii_file_parts(plii_file* file, const plii_state_part* parts, void* element) {
    for (const plii_state_part* part = parts; part != NULL && part->size > 0; ++part) {
        if (!plii_file_is_kept(part->fields, part->snapshot)) { continue; }
        plii_file_fields(file, part->fields, (unsigned char*)element + part->offset);
    }
}

void plii_file_elements(plii_file* file, const char* fields, void* elements, size_t count, size_t element_size) {
    if (file->mode == PLII_FILE_COUNT) {
        file->at += count * plii_file_packed_size(fields);
        return;
    }
    if (file->mode == PLII_FILE_REPOINT && strpbrk(fields, "PQRSO") == NULL) { return; }
    for (size_t i = 0; i < count && file->status == PLI_OK; ++i) {
        plii_file_fields(file, fields, (unsigned char*)elements + i * element_size);
    }
}
