/* Sleep: what falls asleep, with whom, what wakes it, energy, snapshots, bad input. */

#include "all_calls.h"
#include "heavy_bodies.h"
#include "solver_choice.h"

#include <math.h>
#include <stdlib.h>

static const float dt = 1.0f / 60.0f, gravity = 10;

static pli_solver_settings damped(void) {
    pli_solver_settings settings = pli_body_def_default().solver;
    settings.position_iterations = 10;
    settings.velocity_damping = 0.05f;
    return settings;
}

/* A ground whose top is at the height 0. */
static pli_rigid* make_ground(void) {
    pli_shape* box = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(3, 1, 3), &box));
    return make_rigid(box, -1, 0);
}

static void move_body(pli_body* body, pli_vec3 by) {
    const pli_transform shift = {pli_transform_identity().rotation, by};
    CHECK_OK(pli_body_transform(body, shift));
}

/* A loose sheet at this height that may sleep. */
static pli_body* make_sleeper(float height, solver_choice which) {
    const pli_solver_settings settings = damped();
    pli_body* sheet = make_sheet(SHEET_LOOSE, &settings, true, false);
    use_solver(sheet, which);
    move_body(sheet, pli_vec3_make(0, height, 0));
    CHECK_OK(pli_body_enable_sleep(sheet, NULL));
    return sheet;
}

static void step(int frames) {
    for (int i = 0; i < frames; ++i) {
        CHECK_OK(pli_world_step(world, dt));
    }
}

/* The frame after which it sleeps; fails beyond `most`. */
static int step_until_asleep(const pli_body* body, int most) {
    for (int frame = 1; frame <= most; ++frame) {
        step(1);
        if (pli_body_is_asleep(body)) { return frame; }
    }
    fail_msg("awake after %d frames", most);
    return most;
}

static int count_events(pli_event_kind kind, const pli_body* body) {
    int count = 0, found = 0;
    const pli_event* events = pli_world_get_events(world, &count);
    for (int i = 0; i < count; ++i) {
        found += events[i].kind == kind && events[i].body == body;
    }
    return found;
}

/* J, kinetic and of gravity. */
static double energy_of(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    double sum = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i], v = view.velocities[i];
        const double mass = x.w > 0 ? 1.0 / (double)x.w : 0;
        sum += mass * ((double)gravity * (double)x.y + 0.5 * (double)(v.x * v.x + v.y * v.y + v.z * v.z));
    }
    return sum;
}

static void test_a_sheet_on_the_ground_falls_asleep(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_rigid* ground = make_ground();
        pli_body* sheet = make_sleeper(0.2f, (solver_choice)which);
        step(40); /* falls for 12 frames */
        const int frame = step_until_asleep(sheet, 180);
        print_message("solver %d: asleep %d frames after it fell\n", which, frame + 28);
        assert_int_equal(count_events(PLI_EVENT_BODY_ASLEEP, sheet), 1);
        const uint64_t hash = pli_body_state_hash(sheet);
        const double energy = energy_of(sheet);
        step(60);
        assert_int_equal(count_events(PLI_EVENT_BODY_ASLEEP, sheet), 0);
        assert_true(pli_body_state_hash(sheet) == hash);
        assert_true(pli_body_get_view(sheet).velocities[5].y == 0);

        CHECK_OK(pli_body_set_asleep(sheet, false));
        double most = energy;
        for (int i = 0; i < 20; ++i) {
            step(1);
            if (i == 0) { assert_int_equal(count_events(PLI_EVENT_BODY_AWAKE, sheet), 1); }
            most = fmax(most, energy_of(sheet));
        }
        assert_true(pli_body_state_hash(sheet) != hash);
        print_message("solver %d: %.6f J more after waking\n", which, most - energy);
        check_at_most(most - energy, 1e-5); /* J, of 2 J that the fall took */
        pli_body_destroy(sheet);
        pli_rigid_destroy(ground);
    }
}

