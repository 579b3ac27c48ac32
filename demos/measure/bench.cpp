// Runs the engines in turn, in blocks of frames, so that whatever else the machine does hits all alike.

#include "bench.h"

#include "engines/pliant_engine.h"
#include "engines/stage_clock.h"
#include "engines/stopwatch.h"
#include "measure.h"
#include "span_clock.h"
#include "statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace demos {

namespace {

constexpr int block_frames = 10;
constexpr int averaged_frames = 60; // 1 s

// -------------------------------------------------------------------------------------------------- one engine

class Runner {
public:
    Runner(EngineKind kind, EngineOptions engine_options, EngineCost& cost, const BenchOptions& options)
        : kind_(kind), options_(engine_options), settled_frames_(options.settled_frames), cost_(cost) {
        cost_.is_measured = true;
        const auto count = static_cast<size_t>(options.frames);
        sums_.resize(count);
        touches_.resize(count);
        wholes_.resize(count);
        for (std::vector<double>& times : parts_) {
            times.resize(count);
        }
    }

    void start(const Description& description) {
        description_ = &description;
        const Stopwatch watch;
        engine_ = make_engine(kind_, description, options_);
        const double setup = watch.milliseconds();
        cost_.setup = round_ == 0 ? setup : std::min(cost_.setup, setup);
    }

    void run(int first, int end) {
        for (int frame = first; frame < end; ++frame) {
            const uint64_t before = engine_->soft_allocations();
            engine_->step();
            const uint64_t made = engine_->soft_allocations() - before;
            if (round_ == 0) { touches_[static_cast<size_t>(frame)] = is_touching(); }
            if (round_ == 0 && made > 0) { cost_.last_allocating_frame = frame + 1; }
            if (round_ == 0 && is_steady(*description_, frame)) {
                steady_allocations_ += made;
                ++steady_steps_;
            }
            const StepTimes& times = engine_->step_times();
            keep(sums_, frame, times.sum());
            keep(wholes_, frame, engine_->step_milliseconds());
            for (size_t part = 0; part < parts_.size(); ++part) {
                keep(parts_[part], frame, times.parts[part]);
            }
        }
    }

    Measures finish() {
        const Measures measures = measure(*engine_);
        cost_.finite = measures.finite;
        cost_.bytes = engine_->soft_bytes();
        if (round_ == 0) { settle(measures); }
        engine_.reset();
        ++round_;
        return measures;
    }

    const std::vector<bool>& touches() const { return touches_; }

    void sum_up(const std::vector<bool>& touches) {
        cost_.median = median(sums_);
        std::vector<double> touching;
        for (size_t frame = 0; frame < sums_.size(); ++frame) {
            if (touches[frame]) { touching.push_back(sums_[frame]); }
        }
        if (!touching.empty()) { cost_.touching_median = median(touching); }
        cost_.minimum = *std::min_element(sums_.begin(), sums_.end());
        for (const double time : sums_) {
            cost_.mean += time / static_cast<double>(sums_.size());
        }
        cost_.whole_step = median(wholes_);
        for (size_t part = 0; part < parts_.size(); ++part) {
            cost_.parts[part] = median(parts_[part]);
        }
        const auto steady = static_cast<double>(std::max<uint64_t>(steady_steps_, 1));
        cost_.allocations_per_step = static_cast<double>(steady_allocations_) / steady;
    }

private:
    // Bodies bounce and swing for long: what they are like at one frame says little.
    void settle(const Measures& measures) {
        cost_.rms_stretch = measures.rms_stretch;
        cost_.max_stretch = measures.max_stretch;
        cost_.rms_speed = measures.rms_speed;
        const int more = settled_frames_ - static_cast<int>(sums_.size());
        if (more < averaged_frames) { return; }
        double stretch = 0, speed = 0;
        cost_.max_stretch = 0;
        for (int i = 0; i < more; ++i) {
            engine_->step();
            if (i < more - averaged_frames) { continue; }
            const Measures now = measure(*engine_);
            stretch += now.rms_stretch * now.rms_stretch / averaged_frames;
            speed += now.rms_speed * now.rms_speed / averaged_frames;
            cost_.max_stretch = std::max(cost_.max_stretch, now.max_stretch);
            cost_.finite = cost_.finite && now.finite;
        }
        cost_.rms_stretch = std::sqrt(stretch);
        cost_.rms_speed = std::sqrt(speed);
    }

