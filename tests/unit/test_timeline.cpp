// The timeline of the viewer: frames after going back equal those before, with what the user did, and memory is
// bounded.

#include "viewer/timeline.h"

#include "scene_records.h"

#include "check.h"

using demos::Engine;
using viewer::Timeline;

namespace {

struct Watched {
    std::unique_ptr<demos::Description> description;
    demos::PliantEngine engine;
    Timeline timeline;
    std::vector<uint64_t> hashes; // of the frames, when they were new

    explicit Watched(const char* name, size_t most_bytes = Timeline::usual_most_bytes,
                     demos::SolverKind solver = demos::SolverKind::position_based,
                     size_t frame_bytes = Timeline::usual_frame_bytes)
        : description(describe(name)), engine(*description, options(solver)),
          timeline(engine, most_bytes, frame_bytes), hashes{hash()} {}

    static demos::EngineOptions options(demos::SolverKind solver) {
        demos::EngineOptions made;
        made.ordered_pairs = true;
        made.solver.kind = solver;
        return made;
    }
    uint64_t hash() const { return demos::hash_frame(engine); }
    void go_on(int frames) {
        for (int i = 0; i < frames; ++i) {
            timeline.step();
            assert_true(timeline.is_at_end());
            hashes.push_back(hash());
        }
    }
    // What changes a body at once shows in the frame in which it was done.
    void act(Timeline::Input input) {
        timeline.act(std::move(input));
        hashes.resize(static_cast<size_t>(timeline.frame()));
        hashes.push_back(hash());
    }
    void expect_frame(int frame) const {
        assert_int_equal(timeline.frame(), frame);
        if (hash() != hashes[static_cast<size_t>(frame)]) {
            fail_msg("%s: frame %d is another", description->source->name, frame);
        }
    }
    // To all of these, and from the earliest one by single steps to the last frame.
    void expect_the_same(std::initializer_list<int> frames) {
        const int last = timeline.last();
        int earliest = last;
        for (const int frame : frames) {
            timeline.go_to(frame);
            expect_frame(frame);
            earliest = std::min(earliest, frame);
        }
        timeline.go_to(earliest);
        while (!timeline.is_at_end()) {
            timeline.step();
            expect_frame(timeline.frame());
        }
        assert_int_equal(timeline.frame(), last);
    }
};

Timeline::Input shot(pli_vec3 from, pli_vec3 velocity) {
    return [=](Engine& engine) {
        engine.shoot(from, velocity, 0.5f, 5.0f);
        return true;
    };
}

demos::RayHit node_hit(const Engine& engine, int node) {
    demos::RayHit hit;
    hit.soft = 0;
    hit.node = node;
    hit.point = engine.node_position(0, node);
    hit.fraction = 0.5f;
    return hit;
}

bool let_go(Engine& engine) {
    engine.let_go();
    return true;
}

Timeline::Input grab(const demos::RayHit& hit) {
    return [hit](Engine& engine) { return engine.grab(hit); };
}

Timeline::Input drag(pli_vec3 goal) {
    return [goal](Engine& engine) {
        engine.drag(goal);
        return true;
    };
}

} // namespace

static void scenes_go_the_same_way_again(void**) {
    for (const char* name : {"Cloth", "Collide2", "Impact", "RopeAttach", "ClusterCar", "ClusterStackMixed", "Aero2"}) {
        Watched watched(name);
        watched.go_on(100);
        watched.expect_the_same({99, 98, 60, 61, 30, 1, 0, 100, 45});
        watched.go_on(40);
        watched.expect_the_same({120, 0, 3});
    }
    for (const demos::SolverKind solver : {demos::SolverKind::xpbd, demos::SolverKind::implicit}) {
        Watched watched("Collide2", Timeline::usual_most_bytes, solver);
        watched.go_on(100);
        watched.expect_the_same({99, 31, 0});
    }
}

