/* Worlds as files: writing, making a world from one, and bringing a world to the state of one. What is read is made
   first, in a world of its own; only when all of it is there and sound, the caller's world gets it. */

#include "file/file_impl.h"

/* Before everything else. */
typedef struct file_header {
    uint32_t magic[2]; /* "PLIWORLD" */
    uint32_t version;
    uint32_t reserved;
    uint64_t size;     /* bytes, with the header */
    uint64_t checksum; /* of what follows */
} file_header;
#define FILE_HEADER_FIELDS "4u2U"
enum { FILE_VERSION = 8 };
#define FILE_MAGIC_0 0x57494c50u
#define FILE_MAGIC_1 0x444c524fu

PLII_DEFINE_DEFAULT(pli_world_file_def, 0)

/* Little-endian; zeros for what is missing of a word. */
static uint64_t file_word(const unsigned char* bytes, size_t size) {
    uint64_t word = 0;
    memcpy(&word, bytes, size < sizeof word ? size : sizeof word);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    word = __builtin_bswap64(word);
#endif
    return word;
}

uint64_t plii_file_checksum(const unsigned char* bytes, size_t size) {
    uint64_t sum = size;
    for (size_t at = 0; at < size; at += sizeof sum) {
        sum = (sum ^ file_word(bytes + at, size - at)) * UINT64_C(0x9e3779b97f4a7c15);
        sum ^= sum >> 32;
    }
    return sum;
}

// ------------------------------------------------------------------------------------------------------- the walk

/* The walk and what it needs beside. */
typedef struct file_walk {
    plii_file stream;
    pli_world* world;  /* that is written, or was made for what is read */
    pli_world* target; /* of a restore, or NULL */
    pli_rigid** found; /* [found_count] of the target, by the ids of the file; NULL without a target */
    int found_count;
} file_walk;

/* What pointers are counted in: all that there is by now. */
static void file_count_in(plii_file* file, const pli_world* world) {
    file->bodies = file->to_bodies = world->bodies;
    file->rigids = file->to_rigids = world->rigids;
    file->body_count = world->body_count;
    file->rigid_count = world->rigid_count;
}

static void file_world_settings(plii_file* file, pli_world_def* def) {
    static const plii_state_part parts[] = {
        PLII_STATE_SPAN(pli_world_def, gravity, host_puts_to_sleep, PLII_SAVED, "5f3B"), {0}};
    plii_file_begin_part(file, "settings of the world");
    plii_file_parts(file, parts, def);
}

static void file_world_state(plii_file* file, pli_world* world) {
    plii_file_fields(file, "f", &world->dt);
    plii_file_fields(file, "u", &world->sleep_group);
    const bool is_time = world->dt >= 0.0f && world->dt <= PLI_MAX_TIME_STEP;
    if (file->mode == PLII_FILE_READ && !is_time) { plii_file_refuse(file, "the time step is out of range"); }
}

/* Where the rigid bodies of the file are in the target. */
static void file_find_rigid(file_walk* walk, int index, uint64_t id) {
    const pli_world_file_def* def = &walk->stream.def;
    const pli_world* target = walk->target;
    plii_file* file = &walk->stream;
    pli_rigid* rigid = NULL;
    if (def->find_rigid != NULL) {
        rigid = def->find_rigid(id, def->user);
    } else if (id < (uint64_t)target->rigid_count) {
        rigid = target->rigids[id];
    }
    if (rigid != NULL) { file->status = plii_check_rigid(rigid, file->function); }
    bool is_new = rigid != NULL && file->status == PLI_OK && rigid->world == target;
    for (int i = 0; i < index && is_new; ++i) {
        is_new = walk->found[i] != rigid;
    }
    if (!is_new && file->status == PLI_OK) {
        PLII_FILE_FAIL(file, PLI_ERROR_INVALID_VALUE,
                       "the world does not fit the file: it has no rigid body %d, of id %llu, or it has it twice",
                       index, (unsigned long long)id);
    }
    walk->found[index] = is_new ? rigid : NULL;
}

