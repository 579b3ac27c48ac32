/* Snapshots: the memory that steps read and former steps or calls wrote, as it lies. One walk over the world does all
   four things, so that they cannot differ: counting bytes, writing, comparing and reading. What a feature has is said
   by its class: its state and its arrays, but for what is made anew. Large arrays begin on lines of the cache:
   copies between places that lie alike on these are faster (docs/experiments.md). */

#include "pliant/snapshot.h"

#include "body/pipeline.h"
#include "world/checksum.h"

#include <stdio.h>

typedef enum snapshot_mode { SNAPSHOT_SAVE, SNAPSHOT_COMPARE, SNAPSHOT_RESTORE } snapshot_mode;

typedef struct snapshot_walk {
    snapshot_mode mode;
    pli_context* context;
    const char* function;
    /* What the snapshot is of; the other one is NULL. Written to only in RESTORE. */
    const pli_world* world;
    const pli_body* of_body;   /* alone: others stay as they are */
    int body;                  /* index of the one that is looked at, for messages */
    unsigned char* to;         /* SAVE */
    const unsigned char* from; /* COMPARE, RESTORE */
    size_t at, size;           /* SAVE: what is beyond `size` is counted, not written */
    size_t summed;             /* SAVE: what is before it is in the checksum */
    plii_checksum checksum;
    pli_status status;
} snapshot_walk;

/* The first bytes. */
typedef struct snapshot_header {
    uint32_t magic, version;
    uint64_t size;        /* with the header */
    uint64_t checksum[2]; /* of what follows */
    uint64_t handle;      /* of the world or body */
    uint64_t zeros[3];
} snapshot_header;

#define SNAPSHOT_MAGIC 0x706c6973u
#define SNAPSHOT_VERSION 3u
enum { SNAPSHOT_LARGE = 1024, SNAPSHOT_LINE = 64 };
_Static_assert(sizeof(snapshot_header) == SNAPSHOT_LINE && SNAPSHOT_LINE % PLII_CHECKSUM_BLOCK == 0, "");

// ----------------------------------------------------------------------------------------------------- the walk

static void snapshot_refuse(snapshot_walk* walk, const char* what, const char* feature) {
    if (walk->status != PLI_OK) { return; }
    char of_body[32] = "";
    if (walk->body != PLI_NULL_INDEX) { snprintf(of_body, sizeof of_body, "body %d: ", walk->body); }
    walk->status =
        plii_fail(walk->context, PLI_ERROR_INVALID_VALUE, walk->function, "the snapshot does not fit: %s%s%s%s",
                  of_body, what, feature != NULL ? " of " : "", feature != NULL ? feature : "");
}

static bool snapshot_has(snapshot_walk* walk, size_t size) {
    if (walk->mode == SNAPSHOT_SAVE || walk->at + size <= walk->size) { return walk->status == PLI_OK; }
    if (walk->status == PLI_OK) {
        walk->status =
            plii_fail(walk->context, PLI_ERROR_FILE_FORMAT, walk->function, "the snapshot ends in the middle");
    }
    return false;
}

static void snapshot_sum(snapshot_walk* walk) {
    plii_checksum_add(walk->context, &walk->checksum, walk->to + walk->summed, walk->at - walk->summed);
    walk->summed = walk->at;
}

/* Bytes that are taken over. Large ones begin on the next line; what is before it can be summed then: whole blocks. */
static void snapshot_bytes(snapshot_walk* walk, void* block, size_t size) {
    if (size >= SNAPSHOT_LARGE) {
        const size_t gap = (SNAPSHOT_LINE - walk->at % SNAPSHOT_LINE) % SNAPSHOT_LINE;
        const bool is_written = walk->mode == SNAPSHOT_SAVE && walk->at + gap <= walk->size;
        if (is_written) { memset(walk->to + walk->at, 0, gap); }
        walk->at += gap;
        if (is_written) { snapshot_sum(walk); }
    }
    if (size == 0 || !snapshot_has(walk, size)) { return; }
    if (walk->mode == SNAPSHOT_RESTORE) {
        memcpy(block, walk->from + walk->at, size);
    } else if (walk->mode == SNAPSHOT_SAVE && walk->at + size <= walk->size) {
        const size_t whole = size >= SNAPSHOT_LARGE ? size - size % PLII_CHECKSUM_BLOCK : 0;
        plii_checksum_kernel* add_blocks = PLII_KERNEL(walk->context, plii_checksum_blocks);
        if (whole > 0) { add_blocks(&walk->checksum, walk->to + walk->at, block, whole); }
        memcpy(walk->to + walk->at + whole, (const unsigned char*)block + whole, size - whole);
        walk->summed += whole;
    }
    walk->at += size;
}