// Recording changes nothing: a run without it has the same frames.
static void recording_leaves_no_trace(void**) {
    Watched watched("Collide2");
    watched.go_on(70);
    const std::unique_ptr<demos::Description> description = describe("Collide2");
    demos::PliantEngine plain(*description, Watched::options(demos::SolverKind::position_based));
    for (int i = 1; i <= 70; ++i) {
        plain.step();
        assert_true(demos::hash_frame(plain) == watched.hashes[static_cast<size_t>(i)]);
    }
}

static void what_the_user_did_is_repeated(void**) {
    Watched watched("Cutting1");
    watched.go_on(20);
    watched.act(shot(pli_vec3_make(0, 12, 0), pli_vec3_make(0, -20, 0)));
    watched.go_on(20);
    watched.act([](Engine& engine) { // makes other nodes and links
        engine.cut_sphere(0, engine.node_position(0, 120), 1.0f);
        return true;
    });
    watched.go_on(15);
    watched.act(shot(pli_vec3_make(3, 12, 1), pli_vec3_make(0, -20, 0)));
    watched.go_on(5);
    const demos::RayHit hit = node_hit(watched.engine, 0);
    watched.act(grab(hit));
    for (int i = 1; i <= 50; ++i) { // over where a keyframe would be
        watched.timeline.move(drag(hit.point));
        watched.timeline.move(drag(pli_vec3_add(hit.point, pli_vec3_make(0, 0.05f * static_cast<float>(i), 0))));
        watched.go_on(1);
    }
    watched.act(let_go);
    watched.go_on(70);
    assert_int_equal(watched.engine.balls().size(), 2);
    assert_int_equal(watched.timeline.last(), 180);
    watched.expect_the_same({179, 85, 100, 41, 40, 39, 61, 19, 20, 21, 150, 0});
    watched.timeline.go_to(10);
    assert_int_equal(watched.engine.balls().size(), 0);
    watched.timeline.go_to(59);
    assert_int_equal(watched.engine.balls().size(), 2);
    watched.timeline.go_to(40);
    const size_t cut = watched.engine.soft(0).positions.size();
    watched.timeline.go_to(39);
    assert_true(watched.engine.soft(0).positions.size() < cut);
    assert_int_equal(watched.timeline.input_frames().size(), 3 + 50 + 1); // the grab is in the frame of the first move
}

// A rigid body that is held, and what is let go of.
static void a_rigid_body_is_pulled_again(void**) {
    Watched watched("ClusterStackMixed");
    watched.go_on(31);
    int held = 0;
    while (watched.engine.rigids().body(held) == nullptr || watched.engine.rigids().body(held)->getInvMass() <= 0) {
        ++held;
    }
    demos::RayHit hit;
    hit.rigid = held;
    hit.point = watched.engine.rigid(held).pose.origin;
    hit.fraction = 0.5f;
    watched.act(grab(hit));
    watched.timeline.move(drag(pli_vec3_add(hit.point, pli_vec3_make(0, 4, 0))));
    watched.go_on(40);
    watched.act(let_go);
    watched.go_on(40);
    watched.expect_the_same({100, 40, 31, 30, 71, 0});
}

static void a_change_cuts_off_the_future(void**) {
    Watched watched("Cloth");
    watched.go_on(100);
    watched.timeline.go_to(50);
    const std::string failed =
        error_of([&] { watched.timeline.act([](Engine&) -> bool { throw demos::Error("it cannot be done"); }); });
    assert_string_equal(failed.c_str(), "it cannot be done");
    watched.timeline.act([](Engine&) { return false; });
    assert_int_equal(watched.timeline.last(), 100); // nothing has changed
    const std::vector<uint64_t> before = watched.hashes;
    watched.act(shot(pli_vec3_make(0, 3, 0), pli_vec3_make(0, -10, 0)));
    assert_int_equal(watched.timeline.last(), 50);
    assert_true(watched.timeline.is_at_end());
    watched.go_on(50);
    assert_true(watched.hashes[50] != before[50]); // the ball is there
    assert_true(watched.hashes[100] != before[100]);
    watched.expect_the_same({99, 51, 50, 49, 0});
    watched.timeline.go_to(49);
    assert_true(watched.hash() == before[49]);
    const std::string outside = error_of([&] { watched.timeline.go_to(101); });
    assert_string_equal(outside.c_str(), "frame 101 is not on the timeline, which has 0 to 100");
    assert_int_equal(watched.timeline.frame(), 49);
}

