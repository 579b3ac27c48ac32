/* Many bodies on several threads: the same bits as on one, whatever the bodies share; several worlds of a context at a
   time; a world that two threads step. */

#include "check.h"
#include "hash_mix.h"

#include <pliant/pliant.h>

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#ifdef __SANITIZE_THREAD__ /* takes a hundred times as long */
enum { MOST_BODIES = 80, BODY_NODES = 48, ROW = 10, STEPS = 4 };
#else
enum { MOST_BODIES = 100, BODY_NODES = 48, ROW = 10, STEPS = 25 };
#endif

typedef enum trial_kind {
    TRIAL_COLORED,
    TRIAL_XPBD,
    TRIAL_TOUCHING,
    TRIAL_TOUCHING_XPBD,
    TRIAL_RIGIDS,
    TRIAL_RIGIDS_XPBD,
    TRIAL_CLUSTERS,
    TRIAL_LOST,
    TRIAL_KINDS
} trial_kind;

typedef struct trial {
    pli_context* context;
    pli_world* world;
    int count, rigid_count;
    pli_body* bodies[MOST_BODIES];
    pli_rigid* rigids[MOST_BODIES];
} trial;

static bool is_xpbd(trial_kind kind) {
    return kind == TRIAL_XPBD || kind == TRIAL_TOUCHING_XPBD || kind == TRIAL_RIGIDS_XPBD;
}

static pli_rigid* add_rigid(trial* all, pli_rigid_kind kind, pli_vec3 origin, pli_shape* shape) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.state.pose.origin = origin;
    def.state.inverse_mass = 0.5f;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 2.0f);
    }
    if (kind == PLI_RIGID_KINEMATIC) { def.state.linear_velocity = pli_vec3_make(0.2f, 0.1f, 0); }
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(all->world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
    return rigid;
}

