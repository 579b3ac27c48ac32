#ifndef TESTS_FAILING_ALLOCATOR_H
#define TESTS_FAILING_ALLOCATOR_H

/* An allocator that counts what is alive and fails at the n-th call, or from it on, and a check that runs an operation
   with every such n: it must fail with PLI_ERROR_OUT_OF_MEMORY, and in the end nothing may be left. */

#include "check.h"

#include <pliant/base.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct failing_allocator {
    long fail_at;        /* calls until the failure, 0 = never */
    bool fails_for_good; /* from then on, until fail_at is set again */
    long alive;          /* bytes */
    long calls, failed;  /* so far */
} failing_allocator;

static inline void* failing_allocate(size_t size, size_t alignment, void* user) {
    failing_allocator* self = (failing_allocator*)user;
    ++self->calls;
    if (self->fail_at > 0 && --self->fail_at == 0) {
        ++self->failed;
        if (self->fails_for_good) { self->fail_at = 1; }
        return NULL;
    }
    void* block = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (block != NULL) { self->alive += (long)size; }
    return block;
}

static inline void failing_release(void* block, size_t size, void* user) {
    failing_allocator* self = (failing_allocator*)user;
    self->alive -= (long)size;
    free(block);
}

static inline pli_context* failing_context(failing_allocator* self) {
    memset(self, 0, sizeof *self);
    pli_context_def def = pli_context_def_default();
    def.allocator.allocate = failing_allocate;
    def.allocator.release = failing_release;
    def.allocator.user = self;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    return context;
}

/* `operation` must release everything that it makes, whatever it returns. Gives the number of failures it survived. */
static inline int check_survives_failing_allocator(pli_status (*operation)(pli_context*, void*), void* user) {
    failing_allocator allocator;
    pli_context* context = failing_context(&allocator);
    const long at_rest = allocator.alive;
    int failures = 0;
    for (;; ++failures) {
        allocator.fail_at = failures + 1;
        const pli_status status = operation(context, user);
        assert_int_equal(allocator.alive, at_rest);
        if (status == PLI_OK) { break; }
        assert_int_equal(status, PLI_ERROR_OUT_OF_MEMORY);
        assert_non_null(strstr(pli_last_error(context), "memory"));
    }
    allocator.fail_at = 0;
    pli_context_destroy(context);
    assert_int_equal(allocator.alive, 0);
    return failures;
}

#endif
