/* Contacts that begin, go on and end, and that what they say they pushed is what momenta changed by. */

#include "heavy_bodies.h"

#define STEP (1.0f / 60.0f)
#define GRAVITY 10.0f

typedef enum solver_kind { POSITION, IMPLICIT, XPBD, SOLVER_COUNT } solver_kind;

static void use_solver(pli_body* body, solver_kind kind) {
    if (kind == IMPLICIT) {
        pli_implicit_def def = pli_implicit_def_default();
        def.method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
        def.sweeps = 60;
        CHECK_OK(pli_body_enable_implicit(body, &def));
    }
    if (kind == XPBD) {
        CHECK_OK(pli_body_enable_xpbd(body, NULL));
        CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
    }
}

static pli_body* make_told_sheet(sheet_pins pins, solver_kind kind, bool has_nodes, bool has_faces) {
    pli_solver_settings settings = pli_body_def_default().solver;
    settings.position_iterations = 10;
    pli_body* sheet = make_sheet(pins, &settings, has_nodes, has_faces);
    use_solver(sheet, kind);
    CHECK_OK(pli_body_enable_contact_events(sheet, NULL));
    return sheet;
}

static int count_of(const pli_body* body, pli_contact_phase phase) {
    int count = -1;
    const pli_contact_event* events = pli_body_get_contact_events(body, phase, &count);
    assert_true((events == NULL) == (count == 0));
    return count;
}

/* N s, of all that `body` touches. */
static pli_vec3 impulse_on(const pli_body* body) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int phase = PLI_CONTACT_BEGIN; phase <= PLI_CONTACT_END; ++phase) {
        int count = 0;
        const pli_contact_event* events = pli_body_get_contact_events(body, (pli_contact_phase)phase, &count);
        for (int i = 0; i < count; ++i) {
            sum = pli_vec3_add(sum, events[i].impulse);
        }
    }
    return sum;
}

// ---------------------------------------------------------------------------------------------------- momentum

typedef struct balance {
    double worst; /* largest difference of momentum and impulse of a step, N s */
    double mean;  /* of the upward impulses at rest, N s */
    int begun, ended;
} balance;

/* A ball of 1 kg falls from 0.2 m on a sheet of 1 kg that is pinned at its rim. */
static balance drop_ball(solver_kind kind, bool has_nodes, bool has_faces) {
    enum { STEPS = 600, RESTING = 60 };
    const float mass = 1.0f;
    pli_body* sheet = make_told_sheet(SHEET_RIM, kind, has_nodes, has_faces);
    pli_rigid* ball = make_ball(ball_radius + 0.2f, mass);
    balance result = {0};
    pli_vec3 before = pli_vec3_make(0, 0, 0);
    for (int step = 0; step < STEPS; ++step) {
        CHECK_OK(pli_world_step(world, STEP));
        const pli_vec3 velocity = pli_rigid_get_state(ball).linear_velocity;
        const pli_vec3 pushed = pli_vec3_neg(impulse_on(sheet));
        pli_vec3 change = pli_vec3_scale(pli_vec3_sub(velocity, before), mass);
        if (step > 0) { change.y += mass * GRAVITY * STEP; }
        result.worst = fmax(result.worst, (double)pli_vec3_length(pli_vec3_sub(change, pushed)));
        if (step >= STEPS - RESTING) { result.mean += (double)pushed.y / RESTING; }
        before = velocity;
        result.begun += count_of(sheet, PLI_CONTACT_BEGIN);
        result.ended += count_of(sheet, PLI_CONTACT_END);
        CHECK_OK(pli_rigid_integrate(ball, pli_vec3_make(0, -GRAVITY, 0), STEP));
    }
    pli_rigid_destroy(ball);
    pli_body_destroy(sheet);
    return result;
}

static void a_ball_takes_the_impulses_that_are_told(void** state) {
    (void)state;
    for (int kind = 0; kind < SOLVER_COUNT; ++kind) {
        for (int elements = PLIANT_CHECKED ? 3 : 1; elements <= 3; ++elements) {
            const balance b = drop_ball((solver_kind)kind, (elements & 1) != 0, (elements & 2) != 0);
            check_at_most(b.worst, 1e-4);
            check_near(b.mean, GRAVITY * STEP, 0.01 * (double)(GRAVITY * STEP));
            assert_in_range(b.begun, 1, 3); /* it may bounce */
            assert_int_equal(b.begun, b.ended + 1);
        }
    }
}

