#pragma once

/* Hooks, memory and error messages. Several threads may be here at once: the parts of a parallel range, and steps of
   different worlds. Hooks of the user are called by one of them at a time. */

#include "pliant/base.h"

#include <stdbool.h>
#include <string.h>

/* What a step is at, and what it asks for memory for then. */
typedef struct plii_pass {
    int body;                                 /* index in its world, or PLI_NULL_INDEX */
    const struct plii_feature_class* feature; /* NULL: the solver */
} plii_pass;

/* Allocations that failed. */
typedef struct plii_shortage {
    uint64_t count;
    size_t size;    /* bytes, of the last one */
    plii_pass pass; /* likewise */
} plii_shortage;

/* What the user holds (base/handle.h). */
typedef enum plii_handle_kind {
    PLII_HANDLE_CONTEXT,
    PLII_HANDLE_WORLD,
    PLII_HANDLE_BODY,
    PLII_HANDLE_RIGID,
    PLII_HANDLE_MESH,
    PLII_HANDLE_SHAPE,
    PLII_HANDLE_KINDS
} plii_handle_kind;

struct pli_context {
    uint32_t magic;
    pli_context_def def;    /* `simd` is never PLI_SIMD_BEST */
    bool has_zeroed_memory; /* what the allocator gives is zero already */
    size_t allocated_bytes;
    uint64_t allocation_count;
    bool is_locked;         /* a thread is in a hook of the user, or writes what follows */
    plii_shortage shortage; /* the last one */
    char last_error[512];
    int alive[PLII_HANDLE_KINDS], triangles_count; /* how many there are */
};

/* Errors are rare: calls of what makes them are put out of the way. */
#if defined(__GNUC__)
#define PLII_COLD __attribute__((cold))
#else
#define PLII_COLD
#endif

/* Keeps "function: message", logs it, returns `status`. Without a context only a checked build keeps it. */
PLII_COLD pli_status plii_fail(pli_context* context, pli_status status, const char* function, const char* format, ...)
    PLI_PRINTF_LIKE(4, 5);
/* Of calls that no context could keep the message of; empty but in a checked build. */
const char* plii_lost_error(void);

#define PLII_FAIL(context, status, ...) plii_fail(context, status, __func__, __VA_ARGS__)
/* Returns early with an error where something is wrong and nothing is owned. */
#define PLII_FAIL_IF(is_wrong, context, status, function, ...)                                                         \
    do {                                                                                                               \
        if (is_wrong) { return plii_fail(context, status, function, __VA_ARGS__); }                                    \
    } while (0)

/* Returns early where nothing is owned. */
#define PLII_TRY(expression)                                                                                           \
    do {                                                                                                               \
        const pli_status plii_try_status = (expression);                                                               \
        if (plii_try_status != PLI_OK) { return plii_try_status; }                                                     \
    } while (0)

/* A public call that only looks at a handle: `value`, or `otherwise` where it is not one. */
#define PLII_DEFINE_GET(type, function, kind, value, otherwise)                                                        \
    type function(const pli_##kind* kind) {                                                                            \
        return plii_check_##kind(kind, __func__) == PLI_OK ? (value) : (otherwise);                                    \
    }

/* Why a thread is in the middle of something. */
typedef enum plii_walk_kind {
    PLII_WALK_STEP = 1,     /* of a world, or another change of many parts */
    PLII_WALK_PARALLEL = 2, /* a part of a range, on any thread */
    PLII_WALK_HOOK = 4,     /* the thread has the lock of the context */
    PLII_WALK_LOG = 8,      /* likewise, in the log function */
    PLII_WALK_RELEASE = 16, /* the end of a shape, which may retain and release others */
    PLII_WALK_ANY = 31
} plii_walk_kind;

/* While the library is in the middle of something, it may call hooks and callbacks of the user: nothing of the context
   may be changed then. Walks nest, and each thread knows its own: they are a list on its stack. Every public function
   that changes something asks plii_check_change before it does anything else. */
typedef struct plii_walk {
    const pli_context* context;
    const struct plii_walk* outer;
    plii_walk_kind kind;
} plii_walk;

