// The group `heavy` of the stability map: what its checks let pass and what they do not, on motions made up here and in
// short runs.

#include "engines/pliant_engine.h"
#include "measure/stability/heavy_checks.h"
#include "measure/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "check.h"

using demos::Cell;
using demos::Check;
using demos::CheckedBodies;
using demos::CheckedState;
using demos::CheckPointer;
using demos::Column;
using demos::Engine;
using demos::Finding;
using demos::SoftState;
using demos::StabilityCase;
using demos::StabilityOptions;
using demos::Verdict;

static constexpr double step_seconds = 1.0 / 60;
static constexpr float radius = 0.3f;

// A ball of 1 kg, and soft bodies of one link with or without stiffness.
static CheckedBodies bodies_of(double link_stiffness) {
    CheckedBodies bodies;
    bodies.step_seconds = step_seconds;
    demos::CheckedRigid ball;
    ball.mass = 1;
    ball.inertia = pli_vec3_make(0.036f, 0.036f, 0.036f);
    ball.half_extents = pli_vec3_make(radius, radius, radius);
    bodies.rigids.push_back(ball);
    bodies.link_stiffness.push_back(link_stiffness);
    return bodies;
}

// The ball at a height with a speed upwards, and a link of 1 m at the height of a cloth, one end pinned.
static CheckedState state_of(float height, float speed, float cloth_height, float link_length) {
    CheckedState state;
    demos::RigidState ball{};
    ball.pose = pli_transform_identity();
    ball.pose.origin = pli_vec3_make(0, height, 0);
    ball.linear_velocity = pli_vec3_make(0, speed, 0);
    state.rigids.push_back(ball);
    SoftState soft;
    soft.positions = {pli_vec3_make(-0.1f, cloth_height, 0), pli_vec3_make(link_length - 0.1f, cloth_height, 0)};
    soft.velocities.assign(2, pli_vec3_make(0, 0, 0));
    soft.inverse_masses = {0, 100};
    soft.link_nodes = {0, 1};
    soft.rest_lengths = {1};
    state.softs.push_back(soft);
    return state;
}

static Finding finding_of(Check& check, const std::vector<CheckedState>& states) {
    check.start(states.front());
    for (size_t i = 1; i < states.size(); ++i) {
        check.after_step({states[i - 1], states[i], static_cast<double>(i) * step_seconds});
    }
    return check.finding();
}

// Falls freely for a number of steps, and then moves on with `rebound` times its velocity turned upwards.
static std::vector<CheckedState> bounce(float rebound) {
    std::vector<CheckedState> states{state_of(1, 0, 0, 1)};
    float height = 1, speed = 0;
    for (int step = 1; step <= 40; ++step) {
        if (step == 21) { speed *= -rebound; }
        speed -= 10 * static_cast<float>(step_seconds);
        height += speed * static_cast<float>(step_seconds);
        states.push_back(state_of(height, speed, 0, 1));
    }
    return states;
}

static void energy_may_not_grow(void**) {
    assert_true(finding_of(*demos::check_energy(bodies_of(0)), bounce(1)).verdict == Verdict::survives);
    const Finding gain = finding_of(*demos::check_energy(bodies_of(0)), bounce(1.1f));
    assert_true(gain.verdict == Verdict::gains_energy);
    assert_non_null(std::strstr(gain.note.c_str(), "gravity did"));
    // A ball that begins to spin, as fast as its fall cannot make it.
    std::vector<CheckedState> spins = bounce(1);
    spins.back().rigids[0].angular_velocity = pli_vec3_make(0, 0, 10);
    assert_true(finding_of(*demos::check_energy(bodies_of(0)), spins).verdict == Verdict::gains_energy);
    // A link of 100 N/m that nothing stretches, for a solver that knows its stiffness and for one that does not.
    std::vector<CheckedState> slowly{state_of(1, 0, 0, 1)};
    for (int i = 1; i <= 100; ++i) {
        slowly.push_back(state_of(1, 0, 0, 1 + 0.002f * static_cast<float>(i)));
    }
    const Finding springs = finding_of(*demos::check_energy(bodies_of(100)), slowly);
    assert_true(springs.verdict == Verdict::gains_energy);
    assert_non_null(std::strstr(springs.note.c_str(), "springs 1.98 J")); // of the middle of the last step
    assert_true(finding_of(*demos::check_energy(bodies_of(0)), slowly).verdict == Verdict::survives);
    // Substeps of 10 ms at a node of 10 g: 1/100 + 100 * 0.01^2 m/N.
    CheckedBodies substepped = bodies_of(100);
    substepped.substep_seconds = 0.01;
    assert_non_null(std::strstr(finding_of(*demos::check_energy(substepped), slowly).note.c_str(), "springs 0.99 J"));
}

