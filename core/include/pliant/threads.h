#ifndef PLIANT_THREADS_H
#define PLIANT_THREADS_H

/// A pool of threads for pli_context_def::parallel_for, for programs without a job system. A program that does not name
/// it links neither the pool nor threads.
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

/// Threads that wait for work. A pool belongs to no context, and may serve several.
typedef struct pli_threads pli_threads;

/// The most threads of a pool.
#define PLI_MAX_THREADS 256

/// Starts the threads of a pool. Memory comes from the C library.
/// @param count 1 to PLI_MAX_THREADS. The thread that steps a world counts as one, so 1 starts none
/// @return PLI_ERROR_INVALID_VALUE for the count; PLI_ERROR_OUT_OF_MEMORY also when the system gives no threads. There
///         is no context to keep a message
PLI_API pli_status pli_threads_create(int count, pli_threads** threads);

/// Ends the threads and waits for them. Contexts that use the pool must have been destroyed, or must not be used any
/// more. Not allowed inside a range. NULL is allowed.
PLI_API void pli_threads_destroy(pli_threads* threads);

/// Number of threads, including the one that steps; 0 for NULL.
PLI_API int pli_threads_count(const pli_threads* threads);

/// A pli_parallel_for_fn; `user` is the pool. One caller at a time has the threads: other callers, and calls inside a
/// range, meanwhile run on their own thread. Nothing waits for a thread that has not begun: its parts are run by
/// others.
PLI_API void pli_threads_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user);

#ifdef __cplusplus
}
#endif
#endif
