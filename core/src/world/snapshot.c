/* Snapshots: the memory that steps read and former steps or calls wrote, as it lies. One walk over the world does all
   four things, so that they cannot differ: counting bytes, writing, comparing and reading. What a feature has is said
   by its class: its state and its arrays, but for what is made anew. Bodies have parts of their own, which threads
   write, sum and read side by side. Large arrays begin on lines of the cache: copies between places that lie alike on
   these are faster (docs/experiments.md). */

#include "pliant/snapshot.h"

#include "base/checksum.h"
#include "base/ranges.h"
#include "body/feature_arrays.h"
#include "body/world_state.h"

#include <limits.h>
#include <stddef.h>
#include <string.h>

typedef enum snapshot_mode { SNAPSHOT_COUNT, SNAPSHOT_SAVE, SNAPSHOT_COMPARE, SNAPSHOT_RESTORE } snapshot_mode;

typedef struct snapshot_walk {
    snapshot_mode mode;
    pli_context* context;
    const char* function;
    int body;                  /* index of the one that is looked at, for messages */
    unsigned char* to;         /* SAVE */
    const unsigned char* from; /* COMPARE, RESTORE */
    size_t at;
    size_t end;    /* COMPARE, RESTORE */
    size_t summed; /* SAVE: what is before it is in the checksum */
    plii_checksum checksum;
    pli_status status;
} snapshot_walk;

/* The first bytes; records of the bodies follow, then what the world has beside them: the head. */
typedef struct snapshot_header {
    uint32_t magic, version;
    uint64_t checksum[2]; /* of what follows, to the end of the head */
    uint64_t size, head_size;
    uint64_t handle; /* of the world or body */
    uint64_t body_count;
    uint64_t zero;
} snapshot_header;

/* Of a body: where its part is, whole lines. */
typedef struct snapshot_record {
    uint64_t begin, end;
    uint64_t checksum[2];
} snapshot_record;

#define SNAPSHOT_MAGIC 0x706c6973u
#define SNAPSHOT_VERSION 4u
enum { SNAPSHOT_LARGE = 1024, SNAPSHOT_LINE = 64 };
_Static_assert(sizeof(snapshot_header) == SNAPSHOT_LINE && SNAPSHOT_LINE % PLII_CHECKSUM_BLOCK == 0, "");

// ----------------------------------------------------------------------------------------------------- the walk

static void snapshot_refuse(snapshot_walk* walk, const char* what, const char* feature) {
    if (walk->status != PLI_OK) { return; }
    const char *of = feature != NULL ? " of " : "", *name = feature != NULL ? feature : "";
    walk->status = walk->body == PLI_NULL_INDEX
                       ? plii_fail(walk->context, PLI_ERROR_INVALID_VALUE, walk->function,
                                   "the snapshot does not fit: %s%s%s", what, of, name)
                       : plii_fail(walk->context, PLI_ERROR_INVALID_VALUE, walk->function,
                                   "the snapshot does not fit: body %d: %s%s%s", walk->body, what, of, name);
}

static bool snapshot_has(snapshot_walk* walk, size_t size) {
    if (walk->mode < SNAPSHOT_COMPARE || walk->at + size <= walk->end) { return walk->status == PLI_OK; }
    if (walk->status == PLI_OK) {
        walk->status =
            plii_fail(walk->context, PLI_ERROR_FILE_FORMAT, walk->function, "the snapshot ends in the middle");
    }
    return false;
}

static void snapshot_sum(snapshot_walk* walk) {
    plii_checksum_add(&walk->checksum, walk->to + walk->summed, walk->at - walk->summed);
    walk->summed = walk->at;
}

/* To the next line. What is before it can be summed then: whole blocks. */
static void snapshot_align(snapshot_walk* walk) {
    const size_t gap = (SNAPSHOT_LINE - walk->at % SNAPSHOT_LINE) % SNAPSHOT_LINE;
    if (walk->mode == SNAPSHOT_SAVE) { memset(walk->to + walk->at, 0, gap); }
    walk->at += gap;
    if (walk->mode == SNAPSHOT_SAVE) { snapshot_sum(walk); }
}

