/* Worlds that are made again from a file go on as those that were written: the same bits in every step. And nothing
   that a file says harms the library. */

#include "body/all_features.h"
#include "body/pipeline.h"
#include "file/file_impl.h"

#define TRIAL_GRID 11
#include "failing_allocator.h"
#include "short_steps.h"
#include "state_trials.h"

#include <pliant/bullet_reference.h>
#include <pliant/world_file.h>

#include <stdio.h>

enum { FRESH = 8 };

#define ADDRESS(name) &plii_##name##_class,
static const plii_feature_class* const all_classes[] = {PLII_ALL_FEATURES(ADDRESS)};
enum { ALL_CLASSES = sizeof all_classes / sizeof *all_classes };

static unsigned char* write_file(const pli_world* written_world, size_t* size) {
    *size = pli_world_file_size(written_world);
    assert_true(*size > 0);
    unsigned char* buffer = malloc(*size);
    assert_non_null(buffer);
    size_t written = 0;
    if (pli_world_file_write(written_world, NULL, buffer, *size, &written) != PLI_OK) {
        fail_msg("%s", pli_last_error(pli_world_get_context(written_world)));
    }
    assert_int_equal(written, *size);
    return buffer;
}

/* The trial in a world that was made from a file, in a context of its own. */
static void start_from_file(trial* t, const trial* from, const void* buffer, size_t size, int threads) {
    *t = (trial){.drag = from->drag, .step = from->step};
    pli_context_def def = pli_context_def_default();
    if (threads > 1) {
        assert_int_equal(pli_threads_create(threads, &t->threads), PLI_OK);
        def.parallel_for = pli_threads_parallel_for;
        def.parallel_user = t->threads;
    }
    assert_int_equal(pli_context_create(&def, &t->context), PLI_OK);
    if (pli_world_file_create(t->context, NULL, buffer, size, &t->world) != PLI_OK) {
        fail_msg("%s", pli_last_error(t->context));
    }
    t->body_count = pli_world_body_count(t->world);
    t->rigid_count = pli_world_rigid_count(t->world);
    for (int i = 0; i < t->body_count; ++i) {
        t->bodies[i] = pli_world_get_body(t->world, i);
    }
    for (int i = 0; i < t->rigid_count; ++i) {
        t->rigids[i] = pli_world_get_rigid(t->world, i);
    }
}

static void expect_same_steps(trial* t, const uint64_t* hashes, int count, const char* what) {
    for (int i = 0; i < count; ++i) {
        step(t);
        if (hash_of(t) != hashes[i]) { fail_msg("%s: other bits in step %d", what, i + 1); }
    }
}

static void expect_same_bytes(const unsigned char* a, const unsigned char* b, size_t size, const char* what) {
    for (size_t i = PLII_FILE_HEADER_SIZE; i < size; ++i) {
        if (a[i] != b[i]) { fail_msg("%s: written again, other bytes from %zu on", what, i); }
    }
}

static void cut_something(trial* t) {
    for (int i = 0; i < t->body_count; ++i) {
        const pli_bounds bounds = pli_body_get_bounds(t->bodies[i]);
        const pli_vec3 middle = pli_vec3_scale(pli_vec3_add(bounds.min, bounds.max), 0.5f);
        const float length = pli_vec3_length(pli_vec3_sub(bounds.max, bounds.min));
        const pli_vec3 first[2] = {{middle.x, middle.y - length, middle.z - 0.2f * length},
                                   {middle.x, middle.y + length, middle.z - 0.2f * length}};
        const pli_vec3 second[2] = {{middle.x, middle.y - length, middle.z + 0.2f * length},
                                    {middle.x, middle.y + length, middle.z + 0.2f * length}};
        (void)pli_body_cut_swept(t->bodies[i], first[0], first[1], second[0], second[1], NULL);
    }
}

