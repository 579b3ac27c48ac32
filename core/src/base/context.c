/* Memory and error messages. */

#include "base/context.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* A call that fails inside of the log function is not logged, and its message does not stay. */
static void context_log(pli_context* context, pli_log_level level, const char* message) {
    if (context->log == NULL || context->is_logging) { return; }
    context->is_logging = true;
    plii_walk_begin(context);
    context->log(level, message, context->log_user);
    plii_walk_end(context);
    context->is_logging = false;
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
    memcpy(context->last_error, message, strlen(message) + 1);
    context_log(context, PLI_LOG_ERROR, message);
    memcpy(context->last_error, message, strlen(message) + 1);
    return status;
}

_Thread_local int plii_shape_queries;

pli_status plii_refuse_change(pli_context* context, const char* function) {
    return plii_fail(context, PLI_ERROR_WRONG_STATE, function, "not allowed inside of a callback");
}

void* plii_allocate(pli_context* context, size_t size) {
    if (size == 0) { return NULL; }
    plii_walk_begin(context);
    void* block = context->allocator.allocate(size, PLII_ALIGNMENT, context->allocator.user);
    plii_walk_end(context);
    if (block == NULL) {
        context->shortage = (plii_shortage){context->shortage.count + 1, size, context->pass};
        return NULL;
    }
    if (!context->has_zeroed_memory) { memset(block, 0, size); }
    context->allocated_bytes += size;
    context->allocation_count += 1;
    return block;
}

void plii_release(pli_context* context, void* block, size_t size) {
    if (block == NULL) { return; }
    context->allocated_bytes -= size;
    plii_walk_begin(context);
    context->allocator.release(block, size, context->allocator.user);
    plii_walk_end(context);
}

bool plii_allocate_array(pli_context* context, void** pointer, size_t size) {
    *pointer = plii_allocate(context, size);
    return *pointer != NULL || size == 0;
}

bool plii_reserve(pli_context* context, void** data, int* capacity, int needed, size_t element_size) {
    if (needed <= *capacity) { return true; }
    int grown = *capacity < 8 ? 8 : *capacity <= INT32_MAX / 2 ? *capacity * 2 : INT32_MAX;
    if (grown < needed) { grown = needed; }
    void* block = plii_allocate(context, (size_t)grown * element_size);
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
