// One-step comparison: both engines make each step from the same state, that of btSoftBody.

#include "compare.h"
#include "contact_match.h"
#include "description/recorder.h"

#include <pliant/bullet_reference.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace demos {

namespace {

constexpr double error_limit = 1e-5;

// ----------------------------------------------------------------------------------- taking over the reference

void copy_body(const btRigidBody& from, btRigidBody& to) {
    to.setCenterOfMassTransform(from.getWorldTransform()); // turns the inertia too
    to.setInterpolationWorldTransform(from.getInterpolationWorldTransform());
    to.setLinearVelocity(from.getLinearVelocity());
    to.setAngularVelocity(from.getAngularVelocity());
    to.setInterpolationLinearVelocity(from.getInterpolationLinearVelocity());
    to.setInterpolationAngularVelocity(from.getInterpolationAngularVelocity());
    to.forceActivationState(from.getActivationState());
    to.setDeactivationTime(from.getDeactivationTime());
}

pli_bounds leaf_bounds(const btDbvtNode* leaf) {
    return {from_bullet(leaf->volume.Mins()), from_bullet(leaf->volume.Maxs())};
}

// The boxes that a btSoftBody searches contacts with, as they are before the step. With soft contacts its first step
// makes the trees anew, with boxes around the bare nodes and faces; without, there is none of faces.
void copy_boxes(const btSoftBody& from, bool is_first, bool has_faces, pli_body* to) {
    std::vector<pli_bounds> nodes, faces;
    for (int i = 0; i < from.m_nodes.size(); ++i) {
        const pli_vec3 p = from_bullet(from.m_nodes[i].m_x);
        nodes.push_back(is_first && has_faces ? pli_bounds{p, p} : leaf_bounds(from.m_nodes[i].m_leaf));
    }
    for (int i = 0; has_faces && i < from.m_faces.size(); ++i) {
        if (is_first) {
            faces.push_back(empty_bounds());
            for (const btSoftBody::Node* node : from.m_faces[i].m_n) {
                extend_bounds(faces.back(), from_bullet(node->m_x));
            }
        } else {
            faces.push_back(leaf_bounds(from.m_faces[i].m_leaf));
        }
    }
    pli_body_set_bullet_boxes(to, nodes.data(), faces.data());
}

// ---------------------------------------------------------------------------------------------------- the pair

class Pair {
public:
    Pair(const Description& description, Witness witness, const EngineOptions& options)
        : description_(description), step_seconds_(static_cast<double>(options.step_seconds)),
          reference_(description, bullet_options(options, SolverKind::position_based)),
          pliant_(description, reference_options(options, witness)), matcher_(reference_, pliant_),
          diagonal_(bounds_diagonal(description.rest_bounds)) {
        pliant_.bridge().set_before_solve([this] { lone_contacts_ = matcher_.match(); });
    }
    ~Pair() { pliant_.bridge().set_before_solve(nullptr); }
    Pair(const Pair&) = delete;
    Pair& operator=(const Pair&) = delete;

    // Of this frame: error and number of contacts that only one engine made.
    struct Outcome {
        double error;
        bool is_bit_equal;
        int lone_contacts;
    };
    Outcome step() {
        for (int i = 0; i < reference_.rigids().object_count(); ++i) {
            const btRigidBody* from = reference_.rigids().body(i);
            if (from != nullptr && !from->isStaticObject()) { copy_body(*from, *pliant_.rigids().body(i)); }
        }
        for (int i = 0; i < reference_.soft_count(); ++i) {
            copy_soft(i);
        }
        is_first_ = false;
        reference_.step();
        pliant_.step();
        Outcome outcome{0.0, true, lone_contacts_};
        for (int i = 0; i < reference_.soft_count(); ++i) {
            compare_soft(i, outcome);
        }
        for (int i = 0; i < reference_.rigids().object_count(); ++i) {
            const RigidState expected = reference_.rigid(i), actual = pliant_.rigid(i);
            outcome.is_bit_equal = outcome.is_bit_equal && std::memcmp(&expected, &actual, sizeof expected) == 0;
        }
        return outcome;
    }

private:
    void copy_soft(int index) {
        const SoftState state = reference_.soft(index);
        pli_body* body = pliant_.body(index);
        const pli_status status = pli_body_set_state(body, state.positions.data(), state.velocities.data());
        if (status != PLI_OK) {
            throw Error("cannot take over the state of btSoftBody: " +
                        std::string(pli_last_error(pliant_.bridge().context())));
        }
        const scene_soft_def& def = description_.softs[static_cast<size_t>(index)].def;
        if (def.has_soft_contacts || def.has_rigid_contacts) {
            copy_boxes(reference_.body(index), is_first_, def.has_soft_contacts, body);
        }
    }