// J, of two free nodes that a stretched link pulls together in substeps of `h`.
static double most_motion_of_link(float stiffness, float mass, float stretch, float h) {
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_mesh* mesh = nullptr;
    pli_body* body = nullptr;
    pli_world_def def = pli_world_def_default();
    def.gravity = pli_vec3_make(0, 0, 0);
    assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
    assert_int_equal(pli_world_create(context, &def, &world), PLI_OK);
    pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 0, 0, &mesh);
    pli_mesh_set_total_mass(mesh, 2 * mass);
    assert_int_equal(pli_body_create(world, mesh, nullptr, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_xpbd_def solver = pli_xpbd_def_default();
    solver.substeps = 1;
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = 1 / stiffness;
    pli_body_enable_xpbd(body, &solver);
    pli_body_enable_xpbd_links(body, &links);
    assert_int_equal(pli_body_set_node_position(body, 1, pli_vec3_make(1 + stretch, 0, 0)), PLI_OK);
    double most = 0;
    for (int step = 0; step < 1000; ++step) {
        pli_world_step(world, h);
        const pli_vec4* v = pli_body_get_view(body).velocities;
        most = std::max(most, 0.5 * static_cast<double>(mass * (v[0].x * v[0].x + v[1].x * v[1].x)));
    }
    pli_world_destroy(world);
    pli_context_destroy(context);
    return most;
}

// Why links of XPBD do not count with the stiffness that they should have.
static void stretched_links_give_back_what_is_counted(void**) {
    constexpr float mass = 0.01f, stretch = 0.1f;
    for (const float stiffness : {1e2f, 1e4f, 1e6f}) {
        for (const int substeps : {1, 10, 100}) {
            const float h = static_cast<float>(step_seconds) / static_cast<float>(substeps);
            const double counted = static_cast<double>(0.5f * stretch * stretch / (1 / stiffness + 2 / mass * h * h));
            const double share = most_motion_of_link(stiffness, mass, stretch, h) / counted;
            if (!(share > 0.3 && share < 1.001)) {
                fail_msg("%g N/m, %d: %g", static_cast<double>(stiffness), substeps, share);
            }
        }
    }
}

static void balls_may_not_rise_or_pass(void**) {
    assert_true(finding_of(*demos::check_height(0), bounce(1)).verdict == Verdict::survives);
    const Finding rise = finding_of(*demos::check_height(0), {state_of(1, 0, 0, 1), state_of(1.01f, 0, 0, 1)});
    assert_true(rise.verdict == Verdict::gains_energy);
    const auto passage = [](float height, float cloth_height) {
        const CheckPointer check = demos::check_passage(bodies_of(0), 0);
        const Verdict verdict =
            finding_of(*check, {state_of(1, 0, 0, 1), state_of(height, 0, cloth_height, 1)}).verdict;
        assert_true(check->is_decided() == (verdict == Verdict::passes_through));
        return verdict;
    };
    assert_true(passage(0.3f, 0) == Verdict::survives);
    assert_true(passage(0.25f, 0) == Verdict::survives); // nodes are 4 cm inside
    assert_true(passage(0.1f, 0) == Verdict::passes_through);
    assert_true(passage(-0.5f, 0) == Verdict::passes_through);
    assert_true(finding_of(*demos::check_reach(5), {state_of(1, 0, 0, 1), state_of(-3.9f, 0, 0, 1)}).verdict ==
                Verdict::survives);
    assert_true(finding_of(*demos::check_reach(5), {state_of(1, 0, 0, 1), state_of(-4.1f, 0, 0, 1)}).verdict ==
                Verdict::out_of_reach);
}

// Steady for two seconds; in the last one the ball creeps upwards and the node sideways, m per step.
static std::vector<CheckedState> creep(float ball, float node) {
    std::vector<CheckedState> states{state_of(1, 0, 0, 1)};
    for (int step = 1; step <= 120; ++step) {
        const auto way = static_cast<float>(std::max(step - 60, 0));
        states.push_back(state_of(1 + ball * way, 0, 0, 1 + node * way));
    }
    return states;
}

static void what_lies_stays(void**) {
    const CheckedBodies bodies = bodies_of(0);
    assert_true(finding_of(*demos::check_rest(bodies, 2), creep(0, 0)).verdict == Verdict::survives);
    assert_true(finding_of(*demos::check_rest(bodies, 2), creep(1e-5f, 0)).verdict == Verdict::survives);
    const Finding ball = finding_of(*demos::check_rest(bodies, 2), creep(1e-4f, 0));
    assert_true(ball.verdict == Verdict::never_rests && ball.note == "moves at 0.006 m/s");
    assert_true(finding_of(*demos::check_rest(bodies, 2), creep(0, 1e-4f)).verdict == Verdict::never_rests);

    demos::Lasting what;
    what.rigid = 0;
    Finding place = finding_of(*demos::check_place(what, 0.5), creep(1e-4f, 0));
    assert_true(place.verdict == Verdict::survives);
    check_near(place.figure, 6, 0.01); // mm
    place = finding_of(*demos::check_place(what, 0.5), creep(2e-4f, 0));
    assert_true(place.verdict == Verdict::wanders);
    check_near(place.figure, 12, 0.01);
    what.rigid = -1;
    what.soft = 0; // whose centre makes half the way of the node
    place = finding_of(*demos::check_place(what, 0.5), creep(0, 2e-4f));
    assert_true(place.verdict == Verdict::survives);
    check_near(place.figure, 6, 0.01);
    check_near(finding_of(*demos::measure_stretch(0), creep(0, 1e-3f)).figure, 6, 0.01); // %
}

// A body that makes a quarter turn in a step, and a node that follows it or stays behind.
static void anchored_nodes_do_not_lag(void**) {
    demos::AnchorRecord anchor{};
    anchor.node = 1;
    CheckedState start = state_of(1, 0, 1, 1), end = start;
    end.rigids[0].pose.rotation.rows[0] = pli_vec3_make(0, 0, 1);
    end.rigids[0].pose.rotation.rows[2] = pli_vec3_make(-1, 0, 0);
    end.softs[0].positions[1] = pli_vec3_make(0, 1.0005f, -0.9f);
    const Finding follows = finding_of(*demos::check_anchors({anchor}), {start, end});
    assert_true(follows.verdict == Verdict::survives);
    check_near(follows.figure, 0.5, 1e-3); // mm
    end.softs[0].positions[1] = start.softs[0].positions[1];
    const Finding lags = finding_of(*demos::check_anchors({anchor}), {start, end});
    assert_true(lags.verdict == Verdict::lags && lags.figure > 1000);
}

static void findings_are_summed_up(void**) {
    std::vector<CheckPointer> checks;
    checks.push_back(demos::check_height(0));
    checks.push_back(demos::check_rest(bodies_of(0), 2));
    checks.push_back(demos::measure_stretch(0));
    const std::vector<CheckedState> states = creep(1e-4f, 0);
    for (const CheckPointer& check : checks) {
        finding_of(*check, states);
    }
    const Finding sum = demos::sum_up(checks);
    assert_true(sum.verdict == Verdict::gains_energy);
    assert_non_null(std::strstr(sum.note.c_str(), "rises 0.006 m above its start, moves at"));
    check_near(sum.figure, 0, 1e-9);
}

// ------------------------------------------------------------------------------------------------------ the group

static std::vector<StabilityCase> heavy_cases(int rest_steps) {
    StabilityOptions options;
    options.rest_steps = rest_steps;
    std::vector<StabilityCase> cases = demos::stability_cases(options);
    cases.erase(std::remove_if(cases.begin(), cases.end(), [](const auto& each) { return each.group != "heavy"; }),
                cases.end());
    return cases;
}

static StabilityCase heavy_case(const std::string& name, int rest_steps) {
    for (const StabilityCase& each : heavy_cases(rest_steps)) {
        if (each.name == name) { return each; }
    }
    fail_msg("no case %s", name.c_str());
    return {};
}

static void the_group_is_large_and_run_by_name(void**) {
    const std::vector<StabilityCase> cases = heavy_cases(20000);
    assert_true(4 * cases.size() >= 100);
    for (const StabilityCase& each : cases) {
        assert_true(each.is_asked_for_only && !each.has_loose_energy_rule && each.watch);
    }
    for (const StabilityCase& each : demos::stability_cases({})) {
        assert_true(each.is_asked_for_only == (each.group == "heavy" || each.group == "random"));
    }
}

static void cells_of_the_group_are_judged(void**) {
    StabilityCase ball = heavy_case("ball of 1 kg, rim, nodes, 1/60 s", 20000);
    const Cell rests = demos::run_cell(ball, Column::gradients, {});
    if (rests.verdict != Verdict::survives) { fail_msg("%s", rests.note.c_str()); }
    assert_true(rests.figure > 0.1 && rests.figure < 10.0); // %
    const auto prepare = ball.prepare;
    ball.prepare = [prepare](Engine& engine) {
        prepare(engine);
        pli_body_disable_rigid_contacts(static_cast<demos::PliantEngine&>(engine).body(0));
    };
    const Cell sinks = demos::run_cell(ball, Column::gradients, {});
    assert_true(sinks.verdict == Verdict::passes_through);
    // A trampoline whose ball flies up.
    StabilityCase trampoline = heavy_case("trampoline, ball of 5 kg, nodes", 20000);
    trampoline.seconds = 0.1f;
    assert_true(demos::run_cell(trampoline, Column::position_based, {}).verdict == Verdict::survives);
    trampoline.prepare = [](Engine& engine) { engine.rigids().body(0)->setLinearVelocity(btVector3(0, 3, 0)); };
    const Cell rises = demos::run_cell(trampoline, Column::position_based, {});
    assert_true(rises.verdict == Verdict::gains_energy);
    assert_non_null(std::strstr(rises.note.c_str(), "above its start"));
    // Shortened boxes still say how far they have moved since 5 s.
    const StabilityCase box = heavy_case("box on cloth, nodes, start 1", 330);
    check_near(box.seconds, 5.5, 1e-4);
    const Cell wanders = demos::run_cell(box, Column::position_based, {});
    assert_true(wanders.verdict != Verdict::crashes && wanders.figure >= 0.0);
}

static Cell heavy_cell(const char* name, Column column) {
    return demos::run_cell(heavy_case(name, 1200), column, {});
}

// Whatever the ratio of masses: a body is held by what holds the nodes that it presses on.
static void xpbd_carries_heavy_bodies(void**) {
    const char* const names[] = {"ball of 100 kg, corners, nodes, 1/60 s",
                                 "ball of 1000 kg, rim, nodes, 1/60 s",
                                 "ball of 1000 kg, hammock, nodes, 1/120 s",
                                 "ball of 1000 kg, floor, nodes, 1/30 s",
                                 "ball of 100 kg, hammock, nodes and faces, 1/60 s",
                                 "ball of 1000 kg, corners, nodes and faces, 1/60 s",
                                 "trampoline, ball of 100 kg, nodes",
                                 "box on cloth, nodes, start 1",
                                 "rope with a weight, masses 1 : 10"};
    for (const char* name : names) {
        const Cell cell = heavy_cell(name, Column::xpbd);
        if (cell.verdict != Verdict::survives) { fail_msg("%s: %s", name, cell.note.c_str()); }
        check_at_most(cell.figure, 12); // %, or mm
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_may_not_grow),
        cmocka_unit_test(stretched_links_give_back_what_is_counted),
        cmocka_unit_test(balls_may_not_rise_or_pass),
        cmocka_unit_test(what_lies_stays),
        cmocka_unit_test(anchored_nodes_do_not_lag),
        cmocka_unit_test(findings_are_summed_up),
        cmocka_unit_test(the_group_is_large_and_run_by_name),
        cmocka_unit_test(cells_of_the_group_are_judged),
        cmocka_unit_test(xpbd_carries_heavy_bodies),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