static void go_through_a_file(trial_kind kind, solver_choice solver, bool is_cut) {
    char what[80];
    trial t;
    start(&t, kind, solver, 1);
    for (int i = 0; i < t.body_count; ++i) {
        if (is_cut) { assert_int_equal(pli_body_enable_sleep(t.bodies[i], NULL), PLI_OK); }
    }
    for (int i = 0; i < BEFORE; ++i) {
        step(&t);
        if (is_cut && i == BEFORE / 2) { cut_something(&t); }
    }
    size_t size = 0;
    unsigned char* buffer = write_file(t.world, &size);
    trial here = t;
    uint64_t hashes[FRESH];
    for (int i = 0; i < FRESH; ++i) {
        step(&t);
        hashes[i] = hash_of(&t);
    }
    for (int threads = is_cut ? 3 : 1; threads <= 3; threads += 2) {
        snprintf(what, sizeof what, "trial %d, solver %d, %d threads%s", (int)kind, (int)solver, threads,
                 is_cut ? ", cut" : "");
        trial made;
        start_from_file(&made, &here, buffer, size, threads);
        size_t again = 0;
        unsigned char* rewritten = write_file(made.world, &again);
        assert_int_equal(again, size);
        expect_same_bytes(buffer, rewritten, size, what);
        free(rewritten);
        expect_same_steps(&made, hashes, FRESH, what);
        end(&made);
    }
    /* Into the world that has gone on, and into one that was made anew. */
    t.step = BEFORE;
    assert_int_equal(pli_world_file_restore(t.world, NULL, buffer, size), PLI_OK);
    size_t again = 0;
    unsigned char* rewritten = write_file(t.world, &again);
    assert_int_equal(again, size);
    expect_same_bytes(buffer, rewritten, size, what);
    free(rewritten);
    expect_same_steps(&t, hashes, FRESH, "back in the same world");
    trial anew;
    start(&anew, kind, solver, 1);
    anew.step = BEFORE;
    assert_int_equal(pli_world_file_restore(anew.world, NULL, buffer, size), PLI_OK);
    expect_same_steps(&anew, hashes, FRESH, "a world that was made anew");
    end(&anew);
    free(buffer);
    end(&t);
}

static void a_world_of_a_file_goes_on(void** unused) {
    (void)unused;
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
            if (!has_trial((trial_kind)kind, (solver_choice)solver)) { continue; }
            go_through_a_file((trial_kind)kind, (solver_choice)solver, false);
            go_through_a_file((trial_kind)kind, (solver_choice)solver, true);
        }
    }
}

/* Into a world where no body had one. */
static void update_intervals_come_with_a_file(void** unused) {
    (void)unused;
    trial t, anew;
    start(&t, TRIAL_SELF_NODES, POSITION, 1); /* it meets nothing that is dynamic */
    start(&anew, TRIAL_SELF_NODES, POSITION, 1);
    assert_int_equal(pli_body_set_update_interval(t.bodies[0], 4), PLI_OK);
    for (int i = 0; i < 10; ++i) {
        step(&t);
    }
    size_t size = 0;
    unsigned char* buffer = write_file(t.world, &size);
    uint64_t hashes[FRESH];
    anew.step = t.step;
    for (int i = 0; i < FRESH; ++i) {
        step(&t);
        hashes[i] = hash_of(&t);
    }
    assert_int_equal(pli_world_file_restore(anew.world, NULL, buffer, size), PLI_OK);
    assert_int_equal(pli_body_get_update_interval(anew.bodies[0]), 4);
    expect_same_steps(&anew, hashes, FRESH, "update intervals");
    free(buffer);
    end(&anew);
    end(&t);
}

/* Totals leave some room below PLI_MIN_MASS, and cuts halve masses. */
static void light_nodes_come_with_a_file(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    const pli_vec3 ends[2] = {{0, 0, 0}, {1, 0, 0}};
    assert_int_equal(pli_mesh_create_rope(context, ends[0], ends[1], 0, 0, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 2.0f * 0.9995e-9f), PLI_OK);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    for (int i = 0; i < 2; ++i) {
        size_t size = 0;
        unsigned char* buffer = write_file(world, &size);
        pli_world* made = NULL;
        if (pli_world_file_create(context, NULL, buffer, size, &made) != PLI_OK) {
            fail_msg("%s", pli_last_error(context));
        }
        assert_true(pli_body_state_hash(pli_world_get_body(made, 0)) == pli_body_state_hash(body));
        pli_world_destroy(made);
        free(buffer);
        assert_int_equal(pli_body_cut_link(body, 0, 1, 0.5f), i == 0 ? PLI_OK : PLI_ERROR_INVALID_VALUE);
    }
    assert_true(pli_body_get_view(body).positions[0].w > 1.4f / PLI_MIN_MASS);
}

