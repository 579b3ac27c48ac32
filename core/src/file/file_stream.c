/* Numbers of files, and structs by the letters of their members. */

#include "file/file_stream.h"

#include "cluster/joint_impl.h"

#include <ctype.h>
#include <string.h>

void plii_file_refuse(plii_file* file, const char* problem) {
    if (file->status != PLI_OK) { return; }
    const char* what = file->what != NULL ? file->what : "the world";
    file->status = file->body_index == PLI_NULL_INDEX
                       ? plii_fail(file->context, PLI_ERROR_FILE_FORMAT, file->function, "%s: %s, before byte %zu",
                                   what, problem, file->at)
                       : plii_fail(file->context, PLI_ERROR_FILE_FORMAT, file->function,
                                   "body %d: %s: %s, before byte %zu", file->body_index, what, problem, file->at);
}

void plii_file_begin_part(plii_file* file, const char* part) {
    file->what = part;
    if (file->begin_part != NULL) { file->begin_part(part, file->body_index, file->at, file->begin_user); }
}

// -------------------------------------------------------------------------------------------------------- numbers

static bool file_is_little_endian(void) {
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static void file_copy_number(unsigned char* to, const unsigned char* from, size_t size) {
    if (file_is_little_endian()) {
        memcpy(to, from, size);
        return;
    }
    for (size_t i = 0; i < size; ++i) {
        to[i] = from[size - 1 - i];
    }
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

static void file_read_index(plii_file* file, int64_t index, int64_t end, int64_t* used) {
    const bool is_good = index >= 0 && index < end;
    if (!is_good) { plii_file_refuse(file, "an index is out of range"); }
    *used = is_good ? index : 0;
}

/* Index + 1 in the list, 0: none. */
static void file_body_pointer(plii_file* file, pli_body** body, bool may_be_gone) {
    uint32_t index1 = 0;
    if (file->mode != PLII_FILE_READ && *body != NULL) {
        /* One that may be gone must not be looked into. */
        int i = may_be_gone ? 0 : (*body)->world_index;
        while (i < file->body_count && file->bodies[i] != *body) {
            ++i;
        }
        index1 = i < file->body_count ? (uint32_t)i + 1 : 0;
        if (!may_be_gone && index1 == 0) { plii_file_refuse(file, "a body is not of this world"); }
    }
    if (file->mode == PLII_FILE_REPOINT) {
        *body = index1 > 0 ? file->new_world->bodies[index1 - 1] : NULL;
        return;
    }
    index1 = plii_file_u32(file, index1);
    if (file->mode != PLII_FILE_READ || file->status != PLI_OK) { return; }
    int64_t index = 0;
    if (index1 > 0) { file_read_index(file, (int64_t)index1 - 1, file->body_count, &index); }
    *body = index1 > 0 && file->status == PLI_OK ? file->bodies[index] : NULL;
}

static int file_find_rigid(const plii_file* file, const pli_rigid* rigid) {
    const bool is_of_world = rigid != NULL && rigid->world_index < file->rigid_count;
    return is_of_world && file->rigids[rigid->world_index] == rigid ? rigid->world_index : PLI_NULL_INDEX;
}

static void file_rigid_pointer(plii_file* file, pli_rigid** rigid, bool may_be_null) {
    const int found = file->mode != PLII_FILE_READ ? file_find_rigid(file, *rigid) : PLI_NULL_INDEX;
    if (file->mode == PLII_FILE_REPOINT) {
        *rigid = found != PLI_NULL_INDEX ? file->new_rigids[found] : NULL;
        return;
    }
    const uint32_t index1 = plii_file_u32(file, (uint32_t)(found + 1));
    if (file->mode != PLII_FILE_READ || file->status != PLI_OK) { return; }
    int64_t index = 0;
    if (index1 > 0) { file_read_index(file, (int64_t)index1 - 1, file->rigid_count, &index); }
    if (index1 == 0 && !may_be_null) { plii_file_refuse(file, "a rigid body is missing"); }
    *rigid = index1 > 0 && file->status == PLI_OK ? file->rigids[index] : NULL;
}

/* What is only compared. */
typedef enum file_identity_kind { FILE_NOTHING, FILE_RIGID, FILE_BODY, FILE_SHAPE } file_identity_kind;
typedef struct file_identity {
    file_identity_kind kind;
    uint32_t index, shape; /* of the body or rigid body; of its shapes */
} file_identity;

static file_identity file_identify(const plii_file* file, const void* pointer) {
    if (pointer == NULL) { return (file_identity){FILE_NOTHING, 0, 0}; }
    for (int i = 0; i < file->body_count; ++i) {
        if (file->bodies[i] == pointer) { return (file_identity){FILE_BODY, (uint32_t)i, 0}; }
    }
    for (int i = 0; i < file->rigid_count; ++i) {
        const pli_rigid* rigid = file->rigids[i];
        if (rigid == pointer) { return (file_identity){FILE_RIGID, (uint32_t)i, 0}; }
        for (int k = 0; k < rigid->shape_count; ++k) {
            if (rigid->shapes[k] == pointer) { return (file_identity){FILE_SHAPE, (uint32_t)i, (uint32_t)k}; }
        }
    }
    return (file_identity){FILE_NOTHING, 0, 0}; /* gone */
}

static const void* file_find_identity(plii_file* file, file_identity identity, pli_body* const* bodies,
                                      pli_rigid* const* rigids) {
    const bool is_body = identity.kind == FILE_BODY;
    if (identity.kind == FILE_NOTHING) { return NULL; }
    if (identity.kind > FILE_SHAPE || identity.index >= (uint32_t)(is_body ? file->body_count : file->rigid_count)) {
        plii_file_refuse(file, "an index is out of range");
        return NULL;
    }
    if (is_body) { return bodies[identity.index]; }
    const pli_rigid* rigid = rigids[identity.index];
    if (identity.kind == FILE_RIGID) { return rigid; }
    if (identity.shape >= (uint32_t)rigid->shape_count) {
        plii_file_refuse(file, "an index is out of range");
        return NULL;
    }
    return rigid->shapes[identity.shape];
}

static void file_compared_pointer(plii_file* file, const void** pointer) {
    file_identity identity = {FILE_NOTHING, 0, 0};
    if (file->mode != PLII_FILE_READ) { identity = file_identify(file, *pointer); }
    if (file->mode == PLII_FILE_REPOINT) {
        *pointer = file_find_identity(file, identity, file->new_world->bodies, file->new_rigids);
        return;
    }
    identity.kind = (file_identity_kind)plii_file_u32(file, (uint32_t)identity.kind);
    identity.index = plii_file_u32(file, identity.index);
    identity.shape = plii_file_u32(file, identity.shape);
    if (file->mode == PLII_FILE_READ && file->status == PLI_OK) {
        *pointer = file_find_identity(file, identity, file->bodies, file->rigids);
    }
}

static void file_joint_class(plii_file* file, const plii_joint_class** klass) {
    const plii_joint_class* const classes[] = {&plii_linear_joint_class, &plii_angular_joint_class};
    if (file->mode == PLII_FILE_REPOINT) { return; }
    const uint32_t index = plii_file_u32(file, *klass == classes[1]);
    if (file->mode != PLII_FILE_READ) { return; }
    if (index > 1) { plii_file_refuse(file, "there is no such kind of joint"); }
    *klass = classes[index == 1];
}

static void file_pointer(plii_file* file, char letter, void* at) {
    void* pointer;
    memcpy(&pointer, at, sizeof pointer);
    if (letter == 'P' || letter == 'Q') {
        pli_body* body = pointer;
        file_body_pointer(file, &body, letter == 'Q');
        pointer = body;
    } else if (letter == 'R' || letter == 'S') {
        pli_rigid* rigid = pointer;
        file_rigid_pointer(file, &rigid, letter == 'R');
        pointer = rigid;
    } else if (letter == 'O') {
        const void* compared = pointer;
        file_compared_pointer(file, &compared);
        pointer = (void*)(uintptr_t)compared;
    } else {
        const plii_joint_class* klass = pointer;
        file_joint_class(file, &klass);
        pointer = (void*)(uintptr_t)klass;
    }
    memcpy(at, &pointer, sizeof pointer);
}

// --------------------------------------------------------------------------------------------------------- structs

typedef struct file_letter {
    char letter;
    int count;     /* how often */
    int largest;   /* of 'e' */
    size_t size;   /* of one, in memory; 0: there is no such letter */
    size_t packed; /* in a file */
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
    switch (next.letter) {
    case 'B':
        next.size = next.packed = sizeof(bool);
        break;
    case '|':
        next.count = 0;
        next.size = sizeof(void*);
        break;
    case 'X':
        next.size = sizeof(void*);
        break;
    case '*':
        next.size = 1;
        break;
    case 'd':
    case 'U':
        next.size = next.packed = 8;
        break;
    case 'O':
        next.size = sizeof(void*), next.packed = 12;
        break;
    case 'P':
    case 'Q':
    case 'R':
    case 'S':
    case 'J':
        next.size = sizeof(void*), next.packed = 4;
        break;
    case 'e':
        next.largest = file_read_digits(fields);
        next.size = next.packed = 4;
        break;
    default:
        next.size = next.packed = strchr("fgiunNFHL", next.letter) != NULL ? 4 : 0;
        break;
    }
    return next;
}

size_t plii_file_packed_size(const char* fields) {
    size_t size = 0;
    while (*fields != '\0') {
        const file_letter next = file_next_letter(&fields);
        size += (size_t)next.count * next.packed;
    }
    return size;
}

static size_t file_align(size_t offset, size_t size) {
    return (offset + size - 1) / size * size;
}

size_t plii_file_struct_size(const char* fields, size_t size) {
    size_t offset = 0, largest = 1;
    while (*fields != '\0') {
        const file_letter next = file_next_letter(&fields);
        if (next.size == 0) { return 0; }
        if (next.letter == '*') { return offset <= size ? size : 0; }
        offset = file_align(offset, next.size) + (size_t)next.count * next.size;
        largest = next.size > largest ? next.size : largest;
    }
    return file_align(offset, largest);
}

static void file_check_int(plii_file* file, char letter, int largest, int value) {
    const pli_body* body = file->body;
    int low = INT32_MIN, high = INT32_MAX;
    switch (letter) {
    case 'n':
        low = 0, high = body->node_count - 1;
        break;
    case 'N':
        low = -1, high = body->node_count - 1;
        break;
    case 'F':
        low = 0, high = body->topology->face_count - 1;
        break;
    case 'H':
        low = -1, high = body->topology->face_count - 1;
        break;
    case 'L':
        low = -1, high = body->link_count - 1;
        break;
    case 'e':
        low = 0, high = largest;
        break;
    default:
        break;
    }
    if (value < low || value > high) { plii_file_refuse(file, "an index is out of range"); }
}

static void file_check(plii_file* file, const file_letter* letter, const void* at) {
    if (letter->letter == 'f') {
        float value;
        memcpy(&value, at, sizeof value);
        if (!(value == value)) { plii_file_refuse(file, "something is not a number"); }
    } else if (letter->letter == 'd') {
        double value;
        memcpy(&value, at, sizeof value);
        if (!(value == value)) { plii_file_refuse(file, "something is not a number"); }
    } else if (letter->letter == 'B') {
        unsigned char value;
        memcpy(&value, at, 1);
        if (value > 1) { plii_file_refuse(file, "something is neither true nor false"); }
    } else if (letter->size == sizeof(int)) {
        int value;
        memcpy(&value, at, sizeof value);
        file_check_int(file, letter->letter, letter->largest, value);
    }
}

/* What is wrong becomes zero, which fits everything, so that nothing wrong is ever there. */
static void file_value(plii_file* file, const file_letter* letter, unsigned char* at) {
    if (strchr("PQRSOJ", letter->letter) != NULL) {
        file_pointer(file, letter->letter, at);
        return;
    }
    plii_file_number(file, at, letter->size);
    if (file->mode != PLII_FILE_READ) { return; }
    if (file->status == PLI_OK) { file_check(file, letter, at); }
    if (file->status != PLI_OK) { memset(at, 0, letter->size); }
}

void plii_file_fields(plii_file* file, const char* fields, void* element) {
    unsigned char* bytes = element;
    size_t offset = 0;
    while (*fields != '\0' && file->status == PLI_OK) {
        const file_letter letter = file_next_letter(&fields);
        if (letter.letter == '*') { return; }
        offset = file_align(offset, letter.size);
        for (int i = 0; i < letter.count && letter.letter != 'X'; ++i) {
            file_value(file, &letter, bytes + offset + (size_t)i * letter.size);
        }
        offset += (size_t)letter.count * letter.size;
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