/* A thing that falls, or swings on, is never taken for one that rests. */
static void test_what_moves_stays_awake(void** unused) {
    (void)unused;
    const pli_solver_settings settings = damped();
    pli_body* hanging = make_sheet(SHEET_CORNERS, &settings, false, false);
    CHECK_OK(pli_body_enable_sleep(hanging, NULL));
    pli_body* falling = make_sleeper(40, POSITION);
    for (int i = 0; i < 30; ++i) {
        step(1);
        assert_false(pli_body_is_asleep(falling));
        assert_false(pli_body_is_asleep(hanging));
    }
    CHECK_OK(pli_body_add_velocity(falling, pli_vec3_make(0, 15, 0)));
    for (int i = 0; i < 120; ++i) { /* up, and past the turning point */
        step(1);
        assert_false(pli_body_is_asleep(falling));
    }
}

typedef struct resting_pair {
    pli_rigid *ground, *box;
    pli_body* sheet;
} resting_pair;

/* A box of 0.5 kg lies on the sheet, both asleep. */
static resting_pair make_resting_pair(void) {
    resting_pair pair = {.ground = make_ground(), .sheet = make_sleeper(0.05f, COLORS)};
    pli_shape* box = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.3f, 0.1f, 0.3f), &box));
    pair.box = make_rigid(box, 0.2f, 0.5f);
    for (int i = 0; i < 400 && !pli_body_is_asleep(pair.sheet); ++i) {
        step(1);
        CHECK_OK(pli_rigid_integrate(pair.box, pli_vec3_make(0, -gravity, 0), dt));
    }
    assert_true(pli_body_is_asleep(pair.sheet));
    assert_true(pli_rigid_is_asleep(pair.box));
    return pair;
}

static void test_a_box_sleeps_on_a_sheet_and_wakes_with_it(void** unused) {
    (void)unused;
    const resting_pair pair = make_resting_pair();
    const float height = pli_rigid_get_state(pair.box).pose.origin.y;
    check_near(height, 0.1f + 2 * sheet_margin, 0.03f);
    for (int i = 0; i < 60; ++i) {
        step(1);
        CHECK_OK(pli_rigid_integrate(pair.box, pli_vec3_make(0, -gravity, 0), dt));
    }
    assert_true(pli_rigid_get_state(pair.box).pose.origin.y == height);
    assert_true(pli_rigid_get_state(pair.box).linear_velocity.y == 0);

    pli_rigid_state state = pli_rigid_get_state(pair.box);
    CHECK_OK(pli_rigid_set_state(pair.box, &state)); /* the same again */
    step(1);
    assert_true(pli_rigid_is_asleep(pair.box) && pli_body_is_asleep(pair.sheet));
    state.linear_velocity.x = 1;
    CHECK_OK(pli_rigid_set_state(pair.box, &state));
    step(1);
    assert_false(pli_rigid_is_asleep(pair.box) || pli_body_is_asleep(pair.sheet));
    for (int i = 0; i < 30; ++i) {
        CHECK_OK(pli_rigid_integrate(pair.box, pli_vec3_make(0, -gravity, 0), dt));
        step(1);
    }
    check_near(pli_rigid_get_state(pair.box).pose.origin.y, height, 0.03f);
}

static void force_a_node(resting_pair* pair) {
    CHECK_OK(pli_body_add_node_force(pair->sheet, 0, pli_vec3_make(0, 1, 0)));
}
static void change_gravity(resting_pair* pair) {
    (void)pair;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, -5, 0)));
}
static void take_the_ground(resting_pair* pair) {
    pli_rigid_destroy(pair->ground);
    pair->ground = NULL;
}
static void move_the_ground(resting_pair* pair) {
    pli_rigid_state state = pli_rigid_get_state(pair->ground);
    state.pose.origin.y -= 50;
    CHECK_OK(pli_rigid_set_state(pair->ground, &state));
}
static void take_the_ground_out(resting_pair* pair) {
    CHECK_OK(pli_rigid_set_present(pair->ground, false));
}
static void smooth_the_ground(resting_pair* pair) {
    CHECK_OK(pli_rigid_set_friction(pair->ground, 0));
}
static void load_the_box(resting_pair* pair) {
    pli_rigid_state state = pli_rigid_get_state(pair->box);
    state.inverse_mass *= 0.01f;
    CHECK_OK(pli_rigid_set_state(pair->box, &state));
}
static void take_the_box(resting_pair* pair) {
    pli_rigid_destroy(pair->box);
    pair->box = NULL;
}
/* It meets the sheet in this step. */
static void throw_a_ball(resting_pair* pair) {
    (void)pair;
    pli_rigid* ball = make_ball(0.5f, 1);
    pli_rigid_state state = pli_rigid_get_state(ball);
    state.pose.origin.x = 0.7f;
    state.linear_velocity.y = -20;
    CHECK_OK(pli_rigid_set_state(ball, &state));
}
static void push_with_a_platform(resting_pair* pair) {
    (void)pair;
    pli_rigid* platform = make_ball(0.2f, 1);
    pli_rigid_state state = pli_rigid_get_state(platform);
    state.pose.origin.x = 1.4f;
    state.linear_velocity.x = -10;
    CHECK_OK(pli_rigid_set_kind(platform, PLI_RIGID_KINEMATIC, &state));
}

