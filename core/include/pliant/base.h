#ifndef PLIANT_BASE_H
#define PLIANT_BASE_H

/// Status codes, allocator and log hooks, and the context that carries them.
///
/// Errors. Any call may return those of this list that apply to it; "@return" names only what needs more words.
///
///     PLI_ERROR_NULL_ARGUMENT  a handle, a required pointer or the place for a result is NULL
///     PLI_ERROR_STALE_ID       a handle is of another kind than the call takes
///     PLI_ERROR_INVALID_DEF    a definition does not come from its default function
///     PLI_ERROR_NOT_FINITE     a number is NaN or infinite
///     PLI_ERROR_INVALID_VALUE  a number is outside the range that is named beside it (limits.h)
///     PLI_ERROR_WRONG_STATE    the call was made inside a callback and would change something
///     PLI_ERROR_OUT_OF_MEMORY  from calls that create, append, add or enable
///
/// On an error, calls without a status return zero, NULL or another neutral value.
///
/// Definitions. A call that needs more than one number takes a definition: a struct that its `_default` function fills
/// in. Change the fields that should differ; the call copies it. A single number is passed directly. Calls that enable
/// something, and others that say so, take NULL for the defaults.
///
/// Features. pli_body_enable_x turns something on, or changes it when it is on; pli_body_disable_x turns it off, and
/// does nothing when it is off. Both return a status.
///
/// Getters. pli_x_get_y returns what is stored. Measures (pli_body_volume, pli_body_momentum) and counts
/// (pli_x_y_count) are nouns. A measure that needs memory returns a status (pli_body_count_parts). Getters of lists
/// fill the room that the caller gives and return how many entries there are.
///
/// Callbacks. The library calls hooks and callbacks of the user in the middle of its work: those of a context, a
/// profile function, controllers of joints, the surface of a cut, the functions of a shape, and those that a file of a
/// world needs. Inside them, calls that only read are allowed. A call that would change, make or destroy anything in
/// the context is refused with PLI_ERROR_WRONG_STATE, and nothing is changed.
///
/// Handles (context, world, body, rigid body, mesh, shape). Using a handle after its end is undefined behaviour. In a
/// checked build (CMake option PLIANT_CHECKED) it gives PLI_ERROR_STALE_ID and a message instead, without reading
/// memory that is gone. A later handle may have the same address.
///
/// Time. "Not while stepping" means: PLI_ERROR_WRONG_STATE between pli_world_predict and pli_world_solve. Calls without
/// this note are allowed there.

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

/// Short English text of a status code, as in PLI_STATUS_LIST; "unknown status" for other numbers, never NULL.
PLI_API const char* pli_status_string(pli_status status);

/// Memory hooks; both or none. They may read only. Those of a context are called by one thread at a time, which may be
/// any thread.
typedef struct pli_allocator {
    /// A block of `size` bytes aligned to `alignment` (a power of two, at most 64), or NULL.
    void* (*allocate)(size_t size, size_t alignment, void* user);
    /// Releases a block, given with the size that was asked for; never called with NULL.
    void (*release)(void* block, size_t size, void* user);
    void* user; ///< handed to both
} pli_allocator;

/// How serious a message is.
typedef enum pli_log_level {
    PLI_LOG_INFO = 0,    ///< reserved: nothing is logged at this level yet
    PLI_LOG_WARNING = 1, ///< reserved: nothing is logged at this level yet
    PLI_LOG_ERROR = 2    ///< a call has failed; the text of pli_last_error
} pli_log_level;

/// Receives one line without a newline. The library is silent when no log function is set. It may read only; errors of
/// calls that the function makes itself are not logged.
typedef void pli_log_fn(pli_log_level level, const char* message, void* user);

/// Work on [begin, end) of a range of work; called on any thread, parts at the same time.
typedef void pli_range_fn(int begin, int end, void* task);

