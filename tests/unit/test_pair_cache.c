/* What pairs remember from step to step, and how much room that takes. */

#include "check.h"

#include "geometry/pair_cache.h"

#include <pliant/pliant.h>

static const plii_pair_key first_key = {1, 2, NULL, 3}, second_key = {2, 1, NULL, 3};

static pli_context* create_context(void) {
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    return context;
}

static void test_pairs_are_remembered_for_a_step(void** state) {
    (void)state;
    pli_context* context = create_context();
    plii_pair_cache memory = {0};
    assert_true(plii_pair_cache_begin_step(context, &memory));
    plii_pair_cache_get(context, &memory, first_key)->cache.count = 3;
    memory.present.items[0].slot = 7;
    assert_null(plii_pair_cache_find(&memory, first_key));
    assert_true(plii_pair_cache_begin_step(context, &memory));
    assert_int_equal(plii_pair_cache_find(&memory, first_key)->count, 3);
    assert_null(plii_pair_cache_find(&memory, second_key));
    assert_int_equal(plii_pair_cache_get(context, &memory, second_key)->cache.count, 0);
    assert_int_equal(plii_pair_cache_get(context, &memory, first_key)->cache.count, 3);
    assert_int_equal(memory.present.items[1].slot, 0);
    assert_true(plii_pair_cache_begin_step(context, &memory));
    assert_true(plii_pair_cache_begin_step(context, &memory));
    assert_null(plii_pair_cache_find(&memory, first_key));
    plii_pair_cache_release(context, &memory);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
}

/* Whatever sizes the two lists came to, steps that are alike add nothing. */
static void test_room_does_not_grow_by_itself(void** state) {
    (void)state;
    for (int room = 1; room < 40; ++room) {
        pli_context* context = create_context();
        plii_pair_cache memory = {0};
        (void)plii_pair_cache_get(context, &memory, first_key);
        assert_true(plii_pair_cache_reserve(context, &memory, room));
        size_t settled = 0;
        for (int step = 0; step < 50; ++step) {
            assert_true(plii_pair_cache_begin_step(context, &memory));
            for (int i = 0; i < 20; ++i) {
                assert_non_null(plii_pair_cache_get(context, &memory, (plii_pair_key){i, 0, NULL, 0}));
            }
            if (step == 2) { settled = pli_context_allocated_bytes(context); }
        }
        assert_int_equal(pli_context_allocated_bytes(context), settled);
        assert_true(memory.present.capacity <= 80);
        plii_pair_cache_release(context, &memory);
        pli_context_destroy(context);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pairs_are_remembered_for_a_step),
        cmocka_unit_test(test_room_does_not_grow_by_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
