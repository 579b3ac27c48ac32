/* Blocks of handles, and, in a checked build, the register of all handles of the process. */

#include "base/handle.h"

#include <stdio.h>

static const char* const handle_names[] = {
    [PLII_HANDLE_CONTEXT] = "context",  [PLII_HANDLE_WORLD] = "world", [PLII_HANDLE_BODY] = "body",
    [PLII_HANDLE_RIGID] = "rigid body", [PLII_HANDLE_MESH] = "mesh",   [PLII_HANDLE_SHAPE] = "shape",
};

#if PLIANT_CHECKED

#include <stdatomic.h>
#include <stdlib.h>
#include <threads.h>

/* What is or was at an address. */
typedef struct handle_record {
    const void* handle;       /* NULL: an empty slot */
    const pli_context* owner; /* of a context, itself */
    uint64_t number;          /* of its making; when it is gone, of that */
    uint64_t owner_number;
    plii_handle_kind kind;
    bool is_alive;
} handle_record;

/* How many that are gone are remembered at least, when the table grows. */
enum { HANDLE_LEAST_CAPACITY = 1024, HANDLE_MOST_GONE = 4096 };

/* Open addressing. For all contexts, which may be used by threads of their own. */
static struct {
    atomic_flag is_locked;
    handle_record* records;
    size_t capacity; /* a power of two */
    size_t count, gone_count;
    uint64_t last_number;
} handles = {.is_locked = ATOMIC_FLAG_INIT};

static void handles_lock(void) {
    while (atomic_flag_test_and_set_explicit(&handles.is_locked, memory_order_acquire)) {
        thrd_yield();
    }
}
static void handles_unlock(void) {
    atomic_flag_clear_explicit(&handles.is_locked, memory_order_release);
}

/* That of the record, or an empty one. The table is never full. */
static handle_record* handles_find_slot(const void* handle) {
    const size_t mask = handles.capacity - 1;
    size_t slot = (size_t)(((uint64_t)(uintptr_t)handle >> 4) * 0x9e3779b97f4a7c15u >> 32) & mask;
    while (handles.records[slot].handle != NULL && handles.records[slot].handle != handle) {
        slot = (slot + 1) & mask;
    }
    return &handles.records[slot];
}

/* NULL when nothing is known of it. */
static handle_record* handles_find(const void* handle) {
    if (handles.capacity == 0 || handle == NULL) { return NULL; }
    handle_record* record = handles_find_slot(handle);
    return record->handle != NULL ? record : NULL;
}

static bool handles_grow(void) {
    const bool keeps_gone = handles.gone_count <= HANDLE_MOST_GONE;
    const size_t kept = keeps_gone ? handles.count : handles.count - handles.gone_count;
    size_t capacity = HANDLE_LEAST_CAPACITY;
    while (capacity < 4 * kept) {
        capacity *= 2;
    }
    handle_record* records = calloc(capacity, sizeof *records);
    if (records == NULL) { return false; }
    handle_record* old = handles.records;
    const size_t old_capacity = handles.capacity;
    handles.records = records;
    handles.capacity = capacity;
    for (size_t i = 0; i < old_capacity; ++i) {
        if (old[i].handle != NULL && (keeps_gone || old[i].is_alive)) { *handles_find_slot(old[i].handle) = old[i]; }
    }
    handles.count = kept;
    handles.gone_count = keeps_gone ? handles.gone_count : 0;
    free(old);
    return true;
}

static bool handles_add(const void* handle, plii_handle_kind kind, const pli_context* owner) {
    handles_lock();
    bool has_room = 2 * (handles.count + 1) <= handles.capacity || handles_grow();
    if (has_room) {
        handle_record* record = handles_find_slot(handle);
        if (record->handle == NULL) {
            handles.count += 1;
        } else if (!record->is_alive) {
            handles.gone_count -= 1;
        }
        const handle_record* owner_record = handles_find(owner);
        const uint64_t number = ++handles.last_number;
        const uint64_t owner_number =
            (const void*)owner == handle || owner_record == NULL ? number : owner_record->number;
        *record = (handle_record){handle, owner, number, owner_number, kind, true};
    }
    handles_unlock();
    return has_room;
}

