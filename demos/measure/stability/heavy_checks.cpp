#include "heavy_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace demos {

namespace {

// ------------------------------------------------------------------------------------------------------ vectors

double distance(pli_vec3 a, pli_vec3 b) {
    const pli_vec3 d = pli_vec3_sub(b, a);
    return std::sqrt(dot(d, d));
}

pli_vec3 halfway(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_scale(pli_vec3_add(a, b), 0.5f);
}

pli_vec3 into_frame(const pli_transform& pose, pli_vec3 v) {
    const pli_vec3* r = pose.rotation.rows;
    return pli_vec3_make(r[0].x * v.x + r[1].x * v.y + r[2].x * v.z, r[0].y * v.x + r[1].y * v.y + r[2].y * v.z,
                         r[0].z * v.x + r[1].z * v.y + r[2].z * v.z);
}

pli_vec3 out_of_frame(const pli_transform& pose, pli_vec3 v) {
    const pli_vec3* r = pose.rotation.rows;
    return pli_vec3_make(pli_vec3_dot(r[0], v), pli_vec3_dot(r[1], v), pli_vec3_dot(r[2], v));
}

template <class... Values> std::string text_of(const char* format, Values... values) {
    char text[160];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

// J, without the motion of the centre.
double rotation_energy(const CheckedRigid& rigid, const RigidState& state) {
    const pli_vec3 w = into_frame(state.pose, state.angular_velocity);
    return 0.5 * dot(pli_vec3_make(rigid.inertia.x * w.x, rigid.inertia.y * w.y, rigid.inertia.z * w.z), w);
}

double link_length(const SoftState& state, size_t link) {
    return distance(state.positions[static_cast<size_t>(state.link_nodes[2 * link])],
                    state.positions[static_cast<size_t>(state.link_nodes[2 * link + 1])]);
}

// ------------------------------------------------------------------------------------------------------- energy

constexpr double largest_gain = 0.02; // of the work of gravity
constexpr double lost_gain = 10;      // of the same: nothing is left to be learned from such a run
constexpr double slack = 1e-4;        // m, that contacts may lift everything beside

struct Energies {
    double kinetic = 0, gravity = 0, springs = 0, weight = 0; // J; the last in N
    double sum() const { return kinetic + gravity + springs; }
};

class EnergyCheck final : public Check {
public:
    explicit EnergyCheck(const CheckedBodies& bodies) : bodies_(bodies) {}

    void start(const CheckedState& state) override {
        CheckedState before = state; // had it moved as fast before
        for (SoftState& soft : before.softs) {
            for (size_t i = 0; i < soft.positions.size(); ++i) {
                soft.positions[i] = before_step(soft.positions[i], soft.velocities[i]);
            }
        }
        for (RigidState& rigid : before.rigids) {
            rigid.pose.origin = before_step(rigid.pose.origin, rigid.linear_velocity);
        }
        start_ = energies(before, state);
    }

    void after_step(const CheckedStep& step) override {
        const Energies now = energies(step.before, step.now);
        work_ = std::max(work_, start_.gravity - now.gravity);
        const double excess = now.sum() - start_.sum();
        if (excess <= largest_gain * work_ + slack * start_.weight || excess <= worst_) { return; }
        worst_ = excess;
        note_ = text_of("gains %.3g J (motion %.3g J, springs %.3g J), gravity did %.3g J, at %.2f s", excess,
                        now.kinetic, now.springs, work_, step.seconds);
    }

    bool is_decided() const override { return worst_ > lost_gain * (work_ + slack * start_.weight); }

    Finding finding() const override { return {note_.empty() ? Verdict::survives : Verdict::gains_energy, -1, note_}; }

private:
    pli_vec3 before_step(pli_vec3 position, pli_vec3 velocity) const {
        return pli_vec3_sub(position, pli_vec3_scale(velocity, static_cast<float>(bodies_.step_seconds)));
    }

    // Positions of a step and its motion hold at the same time in its middle: a free fall keeps this sum to rounding.
    Energies energies(const CheckedState& before, const CheckedState& now) const {
        Energies sum;
        const auto add = [&](double mass, pli_vec3 position, pli_vec3 velocity) {
            sum.kinetic += 0.5 * mass * dot(velocity, velocity);
            sum.gravity -= mass * dot(bodies_.gravity, position);
            sum.weight += mass * std::sqrt(dot(bodies_.gravity, bodies_.gravity));
        };
        const auto rate = static_cast<float>(1 / bodies_.step_seconds);
        for (size_t i = 0; i < now.softs.size(); ++i) {
            const SoftState &from = before.softs[i], &to = now.softs[i];
            for (size_t node = 0; node < to.positions.size(); ++node) {
                if (!(to.inverse_masses[node] > 0.0f)) { continue; }
                add(1.0 / static_cast<double>(to.inverse_masses[node]),
                    halfway(from.positions[node], to.positions[node]),
                    pli_vec3_scale(pli_vec3_sub(to.positions[node], from.positions[node]), rate));
            }
            if (bodies_.link_stiffness[i] > 0.0) { sum.springs += springs(bodies_.link_stiffness[i], from, to); }
        }
        for (size_t i = 0; i < now.rigids.size(); ++i) {
            if (!(bodies_.rigids[i].mass > 0.0)) { continue; }
            const pli_vec3 from = before.rigids[i].pose.origin, to = now.rigids[i].pose.origin;
            add(bodies_.rigids[i].mass, halfway(from, to), pli_vec3_scale(pli_vec3_sub(to, from), rate));
            sum.kinetic += rotation_energy(bodies_.rigids[i], now.rigids[i]);
        }
        return sum;
    }

    double springs(double stiffness, const SoftState& before, const SoftState& now) const {
        const double square = bodies_.substep_seconds * bodies_.substep_seconds;
        double sum = 0;
        for (size_t link = 0; link < now.rest_lengths.size(); ++link) {
            const auto a = static_cast<size_t>(now.link_nodes[2 * link]);
            const auto b = static_cast<size_t>(now.link_nodes[2 * link + 1]);
            const double length = distance(halfway(before.positions[a], now.positions[a]),
                                           halfway(before.positions[b], now.positions[b]));
            const double stretch = length - static_cast<double>(now.rest_lengths[link]);
            const auto weight = static_cast<double>(now.inverse_masses[a]) + static_cast<double>(now.inverse_masses[b]);
            sum += 0.5 * stretch * stretch / (1 / stiffness + weight * square);
        }
        return sum;
    }

    CheckedBodies bodies_;
    Energies start_;
    double work_ = 0, worst_ = 0;
    std::string note_;
};

class HeightCheck final : public Check {
public:
    explicit HeightCheck(int rigid) : rigid_(static_cast<size_t>(rigid)) {}

    void start(const CheckedState& state) override { start_ = height(state); }
    void after_step(const CheckedStep& step) override { rise_ = std::max(rise_, height(step.now) - start_); }
    Finding finding() const override {
        if (rise_ <= most_rise) { return {}; }
        return {Verdict::gains_energy, -1, text_of("rises %.3g m above its start", rise_)};
    }

private:
    static constexpr double most_rise = 0.001; // m
    double height(const CheckedState& state) const { return static_cast<double>(state.rigids[rigid_].pose.origin.y); }

    size_t rigid_;
    double start_ = 0, rise_ = 0;
};

// ---------------------------------------------------------------------------------------------- passing through

constexpr double deep = 0.15; // m

// m, how far a point is below the surface; < 0: outside.
double depth(const CheckedRigid& rigid, const pli_transform& pose, pli_vec3 point) {
    if (rigid.shape == SCENE_SHAPE_SPHERE) {
        return static_cast<double>(rigid.half_extents.x) - distance(pose.origin, point);
    }
    const pli_vec3 p = into_frame(pose, pli_vec3_sub(point, pose.origin));
    return static_cast<double>(std::min({rigid.half_extents.x - std::fabs(p.x), rigid.half_extents.y - std::fabs(p.y),
                                         rigid.half_extents.z - std::fabs(p.z)}));
}

double smallest(pli_vec3 v) {
    return static_cast<double>(std::min({v.x, v.y, v.z}));
}

class PassageCheck final : public Check {
public:
    PassageCheck(const CheckedBodies& bodies, int lying) : bodies_(bodies), lying_(lying) {}

    void after_step(const CheckedStep& step) override {
        if (is_decided()) { return; }
        if (lying_ >= 0 && is_below(step.now)) {
            note_ = text_of("its centre is below the cloth at %.2f s", step.seconds);
        }
        for (size_t i = 0; i < step.now.rigids.size(); ++i) {
            const double deepest = deepest_node(step.now, i);
            if (deepest > std::min(deep, 0.5 * smallest(bodies_.rigids[i].half_extents))) {
                note_ = text_of("a node is %.3g m deep in rigid body %d at %.2f s", deepest, static_cast<int>(i),
                                step.seconds);
            }
        }
    }
    bool is_decided() const override { return !note_.empty(); }
    Finding finding() const override { return {is_decided() ? Verdict::passes_through : Verdict::survives, -1, note_}; }

private:
    bool is_below(const CheckedState& state) const {
        const auto index = static_cast<size_t>(lying_);
        const pli_vec3 center = state.rigids[index].pose.origin, half = bodies_.rigids[index].half_extents;
        const float near = std::max(half.x, half.z);
        int near_nodes = 0;
        for (const SoftState& soft : state.softs) {
            for (const pli_vec3 p : soft.positions) {
                if (std::hypot(p.x - center.x, p.z - center.z) > near) { continue; }
                if (p.y <= center.y) { return false; }
                ++near_nodes;
            }
        }
        return near_nodes > 0;
    }

    double deepest_node(const CheckedState& state, size_t rigid) const {
        double deepest = -1;
        for (const SoftState& soft : state.softs) {
            for (const pli_vec3 p : soft.positions) {
                deepest = std::max(deepest, depth(bodies_.rigids[rigid], state.rigids[rigid].pose, p));
            }
        }
        return deepest;
    }

    CheckedBodies bodies_;
    int lying_;
    std::string note_;
};

class ReachCheck final : public Check {
public:
    explicit ReachCheck(double most) : most_(most) {}

    void start(const CheckedState& state) override { start_ = state.rigids; }
    void after_step(const CheckedStep& step) override {
        for (size_t i = 0; i < start_.size(); ++i) {
            farthest_ = std::max(farthest_, distance(start_[i].pose.origin, step.now.rigids[i].pose.origin));
        }
    }
    bool is_decided() const override { return farthest_ > most_; }
    Finding finding() const override {
        if (!is_decided()) { return {}; }
        return {Verdict::out_of_reach, -1, text_of("a rigid body is %.3g m from its start", farthest_)};
    }

private:
    double most_, farthest_ = 0;
    std::vector<RigidState> start_;
};

// --------------------------------------------------------------------------------------------------------- rest

class RestCheck final : public Check {
public:
    RestCheck(const CheckedBodies& bodies, double seconds) : bodies_(bodies), from_(seconds - 1) {}

    void start(const CheckedState& state) override { squares_.assign(state.softs.size() + state.rigids.size(), 0.0); }

    void after_step(const CheckedStep& step) override {
        if (step.seconds < from_) { return; }
        ++steps_;
        for (size_t i = 0; i < step.now.softs.size(); ++i) {
            squares_[i] += soft_square(step.before.softs[i], step.now.softs[i]);
        }
        for (size_t i = 0; i < step.now.rigids.size(); ++i) {
            const CheckedRigid& rigid = bodies_.rigids[i];
            if (!(rigid.mass > 0.0)) { continue; }
            const RigidState& now = step.now.rigids[i];
            squares_[step.now.softs.size() + i] += speed_square(step.before.rigids[i].pose.origin, now.pose.origin) +
                                                   2 * rotation_energy(rigid, now) / rigid.mass;
        }
    }

    Finding finding() const override {
        const double largest = squares_.empty() ? 0 : *std::max_element(squares_.begin(), squares_.end());
        const double speed = std::sqrt(largest / std::max(steps_, 1));
        if (speed <= most_speed) { return {}; }
        return {Verdict::never_rests, -1, text_of("moves at %.2g m/s", speed)};
    }

private:
    static constexpr double most_speed = 0.001; // m/s

    double speed_square(pli_vec3 from, pli_vec3 to) const {
        const double speed = distance(from, to) / bodies_.step_seconds;
        return speed * speed;
    }
    // Mean over the nodes that are not pinned.
    double soft_square(const SoftState& before, const SoftState& now) const {
        double sum = 0;
        int count = 0;
        for (size_t node = 0; node < now.positions.size(); ++node) {
            if (!(now.inverse_masses[node] > 0.0f)) { continue; }
            sum += speed_square(before.positions[node], now.positions[node]);
            ++count;
        }
        return count > 0 ? sum / count : 0;
    }

    CheckedBodies bodies_;
    double from_;
    int steps_ = 0;
    std::vector<double> squares_; // soft bodies, then rigid ones; sums over steps
};

class PlaceCheck final : public Check {
public:
    PlaceCheck(const Lasting& what, double seconds) : what_(what), from_(seconds) {}

    void after_step(const CheckedStep& step) override {
        if (step.seconds < from_) { return; }
        const pli_vec3 place = place_in(step.now);
        if (!has_start_) { start_ = place; }
        has_start_ = true;
        farthest_ = std::max(farthest_, distance(start_, place));
    }

    Finding finding() const override {
        const double figure = has_start_ ? 1000 * farthest_ : -1;
        if (farthest_ <= most_way) { return {Verdict::survives, figure, ""}; }
        return {Verdict::wanders, figure, text_of("moves by %.3g mm", figure)};
    }

private:
    static constexpr double most_way = 0.01; // m

    pli_vec3 place_in(const CheckedState& state) const {
        if (what_.rigid >= 0) { return state.rigids[static_cast<size_t>(what_.rigid)].pose.origin; }
        double sum[3] = {};
        const std::vector<pli_vec3>& positions = state.softs[static_cast<size_t>(what_.soft)].positions;
        for (const pli_vec3 p : positions) {
            sum[0] += static_cast<double>(p.x);
            sum[1] += static_cast<double>(p.y);
            sum[2] += static_cast<double>(p.z);
        }
        const auto count = static_cast<double>(positions.size());
        return pli_vec3_make(static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count),
                             static_cast<float>(sum[2] / count));
    }

    Lasting what_;
    double from_, farthest_ = 0;
    bool has_start_ = false;
    pli_vec3 start_{};
};

// ----------------------------------------------------------------------------------------------------- anchors

class AnchorCheck final : public Check {
public:
    explicit AnchorCheck(const std::vector<AnchorRecord>& anchors) : anchors_(anchors) {}

