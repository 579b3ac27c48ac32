// Equal bits for every number of threads and every instruction set.

#include "measure/bench.h"
#include "measure/compare.h"
#include "scene_records.h"

#include "check.h"
#include "measure/measure.h"

#include <pliant/threads.h>

#include <atomic>
#include <memory>
#include <vector>

using demos::EngineOptions;
using demos::SolverKind;

namespace {

uint64_t hash_after(const demos::Description& description, const EngineOptions& options, int frames) {
    const auto engine = make_engine(demos::EngineKind::pliant, description, options);
    for (int i = 0; i < frames; ++i) {
        engine->step();
    }
    return measure(*engine).state_hash;
}

bool is_available(pli_simd simd) {
    pli_context_def def = pli_context_def_default();
    def.simd = simd;
    pli_context* context = nullptr;
    const bool is_made = pli_context_create(&def, &context) == PLI_OK;
    pli_context_destroy(context);
    return is_made;
}

void expect_equal_bits(const demos::Description& description, EngineOptions options, int frames) {
    options.simd = PLI_SIMD_PORTABLE;
    const uint64_t expected = hash_after(description, options, frames);
    for (const pli_simd simd : {PLI_SIMD_SSE2, PLI_SIMD_AVX2, PLI_SIMD_AVX512, PLI_SIMD_NEON}) {
        if (!is_available(simd)) { continue; }
        options.simd = simd;
        assert_true(hash_after(description, options, frames) == expected);
    }
    options.simd = PLI_SIMD_BEST;
    for (const int threads : {2, 3, 8}) {
        options.threads = threads;
        assert_true(hash_after(description, options, frames) == expected);
    }
}

std::unique_ptr<demos::Description> describe_size(const demos::BenchSeries& series, const std::string& name) {
    for (const demos::BenchSize& size : series.sizes) {
        if (size.which.name == name) { return demos::Description::build(size.which, size.scene_options); }
    }
    fail_msg("no scene %s in series %s", name.c_str(), series.name.c_str());
    return nullptr;
}

} // namespace

static void scenes_have_equal_bits(void**) {
    for (const char* name : {"Cloth", "Pressure", "Volume", "Collide2", "Aero", "Aero2", "Sticks", "TorusMatch",
                             "Cutting1", "ClusterStackSoft", "ClusterStackMixed", "TetraBunny", "Friction"}) {
        expect_equal_bits(*describe(name), {}, 30);
    }
}

static void solvers_have_equal_bits(void**) {
    for (const SolverKind solver : {SolverKind::implicit, SolverKind::xpbd}) {
        EngineOptions options;
        options.solver.kind = solver;
        for (const char* name : {"Cloth", "Bunny"}) {
            expect_equal_bits(*describe(name), options, 10);
        }
    }
}

// Large enough that threads get parts.
static void large_bodies_have_equal_bits(void**) {
    const auto sheet = describe_size(demos::find_bench_series("sheet"), "sheet 128");
    const auto large_sheet = describe_size(demos::find_bench_series("sheet"), "sheet 256");
    const auto ball = describe_size(demos::find_bench_series("sphere"), "sphere 20000");
    expect_equal_bits(*sheet, {}, 3);
    expect_equal_bits(*large_sheet, {}, 2);
    expect_equal_bits(*ball, {}, 2);
    EngineOptions xpbd;
    xpbd.solver.kind = SolverKind::xpbd;
    xpbd.solver.substeps = 3;
    expect_equal_bits(*sheet, xpbd, 2);
}

// What docs/benchmarks.md has figures of.
static void series_have_equal_bits(void**) {
    const std::pair<const char*, int> series[] = {{"crowd", 2},  {"crowd-xpbd", 1}, {"flags", 3}, {"tori", 6},
                                                  {"jacobi", 3}, {"gradients", 2},  {"drape", 2}, {"fold", 2}};
    for (const auto& [name, frames] : series) {
        const demos::BenchSeries& all = demos::find_bench_series(name);
        for (const demos::BenchSize& size : all.sizes) {
            const auto description = demos::Description::build(size.which, size.scene_options);
            EngineOptions options;
            options.solver = all.solver;
            const uint64_t expected = hash_after(*description, options, frames);
            for (const int threads : {2, 3, 8}) {
                options.threads = threads;
                if (hash_after(*description, options, frames) != expected) {
                    fail_msg("%s: other bits with %d threads", size.which.name, threads);
                }
            }
        }
    }
}

// -------------------------------------------------------------------------------------------------------- the pool

namespace {

using Pool = std::unique_ptr<pli_threads, void (*)(pli_threads*)>;

Pool make_pool(int threads) {
    pli_threads* made = nullptr;
    assert_int_equal(pli_threads_create(threads, &made), PLI_OK);
    assert_int_equal(pli_threads_count(made), threads);
    return {made, pli_threads_destroy};
}

struct Marks {
    std::vector<std::atomic<int>> counts;
    std::atomic<int> parts{0}, smallest_part{1 << 30};
    pli_threads* nested = nullptr;

    explicit Marks(int size) : counts(static_cast<size_t>(size)) {}
    static void mark(int begin, int end, void* task) {
        Marks& marks = *static_cast<Marks*>(task);
        ++marks.parts;
        if (end < static_cast<int>(marks.counts.size()) && end - begin < marks.smallest_part) {
            marks.smallest_part = end - begin;
        }
        for (int i = begin; i < end; ++i) {
            ++marks.counts[static_cast<size_t>(i)];
        }
        if (marks.nested != nullptr) {
            Marks inner(100);
            pli_threads_parallel_for(mark, &inner, 100, 1, marks.nested);
            inner.expect_each_once();
        }
    }
    void expect_each_once() const {
        for (const std::atomic<int>& count : counts) {
            assert_int_equal(count.load(), 1);
        }
    }
};

} // namespace

static void a_pool_does_each_index_once(void**) {
    for (const int threads : {1, 2, 3, 8}) {
        const Pool pool = make_pool(threads);
        for (int round = 0; round < 300; ++round) {
            const int count = 1 + 37 * round % 1000, grain = 1 + round % 50;
            Marks marks(count);
            pli_threads_parallel_for(Marks::mark, &marks, count, grain, pool.get());
            marks.expect_each_once();
            assert_true(marks.parts == 1 || marks.smallest_part >= grain);
            if (threads > 1 && count > 20 * grain) { assert_true(marks.parts > 4); }
        }
    }
}

static void a_pool_may_be_asked_from_within_a_range(void**) {
    const Pool pool = make_pool(3);
    Marks marks(50);
    marks.nested = pool.get();
    pli_threads_parallel_for(Marks::mark, &marks, 50, 1, pool.get());
    marks.expect_each_once();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_have_equal_bits),       cmocka_unit_test(solvers_have_equal_bits),
        cmocka_unit_test(large_bodies_have_equal_bits), cmocka_unit_test(series_have_equal_bits),
        cmocka_unit_test(a_pool_does_each_index_once),  cmocka_unit_test(a_pool_may_be_asked_from_within_a_range),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