/* It waits for the world when it is told to step with it. */
static void what_is_left_of_an_update_interval_comes_with_a_file(void** unused) {
    (void)unused;
    trial t, made;
    start(&t, TRIAL_SELF_NODES, POSITION, 1);
    assert_int_equal(pli_body_set_update_interval(t.bodies[0], 8), PLI_OK);
    for (int i = 0; i < 4; ++i) {
        step(&t);
    }
    assert_int_equal(pli_body_set_update_interval(t.bodies[0], 1), PLI_OK);
    size_t size = 0;
    unsigned char* buffer = write_file(t.world, &size);
    start_from_file(&made, &t, buffer, size, 1);
    uint64_t hashes[FRESH];
    for (int i = 0; i < FRESH; ++i) {
        step(&t);
        hashes[i] = hash_of(&t);
    }
    expect_same_steps(&made, hashes, FRESH, "after an update interval");
    free(buffer);
    end(&made);
    end(&t);
}

/* Steps later too, and when there were contacts before that have ended. */
static void worlds_that_are_equal_have_equal_files(void** unused) {
    (void)unused;
    trial t, made;
    start(&t, TRIAL_CLUSTERS, POSITION, 1);
    for (int i = 0; i < 3 * BEFORE; ++i) {
        step(&t);
    }
    pli_rigid* gone = NULL;
    const pli_rigid_def def = pli_rigid_def_default();
    assert_int_equal(pli_rigid_create(t.world, &def, &gone), PLI_OK);
    pli_rigid_destroy(gone); /* all contacts end */
    size_t size = 0, again = 0;
    unsigned char* buffer = write_file(t.world, &size);
    start_from_file(&made, &t, buffer, size, 1);
    free(buffer);
    step(&t);
    step(&made);
    buffer = write_file(t.world, &size);
    unsigned char* other = write_file(made.world, &again);
    assert_int_equal(again, size);
    expect_same_bytes(buffer, other, size, "a step later");
    free(other);
    free(buffer);
    end(&made);
    end(&t);
}

/* The first step puts faces in order, from where bodies begin and not from where they are when they meet. */
static void worlds_that_go_back_to_their_beginning_have_equal_files(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_SOFT, POSITION, 1);
    for (int i = 0; i < t.body_count; ++i) {
        for (int node = 0; node < GRID * GRID; ++node) {
            const pli_vec3 velocity = pli_vec3_make((float)(node * 7 % 11 - 5), 0, (float)(node * 5 % 13 - 6));
            assert_int_equal(pli_body_set_node_velocity(t.bodies[i], node, velocity), PLI_OK);
        }
    }
    const size_t saved_size = pli_world_snapshot_size(t.world);
    void* saved = malloc(saved_size);
    assert_int_equal(pli_world_save(t.world, saved, saved_size, NULL), PLI_OK);
    unsigned char* files[2] = {NULL, NULL};
    size_t sizes[2] = {0, 0};
    for (int k = 0; k < 2; ++k) {
        t.step = 0;
        if (k > 0) { assert_int_equal(pli_world_restore(t.world, saved, saved_size), PLI_OK); }
        for (int i = 0; i < BEFORE; ++i) {
            step(&t);
        }
        files[k] = write_file(t.world, &sizes[k]);
    }
    assert_int_equal(sizes[0], sizes[1]);
    expect_same_bytes(files[0], files[1], sizes[0], "from the beginning again");
    free(files[0]);
    free(files[1]);
    free(saved);
    end(&t);
}

/* Where two corners of a face coincide there is no division by its first edge. */
static void faces_without_an_area_come_with_a_file(void** unused) {
    (void)unused;
    const pli_vec3 points[5] = {{1, 0, 0}, {1, 0, 0}, {1, 0, 1}, {1, 0.3f, 0.5f}, {2, 0.3f, 0.5f}};
    const int triangles[6] = {0, 1, 2, 3, 4, 2};
    for (int turn = 0; turn < 3; ++turn) {
        const int turned[6] = {triangles[turn], triangles[(turn + 1) % 3], triangles[(turn + 2) % 3], 3, 4, 2};
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create_from_triangles(context, 5, points, 2, turned, false, &mesh), PLI_OK);
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_self_faces_def faces = pli_self_faces_def_default();
        faces.thickness = 0.2f;
        assert_int_equal(pli_body_enable_self_faces(body, &faces), PLI_OK);
        assert_int_equal(pli_body_set_node_velocity(body, 3, pli_vec3_make(0, -20, 0)), PLI_OK);
    }
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    size_t size = 0;
    unsigned char* buffer = write_file(world, &size);
    pli_world* made = NULL;
    if (pli_world_file_create(context, NULL, buffer, size, &made) != PLI_OK) {
        fail_msg("%s", pli_last_error(context));
    }
    pli_world_destroy(made);
    free(buffer);
}

