/* What base offers to hold things: compressed lists, disjoint sets, scratch memory, maps of edges. */

#include "check.h"
#include "failing_allocator.h"

#include "base/csr.h"
#include "base/edge_map.h"
#include "base/union_find.h"

#include <pliant/pliant.h>

static void test_lists_keep_the_order_of_items(void** state) {
    (void)state;
    const int keys[7] = {2, 0, 2, 3, 0, 2, 3};
    int begin[6] = {9, 9, 9, 9, 9, 9}, items[7];
    plii_csr_sort(5, 7, keys, begin, items);
    const int expected_begin[6] = {0, 2, 2, 5, 7, 7}, expected_items[7] = {1, 4, 0, 2, 5, 3, 6};
    assert_memory_equal(begin, expected_begin, sizeof begin);
    assert_memory_equal(items, expected_items, sizeof items);
    plii_csr_sort(0, 0, NULL, begin, NULL);
    assert_int_equal(begin[0], 0);
}

static void test_the_root_of_a_set_is_its_smallest_index(void** state) {
    (void)state;
    const int joins[2][4][2] = {{{5, 3}, {1, 4}, {3, 4}, {6, 2}}, {{2, 6}, {4, 5}, {4, 1}, {5, 3}}};
    const int expected[7] = {0, 1, 2, 1, 1, 1, 2};
    for (int order = 0; order < 2; ++order) {
        int parents[7];
        plii_union_start(7, parents);
        for (int i = 0; i < 4; ++i) {
            plii_union_join(parents, joins[order][i][0], joins[order][i][1]);
        }
        plii_union_flatten(7, parents);
        assert_memory_equal(parents, expected, sizeof parents);
    }
}

/* With the n-th allocation failing all is given back, and the lack is known. */
static void test_scratch_is_all_or_nothing(void** state) {
    (void)state;
    for (int allowed = 0; allowed <= 3; ++allowed) {
        failing_allocator memory;
        pli_context* context = failing_context(&memory);
        memory.fail_at = allowed + 1;
        memory.fails_for_good = true;
        plii_scratch scratch = {.context = context};
        const int* first = PLII_TAKE(&scratch, int, 10);
        assert_null(PLII_TAKE(&scratch, int, 0));
        const char* second = PLII_TAKE(&scratch, char, 5);
        const double* third = PLII_TAKE(&scratch, double, 2);
        assert_int_equal(first != NULL, allowed > 0);
        assert_int_equal(second != NULL, allowed > 1);
        assert_int_equal(third != NULL, allowed > 2);
        assert_int_equal(scratch.is_short, allowed < 3);
        if (allowed == 3) { assert_true(first[9] == 0 && second[4] == 0 && third[1] == 0.0); }
        plii_scratch_free(&scratch);
        assert_int_equal(pli_context_allocated_bytes(context), 0);
        pli_context_destroy(context);
    }
}

/* As of meshes of some hundred million nodes where addresses have 32 bits. */
static void test_sizes_do_not_wrap(void** state) {
    (void)state;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    const size_t huge = SIZE_MAX / 8 + 9; /* eight of them are 64 bytes */
    void* data = NULL;
    int capacity = 0;
    assert_false(plii_reserve(context, &data, &capacity, 8, huge));
    assert_null(data);
    assert_int_equal(capacity, 0);
    uint64_t* numbers = NULL;
    assert_false(PLII_ALLOCATE(context, &numbers, huge));
    plii_scratch scratch = {.context = context};
    assert_null(PLII_TAKE(&scratch, uint64_t, huge));
    assert_true(scratch.is_short);
    plii_scratch_free(&scratch);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
}

static void test_edges_are_ordered_by_their_nodes(void** state) {
    (void)state;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_edge_map map = {.table.context = context};
    const int edges[5][2] = {{4, 2}, {0, 3}, {2, 3}, {3, 0}, {1, 0}}, expected[4] = {3, 1, 2, 0};
    for (int i = 0; i < 5; ++i) {
        const plii_edge* edge = plii_edge_map_add(&map, edges[i][0], edges[i][1]);
        assert_int_equal(edge - map.edges, i == 4 ? 3 : i == 3 ? 1 : i);
    }
    plii_scratch scratch = {.context = context};
    const int* order = plii_edge_map_order(&map, 5, &scratch);
    assert_non_null(order);
    assert_memory_equal(order, expected, sizeof expected);
    assert_ptr_equal(plii_edge_map_find(&map, 2, 4), &map.edges[0]);
    assert_null(plii_edge_map_find(&map, 1, 4));
    plii_scratch_free(&scratch);
    plii_edge_map_free(&map);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
}

static void test_keys_are_found_after_the_table_has_grown(void** state) {
    (void)state;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_key_table table = {.context = context};
    assert_int_equal(plii_key_table_find(&table, 5), PLI_NULL_INDEX);
    for (int i = 0; i < 1000; ++i) {
        assert_int_equal(plii_key_table_add(&table, plii_edge_key(i, 2 * i), i), i);
        assert_int_equal(plii_key_table_add(&table, plii_edge_key(2 * i, i), -7), i);
    }
    for (int i = 0; i < 1000; ++i) {
        assert_int_equal(plii_key_table_find(&table, plii_edge_key(2 * i, i)), i);
        assert_int_equal(plii_key_table_find(&table, plii_edge_key(i, 2 * i + 1)), PLI_NULL_INDEX);
    }
    assert_int_equal(plii_key_table_add(&table, plii_edge_key(3, 6), 1000), 3);
    assert_int_equal(table.count, 1000);
    plii_key_table_clear(&table);
    assert_int_equal(plii_key_table_find(&table, plii_edge_key(3, 6)), PLI_NULL_INDEX);
    assert_int_equal(plii_key_table_add(&table, plii_edge_key(3, 6), 7), 7);
    plii_key_table_free(&table);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lists_keep_the_order_of_items),
        cmocka_unit_test(test_the_root_of_a_set_is_its_smallest_index),
        cmocka_unit_test(test_scratch_is_all_or_nothing),
        cmocka_unit_test(test_sizes_do_not_wrap),
        cmocka_unit_test(test_edges_are_ordered_by_their_nodes),
        cmocka_unit_test(test_keys_are_found_after_the_table_has_grown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