    void start(const CheckedState& state) override {
        for (const AnchorRecord& anchor : anchors_) {
            const pli_transform& pose = state.rigids[static_cast<size_t>(anchor.rigid)].pose;
            points_.push_back(into_frame(pose, pli_vec3_sub(node_of(state, anchor), pose.origin)));
        }
    }
    void after_step(const CheckedStep& step) override {
        for (size_t i = 0; i < anchors_.size(); ++i) {
            const pli_transform& pose = step.now.rigids[static_cast<size_t>(anchors_[i].rigid)].pose;
            const pli_vec3 point = pli_vec3_add(pose.origin, out_of_frame(pose, points_[i]));
            const double lag = distance(point, node_of(step.now, anchors_[i]));
            if (lag <= lag_) { continue; }
            lag_ = lag;
            seconds_ = step.seconds;
        }
    }
    Finding finding() const override {
        if (lag_ <= most_lag) { return {Verdict::survives, 1000 * lag_, ""}; }
        return {Verdict::lags, 1000 * lag_, text_of("%.3g mm behind at %.2f s", 1000 * lag_, seconds_)};
    }

private:
    static constexpr double most_lag = 0.001; // m

    static pli_vec3 node_of(const CheckedState& state, const AnchorRecord& anchor) {
        return state.softs[0].positions[static_cast<size_t>(anchor.node)];
    }

