#ifndef TESTS_UNIT_CONTEXT_FIXTURE_H
#define TESTS_UNIT_CONTEXT_FIXTURE_H

/* A context for the tests of a file, and that nothing of it stays. */

#include "check.h"

#include <pliant/base.h>

static pli_context* context;

static inline int setup_context(void** unused) {
    (void)unused;
    return pli_context_create(NULL, &context) == PLI_OK ? 0 : -1;
}

static inline int teardown_context(void** unused) {
    (void)unused;
    const size_t left = pli_context_allocated_bytes(context);
    pli_context_destroy(context);
    return left == 0 ? 0 : -1;
}

#endif