/* A number; that of the snapshot where there is one. */
static uint64_t snapshot_number(snapshot_walk* walk, uint64_t number) {
    if (!snapshot_has(walk, sizeof number)) { return 0; }
    if (walk->mode != SNAPSHOT_SAVE) {
        memcpy(&number, walk->from + walk->at, sizeof number);
    } else if (walk->at + sizeof number <= walk->size) {
        memcpy(walk->to + walk->at, &number, sizeof number);
    }
    walk->at += sizeof number;
    return number;
}

/* Something that must be the same; `what` is what else is wrong. */
static void snapshot_same(snapshot_walk* walk, uint64_t number, const char* what) {
    const uint64_t saved = snapshot_number(walk, number);
    if (walk->status == PLI_OK && saved != number) { snapshot_refuse(walk, what, NULL); }
}
#define SNAPSHOT_POINTER(pointer) ((uint64_t)(uintptr_t)(pointer))

// ------------------------------------------------------------------------------------------------------- features

static void snapshot_set_count(const plii_feature_array* array, void* state, int count) {
    if (array->count != 0) { memcpy((char*)state + array->count, &count, sizeof count); }
}

static void snapshot_array(snapshot_walk* walk, pli_body* body, const plii_feature_class* klass,
                           const plii_feature_array* array, void* state) {
    if (array->snapshot == PLII_LEFT && walk->mode == SNAPSHOT_RESTORE) { snapshot_set_count(array, state, 0); }
    if (array->snapshot != PLII_SAVED) { return; }
    void* items = plii_feature_array_address(body, array, state);
    size_t size = plii_feature_array_bytes(body, array, state);
    if (array->length >= PLII_LIST) {
        const size_t room = size / array->element_size;
        int count = (int)room;
        if (array->count != 0) { memcpy(&count, (const char*)state + array->count, sizeof count); }
        const uint64_t saved = snapshot_number(walk, (uint64_t)count);
        if (saved > room) { snapshot_refuse(walk, "there is less memory than then for a list", klass->name); }
        if (walk->status != PLI_OK) { return; }
        if (walk->mode == SNAPSHOT_RESTORE) { snapshot_set_count(array, state, (int)saved); }
        size = (size_t)saved * array->element_size;
    }
    snapshot_bytes(walk, items, size);
}

static void snapshot_feature(snapshot_walk* walk, pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    void* state = feature->state;
    for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
        if (part->snapshot == PLII_SAVED) { snapshot_bytes(walk, (unsigned char*)state + part->offset, part->size); }
    }
    for (PLII_EACH_ARRAY(array, klass)) {
        if (walk->status != PLI_OK) { return; }
        snapshot_array(walk, body, klass, array, state);
    }
    if (walk->mode == SNAPSHOT_RESTORE && klass->on_restored != NULL) { klass->on_restored(body, state); }
}

/* As it was made, when a call has made it since. */
static void snapshot_empty_feature(pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    unsigned char* state = feature->state;
    for (PLII_EACH_ARRAY(array, klass)) {
        const size_t size = array->count == 0 ? plii_feature_array_bytes(body, array, state) : 0;
        snapshot_set_count(array, state, 0);
        if (size > 0) { memset(plii_feature_array_address(body, array, state), 0, size); }
    }
    for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
        memset(state + part->offset, 0, part->size);
    }
    if (klass->enable != NULL) { klass->enable(body, state); }
}

// --------------------------------------------------------------------------------------------- bodies and the world

/* From one member to another, and what is between them. */
#define SNAPSHOT_MEMBERS(walk, type, object, first, last)                                                              \
    snapshot_bytes(walk, (char*)(object) + offsetof(type, first),                                                      \
                   offsetof(type, last) + sizeof((object)->last) - offsetof(type, first))