    std::vector<AnchorRecord> anchors_; // of soft body 0
    std::vector<pli_vec3> points_;      // in the frames of the rigid bodies
    double lag_ = 0, seconds_ = 0;
};

class StretchFigure final : public Check {
public:
    explicit StretchFigure(double seconds) : from_(seconds) {}

    void after_step(const CheckedStep& step) override {
        if (step.seconds < from_) { return; }
        largest_ = std::max(largest_, 0.0);
        for (const SoftState& soft : step.now.softs) {
            for (size_t link = 0; link < soft.rest_lengths.size(); ++link) {
                const auto rest = static_cast<double>(soft.rest_lengths[link]);
                if (rest > 0.0) { largest_ = std::max(largest_, 100 * (link_length(soft, link) / rest - 1)); }
            }
        }
    }
    Finding finding() const override { return {Verdict::survives, largest_, ""}; }

private:
    double from_, largest_ = -1;
};

} // namespace

CheckPointer check_energy(const CheckedBodies& bodies) {
    return std::make_unique<EnergyCheck>(bodies);
}

CheckPointer check_height(int rigid) {
    return std::make_unique<HeightCheck>(rigid);
}

CheckPointer check_passage(const CheckedBodies& bodies, int lying) {
    return std::make_unique<PassageCheck>(bodies, lying);
}

CheckPointer check_reach(double distance) {
    return std::make_unique<ReachCheck>(distance);
}

CheckPointer check_rest(const CheckedBodies& bodies, double seconds) {
    return std::make_unique<RestCheck>(bodies, seconds);
}

CheckPointer check_place(const Lasting& what, double seconds) {
    return std::make_unique<PlaceCheck>(what, seconds);
}

CheckPointer check_anchors(const std::vector<AnchorRecord>& anchors) {
    return std::make_unique<AnchorCheck>(anchors);
}

CheckPointer measure_stretch(double seconds) {
    return std::make_unique<StretchFigure>(seconds);
}

Finding sum_up(const std::vector<CheckPointer>& checks) {
    Finding sum;
    for (const CheckPointer& check : checks) {
        const Finding finding = check->finding();
        if (sum.figure < 0.0) { sum.figure = finding.figure; }
        if (finding.verdict == Verdict::survives) { continue; }
        if (sum.verdict == Verdict::survives) { sum.verdict = finding.verdict; }
        sum.note += (sum.note.empty() ? "" : ", ") + finding.note;
    }
    return sum;
}

} // namespace demos