static void take_the_sheet(resting_pair* pair) {
    pli_body_destroy(pair->sheet);
    pair->sheet = NULL;
}
/* It meets the box in this step; the two sheets do not collide. */
static void drop_a_sheet_on_the_box(resting_pair* pair) {
    (void)pair;
    CHECK_OK(pli_body_add_velocity(make_sleeper(0.4f, POSITION), pli_vec3_make(0, -20, 0)));
}

static void test_what_wakes_a_body(void** unused) {
    (void)unused;
    void (*const wakes[])(resting_pair * pair) = {force_a_node,    change_gravity,          take_the_ground,
                                                  move_the_ground, take_the_ground_out,     take_the_box,
                                                  throw_a_ball,    push_with_a_platform,    smooth_the_ground,
                                                  load_the_box,    drop_a_sheet_on_the_box, take_the_sheet};
    for (size_t i = 0; i < sizeof wakes / sizeof *wakes; ++i) {
        resting_pair pair = make_resting_pair();
        wakes[i](&pair);
        step(1);
        if (pair.box != NULL) { assert_false(pli_rigid_is_asleep(pair.box)); }
        if (pair.sheet != NULL) {
            assert_false(pli_body_is_asleep(pair.sheet));
            assert_int_equal(count_events(PLI_EVENT_BODY_AWAKE, pair.sheet), 1);
        }
        pli_world_destroy(world);
        CHECK_OK(pli_world_create(context, NULL, &world));
    }
}

/* The bounds of what lies a margin above a ground touch it up to rounding. */
static void test_a_sheet_falls_when_its_ground_goes(void** unused) {
    (void)unused;
    for (int way = 0; way < 3; ++way) {
        pli_rigid* ground = make_ground();
        pli_body* sheet = make_sleeper(0, POSITION);
        move_body(sheet, pli_vec3_make(0, -pli_body_get_bounds(sheet).min.y, 0));
        (void)step_until_asleep(sheet, 300);
        const float height = pli_body_get_bounds(sheet).max.y;
        if (way == 0) { CHECK_OK(pli_rigid_set_present(ground, false)); }
        if (way == 1) { CHECK_OK(pli_rigid_set_sensor(ground, true)); }
        if (way == 2) { pli_rigid_destroy(ground); }
        step(30);
        assert_false(pli_body_is_asleep(sheet));
        assert_true(pli_body_get_bounds(sheet).max.y < height - 0.3f);
        pli_body_destroy(sheet);
        if (way < 2) { pli_rigid_destroy(ground); }
    }
}

/* What a game sets in every frame wakes when it becomes another. */
static void test_the_same_wind_and_targets_wake_nobody(void** unused) {
    (void)unused;
    (void)make_ground();
    pli_body* sheet = make_sleeper(0.05f, COLORS);
    const pli_aero_def aero = pli_aero_def_default();
    CHECK_OK(pli_body_enable_aero(sheet, &aero));
    const pli_target corner = {.node = 0, .max_distance = 0.1f};
    pli_vec3 place = pli_vec3_make(-1, sheet_margin, -1);
    pli_targets_def targets = pli_targets_def_default();
    targets.targets = &corner;
    targets.positions = &place;
    targets.count = 1;
    CHECK_OK(pli_body_enable_targets(sheet, &targets));
    for (int i = 0; i < 240; ++i) {
        CHECK_OK(pli_body_set_wind(sheet, pli_vec3_make(0, 0, 0)));
        CHECK_OK(pli_body_move_targets(sheet, &place, NULL, 1));
        step(1);
    }
    assert_true(pli_body_is_asleep(sheet));
    place.x -= 0.2f;
    CHECK_OK(pli_body_move_targets(sheet, &place, NULL, 1));
    step(1);
    assert_false(pli_body_is_asleep(sheet));
    (void)step_until_asleep(sheet, 300);
    CHECK_OK(pli_body_set_wind(sheet, pli_vec3_make(0, 1, 0)));
    step(1);
    assert_false(pli_body_is_asleep(sheet));
}

