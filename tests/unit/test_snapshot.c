/* Saved, stepped on, restored and stepped again: the same bits in every step, whatever the bodies have. */

#include "body/body_impl.h"

#include "state_trials.h"

#include <pliant/bullet_reference.h>

// ------------------------------------------------------------------------------------------------ rollback, bit by bit

static void* save(const trial* t, size_t* size) {
    *size = pli_world_snapshot_size(t->world);
    assert_true(*size > 0);
    void* buffer = malloc(*size);
    assert_non_null(buffer);
    size_t written = 0;
    assert_int_equal(pli_world_save(t->world, buffer, *size, &written), PLI_OK);
    assert_int_equal(written, *size);
    return buffer;
}

static void go_back_and_forth(trial_kind kind, solver_choice solver, int threads) {
    trial t;
    start(&t, kind, solver, threads);
    for (int i = 0; i < BEFORE; ++i) {
        step(&t);
    }
    size_t size = 0;
    void* buffer = save(&t, &size);
    uint64_t hashes[AFTER];
    for (int i = 0; i < AFTER; ++i) {
        step(&t);
        hashes[i] = hash_of(&t);
    }
    const uint64_t allocations = pli_context_allocation_count(t.context);
    for (int round = 0; round < (threads > 1 ? 1 : 2); ++round) {
        t.step = BEFORE;
        if (pli_world_restore(t.world, buffer, size) != PLI_OK) { fail_msg("%s", pli_last_error(t.context)); }
        for (int i = 0; i < AFTER; ++i) {
            step(&t);
            if (hash_of(&t) == hashes[i]) { continue; }
            fail_msg("trial %d, solver %d, %d threads: other bits %d steps after the restore", (int)kind, (int)solver,
                     threads, i + 1);
        }
    }
    assert_int_equal(pli_context_allocation_count(t.context) - allocations, 0);
    free(buffer);
    end(&t);
}

static void a_restored_world_goes_the_same_way_again(void** unused) {
    (void)unused;
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
            if (!has_trial((trial_kind)kind, (solver_choice)solver)) { continue; }
            go_back_and_forth((trial_kind)kind, (solver_choice)solver, 1);
            const bool has_parallel_parts = solver == COLORS || solver == XPBD;
            if (has_parallel_parts) { go_back_and_forth((trial_kind)kind, (solver_choice)solver, 3); }
        }
    }
}

static void go_back_to_now(trial* t, const char* what) {
    size_t size = 0;
    void* buffer = save(t, &size);
    const int now = t->step;
    uint64_t hashes[AFTER];
    for (int i = 0; i < AFTER; ++i) {
        step(t);
        hashes[i] = hash_of(t);
    }
    t->step = now;
    assert_int_equal(pli_world_restore(t->world, buffer, size), PLI_OK);
    for (int i = 0; i < AFTER; ++i) {
        step(t);
        if (hash_of(t) != hashes[i]) { fail_msg("%s: other bits %d steps after the restore", what, i + 1); }
    }
    free(buffer);
}

/* The next step measures tethers anew. */
static void tethers_of_a_node_that_was_pinned_are_measured_again(void** unused) {
    (void)unused;
    for (int solver = POSITION; solver <= XPBD; solver += XPBD - POSITION) {
        trial t;
        start(&t, TRIAL_CLOTH, (solver_choice)solver, 1);
        for (int i = 0; i < BEFORE; ++i) {
            step(&t);
        }
        assert_int_equal(pli_body_set_node_mass(t.bodies[0], GRID * GRID / 3, 0), PLI_OK);
        go_back_to_now(&t, "with a node that was pinned");
        end(&t);
    }
}