typedef struct meddler {
    trial* t;
    int calls, refused;
} meddler;

static void meddle(void* user) {
    meddler* self = user;
    const int bodies = pli_world_body_count(self->t->world);
    pli_body_destroy(self->t->bodies[0]);
    pli_rigid_destroy(self->t->rigids[0]);
    self->calls += 1;
    self->refused += pli_body_ignore_rigid(self->t->bodies[0], self->t->rigids[0], true) == PLI_ERROR_WRONG_STATE &&
                     pli_world_body_count(self->t->world) == bodies;
}
static uint64_t meddling_rigid_id(const pli_rigid* rigid, void* user) {
    (void)rigid;
    meddle(user);
    return 7;
}
static void meddling_begin_part(const char* part, int body, size_t offset, void* user) {
    (void)part;
    (void)body;
    (void)offset;
    meddle(user);
}

/* The size is known before. */
static void nothing_is_changed_while_a_file_is_written(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_SOFT, POSITION, 1);
    meddler self = {.t = &t};
    pli_world_file_def def = pli_world_file_def_default();
    def.rigid_id = meddling_rigid_id;
    def.begin_part = meddling_begin_part;
    def.user = &self;
    const size_t size = pli_world_file_size(t.world);
    unsigned char* buffer = malloc(size);
    assert_int_equal(pli_world_file_write(t.world, &def, buffer, size, NULL), PLI_OK);
    assert_true(self.calls > t.rigid_count + t.body_count);
    assert_int_equal(self.refused, self.calls);
    free(buffer);
    end(&t);
}

static int cluster_contacts_after_step(pli_world* stepped) {
    assert_int_equal(pli_world_step(stepped, 1.0f / 60.0f), PLI_OK);
    return pli_body_get_cluster_contacts(pli_world_get_body(stepped, 0), 0, NULL);
}

