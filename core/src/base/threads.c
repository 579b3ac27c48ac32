/* A pool of threads. Each, the caller's included, has a stretch of every range: the same nodes stay in the same cache.
   Whoever has finished waits a little, then takes parts of the others' stretches. Between two ranges, which follow each
   other after microseconds, workers look out for work for a while before they sleep. A line of memory that one thread
   writes and another reads takes longer than a short part, so there are few of them: the work, and what each thread has
   finished. POSIX threads: those of C are unknown to ThreadSanitizer. */

#include "pliant/threads.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { PARTS_PER_THREAD = 4, LINE = 64 };
enum { PART_BITS = 16, PART_MASK = (1 << PART_BITS) - 1 };
_Static_assert(PART_MASK / PARTS_PER_THREAD > PLI_MAX_THREADS, "");
/* Looks of some 40 cycles each. To look at another thread's stretch makes that one wait. */
enum { LOOKS_BEFORE_HELP = 50, LOOKS_BEFORE_YIELD = 2000, LOOKS_BEFORE_SLEEP = 20000 };

typedef struct threads_work {
    uint64_t job; /* 0: none */
    pli_range_fn* range;
    void* task;
    int count, part_size;
} threads_work;

/* Valid while `job` stays what it was before the rest was read. */
typedef struct threads_shared_work {
    _Alignas(LINE) _Atomic uint64_t job;
    _Atomic int count, part_size;
    _Atomic(pli_range_fn*) range;
    _Atomic(void*) task;
} threads_shared_work;

typedef struct threads_member {
    /* Of its stretch: the job in the upper 48 bits, the next part in the others; of an earlier job: the first. A
       stretch may be left alone for as long as ranges have few parts, so jobs are never counted from the beginning
       again. */
    _Alignas(LINE) _Atomic uint64_t next;
    _Alignas(LINE) _Atomic uint32_t finished; /* parts, by this thread since the pool was made */
    pli_threads* pool;
    pthread_t thread;
} threads_member;

struct pli_threads {
    threads_shared_work work;
    uint32_t published_parts; /* since the pool was made */
    int count;
    _Alignas(LINE) atomic_bool is_busy;
    atomic_bool is_ending;
    atomic_int sleeping;
    pthread_mutex_t mutex;
    pthread_cond_t work_came;
    threads_member members[];
};

static void threads_pause(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#else
    sched_yield();
#endif
}

/* Nobody takes parts of the last job any more; who reads the new one halfway sees no job. */
static void threads_publish(threads_shared_work* shared, const threads_work* work) {
    atomic_store_explicit(&shared->job, 0, memory_order_relaxed);
    atomic_store_explicit(&shared->count, work->count, memory_order_release);
    atomic_store_explicit(&shared->part_size, work->part_size, memory_order_release);
    atomic_store_explicit(&shared->range, work->range, memory_order_release);
    atomic_store_explicit(&shared->task, work->task, memory_order_release);
    atomic_store(&shared->job, work->job); /* before `sleeping` is read */
}

/* False when it was changed meanwhile. */
static bool threads_read(const threads_shared_work* shared, threads_work* work) {
    work->job = atomic_load_explicit(&shared->job, memory_order_acquire);
    work->count = atomic_load_explicit(&shared->count, memory_order_acquire);
    work->part_size = atomic_load_explicit(&shared->part_size, memory_order_acquire);
    work->range = atomic_load_explicit(&shared->range, memory_order_acquire);
    work->task = atomic_load_explicit(&shared->task, memory_order_acquire);
    return work->job != 0 && atomic_load_explicit(&shared->job, memory_order_relaxed) == work->job;
}

/* Takes parts of the stretch of one member, which another one may do at the same time. */
static void threads_run_stretch(pli_threads* pool, const threads_work* work, int of, int by) {
    const uint64_t parts = (uint64_t)((work->count - 1) / work->part_size + 1);
    const uint32_t begin_part = (uint32_t)(parts * (uint64_t)of / (uint64_t)pool->count);
    const uint32_t end_part = (uint32_t)(parts * ((uint64_t)of + 1) / (uint64_t)pool->count);
    _Atomic uint64_t* next = &pool->members[of].next;
    uint32_t done = 0;
    for (uint64_t word = atomic_load_explicit(next, memory_order_acquire);;) {
        const uint64_t job = word >> PART_BITS;
        const uint32_t part = job == work->job ? (uint32_t)word & PART_MASK : begin_part;
        if (job > work->job || part >= end_part) { break; } /* or another job has come already */
        const uint64_t taken = work->job << PART_BITS | (part + 1);
        if (!atomic_compare_exchange_weak_explicit(next, &word, taken, memory_order_acq_rel, memory_order_acquire)) {
            continue;
        }
        const int begin = (int)part * work->part_size, left = work->count - begin;
        work->range(begin, begin + (left < work->part_size ? left : work->part_size), work->task);
        done += 1;
        word = atomic_load_explicit(next, memory_order_acquire);
    }
    if (done > 0) { atomic_fetch_add_explicit(&pool->members[by].finished, done, memory_order_release); }
}

