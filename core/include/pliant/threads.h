#ifndef PLIANT_THREADS_H
#define PLIANT_THREADS_H

/// Threads for the hook of contexts, for programs that have no job system. Nothing of it is linked, and no threads
/// either, unless a program names it.
///
///     pli_threads* threads = NULL;
///     pli_threads_create(4, &threads);
///     pli_context_def def = pli_context_def_default();
///     def.parallel_for = pli_threads_parallel_for;
///     def.parallel_user = threads;

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Threads that wait for work; they belong to no context, and may serve several.
typedef struct pli_threads pli_threads;

/// The most threads of a pool.
#define PLI_MAX_THREADS 256

/// Starts threads. Memory comes from the C library.
/// @param count 1 to PLI_MAX_THREADS; the thread that steps a world is one of them, so that 1 starts none
/// @return PLI_ERROR_INVALID_VALUE: the count; PLI_ERROR_OUT_OF_MEMORY, also where the system gives no threads;
///         there is no context to keep a message
PLI_API pli_status pli_threads_create(int count, pli_threads** threads);

/// Ends the threads and waits for them. Contexts that have this hook must be gone, or not be used any more. Not from
/// within a range. NULL is allowed.
PLI_API void pli_threads_destroy(pli_threads* threads);

/// How many there are, the one that steps included; 0 for NULL.
PLI_API int pli_threads_count(const pli_threads* threads);

/// A pli_parallel_for_fn; `user` is the pool. One caller at a time has the threads: others that come meanwhile, and
/// calls from within a range, run alone. Nothing waits for a thread that has not begun: parts of such are run by
/// others.
PLI_API void pli_threads_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user);

#ifdef __cplusplus
}
#endif
#endif