/* Clusters that were apart at first meet later, also in a world that is made when they do. */
static void clusters_of_a_body_that_touch_come_with_a_file(void** unused) {
    (void)unused;
    const pli_vec3 corners[4] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}}, far = {0, 5, 0};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < 8; ++i) {
        const pli_vec3 at = i < 4 ? corners[i] : pli_vec3_add(corners[i - 4], far);
        assert_int_equal(pli_mesh_append_node(mesh, at, 1, NULL), PLI_OK);
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.05f;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    const int nodes[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    assert_int_equal(pli_body_add_cluster(body, nodes, 4, NULL), PLI_OK);
    assert_int_equal(pli_body_add_cluster(body, nodes + 4, 4, NULL), PLI_OK);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    contacts.with_self = true;
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    assert_int_equal(cluster_contacts_after_step(world), 0);
    for (int i = 4; i < 8; ++i) {
        const pli_vec4 at = pli_body_get_view(body).positions[i];
        assert_int_equal(pli_body_set_node_position(body, i, pli_vec3_make(at.x, at.y - 4.02f, at.z)), PLI_OK);
    }
    size_t size = 0;
    unsigned char* buffer = write_file(world, &size);
    pli_world* made = NULL;
    assert_int_equal(pli_world_file_create(context, NULL, buffer, size, &made), PLI_OK);
    for (int i = 0; i < FRESH; ++i) {
        const int count = cluster_contacts_after_step(world);
        assert_true(count > 0 || i > 0);
        assert_int_equal(cluster_contacts_after_step(made), count);
        assert_true(pli_body_state_hash(pli_world_get_body(made, 0)) == pli_body_state_hash(body));
    }
    pli_world_destroy(made);
    free(buffer);
}

static float count_speed(float present, void* user) {
    ++*(int*)user;
    return present;
}
static bool count_distance(const pli_body* body, pli_cluster_contact* contact, void* user) {
    (void)body, (void)contact;
    ++*(int*)user;
    return false;
}

/* They are not in the file: those that the bodies of the world have stay. */
static void callbacks_stay_when_a_world_goes_back(void** unused) {
    (void)unused;
    trial t = {0};
    int speeds = 0, distances = 0;
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    contacts.distance = count_distance;
    contacts.distance_user = &distances;
    pli_angular_joint_def joint = pli_angular_joint_def_default();
    joint.axis = pli_vec3_make(0, 1, 0);
    joint.controller = (pli_joint_controller){NULL, count_speed, &speeds};
    pli_world_def def = pli_world_def_default();
    def.reference_mode = true;
    assert_int_equal(pli_context_create(NULL, &t.context), PLI_OK);
    assert_int_equal(pli_world_create(t.context, &def, &t.world), PLI_OK);
    for (int i = 0; i < 2; ++i) {
        pli_body* body = add_ball(&t, pli_vec3_make(0, 0.5f * (float)i, 0), POSITION);
        assert_int_equal(pli_body_generate_clusters(body, 1, 100, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
        assert_int_equal(pli_body_add_angular_joint(body, &joint, NULL), PLI_OK);
    }
    size_t size = 0;
    unsigned char* buffer = write_file(t.world, &size);
    assert_int_equal(pli_world_step(t.world, 1.0f / 60.0f), PLI_OK);
    const int speeds_before = speeds, distances_before = distances;
    assert_true(speeds_before > 0 && distances_before > 0);
    assert_int_equal(pli_world_file_restore(t.world, NULL, buffer, size), PLI_OK);
    speeds = distances = 0;
    assert_int_equal(pli_world_step(t.world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(speeds, speeds_before);
    assert_int_equal(distances, distances_before);
    free(buffer);
    end(&t);
}

// ------------------------------------------------------------------------------- every member is described as it is

/* Bytes in memory of a struct of `size` bytes by the letters of its members (body/feature.h); 0: of unknown letters. */
static size_t size_by_letters(const char* fields, size_t size) {
    size_t end = 0, largest = 1;
    while (*fields != '\0') {
        char* after = NULL;
        const unsigned long count = strtoul(fields, &after, 10);
        const size_t times = after != fields ? count : 1;
        const char letter = *after++;
        const size_t own = letter == 'B'                          ? sizeof(bool)
                           : letter == 'h'                        ? 2
                           : letter == 'd' || letter == 'U'       ? 8
                           : strchr("OPQRSJX|", letter) != NULL   ? sizeof(void*)
                           : strchr("nNFHLfgiue", letter) != NULL ? 4
                                                                  : 0;
        if (letter == '*') { return end <= size ? size : 0; }
        if (own == 0) { return 0; }
        if (letter == 'e') { (void)strtoul(after, &after, 10); }
        end = (end + own - 1) / own * own + (letter == '|' ? 0 : times * own);
        largest = own > largest ? own : largest;
        fields = after;
    }
    return (end + largest - 1) / largest * largest;
}

static void every_field_has_the_size_of_its_member(void** unused) {
    (void)unused;
    for (int i = 0; i < ALL_CLASSES; ++i) {
        const plii_feature_class* klass = all_classes[i];
        assert_true(strlen(klass->name) < 32);
        for (const plii_feature_array* array = klass->arrays; array != NULL && array->element_size > 0; ++array) {
            const bool is_kept = array->snapshot == PLII_SAVED || array->snapshot == PLII_FILED;
            if (!is_kept) { continue; }
            if (array->fields == NULL || size_by_letters(array->fields, array->element_size) != array->element_size) {
                fail_msg("%s: array at %zu: %s", klass->name, array->member, array->fields);
            }
        }
        for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
            if (part->snapshot == PLII_LEFT) { continue; }
            if (part->fields == NULL || size_by_letters(part->fields, part->size) != part->size) {
                fail_msg("%s: part at %zu: %s", klass->name, part->offset, part->fields);
            }
        }
    }
}

// ---------------------------------------------------------------------------------------------------- what is wrong

static void expect_refused(trial* t, const void* buffer, size_t size, pli_status status, const char* message) {
    const uint64_t hash = hash_of(t);
    const size_t bytes = pli_context_allocated_bytes(t->context);
    pli_world* made = NULL;
    assert_int_equal(pli_world_file_create(t->context, NULL, buffer, size, &made), status);
    if (strstr(pli_last_error(t->context), message) == NULL) { fail_msg("%s", pli_last_error(t->context)); }
    assert_null(made);
    assert_int_equal(pli_world_file_restore(t->world, NULL, buffer, size), status);
    assert_int_equal(pli_context_allocated_bytes(t->context), bytes);
    assert_true(hash_of(t) == hash);
}

static void what_is_wrong_is_refused(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_CLUSTERS, POSITION, 1);
    for (int i = 0; i < 10; ++i) {
        step(&t);
    }
    size_t size = 0;
    unsigned char* buffer = write_file(t.world, &size);
    for (size_t cut = 0; cut < size; cut = cut < 200 ? cut + 1 : cut + 1999) {
        expect_refused(&t, buffer, cut, PLI_ERROR_FILE_FORMAT, "");
    }
    for (size_t cut = PLII_FILE_HEADER_SIZE; cut < size; cut += cut < 400 ? 1 : 1999) { /* as if it were all of it */
        unsigned char* part = malloc(cut);
        memcpy(part, buffer, cut);
        file_seal(part, cut);
        expect_refused(&t, part, cut, PLI_ERROR_FILE_FORMAT, "");
        free(part);
    }
    buffer[8] = 9;
    expect_refused(&t, buffer, size, PLI_ERROR_FILE_FORMAT, "the file is of version 9, this is 8");
    buffer[8] = 8;
    buffer[size / 2] ^= 1;
    expect_refused(&t, buffer, size, PLI_ERROR_FILE_FORMAT, "its checksum is wrong");
    buffer[size / 2] ^= 1;
    trial other;
    start(&other, TRIAL_CLOTH, POSITION, 1);
    assert_int_equal(pli_world_file_restore(other.world, NULL, buffer, size), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(other.context), "it has 1 bodies, 4 in the file"));
    end(&other);
    assert_int_equal(pli_world_file_write(t.world, NULL, buffer, size - 1, NULL), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_world_file_write(t.world, NULL, NULL, 0, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_file_size(NULL), 0);
    free(buffer);
    end(&t);
}

// ---------------------------------------------------------------------------------- no setting that calls would refuse

typedef struct settings_check {
    trial* t;
    const plii_feature_class* klass;
    int refused;
} settings_check;

static void expect_setting_refused(settings_check* check, const plii_field* field) {
    size_t size = 0;
    unsigned char* buffer = write_file(check->t->world, &size);
    pli_world* made = NULL;
    const pli_status status = pli_world_file_create(check->t->context, NULL, buffer, size, &made);
    const char* message = pli_last_error(check->t->context);
    char named[80];
    snprintf(named, sizeof named, "%s: %s is out of range", check->klass->name, field->name);
    /* Enumerations have limits of their own. */
    const bool is_told = strstr(message, named) != NULL || strstr(message, "an index is out of range") != NULL;
    if (status != PLI_ERROR_FILE_FORMAT || !is_told) {
        fail_msg("%s of %s: status %d, %s", field->name, check->klass->name, (int)status, message);
    }
    check->refused += 1;
    free(buffer);
}

/* `values` of a body, which are put back. */
static void try_settings(settings_check* check, const plii_limits* settings, void* values) {
    for (int i = 0; i < settings->count; ++i) {
        const plii_field* field = &settings->fields[i];
        char* at = (char*)values + settings->offset + field->offset;
        const bool is_int = field->type == PLII_FIELD_INT;
        for (int side = 0; side < 2; ++side) {
            const float limit = side == 0 ? field->lowest : field->highest;
            if (is_int && fabsf(limit) >= (float)INT_MAX) { continue; }
            const float past = nextafterf(limit, side == 0 ? -INFINITY : INFINITY);
            const int number = is_int ? (int)limit + (side == 0 ? -1 : 1) : 0;
            int kept = 0;
            memcpy(&kept, at, sizeof kept);
            memcpy(at, is_int ? (const void*)&number : (const void*)&past, sizeof kept);
            expect_setting_refused(check, field);
            memcpy(at, &kept, sizeof kept);
        }
    }
}

static void try_settings_of_body(trial* t, pli_body* body, bool* tried) {
    for (int i = 0; i < body->pipeline.feature_count; ++i) {
        const plii_feature* feature = &body->pipeline.features[i];
        settings_check check = {.t = t, .klass = feature->klass};
        try_settings(&check, &feature->klass->settings, feature->state);
        const plii_feature_array* array = feature->klass->arrays;
        for (; array != NULL && array->element_size > 0; ++array) {
            if (array->settings.count == 0) { continue; }
            int count = 0;
            memcpy(&count, (char*)feature->state + array->count, sizeof count);
            if (count == 0) { continue; }
            char* items = plii_feature_array_address(body, array, feature->state);
            try_settings(&check, &array->settings, items + (size_t)(count - 1) * array->element_size);
        }
        for (int k = 0; k < ALL_CLASSES; ++k) {
            tried[k] = tried[k] || (all_classes[k] == feature->klass && check.refused > 0);
        }
    }
}

/* What trials do not have. */
static void add_block(trial* t) {
    const pli_vec3 corners[4] = {{0, 3, 0}, {1, 3, 0}, {0, 4, 0}, {0, 3, 1}};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_from_tetras(t->context, 4, corners, 1, (const int[4]){0, 1, 2, 3}, &mesh), PLI_OK);
    pli_body* body = add_body(t, mesh, 1, XPBD);
    assert_int_equal(pli_body_enable_xpbd_tetras(body, 1e-4f), PLI_OK);
    assert_int_equal(pli_body_enable_sleep(body, NULL), PLI_OK);
    assert_int_equal(pli_body_enable_restitution(body, 0.5f), PLI_OK);
    const pli_target target = {.node = 0, .max_distance = 0.1f};
    pli_targets_def targets = pli_targets_def_default();
    targets.count = 1;
    targets.targets = &target;
    assert_int_equal(pli_body_enable_targets(body, &targets), PLI_OK);
}

static void no_setting_is_out_of_range(void** unused) {
    (void)unused;
    bool tried[ALL_CLASSES] = {false};
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
            if (!has_trial((trial_kind)kind, (solver_choice)solver)) { continue; }
            trial t;
            start(&t, (trial_kind)kind, (solver_choice)solver, 1);
            if (solver == XPBD) { add_block(&t); }
            pli_aero_def aero = pli_aero_def_default();
            aero.model = PLI_AERO_FACE_TWO_SIDED;
            if (kind == TRIAL_SOFT) { assert_int_equal(pli_body_enable_aero(t.bodies[0], &aero), PLI_OK); }
            for (int i = 0; i < t.body_count; ++i) {
                try_settings_of_body(&t, t.bodies[i], tried);
            }
            end(&t);
        }
    }
    for (int i = 0; i < ALL_CLASSES; ++i) {
        const plii_feature_class* klass = all_classes[i];
        bool has_settings = klass->settings.count > 0;
        for (const plii_feature_array* array = klass->arrays; array != NULL && array->element_size > 0; ++array) {
            has_settings = has_settings || array->settings.count > 0;
        }
        if (has_settings != tried[i]) { fail_msg("%s was not tried", klass->name); }
    }
}

