#ifndef PLIANT_BASE_H
#define PLIANT_BASE_H

/// Status codes, allocator and log hooks, and the context that carries them.
///
/// The library calls hooks and callbacks of the user from the middle of its work: those of a context, a profile
/// function, controllers of joints, the surface of a cut, the functions of a shape. In all of them calls that only read
/// may be made; what would change, make or destroy anything in the context of the caller is refused with
/// PLI_ERROR_WRONG_STATE, and nothing is changed.
///
/// A handle (context, world, body, rigid body, mesh, shape) that is null gives PLI_ERROR_NULL_ARGUMENT, one of another
/// kind PLI_ERROR_STALE_ID, and calls without a status give zero, NULL or whatever is neutral. To use a handle after
/// its end is undefined behaviour, but in a checked build (CMake option PLIANT_CHECKED): there it gives
/// PLI_ERROR_STALE_ID and a message, without a look at memory that is gone. The address of a handle may be taken by
/// another one later.

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(PLIANT_SHARED)
#if defined(PLIANT_BUILDING)
#define PLI_API __declspec(dllexport)
#else
#define PLI_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define PLI_API __attribute__((visibility("default")))
#else
#define PLI_API
#endif

#if defined(__GNUC__)
#define PLI_PRINTF_LIKE(format_index, first_index) __attribute__((format(printf, format_index, first_index)))
#else
#define PLI_PRINTF_LIKE(format_index, first_index)
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define PLI_VERSION_MAJOR 0
#define PLI_VERSION_MINOR 1
#define PLI_VERSION_PATCH 0

/// The one list of status codes: X(name, value, text).
#define PLI_STATUS_LIST(X)                                                                                             \
    X(PLI_OK, 0, "ok")                                                                                                 \
    X(PLI_ERROR_NULL_ARGUMENT, 1, "a required pointer is null")                                                        \
    X(PLI_ERROR_INVALID_DEF, 2, "a definition was not made by its default function")                                   \
    X(PLI_ERROR_INVALID_VALUE, 3, "a value is outside its allowed range")                                              \
    X(PLI_ERROR_NOT_FINITE, 4, "a value is NaN or infinite")                                                           \
    X(PLI_ERROR_INDEX_OUT_OF_RANGE, 5, "an index is out of range")                                                     \
    X(PLI_ERROR_INVALID_MESH, 6, "the mesh cannot be used for this")                                                   \
    X(PLI_ERROR_STALE_ID, 7, "the id or handle names something that does not exist")                                   \
    X(PLI_ERROR_WRONG_STATE, 8, "the call is not allowed now")                                                         \
    X(PLI_ERROR_OUT_OF_MEMORY, 9, "out of memory")                                                                     \
    X(PLI_ERROR_FILE_OPEN, 10, "the file cannot be opened")                                                            \
    X(PLI_ERROR_FILE_FORMAT, 11, "the file is damaged or not of the expected format")

/// Result of every call that can fail. On any value but PLI_OK the outputs and the state are as they were before; the
/// one exception is PLI_ERROR_OUT_OF_MEMORY of the calls that make up a step (world.h), which goes on to its end.
typedef enum pli_status {
#define PLI_STATUS_ENUM(name, value, text) name = value,
    PLI_STATUS_LIST(PLI_STATUS_ENUM)
#undef PLI_STATUS_ENUM
} pli_status;

/// Short English text of a status code; never NULL.
PLI_API const char* pli_status_string(pli_status status);

/// Memory hooks. `allocate` returns a block aligned to `alignment` (a power of two, at most 64) or NULL;
/// `release` gets the size that was asked for. `release` is never called with NULL. Both may read only.
typedef struct pli_allocator {
    void* (*allocate)(size_t size, size_t alignment, void* user);
    void (*release)(void* block, size_t size, void* user);
    void* user;
} pli_allocator;

typedef enum pli_log_level { PLI_LOG_INFO = 0, PLI_LOG_WARNING = 1, PLI_LOG_ERROR = 2 } pli_log_level;

/// Receives one line without a newline. The library is silent when no log function is set. May read only; errors of
/// calls that it makes itself are not logged.
typedef void pli_log_fn(pli_log_level level, const char* message, void* user);

/// Work on [begin, end) of a range of work; called on any thread, parts at the same time.
typedef void pli_range_fn(int begin, int end, void* task);

/// Calls `range` for parts that make up [0, count), in any order and on any threads, and returns when all are done.
/// Parts below `grain` are not worth a thread. Results do not depend on how the range is parted. May read only.
typedef void pli_parallel_for_fn(pli_range_fn* range, void* task, int count, int grain, void* user);

/// Instruction sets of the inner loops. All give the same bits.
typedef enum pli_simd {
    PLI_SIMD_BEST = 0, ///< the fastest that the processor has
    PLI_SIMD_PORTABLE = 1,
    PLI_SIMD_SSE2 = 2,
    PLI_SIMD_AVX2 = 3,
    PLI_SIMD_NEON = 4,
    PLI_SIMD_AVX512 = 5 ///< AVX-512VL: vectors as in AVX2, twice the registers
} pli_simd;

/// Owner of the hooks and of the last error message. Every mesh, shape and world is made in a context and must be
/// destroyed before it.  One context is used by one thread at a time; different contexts never touch.
typedef struct pli_context pli_context;

typedef struct pli_context_def {
    pli_allocator allocator; ///< all NULL: the C library's allocator
    pli_log_fn* log;         ///< NULL: silent
    void* log_user;
    pli_parallel_for_fn* parallel_for; ///< NULL: everything on the calling thread
    void* parallel_user;
    /// How many parts of a range `parallel_for` runs at the same time, the caller's included; 0: not known. With it
    /// large grids are solved by threads that wait for each other only where their parts touch. Where the hook keeps
    /// fewer they do not meet, which costs some 0.1 ms now and then.
    int thread_count;
    pli_simd simd; ///< default PLI_SIMD_BEST
} pli_context_def;

PLI_API pli_context_def pli_context_def_default(void);

/// @param def NULL for the defaults
/// @return PLI_ERROR_NULL_ARGUMENT, PLI_ERROR_INVALID_VALUE (one of the two memory hooks missing, a negative number of
/// threads, or an instruction set that the processor or this build does not have), PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_context_create(const pli_context_def* def, pli_context** context);

/// NULL is allowed.
/// @return PLI_ERROR_WRONG_STATE, and the context stays, while worlds, meshes, shapes or triangles of it are alive (the
/// message says how many) and inside of a callback; PLI_ERROR_STALE_ID in a checked build when it is gone
PLI_API pli_status pli_context_destroy(pli_context* context);

/// What the last failed call in this context did wrong and where, in one line ("pli_mesh_append_link: node 17 is out
/// of range, the mesh has 9 nodes"). Empty when nothing has failed. Valid until the next failing call. NULL, or a
/// context that is gone, in a checked build: of the last call of this thread that failed without a context to keep the
/// message, since its handle was null or unknown or its context is gone; in other builds empty.
PLI_API const char* pli_last_error(const pli_context* context);

/// Bytes that the context holds through its allocator at the moment, and allocations made so far.
PLI_API size_t pli_context_allocated_bytes(const pli_context* context);
PLI_API uint64_t pli_context_allocation_count(const pli_context* context);

#define PLI_NULL_INDEX (-1)

#ifdef __cplusplus
}
#endif
#endif
