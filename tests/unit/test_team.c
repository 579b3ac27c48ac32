/* Teams of threads: they come together or not at all; shares of grids touch only where they should; bits are those of
   one thread. */

#include "check.h"
#include "sample_mesh.h"

#include <pliant/pliant.h>

#include "link_shares.h"

#include <pthread.h>
#include <stdlib.h>

// ---------------------------------------------------------------------------------------------------------- hooks

enum { MOST_PARTS = 16 };

typedef struct part {
    pli_range_fn* range;
    void* task;
    int index;
} part;

static void* run_part(void* data) {
    const part* own = data;
    own->range(own->index, own->index + 1, own->task);
    return NULL;
}

/* A thread for each of a few parts; long ranges run alone. */
static void in_threads(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)user;
    if (grain > 1 || count > MOST_PARTS) {
        range(0, count, task);
        return;
    }
    part parts[MOST_PARTS];
    pthread_t threads[MOST_PARTS];
    for (int i = 1; i < count; ++i) {
        parts[i] = (part){range, task, i};
        assert_int_equal(pthread_create(&threads[i], NULL, run_part, &parts[i]), 0);
    }
    range(0, 1, task);
    for (int i = 1; i < count; ++i) {
        pthread_join(threads[i], NULL);
    }
}
static void one_after_the_other(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)grain;
    *(int*)user += 1;
    for (int i = 0; i < count; ++i) {
        range(i, i + 1, task);
    }
}
static void in_one_piece(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)grain;
    *(int*)user += 1;
    range(0, count, task);
}

static pli_context* create_context(pli_parallel_for_fn* hook, void* user, int thread_count) {
    pli_context_def def = pli_context_def_default();
    def.parallel_for = hook;
    def.parallel_user = user;
    def.thread_count = thread_count;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    context->team_patience = 10000000; /* there may be fewer processors than threads */
    return context;
}

// --------------------------------------------------------------------------------------------------------- a team

enum { ROUNDS = 200, MEMBERS = 3 };

/* What members read of each other after each round, and write in the next one, without any lock. */
typedef struct rounds {
    int numbers[MEMBERS], calls[MEMBERS], sum_of_last[MEMBERS];
} rounds;

static void do_rounds(plii_team* team, int member, void* data) {
    rounds* all = data;
    all->calls[member] += 1;
    for (int i = 0; i < ROUNDS; ++i) {
        all->numbers[member] = i + member;
        plii_team_meet(team, member, MEMBERS, 2 * i + 1);
        all->sum_of_last[member] = all->numbers[0] + all->numbers[1] + all->numbers[2];
        plii_team_meet(team, member, MEMBERS, 2 * i + 2);
    }
}

static void test_members_work_at_the_same_time(void** state) {
    (void)state;
    pli_context* context = create_context(in_threads, NULL, MEMBERS);
    rounds all = {0};
    assert_true(plii_team_run(context, MEMBERS, do_rounds, &all));
    for (int m = 0; m < MEMBERS; ++m) {
        assert_int_equal(all.calls[m], 1);
        assert_int_equal(all.sum_of_last[m], 3 * (ROUNDS - 1) + 3);
    }
    assert_int_equal(context->team_failures, 0);
    pli_context_destroy(context);
}

static void test_without_threads_nothing_is_done_and_seldom_tried(void** state) {
    (void)state;
    pli_parallel_for_fn* const hooks[] = {one_after_the_other, in_one_piece};
    for (int h = 0; h < 2; ++h) {
        int tries = 0;
        pli_context* context = create_context(hooks[h], &tries, MEMBERS);
        rounds all = {0};
        for (int i = 0; i < 256; ++i) {
            context->team_patience = 10;
            assert_false(plii_team_run(context, MEMBERS, do_rounds, &all));
        }
        assert_int_equal(all.calls[0] + all.calls[1] + all.calls[2], 0);
        assert_int_equal(tries, 9); /* after 0, 2, 6, 14, 30, 62, 126, 190 and 254 others */
        pli_context_destroy(context);
    }
    pli_context_def def = pli_context_def_default();
    def.thread_count = -1;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_ERROR_INVALID_VALUE);
}