/* What a definition of the user is kept as has limits: a part that ends with its mark. */
static void every_definition_has_limits(void** unused) {
    (void)unused;
    for (int i = 0; i < ALL_CLASSES; ++i) {
        const plii_feature_class* klass = all_classes[i];
        for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
            const size_t length = part->fields != NULL ? strlen(part->fields) : 0;
            const bool is_definition =
                length > 1 && part->fields[length - 1] == 'u' && strpbrk(part->fields, "fi") != NULL;
            if (is_definition && klass->settings.count == 0) { fail_msg("%s has no limits", klass->name); }
        }
    }
}

static void the_world_and_its_bodies_have_limits(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_BALLS, POSITION, 1);
    pli_body* body = t.bodies[1];
    float* const numbers[] = {&t.world->def.air_density,      &t.world->dt,
                              &body->collision_margin,        &body->materials[0].linear_stiffness,
                              &body->solver.velocity_damping, &body->solver.time_scale};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        for (int side = 0; side < 2; ++side) {
            const float kept = *numbers[i];
            *numbers[i] = side == 0 ? -0.01f : 1e30f;
            size_t size = 0;
            unsigned char* buffer = write_file(t.world, &size);
            *numbers[i] = kept;
            expect_refused(&t, buffer, size, PLI_ERROR_FILE_FORMAT, "out of range");
            free(buffer);
        }
    }
    end(&t);
}