static void a_sheet_takes_the_impulses_that_are_told(void** state) {
    (void)state;
    for (int kind = 0; kind < SOLVER_COUNT; ++kind) {
        pli_body* sheet = make_told_sheet(SHEET_LOOSE, (solver_kind)kind, true, false);
        pli_shape* plane = NULL;
        CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), -0.2f, &plane));
        pli_rigid* floor = make_rigid(plane, 0, 0);
        double worst = 0, mean = 0;
        float before = 0;
        for (int step = 0; step < 200; ++step) {
            CHECK_OK(pli_world_step(world, STEP));
            const float momentum = pli_body_momentum(sheet).y, pushed = impulse_on(sheet).y;
            const double off = fabs((double)(momentum - before - pushed) + (double)(GRAVITY * STEP));
            worst = fmax(worst, off);
            if (step >= 140) { mean += (double)pushed / 60; }
            before = momentum;
        }
        check_at_most(worst, 5e-5);
        check_near(mean, GRAVITY * STEP, 1e-4);
        int count = 0;
        const pli_contact_event* event = pli_body_get_contact_events(sheet, PLI_CONTACT_PERSIST, &count);
        assert_int_equal(count, 1);
        check_near(event->point.x, 0, 1e-3); /* it lies around the origin */
        check_near(event->point.y, -0.2, 1e-5);
        check_near(event->point.z, 0, 1e-3);
        check_near(event->normal.y, 1, 1e-6);
        assert_int_equal(event->contact_count, SHEET_NODES);
        pli_rigid_destroy(floor);
        pli_body_destroy(sheet);
    }
}

static void soft_bodies_take_the_impulses_that_are_told(void** state) {
    (void)state;
    for (int kind = 0; kind < SOLVER_COUNT; ++kind) {
        pli_body* below = make_told_sheet(SHEET_RIM, (solver_kind)kind, false, false);
        pli_body* above = make_told_sheet(SHEET_LOOSE, (solver_kind)kind, false, false);
        CHECK_OK(pli_body_enable_soft_contacts(below, NULL));
        CHECK_OK(pli_body_enable_soft_contacts(above, NULL));
        CHECK_OK(
            pli_body_transform(above, (pli_transform){pli_mat3_from_euler_zyx(0, 0.5f, 0), pli_vec3_make(0, 0.2f, 0)}));
        double worst = 0, mean = 0, odd = 0;
        float before = 0;
        for (int step = 0; step < 200; ++step) {
            CHECK_OK(pli_world_step(world, STEP));
            const float momentum = pli_body_momentum(above).y, pushed = impulse_on(above).y;
            const double off = fabs((double)(momentum - before - pushed) + (double)(GRAVITY * STEP));
            worst = fmax(worst, off);
            odd = fmax(odd, (double)pli_vec3_length(pli_vec3_add(impulse_on(above), impulse_on(below))));
            if (step >= 140) { mean += (double)pushed / 60; }
            before = momentum;
        }
        check_at_most(worst, 5e-5);
        check_at_most(odd, 5e-6);
        check_near(mean, GRAVITY * STEP, 0.03 * (double)(GRAVITY * STEP));
        pli_body_destroy(below);
        pli_body_destroy(above);
    }
}

static int setup_reference_world(void** state) {
    if (setup_context(state) != 0) { return -1; }
    pli_world_def def = pli_world_def_default();
    def.gravity = pli_vec3_make(0, 0, 0);
    def.reference_mode = true;
    return pli_world_create(context, &def, &world) == PLI_OK ? 0 : -1;
}

