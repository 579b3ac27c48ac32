#ifndef TESTS_UNIT_WORLD_FIXTURE_H
#define TESTS_UNIT_WORLD_FIXTURE_H

/* A world of its own for each test, handed over as its state. */

#include <pliant/world.h>

#include <stdlib.h>

typedef struct fixture {
    pli_context* context;
    pli_world* world;
} fixture;

static inline int setup_fixture(void** state) {
    fixture* f = calloc(1, sizeof *f);
    if (f == NULL || pli_context_create(NULL, &f->context) != PLI_OK) { return -1; }
    *state = f;
    return pli_world_create(f->context, NULL, &f->world) == PLI_OK ? 0 : -1;
}

static inline int teardown_fixture(void** state) {
    fixture* f = *state;
    pli_world_destroy(f->world);
    const size_t left = pli_context_allocated_bytes(f->context);
    pli_context_destroy(f->context);
    free(f);
    return left == 0 ? 0 : -1;
}

#endif