/* Memory that a snapshot was not made from, but with the same history up to there. */
static void one_body_goes_back_alone(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    for (int i = 0; i < BEFORE; ++i) {
        step(&t);
    }
    pli_body* body = t.bodies[0];
    size_t size = pli_body_snapshot_size(body);
    void* buffer = malloc(size);
    assert_int_equal(pli_body_save(body, buffer, size, NULL), PLI_OK);
    const uint64_t hash = pli_body_state_hash(body);
    const pli_vec3 box = pli_rigid_get_state(t.rigids[1]).pose.origin;
    step(&t);
    assert_true(pli_body_state_hash(body) != hash);
    assert_int_equal(pli_body_restore(body, buffer, size), PLI_OK);
    assert_true(pli_body_state_hash(body) == hash);
    assert_true(pli_rigid_get_state(t.rigids[1]).pose.origin.y != box.y); /* others stay */
    free(buffer);
    end(&t);
}

/* Its anchors and joints would hold to what is gone. */
static void a_body_gets_back_nothing_that_is_gone(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    pli_body* body = t.bodies[0];
    const pli_rigid_def def = pli_rigid_def_default();
    pli_rigid *rigid = NULL, *later = NULL;
    assert_int_equal(pli_rigid_create(t.world, &def, &rigid), PLI_OK);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = rigid;
    assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK);
    const size_t size = pli_body_snapshot_size(body);
    void* buffer = malloc(size);
    assert_int_equal(pli_body_save(body, buffer, size, NULL), PLI_OK);
    assert_int_equal(pli_rigid_create(t.world, &def, &later), PLI_OK);
    assert_int_equal(pli_body_restore(body, buffer, size), PLI_OK);
    const int anchors = pli_body_anchor_count(body);
    pli_rigid_destroy(later);
    pli_rigid_destroy(rigid);
    assert_int_equal(pli_body_restore(body, buffer, size), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(t.context), "bodies, rigid bodies or clusters have gone"));
    assert_int_equal(pli_body_anchor_count(body), anchors - 1);
    free(buffer);
    end(&t);
}