// Else it would be held for ever, since the frame that lets go is no more.
static void what_is_held_in_the_past_is_let_go_of(void**) {
    Watched watched("Cloth");
    watched.go_on(5);
    const demos::RayHit hit = node_hit(watched.engine, 200);
    watched.act(grab(hit));
    watched.go_on(20);
    watched.act(let_go);
    watched.go_on(5);
    watched.timeline.go_to(15);
    assert_true(watched.engine.is_holding());
    watched.act(shot(pli_vec3_make(0, 30, 0), pli_vec3_make(0, -10, 0)));
    assert_false(watched.engine.is_holding());
    watched.go_on(20);
    watched.expect_the_same({14, 15, 16, 5, 0});
}

static void controls_go_back(void**) {
    Watched watched("Aero2");
    watched.go_on(20);
    watched.act([](Engine& engine) {
        engine.set_control(0, 180);
        return true;
    });
    watched.go_on(40);
    watched.expect_the_same({59, 19, 20, 0});
    check_near(static_cast<double>(watched.engine.control(0)), 180, 0);
    watched.timeline.go_to(19);
    check_near(static_cast<double>(watched.engine.control(0)),
               static_cast<double>(watched.description->controls[0].def.initial), 0);
}

static void memory_is_bounded(void**) {
    size_t one = 0;
    {
        const Watched start("Cloth");
        one = start.timeline.bytes();
    }
    const size_t most = 6 * one;
    Watched watched("Cloth", most);
    size_t largest = 0;
    for (int i = 0; i < 1600; ++i) {
        watched.go_on(1);
        if (i % 100 == 50) { watched.act(shot(pli_vec3_make(50, 30, 0), pli_vec3_make(0, 1, 0))); }
        largest = std::max(largest, watched.timeline.bytes());
    }
    assert_true(largest <= most);
    assert_true(largest > most / 2);
    const int first = watched.timeline.first();
    assert_true(first > 0); // the oldest frames are forgotten
    assert_true(watched.timeline.last() - first >= 240);
    assert_true(watched.timeline.input_frames().front() >= first);
    watched.expect_the_same({1599, 1500, 1400, first});
    assert_true(!error_of([&] { watched.timeline.go_to(first - 1); }).empty());
}

static void large_keyframes_are_rarer(void**) {
    Watched usual("Cloth");
    const size_t one = usual.timeline.bytes();
    usual.go_on(30);
    assert_true(usual.timeline.bytes() > one);
    Watched watched("Cloth", Timeline::usual_most_bytes, demos::SolverKind::position_based, one / 70);
    watched.go_on(60);
    assert_int_equal(watched.timeline.bytes(), one);
    watched.go_on(15);
    assert_true(watched.timeline.bytes() > one);
    watched.expect_the_same({74, 60, 30, 0});
}

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(scenes_go_the_same_way_again),
        cmocka_unit_test(recording_leaves_no_trace),
        cmocka_unit_test(what_the_user_did_is_repeated),
        cmocka_unit_test(a_rigid_body_is_pulled_again),
        cmocka_unit_test(a_change_cuts_off_the_future),
        cmocka_unit_test(what_is_held_in_the_past_is_let_go_of),
        cmocka_unit_test(controls_go_back),
        cmocka_unit_test(memory_is_bounded),
        cmocka_unit_test(large_keyframes_are_rarer),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