/* A platform beside what sleeps, turned, in each of the ways to say where it is. */
static void test_a_platform_that_stays_wakes_nobody(void** unused) {
    (void)unused;
    for (int way = 0; way < 4; ++way) {
        const resting_pair pair = make_resting_pair();
        pli_rigid* platform = make_ball(0.3f, 1);
        pli_rigid_state state = pli_rigid_get_state(platform);
        state.pose = pli_transform_make(pli_quat_from_yaw_pitch_roll(2.0f, -0.5f, 1.0f), pli_vec3_make(0.8f, 0.1f, 0));
        CHECK_OK(pli_rigid_set_kind(platform, PLI_RIGID_KINEMATIC, &state));
        step(1);
        (void)step_until_asleep(pair.sheet, 900);
        for (int i = 0; i < 60; ++i) {
            if (way == 1) { CHECK_OK(pli_rigid_set_state(platform, &state)); }
            if (way == 2) { CHECK_OK(pli_rigid_move(platform, state.pose, dt)); }
            if (way == 3) { CHECK_OK(pli_rigid_set_kind(platform, PLI_RIGID_KINEMATIC, &state)); }
            step(1);
            assert_true(pli_body_is_asleep(pair.sheet));
        }
        pli_world_destroy(world);
        CHECK_OK(pli_world_create(context, NULL, &world));
    }
}

/* At once, beside things that were there before. */
static void test_a_body_is_put_to_sleep_by_hand(void** unused) {
    (void)unused;
    (void)make_ground();
    pli_body* sheet = make_sleeper(0.3f, POSITION);
    step(5);
    const float height = pli_body_get_view(sheet).positions[0].y;
    CHECK_OK(pli_body_set_asleep(sheet, true));
    step(10);
    assert_true(pli_body_is_asleep(sheet));
    assert_true(pli_body_get_view(sheet).positions[0].y == height); /* in the air, as it was told */
    CHECK_OK(pli_body_set_asleep(sheet, false));
    step(1);
    assert_true(pli_body_get_view(sheet).positions[0].y < height);
}

/* A weight without shapes at the end of a rope. */
static void test_what_touches_nothing_rests_too(void** unused) {
    (void)unused;
    pli_body_def def = pli_body_def_default();
    def.solver = damped();
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    pli_rigid* weight = NULL;
    const pli_vec3 from = pli_vec3_make(0, 1, 0), to = pli_vec3_make(0, 0, 0);
    CHECK_OK(pli_mesh_create_rope(context, from, to, 3, PLI_ROPE_PIN_FIRST, &mesh));
    CHECK_OK(pli_body_create(world, mesh, &def, &rope));
    pli_mesh_destroy(mesh);
    pli_rigid_def made = pli_rigid_def_default();
    made.kind = PLI_RIGID_DYNAMIC;
    made.state.inverse_mass = 1;
    made.state.inverse_inertia_world = pli_mat3_identity();
    CHECK_OK(pli_rigid_create(world, &made, &weight));
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.node = 4;
    anchor.rigid = weight;
    CHECK_OK(pli_body_add_anchor(rope, &anchor, NULL));
    CHECK_OK(pli_body_enable_sleep(rope, NULL));
    for (int i = 0; i < 600 && !pli_body_is_asleep(rope); ++i) {
        step(1);
        CHECK_OK(pli_rigid_integrate(weight, pli_vec3_make(0, -gravity, 0), dt));
    }
    assert_true(pli_body_is_asleep(rope));
    assert_true(pli_rigid_is_asleep(weight));
}

