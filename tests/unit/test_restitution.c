/* Restitution of contacts with rigid bodies: what share of the speed comes back, with each solver. */

#include "heavy_bodies.h"
#include "level_sheet.h"

#include <pliant/cut.h>

#include <math.h>

static const float dt = 1.0f / 240.0f;

typedef enum solver { POSITION_BASED, XPBD, IMPLICIT, SOLVERS } solver;

static void use(pli_body* body, solver which) {
    if (which == XPBD) {
        CHECK_OK(pli_body_enable_xpbd(body, NULL));
        CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
    }
    if (which == IMPLICIT) { CHECK_OK(pli_body_enable_implicit(body, NULL)); }
}

static pli_rigid* make_floor(float restitution) {
    pli_rigid_def def = pli_rigid_def_default();
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(5, 1, 5), &shape));
    def.shape_count = 1;
    def.shapes = &shape;
    def.state.pose.origin = pli_vec3_make(0, -1, 0);
    def.restitution = restitution;
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

/* A level patch of 5 x 5 nodes, whose nodes all meet the floor in the same step. */
static pli_body* make_patch(float height, bool has_faces, solver which, float restitution) {
    pli_patch_def patch = level_sheet(0.5f, height, 5);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    use(body, which);
    if (has_faces) {
        CHECK_OK(pli_body_enable_rigid_face_contacts(body, NULL));
    } else {
        CHECK_OK(pli_body_enable_rigid_contacts(body, NULL));
    }
    if (restitution > 0) { CHECK_OK(pli_body_enable_restitution(body, restitution)); }
    return body;
}

static float height_of(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float sum = 0;
    for (int i = 0; i < view.node_count; ++i) {
        sum += view.positions[i].y;
    }
    return sum / (float)view.node_count;
}

/* How high it gets after the first impact on a floor, which goes with it, as a share of the fall; 0.5 m. */
static float bounce_on(pli_rigid* floor_body, bool has_faces, solver which, float restitution) {
    const float start = 0.52f;
    pli_body* body = make_patch(start, has_faces, which, restitution);
    float highest = 0;
    bool has_met = false;
    for (int i = 0; i < 240; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        const float height = height_of(body) - 0.02f;
        has_met = has_met || height < 0.02f;
        if (has_met) { highest = fmaxf(highest, height); }
    }
    assert_true(has_met);
    pli_body_destroy(body);
    pli_rigid_destroy(floor_body);
    return highest / (start - 0.02f);
}
static float bounce(bool has_faces, solver which, float restitution, float of_floor) {
    return bounce_on(make_floor(of_floor), has_faces, which, restitution);
}

/* The height is that of the square of the speed. */
static void a_share_of_the_speed_comes_back(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVERS; ++c) {
        const solver which = (solver)(c / 2);
        const bool has_faces = c % 2 != 0;
        check_at_most(bounce(has_faces, which, 0, 1), 0.05);
        check_near(bounce(has_faces, which, 0.5f, 1), 0.25, 0.02);
        check_near(bounce(has_faces, which, 1, 0.5f), 0.25, 0.02);
        check_near(bounce(has_faces, which, 1, 1), 0.98, 0.03);
        check_at_most(bounce(has_faces, which, 1, 0), 0.05);
    }
}

static void the_restitution_of_a_rigid_body_can_change(void** unused) {
    (void)unused;
    pli_rigid* floor_body = make_floor(0);
    CHECK_OK(pli_rigid_set_restitution(floor_body, 0.5f));
    check_near(bounce_on(floor_body, false, XPBD, 1), 0.25, 0.02);
    floor_body = make_floor(1);
    CHECK_OK(pli_rigid_set_restitution(floor_body, 0));
    check_at_most(bounce_on(floor_body, false, XPBD, 1), 0.05);
}

/* A ball of 1 kg that falls on the patch on the floor gets its share too, and the sum of both energies does not grow.
 */
static void a_body_bounces_off_what_lies(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVERS; ++which) {
        pli_rigid* floor_body = make_floor(0);
        pli_body* body = make_patch(0.02f, false, (solver)which, 0.8f);
        pli_rigid* ball = make_ball(1, 1);
        float highest = 0;
        bool has_met = false;
        for (int i = 0; i < 300; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(ball, pli_vec3_make(0, -10, 0), dt));
            const pli_rigid_state now = pli_rigid_get_state(ball);
            has_met = has_met || now.linear_velocity.y > 0;
            if (has_met) { highest = fmaxf(highest, now.pose.origin.y); }
        }
        assert_true(has_met);
        check_at_most(highest, 1.0);
        pli_rigid_destroy(ball);
        pli_body_destroy(body);
        pli_rigid_destroy(floor_body);
    }
}