/* What has been read by then ends, too. */
static void an_order_without_a_body_is_refused(void** unused) {
    (void)unused;
    trial t;
    start(&t, TRIAL_BALLS, POSITION, 1);
    pli_body** const first = &t.world->sweep[0];
    pli_body *const kept = *first, *const others[] = {NULL, t.world->sweep[1]};
    for (int i = 0; i < 2; ++i) {
        *first = others[i];
        size_t size = 0;
        unsigned char* buffer = write_file(t.world, &size);
        *first = kept;
        expect_refused(&t, buffer, size, PLI_ERROR_FILE_FORMAT, "a body is missing");
        free(buffer);
    }
    end(&t);
}

/* A world that was made of a file that was tampered with may be stepped. */
static void nothing_in_a_file_harms(void** unused) {
    (void)unused;
    enum { MUTATIONS = 1000 };
    uint64_t dice = 12345;
    int accepted = 0, tried = 0;
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        const solver_choice solver = kind == TRIAL_CLUSTERS ? POSITION : kind % 2 == 0 ? XPBD : GRADIENTS;
        trial t;
        start(&t, (trial_kind)kind, solver, 1);
        for (int i = 0; i < 20; ++i) {
            step(&t);
        }
        size_t size = 0;
        unsigned char* buffer = write_file(t.world, &size);
        end(&t);
        pli_context* hostile_context = NULL;
        assert_int_equal(pli_context_create(NULL, &hostile_context), PLI_OK);
        unsigned char* file = malloc(size);
        for (int i = 0; i < MUTATIONS / TRIAL_KINDS + 1; ++i, ++tried) {
            memcpy(file, buffer, size);
            for (int k = 0; k < 1 + i % 4; ++k) {
                dice = dice * 6364136223846793005u + 1442695040888963407u;
                const size_t at = PLII_FILE_HEADER_SIZE + (size_t)(dice >> 33) % (size - PLII_FILE_HEADER_SIZE);
                file[at] = (unsigned char)(i % 3 == 0 ? file[at] ^ (1u << (dice >> 8 & 7)) : dice >> 16);
            }
            file_seal(file, size);
            pli_world* made = NULL;
            if (pli_world_file_create(hostile_context, NULL, file, size, &made) != PLI_OK) { continue; }
            accepted += 1;
            bool is_short = true;
            for (int b = 0; b < pli_world_body_count(made); ++b) {
                is_short = is_short && has_short_steps(pli_world_get_body(made, b));
            }
            for (int s = 0; s < 2 && is_short; ++s) {
                (void)pli_world_step(made, 1.0f / 60.0f);
            }
            pli_world_destroy(made);
        }
        assert_int_equal(pli_context_allocated_bytes(hostile_context), 0);
        assert_int_equal(pli_context_destroy(hostile_context), PLI_OK);
        free(file);
        free(buffer);
    }
    print_message("%d of %d mutations made a world\n", accepted, tried);
    assert_true(tried >= MUTATIONS && accepted > 0 && accepted < tried);
}