static void file_rigids(file_walk* walk) {
    plii_file* file = &walk->stream;
    const int count = plii_file_count(file, walk->world->rigid_count, 64);
    if (walk->target != NULL && count > 0 && !PLII_ALLOCATE(file->context, &walk->found, count)) {
        PLII_FILE_FAIL(file, PLI_ERROR_OUT_OF_MEMORY, "no memory for the file");
    }
    walk->found_count = walk->found != NULL ? count : 0;
    for (int i = 0; i < count && file->status == PLI_OK; ++i) {
        const bool is_asked = file->mode == PLII_FILE_WRITE && file->def.rigid_id != NULL;
        const uint64_t id =
            plii_file_u64(file, is_asked ? file->def.rigid_id(walk->world->rigids[i], file->def.user) : (uint64_t)i);
        if (walk->target != NULL && file->status == PLI_OK) { file_find_rigid(walk, i, id); }
        if (file->status != PLI_OK) { break; }
        plii_file_rigid(file, walk->world, i, walk->found != NULL ? walk->found[i] : NULL);
    }
    file_count_in(file, walk->world);
}

static void file_begin_body(plii_file* file, const pli_body* body, int index) {
    file->body = body;
    file->body_index = index;
}

/* Bodies first, then what may lead to any of them. */
static void file_bodies(file_walk* walk) {
    plii_file* file = &walk->stream;
    pli_world* world = walk->world;
    const bool is_reading = file->mode == PLII_FILE_READ;
    const int count = plii_file_count(file, world->body_count, 64);
    for (int i = 0; i < count && file->status == PLI_OK; ++i) {
        file_begin_body(file, is_reading ? NULL : world->bodies[i], i);
        plii_file_begin_part(file, "nodes");
        plii_file_body(file, world, is_reading ? NULL : world->bodies[i]);
    }
    file_count_in(file, world);
    for (int i = 0; i < count && file->status == PLI_OK; ++i) {
        file_begin_body(file, world->bodies[i], i);
        plii_file_features(file, world->bodies[i]);
        plii_file_body_end(file, world->bodies[i]);
    }
    file_begin_body(file, NULL, PLI_NULL_INDEX);
    for (int i = 0; i < world->rigid_count && file->status == PLI_OK; ++i) {
        plii_file_rigid_end(file, world->rigids[i]);
    }
    plii_file_begin_part(file, "order of the bodies");
    plii_file_elements(file, "P", world->sweep, (size_t)count, sizeof(*world->sweep));
}

/* Each body once. */
static void file_check_order(plii_file* file, const pli_world* world) {
    int* is_met = world->islands; /* there are none yet */
    for (int i = 0; i < world->body_count; ++i) {
        is_met[i] = false;
    }
    for (PLII_EACH_AT(pli_body, body, world->sweep, world->body_count)) {
        const bool is_missing = body == NULL || is_met[body->world_index]++ > 0;
        if (is_missing) { plii_file_refuse(file, "a body is missing"); }
    }
}

/* Without a definition, the default one. */
static pli_status file_begin(plii_file_mode mode, const pli_world_file_def* def, pli_world* world, pli_context* context,
                             const char* function, file_walk* walk) {
    *walk = (file_walk){.stream = {.mode = mode,
                                   .context = context,
                                   .function = function,
                                   .def = def != NULL ? *def : pli_world_file_def_default(),
                                   .body_index = PLI_NULL_INDEX},
                        .world = world};
    if (world != NULL) { file_count_in(&walk->stream, world); }
    return PLII_CHECK_MADE(context, pli_world_file_def, &walk->stream.def, function);
}

// ---------------------------------------------------------------------------------------------------------- writing

/* Walks change nothing where they do not read. */
static void file_write_all(file_walk* walk) {
    pli_world_def def = walk->world->def;
    walk->stream.at = PLII_FILE_HEADER_SIZE;
    file_world_settings(&walk->stream, &def);
    file_world_state(&walk->stream, walk->world);
    file_rigids(walk);
    file_bodies(walk);
}

static size_t file_size(const pli_world* world, const char* function) {
    file_walk walk;
    (void)file_begin(PLII_FILE_COUNT, NULL, (pli_world*)(uintptr_t)world, world->context, function, &walk);
    file_write_all(&walk);
    return walk.stream.at;
}

PLII_DEFINE_GET(size_t, pli_world_file_size, world, file_size(world, __func__), 0)

