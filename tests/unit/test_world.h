#ifndef TESTS_UNIT_TEST_WORLD_H
#define TESTS_UNIT_TEST_WORLD_H

/* An empty world for each test, and that nothing of it stays. */

#include "context_fixture.h"

#include <pliant/pliant.h>

#include <string.h>

static pli_world* world;

static inline int setup_world(void** unused) {
    if (setup_context(unused) != 0) { return -1; }
    return pli_world_create(context, NULL, &world) == PLI_OK ? 0 : -1;
}

static inline int setup_weightless_world(void** unused) {
    if (setup_context(unused) != 0) { return -1; }
    pli_world_def def = pli_world_def_default();
    def.gravity = pli_vec3_make(0, 0, 0);
    return pli_world_create(context, &def, &world) == PLI_OK ? 0 : -1;
}

static inline int teardown_world(void** unused) {
    pli_world_destroy(world);
    return teardown_context(unused);
}

/* Mean of the nodes' positions. */
static inline pli_vec3 middle_of(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    pli_vec3 sum = {0, 0, 0};
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i];
        sum = pli_vec3_add(sum, pli_vec3_scale(pli_vec3_make(x.x, x.y, x.z), 1.0f / (float)view.node_count));
    }
    return sum;
}

/* A call that fails with a message, and takes no memory. */
#define check_refused(call, expected_status, expected_text)                                                            \
    do {                                                                                                               \
        const size_t bytes = pli_context_allocated_bytes(context);                                                     \
        assert_int_equal(call, expected_status);                                                                       \
        if (strstr(pli_last_error(context), expected_text) == NULL) {                                                  \
            fail_msg("\"%s\" does not say \"%s\"", pli_last_error(context), expected_text);                            \
        }                                                                                                              \
        assert_int_equal(pli_context_allocated_bytes(context), bytes);                                                 \
    } while (0)

#endif