/* Bytes that are taken over. */
static void snapshot_bytes(snapshot_walk* walk, void* block, size_t size) {
    if (size >= SNAPSHOT_LARGE) { snapshot_align(walk); }
    if (size == 0 || !snapshot_has(walk, size)) { return; }
    if (walk->mode == SNAPSHOT_RESTORE) {
        memcpy(block, walk->from + walk->at, size);
    } else if (walk->mode == SNAPSHOT_SAVE) {
        const size_t whole = size >= SNAPSHOT_LARGE ? size - size % PLII_CHECKSUM_BLOCK : 0;
        if (whole > 0) { plii_checksum_add_blocks(&walk->checksum, walk->to + walk->at, block, whole); }
        memcpy(walk->to + walk->at + whole, (const unsigned char*)block + whole, size - whole);
        walk->summed += whole;
    }
    walk->at += size;
}

/* A number; that of the snapshot where there is one. */
static uint64_t snapshot_number(snapshot_walk* walk, uint64_t number) {
    if (!snapshot_has(walk, sizeof number)) { return 0; }
    if (walk->mode == SNAPSHOT_SAVE) { memcpy(walk->to + walk->at, &number, sizeof number); }
    if (walk->mode >= SNAPSHOT_COMPARE) { memcpy(&number, walk->from + walk->at, sizeof number); }
    walk->at += sizeof number;
    return number;
}

/* Something that must be the same; `what` is what else is wrong. */
static void snapshot_same(snapshot_walk* walk, uint64_t number, const char* what, const char* feature) {
    const uint64_t saved = snapshot_number(walk, number);
    if (walk->status == PLI_OK && saved != number) { snapshot_refuse(walk, what, feature); }
}
#define SNAPSHOT_POINTER(pointer) ((uint64_t)(uintptr_t)(pointer))

// ------------------------------------------------------------------------------------------------------- features

static void snapshot_set_count(const plii_feature_array* array, void* state, int count) {
    if (array->count != 0) { memcpy((char*)state + array->count, &count, sizeof count); }
}

static void snapshot_list_of_feature(snapshot_walk* walk, pli_body* body, const plii_feature_class* klass,
                                     const plii_feature_array* array, void* state) {
    const size_t room = plii_feature_array_bytes(body, array, state) / array->element_size;
    int count = (int)room;
    if (array->count != 0) { memcpy(&count, (const char*)state + array->count, sizeof count); }
    const uint64_t saved = snapshot_number(walk, (uint64_t)count);
    if (walk->status != PLI_OK) { return; }
    if (saved > room) {
        snapshot_refuse(walk, "there is less memory than then for a list", klass->name);
        return;
    }
    snapshot_bytes(walk, plii_feature_array_address(body, array, state), (size_t)saved * array->element_size);
    if (walk->mode == SNAPSHOT_RESTORE) { snapshot_set_count(array, state, (int)saved); }
}

static void snapshot_array(snapshot_walk* walk, pli_body* body, const plii_feature_class* klass,
                           const plii_feature_array* array, void* state) {
    if (array->snapshot == PLII_LEFT && walk->mode == SNAPSHOT_RESTORE) { snapshot_set_count(array, state, 0); }
    if (array->snapshot != PLII_SAVED) { return; }
    if (array->length >= PLII_LIST) {
        snapshot_list_of_feature(walk, body, klass, array, state);
        return;
    }
    void* block = plii_feature_array_address(body, array, state);
    const size_t size = plii_feature_array_bytes(body, array, state);
    const bool was_there = snapshot_number(walk, block != NULL) != 0;
    if (walk->status != PLI_OK) { return; }
    if (walk->mode >= SNAPSHOT_COMPARE && was_there && block == NULL) {
        snapshot_refuse(walk, "an array is not there any more", klass->name);
    } else if (was_there) {
        snapshot_bytes(walk, block, size);
    } else if (walk->mode == SNAPSHOT_RESTORE && block != NULL) {
        memset(block, 0, size); /* as it is when it comes to be there */
    }
}

static void snapshot_part(snapshot_walk* walk, const plii_feature_class* klass, const plii_state_part* part,
                          void* state) {
    unsigned char* bytes = (unsigned char*)state + part->offset;
    if (part->snapshot == PLII_SAVED) { snapshot_bytes(walk, bytes, part->size); }
    if (part->snapshot != PLII_SAME || !snapshot_has(walk, part->size)) { return; }
    const bool differs = walk->mode >= SNAPSHOT_COMPARE && memcmp(bytes, walk->from + walk->at, part->size) != 0;
    snapshot_bytes(walk, bytes, part->size);
    if (differs) { snapshot_refuse(walk, "what it was made for has changed, the state", klass->name); }
}

