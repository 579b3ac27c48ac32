/* The pool of threads after more ranges than a test can run. */

#include "check.h"

#include "base/threads.c"

enum { COUNT = 100000 };

static void count_range(int begin, int end, void* task) {
    atomic_fetch_add((atomic_int*)task, end - begin);
}

/* Ranges of two parts leave stretches of the other threads as they were at the start. */
static void stretches_may_be_left_alone_for_long(void** unused) {
    (void)unused;
    static const uint64_t jobs[] = {0x7ffffff0u, 0x80000005u, 0xfffffffeu, UINT64_C(0x100000005)};
    for (int i = 0; i < 4; ++i) {
        pli_threads* pool = NULL;
        assert_int_equal(pli_threads_create(4, &pool), PLI_OK);
        atomic_store(&pool->work.part_size, 1); /* of a range of nothing, for threads that are awake */
        atomic_store(&pool->work.job, jobs[i]);
        for (int range = 0; range < 4; ++range) {
            atomic_int sum = 0;
            pli_threads_parallel_for(count_range, &sum, COUNT, 1, pool);
            assert_int_equal(sum, COUNT);
        }
        pli_threads_destroy(pool);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(stretches_may_be_left_alone_for_long)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