/* Nor does what others hold to go with it. */
static void joints_hold_to_clusters_that_are_there(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    pli_body *body = t.bodies[0], *other = NULL;
    pli_mesh* mesh = NULL;
    int made = 0;
    const pli_vec3 from = pli_vec3_make(5, 1, 0), to = pli_vec3_make(6, 1, 0);
    assert_int_equal(pli_mesh_create_rope(t.context, from, to, 8, 0, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(t.world, mesh, NULL, &other), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_enable_clusters(body, NULL), PLI_OK);
    assert_int_equal(pli_body_enable_clusters(other, NULL), PLI_OK);
    assert_int_equal(pli_body_generate_clusters(body, 1, 10, &made), PLI_OK);
    const size_t size_before = pli_body_snapshot_size(other);
    void* before = malloc(size_before);
    assert_int_equal(pli_body_save(other, before, size_before, NULL), PLI_OK);
    const int nodes[] = {0, 1, 2};
    pli_linear_joint_def joint = pli_linear_joint_def_default();
    joint.other.body = other;
    assert_int_equal(pli_body_add_cluster(other, nodes, 3, &joint.other.cluster), PLI_OK);
    assert_int_equal(pli_body_add_linear_joint(body, &joint, NULL), PLI_OK);
    const size_t size = pli_body_snapshot_size(body);
    void* buffer = malloc(size);
    assert_int_equal(pli_body_save(body, buffer, size, NULL), PLI_OK);

    assert_int_equal(pli_body_restore(other, before, size_before), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_restore(body, buffer, size), PLI_OK);
    assert_int_equal(pli_world_step(t.world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(pli_body_remove_clusters(other), PLI_OK);
    assert_int_equal(pli_body_restore(body, buffer, size), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_joint_count(body), 0);
    assert_int_equal(pli_world_step(t.world, 1.0f / 60.0f), PLI_OK);
    free(buffer);
    free(before);
    end(&t);
}

static void a_buffer_needs_no_alignment(void** unused) {
    (void)unused;
    enum { LINE = 64 };
    trial t;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    for (int i = 0; i < BEFORE; ++i) {
        step(&t);
    }
    const size_t size = pli_world_snapshot_size(t.world), room = (size + 2 * LINE) / LINE * LINE;
    unsigned char *aligned = aligned_alloc(LINE, room), *buffer = aligned_alloc(LINE, room);
    assert_int_equal(pli_world_save(t.world, aligned, size, NULL), PLI_OK);
    for (size_t offset = 1; offset < LINE; offset += 5) {
        memset(buffer, 0xff, room);
        assert_int_equal(pli_world_save(t.world, buffer + offset, size, NULL), PLI_OK);
        assert_memory_equal(buffer + offset, aligned, size);
    }
    step(&t);
    const uint64_t hash = hash_of(&t);
    for (size_t offset = 1; offset < LINE; offset += 5) {
        memcpy(buffer + offset, aligned, size);
        assert_int_equal(pli_world_restore(t.world, buffer + offset, size), PLI_OK);
        t.step = BEFORE;
        step(&t);
        assert_true(hash_of(&t) == hash);
    }
    free(buffer);
    free(aligned);
    end(&t);
}

/* As docs/costs.md has it; what does not grow with the body, or by a fraction of a byte per node, is below 600 B. */
static void bytes_are_those_of_the_page_of_costs(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_SELF_GRIDS, POSITION, 1);
    pli_body* body = t.bodies[0];
    const size_t n = (size_t)GRID * GRID, per_node[] = {24, 4, 40, 45};
    const pli_aero_def aero = pli_aero_def_default();
    size_t before = pli_body_snapshot_size(body);
    assert_true(before >= 48 * n && before < 48 * n + 600);
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(i == 0   ? pli_body_enable_aero(body, &aero)
                         : i == 1 ? pli_body_enable_soft_contacts(body, NULL)
                         : i == 2 ? pli_body_enable_tethers(body, NULL)
                                  : pli_body_enable_self_collision(body, NULL),
                         PLI_OK);
        const size_t bytes = pli_body_snapshot_size(body);
        if (!(bytes - before >= per_node[i] * n && bytes - before < per_node[i] * n + 600)) {
            fail_msg("feature %d: %zu B more for %zu nodes", i, bytes - before, n);
        }
        before = bytes;
    }
    end(&t);
}

// ----------------------------------------------------------------------------------------------- what does not fit

static void expect_refused(trial* t, const void* buffer, size_t size, pli_status status, const char* message) {
    const uint64_t hash = hash_of(t);
    assert_int_equal(pli_world_restore(t->world, buffer, size), status);
    if (strstr(pli_last_error(t->context), message) == NULL) { fail_msg("%s", pli_last_error(t->context)); }
    assert_true(hash_of(t) == hash);
}

static void what_is_damaged_is_refused(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, XPBD, 1);
    step(&t);
    size_t size = 0;
    unsigned char* buffer = save(&t, &size);
    step(&t);
    for (size_t cut = 0; cut < size; cut = cut < 200 ? cut + 1 : cut + 997) {
        expect_refused(&t, buffer, cut, PLI_ERROR_FILE_FORMAT, "snapshot");
    }
    for (size_t at = 0; at < size; at = at < 200 ? at + 1 : at + 997) {
        buffer[at] ^= 0x10;
        const pli_status status = pli_world_restore(t.world, buffer, size);
        assert_true(status == PLI_ERROR_FILE_FORMAT || status == PLI_ERROR_INVALID_VALUE);
        buffer[at] ^= 0x10;
    }
    assert_int_equal(pli_world_save(t.world, buffer, size - 1, NULL), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_world_save(t.world, NULL, 0, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_restore(t.world, NULL, 0), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_snapshot_size(NULL), 0);
    free(buffer);
    end(&t);
}

/* Bytes and checksum do not depend on it. */
static void each_instruction_set_writes_and_reads_the_same(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, XPBD, 1);
    step(&t);
    const pli_simd best = t.context->def.simd;
    size_t size = 0, base_size = 0;
    void* buffer = save(&t, &size);
    t.context->def.simd = PLI_SIMD_PORTABLE;
    void* of_base = save(&t, &base_size);
    assert_int_equal(base_size, size);
    assert_memory_equal(buffer, of_base, size);
    assert_int_equal(pli_world_restore(t.world, buffer, size), PLI_OK);
    t.context->def.simd = best;
    assert_int_equal(pli_world_restore(t.world, of_base, size), PLI_OK);
    free(buffer);
    free(of_base);
    end(&t);
}

