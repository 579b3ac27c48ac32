/* Life of a context: its definition, the allocator of the C library, instruction sets. */

#include "base/handle.h"

#include <stdlib.h>

/* Zeroed: of large blocks the system gives pages only when written. What calloc gave stands in front of the block. */
static void* context_default_allocate(size_t size, size_t alignment, void* user) {
    const size_t front = sizeof(void*) + alignment - 1;
    char* base = size <= SIZE_MAX - front ? calloc(1, front + size) : NULL;
    if (base == NULL) { return NULL; }
    const uintptr_t least = (uintptr_t)base + sizeof(void*);
    char* block = base + sizeof(void*) + (alignment - least % alignment) % alignment;
    memcpy(block - sizeof base, &base, sizeof base);
    return block;
}

static void context_default_release(void* block, size_t size, void* user) {
    void* base = NULL;
    memcpy(&base, (char*)block - sizeof base, sizeof base);
    free(base);
}

static bool context_has_simd(pli_simd simd) {
#if PLIANT_SIMD_X86
    if (simd == PLI_SIMD_AVX2) { return __builtin_cpu_supports("avx2") != 0; }
    if (simd == PLI_SIMD_AVX512) { /* both of which have F and AVX2 */
        return __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0;
    }
#endif
    return simd == PLI_SIMD_PORTABLE || (PLIANT_SIMD_X86 && simd == PLI_SIMD_SSE2) ||
           (PLIANT_SIMD_NEON && simd == PLI_SIMD_NEON);
}

static pli_simd context_best_simd(void) {
    static const pli_simd best_first[] = {PLI_SIMD_AVX512, PLI_SIMD_AVX2, PLI_SIMD_SSE2, PLI_SIMD_NEON};
    for (size_t i = 0; i < sizeof best_first / sizeof *best_first; ++i) {
        if (context_has_simd(best_first[i])) { return best_first[i]; }
    }
    return PLI_SIMD_PORTABLE;
}

PLII_DEFINE_DEFAULT(pli_context_def, .allocator = {context_default_allocate, context_default_release, NULL})

pli_status pli_context_create(const pli_context_def* def, pli_context** context) {
    if (context == NULL) { return PLI_ERROR_NULL_ARGUMENT; }
    pli_context_def used = def != NULL ? *def : pli_context_def_default();
    if (used.cookie != PLII_DEF_COOKIE) { return PLI_ERROR_INVALID_DEF; }
    if (used.allocator.allocate == NULL && used.allocator.release == NULL) {
        used.allocator = pli_context_def_default().allocator;
    }
    const bool is_own = used.allocator.allocate != context_default_allocate;
    const bool releases_own = used.allocator.release != context_default_release; /* which looks in front of the block */
    if (used.allocator.allocate == NULL || used.allocator.release == NULL || is_own != releases_own) {
        return PLI_ERROR_INVALID_VALUE;
    }
    if (used.simd == PLI_SIMD_BEST) { used.simd = context_best_simd(); }
    if (!context_has_simd(used.simd)) { return PLI_ERROR_INVALID_VALUE; }
    pli_context* made = used.allocator.allocate(sizeof *made, PLII_ALIGNMENT, used.allocator.user);
    if (made == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    memset(made, 0, sizeof *made);
    made->def = used;
    made->has_zeroed_memory = !is_own;
    if (!plii_handle_add_context(made)) {
        used.allocator.release(made, sizeof *made, used.allocator.user);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    *context = made;
    return PLI_OK;
}

pli_status pli_context_destroy(pli_context* context) {
    if (context == NULL) { return PLI_OK; }
    PLII_TRY(plii_check_context_change(context, __func__));
    const int* alive = context->alive; /* bodies and rigid bodies go with their world */
    const int sum = alive[PLII_HANDLE_WORLD] + alive[PLII_HANDLE_MESH] + alive[PLII_HANDLE_SHAPE];
    PLII_FAIL_IF(sum + context->triangles_count > 0, context, PLI_ERROR_WRONG_STATE, __func__,
                 "still alive are worlds: %d, meshes: %d, shapes: %d, sets of triangles: %d", alive[PLII_HANDLE_WORLD],
                 alive[PLII_HANDLE_MESH], alive[PLII_HANDLE_SHAPE], context->triangles_count);
    plii_handle_retire(context);
    context->def.allocator.release(context, sizeof *context, context->def.allocator.user);
    return PLI_OK;
}

const char* pli_last_error(const pli_context* context) {
    return plii_handle_is_alive(context, PLII_HANDLE_CONTEXT) ? context->last_error : plii_lost_error();
}
pli_status pli_context_fail(pli_context* context, pli_status status, const char* function, const char* message) {
    PLII_TRY(plii_check_context(context, __func__));
    if (status == PLI_OK) { return PLI_OK; }
    if (function == NULL || message == NULL) { return PLII_FAIL(context, status, "no function or message is given"); }
    return plii_fail(context, status, function, "%s", message);
}
PLII_DEFINE_GET(size_t, pli_context_allocated_bytes, context, PLII_LOAD(&context->allocated_bytes), 0)
PLII_DEFINE_GET(uint64_t, pli_context_allocation_count, context, PLII_LOAD(&context->allocation_count), 0)

pli_status plii_check_context(const pli_context* context, const char* function) {
    return plii_check_handle(context, PLII_HANDLE_CONTEXT, NULL, NULL, function);
}
pli_status plii_check_context_change(pli_context* context, const char* function) {
    PLII_TRY(plii_check_context(context, function));
    return plii_check_change(context, function);
}
pli_status plii_check_create(pli_context* context, const void* made, const char* name, const char* function) {
    PLII_TRY(plii_check_context_change(context, function));
    return made != NULL ? PLI_OK : plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "%s is null", name);
}