/* A sheet meets one that is solved before it, or after it, and both have the velocities of what they are told. */
static void soft_bodies_of_reference_mode_take_the_impulses_that_are_told(void** state) {
    (void)state;
    for (int falling = 0; falling < 2; ++falling) {
        pli_body* sheets[2];
        pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
        contacts.bullet_boxes = true;
        contacts.recovery_speed = 1;
        for (int k = 0; k < 2; ++k) {
            sheets[k] = make_told_sheet(SHEET_LOOSE, POSITION, false, false);
            CHECK_OK(pli_body_enable_soft_contacts(sheets[k], &contacts));
        }
        CHECK_OK(pli_body_transform(sheets[falling],
                                    (pli_transform){pli_mat3_from_euler_zyx(0, 0.5f, 0), pli_vec3_make(0, 0.1f, 0)}));
        CHECK_OK(pli_body_add_velocity(sheets[falling], pli_vec3_make(0, -1, 0)));
        double worst[2] = {0}, pushed[2] = {0}, odd = 0;
        for (int step = 0; step < 20; ++step) {
            pli_vec3 before[2], told[2];
            for (int k = 0; k < 2; ++k) {
                before[k] = pli_body_momentum(sheets[k]);
            }
            CHECK_OK(pli_world_step(world, STEP));
            for (int k = 0; k < 2; ++k) {
                told[k] = impulse_on(sheets[k]);
                const pli_vec3 change = pli_vec3_sub(pli_body_momentum(sheets[k]), before[k]);
                worst[k] = fmax(worst[k], (double)pli_vec3_length(pli_vec3_sub(change, told[k])));
                pushed[k] += (double)told[k].y;
            }
            odd = fmax(odd, (double)pli_vec3_length(pli_vec3_add(told[0], told[1])));
        }
        check_at_most(worst[0], 5e-6);
        check_at_most(worst[1], 5e-6);
        check_at_most(odd, 3e-6);
        check_near(pushed[falling], 0.47, 0.01);
        pli_body_destroy(sheets[0]);
        pli_body_destroy(sheets[1]);
    }
}

// ------------------------------------------------------------------------------------------------------- phases

/* A loose sheet comes down on a ball that then goes away. */
static void contacts_begin_persist_and_end(void** state) {
    (void)state;
    for (int kind = 0; kind < SOLVER_COUNT; ++kind) {
        pli_body* sheet = make_told_sheet(SHEET_CORNERS, (solver_kind)kind, true, false);
        pli_rigid* ball = make_ball(-ball_radius - 0.1f, 0);
        int begun = 0, ended = 0, gone = 0, step = 0;
        for (; step < 200; ++step) {
            CHECK_OK(pli_world_step(world, STEP));
            int count = 0;
            const pli_contact_event* begin = pli_body_get_contact_events(sheet, PLI_CONTACT_BEGIN, &count);
            begun += count;
            for (int i = 0; i < count; ++i) {
                assert_ptr_equal(begin[i].rigid, ball);
                assert_null(begin[i].other);
                assert_in_range(begin[i].node, 0, SHEET_NODES - 1);
                assert_int_equal(begin[i].face, PLI_NULL_INDEX);
                assert_int_equal(begin[i].shape, 0);
                const pli_vec3 from = pli_vec3_sub(begin[i].point, pli_vec3_make(0, -ball_radius - 0.1f, 0));
                check_near(pli_vec3_length(from), ball_radius, 0.03);
                assert_true(begin[i].normal.y > 0.7f && begin[i].impulse.y > 0.0f);
            }
            ended += count_of(sheet, PLI_CONTACT_END);
        }
        assert_int_equal(begun, ended + 1);
        assert_int_equal(count_of(sheet, PLI_CONTACT_PERSIST), 1);
        pli_rigid_destroy(ball); /* the arrays of the last step do not name it any more */
        assert_null(pli_body_get_contact_events(sheet, PLI_CONTACT_PERSIST, NULL)->rigid);
        CHECK_OK(pli_world_step(world, STEP));
        const pli_contact_event* end = pli_body_get_contact_events(sheet, PLI_CONTACT_END, &gone);
        assert_int_equal(gone, 1);
        assert_null(end->rigid);
        check_near(pli_vec3_length(end->impulse), 0, 0);
        assert_int_equal(end->contact_count, 0);
        CHECK_OK(pli_world_step(world, STEP));
        assert_int_equal(count_of(sheet, PLI_CONTACT_END), 0);
        pli_body_destroy(sheet);
    }
}

static float middle(pli_vec3 x, void* user) {
    (void)user;
    return x.x - 0.013f;
}

/* What has ended names no face when faces have other indices since. */
static void an_end_after_a_cut_names_no_face(void** state) {
    (void)state;
    pli_body* sheet = make_told_sheet(SHEET_CORNERS, POSITION, false, true);
    pli_rigid* ball = make_ball(-ball_radius - 0.1f, 0);
    for (int step = 0; step < 200; ++step) {
        CHECK_OK(pli_world_step(world, STEP));
    }
    int count = 0;
    const pli_contact_event* event = pli_body_get_contact_events(sheet, PLI_CONTACT_PERSIST, &count);
    assert_int_equal(count, 1);
    assert_in_range(event->face, 0, pli_body_get_view(sheet).face_count - 1);
    pli_refine_def def = pli_refine_def_default();
    def.surface = middle;
    def.cut = false;
    CHECK_OK(pli_body_refine(sheet, &def));
    pli_rigid_state away = pli_rigid_get_state(ball);
    away.pose.origin.y -= 10;
    CHECK_OK(pli_rigid_set_state(ball, &away));
    CHECK_OK(pli_world_step(world, STEP));
    event = pli_body_get_contact_events(sheet, PLI_CONTACT_END, &count);
    assert_int_equal(count, 1);
    assert_ptr_equal(event->rigid, ball);
    assert_int_equal(event->face, PLI_NULL_INDEX);
}