    bool is_touching() const {
        for (int i = 0; i < engine_->soft_count(); ++i) {
            if (!engine_->contacts(i).empty()) { return true; }
        }
        return false;
    }

    // The runs of a scene are equal from round to round, so a longer time is a disturbance.
    void keep(std::vector<double>& times, int frame, double time) const {
        double& kept = times[static_cast<size_t>(frame)];
        kept = round_ == 0 ? time : std::min(kept, time);
    }

    EngineKind kind_;
    EngineOptions options_;
    int settled_frames_;
    EngineCost& cost_;
    const Description* description_ = nullptr;
    std::unique_ptr<Engine> engine_;
    int round_ = 0;
    uint64_t steady_allocations_ = 0, steady_steps_ = 0;
    std::vector<double> sums_, wholes_;
    std::vector<bool> touches_; // by frame
    std::array<std::vector<double>, soft_part_count> parts_;
};

// -------------------------------------------------------------------------------------------- stages of Pliant

EngineOptions pliant_options(const BenchOptions& options) {
    EngineOptions result;
    result.threads = options.threads;
    result.solver = options.solver;
    return result;
}

int link_iterations(const scene_soft_def& def) {
    const pli_solver_settings& solver = def.solver;
    return def.velocity_links ? solver.velocity_iterations + solver.drift_iterations : solver.position_iterations;
}

bool is_iteration(const std::string& stage) {
    return stage == "velocity" || stage == "position" || stage == "drift";
}

double nanoseconds_each(double milliseconds, double count) {
    return count > 0.0 ? milliseconds * 1e6 / count : -1.0;
}

struct Counts {
    double links = 0, contacts = 0, clusters = 0; // the first two times iterations
};

Counts count_work(const Description& description, const PliantEngine& engine) {
    Counts counts;
    for (int i = 0; i < engine.soft_count(); ++i) {
        const scene_soft_def& def = description.softs[static_cast<size_t>(i)].def;
        const pli_body* body = engine.body(i);
        counts.links += link_iterations(def) * pli_body_get_view(body).link_count;
        counts.contacts += def.solver.position_iterations * (pli_body_get_rigid_contacts(body, 0, nullptr) +
                                                             pli_body_get_soft_contacts(body, 0, nullptr));
        counts.clusters += pli_body_cluster_count(body);
    }
    return counts;
}

// Of all frames, ms; of each frame the shortest of the rounds.
using StageTimes = std::map<std::pair<std::string, std::string>, double>;

void sum_up_stages(const StageTimes& times, const Counts& counts, int frames, BenchResult& result) {
    double link_time = 0, contact_time = 0, cluster_time = 0;
    for (const auto& [part, time] : times) {
        const auto& [stage, feature] = part;
        result.stages.push_back({stage, feature, time * 1000.0 / frames});
        if (feature == "clusters") { cluster_time += time; }
        if (!is_iteration(stage)) { continue; }
        if (feature.find("links") != std::string::npos) { link_time += time; }
        if (feature == "rigid contacts" || feature == "soft contacts") { contact_time += time; }
    }
    std::sort(result.stages.begin(), result.stages.end(),
              [](const StageCost& a, const StageCost& b) { return a.microseconds > b.microseconds; });
    result.ns_per_link = nanoseconds_each(link_time, counts.links);
    result.ns_per_contact = nanoseconds_each(contact_time, counts.contacts);
    result.ns_per_cluster = nanoseconds_each(cluster_time, counts.clusters);
}

void profile_stages(const Description& description, const BenchOptions& options, const Progress& progress,
                    BenchResult& result) {
    std::vector<std::map<StageClock::Part, double>> shortest(static_cast<size_t>(options.frames));
    Counts counts;
    for (int round = 0; round < options.rounds; ++round) {
        PliantEngine engine(description, pliant_options(options));
        StageClock clock;
        pli_world_set_profile(engine.bridge().world(), StageClock::on_part, &clock);
        for (int frame = 0; frame < options.frames; ++frame) {
            engine.step();
            for (const auto& [part, time] : clock.take()) {
                double& kept = shortest[static_cast<size_t>(frame)].try_emplace(part, time).first->second;
                kept = std::min(kept, time);
            }
            progress(round * options.frames + frame + 1, options.rounds * options.frames);
            if (round > 0) { continue; }
            const Counts now = count_work(description, engine);
            counts.links += now.links;
            counts.contacts += now.contacts;
            counts.clusters += now.clusters;
        }
    }
    StageTimes times;
    for (const auto& frame : shortest) {
        for (const auto& [part, time] : frame) {
            times[{part.first, part.second != nullptr ? part.second : ""}] += time;
        }
    }
    sum_up_stages(times, counts, options.frames, result);
}

// Each part of a range runs alone and is timed; what is not in ranges waits for all before it.
void measure_span(const Description& description, const BenchOptions& options, EngineCost& cost) {
    constexpr int least_rounds = 3; // a disturbance within the longest part counts as a whole
    const int rounds = std::max(options.rounds, least_rounds);
    const auto frames = static_cast<size_t>(options.frames);
    std::vector<double> works(frames), spans(frames);
    std::array<std::vector<double>, predicted_threads.size()> shares; // with so many threads
    shares.fill(std::vector<double>(frames));
    for (int round = 0; round < rounds; ++round) {
        SpanClock clock;
        EngineOptions engine_options = pliant_options(options);
        engine_options.parallel_for = SpanClock::parallel_for;
        engine_options.parallel_user = &clock;
        PliantEngine engine(description, engine_options);
        for (size_t frame = 0; frame < frames; ++frame) {
            engine.step();
            const SpanClock::Savings saved = clock.take();
            const double work = engine.step_times().sum() - saved.own;
            const auto keep = [&](double& kept, double time) { kept = round == 0 ? time : std::min(kept, time); };
            keep(works[frame], work);
            keep(spans[frame], work - saved.of_all);
            for (size_t i = 0; i < shares.size(); ++i) {
                keep(shares[i][frame], work - saved.of_threads[i]);
            }
        }
    }
    cost.work_over_span = median(works) / median(spans);
    for (size_t i = 0; i < shares.size(); ++i) {
        cost.predicted_speedups[i] = median(works) / median(shares[i]);
    }
}

} // namespace

