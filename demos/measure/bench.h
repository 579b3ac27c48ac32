#ifndef DEMOS_BENCH_H
#define DEMOS_BENCH_H

// What the soft bodies of a scene cost in Pliant and in btSoftBody, and how far both stretch them.

#include "compare.h"
#include "engines/engine.h"
#include "predicted_threads.h"

#include <array>
#include <string>
#include <vector>

namespace demos {

struct BenchOptions {
    int frames = 300;
    int settled_frames = 900; // the first run goes on to here, untimed, for the stretch
    int rounds = 3;           // runs from the start; of the times of a frame the shortest counts
    bool with_reference = true, with_bullet = true;
    int threads = 1;        // of Pliant
    SolverOptions solver{}; // likewise
};

// Times are those of the soft bodies' part of a step, ms: the shortest of the rounds per frame, then over the frames.
struct EngineCost {
    bool is_measured = false;
    double median = 0, minimum = 0, mean = 0;
    double parts[soft_part_count] = {}; // medians of predict, collide, solve
    double touching_median = 0;         // over the frames in which Pliant's bodies touch something; 0: there are none
    double whole_step = 0;              // median, rigid bodies included
    double setup = 0;                   // making the engine
    // Of the links, over the last second of a run on to `settled_frames`; and how fast the nodes still are then, m/s.
    double rms_stretch = 0, max_stretch = 0, rms_speed = 0;
    bool finite = true;
    size_t bytes = 0;                // at the end
    double allocations_per_step = 0; // of steady steps
    int last_allocating_frame = 0;   // 0: none
    // Of Pliant; 0: not measured. The median on one thread in the same run, and the time of all work over that of the
    // longest chain of work that waits for each other: so many times as fast it is with any number of threads.
    double one_thread_median = 0, work_over_span = 0;
    // And with so many threads: each takes the next part of a range when it has done one, and hands over for nothing.
    std::array<double, predicted_threads.size()> predicted_speedups{};
};

// A stage of one feature (feature empty: of the step itself) without what it calls; mean per step.
struct StageCost {
    std::string stage, feature;
    double microseconds = 0;
};

struct BenchResult {
    std::string scene;
    int nodes = 0, links = 0, clusters = 0, bodies = 0;
    int frames = 0, touching_frames = 0; // the latter after whose step a soft body of Pliant has contacts
    EngineCost pliant, reference, bullet;
    std::vector<StageCost> stages; // of Pliant, dearest first
    // Of Pliant; < 0: the scene has none.
    double ns_per_link = -1;    // and iteration
    double ns_per_contact = -1; // of nodes, and iteration
    double ns_per_cluster = -1;

    double ratio() const { return bullet.median / pliant.median; }
    double touching_ratio() const { return bullet.touching_median / pliant.touching_median; }
    double reference_ratio() const { return bullet.median / reference.median; }
    double whole_ratio() const { return bullet.whole_step / pliant.whole_step; }
};

// A step, counted from 0, of which no allocation is expected: not the first, which finds everything new, and none that
// begins with a cut, which makes new nodes, links and faces.
bool is_steady(const Description& description, int step);

// count_bullet_memory() is to be called first.
BenchResult bench_scene(const Description& description, const BenchOptions& options, const Progress& progress);

// ------------------------------------------------------------------------------------------------------- series

struct BenchSize {
    scene which{};
    SceneOptions scene_options{};
    int frames = 0; // 0: as series_options has it
};

// The same thing in growing sizes, or in a few kinds.
struct BenchSeries {
    std::string name; // "sheet", "sphere", "bodies"
    std::vector<BenchSize> sizes;
    SolverOptions solver{};
};

const std::vector<BenchSeries>& bench_series();
// Throws Error when there is none of that name.
const BenchSeries& find_bench_series(const std::string& name);
// Fewer frames for larger scenes, and no btSoftBody where it would take minutes, or has not that solver.
BenchOptions series_options(const BenchSeries& series, const BenchSize& size, const Description& description,
                            bool is_quick);

} // namespace demos
#endif
