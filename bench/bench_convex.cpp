// Distance and penetration of random convex hulls: errors of the methods in a table, then times per call.
// bench_convex [number of pairs of the table, 0: none] [options of Google Benchmark]

#include "convex_pairs.hpp"

#include <benchmark/benchmark.h>
#include <ccd/ccd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

using namespace pairs;

// ---- libccd as it comes: its own centre rays, its own tolerances but for size
struct Plain {
    const Hull* hull;
};

void plain_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
    const ccd_real_t* d = direction->v;
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const pli_vec3 unit = {static_cast<float>(d[0] / length), static_cast<float>(d[1] / length),
                           static_cast<float>(d[2] / length)};
    const pli_vec3 p = Hull::support(static_cast<const Plain*>(object)->hull, unit);
    ccdVec3Set(point, static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
}

void plain_centre(const void* object, ccd_vec3_t* centre) {
    const pli_vec3 c = static_cast<const Plain*>(object)->hull->centre;
    ccdVec3Set(centre, static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z));
}

Opinion plain_ccd(const Pair& pair, bool is_epa) {
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = plain_support;
    ccd.center1 = ccd.center2 = plain_centre;
    ccd.max_iterations = 100;
    const Plain a = {&pair.a}, b = {&pair.b};
    ccd_real_t depth = 0;
    ccd_vec3_t n = {{0, 0, 0}}, position;
    const int status = is_epa ? ccdGJKPenetration(&a, &b, &ccd, &depth, &n, &position)
                              : ccdMPRPenetration(&a, &b, &ccd, &depth, &n, &position);
    return {status == 0, -depth, {-n.v[0], -n.v[1], -n.v[2]}};
}

// ---- methods
enum Method { plain_mpr, plain_epa, descent, epa, bullet_epa, method_count };
const char* const method_names[method_count] = {"libccd MPR, plain", "libccd EPA, plain", "descent (default)",
                                                "EPA + descent", "Bullet GJK/EPA"};

plii_convex_result run(const Pair& pair, plii_penetration_fn* penetration, plii_convex_cache* cache) {
    const plii_convex a = pair.a.convex(), b = pair.b.convex();
    plii_convex_options options{};
    options.max_distance = INFINITY;
    options.penetration = penetration;
    plii_convex_result result;
    plii_convex_distance(&a, &b, &options, cache, &result);
    return result;
}

struct Sample {
    Pair pair;
    btConvexHullShape a, b; // in the frame of the pair
    Opinion exact;
};

Opinion ask_bullet(const Sample& sample) {
    return bullet_opinion(sample.a, sample.b, pli_vec3_sub(sample.pair.a.centre, sample.pair.b.centre));
}

Opinion ask(const Sample& sample, int method) {
    switch (method) {
    case plain_mpr:
        return plain_ccd(sample.pair, false);
    case plain_epa:
        return plain_ccd(sample.pair, true);
    case descent:
        return pliant_opinion(run(sample.pair, nullptr, nullptr));
    case epa:
        return pliant_opinion(run(sample.pair, plii_penetration_epa, nullptr));
    default:
        return ask_bullet(sample);
    }
}

enum Class { apart, shallow, deep, class_count };
const char* const class_names[class_count] = {"apart, up to 0.1", "overlapping, up to 0.1 deep",
                                              "overlapping, deeper than 0.1"};

// `count` pairs of a class with their exact distance. Apart that is Pliant's, which its support plane proves.
std::vector<Sample*> make_samples(Class wanted, int count, uint64_t seed) {
    pli_context* context = nullptr;
    if (pli_context_create(nullptr, &context) != PLI_OK) { std::abort(); }
    Random random = {seed};
    std::vector<Sample*> samples;
    while (static_cast<int>(samples.size()) < count) {
        const Pair pair = random_pair(random);
        const plii_convex_result r = run(pair, nullptr, nullptr);
        const bool is_apart = r.relation == PLII_CONVEX_SEPARATED;
        if (is_apart != (wanted == apart) || r.distance > 0.1f) { continue; }
        const Opinion exact = is_apart ? pliant_opinion(r) : exact_overlap(context, pair);
        if (!is_apart && (exact.distance < -0.1) != (wanted == deep)) { continue; }
        Sample* sample = new Sample;
        sample->pair = pair;
        bullet_shape(pair.a, sample->a);
        bullet_shape(pair.b, sample->b);
        sample->exact = exact;
        samples.push_back(sample);
    }
    pli_context_destroy(context);
    return samples;
}