/* What a thread is at. */
typedef struct plii_thread_state {
    const plii_walk* walk; /* the innermost, or NULL */
    plii_pass pass;
    uint64_t shortages; /* allocations of this thread that failed */
} plii_thread_state;
extern __thread plii_thread_state plii_thread;

static inline void plii_walk_begin(plii_walk* walk, const pli_context* context, plii_walk_kind kind) {
    walk->context = context;
    walk->outer = plii_thread.walk;
    walk->kind = kind;
    plii_thread.walk = walk;
}
/* In the order of their beginnings, from the last one. */
static inline void plii_walk_end(const plii_walk* walk) {
    plii_thread.walk = walk->outer;
}
/* The innermost walk of this thread through the context that is one of these kinds, or NULL. */
static inline const plii_walk* plii_walk_find(const pli_context* context, unsigned kinds) {
    const plii_walk* walk = plii_thread.walk;
    while (walk != NULL && (walk->context != context || !((unsigned)walk->kind & kinds))) {
        walk = walk->outer;
    }
    return walk;
}
/* PLI_OK, or the error of a null or wrong handle. */
pli_status plii_check_context(const pli_context* context, const char* function);
/* The same for a call that changes something, which must not come from a callback. */
pli_status plii_check_context_change(pli_context* context, const char* function);
/* The same for a call that makes something: where it is put, which messages call `name`, must not be null. */
pli_status plii_check_create(pli_context* context, const void* made, const char* name, const char* function);
/* Queries of shapes that this thread is in: no walks, as several may ask shapes of one context. */
extern __thread int plii_shape_queries;
PLII_COLD pli_status plii_refuse_change(pli_context* context, const char* function);
/* PLI_OK outside of walks. */
static inline pli_status plii_check_change(pli_context* context, const char* function) {
    const bool is_free = plii_walk_find(context, PLII_WALK_ANY) == NULL && plii_shape_queries == 0;
    return is_free ? PLI_OK : plii_refuse_change(context, function);
}

enum { PLII_ALIGNMENT = 64 }; /* bytes */

/* Of so many elements; what is too large for the processor to address becomes what cannot be allocated. */
static inline size_t plii_array_bytes(size_t count, size_t element_size) {
    return count <= (size_t)PTRDIFF_MAX / element_size ? count * element_size : SIZE_MAX;
}

/* Zeroed, so aligned; NULL when out of memory or when `size` is 0. */
void* plii_allocate(pli_context* context, size_t size);
/* NULL is allowed. */
void plii_release(pli_context* context, void* block, size_t size);

/* An array of `count` elements that `pointer` points to then; false when out of memory. */
bool plii_allocate_array(pli_context* context, void** pointer, size_t size);
#define PLII_ALLOCATE(context, pointer, count)                                                                         \
    plii_allocate_array(context, (void**)(pointer), plii_array_bytes((size_t)(count), sizeof **(pointer)))
#define PLII_RELEASE(context, array, count) plii_release(context, array, (size_t)(count) * sizeof *(array))

/* In a `for`: each of the items of an array, which may be NULL where there are none. */
#define PLII_EACH(type, item, items, count)                                                                            \
    type* item = (items);                                                                                              \
    item != NULL && (item) < (items) + (count);                                                                        \
    ++item
/* The same of an array of pointers: what each leads to. */
#define PLII_EACH_AT(type, item, items, count)                                                                         \
    type *const *plii_at_##item = (items), *item = NULL;                                                               \
    plii_at_##item != NULL&& plii_at_##item < (items) + (count) && ((item) = *plii_at_##item, true);                   \
    ++plii_at_##item

/* Takes the items of a list out for which `goes` is true, a condition on `item`; the others keep their order. */
#define PLII_REMOVE_IF(type, item, items, count, goes)                                                                 \
    do {                                                                                                               \
        int plii_kept = 0;                                                                                             \
        for (PLII_EACH(type, item, items, count)) {                                                                    \
            if (!(goes)) { (items)[plii_kept++] = *item; }                                                             \
        }                                                                                                              \
        (count) = plii_kept;                                                                                           \
    } while (0)
