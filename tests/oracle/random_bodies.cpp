// Random bodies and scenes: each runs alone in Pliant's reference mode and in btSoftBody, only the order of contacts is
// taken over, and must stay bit-equal.
//
//     oracle_random_bodies [--cases N] [--seed S] [--steps N] [--shrink] [--off FEATURE]...
//
// Case i has the seed S + i; one case: --cases 1 --seed S. --shrink switches off what a difference does not need.

#include "measure/contact_match.h"
#include "random_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <new>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

using random_scene::Case;
using random_scene::Extras;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int default_cases = 150;
#else
constexpr int default_cases = 500;
#endif

struct Options {
    int cases = default_cases, steps = 20;
    std::uint64_t seed = 1;
    bool shrink = false, lists = false;
    std::set<std::string> off;
};

enum class Verdict { equal, nan_in_bullet, crash_in_bullet, known, differs, refused, crash };
constexpr int verdict_count = 7;
constexpr const char* verdict_names[verdict_count] = {
    "bit-equal", "NaN in Bullet", "crash in Bullet", "of a known class", "differ", "refused", "crash"};

// Classes of btSoftBody's own; see "Random bodies" in docs/comparison.md.
constexpr const char* class_names[] = {"", "pressure by a volume of zero", "beyond Pliant's limits"};
constexpr int class_count = 3;
enum class Known { no, zero_volume, too_large };

// What a process that works off cases tells the one that started it: Bullet may crash.
struct Progress {
    int next = 0; // case
    int step = 0;
    bool is_in_bullet = false;
    int verdicts[verdict_count] = {}, after_one[verdict_count] = {};
    int classes[class_count] = {};
};

struct Outcome {
    Verdict verdict = Verdict::equal;
    int step = 0; // that ended the case
    double position = 0, velocity = 0, rigid = 0;
    int lone_contacts = 0;
    std::string message;
    Known known = Known::no; // class that the case has been in
    std::set<std::string> features;
};

// ------------------------------------------------------------------------------------------------------ set-up

void prepare(btSoftBody& body, const scene_soft_def& def, const Extras& extras) {
    using Flags = btSoftBody::fCollision;
    const bool has_clusters = def.has_cluster_contacts;
    body.m_cfg.collisions = (def.has_rigid_contacts ? Flags::SDF_RS : 0) | (def.has_soft_contacts ? Flags::VF_SS : 0) |
                            (has_clusters && def.cluster_contacts.with_rigids ? Flags::CL_RS : 0) |
                            (has_clusters && def.cluster_contacts.with_bodies ? Flags::CL_SS : 0);
    // In btSoftBody those of bodies without clusters count too.
    body.m_cfg.citerations = def.has_clusters ? extras.cluster_iterations : 0;
    for (int i = 0; i < body.m_clusters.size(); ++i) {
        const pli_cluster_settings& settings = extras.clusters.at(static_cast<size_t>(i));
        btSoftBody::Cluster& cluster = *body.m_clusters[i];
        cluster.m_matching = settings.matching;
        cluster.m_ndamping = settings.node_damping;
        cluster.m_ldamping = settings.linear_damping;
        cluster.m_adamping = settings.angular_damping;
    }
    if (extras.moved_nodes.empty() || extras.move_step > 0) { return; }
    // The first step would take the moved positions as rest lengths.
    body.updateConstants();
    body.m_bUpdateRtCst = false;
    if (def.has_soft_contacts) { body.initializeFaceTree(); }
}

void check(const pli_body* body, pli_status status) {
    if (status != PLI_OK) { throw demos::Error(pli_last_error(pli_world_get_context(pli_body_get_world(body)))); }
}

void prepare(pli_body* body, const scene_soft_def& def, const Extras& extras) {
    if (!def.has_clusters) { return; }
    pli_clusters_def clusters = pli_clusters_def_default();
    clusters.reference_mode = true;
    clusters.iterations = extras.cluster_iterations;
    check(body, pli_body_enable_clusters(body, &clusters));
    for (int i = 0; i < pli_body_cluster_count(body); ++i) {
        pli_cluster_settings settings;
        check(body, pli_body_get_cluster_settings(body, i, &settings));
        const pli_cluster_settings& wanted = extras.clusters.at(static_cast<size_t>(i));
        settings.matching = wanted.matching;
        settings.node_damping = wanted.node_damping;
        settings.linear_damping = wanted.linear_damping;
        settings.angular_damping = wanted.angular_damping;
        check(body, pli_body_set_cluster_settings(body, i, &settings));
    }
}