static void a_cut_body_goes_on_bouncing(void** unused) {
    (void)unused;
    pli_rigid* rigid = make_floor(1);
    pli_body* body = make_patch(0.5f, false, POSITION_BASED, 1);
    CHECK_OK(pli_body_cut_link(body, 12, 13, 0.5f));
    assert_true(pli_body_get_view(body).node_count > 25);
    float lowest = 1, highest = 0;
    for (int i = 0; i < 240; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        const float height = height_of(body);
        lowest = fminf(lowest, height);
        if (lowest < 0.1f) { highest = fmaxf(highest, height); }
    }
    assert_true(highest > 0.3f);
    pli_body_destroy(body);
    pli_rigid_destroy(rigid);
}

static void wrong_values_are_refused(void** unused) {
    (void)unused;
    pli_body* body = make_patch(1, false, POSITION_BASED, 0);
    assert_int_equal(pli_body_enable_restitution(body, -0.1f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_enable_restitution(body, 1.1f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_enable_restitution(body, NAN), PLI_ERROR_NOT_FINITE);
    pli_rigid* rigid = make_floor(1);
    assert_int_equal(pli_rigid_set_restitution(rigid, -1), PLI_ERROR_INVALID_VALUE);
    CHECK_OK(pli_rigid_set_restitution(rigid, 0));
    CHECK_OK(pli_body_enable_restitution(body, 1));
    CHECK_OK(pli_body_disable_restitution(body));
    CHECK_OK(pli_body_disable_restitution(body));
    pli_rigid_destroy(rigid);
    pli_body_destroy(body);
}

/* Height above a lift, and the steps with a contact that begins or goes on, of a patch that falls onto it by 0.5 m. */
static float bounce_on_lift(float speed, solver which, int* events) {
    pli_rigid* lift = make_floor(1);
    pli_rigid_state state = pli_rigid_get_state(lift);
    state.linear_velocity.y = speed;
    CHECK_OK(pli_rigid_set_kind(lift, PLI_RIGID_KINEMATIC, &state));
    pli_body* body = make_patch(0.52f, false, which, 0.8f);
    CHECK_OK(pli_body_enable_contact_events(body, NULL));
    CHECK_OK(pli_body_add_velocity(body, pli_vec3_make(0, speed, 0)));
    float highest = 0;
    for (int i = 0; i < 220; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(lift, pli_vec3_make(0, 0, 0), dt));
        const float above = height_of(body) - pli_rigid_get_state(lift).pose.origin.y - 1.02f;
        if (i > 100) { highest = fmaxf(highest, above); }
        for (int phase = PLI_CONTACT_BEGIN; phase <= PLI_CONTACT_PERSIST; ++phase) {
            int count = 0;
            (void)pli_body_get_contact_events(body, (pli_contact_phase)phase, &count);
            *events += count;
        }
    }
    pli_body_destroy(body);
    pli_rigid_destroy(lift);
    return highest;
}

/* What touches is known by where the lift ends up in the step. */
static void a_patch_bounces_off_a_lift_as_off_the_floor(void** unused) {
    (void)unused;
    static const float speeds[] = {-20, -5, 5, 20};
    for (int which = 0; which < SOLVERS; ++which) {
        int events = 0;
        const float still = bounce_on_lift(0, (solver)which, &events);
        for (int i = 0; i < 4; ++i) {
            int moving_events = 0;
            const float moving = bounce_on_lift(speeds[i], (solver)which, &moving_events);
            print_message("solver %d at %g m/s: to %.3f m (still %.3f), %d events (%d)\n", which, (double)speeds[i],
                          (double)moving, (double)still, moving_events, events);
            check_near(moving, still, 2e-3);
            assert_int_equal(moving_events, events);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_share_of_the_speed_comes_back, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(the_restitution_of_a_rigid_body_can_change, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_body_bounces_off_what_lies, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_patch_bounces_off_a_lift_as_off_the_floor, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_cut_body_goes_on_bouncing, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(wrong_values_are_refused, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