static pli_body* add_ball(trial* all, trial_kind kind, pli_vec3 center) {
    pli_mesh* mesh = NULL;
    const pli_vec3 radii = pli_vec3_make(0.5f, 0.5f, 0.5f);
    assert_int_equal(pli_mesh_create_ellipsoid(all->context, center, radii, BODY_NODES, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 1), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    def.solver.position_iterations = 4;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(all->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    if (is_xpbd(kind)) {
        assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(body, NULL), PLI_OK);
    } else {
        assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
    }
    assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
    if (kind == TRIAL_TOUCHING || kind == TRIAL_TOUCHING_XPBD) {
        assert_int_equal(pli_body_enable_soft_contacts(body, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_contact_events(body, NULL), PLI_OK);
    }
    if (kind == TRIAL_RIGIDS || kind == TRIAL_RIGIDS_XPBD) {
        assert_int_equal(pli_body_enable_rigid_face_contacts(body, NULL), PLI_OK);
    }
    if (kind == TRIAL_CLUSTERS) {
        assert_int_equal(pli_body_generate_clusters(body, 3, 100, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_cluster_contacts(body, NULL), PLI_OK);
    }
    return all->bodies[all->count++] = body;
}

static void add_shared(trial* all, int index) {
    /* Two of three balls hang on a rigid body that moves, or on the ground. */
    const bool is_kinematic = index % 4 == 0;
    pli_shape* box = NULL;
    assert_int_equal(pli_shape_create_box(all->context, pli_vec3_make(0.3f, 0.1f, 1.2f), &box), PLI_OK);
    const pli_vec3 at = pli_vec3_make(3.0f * (float)(index % ROW), 1.7f, 3.0f * (float)(index / ROW) + 0.5f);
    pli_rigid* rigid = add_rigid(all, is_kinematic ? PLI_RIGID_KINEMATIC : PLI_RIGID_DYNAMIC, at, box);
    all->rigids[all->rigid_count++] = rigid;
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = index % 3 == 0 ? all->rigids[0] : rigid;
    assert_int_equal(pli_body_add_anchor(all->bodies[all->count - 1], &anchor, NULL), PLI_OK);
}

static void add_joints(trial* all) {
    for (int i = 0; i + 1 < all->count; i += 3) {
        pli_linear_joint_def def = pli_linear_joint_def_default();
        def.other.body = all->bodies[i + 1];
        def.position = pli_vec3_make(0, 1, 0);
        assert_int_equal(pli_body_add_linear_joint(all->bodies[i], &def, NULL), PLI_OK);
        def.other = (pli_joint_end){.rigid = all->rigids[0]};
        assert_int_equal(pli_body_add_linear_joint(all->bodies[i], &def, NULL), PLI_OK);
    }
}

static void start(trial* all, pli_context* context, trial_kind kind) {
    *all = (trial){.context = context};
    assert_int_equal(pli_world_create(context, NULL, &all->world), PLI_OK);
    pli_shape* plane = NULL;
    assert_int_equal(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &plane), PLI_OK);
    all->rigids[all->rigid_count++] = add_rigid(all, PLI_RIGID_STATIC, pli_vec3_make(0, 0, 0), plane);
    const bool is_close = kind == TRIAL_TOUCHING || kind == TRIAL_TOUCHING_XPBD || kind == TRIAL_CLUSTERS;
    for (int i = 0; i < MOST_BODIES; ++i) {
        /* Close ones touch in columns, which do not touch each other. */
        const float height = is_close ? 0.5f + 0.97f * (float)(i % 4) : 0.52f + 0.05f * (float)(i % 7);
        const float x = is_close ? 0.1f * (float)(i % 3) + 3.0f * (float)(i / 4 % ROW) : 3.0f * (float)(i % ROW);
        const float z = is_close ? 3.0f * (float)(i / 40) : 3.0f * (float)(i / ROW);
        (void)add_ball(all, kind, pli_vec3_make(x, height, z));
        if ((kind == TRIAL_RIGIDS || kind == TRIAL_RIGIDS_XPBD) && i % 2 == 0) { add_shared(all, i); }
    }
    if (kind == TRIAL_CLUSTERS) { add_joints(all); }
    for (int i = 10; kind == TRIAL_LOST && i < MOST_BODIES; i += 37) {
        assert_int_equal(pli_body_add_velocity(all->bodies[i], pli_vec3_make(1e8f, 0, 0)), PLI_OK);
    }
}

static void step(trial* all) {
    const float dt = 1.0f / 60.0f;
    assert_int_equal(pli_world_step(all->world, dt), PLI_OK);
    for (int i = 1; i < all->rigid_count; ++i) {
        assert_int_equal(pli_rigid_integrate(all->rigids[i], pli_world_get_gravity(all->world), dt), PLI_OK);
    }
}

static uint64_t hash_of(const trial* all) {
    uint64_t hash = HASH_START;
    for (int i = 0; i < all->count; ++i) {
        const uint64_t state = pli_body_state_hash(all->bodies[i]);
        hash = hash_mix(hash, &state, sizeof state);
        int count = 0;
        const pli_contact_event* events = pli_body_get_contact_events(all->bodies[i], PLI_CONTACT_PERSIST, &count);
        for (int k = 0; k < count; ++k) {
            hash = hash_mix(hash, &events[k].impulse, sizeof events[k].impulse);
        }
    }
    for (int i = 0; i < all->rigid_count; ++i) {
        const pli_rigid_state state = pli_rigid_get_state(all->rigids[i]);
        const bool was_touched = pli_rigid_was_touched(all->rigids[i]);
        hash = hash_mix(hash_mix(hash, &state, sizeof state), &was_touched, sizeof was_touched);
    }
    return hash;
}

/* With the bodies that froze, in the order of their events. */
static uint64_t run(trial* all) {
    uint64_t hash = 0;
    for (int i = 0; i < STEPS; ++i) {
        step(all);
        int count = 0;
        const pli_event* events = pli_world_get_events(all->world, &count);
        for (int k = 0; k < count; ++k) {
            int body = 0;
            while (all->bodies[body] != events[k].body) {
                ++body;
            }
            hash = hash_mix(hash, &body, sizeof body);
        }
    }
    return hash ^ hash_of(all);
}

typedef struct calls {
    pli_threads* threads;
    int count, largest;
} calls;

/* How the work was parted. */
static void counted_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    calls* made = user;
    ++made->count;
    if (count > made->largest) { made->largest = count; }
    pli_threads_parallel_for(range, task, count, grain, made->threads);
}

static uint64_t run_on(int threads, trial_kind kind, calls* made) {
    *made = (calls){0};
    pli_context_def def = pli_context_def_default();
    if (threads > 1) {
        assert_int_equal(pli_threads_create(threads, &made->threads), PLI_OK);
        def.parallel_for = counted_parallel_for;
        def.parallel_user = made;
    }
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    trial all;
    start(&all, context, kind);
    const uint64_t hash = run(&all);
    const uint64_t allocations = pli_context_allocation_count(context);
    if (kind == TRIAL_COLORED) {
        step(&all);
        assert_int_equal(pli_context_allocation_count(context) - allocations, 0);
    }
    pli_world_destroy(all.world);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    pli_threads_destroy(made->threads);
    return hash;
}

static void bits_do_not_depend_on_threads(void** unused) {
    (void)unused;
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        calls made;
        const uint64_t expected = run_on(1, (trial_kind)kind, &made);
        for (int i = 0; i < 3; ++i) {
            const uint64_t hash = run_on((int[]){2, 3, 8}[i], (trial_kind)kind, &made);
            if (hash != expected) { fail_msg("trial %d: other bits with %d threads", kind, (int[]){2, 3, 8}[i]); }
            assert_true(made.count >= STEPS); /* predictions and solves were parted */
            assert_true(made.largest >= 20);
        }
    }
}