static void a_world_that_is_another_is_refused(void** unused) {
    (void)unused;
    trial t, other;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    start(&other, TRIAL_CLOTH, COLORS, 1);
    size_t size = 0;
    void* buffer = save(&t, &size);
    expect_refused(&other, buffer, size, PLI_ERROR_INVALID_VALUE, "another world");
    end(&other);

    assert_int_equal(pli_body_set_rest_length(t.bodies[0], 0, 0.3f), PLI_OK);
    expect_refused(&t, buffer, size, PLI_ERROR_INVALID_VALUE, "body 0: it was cut or refined, or rest lengths");
    free(buffer);
    buffer = save(&t, &size);
    assert_int_equal(pli_body_disable_tethers(t.bodies[0]), PLI_OK);
    expect_refused(&t, buffer, size, PLI_ERROR_INVALID_VALUE, "body 0: features were enabled or disabled");
    free(buffer);
    buffer = save(&t, &size);
    pli_rigid_destroy(t.rigids[--t.rigid_count]);
    expect_refused(&t, buffer, size, PLI_ERROR_INVALID_VALUE, "bodies or rigid bodies have come or gone");
    free(buffer);
    assert_int_equal(pli_world_predict(t.world, 0.01f), PLI_OK);
    char small[8];
    assert_int_equal(pli_world_save(t.world, small, sizeof small, NULL), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_solve(t.world), PLI_OK);
    buffer = save(&t, &size);
    while (t.body_count > 0) {
        pli_body_destroy(t.bodies[--t.body_count]);
    }
    expect_refused(&t, buffer, size, PLI_ERROR_INVALID_VALUE, "bodies or rigid bodies have come or gone");
    free(buffer);
    end(&t);
}

/* Masses, anchors and settings that were changed since come back. */
static void what_calls_have_changed_comes_back(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    for (int i = 0; i < BEFORE; ++i) {
        step(&t);
    }
    size_t size = 0;
    void* buffer = save(&t, &size);
    uint64_t hashes[10];
    for (int i = 0; i < 10; ++i) {
        step(&t);
        hashes[i] = hash_of(&t);
    }
    pli_body* body = t.bodies[0];
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = t.rigids[1];
    anchor.node = 5;
    pli_anchor_id id;
    assert_int_equal(pli_body_add_anchor(body, &anchor, &id), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(body, 40, 3), PLI_OK);
    pli_aero_def aero = pli_aero_def_default();
    aero.wind = pli_vec3_make(-20, 0, 0);
    assert_int_equal(pli_body_enable_aero(body, &aero), PLI_OK);
    assert_int_equal(pli_world_set_gravity(t.world, pli_vec3_make(1, 2, 3)), PLI_OK);
    step(&t);
    t.step = BEFORE;
    assert_int_equal(pli_world_restore(t.world, buffer, size), PLI_OK);
    assert_int_equal(pli_body_remove_anchor(body, id), PLI_ERROR_STALE_ID);
    for (int i = 0; i < 10; ++i) {
        step(&t);
        assert_true(hash_of(&t) == hashes[i]);
    }
    free(buffer);
    end(&t);
}

