/* Hooks, memory accounting and error messages. */

#include "handle.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CONTEXT_ALIGNMENT 64u

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

/* Zeroed: of large blocks the system gives pages only as they are first written, which for some never comes. What
   calloc gave stands in front of the block. */
static void* context_default_allocate(size_t size, size_t alignment, void* user) {
    (void)user;
    const size_t front = sizeof(void*) + alignment - 1;
    char* base = size <= SIZE_MAX - front ? calloc(1, front + size) : NULL;
    if (base == NULL) { return NULL; }
    const uintptr_t least = (uintptr_t)base + sizeof(void*);
    char* block = base + sizeof(void*) + (alignment - least % alignment) % alignment;
    memcpy(block - sizeof base, &base, sizeof base);
    return block;
}

static void context_default_release(void* block, size_t size, void* user) {
    (void)size;
    (void)user;
    void* base = NULL;
    memcpy(&base, (char*)block - sizeof base, sizeof base);
    free(base);
}

static void context_serial_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)grain;
    (void)user;
    range(0, count, task);
}

static bool context_has_simd(pli_simd simd) {
    switch (simd) {
    case PLI_SIMD_PORTABLE:
        return true;
#if PLIANT_SIMD_X86
    case PLI_SIMD_SSE2:
        return true;
    case PLI_SIMD_AVX2:
        return __builtin_cpu_supports("avx2") != 0;
#endif
#if PLIANT_SIMD_NEON
    case PLI_SIMD_NEON:
        return true;
#endif
    default:
        return false;
    }
}

static pli_simd context_best_simd(void) {
    static const pli_simd best_first[] = {PLI_SIMD_AVX2, PLI_SIMD_SSE2, PLI_SIMD_NEON};
    for (size_t i = 0; i < sizeof best_first / sizeof *best_first; ++i) {
        if (context_has_simd(best_first[i])) { return best_first[i]; }
    }
    return PLI_SIMD_PORTABLE;
}

pli_context_def pli_context_def_default(void) {
    return (pli_context_def){.allocator = {context_default_allocate, context_default_release, NULL},
                             .cookie = PLII_DEF_COOKIE};
}

pli_status pli_context_create(const pli_context_def* def, pli_context** context) {
    if (context == NULL) { return PLI_ERROR_NULL_ARGUMENT; }
    pli_context_def used = def != NULL ? *def : pli_context_def_default();
    if (used.cookie != PLII_DEF_COOKIE) { return PLI_ERROR_INVALID_DEF; }
    if (used.allocator.allocate == NULL && used.allocator.release == NULL) {
        used.allocator = pli_context_def_default().allocator;
    }
    if (used.allocator.allocate == NULL || used.allocator.release == NULL) { return PLI_ERROR_INVALID_VALUE; }
    if (used.simd == PLI_SIMD_BEST) { used.simd = context_best_simd(); }
    if (!context_has_simd(used.simd)) { return PLI_ERROR_INVALID_VALUE; }
    pli_context* made = used.allocator.allocate(sizeof *made, CONTEXT_ALIGNMENT, used.allocator.user);
    if (made == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    memset(made, 0, sizeof *made);
    made->allocator = used.allocator;
    made->log = used.log;
    made->log_user = used.log_user;
    made->parallel_for = used.parallel_for != NULL ? used.parallel_for : context_serial_for;
    made->parallel_user = used.parallel_user;
    made->has_threads = used.parallel_for != NULL;
    made->simd = used.simd;
    if (!plii_handle_add_context(made)) {
        used.allocator.release(made, sizeof *made, used.allocator.user);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    *context = made;
    return PLI_OK;
}

/* "2 worlds, 1 mesh and 3 shapes are still alive" */
static pli_status context_check_empty(pli_context* context, const char* function) {
    const struct {
        int count;
        const char *one, *many;
    } kinds[] = {{context->world_count, "world", "worlds"},
                 {context->mesh_count, "mesh", "meshes"},
                 {context->shape_count, "shape", "shapes"},
                 {context->triangles_count, "set of triangles", "sets of triangles"}};
    enum { KINDS = sizeof kinds / sizeof *kinds };
    int left = 0;
    for (int i = 0; i < KINDS; ++i) {
        left += kinds[i].count > 0;
    }
    if (left == 0) { return PLI_OK; }
    char list[128] = "";
    size_t length = 0;
    const bool is_one = left == 1;
    int total = 0;
    for (int i = 0; i < KINDS; ++i) {
        if (kinds[i].count == 0) { continue; }
        total += kinds[i].count;
        const char* separator = length == 0 ? "" : left == 1 ? " and " : ", ";
        length += (size_t)snprintf(list + length, sizeof list - length, "%s%d %s", separator, kinds[i].count,
                                   kinds[i].count == 1 ? kinds[i].one : kinds[i].many);
        left -= 1;
    }
    return plii_fail(context, PLI_ERROR_WRONG_STATE, function, "%s %s still alive", list,
                     is_one && total == 1 ? "is" : "are");
}

pli_status pli_context_destroy(pli_context* context) {
    if (context == NULL) { return PLI_OK; }
    PLII_TRY(plii_check_context_change(context, __func__));
    PLII_TRY(context_check_empty(context, __func__));
    plii_handle_retire(context);
    context->allocator.release(context, sizeof *context, context->allocator.user);
    return PLI_OK;
}

/* Of calls that no context could keep the message of. */
#if PLIANT_CHECKED
static _Thread_local char context_lost_error[sizeof((pli_context*)NULL)->last_error];
#else
static const char context_lost_error[1] = "";
#endif

const char* pli_last_error(const pli_context* context) {
    return plii_handle_is_alive(context, PLII_HANDLE_CONTEXT) ? context->last_error : context_lost_error;
}
size_t pli_context_allocated_bytes(const pli_context* context) {
    return plii_check_context(context, __func__) == PLI_OK ? context->allocated_bytes : 0;
}
uint64_t pli_context_allocation_count(const pli_context* context) {
    return plii_check_context(context, __func__) == PLI_OK ? context->allocation_count : 0;
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

void plii_log(pli_context* context, pli_log_level level, const char* format, ...) {
    if (context->log == NULL) { return; }
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    context_log(context, level, message);
}

pli_status plii_check_context(const pli_context* context, const char* function) {
    return plii_check_handle(context, PLII_HANDLE_CONTEXT, NULL, NULL, function);
}

pli_status plii_check_context_change(pli_context* context, const char* function) {
    PLII_TRY(plii_check_context(context, function));
    return plii_check_change(context, function);
}

_Thread_local int plii_shape_queries;

pli_status plii_refuse_change(pli_context* context, const char* function) {
    return plii_fail(context, PLI_ERROR_WRONG_STATE, function, "not allowed inside of a callback");
}

void* plii_allocate(pli_context* context, size_t size) {
    if (size == 0) { return NULL; }
    plii_walk_begin(context);
    void* block = context->allocator.allocate(size, CONTEXT_ALIGNMENT, context->allocator.user);
    plii_walk_end(context);
    if (block == NULL) {
        context->shortage = (plii_shortage){context->shortage.count + 1, size, context->pass};
        return NULL;
    }
    if (context->allocator.allocate != context_default_allocate) { memset(block, 0, size); }
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
