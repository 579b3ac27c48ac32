// In the demo scenes only first steps and cuts allocate: afterwards neither the core nor the bridge does, nor Bullet on
// their behalf.

#include "engines/bullet_memory.h"
#include "engines/soft_clock.h"
#include "measure/bench.h"
#include "scene_records.h"

#include "check.h"

#include <LinearMath/btAlignedAllocator.h>

namespace {

constexpr int steps = 600;

// Steady steps that allocated.
int count_allocating_steps(const scene& source, bool* counts) {
    const DescriptionPointer description = demos::Description::build(source, {});
    const auto engine = make_engine(demos::EngineKind::pliant, *description, {});
    int sum = 0;
    for (int step = 0; step < steps; ++step) {
        const uint64_t before = engine->soft_allocations();
        engine->step();
        const uint64_t made = engine->soft_allocations() - before;
        if (!demos::is_steady(*description, step)) {
            *counts = *counts || made > 0;
        } else if (made > 0) {
            print_message("%s: %d allocations in step %d\n", source.name, static_cast<int>(made), step);
            ++sum;
        }
    }
    return sum;
}

} // namespace

static void steady_steps_allocate_nothing(void**) {
    assert_int_equal(scene_demo_count, 33);
    int allocating = 0;
    for (int i = 0; i < scene_demo_count; ++i) {
        bool counts = false;
        allocating += count_allocating_steps(*scene_list[i], &counts);
        assert_true(counts);
    }
    assert_int_equal(allocating, 0);
}

// Of Bullet and of C++, in the windows that belong to soft bodies and outside of pauses.
static void memory_is_counted(void**) {
    demos::SoftClock clock;
    const auto use_both = [] {
        auto made = std::make_unique<demos::SoftState>();
        btAlignedFree(btAlignedAlloc(16, 16));
        return made;
    };
    (void)use_both();
    assert_int_equal(clock.allocations(), 0);
    const bool counts_heap = demos::heap_allocations() > 0; // not under AddressSanitizer
    {
        const demos::SoftClock::Window window(clock, demos::SoftPart::solve);
        (void)use_both();
        const demos::SoftClock::Pause pause(clock);
        (void)use_both();
    }
    assert_int_equal(clock.allocations(), counts_heap ? 2 : 1);
    const demos::SoftClock::Pause pause(clock);
    (void)use_both();
    assert_int_equal(clock.allocations(), counts_heap ? 2 : 1);
}

// A cut is where allocations are, and what it made is steady again.
static void cuts_are_no_steady_steps(void**) {
    const DescriptionPointer description = describe("Cutting1");
    assert_false(demos::is_steady(*description, 0));
    assert_true(demos::is_steady(*description, 1));
    int cuts = 0;
    for (int step = 1; step < steps; ++step) {
        cuts += demos::is_steady(*description, step) ? 0 : 1;
    }
    assert_int_equal(cuts, 3);
}

int main(void) {
    demos::count_bullet_memory();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steady_steps_allocate_nothing),
        cmocka_unit_test(memory_is_counted),
        cmocka_unit_test(cuts_are_no_steady_steps),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