/* A body that has no force, anchor, drag or moved node yet is the same as one that has none any more. */
static void what_the_first_call_has_made_goes_again(void** unused) {
    (void)unused;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        trial t;
        start(&t, TRIAL_SELF_NODES, (solver_choice)solver, 1);
        pli_body* body = t.bodies[0];
        const pli_vec4 at = pli_body_get_view(body).positions[0];
        assert_int_equal(pli_body_set_node_mass(body, 0, 0), PLI_OK);
        size_t size = 0;
        void* buffer = save(&t, &size);
        uint64_t hashes[2][10];
        for (int round = 0; round < 4; ++round) { /* without, with, without, with */
            for (int i = 0; i < 10; ++i) {
                if (round % 2 == 1) {
                    pli_anchor_def anchor = pli_anchor_def_default();
                    anchor.rigid = t.rigids[2];
                    anchor.node = GRID - 1;
                    pli_drag_def drag = pli_drag_def_default();
                    drag.node = GRID * GRID / 2;
                    assert_int_equal(pli_body_add_force(body, pli_vec3_make(0.01f, 0.02f, 0)), PLI_OK);
                    assert_int_equal(pli_body_move_node(body, 0, pli_vec3_make(at.x, at.y, at.z)), PLI_OK);
                    if (i == 3) { assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK); }
                    if (i == 4) { assert_int_equal(pli_body_begin_drag(body, &drag, &t.drag), PLI_OK); }
                }
                step(&t);
                if (round < 2) { hashes[round][i] = hash_of(&t); }
                if (hash_of(&t) != hashes[round % 2][i]) { fail_msg("solver %d round %d step %d", solver, round, i); }
            }
            t.step = 0;
            t.drag = (pli_drag_id){0};
            if (pli_world_restore(t.world, buffer, size) != PLI_OK) { fail_msg("%s", pli_last_error(t.context)); }
        }
        assert_true(hashes[0][0] != hashes[1][0]);
        free(buffer);
        end(&t);
    }
}

/* A sweep that meets nothing is no cut. */
static void a_cut_that_misses_leaves_snapshots(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLOTH, COLORS, 1);
    size_t size = 0;
    void* buffer = save(&t, &size);
    uint64_t hashes[10];
    for (int round = 0; round < 2; ++round) {
        for (int i = 0; i < 10; ++i) {
            step(&t);
            if (round == 0) { hashes[i] = hash_of(&t); }
            assert_true(hash_of(&t) == hashes[i]);
        }
        const pli_vec3 a = pli_vec3_make(50, 0, 0), b = pli_vec3_make(50, 9, 0);
        const pli_vec3 c = pli_vec3_make(60, 0, 0), d = pli_vec3_make(60, 9, 0);
        int parted = 1;
        assert_int_equal(pli_body_cut_swept(t.bodies[0], a, b, c, d, &parted), PLI_OK);
        assert_int_equal(parted, 0);
        t.step = 0;
        if (pli_world_restore(t.world, buffer, size) != PLI_OK) { fail_msg("%s", pli_last_error(t.context)); }
    }
    free(buffer);
    end(&t);
}

/* What follows from a definition follows from the one that is restored. */
static void compliances_come_back(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_SELF_NODES, XPBD, 1);
    size_t size = 0;
    void* buffer = save(&t, &size);
    step(&t);
    const uint64_t hash = hash_of(&t);
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = 0.1f;
    assert_int_equal(pli_body_enable_xpbd_links(t.bodies[0], &links), PLI_OK);
    for (int round = 0; round < 2; ++round) {
        t.step = 0;
        if (round == 1) { assert_int_equal(pli_world_restore(t.world, buffer, size), PLI_OK); }
        step(&t);
        assert_true((hash_of(&t) == hash) == (round == 1));
    }
    free(buffer);
    end(&t);
}

/* So does the method of the implicit solver, with the memory that it takes. */
static void the_implicit_method_comes_back(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_SELF_NODES, GRADIENTS, 1);
    step(&t);
    size_t size = 0;
    void* buffer = save(&t, &size);
    step(&t);
    const uint64_t hash = hash_of(&t);
    assert_int_equal(pli_body_enable_implicit(t.bodies[0], NULL), PLI_OK);
    step(&t);
    t.step = 1;
    assert_int_equal(pli_world_restore(t.world, buffer, size), PLI_OK);
    step(&t);
    assert_true(hash_of(&t) == hash);
    free(buffer);
    end(&t);
}