static void snapshot_feature(snapshot_walk* walk, pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    void* state = feature->state;
    for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
        snapshot_part(walk, klass, part, state);
    }
    for (const plii_feature_array* array = klass->arrays; array != NULL && array->element_size > 0; ++array) {
        if (walk->status != PLI_OK) { return; }
        snapshot_array(walk, body, klass, array, state);
    }
    if (walk->mode == SNAPSHOT_RESTORE && klass->on_restored != NULL) { klass->on_restored(body, state); }
}

/* As it was made, when a call has made it since. */
static void snapshot_empty_feature(pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    unsigned char* state = feature->state;
    for (const plii_feature_array* array = klass->arrays; array->element_size > 0; ++array) {
        const size_t size = array->count == 0 ? plii_feature_array_bytes(body, array, state) : 0;
        snapshot_set_count(array, state, 0);
        if (size > 0) { memset(plii_feature_array_address(body, array, state), 0, size); }
    }
    for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
        memset(state + part->offset, 0, part->size);
    }
    if (klass->enable != NULL) { (void)klass->enable(body, state); }
}

// --------------------------------------------------------------------------------------------- bodies and the world

#define SNAPSHOT_MEMBER(walk, member) snapshot_bytes(walk, &(member), sizeof(member))
/* From one member to another, and what is between them. */
#define SNAPSHOT_MEMBERS(walk, type, object, first, last)                                                              \
    snapshot_bytes(walk, (char*)(object) + offsetof(type, first),                                                      \
                   offsetof(type, last) + sizeof((object)->last) - offsetof(type, first))

static void snapshot_body(snapshot_walk* walk, pli_body* body) {
    walk->body = body->world_index;
    snapshot_same(walk, SNAPSHOT_POINTER(body), "it is another body", NULL);
    snapshot_same(walk, body->length_revision, "it was cut or refined, or rest lengths were set", NULL);
    snapshot_same(walk, body->pipeline.revision, "features were enabled or disabled", NULL);
    snapshot_same(walk, SNAPSHOT_POINTER(body->solver_class), "it has another solver", NULL);
    snapshot_same(walk, (uint64_t)body->node_count, "it has another number of nodes", NULL);
    snapshot_same(walk, (uint64_t)body->material_count, "it has another number of materials", NULL);
    /* Masses are with the positions; what follows from them is made anew where they were others. */
    const bool is_same = snapshot_number(walk, body->link_revision) == body->link_revision;
    if (walk->mode == SNAPSHOT_RESTORE && !is_same) { body->link_revision += 1; }
    snapshot_bytes(walk, body->positions, plii_body_node_block_size(body)); /* previous and velocities, too */
    snapshot_bytes(walk, body->materials, (size_t)body->material_count * sizeof *body->materials);
    SNAPSHOT_MEMBERS(walk, pli_body, body, is_frozen, is_asleep);
    SNAPSHOT_MEMBER(walk, body->bounds);
    SNAPSHOT_MEMBERS(walk, pli_body, body, interval, sleep_group);
    const uint64_t ignored = snapshot_number(walk, (uint64_t)body->ignored_rigid_count);
    if (walk->mode >= SNAPSHOT_COMPARE && ignored > (uint64_t)body->ignored_rigid_capacity) {
        snapshot_refuse(walk, "there is less memory than then for rigid bodies that it ignores", NULL);
    }
    if (walk->status != PLI_OK) { return; }
    snapshot_bytes(walk, body->ignored_rigids, (size_t)ignored * sizeof(*body->ignored_rigids));
    if (walk->mode == SNAPSHOT_RESTORE) { body->ignored_rigid_count = (int)ignored; }
    const int count = body->pipeline.feature_count;
    const uint64_t saved = snapshot_number(walk, (uint64_t)count);
    for (int i = 0; i < count && walk->status == PLI_OK; ++i) {
        plii_feature* feature = &body->pipeline.features[i];
        if ((uint64_t)i < saved) {
            snapshot_feature(walk, body, feature);
        } else if (walk->mode == SNAPSHOT_RESTORE) {
            snapshot_empty_feature(body, feature);
        }
    }
    snapshot_align(walk);
}