/// Calls `range` for parts that make up [0, count), in any order and on any threads, and returns when all are done.
/// Parts smaller than `grain` are not worth a thread. Results do not depend on how the range is divided, and no part
/// waits for another one. Several threads call it at once when worlds of the context step at the same time. It may read
/// only.
typedef void pli_parallel_for_fn(pli_range_fn* range, void* task, int count, int grain, void* user);

/// Instruction sets of the inner loops. All give the same bits.
typedef enum pli_simd {
    PLI_SIMD_BEST = 0,     ///< the fastest that the processor has
    PLI_SIMD_PORTABLE = 1, ///< what every processor of the target has
    PLI_SIMD_SSE2 = 2,     ///< the same as PLI_SIMD_PORTABLE, on x86-64 only: four floats at a time
    PLI_SIMD_AVX2 = 3,     ///< eight floats at a time, x86-64 since about 2013
    PLI_SIMD_NEON = 4,     ///< the same as PLI_SIMD_PORTABLE, on 64-bit ARM only: four floats at a time
    PLI_SIMD_AVX512 = 5    ///< sixteen floats at a time where that is faster, with AVX-512 F, DQ and VL
} pli_simd;

/// Owns the hooks and the last error message. Every mesh, shape and world is made in a context and must be destroyed
/// before it. Only one thread may use a context at a time, except that different worlds of it may step at the same
/// time. Different contexts share nothing.
typedef struct pli_context pli_context;

/// Hooks and threads of a context.
typedef struct pli_context_def {
    pli_allocator allocator;           ///< default, and where all is NULL: the C library's allocator
    pli_log_fn* log;                   ///< default NULL: silent
    void* log_user;                    ///< handed to `log`
    pli_parallel_for_fn* parallel_for; ///< default NULL: everything on the calling thread
    void* parallel_user;               ///< handed to `parallel_for`
    pli_simd simd;                     ///< default PLI_SIMD_BEST
    uint32_t cookie;                   ///< set by the default function
} pli_context_def;

/// Defaults of the fields.
PLI_API pli_context_def pli_context_def_default(void);

/// Makes a context, the first thing that a program needs.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_VALUE: one of the two memory hooks missing or still that of the C library, or an
///         instruction set that the processor or this build does not have
PLI_API pli_status pli_context_create(const pli_context_def* def, pli_context** context);

/// Destroys a context that holds nothing any more. NULL is allowed.
/// @return PLI_ERROR_WRONG_STATE, and the context stays, while worlds, meshes, shapes or triangles of it are alive (the
///         message says how many)
PLI_API pli_status pli_context_destroy(pli_context* context);

/// What the last failed call in this context did wrong and where, in one line ("pli_mesh_append_link: node 17 is out
/// of range, the mesh has 9 nodes"). Empty when nothing has failed. Valid until the next failing call.
/// Given NULL, or in a checked build a context that is gone, it returns the message of this thread's last call that had
/// no context to keep it in (its handle was null or unknown, or its context is gone). Other builds keep no such message
/// and return an empty one.
PLI_API const char* pli_last_error(const pli_context* context);

/// For code that is built on the library, as the bridge is, and finds an error itself: makes "function: message" the
/// text of pli_last_error and calls the log function. Allowed in callbacks. Does nothing for PLI_OK.
/// @param function name of the call that has failed
/// @param message  what is wrong, in one line
/// @return `status`, for the caller to return
PLI_API pli_status pli_context_fail(pli_context* context, pli_status status, const char* function, const char* message);

/// Bytes that the context holds through its allocator at the moment.
PLI_API size_t pli_context_allocated_bytes(const pli_context* context);

/// Allocations that the context has made so far; a step in a steady state adds none.
PLI_API uint64_t pli_context_allocation_count(const pli_context* context);

/// No node, link, face or tetrahedron.
#define PLI_NULL_INDEX (-1)

#ifdef __cplusplus
}
#endif
#endif