static void each_element_is_told_when_wanted(void** state) {
    (void)state;
    pli_body* sheet = make_told_sheet(SHEET_LOOSE, POSITION, true, false);
    pli_contact_events_def def = pli_contact_events_def_default();
    def.each_element = true;
    CHECK_OK(pli_body_enable_contact_events(sheet, &def));
    pli_shape* plane = NULL;
    CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), -0.1f, &plane));
    (void)make_rigid(plane, 0, 0);
    for (int step = 0; step < 120; ++step) {
        CHECK_OK(pli_world_step(world, STEP));
        int count = 0;
        const pli_contact_event* events = pli_body_get_contact_events(sheet, PLI_CONTACT_BEGIN, &count);
        for (int i = 0; i < count; ++i) {
            assert_in_range(events[i].node, 0, SHEET_NODES - 1);
            assert_int_equal(events[i].contact_count, 1);
        }
        if (step < 60) { continue; } /* it rests */
        assert_int_equal(count_of(sheet, PLI_CONTACT_END), 0);
        assert_int_equal(count_of(sheet, PLI_CONTACT_PERSIST), SHEET_NODES);
    }
    check_near(impulse_on(sheet).y, GRAVITY * STEP, 1e-4);
}

static void sensors_tell_and_do_not_push(void** state) {
    (void)state;
    uint64_t hashes[2];
    for (int has_sensor = 0; has_sensor < 2; ++has_sensor) {
        pli_body* sheet = make_told_sheet(SHEET_LOOSE, XPBD, true, true);
        pli_rigid* ball = has_sensor != 0 ? make_ball(-1, 0) : NULL;
        int begun = 0, ended = 0;
        if (ball != NULL) {
            pli_shape* shapes[2] = {NULL, NULL}; /* it meets the second one */
            pli_transform poses[2] = {pli_transform_identity(), pli_transform_identity()};
            poses[0].origin.y = -9;
            CHECK_OK(pli_shape_create_sphere(context, 0.1f, &shapes[0]));
            CHECK_OK(pli_shape_create_sphere(context, ball_radius, &shapes[1]));
            CHECK_OK(pli_rigid_set_shapes(ball, 2, shapes, poses));
            pli_shape_release(shapes[0]);
            pli_shape_release(shapes[1]);
            CHECK_OK(pli_rigid_set_sensor(ball, true));
            assert_true(pli_rigid_is_sensor(ball));
        }
        for (int step = 0; step < 60; ++step) {
            CHECK_OK(pli_world_step(world, STEP));
            int count = 0;
            const pli_contact_event* begin = pli_body_get_contact_events(sheet, PLI_CONTACT_BEGIN, &count);
            if (count > 0) {
                assert_true(begin->is_sensor);
                assert_int_equal(begin->shape, 1);
                check_near(pli_body_get_view(sheet).positions[begin->node].y, -1 + ball_radius + sheet_margin, 0.1);
            }
            begun += count;
            ended += count_of(sheet, PLI_CONTACT_END);
        }
        assert_int_equal(begun, has_sensor);
        assert_int_equal(ended, has_sensor);
        hashes[has_sensor] = pli_body_state_hash(sheet);
        pli_rigid_destroy(ball);
        pli_body_destroy(sheet);
    }
    assert_true(hashes[0] == hashes[1]);
}