static void snapshot_world(snapshot_walk* walk, pli_world* world) {
    snapshot_same(walk, world->revision, "bodies or rigid bodies have come or gone", NULL);
    SNAPSHOT_MEMBER(walk, world->def.gravity);
    SNAPSHOT_MEMBER(walk, world->def.air_density);
    SNAPSHOT_MEMBER(walk, world->dt);
    SNAPSHOT_MEMBER(walk, world->sleep_group);
    if (walk->status != PLI_OK) { return; }
    snapshot_bytes(walk, world->sweep, (size_t)world->body_count * sizeof(*world->sweep));
    if (walk->mode == SNAPSHOT_RESTORE) { world->event_count = 0; }
    for (PLII_EACH_RIGID(rigid, world)) {
        SNAPSHOT_MEMBERS(walk, pli_rigid, rigid, kind, rest_time);
        if (walk->mode != SNAPSHOT_RESTORE) { continue; }
        rigid->path.next = NULL;
        rigid->is_in_step = true;
        rigid->are_shapes_placed = false;
    }
}

// --------------------------------------------------------------------------------------------------- head and parts

/* What a snapshot is of, and where its bytes are. Walks write only where they restore. */
typedef struct snapshot_subject {
    pli_context* context;
    const char* function;
    pli_world* world; /* NULL: of one body */
    pli_body* const* bodies;
    int body_count;
    unsigned char* to;         /* of a save */
    const unsigned char* from; /* of a restore */
    size_t size;
} snapshot_subject;

static uint64_t snapshot_handle(const snapshot_subject* subject) {
    return subject->world != NULL ? SNAPSHOT_POINTER(subject->world) : SNAPSHOT_POINTER(subject->bodies[0]);
}

static snapshot_walk snapshot_walk_of(const snapshot_subject* subject, snapshot_mode mode, size_t begin, size_t end) {
    return (snapshot_walk){.mode = mode,
                           .context = subject->context,
                           .function = subject->function,
                           .body = PLI_NULL_INDEX,
                           .to = subject->to,
                           .from = subject->from,
                           .at = begin,
                           .end = end,
                           .summed = begin};
}

static size_t snapshot_record_at(int index) {
    return sizeof(snapshot_header) + (size_t)index * sizeof(snapshot_record);
}
static snapshot_record snapshot_record_of(const unsigned char* bytes, int index) {
    snapshot_record record;
    memcpy(&record, bytes + snapshot_record_at(index), sizeof record);
    return record;
}

/* The walk after what the world has beside its bodies. `end`: COMPARE, RESTORE. */
static snapshot_walk snapshot_walk_head(const snapshot_subject* subject, snapshot_mode mode, size_t end) {
    snapshot_walk walk = snapshot_walk_of(subject, mode, snapshot_record_at(subject->body_count), end);
    if (subject->world != NULL) { snapshot_world(&walk, subject->world); }
    snapshot_align(&walk);
    return walk;
}

/* Of all bytes from the checksum on to the end of the head. */
static void snapshot_sum_head(const unsigned char* bytes, size_t head_size, uint64_t sums[2]) {
    const size_t begin = offsetof(snapshot_header, size);
    plii_checksum checksum = {0};
    plii_checksum_add(&checksum, bytes + begin, head_size - begin);
    plii_checksum_end(&checksum, sums);
}

/* Bodies that are worth a thread: ten bytes are copied in a nanosecond. */
static int snapshot_grain(const snapshot_subject* subject, int body_count) {
    const size_t nanoseconds = subject->size / 10 / ((size_t)body_count + 1);
    return plii_grain(nanoseconds < PLII_PART_NANOSECONDS ? (int)nanoseconds + 1 : PLII_PART_NANOSECONDS);
}

static void snapshot_run(const snapshot_subject* subject, pli_range_fn* range) {
    const int count = subject->body_count;
    plii_parallel_for(subject->context, range, (void*)(uintptr_t)subject, count, snapshot_grain(subject, count));
}

// ------------------------------------------------------------------------------------------------------------- save

/* All bytes; with a buffer the records that fit. */
static size_t snapshot_lay_out(const snapshot_subject* subject) {
    snapshot_walk walk = snapshot_walk_head(subject, SNAPSHOT_COUNT, 0);
    for (int i = 0; i < subject->body_count; ++i) {
        snapshot_record record = {.begin = walk.at};
        snapshot_body(&walk, subject->bodies[i]);
        record.end = walk.at;
        const size_t at = snapshot_record_at(i);
        if (subject->to != NULL && at + sizeof record <= subject->size) {
            memcpy(subject->to + at, &record, sizeof record);
        }
    }
    return walk.at;
}

