// Random bodies and scenes: each runs alone in Pliant's reference mode and in btSoftBody, only the order of contacts is
// taken over, and must stay bit-equal.
//
//     oracle_random_bodies [--cases N] [--seed S] [--steps N] [--shrink] [--off FEATURE]...
//
// Case i has the seed S + i; one case: --cases 1 --seed S. --shrink switches off what a difference does not need.

#include "contact_match.h"
#include "random_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

namespace {

using random_scene::Case;
using random_scene::Extras;

struct Options {
    int cases = 500, steps = 20;
    std::uint64_t seed = 1;
    bool shrink = false, lists = false;
    std::set<std::string> off;
};

enum class Verdict { equal, nan_in_bullet, known, differs, refused };
constexpr const char* verdict_names[] = {"bit-equal", "NaN in Bullet", "of a known class", "differ", "refused"};

struct Outcome {
    Verdict verdict = Verdict::equal;
    int step = 0; // that ended the case
    double position = 0, velocity = 0, rigid = 0;
    int lone_contacts = 0;
    std::string message;
    std::string known; // class of Bullet's own that the case has been in
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
    clusters.as_bullet = true;
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

// What btSoftBody is about to do that Pliant does not follow, from its state before a step; empty: nothing. See "Random
// bodies" in docs/comparison.md.
std::string known_class(const btSoftBody& body) {
    const btSoftBody::Config& config = body.m_cfg;
    const btScalar volume = body.getVolume();
    if (config.kPR != 0 && volume == 0) { return "pressure by a volume of zero"; }
    return "";
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

// DUMP-BEGIN
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdouble-promotion"
void dump(demos::BulletEngine& reference, demos::PliantEngine& pliant) {
    for (int i = 0; i < reference.soft_count(); ++i) {
        const btSoftBody& b = reference.body(i);
        const demos::SoftState expected = reference.soft(i), actual = pliant.soft(i);
        for (size_t k = 0; k < expected.positions.size(); ++k) {
            const auto p = expected.positions[k], q = actual.positions[k], v = expected.velocities[k], w = actual.velocities[k];
            if (std::memcmp(&p, &q, 12) || std::memcmp(&v, &w, 12))
                std::printf("soft %d node %zu im %g: x %.9g %.9g %.9g | %.9g %.9g %.9g  v %.9g %.9g %.9g | %.9g %.9g %.9g\n", i, k, double(expected.inverse_masses[k]), p.x, p.y, p.z, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z);
        }
        for (int k = 0; k < b.m_clusters.size() && k < 4; ++k) {
            const auto& c = *b.m_clusters[k];
            pli_cluster_view view;
            pli_body_get_cluster(pliant.body(i), k, &view);
            std::printf("cluster %d.%d: n %d imass %g|%g com %.9g %.9g %.9g|%.9g %.9g %.9g lv %.9g %.9g %.9g|%.9g %.9g %.9g av %.9g %.9g %.9g|%.9g %.9g %.9g\n", i, k, c.m_nodes.size(), c.m_imass, view.inverse_mass, c.m_com.x(), c.m_com.y(), c.m_com.z(), view.frame.origin.x, view.frame.origin.y, view.frame.origin.z,
               c.m_lv.x(), c.m_lv.y(), c.m_lv.z(), view.linear_velocity.x, view.linear_velocity.y, view.linear_velocity.z, c.m_av.x(), c.m_av.y(), c.m_av.z(), view.angular_velocity.x, view.angular_velocity.y, view.angular_velocity.z);
            for (int r = 0; r < 3; ++r)
              std::printf("   locii %.9g %.9g %.9g  invwi %.9g %.9g %.9g | %.9g %.9g %.9g  rot %.9g %.9g %.9g | %.9g %.9g %.9g\n", c.m_locii[r].x(), c.m_locii[r].y(), c.m_locii[r].z(), c.m_invwi[r].x(), c.m_invwi[r].y(), c.m_invwi[r].z(),
                view.inverse_inertia_world.rows[r].x, view.inverse_inertia_world.rows[r].y, view.inverse_inertia_world.rows[r].z,
                c.m_framexform.getBasis()[r].x(), c.m_framexform.getBasis()[r].y(), c.m_framexform.getBasis()[r].z(),
                view.frame.rotation.rows[r].x, view.frame.rotation.rows[r].y, view.frame.rotation.rows[r].z);
        }
    }
}
#pragma GCC diagnostic pop
// DUMP-END

Outcome run(std::uint64_t key, int steps, const std::set<std::string>& off) {
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
            outcome.step = step + 1;
            for (size_t i = 0; i < softs; ++i) {
                const int index = static_cast<int>(i);
                if (made->extras[i].move_step == step) {
                    move_nodes(reference.body(index), pliant.body(index), made->extras[i]);
                }
            }
            for (int i = 0; outcome.known.empty() && i < reference.soft_count(); ++i) {
                outcome.known = known_class(reference.body(i));
            }
            reference.step();
            if (!is_finite(reference)) {
                outcome.verdict = Verdict::nan_in_bullet;
                break;
            }
            pliant.step();
            if (!trouble.empty()) { throw demos::Error(trouble); }
            compare(reference, pliant, outcome);
            if (outcome.verdict == Verdict::differs && !outcome.known.empty()) { outcome.verdict = Verdict::known; }
            if (std::getenv("DUMP")) dump(reference, pliant);
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
std::set<std::string> shrink(std::uint64_t key, int steps, std::set<std::string> off) {
    for (bool has_changed = true; has_changed;) {
        has_changed = false;
        for (const std::string& feature : run(key, steps, off).features) {
            std::set<std::string> without = off;
            if (feature.find('(') != std::string::npos || !without.insert(feature).second) { continue; }
            if (run(key, steps, without).verdict == Verdict::differs) {
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

} // namespace

int main(int count, char** arguments) {
    Options options;
    if (!parse(count, arguments, options)) {
        std::fprintf(stderr, "%s [--cases N] [--seed S] [--steps N] [--shrink] [--list] [--off FEATURE]...\n",
                     arguments[0]);
        return 2;
    }
    std::map<Verdict, int> verdicts, after_one;
    for (int i = 0; i < options.cases; ++i) {
        const std::uint64_t key = options.seed + static_cast<std::uint64_t>(i);
        const Outcome outcome = run(key, options.steps, options.off);
        verdicts[outcome.verdict] += 1;
        after_one[outcome.step > 1 ? Verdict::equal : outcome.verdict] += 1;
        if (options.lists || outcome.verdict == Verdict::differs) { print(key, outcome); }
        if (options.shrink && outcome.verdict == Verdict::differs) {
            const Outcome small = run(key, options.steps, shrink(key, options.steps, options.off));
            std::printf("  needs:\n  ");
            print(key, small);
        }
        std::fflush(stdout);
    }
    for (const auto& [verdict, number] : verdicts) {
        std::printf("%s: %d of %d (after one step %d)\n", verdict_names[static_cast<int>(verdict)], number,
                    options.cases, after_one[verdict]);
    }
    return verdicts[Verdict::differs] == 0 ? 0 : 1;
}