enum { COLUMN = 15 };

typedef struct column_ranges {
    int of_pairs, of_bodies;
} column_ranges;

static void note_ranges(pli_range_fn* range, void* task, int count, int grain, void* user) {
    column_ranges* noted = user;
    noted->of_pairs += count == COLUMN - 1;
    noted->of_bodies += count == COLUMN;
    for (int i = 0; i < count; i += grain) {
        range(i, i + grain < count ? i + grain : count, task);
    }
}

/* Balls on each other that have contacts of clusters alone, all of them with one box that moves. */
static uint64_t run_column(column_ranges* noted) {
    pli_context_def def = pli_context_def_default();
    if (noted != NULL) {
        def.parallel_for = note_ranges;
        def.parallel_user = noted;
    }
    trial all = {.count = 0};
    assert_int_equal(pli_context_create(&def, &all.context), PLI_OK);
    assert_int_equal(pli_world_create(all.context, NULL, &all.world), PLI_OK);
    pli_shape* box = NULL;
    assert_int_equal(pli_shape_create_box(all.context, pli_vec3_make(0.3f, 20, 1), &box), PLI_OK);
    all.rigids[all.rigid_count++] = add_rigid(&all, PLI_RIGID_DYNAMIC, pli_vec3_make(0.8f, 7, 0), box);
    for (int i = 0; i < COLUMN; ++i) {
        pli_body* ball = add_ball(&all, TRIAL_CLUSTERS, pli_vec3_make(0.02f * (float)(i % 3), 0.97f * (float)i, 0));
        assert_int_equal(pli_body_disable_rigid_contacts(ball), PLI_OK);
    }
    int contacts = 0;
    for (int i = 0; i < 10; ++i) {
        step(&all);
        for (int k = 0; k < COLUMN; ++k) {
            contacts += pli_body_get_cluster_contacts(all.bodies[k], 0, NULL);
        }
    }
    assert_true(contacts > 10 * COLUMN);
    const uint64_t hash = hash_of(&all);
    pli_world_destroy(all.world);
    assert_int_equal(pli_context_destroy(all.context), PLI_OK);
    return hash;
}

static void bodies_that_meet_by_clusters_alone_step_side_by_side(void** unused) {
    (void)unused;
    column_ranges noted = {0};
    assert_true(run_column(&noted) == run_column(NULL));
    print_message("%d ranges of pairs, %d of bodies\n", noted.of_pairs, noted.of_bodies);
    assert_true(noted.of_pairs >= 8);
    assert_int_equal(noted.of_bodies, 10); /* solves */
}

// ------------------------------------------------------------------------------------------------ pairs of a host