// A node alone: normals stay as they are. A whole state: they follow.
void move_nodes(btSoftBody& body, pli_body* twin, const Extras& extras) {
    for (const random_scene::MovedNode& moved : extras.moved_nodes) {
        btVector3& x = body.m_nodes[moved.node].m_x;
        x += demos::to_bullet(moved.offset);
        if (!extras.sets_state) { check(twin, pli_body_set_node_position(twin, moved.node, demos::from_bullet(x))); }
    }
    if (extras.moved_nodes.empty() || !extras.sets_state) { return; }
    body.updateNormals();
    std::vector<pli_vec3> positions, velocities;
    for (int i = 0; i < body.m_nodes.size(); ++i) {
        positions.push_back(demos::from_bullet(body.m_nodes[i].m_x));
        velocities.push_back(demos::from_bullet(body.m_nodes[i].m_v));
    }
    check(twin, pli_body_set_state(twin, positions.data(), velocities.data()));
}

// --------------------------------------------------------------------------------- classes of Bullet's own

// What btSoftBody does that Pliant does not follow. From its state before a step:
Known known_class(const btSoftBody& body) {
    return body.m_cfg.kPR != 0 && body.getVolume() == 0 ? Known::zero_volume : Known::no;
}

// And after it: what has left Pliant's limits. Bullet's world no longer simulates what is larger than 1000 km.
bool is_too_large(const demos::BulletEngine& engine) {
    const auto is_within = [](pli_vec3 v, float limit) {
        return std::fabs(v.x) <= limit && std::fabs(v.y) <= limit && std::fabs(v.z) <= limit;
    };
    for (int i = 0; i < engine.soft_count(); ++i) {
        const demos::SoftState state = engine.soft(i);
        for (size_t k = 0; k < state.positions.size(); ++k) {
            if (!is_within(state.positions[k], PLI_MAX_COORDINATE)) { return true; }
            if (!is_within(state.velocities[k], PLI_MAX_SPEED)) { return true; }
        }
        if (engine.body(i).getActivationState() == DISABLE_SIMULATION) { return true; }
    }
    for (int i = 0; i < engine.rigids().object_count(); ++i) {
        const demos::RigidState state = engine.rigid(i);
        if (!is_within(state.pose.origin, PLI_MAX_COORDINATE) || !is_within(state.linear_velocity, PLI_MAX_SPEED) ||
            !is_within(state.angular_velocity, PLI_MAX_ANGULAR_SPEED)) {
            return true;
        }
    }
    return false;
}

// ------------------------------------------------------------------------------------------------- one run

bool is_finite(pli_vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_finite(const demos::BulletEngine& engine) {
    for (int i = 0; i < engine.soft_count(); ++i) {
        const demos::SoftState state = engine.soft(i);
        for (const auto* values : {&state.positions, &state.velocities}) {
            if (!std::all_of(values->begin(), values->end(), [](pli_vec3 v) { return is_finite(v); })) { return false; }
        }
    }
    for (int i = 0; i < engine.rigids().object_count(); ++i) {
        const demos::RigidState state = engine.rigid(i);
        if (!is_finite(state.pose.origin) || !is_finite(state.linear_velocity) || !is_finite(state.angular_velocity)) {
            return false;
        }
    }
    return true;
}

double distance(const std::vector<pli_vec3>& a, const std::vector<pli_vec3>& b) {
    double largest = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const double length = static_cast<double>(pli_vec3_length(pli_vec3_sub(a[i], b[i])));
        largest = std::isfinite(length) ? std::max(largest, length) : HUGE_VAL;
    }
    return largest;
}

bool same_bits(const std::vector<pli_vec3>& a, const std::vector<pli_vec3>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(pli_vec3)) == 0;
}