static void snapshot_body(snapshot_walk* walk, pli_body* body) {
    snapshot_same(walk, SNAPSHOT_POINTER(body), "it is another body");
    if (walk->of_body != NULL) { /* its features may keep them */
        snapshot_same(walk, body->world->removals, "bodies, rigid bodies or clusters have gone");
    }
    snapshot_same(walk, body->length_revision, "it was cut or refined, or rest lengths were set");
    snapshot_same(walk, body->pipeline.revision, "features were enabled or disabled, or clusters have come or gone");
    snapshot_same(walk, SNAPSHOT_POINTER(body->solver_class), "it has another solver");
    snapshot_same(walk, (uint64_t)body->node_count, "it has another number of nodes");
    snapshot_same(walk, (uint64_t)body->material_count, "it has another number of materials");
    /* Masses are with the positions; what follows from them is made anew where they were others. */
    const bool is_same = snapshot_number(walk, body->link_revision) == body->link_revision;
    if (walk->mode == SNAPSHOT_RESTORE && !is_same) { body->link_revision += 1; }
    /* Room that was still to be made is made again: the order of faces for contacts comes with it. */
    const bool needs_reserve = snapshot_number(walk, body->world->needs_reserve) != 0;
    if (walk->mode == SNAPSHOT_RESTORE && needs_reserve) { body->world->needs_reserve = true; }
    snapshot_bytes(walk, body->positions, plii_body_node_block_size(body)); /* previous and velocities, too */
    snapshot_bytes(walk, body->materials, (size_t)body->material_count * sizeof *body->materials);
    SNAPSHOT_MEMBERS(walk, pli_body, body, is_frozen, is_asleep);
    SNAPSHOT_MEMBERS(walk, pli_body, body, bounds, bounds);
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
}

static void snapshot_world(snapshot_walk* walk, pli_world* world) {
    snapshot_same(walk, world->revision, "bodies or rigid bodies have come or gone");
    SNAPSHOT_MEMBERS(walk, pli_world_def, &world->def, gravity, air_density);
    SNAPSHOT_MEMBERS(walk, pli_world, world, dt, dt);
    SNAPSHOT_MEMBERS(walk, pli_world, world, sleep_group, sleep_group);
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
    for (int i = 0; i < world->body_count && walk->status == PLI_OK; ++i) {
        walk->body = i;
        snapshot_body(walk, world->bodies[i]);
    }
    walk->body = PLI_NULL_INDEX;
}

// ---------------------------------------------------------------------------------------------------------- calls

static uint64_t snapshot_handle(const snapshot_walk* walk) {
    return walk->world != NULL ? SNAPSHOT_POINTER(walk->world) : SNAPSHOT_POINTER(walk->of_body);
}

static pli_status snapshot_run(snapshot_walk* walk, snapshot_mode mode) {
    walk->mode = mode;
    walk->at = sizeof(snapshot_header);
    walk->body = walk->of_body != NULL ? walk->of_body->world_index : PLI_NULL_INDEX;
    if (walk->world != NULL) {
        snapshot_world(walk, (pli_world*)(uintptr_t)walk->world);
    } else {
        snapshot_body(walk, (pli_body*)(uintptr_t)walk->of_body);
    }
    return walk->status;
}

static size_t snapshot_size(snapshot_walk walk) {
    return snapshot_run(&walk, SNAPSHOT_SAVE) == PLI_OK ? walk.at : 0;
}

static pli_status snapshot_save(snapshot_walk walk, void* buffer, size_t capacity, size_t* size) {
    walk.to = buffer;
    walk.size = buffer != NULL ? capacity : 0;
    walk.summed = sizeof(snapshot_header);
    PLII_TRY(snapshot_run(&walk, SNAPSHOT_SAVE));
    if (size != NULL) { *size = walk.at; }
    PLII_FAIL_IF(buffer == NULL, walk.context, PLI_ERROR_NULL_ARGUMENT, walk.function, "buffer is null");
    PLII_FAIL_IF(walk.at > capacity, walk.context, PLI_ERROR_INVALID_VALUE, walk.function,
                 "capacity is %zu, the snapshot has %zu bytes", capacity, walk.at);
    snapshot_sum(&walk);
    snapshot_header header = {
        .magic = SNAPSHOT_MAGIC, .version = SNAPSHOT_VERSION, .size = walk.at, .handle = snapshot_handle(&walk)};
    plii_checksum_end(&walk.checksum, header.checksum);
    memcpy(buffer, &header, sizeof header);
    return PLI_OK;
}