pli_status pli_world_file_write(const pli_world* world, const pli_world_file_def* def, void* buffer, size_t capacity,
                                size_t* size) {
    PLII_TRY(plii_check_world_idle(world, __func__));
    pli_context* context = world->context;
    file_walk walk;
    PLII_TRY(file_begin(PLII_FILE_WRITE, def, (pli_world*)(uintptr_t)world, context, __func__, &walk));
    const size_t needed = file_size(world, __func__);
    if (size != NULL) { *size = needed; }
    if (buffer == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "buffer is null"); }
    PLII_FAIL_IF(needed > capacity, context, PLI_ERROR_INVALID_VALUE, __func__,
                 "capacity is %zu, the file has %zu bytes", capacity, needed);
    walk.stream.to = buffer;
    plii_walk guard; /* callbacks may read only */
    plii_walk_begin(&guard, context, PLII_WALK_STEP);
    file_write_all(&walk);
    plii_walk_end(&guard);
    PLII_TRY(walk.stream.status);
    file_header header = {
        .magic = {FILE_MAGIC_0, FILE_MAGIC_1},
        .version = FILE_VERSION,
        .size = needed,
        .checksum = plii_file_checksum((unsigned char*)buffer + PLII_FILE_HEADER_SIZE, needed - PLII_FILE_HEADER_SIZE)};
    walk.stream.at = 0;
    plii_file_fields(&walk.stream, FILE_HEADER_FIELDS, &header);
    return PLI_OK;
}

// ---------------------------------------------------------------------------------------------------------- reading

static pli_status file_check_header(plii_file* file) {
    pli_context* context = file->context;
    const pli_status wrong = PLI_ERROR_FILE_FORMAT;
    const char* function = file->function;
    PLII_FAIL_IF(file->from == NULL, context, PLI_ERROR_NULL_ARGUMENT, function, "buffer is null");
    file_header header = {0};
    if (file->size >= PLII_FILE_HEADER_SIZE) { plii_file_fields(file, FILE_HEADER_FIELDS, &header); }
    PLII_FAIL_IF(header.magic[0] != FILE_MAGIC_0 || header.magic[1] != FILE_MAGIC_1, context, wrong, function,
                 "the %zu bytes are no file of a world", file->size);
    PLII_FAIL_IF(header.version != FILE_VERSION, context, wrong, function, "the file is of version %u, this is %u",
                 (unsigned)header.version, (unsigned)FILE_VERSION);
    PLII_FAIL_IF(header.size != file->size, context, wrong, function, "the file has %llu bytes, %zu were given",
                 (unsigned long long)header.size, file->size);
    const uint64_t checksum =
        plii_file_checksum(file->from + PLII_FILE_HEADER_SIZE, file->size - PLII_FILE_HEADER_SIZE);
    PLII_FAIL_IF(header.reserved != 0 || header.checksum != checksum, context, wrong, function,
                 "the file is damaged: its checksum is wrong");
    return PLI_OK;
}

static void file_make_world(file_walk* walk) {
    plii_file* file = &walk->stream;
    pli_world_def def = pli_world_def_default();
    file_world_settings(file, &def);
    if (file->status != PLI_OK) { return; }
    const pli_status status = pli_world_create(file->context, &def, &walk->world);
    (void)plii_file_is_made(file, status, "a setting is out of range");
}

static void file_settle(file_walk* walk) {
    plii_file* file = &walk->stream;
    for (int i = 0; i < walk->world->body_count && file->status == PLI_OK; ++i) {
        file_begin_body(file, walk->world->bodies[i], i);
        plii_file_settle_features(file, walk->world->bodies[i]);
    }
    file_begin_body(file, NULL, PLI_NULL_INDEX);
    if (file->status == PLI_OK && file->at != file->size) { plii_file_refuse(file, "something follows the end"); }
}

/* Into a world of its own, which walk->world is then; on an error there is none. */
static pli_status file_read_all(file_walk* walk, const void* buffer, size_t size) {
    plii_file* file = &walk->stream;
    file->from = buffer;
    file->size = size;
    PLII_TRY(file_check_header(file));
    file_make_world(walk);
    if (file->status == PLI_OK) { file_world_state(file, walk->world); }
    if (file->status == PLI_OK) { file_rigids(walk); }
    if (file->status == PLI_OK) { file_bodies(walk); }
    if (file->status == PLI_OK) { file_check_order(file, walk->world); }
    if (file->status == PLI_OK) { file_settle(walk); }
    if (file->status != PLI_OK) {
        for (int i = 0; walk->world != NULL && i < walk->world->body_count; ++i) {
            plii_file_empty_features(walk->world->bodies[i]);
        }
        pli_world_destroy(walk->world);
        walk->world = NULL;
    }
    return file->status;
}