void compare(const demos::BulletEngine& reference, const demos::PliantEngine& pliant, Outcome& outcome) {
    for (int i = 0; i < reference.soft_count(); ++i) {
        const demos::SoftState expected = reference.soft(i), actual = pliant.soft(i);
        outcome.position = std::max(outcome.position, distance(expected.positions, actual.positions));
        outcome.velocity = std::max(outcome.velocity, distance(expected.velocities, actual.velocities));
        if (!same_bits(expected.positions, actual.positions) || !same_bits(expected.velocities, actual.velocities)) {
            outcome.verdict = Verdict::differs;
        }
    }
    for (int i = 0; i < reference.rigids().object_count(); ++i) {
        const demos::RigidState expected = reference.rigid(i), actual = pliant.rigid(i);
        outcome.rigid = std::max({outcome.rigid, distance({expected.pose.origin}, {actual.pose.origin}),
                                  distance({expected.linear_velocity}, {actual.linear_velocity})});
        if (std::memcmp(&expected, &actual, sizeof expected) != 0) { outcome.verdict = Verdict::differs; }
    }
}

Outcome run(std::uint64_t key, int steps, const std::set<std::string>& off, Progress& progress) {
    Outcome outcome;
    try {
        const std::unique_ptr<Case> made = random_scene::make(key, off);
        outcome.features = made->features;
        demos::EngineOptions options;
        options.step_seconds = made->step_seconds;
        demos::BulletEngine reference(made->description, options);
        options.reference = options.bullet_witness = true;
        demos::PliantEngine pliant(made->description, options);
        const size_t softs = made->description.softs.size();
        for (size_t i = 0; i < softs; ++i) {
            prepare(reference.body(static_cast<int>(i)), made->description.softs[i].def, made->extras[i]);
            prepare(pliant.body(static_cast<int>(i)), made->description.softs[i].def, made->extras[i]);
        }
        demos::ContactMatcher matcher(reference, pliant);
        std::string trouble; // exceptions must not pass through Bullet
        pliant.bridge().set_before_solve([&] {
            try {
                outcome.lone_contacts += matcher.match();
            } catch (const std::exception& error) { trouble = error.what(); }
        });
        for (int step = 0; step < steps && outcome.verdict == Verdict::equal; ++step) {
            progress.step = outcome.step = step + 1;
            for (size_t i = 0; i < softs; ++i) {
                const int index = static_cast<int>(i);
                if (made->extras[i].move_step == step) {
                    move_nodes(reference.body(index), pliant.body(index), made->extras[i]);
                }
            }
            for (int i = 0; outcome.known == Known::no && i < reference.soft_count(); ++i) {
                outcome.known = known_class(reference.body(i));
            }
            progress.is_in_bullet = true;
            reference.step();
            progress.is_in_bullet = false;
            if (!is_finite(reference)) {
                outcome.verdict = Verdict::nan_in_bullet;
                break;
            }
            if (is_too_large(reference)) {
                outcome.verdict = Verdict::known;
                outcome.known = Known::too_large;
                break;
            }
            pliant.step();
            if (!trouble.empty()) { throw demos::Error(trouble); }
            compare(reference, pliant, outcome);
            if (outcome.verdict == Verdict::differs && outcome.known != Known::no) { outcome.verdict = Verdict::known; }
        }
        pliant.bridge().set_before_solve(nullptr);
    } catch (const demos::Error& error) {
        outcome.verdict = Verdict::refused;
        outcome.message = error.what();
    }
    return outcome;
}

// ----------------------------------------------------------------------------------------------------- reports

std::string join(const std::set<std::string>& features) {
    std::string text;
    for (const std::string& feature : features) {
        text += (text.empty() ? "" : ", ") + feature;
    }
    return text;
}

// Without each feature that the difference does not need.
std::set<std::string> shrink(std::uint64_t key, int steps, std::set<std::string> off, Progress& progress) {
    for (bool has_changed = true; has_changed;) {
        has_changed = false;
        for (const std::string& feature : run(key, steps, off, progress).features) {
            std::set<std::string> without = off;
            if (feature.find('(') != std::string::npos || !without.insert(feature).second) { continue; }
            if (run(key, steps, without, progress).verdict == Verdict::differs) {
                off = without;
                has_changed = true;
            }
        }
    }
    return off;
}

void print(std::uint64_t key, const Outcome& outcome) {
    std::printf("seed %llu: %s at step %d", static_cast<unsigned long long>(key),
                verdict_names[static_cast<int>(outcome.verdict)], outcome.step);
    if (outcome.verdict == Verdict::refused) {
        std::printf(" (%s)\n", outcome.message.c_str());
        return;
    }
    std::printf(", dx %.3g, dv %.3g, rigid %.3g, %d lone contacts\n    %s\n", outcome.position, outcome.velocity,
                outcome.rigid, outcome.lone_contacts, join(outcome.features).c_str());
}