/* What falls does not rest when sleep is enabled, for hosts that ask at once. */
static void test_nothing_rests_before_its_time(void** unused) {
    (void)unused;
    pli_body* sheet = make_sleeper(1, POSITION);
    assert_false(pli_body_is_resting(sheet));
    step(1);
    assert_false(pli_body_is_resting(sheet));
}

/* Two sheets apart under one box: the one that may not sleep keeps the other one awake. */
static void test_a_box_passes_on_who_is_awake(void** unused) {
    (void)unused;
    (void)make_ground();
    pli_body* left = make_sleeper(0.05f, COLORS);
    pli_body* right = make_sleeper(0.05f, COLORS);
    move_body(left, pli_vec3_make(-1.1f, 0, 0));
    move_body(right, pli_vec3_make(1.1f, 0, 0));
    CHECK_OK(pli_body_disable_sleep(right));
    pli_shape* box = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.6f, 0.1f, 0.3f), &box));
    pli_rigid* bridge = make_rigid(box, 0.2f, 0.5f);
    for (int i = 0; i < 400; ++i) {
        step(1);
        CHECK_OK(pli_rigid_integrate(bridge, pli_vec3_make(0, -gravity, 0), dt));
        assert_false(pli_body_is_asleep(left) || pli_rigid_is_asleep(bridge));
    }
    CHECK_OK(pli_body_enable_sleep(right, NULL));
    for (int i = 0; i < 200; ++i) {
        step(1);
        CHECK_OK(pli_rigid_integrate(bridge, pli_vec3_make(0, -gravity, 0), dt));
    }
    assert_true(pli_body_is_asleep(left) && pli_body_is_asleep(right) && pli_rigid_is_asleep(bridge));
}

/* Nor one that has just been made: it was nowhere before, and not at the origin, where the rope sleeps. */
static void test_a_rigid_body_made_far_away_wakes_nothing(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    CHECK_OK(pli_mesh_create_rope(context, pli_vec3_make(-1, -1, 0), pli_vec3_make(1, 1, 0), 5, 3, &mesh));
    CHECK_OK(pli_body_create(world, mesh, NULL, &rope));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_rigid_contacts(rope, NULL));
    CHECK_OK(pli_body_enable_sleep(rope, NULL));
    step(1);
    for (int i = 0; i < 2; ++i) {
        CHECK_OK(pli_body_set_asleep(rope, true));
        (void)make_ball(i == 0 ? 30.0f : 0.0f, 1);
        step(1);
        assert_true(pli_body_is_asleep(rope) == (i == 0)); /* the other one is made in its bounds */
    }
}

static void test_a_ball_far_away_wakes_nothing(void** unused) {
    (void)unused;
    const resting_pair pair = make_resting_pair();
    pli_rigid* ball = make_ball(3, 1);
    for (int i = 0; i < 30; ++i) {
        step(1);
        CHECK_OK(pli_rigid_integrate(ball, pli_vec3_make(0, 0, 0), dt));
    }
    assert_true(pli_body_is_asleep(pair.sheet));
}

/* A body that falls on a sleeper has its contacts in the step in which it comes. */
static void test_a_falling_body_wakes_what_it_meets(void** unused) {
    (void)unused;
    (void)make_ground();
    pli_body* lower = make_sleeper(0.1f, COLORS);
    const pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    CHECK_OK(pli_body_enable_soft_contacts(lower, &contacts));
    (void)step_until_asleep(lower, 240);
    pli_body* upper = make_sleeper(0.5f, COLORS);
    CHECK_OK(pli_body_enable_soft_contacts(upper, &contacts));
    int woken_at = 0, asleep_at = 0;
    for (int frame = 1; frame <= 400 && asleep_at == 0; ++frame) {
        step(1);
        if (woken_at == 0 && !pli_body_is_asleep(lower)) { woken_at = frame; }
        assert_true(woken_at == 0 || pli_body_is_asleep(lower) == pli_body_is_asleep(upper)); /* both or none */
        if (woken_at > 0 && pli_body_is_asleep(upper)) { asleep_at = frame; }
    }
    const float above = pli_body_get_view(upper).positions[SHEET_NODES / 2].y;
    print_message("woken in frame %d, both asleep in frame %d, upper sheet at %.3f m\n", woken_at, asleep_at,
                  (double)above);
    check_near(woken_at, 20, 3); /* 0.4 m of fall, in air */
    assert_true(asleep_at > 0);
    assert_true(above > pli_body_get_view(lower).positions[SHEET_NODES / 2].y + 0.01f);
    CHECK_OK(pli_body_set_asleep(lower, false));
    step(1);
    assert_false(pli_body_is_asleep(upper));
}