/* Exchanges two values. */
#define PLII_SWAP(type, a, b)                                                                                          \
    do {                                                                                                               \
        type const plii_swapped = (a);                                                                                 \
        (a) = (b);                                                                                                     \
        (b) = plii_swapped;                                                                                            \
    } while (0)
/* Makes room for `needed` elements in a growable array, keeping what it holds; geometric growth. */
bool plii_reserve(pli_context* context, void** data, int* capacity, int needed, size_t element_size);
#define PLII_RESERVE(context, data, capacity, needed)                                                                  \
    plii_reserve(context, (void**)(data), capacity, needed, sizeof **(data))
/* The same for so many elements more than `count`, and for one more. */
#define PLII_RESERVE_MORE(context, data, capacity, count, more)                                                        \
    ((count) <= INT32_MAX - (more) && PLII_RESERVE(context, data, capacity, (count) + (more)))
#define PLII_GROW(context, data, capacity, count) PLII_RESERVE_MORE(context, data, capacity, count, 1)

/* Copies a block into a new one; NULL when out of memory or when `size` is 0. */
void* plii_duplicate(pli_context* context, const void* block, size_t size);

/* Memory that a function needs for a while: several blocks that go together, and one answer to whether all are there.

       plii_scratch scratch = {.context = context};
       int* stamps = PLII_TAKE(&scratch, int, node_count);
       int* queue = PLII_TAKE(&scratch, int, node_count);
       if (!scratch.is_short) { ... }
       plii_scratch_free(&scratch); */
enum { PLII_SCRATCH_BLOCKS = 16 };
typedef struct plii_scratch {
    pli_context* context;
    bool is_short; /* of memory, for one block at least */
    int count;
    struct {
        void* memory;
        size_t size;
    } blocks[PLII_SCRATCH_BLOCKS];
} plii_scratch;

/* Zeroed; NULL when out of memory, which is kept in `is_short`, or when `size` is 0. At most PLII_SCRATCH_BLOCKS. */
void* plii_scratch_take(plii_scratch* scratch, size_t size);
#define PLII_TAKE(scratch, type, count) plii_scratch_take(scratch, plii_array_bytes((size_t)(count), sizeof(type)))
void plii_scratch_free(plii_scratch* scratch);

/* Of what threads change in the context and its rigid bodies. False: an outer hook of this thread has it already. */
bool plii_context_lock(pli_context* context);
void plii_context_unlock(pli_context* context, bool was_locked);

/* Numbers that several threads read and write where no order matters. */
#define PLII_LOAD(place) __atomic_load_n(place, __ATOMIC_RELAXED)
#define PLII_STORE(place, value) __atomic_store_n(place, value, __ATOMIC_RELAXED)

/* Whether a range would be parted: there is a hook, and the thread is in no part of another range. */
bool plii_has_threads(const pli_context* context);
/* Through the hook. Within a part of another range everything is one part. */
void plii_parallel_run(pli_context* context, pli_range_fn* range, void* task, int count, int grain);
static inline void plii_parallel_for(pli_context* context, pli_range_fn* range, void* task, int count, int grain) {
    if (count > grain && context->def.parallel_for != NULL) {
        plii_parallel_run(context, range, task, count, grain);
    } else if (count > 0) {
        range(0, count, task);
    }
}

/* The one of name_base and name_avx2 that the context runs. */
#if defined(PLIANT_SIMD_X86) && PLIANT_SIMD_X86
#define PLII_KERNEL(context, name) ((context)->def.simd >= PLI_SIMD_AVX2 ? name##_avx2 : name##_base)
#else
#define PLII_KERNEL(context, name) ((void)(context), name##_base)
#endif

#define PLII_DEF_COOKIE 0x706c6931u
/* The call that gives the default of a definition: its members that are not 0, or 0. */
#define PLII_DEFINE_DEFAULT(type, ...)                                                                                 \
    type type##_default(void) {                                                                                        \
        return (type){__VA_ARGS__, .cookie = PLII_DEF_COOKIE};                                                         \
    }
