/* Memory and error messages. */

#include "base/context.h"

#include <stdarg.h>
#include <stdio.h>
#include <threads.h>

const char* pli_status_string(pli_status status) {
    switch (status) {
#define STATUS_TEXT(name, value, text)                                                                                 \
    case name:                                                                                                         \
        return text;
        PLI_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
    }
    return "unknown status";
}

/* Of calls that no context could keep the message of. */
#if PLIANT_CHECKED
static _Thread_local char context_lost_error[sizeof((pli_context*)NULL)->last_error];
#else
static const char context_lost_error[1] = "";
#endif

const char* plii_lost_error(void) {
    return context_lost_error;
}

__thread plii_thread_state plii_thread;
__thread int plii_shape_queries;

bool plii_context_lock(pli_context* context) {
    if (plii_walk_find(context, PLII_WALK_HOOK | PLII_WALK_LOG) != NULL) { return false; }
    while (__atomic_exchange_n(&context->is_locked, true, __ATOMIC_ACQUIRE)) {
        while (PLII_LOAD(&context->is_locked)) {
            thrd_yield();
        }
    }
    return true;
}
void plii_context_unlock(pli_context* context, bool was_locked) {
    if (was_locked) { __atomic_store_n(&context->is_locked, false, __ATOMIC_RELEASE); }
}

typedef struct parallel_task {
    const pli_context* context;
    pli_range_fn* range;
    void* task;
    plii_pass pass;
} parallel_task;

static void parallel_range(int begin, int end, void* data) {
    const parallel_task* parallel = data;
    const plii_pass pass = plii_thread.pass;
    plii_walk walk;
    plii_walk_begin(&walk, parallel->context, PLII_WALK_PARALLEL);
    plii_thread.pass = parallel->pass;
    parallel->range(begin, end, parallel->task);
    plii_thread.pass = pass;
    plii_walk_end(&walk);
}

bool plii_has_threads(const pli_context* context) {
    return context->def.parallel_for != NULL && plii_walk_find(context, PLII_WALK_PARALLEL) == NULL;
}

void plii_parallel_run(pli_context* context, pli_range_fn* range, void* task, int count, int grain) {
    if (!plii_has_threads(context)) {
        range(0, count, task);
        return;
    }
    parallel_task parallel = {context, range, task, plii_thread.pass};
    plii_walk walk;
    plii_walk_begin(&walk, context, PLII_WALK_STEP);
    context->def.parallel_for(parallel_range, &parallel, count, grain, context->def.parallel_user);
    plii_walk_end(&walk);
}

pli_status plii_fail(pli_context* context, pli_status status, const char* function, const char* format, ...) {
    if (context == NULL && !PLIANT_CHECKED) { return status; }
    char message[sizeof context->last_error];
    const int prefix = snprintf(message, sizeof message, "%s: ", function);
    if (prefix >= 0 && (size_t)prefix < sizeof message) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(message + prefix, sizeof message - (size_t)prefix, format, arguments);
        va_end(arguments);
    }
#if PLIANT_CHECKED
    if (context == NULL) {
        memcpy(context_lost_error, message, strlen(message) + 1);
        return status;
    }
#endif
    const bool is_logging = plii_walk_find(context, PLII_WALK_LOG) != NULL;
    const bool was_locked = plii_context_lock(context);
    memcpy(context->last_error, message, strlen(message) + 1);
    /* A call that fails inside of the log function is not logged, and its message does not stay. */
    if (context->def.log != NULL && !is_logging) {
        plii_walk walk;
        plii_walk_begin(&walk, context, PLII_WALK_LOG);
        context->def.log(PLI_LOG_ERROR, message, context->def.log_user);
        plii_walk_end(&walk);
        memcpy(context->last_error, message, strlen(message) + 1);
    }
    plii_context_unlock(context, was_locked);
    return status;
}

pli_status plii_refuse_change(pli_context* context, const char* function) {
    return plii_fail(context, PLI_ERROR_WRONG_STATE, function, "not allowed inside of a callback");
}

void* plii_allocate(pli_context* context, size_t size) {
    if (size == 0) { return NULL; }
    const bool was_locked = plii_context_lock(context);
    plii_walk walk;
    plii_walk_begin(&walk, context, PLII_WALK_HOOK);
    void* block = NULL;
    if (size <= (size_t)PTRDIFF_MAX) {
        block = context->def.allocator.allocate(size, PLII_ALIGNMENT, context->def.allocator.user);
    }
    plii_walk_end(&walk);
    if (block == NULL) {
        context->shortage.size = size;
        context->shortage.pass = plii_thread.pass;
        PLII_STORE(&context->shortage.count, context->shortage.count + 1);
        plii_thread.shortages += 1;
    } else {
        PLII_STORE(&context->allocated_bytes, context->allocated_bytes + size);
        PLII_STORE(&context->allocation_count, context->allocation_count + 1);
    }
    plii_context_unlock(context, was_locked);
    if (block != NULL && !context->has_zeroed_memory) { memset(block, 0, size); }
    return block;
}

void plii_release(pli_context* context, void* block, size_t size) {
    if (block == NULL) { return; }
    const bool was_locked = plii_context_lock(context);
    PLII_STORE(&context->allocated_bytes, context->allocated_bytes - size);
    plii_walk walk;
    plii_walk_begin(&walk, context, PLII_WALK_HOOK);
    context->def.allocator.release(block, size, context->def.allocator.user);
    plii_walk_end(&walk);
    plii_context_unlock(context, was_locked);
}

bool plii_allocate_array(pli_context* context, void** pointer, size_t size) {
    *pointer = plii_allocate(context, size);
    return *pointer != NULL || size == 0;
}

bool plii_reserve(pli_context* context, void** data, int* capacity, int needed, size_t element_size) {
    if (needed <= *capacity) { return true; }
    int grown = *capacity < 8 ? 8 : *capacity <= INT32_MAX / 2 ? *capacity * 2 : INT32_MAX;
    if (grown < needed) { grown = needed; }
    void* block = plii_allocate(context, plii_array_bytes((size_t)grown, element_size));
    if (block == NULL) { return false; }
    const size_t old_size = (size_t)*capacity * element_size;
    if (old_size > 0) { memcpy(block, *data, old_size); }
    plii_release(context, *data, old_size);
    *data = block;
    *capacity = grown;
    return true;
}

void* plii_duplicate(pli_context* context, const void* block, size_t size) {
    void* copy = plii_allocate(context, size);
    if (copy != NULL) { memcpy(copy, block, size); }
    return copy;
}

void* plii_scratch_take(plii_scratch* scratch, size_t size) {
    void* memory = plii_allocate(scratch->context, size);
    if (memory == NULL) {
        scratch->is_short = scratch->is_short || size > 0;
        return NULL;
    }
    scratch->blocks[scratch->count].memory = memory;
    scratch->blocks[scratch->count++].size = size;
    return memory;
}

void plii_scratch_free(plii_scratch* scratch) {
    while (scratch->count > 0) {
        scratch->count -= 1;
        plii_release(scratch->context, scratch->blocks[scratch->count].memory, scratch->blocks[scratch->count].size);
    }
}