static void test_a_body_without_sleep_keeps_others_awake(void** unused) {
    (void)unused;
    (void)make_ground();
    pli_body* lower = make_sleeper(0.03f, COLORS);
    pli_body* upper = make_sleeper(0.1f, COLORS);
    const pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    CHECK_OK(pli_body_enable_soft_contacts(lower, &contacts));
    CHECK_OK(pli_body_enable_soft_contacts(upper, &contacts));
    CHECK_OK(pli_body_disable_sleep(upper));
    for (int i = 0; i < 300; ++i) {
        step(1);
        assert_false(pli_body_is_asleep(lower));
    }
    CHECK_OK(pli_body_enable_sleep(upper, NULL));
    (void)step_until_asleep(lower, 300);
    assert_true(pli_body_is_asleep(upper));
    pli_body_destroy(upper);
    step(1);
    assert_false(pli_body_is_asleep(lower));
}

/* Saved awake, asleep and back: the same frames again. */
static void test_snapshots_know_who_sleeps(void** unused) {
    (void)unused;
    (void)make_ground();
    pli_body* sheet = make_sleeper(0.1f, XPBD);
    step(30);
    const size_t size = pli_world_snapshot_size(world);
    void* before = malloc(size);
    void* asleep = malloc(size);
    uint64_t hashes[240];
    bool states[240];
    assert_true(before != NULL && asleep != NULL);
    CHECK_OK(pli_world_save(world, before, size, NULL));
    for (int i = 0; i < 240; ++i) {
        step(1);
        hashes[i] = pli_body_state_hash(sheet);
        states[i] = pli_body_is_asleep(sheet);
    }
    assert_true(states[239] && !states[0]);
    CHECK_OK(pli_world_save(world, asleep, size, NULL));
    assert_true(pli_body_is_asleep(sheet)); /* to save wakes nobody */
    CHECK_OK(pli_world_restore(world, before, size));
    assert_false(pli_body_is_asleep(sheet));
    for (int i = 0; i < 240; ++i) {
        step(1);
        assert_true(hashes[i] == pli_body_state_hash(sheet) && states[i] == pli_body_is_asleep(sheet));
    }
    CHECK_OK(pli_body_add_velocity(sheet, pli_vec3_make(0, 1, 0)));
    step(1);
    CHECK_OK(pli_world_restore(world, asleep, size));
    step(1);
    assert_true(pli_body_is_asleep(sheet) && pli_body_state_hash(sheet) == hashes[239]);
    free(before);
    free(asleep);
}

static void test_bad_input_is_refused(void** unused) {
    (void)unused;
    const pli_solver_settings settings = damped();
    pli_body* sheet = make_sheet(SHEET_LOOSE, &settings, false, false);
    check_refused(pli_body_set_asleep(sheet, true), PLI_ERROR_WRONG_STATE, "no sleep enabled");
    pli_sleep_def def = pli_sleep_def_default();
    def.time = 0;
    check_refused(pli_body_enable_sleep(sheet, &def), PLI_ERROR_INVALID_VALUE, "time");
    def = pli_sleep_def_default();
    def.speed = NAN;
    check_refused(pli_body_enable_sleep(sheet, &def), PLI_ERROR_NOT_FINITE, "speed");
    CHECK_OK(pli_body_enable_sleep(sheet, NULL));
    CHECK_OK(pli_body_set_asleep(sheet, true));
    assert_true(pli_body_is_asleep(sheet));
    CHECK_OK(pli_world_predict(world, dt));
    check_refused(pli_body_set_asleep(sheet, false), PLI_ERROR_WRONG_STATE, "between predict and solve");
    CHECK_OK(pli_body_add_force(sheet, pli_vec3_make(0, 1, 0))); /* wakes it in the step to come, not in this one */
    const uint64_t hash = pli_body_state_hash(sheet);
    CHECK_OK(pli_world_solve(world));
    assert_true(pli_body_state_hash(sheet) == hash);
    step(1);
    assert_true(pli_body_state_hash(sheet) != hash);
    CHECK_OK(pli_body_disable_sleep(sheet));
    assert_false(pli_body_is_asleep(sheet));
}