// --------------------------------------------------------------------------------------------------------- shares

typedef struct grid {
    int columns, rows, bending;
    bool is_shuffled;
    int share_count; /* for eight threads */
} grid;

static const grid grids[] = {
    {128, 128, 0, false, 4}, {64, 200, 2, false, 3}, {100, 90, 2, false, 2},
    {256, 80, 0, true, 4},   {48, 700, 2, true, 7},  {2000, 12, 0, false, 0},
};
enum { GRID_COUNT = sizeof grids / sizeof *grids };

static pli_mesh* make_grid(pli_context* context, const grid* g) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_10 = pli_vec3_make(0.1f * (float)g->columns, 0, 0);
    def.corner_01 = pli_vec3_make(0, 0, 0.1f * (float)g->rows);
    def.corner_11 = pli_vec3_make(0.1f * (float)g->columns, 0, 0.1f * (float)g->rows);
    def.columns = g->columns;
    def.rows = g->rows;
    def.pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    if (g->bending > 0) { assert_int_equal(pli_mesh_append_bending_links(mesh, g->bending, 0, NULL), PLI_OK); }
    if (g->is_shuffled) { assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK); }
    return mesh;
}

static pli_body* make_body(pli_world* world, pli_context* context, const grid* g) {
    pli_mesh* mesh = make_grid(context, g);
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 4;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

/* Who touches a node: bits of members, in the groups that they solve alone and in others. */
typedef struct touch {
    unsigned alone, shared;
} touch;

/* First and second nodes of eight links follow each other in the planes. */
static void check_group(const plii_planes* planes, const plii_link_run* run, int group, touch* touches, bool is_alone,
                        int member) {
    const int first = plii_link_run_node(run, group);
    for (int side = 0; side < 2; ++side) {
        const int begin = first + side * run->offset;
        for (int k = 0; k < PLII_LINK_LANES; ++k) {
            const int node = begin + plii_link_run_way(run->offset, run->step, k);
            const int even = (node - begin) / 2 * 2;
            assert_int_equal(plii_planes_place(planes, node),
                             plii_planes_place(planes, node - even) + (ptrdiff_t)even / 2);
            *(is_alone ? &touches[node].alone : &touches[node].shared) |= 1u << member;
        }
    }
}

static void check_range(const plii_link_colors* colors, const plii_planes* planes, int color, int begin, int end,
                        touch* touches, bool is_alone, int member, int* done) {
    const plii_link_runs* runs = &colors->runs;
    const plii_link_run_color* own = &runs->colors[color];
    const plii_link_part whole = plii_link_runs_part(runs, own, begin, end);
    if (begin >= end) { return; }
    for (int g = whole.begin; g < whole.end; ++g) {
        const plii_link_run* run = plii_link_run_at(runs, own, g);
        check_group(planes, run, g + own->first_group - run->first_group, touches, is_alone, member);
        done[own->first_group + g] += 1;
    }
}

static void check_shares(const pli_body* body, const plii_link_colors* colors) {
    const plii_planes planes = plii_planes_at(body->velocities, body->node_count, &colors->shares);
    touch* touches = calloc((size_t)body->node_count, sizeof *touches);
    int* done = calloc((size_t)colors->runs.group_count, sizeof *done);
    assert_true(touches != NULL && done != NULL);
    int first = 0;
    for (int m = 0; m < colors->shares.count; ++m) {
        plii_link_shares shares;
        plii_link_shares_find(colors, NULL, m, &shares);
        assert_int_equal(shares.first_node, first);
        assert_true(shares.common_end < shares.end_node);
        first = shares.end_node;
        for (int c = 0; c < colors->runs.color_count; ++c) {
            const plii_link_share* share = &shares.colors[c];
            assert_true(share->low_end <= share->high_begin);
            check_range(colors, &planes, c, share->begin, share->low_end, touches, false, m, done);
            check_range(colors, &planes, c, share->low_end, share->high_begin, touches, true, m, done);
            check_range(colors, &planes, c, share->high_begin, share->end, touches, false, m, done);
        }
        for (int i = shares.common_end; i < shares.end_node; ++i) {
            assert_int_equal((touches[i].alone | touches[i].shared) & ~(1u << m), 0);
        }
    }
    assert_int_equal(first, body->node_count);
    for (int i = 0; i < colors->runs.group_count; ++i) {
        assert_int_equal(done[i], 1);
    }
    for (int i = 0; i < body->node_count; ++i) {
        const unsigned all = touches[i].alone | touches[i].shared;
        if (touches[i].alone != 0) { assert_int_equal(all, touches[i].alone); }
        assert_int_equal(touches[i].alone & (touches[i].alone - 1), 0); /* one member */
        assert_true(all == 0 || (all / (all & (~all + 1))) <= 3);       /* or two beside each other */
    }
    free(touches);
    free(done);
}

static void test_shares_touch_only_where_members_wait(void** state) {
    (void)state;
    for (int i = 0; i < GRID_COUNT; ++i) {
        pli_context* context = create_context(in_threads, NULL, 8);
        pli_world* world = NULL;
        assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
        pli_body* body = make_body(world, context, &grids[i]);
        assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
        const plii_link_colors* colors = plii_feature_state(body, &plii_link_colors_class);
        assert_true(plii_link_colors_have_only_runs(colors));
        assert_int_equal(colors->shares.count, grids[i].share_count);
        if (grids[i].share_count > 0) { check_shares(body, colors); }
        pli_world_destroy(world);
        assert_int_equal(pli_context_allocated_bytes(context), 0);
        pli_context_destroy(context);
    }
}

// ----------------------------------------------------------------------------------------------------------- bits

typedef struct variant {
    int sweeps; /* 0: position-based */
    float compliance, damping;
} variant;

static const variant variants[] = {{0, 0, 0}, {1, 0, 0}, {1, 1e-4f, 0}, {3, 1e-4f, 0.01f}};
enum { VARIANT_COUNT = sizeof variants / sizeof *variants };

static uint64_t hash_after_steps(const grid* g, const variant* v, int thread_count, int steps) {
    pli_context* context = create_context(in_threads, NULL, thread_count);
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_body* body = make_body(world, context, g);
    if (v->sweeps == 0) {
        assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
    } else {
        pli_xpbd_def def = pli_xpbd_def_default();
        def.substeps = 4;
        def.sweeps = v->sweeps;
        pli_xpbd_links_def links = pli_xpbd_links_def_default();
        links.compliance = links.bending_compliance = v->compliance;
        links.damping = v->damping;
        assert_int_equal(pli_body_enable_xpbd(body, &def), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
    }
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    }
    assert_int_equal(context->team_failures, 0);
    const uint64_t hash = pli_body_state_hash(body);
    pli_world_destroy(world);
    pli_context_destroy(context);
    return hash;
}

static void test_teams_have_the_bits_of_one_thread(void** state) {
    (void)state;
    enum { STEPS = 3 };
    for (int i = 0; i < GRID_COUNT; ++i) {
        if (grids[i].share_count == 0) { continue; }
        for (int v = 0; v < VARIANT_COUNT; ++v) {
            const uint64_t expected = hash_after_steps(&grids[i], &variants[v], 1, STEPS);
            for (int threads = 2; threads <= 3; ++threads) {
                assert_true(hash_after_steps(&grids[i], &variants[v], threads, STEPS) == expected);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_members_work_at_the_same_time),
        cmocka_unit_test(test_without_threads_nothing_is_done_and_seldom_tried),
        cmocka_unit_test(test_shares_touch_only_where_members_wait),
        cmocka_unit_test(test_teams_have_the_bits_of_one_thread),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