bool parse(int count, char** arguments, Options& options) {
    for (int i = 1; i < count; ++i) {
        const std::string name = arguments[i];
        const char* value = i + 1 < count ? arguments[i + 1] : nullptr;
        if (name == "--shrink") {
            options.shrink = true;
            continue;
        }
        if (name == "--list") {
            options.lists = true;
            continue;
        }
        if (value == nullptr) { return false; }
        ++i;
        if (name == "--cases") {
            options.cases = std::atoi(value);
        } else if (name == "--seed") {
            options.seed = std::strtoull(value, nullptr, 10);
        } else if (name == "--steps") {
            options.steps = std::atoi(value);
        } else if (name == "--off") {
            options.off.insert(value);
        } else {
            return false;
        }
    }
    return options.cases > 0 && options.steps > 0;
}

void take(Progress& progress, Verdict verdict, int step) {
    progress.verdicts[static_cast<int>(verdict)] += 1;
    progress.after_one[static_cast<int>(step > 1 ? Verdict::equal : verdict)] += 1;
}

void work(const Options& options, Progress& progress) {
    for (; progress.next < options.cases; ++progress.next) {
        const std::uint64_t key = options.seed + static_cast<std::uint64_t>(progress.next);
        const Outcome outcome = run(key, options.steps, options.off, progress);
        take(progress, outcome.verdict, outcome.step);
        if (outcome.verdict == Verdict::known) { progress.classes[static_cast<int>(outcome.known)] += 1; }
        if (options.lists || outcome.verdict == Verdict::differs || outcome.verdict == Verdict::refused) {
            print(key, outcome);
        }
        if (options.shrink && outcome.verdict == Verdict::differs) {
            const std::set<std::string> off = shrink(key, options.steps, options.off, progress);
            std::printf("  needs:\n  ");
            print(key, run(key, options.steps, off, progress));
        }
        std::fflush(stdout);
    }
}

// The process that worked on the next case is gone.
void take_crash(const Options& options, Progress& progress) {
    const Verdict verdict = progress.is_in_bullet ? Verdict::crash_in_bullet : Verdict::crash;
    take(progress, verdict, progress.step);
    std::printf("seed %llu: %s\n",
                static_cast<unsigned long long>(options.seed + static_cast<std::uint64_t>(progress.next)),
                verdict_names[static_cast<int>(verdict)]);
    std::fflush(stdout);
    progress.is_in_bullet = false;
    progress.next += 1;
}

// Nothing differs, and most cases say something.
bool is_good(const Options& options, const Progress& progress) {
    const auto count = [&](Verdict verdict) { return progress.verdicts[static_cast<int>(verdict)]; };
    return count(Verdict::differs) == 0 && count(Verdict::crash) == 0 &&
           100 * count(Verdict::refused) <= options.cases && 10 * count(Verdict::equal) >= 8 * options.cases;
}

} // namespace

int main(int count, char** arguments) {
    Options options;
    if (!parse(count, arguments, options)) {
        std::fprintf(stderr, "%s [--cases N] [--seed S] [--steps N] [--shrink] [--list] [--off FEATURE]...\n",
                     arguments[0]);
        return 2;
    }
    void* memory = mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) { return 2; }
    Progress& progress = *new (memory) Progress;
    while (progress.next < options.cases) {
        const pid_t worker = fork();
        if (worker < 0) { return 2; }
        if (worker == 0) {
            work(options, progress);
            return 0;
        }
        int status = 0;
        waitpid(worker, &status, 0);
        if (progress.next < options.cases) { take_crash(options, progress); }
    }
    for (int i = 0; i < verdict_count; ++i) {
        if (progress.verdicts[i] == 0) { continue; }
        std::printf("%s: %d of %d (after one step %d)\n", verdict_names[i], progress.verdicts[i], options.cases,
                    progress.after_one[i]);
    }
    for (int i = 0; i < class_count; ++i) {
        if (progress.classes[i] > 0) { std::printf("  %s: %d\n", class_names[i], progress.classes[i]); }
    }
    return is_good(options, progress) ? 0 : 1;
}