pli_status pli_world_file_create(pli_context* context, const pli_world_file_def* def, const void* buffer, size_t size,
                                 pli_world** world) {
    PLII_TRY(plii_check_create(context, world, "world", __func__));
    file_walk walk;
    PLII_TRY(file_begin(PLII_FILE_READ, def, NULL, context, __func__, &walk));
    PLII_TRY(file_read_all(&walk, buffer, size));
    *world = walk.world;
    return PLI_OK;
}

// -------------------------------------------------------------------------------------------------------- restoring

/* What a body is goes over to the handle of another; what makes it that handle stays. */
static void file_exchange_bodies(pli_body* body, pli_body* made) {
    pli_body was = *body, now = *made;
    now.world = body->world;
    now.world_index = body->world_index;
    now.user_data = body->user_data;
    now.collide_call = body->collide_call;
    now.pipeline.revision += body->pipeline.revision + 1; /* none that a snapshot has */
    was.world = made->world;
    was.world_index = made->world_index;
    was.user_data = NULL;
    *body = now;
    *made = was;
}

/* Those of the file first, in its order. */
static void file_order_rigids(const file_walk* walk) {
    pli_world* target = walk->target;
    for (int i = 0; i < walk->found_count; ++i) {
        const int at = walk->found[i]->world_index;
        memmove(&target->rigids[i + 1], &target->rigids[i], (size_t)(at - i) * sizeof(*target->rigids));
        target->rigids[i] = walk->found[i];
        for (int k = i; k <= at; ++k) {
            target->rigids[k]->world_index = k;
        }
    }
}

/* Nothing fails any more. */
static void file_commit(file_walk* walk) {
    pli_world *target = walk->target, *made = walk->world;
    plii_file* file = &walk->stream;
    for (int i = 0; i < target->body_count; ++i) {
        file_exchange_bodies(target->bodies[i], made->bodies[i]);
    }
    file->mode = PLII_FILE_REPOINT;
    file->to_bodies = target->bodies;
    file->to_rigids = walk->found;
    for (int i = 0; i < target->body_count; ++i) {
        target->sweep[i] = target->bodies[made->sweep[i]->world_index];
        file_begin_body(file, target->bodies[i], i);
        plii_file_features(file, target->bodies[i]);
        plii_file_take_over(target->bodies[i], made->bodies[i]);
    }
    for (int i = 0; i < walk->found_count; ++i) {
        plii_file_copy_rigid(walk->found[i], made->rigids[i]);
    }
    file_order_rigids(walk);
    void* user_data = target->def.user_data;
    target->def = made->def;
    target->def.user_data = user_data;
    target->dt = made->dt;
    target->sleep_group = made->sleep_group;
    if (target->sleep == NULL) { target->sleep = made->sleep; }
    if (target->take_update_intervals == NULL) { target->take_update_intervals = made->take_update_intervals; }
    target->event_count = 0;
    target->has_groups = target->has_islands = false;
    target->needs_reserve = true;
    target->revision += 1;
}

pli_status pli_world_file_restore(pli_world* world, const pli_world_file_def* def, const void* buffer, size_t size) {
    PLII_TRY(plii_check_world_idle(world, __func__));
    pli_context* context = world->context;
    file_walk walk;
    PLII_TRY(file_begin(PLII_FILE_READ, def, NULL, context, __func__, &walk));
    walk.target = world;
    pli_status status = file_read_all(&walk, buffer, size);
    if (status == PLI_OK && walk.world->body_count != world->body_count) {
        status = PLII_FAIL(context, PLI_ERROR_INVALID_VALUE,
                           "the world does not fit the file: it has %d bodies, %d in the file", world->body_count,
                           walk.world->body_count);
    }
    if (status == PLI_OK) { file_commit(&walk); }
    if (walk.world != NULL) { pli_world_destroy(walk.world); }
    PLII_RELEASE(context, walk.found, walk.found_count);
    return status;
}