static pli_status snapshot_check(const snapshot_walk* walk) {
    pli_context* context = walk->context;
    const char* function = walk->function;
    const size_t size = walk->size;
    snapshot_header header = {0};
    if (size >= sizeof header) { memcpy(&header, walk->from, sizeof header); }
    PLII_FAIL_IF(header.magic != SNAPSHOT_MAGIC, context, PLI_ERROR_FILE_FORMAT, function,
                 "the %zu bytes are no snapshot", size);
    PLII_FAIL_IF(header.version != SNAPSHOT_VERSION, context, PLI_ERROR_FILE_FORMAT, function,
                 "the snapshot is of version %u, this is %u", (unsigned)header.version, SNAPSHOT_VERSION);
    PLII_FAIL_IF(header.size != size, context, PLI_ERROR_FILE_FORMAT, function,
                 "the snapshot has %llu bytes, %zu were given", (unsigned long long)header.size, size);
    plii_checksum checksum = {0};
    uint64_t sums[2];
    plii_checksum_add(context, &checksum, walk->from + sizeof header, size - sizeof header);
    plii_checksum_end(&checksum, sums);
    if (memcmp(sums, header.checksum, sizeof sums) != 0 || (header.zeros[0] | header.zeros[1] | header.zeros[2]) != 0) {
        return plii_fail(context, PLI_ERROR_FILE_FORMAT, function, "the snapshot is damaged: its checksum is wrong");
    }
    PLII_FAIL_IF(header.handle != snapshot_handle(walk), context, PLI_ERROR_INVALID_VALUE, function,
                 "the snapshot does not fit: it is of another %s",
                 walk->world != NULL ? "world, or of a body" : "body, or of a world");
    return PLI_OK;
}

static pli_status snapshot_restore(snapshot_walk walk, const void* buffer, size_t size) {
    PLII_FAIL_IF(buffer == NULL, walk.context, PLI_ERROR_NULL_ARGUMENT, walk.function, "buffer is null");
    walk.from = buffer;
    walk.size = size;
    PLII_TRY(snapshot_check(&walk));
    PLII_TRY(snapshot_run(&walk, SNAPSHOT_COMPARE));
    PLII_FAIL_IF(walk.at != size, walk.context, PLI_ERROR_FILE_FORMAT, walk.function,
                 "the snapshot has %zu bytes more than it says", size - walk.at);
    return snapshot_run(&walk, SNAPSHOT_RESTORE);
}

/* The calls of a user for what a snapshot is of. */
#define SNAPSHOT_CALLS(kind, member, check)                                                                            \
    PLII_DEFINE_GET(size_t, pli_##kind##_snapshot_size, kind, snapshot_size(SNAPSHOT_WALK(kind, member)), 0)           \
    pli_status pli_##kind##_save(const pli_##kind* kind, void* buffer, size_t capacity, size_t* size) {                \
        PLII_TRY(check(kind, __func__));                                                                               \
        return snapshot_save(SNAPSHOT_WALK(kind, member), buffer, capacity, size);                                     \
    }                                                                                                                  \
    pli_status pli_##kind##_restore(pli_##kind* kind, const void* buffer, size_t size) {                               \
        PLII_TRY(check(kind, __func__));                                                                               \
        return snapshot_restore(SNAPSHOT_WALK(kind, member), buffer, size);                                            \
    }
#define SNAPSHOT_WALK(kind, member)                                                                                    \
    ((snapshot_walk){.member = (kind), .context = (kind)->context, .function = __func__})
SNAPSHOT_CALLS(world, world, plii_check_world_idle)
SNAPSHOT_CALLS(body, of_body, plii_check_body_idle)