bool is_steady(const Description& description, int step) {
    return step > 0 && std::none_of(description.cuts.begin(), description.cuts.end(),
                                    [&](const CutRecord& cut) { return cut.frame == step; });
}

BenchResult bench_scene(const Description& description, const BenchOptions& options, const Progress& progress) {
    BenchResult result;
    result.scene = description.source != nullptr ? description.source->name : "";
    result.bodies = static_cast<int>(description.softs.size());
    std::vector<Runner> runners;
    runners.emplace_back(EngineKind::pliant, pliant_options(options), result.pliant, options);
    if (options.with_reference) {
        EngineOptions reference = pliant_options(options);
        reference.reference = true;
        runners.emplace_back(EngineKind::pliant, reference, result.reference, options);
    }
    // On one thread in turn with more of them.
    BenchOptions unsettled = options;
    unsettled.settled_frames = 0;
    EngineCost one_thread;
    if (options.threads > 1) {
        EngineOptions alone = pliant_options(options);
        alone.threads = 1;
        runners.emplace_back(EngineKind::pliant, alone, one_thread, unsettled);
    }
    if (options.with_bullet) { runners.emplace_back(EngineKind::bullet, EngineOptions{}, result.bullet, options); }
    const int steps = 2 * options.frames * options.rounds;
    for (int round = 0; round < options.rounds; ++round) {
        for (Runner& runner : runners) {
            runner.start(description);
        }
        for (int first = 0; first < options.frames; first += block_frames) {
            const int end = std::min(first + block_frames, options.frames);
            for (Runner& runner : runners) {
                runner.run(first, end);
            }
            progress(round * options.frames + end, steps);
        }
        for (size_t i = 0; i < runners.size(); ++i) {
            const Measures measures = runners[i].finish();
            if (i > 0) { continue; }
            result.nodes = measures.nodes;
            result.links = measures.links;
            result.clusters = measures.clusters;
        }
    }
    const std::vector<bool> touches = runners.front().touches();
    result.frames = options.frames;
    result.touching_frames = static_cast<int>(std::count(touches.begin(), touches.end(), true));
    for (Runner& runner : runners) {
        runner.sum_up(touches);
    }
    const auto rest = [&](int frame, int) { progress(options.rounds * options.frames + frame, steps); };
    profile_stages(description, options, rest, result);
    if (options.threads > 1) {
        result.pliant.one_thread_median = one_thread.median;
        measure_span(description, options, result.pliant);
    }
    return result;
}

} // namespace demos