/* Every body with every rigid body, body by body or rigid body by rigid body, in one call or in many. */
static uint64_t run_by_pairs(int threads, bool by_body, bool in_one_call) {
    pli_threads* pool = NULL;
    pli_context_def def = pli_context_def_default();
    if (threads > 1) {
        assert_int_equal(pli_threads_create(threads, &pool), PLI_OK);
        def.parallel_for = pli_threads_parallel_for;
        def.parallel_user = pool;
    }
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(&def, &context), PLI_OK);
    trial all;
    start(&all, context, TRIAL_RIGIDS);
    const int count = all.count * all.rigid_count;
    pli_rigid_pair* pairs = calloc((size_t)count, sizeof *pairs);
    for (int i = 0; i < count; ++i) {
        const int body = by_body ? i / all.rigid_count : i % all.count;
        const int rigid = by_body ? i % all.rigid_count : i / all.count;
        pairs[i] = (pli_rigid_pair){all.bodies[body], all.rigids[rigid]};
    }
    for (int k = 0; k < STEPS; ++k) {
        assert_int_equal(pli_world_predict(all.world, 1.0f / 60.0f), PLI_OK);
        if (in_one_call) {
            assert_int_equal(pli_world_collide_rigids(all.world, pairs, count), PLI_OK);
        } else {
            for (int i = 0; i < count; ++i) {
                assert_int_equal(pli_world_collide_rigid(all.world, pairs[i].body, pairs[i].rigid), PLI_OK);
            }
        }
        assert_int_equal(pli_world_solve(all.world), PLI_OK);
    }
    const uint64_t hash = hash_of(&all);
    const pli_status early = pli_world_collide_rigids(all.world, pairs, count);
    assert_int_equal(early, PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_predict(all.world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(pli_world_collide_rigids(all.world, pairs, -1), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_world_collide_rigids(all.world, NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_collide_rigids(all.world, NULL, 0), PLI_OK);
    pairs[count - 1].rigid = NULL;
    assert_int_equal(pli_world_collide_rigids(all.world, pairs, count), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_get_rigid_contacts(all.bodies[0], 0, NULL), 0); /* nothing was done */
    free(pairs);
    pli_world_destroy(all.world);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    pli_threads_destroy(pool);
    return hash;
}

static void pairs_in_one_call_are_those_one_by_one(void** unused) {
    (void)unused;
    const uint64_t expected = run_by_pairs(1, true, false);
    for (int i = 0; i < 8; ++i) {
        assert_true(run_by_pairs(i < 4 ? 1 : 3, i % 2 == 0, i % 4 < 2) == expected);
    }
}

enum { HEAPED_BODIES = 2, HEAPED_RIGIDS = 24 };

/* The parts of a host that has many threads, one after the other. */
static void run_in_parts(pli_range_fn* range, void* task, int count, int grain, void* user) {
    for (int begin = 0; begin < count; begin += grain) {
        range(begin, begin + grain < count ? begin + grain : count, task);
        *(int*)user += grain < HEAPED_RIGIDS;
    }
}

/* Contacts of bodies that meet so many rigid bodies each that the pairs of one make several parts. */
static int count_heaped_contacts(bool has_parts, int* small_parts) {
    pli_context_def def = pli_context_def_default();
    if (has_parts) {
        def.parallel_for = run_in_parts;
        def.parallel_user = small_parts;
    }
    trial all = {.rigid_count = 0};
    assert_int_equal(pli_context_create(&def, &all.context), PLI_OK);
    assert_int_equal(pli_world_create(all.context, NULL, &all.world), PLI_OK);
    pli_rigid_pair pairs[HEAPED_BODIES * HEAPED_RIGIDS];
    for (int i = 0; i < HEAPED_RIGIDS; ++i) {
        pli_shape* box = NULL;
        assert_int_equal(pli_shape_create_box(all.context, pli_vec3_make(0.6f, 0.6f, 0.6f), &box), PLI_OK);
        all.rigids[i] = add_rigid(&all, PLI_RIGID_KINEMATIC, pli_vec3_make(0.01f * (float)i, 0.02f, 0), box);
    }
    int contacts = 0;
    for (int b = 0; b < HEAPED_BODIES; ++b) {
        pli_mesh* mesh = NULL;
        const pli_vec3 radii = pli_vec3_make(0.5f, 0.5f, 0.5f);
        assert_int_equal(pli_mesh_create_ellipsoid(all.context, pli_vec3_make(0, 0, 0), radii, 400, &mesh), PLI_OK);
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(all.world, mesh, NULL, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
        all.bodies[all.count++] = body;
        for (int i = 0; i < HEAPED_RIGIDS; ++i) {
            pairs[b * HEAPED_RIGIDS + i] = (pli_rigid_pair){body, all.rigids[i]};
        }
    }
    assert_int_equal(pli_world_predict(all.world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(pli_world_collide_rigids(all.world, pairs, HEAPED_BODIES * HEAPED_RIGIDS), PLI_OK);
    for (int b = 0; b < HEAPED_BODIES; ++b) {
        contacts += pli_body_get_rigid_contacts(all.bodies[b], 0, NULL);
    }
    assert_int_equal(pli_world_solve(all.world), PLI_OK);
    pli_world_destroy(all.world);
    assert_int_equal(pli_context_destroy(all.context), PLI_OK);
    return contacts;
}

static void pairs_of_a_body_that_make_several_parts_are_met_once(void** unused) {
    (void)unused;
    int small_parts = 0;
    const int expected = count_heaped_contacts(false, &small_parts);
    assert_true(expected > 1000);
    assert_int_equal(count_heaped_contacts(true, &small_parts), expected);
    assert_true(small_parts > HEAPED_BODIES);
}

// ----------------------------------------------------------------------------------------------- several at a time

static void step_worlds(int begin, int end, void* task) {
    trial* trials = task;
    for (int i = begin; i < end; ++i) {
        (void)run(&trials[i]);
    }
}

static void worlds_of_a_context_may_step_at_the_same_time(void** unused) {
    (void)unused;
    static const trial_kind kinds[] = {TRIAL_COLORED, TRIAL_RIGIDS_XPBD, TRIAL_CLUSTERS, TRIAL_TOUCHING};
    pli_threads *threads = NULL, *drivers = NULL;
    assert_int_equal(pli_threads_create(3, &threads), PLI_OK);
    assert_int_equal(pli_threads_create(4, &drivers), PLI_OK);
    uint64_t hashes[2][4];
    for (int round = 0; round < 2; ++round) {
        pli_context_def def = pli_context_def_default();
        def.parallel_for = pli_threads_parallel_for;
        def.parallel_user = threads;
        pli_context* context = NULL;
        assert_int_equal(pli_context_create(&def, &context), PLI_OK);
        trial trials[4];
        for (int i = 0; i < 4; ++i) {
            start(&trials[i], context, kinds[i]);
        }
        if (round == 0) {
            step_worlds(0, 4, trials);
        } else {
            pli_threads_parallel_for(step_worlds, trials, 4, 1, drivers);
        }
        for (int i = 0; i < 4; ++i) {
            hashes[round][i] = hash_of(&trials[i]);
            pli_world_destroy(trials[i].world);
        }
        assert_int_equal(pli_context_destroy(context), PLI_OK);
    }
    assert_memory_equal(hashes[0], hashes[1], sizeof hashes[0]);
    pli_threads_destroy(drivers);
    pli_threads_destroy(threads);
}

typedef struct intruder {
    trial* all;
    pli_status answers[4];
    bool has_come;
} intruder;

static void* intrude(void* data) {
    intruder* from = data;
    from->answers[0] = pli_world_step(from->all->world, 0.01f);
    from->answers[1] = pli_world_predict(from->all->world, 0.01f);
    from->answers[2] = pli_world_set_gravity(from->all->world, pli_vec3_make(0, 0, 0));
    from->answers[3] = pli_body_add_velocity(from->all->bodies[0], pli_vec3_make(0, 0, 0));
    return NULL;
}

static void on_profile(const char* stage, const char* feature, bool begins, void* user) {
    (void)stage;
    (void)feature;
    (void)begins;
    intruder* from = user;
    if (from->has_come) { return; }
    from->has_come = true;
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, intrude, from), 0);
    pthread_join(thread, NULL);
}

static void a_second_thread_is_refused_while_one_steps(void** unused) {
    (void)unused;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    trial all;
    start(&all, context, TRIAL_COLORED);
    intruder from = {.all = &all};
    assert_int_equal(pli_world_set_profile(all.world, on_profile, &from), PLI_OK);
    step(&all);
    assert_true(from.has_come);
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(from.answers[i], PLI_ERROR_WRONG_STATE);
    }
    assert_true(strstr(pli_last_error(context), "another thread steps the world") != NULL);
    assert_int_equal(pli_world_set_profile(all.world, NULL, NULL), PLI_OK);
    step(&all);
    pli_world_destroy(all.world);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
}

static void a_pool_has_one_to_256_threads(void** unused) {
    (void)unused;
    pli_threads* threads = NULL;
    assert_int_equal(pli_threads_create(0, &threads), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_threads_create(PLI_MAX_THREADS + 1, &threads), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_threads_create(1, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_null(threads);
    assert_int_equal(pli_threads_count(NULL), 0);
    pli_threads_destroy(NULL);
    assert_int_equal(pli_threads_create(5, &threads), PLI_OK);
    assert_int_equal(pli_threads_count(threads), 5);
    pli_threads_destroy(threads);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pool_has_one_to_256_threads),
        cmocka_unit_test(bits_do_not_depend_on_threads),
        cmocka_unit_test(bodies_that_meet_by_clusters_alone_step_side_by_side),
        cmocka_unit_test(pairs_in_one_call_are_those_one_by_one),
        cmocka_unit_test(pairs_of_a_body_that_make_several_parts_are_met_once),
        cmocka_unit_test(worlds_of_a_context_may_step_at_the_same_time),
        cmocka_unit_test(a_second_thread_is_refused_while_one_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