static void without_memory_nothing_is_left(void** unused) {
    (void)unused;
    const trial_kind kinds[] = {TRIAL_CLOTH, TRIAL_SELF_NODES, TRIAL_SOFT, TRIAL_CLUSTERS};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; ++k) {
        trial t;
        start(&t, kinds[k], POSITION, 1);
        for (int i = 0; i < 10; ++i) {
            step(&t);
        }
        size_t size = 0;
        unsigned char* buffer = write_file(t.world, &size);
        end(&t);
        failing_allocator allocator;
        pli_context* failing = failing_context(&allocator);
        const long alive = allocator.alive;
        int failures = 0;
        for (long n = 1;; n += 1 + n / 16) {
            const long failed = allocator.failed;
            allocator.fail_at = n;
            pli_world* made = NULL;
            const pli_status status = pli_world_file_create(failing, NULL, buffer, size, &made);
            allocator.fail_at = 0;
            assert_true((status == PLI_OK) == (made != NULL));
            pli_world_destroy(made);
            assert_int_equal(allocator.alive, alive);
            if (allocator.failed == failed) { break; }
            failures += status != PLI_OK;
        }
        assert_true(failures > 10);
        assert_int_equal(pli_context_destroy(failing), PLI_OK);
        free(buffer);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field_has_the_size_of_its_member),
        cmocka_unit_test(a_world_of_a_file_goes_on),
        cmocka_unit_test(worlds_that_are_equal_have_equal_files),
        cmocka_unit_test(worlds_that_go_back_to_their_beginning_have_equal_files),
        cmocka_unit_test(update_intervals_come_with_a_file),
        cmocka_unit_test(what_is_left_of_an_update_interval_comes_with_a_file),
        cmocka_unit_test_setup_teardown(light_nodes_come_with_a_file, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(faces_without_an_area_come_with_a_file, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(clusters_of_a_body_that_touch_come_with_a_file, setup_world, teardown_world),
        cmocka_unit_test(nothing_is_changed_while_a_file_is_written),
        cmocka_unit_test(what_is_wrong_is_refused),
        cmocka_unit_test(no_setting_is_out_of_range),
        cmocka_unit_test(callbacks_stay_when_a_world_goes_back),
        cmocka_unit_test(every_definition_has_limits),
        cmocka_unit_test(the_world_and_its_bodies_have_limits),
        cmocka_unit_test(an_order_without_a_body_is_refused),
        cmocka_unit_test(nothing_in_a_file_harms),
        cmocka_unit_test(without_memory_nothing_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