static void snapshot_save_range(int begin, int end, void* task) {
    const snapshot_subject* subject = task;
    for (int i = begin; i < end; ++i) {
        snapshot_record record = snapshot_record_of(subject->to, i);
        snapshot_walk walk = snapshot_walk_of(subject, SNAPSHOT_SAVE, record.begin, 0);
        snapshot_body(&walk, subject->bodies[i]);
        plii_checksum_end(&walk.checksum, record.checksum);
        memcpy(subject->to + snapshot_record_at(i), &record, sizeof record);
    }
}

static pli_status snapshot_save(snapshot_subject subject, size_t* size) {
    const size_t capacity = subject.size;
    subject.size = subject.to != NULL ? capacity : 0;
    const size_t needed = snapshot_lay_out(&subject);
    if (size != NULL) { *size = needed; }
    if (subject.to == NULL) {
        return plii_fail(subject.context, PLI_ERROR_NULL_ARGUMENT, subject.function, "buffer is null");
    }
    if (needed > capacity) {
        return plii_fail(subject.context, PLI_ERROR_INVALID_VALUE, subject.function,
                         "capacity is %zu, the snapshot has %zu bytes", capacity, needed);
    }
    subject.size = needed;
    const snapshot_walk head = snapshot_walk_head(&subject, SNAPSHOT_SAVE, 0);
    snapshot_run(&subject, snapshot_save_range);
    snapshot_header header = {.magic = SNAPSHOT_MAGIC,
                              .version = SNAPSHOT_VERSION,
                              .size = needed,
                              .head_size = head.at,
                              .handle = snapshot_handle(&subject),
                              .body_count = (uint64_t)subject.body_count};
    memcpy(subject.to, &header, sizeof header);
    snapshot_sum_head(subject.to, head.at, header.checksum);
    memcpy(subject.to, &header, sizeof header);
    return PLI_OK;
}

// ---------------------------------------------------------------------------------------------------------- restore

/* How many parts are other bytes than were summed. */
static double snapshot_damaged_parts(int begin, int end, const void* task) {
    const snapshot_subject* subject = task;
    int count = 0;
    for (int i = begin; i < end; ++i) {
        const snapshot_record record = snapshot_record_of(subject->from, i);
        plii_checksum checksum = {0};
        uint64_t sums[2] = {0};
        if (record.begin <= record.end && record.end <= subject->size) {
            plii_checksum_add(&checksum, subject->from + record.begin, record.end - record.begin);
            plii_checksum_end(&checksum, sums);
        }
        count += memcmp(sums, record.checksum, sizeof sums) != 0;
    }
    return count;
}

static bool snapshot_is_whole(const snapshot_subject* subject, const snapshot_header* header) {
    if (header->head_size > subject->size || header->body_count > INT_MAX ||
        header->head_size < snapshot_record_at((int)header->body_count)) {
        return false;
    }
    uint64_t sums[2];
    snapshot_sum_head(subject->from, header->head_size, sums);
    const int count = (int)header->body_count, grain = snapshot_grain(subject, count);
    return memcmp(sums, header->checksum, sizeof sums) == 0 &&
           plii_sum_blocks(subject->context, count, grain, snapshot_damaged_parts, subject) == 0.0;
}

static pli_status snapshot_check(const snapshot_subject* subject, snapshot_header* header) {
    pli_context* context = subject->context;
    const char* function = subject->function;
    memset(header, 0, sizeof *header);
    if (subject->size >= sizeof *header) { memcpy(header, subject->from, sizeof *header); }
    if (header->magic != SNAPSHOT_MAGIC) {
        return plii_fail(context, PLI_ERROR_FILE_FORMAT, function, "the %zu bytes are no snapshot", subject->size);
    }
    if (header->version != SNAPSHOT_VERSION) {
        return plii_fail(context, PLI_ERROR_FILE_FORMAT, function, "the snapshot is of version %u, this is %u",
                         (unsigned)header->version, SNAPSHOT_VERSION);
    }
    if (header->size != subject->size) {
        return plii_fail(context, PLI_ERROR_FILE_FORMAT, function, "the snapshot has %llu bytes, %zu were given",
                         (unsigned long long)header->size, subject->size);
    }
    if (!snapshot_is_whole(subject, header)) {
        return plii_fail(context, PLI_ERROR_FILE_FORMAT, function, "the snapshot is damaged: its checksum is wrong");
    }
    if (header->handle != snapshot_handle(subject)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "the snapshot does not fit: it is of another %s",
                         subject->world != NULL ? "world, or of a body" : "body, or of a world");
    }
    return PLI_OK;
}