/* In steps on, too. */
static void check_sleeps(pli_body* body, const char* call) {
    if (!pli_body_is_asleep(body)) { fail_msg("%s woke it", call); }
    step(1);
    assert_true(pli_body_is_asleep(body));
}

static pli_body* make_body_put_to_sleep(void) {
    const pli_solver_settings settings = damped();
    pli_body* body = make_sheet(SHEET_LOOSE, &settings, true, false);
    CHECK_OK(pli_body_enable_sleep(body, NULL));
    step(1);
    CHECK_OK(pli_body_set_asleep(body, true));
    return body;
}

/* Of a body on which little is enabled some calls are refused; all that change it wake it. */
static void test_calls_wake_where_they_change_something(void** unused) {
    (void)unused;
    pli_rigid* ground = make_ground();
    int refused = 0, done = 0;
    for (int i = 0; i < CALL_COUNT; ++i) {
        const call_row* row = &call_rows[i];
        const bool is_about_other_things = strstr(row->name, "sleep") != NULL || strstr(row->name, "destroy") != NULL ||
                                           strstr(row->name, "save") != NULL || strstr(row->name, "world") != NULL;
        if (row->kind != CALL_BODY || row->effect == CALL_READS || is_about_other_things) { continue; }
        pli_body* body = make_body_put_to_sleep();
        const call_handles handles = {.context = context,
                                      .world = world,
                                      .body = body,
                                      .other = body,
                                      .rigid = ground,
                                      .solver = pli_body_get_solver_settings(body)};
        /* What is not there, or what all_calls.h does not count as an error. */
        const bool may_do_nothing = strstr(row->name, "_disable_") != NULL || strstr(row->name, "restore") != NULL ||
                                    strstr(row->name, "move_node") != NULL || strstr(row->name, "targets") != NULL;
        if (row->run(&handles).status != PLI_OK) {
            check_sleeps(body, row->name);
            refused += 1;
        } else if (!may_do_nothing) {
            if (pli_body_is_asleep(body)) { fail_msg("%s left it asleep", row->name); }
            done += 1;
        }
        pli_body_destroy(body);
    }
    print_message("%d calls refused, %d done\n", refused, done);
    assert_int_equal(refused, 20);
    assert_in_range(done, 45, 60);
    pli_rigid_destroy(ground);
}

static void test_wrong_numbers_wake_nobody(void** unused) {
    (void)unused;
    pli_body* body = make_body_put_to_sleep();
    const pli_vec3 nowhere = {NAN, 0, 0};
    const int twice[2] = {3, 3};
    assert_int_equal(pli_body_add_force(body, nowhere), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_body_add_velocity(body, nowhere), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_body_set_node_mass(body, 0, -1), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_set_rest_length(body, -1, 1), PLI_ERROR_INDEX_OUT_OF_RANGE);
    assert_int_equal(pli_body_cut_link(body, 0, 0, 0.5f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_add_cluster(body, twice, 2, NULL), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_add_anchor(body, NULL, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_enable_pressure(body, NAN), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_body_set_update_interval(body, 0), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_disable_tethers(body), PLI_OK); /* there are none */
    check_sleeps(body, "a wrong number");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_sheet_on_the_ground_falls_asleep, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_what_moves_stays_awake, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_box_sleeps_on_a_sheet_and_wakes_with_it, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_what_wakes_a_body, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_sheet_falls_when_its_ground_goes, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_the_same_wind_and_targets_wake_nobody, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_platform_that_stays_wakes_nobody, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_body_is_put_to_sleep_by_hand, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_what_touches_nothing_rests_too, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_nothing_rests_before_its_time, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_box_passes_on_who_is_awake, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_rigid_body_made_far_away_wakes_nothing, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_ball_far_away_wakes_nothing, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_falling_body_wakes_what_it_meets, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_body_without_sleep_keeps_others_awake, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_snapshots_know_who_sleeps, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_input_is_refused, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_calls_wake_where_they_change_something, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_wrong_numbers_wake_nobody, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