/* Telling changes no bit, and steady steps allocate nothing. */
static void telling_changes_nothing(void** state) {
    (void)state;
    for (int kind = 0; kind < SOLVER_COUNT; ++kind) {
        uint64_t hashes[2];
        for (int tells = 0; tells < 2; ++tells) {
            pli_body* below = make_told_sheet(SHEET_CORNERS, (solver_kind)kind, true, true);
            pli_body* above = make_told_sheet(SHEET_LOOSE, (solver_kind)kind, true, false);
            CHECK_OK(pli_body_enable_soft_contacts(below, NULL));
            CHECK_OK(pli_body_enable_soft_contacts(above, NULL));
            CHECK_OK(pli_body_transform(
                above, (pli_transform){pli_mat3_from_euler_zyx(0, 0.5f, 0), pli_vec3_make(0, 0.1f, 0)}));
            if (tells == 0) {
                CHECK_OK(pli_body_disable_contact_events(below));
                CHECK_OK(pli_body_disable_contact_events(above));
                assert_int_equal(count_of(below, PLI_CONTACT_BEGIN), 0);
            }
            pli_rigid* ball = make_ball(-ball_radius - 0.1f, 0);
            uint64_t allocations = 0;
            for (int step = 0; step < 120; ++step) {
                if (step == 90) { allocations = pli_context_allocation_count(context); }
                CHECK_OK(pli_world_step(world, STEP));
            }
            assert_int_equal(pli_context_allocation_count(context), allocations);
            hashes[tells] = pli_body_state_hash(below) ^ (3 * pli_body_state_hash(above));
            pli_rigid_destroy(ball);
            pli_body_destroy(below);
            pli_body_destroy(above);
        }
        assert_true(hashes[0] == hashes[1]);
    }
}

static float rows(pli_vec3 x, void* user) {
    (void)user;
    return sinf(13 * (x.x + 0.6f * x.z) + 0.1f);
}

/* A step in which contacts outgrow their room, and a refinement right after it, leave one list larger than the other.
 */
static void lists_do_not_outgrow_each_other(void** state) {
    (void)state;
    enum { SENSORS = 3, STEPS = 20 };
    const pli_patch_def patch = level_sheet(1, 0, 9);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    pli_body* sheet = NULL;
    CHECK_OK(pli_body_create(world, mesh, NULL, &sheet));
    pli_mesh_destroy(mesh);
    pli_contact_events_def def = pli_contact_events_def_default();
    def.each_element = true;
    CHECK_OK(pli_body_enable_contact_events(sheet, &def));
    for (int i = 0; i < SENSORS; ++i) {
        pli_shape* plane = NULL;
        CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 1, &plane));
        CHECK_OK(pli_rigid_set_sensor(make_rigid(plane, 0, 0), true));
    }
    CHECK_OK(pli_world_step(world, STEP));
    pli_refine_def refine = pli_refine_def_default();
    refine.surface = rows;
    refine.cut = false;
    CHECK_OK(pli_body_refine(sheet, &refine));
    CHECK_OK(pli_world_step(world, STEP));
    CHECK_OK(pli_world_step(world, STEP));
    const int nodes = pli_body_get_view(sheet).node_count;
    const uint64_t allocations = pli_context_allocation_count(context);
    const size_t bytes = pli_context_allocated_bytes(context);
    for (int step = 0; step < STEPS; ++step) {
        CHECK_OK(pli_world_step(world, STEP));
        assert_int_equal(count_of(sheet, PLI_CONTACT_PERSIST), SENSORS * nodes);
    }
    assert_int_equal(pli_context_allocation_count(context), allocations);
    assert_int_equal(pli_context_allocated_bytes(context), bytes);
}

static void wrong_calls_are_refused(void** state) {
    (void)state;
    pli_body* sheet = make_told_sheet(SHEET_LOOSE, POSITION, true, false);
    const pli_contact_events_def unmade = {0};
    int count = 7;
    check_refused(pli_body_enable_contact_events(sheet, &unmade), PLI_ERROR_INVALID_DEF, "pli_contact_events_def");
    assert_null(pli_body_get_contact_events(sheet, (pli_contact_phase)3, &count));
    assert_int_equal(count, 0);
    CHECK_OK(pli_world_predict(world, STEP));
    check_refused(pli_body_enable_contact_events(sheet, NULL), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_refused(pli_body_disable_contact_events(sheet), PLI_ERROR_WRONG_STATE, "between predict and solve");
    CHECK_OK(pli_world_solve(world));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_ball_takes_the_impulses_that_are_told, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_sheet_takes_the_impulses_that_are_told, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(soft_bodies_take_the_impulses_that_are_told, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(soft_bodies_of_reference_mode_take_the_impulses_that_are_told,
                                        setup_reference_world, teardown_world),
        cmocka_unit_test_setup_teardown(contacts_begin_persist_and_end, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(an_end_after_a_cut_names_no_face, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(each_element_is_told_when_wanted, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(sensors_tell_and_do_not_push, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(telling_changes_nothing, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(lists_do_not_outgrow_each_other, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(wrong_calls_are_refused, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