static void handles_retire(const void* handle) {
    handles_lock();
    handle_record* record = handles_find(handle);
    if (record != NULL && record->is_alive) {
        record->is_alive = false;
        record->number = ++handles.last_number;
        handles.gone_count += 1;
    }
    handles_unlock();
}

static bool handles_copy(const void* handle, handle_record* copy) {
    handles_lock();
    const handle_record* record = handles_find(handle);
    if (record != NULL) { *copy = *record; }
    handles_unlock();
    return record != NULL;
}

bool plii_handle_is_alive(const void* handle, plii_handle_kind kind) {
    handle_record record;
    return handles_copy(handle, &record) && record.is_alive && record.kind == kind;
}

/* Where nothing was, as far as is remembered and a few tries find it, else where it is gone for longest. */
static void* handle_allocate(pli_context* context, size_t size) {
    enum { MOST_TRIES = 16 };
    void* tries[MOST_TRIES];
    int count = 0, oldest = 0;
    uint64_t oldest_since = UINT64_MAX;
    do {
        tries[count] = plii_allocate(context, size);
        if (tries[count] == NULL) { break; }
        handle_record gone;
        const uint64_t since = handles_copy(tries[count], &gone) ? gone.number : 0; /* 0: nothing is known */
        if (since < oldest_since) {
            oldest_since = since;
            oldest = count;
        }
        count += 1;
    } while (oldest_since > 0 && count < MOST_TRIES);
    for (int i = 0; i < count; ++i) {
        if (i != oldest) { plii_release(context, tries[i], size); }
    }
    return count > 0 ? tries[oldest] : NULL;
}

#else

static void* handle_allocate(pli_context* context, size_t size) {
    return plii_allocate(context, size);
}
static bool handles_add(const void* handle, plii_handle_kind kind, const pli_context* owner) {
    return true;
}
static void handles_retire(const void* handle) {}

#endif

pli_status plii_handle_refuse(const void* handle, plii_handle_kind kind, pli_context* context, const char* what,
                              const char* function) {
    char name[32];
    snprintf(name, sizeof name, "the %s", handle_names[kind]);
    if (what == NULL) { what = name; }
    if (handle == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "%s is null", what); }
#if PLIANT_CHECKED
    handle_record record, owner;
    if (handles_copy(handle, &record)) {
        /* The context that it was made in, if that still lives. */
        const bool lives = handles_copy(record.owner, &owner) && owner.is_alive && owner.kind == PLII_HANDLE_CONTEXT &&
                           owner.number == record.owner_number;
        if (context == NULL && lives) { context = (pli_context*)record.owner; }
        PLII_FAIL_IF(record.kind == kind, context, PLI_ERROR_STALE_ID, function, "%s was destroyed before", what);
        return plii_fail(context, PLI_ERROR_STALE_ID, function, "%s is a %s", what, handle_names[record.kind]);
    }
#endif
    return plii_fail(context, PLI_ERROR_STALE_ID, function, "%s is not a %s, or one that is gone", what,
                     handle_names[kind]);
}

bool plii_handle_add_context(pli_context* context) {
    context->magic = plii_handle_magic(PLII_HANDLE_CONTEXT);
    return handles_add(context, PLII_HANDLE_CONTEXT, context);
}

void* plii_handle_create(pli_context* context, plii_handle_kind kind, size_t size) {
    void* handle = handle_allocate(context, size);
    if (handle == NULL) { return NULL; }
    if (!handles_add(handle, kind, context)) {
        plii_release(context, handle, size);
        return NULL;
    }
    *(uint32_t*)handle = plii_handle_magic(kind);
    (void)__atomic_add_fetch(&context->alive[kind], 1, __ATOMIC_RELAXED);
    return handle;
}

void plii_handle_retire(void* handle) {
    *(uint32_t*)handle = 0;
    handles_retire(handle);
}

void plii_handle_release(pli_context* context, void* handle, plii_handle_kind kind, size_t size) {
    plii_handle_retire(handle);
    (void)__atomic_sub_fetch(&context->alive[kind], 1, __ATOMIC_RELAXED); /* a step may end a shape */
    plii_release(context, handle, size);
}