    void compare_soft(int index, Outcome& outcome) const {
        const SoftState expected = reference_.soft(index), actual = pliant_.soft(index);
        if (expected.positions.size() != actual.positions.size()) {
            throw Error("a cut leaves " + std::to_string(expected.positions.size()) + " nodes in btSoftBody and " +
                        std::to_string(actual.positions.size()) + " in Pliant");
        }
        for (size_t i = 0; i < expected.positions.size(); ++i) {
            const double dx = distance(expected.positions[i], actual.positions[i]);
            const double dv = distance(expected.velocities[i], actual.velocities[i]);
            const double error = std::max(dx, step_seconds_ * dv) / diagonal_;
            outcome.error =
                std::isfinite(error) ? std::max(outcome.error, error) : std::numeric_limits<double>::infinity();
        }
        const size_t bytes = expected.positions.size() * sizeof(pli_vec3);
        outcome.is_bit_equal = outcome.is_bit_equal && expected.link_nodes == actual.link_nodes &&
                               expected.face_nodes == actual.face_nodes &&
                               std::memcmp(expected.positions.data(), actual.positions.data(), bytes) == 0 &&
                               std::memcmp(expected.velocities.data(), actual.velocities.data(), bytes) == 0;
    }

    static double distance(pli_vec3 a, pli_vec3 b) {
        const double x = static_cast<double>(a.x) - static_cast<double>(b.x);
        const double y = static_cast<double>(a.y) - static_cast<double>(b.y);
        const double z = static_cast<double>(a.z) - static_cast<double>(b.z);
        return std::sqrt(x * x + y * y + z * z);
    }

    const Description& description_;
    double step_seconds_;
    BulletEngine reference_;
    PliantEngine pliant_;
    ContactMatcher matcher_;
    double diagonal_;
    int lone_contacts_ = 0;
    bool is_first_ = true;
};

double quantile(const std::vector<double>& sorted, double share) {
    const double place = std::ceil(share * static_cast<double>(sorted.size()));
    return sorted[static_cast<size_t>(std::max(place, 1.0)) - 1];
}

} // namespace

OneStep compare_one_step(const Description& description, int frames, const Progress& progress, Witness witness,
                         const EngineOptions& options) {
    if (frames < 1) { throw Error("a comparison needs one frame at least"); }
    if (description.softs.empty()) { throw Error("the scene has no soft bodies to compare"); }
    Pair pair(description, witness, options);
    OneStep result;
    int bit_equal = 0;
    for (int frame = 1; frame <= frames; ++frame) {
        const Pair::Outcome outcome = pair.step();
        result.errors.push_back(outcome.error);
        bit_equal += outcome.is_bit_equal ? 1 : 0;
        const bool is_above = outcome.error > error_limit, has_lone = outcome.lone_contacts > 0;
        result.frames_with_lone_contacts += has_lone ? 1 : 0;
        result.frames_above_limit += is_above ? 1 : 0;
        result.unexplained_frames += is_above && !has_lone ? 1 : 0;
        if (progress) { progress(frame, frames); }
    }
    std::vector<double> sorted = result.errors;
    std::sort(sorted.begin(), sorted.end());
    result.frames = frames;
    result.median = quantile(sorted, 0.5);
    result.p99 = quantile(sorted, 0.99);
    result.maximum = sorted.back();
    result.bit_equal_share = static_cast<double>(bit_equal) / static_cast<double>(frames);
    return result;
}

} // namespace demos