static void threads_sleep(pli_threads* pool, uint64_t last_job) {
    pthread_mutex_lock(&pool->mutex);
    atomic_fetch_add(&pool->sleeping, 1);
    while (!atomic_load(&pool->is_ending) && atomic_load(&pool->work.job) == last_job) {
        pthread_cond_wait(&pool->work_came, &pool->mutex);
    }
    atomic_fetch_sub(&pool->sleeping, 1);
    pthread_mutex_unlock(&pool->mutex);
}

static void threads_wake(pli_threads* pool) {
    pthread_mutex_lock(&pool->mutex);
    pthread_cond_broadcast(&pool->work_came);
    pthread_mutex_unlock(&pool->mutex);
}

static void* threads_member_run(void* data) {
    threads_member* member = data;
    pli_threads* pool = member->pool;
    const int self = (int)(member - pool->members);
    uint64_t last_job = 0;
    for (int looks = 0; !atomic_load_explicit(&pool->is_ending, memory_order_relaxed);) {
        threads_work work;
        if (atomic_load_explicit(&pool->work.job, memory_order_relaxed) != last_job &&
            threads_read(&pool->work, &work)) {
            threads_run_stretch(pool, &work, self, self);
            last_job = work.job;
            looks = 0;
            continue;
        }
        threads_pause();
        if (++looks == LOOKS_BEFORE_HELP && threads_read(&pool->work, &work) && work.job == last_job) {
            for (int i = 1; i < pool->count; ++i) {
                threads_run_stretch(pool, &work, (self + i) % pool->count, self);
            }
        } else if (looks >= LOOKS_BEFORE_SLEEP) {
            threads_sleep(pool, last_job);
            looks = 0;
        }
    }
    return NULL;
}

static bool threads_are_finished(const pli_threads* pool) {
    uint32_t parts = 0;
    for (int i = 0; i < pool->count; ++i) {
        parts += atomic_load_explicit(&pool->members[i].finished, memory_order_acquire);
    }
    return parts == pool->published_parts;
}

static void threads_run(pli_threads* pool, pli_range_fn* range, void* task, int count, int grain) {
    /* As many for each thread: all have the same share of every range. */
    const int wanted = count / grain, per_thread = wanted / pool->count;
    const int parts =
        wanted < pool->count ? wanted : pool->count * (per_thread < PARTS_PER_THREAD ? per_thread : PARTS_PER_THREAD);
    const uint64_t last_job = atomic_load_explicit(&pool->work.job, memory_order_relaxed);
    const threads_work work = {last_job + 1, range, task, count, (count - 1) / parts + 1};
    threads_publish(&pool->work, &work);
    if (atomic_load(&pool->sleeping) > 0) { threads_wake(pool); }
    pool->published_parts += (uint32_t)((count - 1) / work.part_size + 1);
    threads_run_stretch(pool, &work, 0, 0);
    for (int looks = 0; !threads_are_finished(pool); ++looks) {
        if (looks < LOOKS_BEFORE_YIELD) {
            threads_pause();
        } else {
            sched_yield();
        }
        if (looks % LOOKS_BEFORE_YIELD != LOOKS_BEFORE_HELP) { continue; }
        for (int i = 1; i < pool->count; ++i) {
            threads_run_stretch(pool, &work, i, 0);
        }
    }
}

void pli_threads_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    pli_threads* pool = user;
    const int least = grain > 1 ? grain : 1;
    if (pool == NULL || pool->count == 1 || count / 2 < least || atomic_exchange(&pool->is_busy, true)) {
        range(0, count, task);
        return;
    }
    threads_run(pool, range, task, count, least);
    atomic_store(&pool->is_busy, false);
}

int pli_threads_count(const pli_threads* threads) {
    return threads != NULL ? threads->count : 0;
}

/* The first `started` members run, or are the caller. */
static void threads_end(pli_threads* pool, int started) {
    atomic_store(&pool->is_ending, true);
    threads_wake(pool);
    for (int i = 1; i < started; ++i) {
        pthread_join(pool->members[i].thread, NULL);
    }
    pthread_cond_destroy(&pool->work_came);
    pthread_mutex_destroy(&pool->mutex);
    free(pool);
}

void pli_threads_destroy(pli_threads* threads) {
    if (threads != NULL) { threads_end(threads, threads->count); }
}

pli_status pli_threads_create(int count, pli_threads** threads) {
    if (threads == NULL) { return PLI_ERROR_NULL_ARGUMENT; }
    if (count < 1 || count > PLI_MAX_THREADS) { return PLI_ERROR_INVALID_VALUE; }
    const size_t size = sizeof(pli_threads) + (size_t)count * sizeof(threads_member);
    pli_threads* pool = aligned_alloc(LINE, size); /* a multiple of it, as both sizes are */
    if (pool == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    memset(pool, 0, size);
    pool->count = count;
    if (pthread_mutex_init(&pool->mutex, NULL) != 0 || pthread_cond_init(&pool->work_came, NULL) != 0) {
        free(pool);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    for (int i = 1; i < count; ++i) {
        pool->members[i].pool = pool;
        if (pthread_create(&pool->members[i].thread, NULL, threads_member_run, &pool->members[i]) != 0) {
            threads_end(pool, i);
            return PLI_ERROR_OUT_OF_MEMORY;
        }
    }
    *threads = pool;
    return PLI_OK;
}