/* One body after the other, so that the error is that of the first. */
static pli_status snapshot_compare(const snapshot_subject* subject, const snapshot_header* header) {
    if (header->body_count != (uint64_t)subject->body_count) {
        return plii_fail(subject->context, PLI_ERROR_INVALID_VALUE, subject->function,
                         "the snapshot does not fit: bodies or rigid bodies have come or gone");
    }
    snapshot_walk walk = snapshot_walk_head(subject, SNAPSHOT_COMPARE, header->head_size);
    size_t end = header->head_size;
    for (int i = 0; i < subject->body_count && walk.status == PLI_OK && walk.at == end; ++i) {
        const snapshot_record record = snapshot_record_of(subject->from, i);
        walk = snapshot_walk_of(subject, SNAPSHOT_COMPARE, record.begin, record.end);
        snapshot_body(&walk, subject->bodies[i]);
        end = record.end;
    }
    if (walk.status != PLI_OK || walk.at == end) { return walk.status; }
    return plii_fail(subject->context, PLI_ERROR_FILE_FORMAT, subject->function,
                     "the snapshot has more bytes than it says");
}

static void snapshot_restore_range(int begin, int end, void* task) {
    const snapshot_subject* subject = task;
    for (int i = begin; i < end; ++i) {
        const snapshot_record record = snapshot_record_of(subject->from, i);
        snapshot_walk walk = snapshot_walk_of(subject, SNAPSHOT_RESTORE, record.begin, record.end);
        snapshot_body(&walk, subject->bodies[i]);
    }
}

static pli_status snapshot_restore(snapshot_subject subject) {
    if (subject.from == NULL) {
        return plii_fail(subject.context, PLI_ERROR_NULL_ARGUMENT, subject.function, "buffer is null");
    }
    snapshot_header header;
    PLII_TRY(snapshot_check(&subject, &header));
    PLII_TRY(snapshot_compare(&subject, &header));
    (void)snapshot_walk_head(&subject, SNAPSHOT_RESTORE, header.head_size);
    snapshot_run(&subject, snapshot_restore_range);
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------------------------ calls

static snapshot_subject snapshot_of_world(const pli_world* world, const char* function) {
    return (snapshot_subject){.context = world->context,
                              .function = function,
                              .world = (pli_world*)(uintptr_t)world,
                              .bodies = world->bodies,
                              .body_count = world->body_count};
}

/* `body` stays where it is until the call is over. */
static snapshot_subject snapshot_of_body(pli_body* const* body, const char* function) {
    return (snapshot_subject){.context = (*body)->context, .function = function, .bodies = body, .body_count = 1};
}

size_t pli_world_snapshot_size(const pli_world* world) {
    if (plii_check_world(world, __func__) != PLI_OK) { return 0; }
    const snapshot_subject subject = snapshot_of_world(world, __func__);
    return snapshot_lay_out(&subject);
}

pli_status pli_world_save(const pli_world* world, void* buffer, size_t capacity, size_t* size) {
    PLII_TRY(plii_check_world_idle(world, __func__));
    snapshot_subject subject = snapshot_of_world(world, __func__);
    subject.to = buffer;
    subject.size = capacity;
    return snapshot_save(subject, size);
}

pli_status pli_world_restore(pli_world* world, const void* buffer, size_t size) {
    PLII_TRY(plii_check_world_idle(world, __func__));
    snapshot_subject subject = snapshot_of_world(world, __func__);
    subject.from = buffer;
    subject.size = size;
    return snapshot_restore(subject);
}

size_t pli_body_snapshot_size(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    pli_body* const own = (pli_body*)(uintptr_t)body;
    const snapshot_subject subject = snapshot_of_body(&own, __func__);
    return snapshot_lay_out(&subject);
}

pli_status pli_body_save(const pli_body* body, void* buffer, size_t capacity, size_t* size) {
    PLII_TRY(plii_check_body_between_steps(body, __func__));
    pli_body* const own = (pli_body*)(uintptr_t)body;
    snapshot_subject subject = snapshot_of_body(&own, __func__);
    subject.to = buffer;
    subject.size = capacity;
    return snapshot_save(subject, size);
}

pli_status pli_body_restore(pli_body* body, const void* buffer, size_t size) {
    PLII_TRY(plii_check_body_between_steps(body, __func__));
    snapshot_subject subject = snapshot_of_body(&body, __func__);
    subject.from = buffer;
    subject.size = size;
    return snapshot_restore(subject);
}