// ---------------------------------------------------------------------------------- every member of every state is
// said

enum { MOST_STATE = 4096 };

static void say(uint8_t* said, size_t offset, size_t size) {
    assert_true(offset + size <= MOST_STATE);
    memset(said + offset, 1, size);
}

static void check_feature(const plii_feature_class* klass) {
    uint8_t said[MOST_STATE] = {0};
    for (const plii_feature_array* array = klass->arrays; array != NULL && array->element_size > 0; ++array) {
        const bool is_said = array->is_scratch || array->snapshot != PLII_NOT_SAID;
        if (!is_said) { fail_msg("%s: array at %zu of its state", klass->name, array->member); }
        if (array->is_in_body) { continue; }
        say(said, array->member, sizeof(void*));
        if (array->length == PLII_LIST) { say(said, array->capacity, sizeof(int)); }
        if (array->count != 0) { say(said, array->count, sizeof(int)); }
    }
    for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
        assert_true(part->snapshot != PLII_NOT_SAID);
        say(said, part->offset, part->size);
    }
    /* Padding ends where something begins that is aligned. */
    for (size_t i = 0; i < klass->state_size; ++i) {
        if (said[i]) { continue; }
        size_t gap = 0;
        while (i + gap < klass->state_size && !said[i + gap]) {
            ++gap;
        }
        const bool is_padding = gap < 8 && i > 0 && (i + gap) % (gap < 4 ? 4 : 8) == 0;
        if (!is_padding) { fail_msg("%s: %zu bytes at %zu of its state", klass->name, gap, i); }
        i += gap;
    }
}

static void every_member_of_a_state_is_said(void** unused) {
    (void)unused;
    const char* seen[64] = {0};
    int count = 0;
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
            if (!has_trial((trial_kind)kind, (solver_choice)solver)) { continue; }
            trial t;
            start(&t, (trial_kind)kind, (solver_choice)solver, 1);
            if (kind == TRIAL_BALLS && solver == POSITION) {
                assert_int_equal(pli_body_enable_velocity_links(t.bodies[0]), PLI_OK);
                assert_int_equal(pli_body_enable_xpbd(t.bodies[1], NULL), PLI_OK);
                assert_int_equal(pli_body_enable_bullet_node_boxes(t.bodies[0]), PLI_OK);
            }
            for (int b = 0; b < t.body_count; ++b) {
                const plii_pipeline* pipeline = &t.bodies[b]->pipeline;
                for (int k = 0; k < pipeline->feature_count; ++k) {
                    const plii_feature_class* klass = pipeline->features[k].klass;
                    check_feature(klass);
                    int i = 0;
                    while (i < count && seen[i] != klass->name) {
                        ++i;
                    }
                    if (i == count && count < 64) { seen[count++] = klass->name; }
                }
            }
            end(&t);
        }
    }
    print_message("%d classes\n", count);
    assert_true(count >= 30);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_member_of_a_state_is_said),
        cmocka_unit_test(a_restored_world_goes_the_same_way_again),
        cmocka_unit_test(tethers_of_a_node_that_was_pinned_are_measured_again),
        cmocka_unit_test(one_body_goes_back_alone),
        cmocka_unit_test(a_body_gets_back_nothing_that_is_gone),
        cmocka_unit_test(joints_hold_to_clusters_that_are_there),
        cmocka_unit_test(a_buffer_needs_no_alignment),
        cmocka_unit_test(bytes_are_those_of_the_page_of_costs),
        cmocka_unit_test(what_is_damaged_is_refused),
        cmocka_unit_test(each_instruction_set_writes_and_reads_the_same),
        cmocka_unit_test(a_world_that_is_another_is_refused),
        cmocka_unit_test(what_calls_have_changed_comes_back),
        cmocka_unit_test(what_the_first_call_has_made_goes_again),
        cmocka_unit_test(a_cut_that_misses_leaves_snapshots),
        cmocka_unit_test(compliances_come_back),
        cmocka_unit_test(the_implicit_method_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