void free_samples(const std::vector<Sample*>& samples) {
    for (Sample* sample : samples) {
        delete sample;
    }
}

double percentile(std::vector<double>& sorted, double share) {
    return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void print_table(int count) {
    std::printf("hulls of 8 to 20 points, size 1; errors against the exact distance, %d pairs a row\n", count);
    for (int c = 0; c < class_count; ++c) {
        const std::vector<Sample*> samples = make_samples(static_cast<Class>(c), count, 7);
        std::printf("\n%-30s| %-29s| %-26s| none\n%-30s| %9s%9s%9s  | %8s%8s%8s  |\n", class_names[c], "distance error",
                    "normal error, degrees", "", "p50", "p90", "p99", "p50", "p90", "p99");
        for (int m = 0; m < method_count; ++m) {
            if (c == apart && m != descent && m != bullet_epa) { continue; } // the others cannot say
            std::vector<double> distances, normals;
            int none = 0;
            for (const Sample* sample : samples) {
                const Opinion opinion = ask(*sample, m);
                if (!opinion.is_valid) {
                    ++none;
                    continue;
                }
                distances.push_back(std::fabs(opinion.distance - sample->exact.distance));
                normals.push_back(angle_degrees(opinion.normal, sample->exact.normal));
            }
            std::sort(distances.begin(), distances.end());
            std::sort(normals.begin(), normals.end());
            std::printf("%-30s| %9.2g%9.2g%9.2g  | %8.2g%8.2g%8.2g  | %d\n",
                        c == apart && m == descent ? "GJK" : method_names[m], percentile(distances, 0.5),
                        percentile(distances, 0.9), percentile(distances, 0.99), percentile(normals, 0.5),
                        percentile(normals, 0.9), percentile(normals, 0.99), none);
        }
        free_samples(samples);
    }
    std::printf("\n");
}

// ---- times
void time_method(benchmark::State& state, Class kind, int method) {
    const std::vector<Sample*> samples = make_samples(kind, 500, 9);
    size_t next = 0;
    int64_t calls = 0;
    for (auto _ : state) {
        const Sample& sample = *samples[next];
        sample.pair.a.calls = sample.pair.b.calls = 0;
        benchmark::DoNotOptimize(ask(sample, method));
        calls += sample.pair.a.calls + sample.pair.b.calls;
        next = (next + 1) % samples.size();
    }
    if (method != bullet_epa) {
        state.counters["supports"] = benchmark::Counter(static_cast<double>(calls), benchmark::Counter::kAvgIterations);
    }
    free_samples(samples);
}

// As in a simulation: each pair asked again with its cache.
void time_warm(benchmark::State& state, Class kind) {
    const std::vector<Sample*> samples = make_samples(kind, 500, 9);
    std::vector<plii_convex_cache> caches(samples.size(), plii_convex_cache{});
    size_t next = 0;
    int64_t calls = 0;
    for (auto _ : state) {
        const plii_convex_result result = run(samples[next]->pair, nullptr, &caches[next]);
        benchmark::DoNotOptimize(result);
        calls += result.support_calls;
        next = (next + 1) % samples.size();
    }
    state.counters["supports"] = benchmark::Counter(static_cast<double>(calls), benchmark::Counter::kAvgIterations);
    free_samples(samples);
}

} // namespace

int main(int argc, char** argv) {
    int count = 5000;
    if (argc > 1 && argv[1][0] != '-') {
        count = std::atoi(argv[1]);
        argv[1] = argv[0];
        ++argv, --argc;
    }
    if (count > 0) { print_table(count); }
    for (int c = 0; c < class_count; ++c) {
        const Class kind = static_cast<Class>(c);
        for (int m = 0; m < method_count; ++m) {
            if (kind == apart && m != descent && m != bullet_epa) { continue; }
            const std::string name = kind == apart && m == descent ? "GJK" : method_names[m];
            benchmark::RegisterBenchmark((std::string(class_names[c]) + ": " + name).c_str(),
                                         [kind, m](benchmark::State& state) { time_method(state, kind, m); });
        }
        benchmark::RegisterBenchmark((std::string(class_names[c]) + ": default, warm").c_str(),
                                     [kind](benchmark::State& state) { time_warm(state, kind); });
    }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) { return 1; }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
