#include "heavy_watch.h"

#include "engines/rigid_world.h"
#include "engines/solvers.h"

#include <algorithm>

namespace demos {

namespace {

constexpr double rigid_reach = 5; // m, of a body that should lie on something

CheckedRigid checked_rigid(const Engine& engine, int index) {
    const RigidRecord& record = engine.rigid_record(index);
    CheckedRigid rigid;
    rigid.mass = static_cast<double>(record.mass);
    rigid.shape = record.shape.kind;
    const float r = record.shape.radius;
    rigid.half_extents = rigid.shape == SCENE_SHAPE_SPHERE ? pli_vec3_make(r, r, r) : record.shape.half_extents;
    if (!(rigid.mass > 0.0)) { return rigid; }
    const btVector3 inverse = engine.rigids().body(index)->getInvInertiaDiagLocal();
    rigid.inertia = pli_vec3_make(1 / inverse.x(), 1 / inverse.y(), 1 / inverse.z());
    return rigid;
}

CheckedBodies checked_bodies(const Engine& engine, Column column, const HeavyRules& rules) {
    CheckedBodies bodies;
    bodies.step_seconds = static_cast<double>(rules.step_seconds);
    if (column == Column::xpbd) { bodies.substep_seconds = bodies.step_seconds / rules.substeps; }
    bodies.gravity = engine.description().gravity;
    for (int i = 0; i < engine.rigid_count(); ++i) {
        bodies.rigids.push_back(checked_rigid(engine, i));
    }
    const bool has_springs = column != Column::bt_soft_body && column != Column::position_based;
    for (const SoftRecord& soft : engine.description().softs) {
        bodies.link_stiffness.push_back(has_springs ? link_stiffness(soft) : 0.0);
    }
    return bodies;
}

CheckedState state_of(const Engine& engine) {
    CheckedState state;
    for (size_t i = 0; i < engine.description().softs.size(); ++i) {
        state.softs.push_back(engine.soft(static_cast<int>(i)));
    }
    for (int i = 0; i < engine.rigid_count(); ++i) {
        state.rigids.push_back(engine.rigid(i));
    }
    return state;
}

class HeavyWatcher final : public Watcher {
public:
    explicit HeavyWatcher(const HeavyRules& rules) : rules_(rules) {}

    void start(const Engine& engine, Column column) override {
        const CheckedBodies bodies = checked_bodies(engine, column, rules_);
        add_checks(bodies, engine.description());
        before_ = state_of(engine);
        for (const CheckPointer& check : checks_) {
            check->start(before_);
        }
    }

    void after_step(const Engine& engine, int step) override {
        CheckedState now = state_of(engine);
        const CheckedStep checked{before_, now, step * static_cast<double>(rules_.step_seconds)};
        for (const CheckPointer& check : checks_) {
            check->after_step(checked);
        }
        before_ = std::move(now);
    }

    bool is_decided() const override {
        return std::any_of(checks_.begin(), checks_.end(), [](const CheckPointer& each) { return each->is_decided(); });
    }

    Finding end(const Engine&) override { return sum_up(checks_); }

private:
    // The worst first.
    void add_checks(const CheckedBodies& bodies, const Description& description) {
        if (rules_.has_passage) { checks_.push_back(check_passage(bodies, rules_.lying)); }
        if (description.motions.empty()) {
            checks_.push_back(check_reach(rigid_reach));
            checks_.push_back(check_energy(bodies));
        }
        if (rules_.never_higher >= 0) { checks_.push_back(check_height(rules_.never_higher)); }
        if (rules_.has_fast_anchors) { checks_.push_back(check_anchors(description.softs[0].anchors)); }
        if (rules_.stays_from >= 0.0) { checks_.push_back(check_place(rules_.stays, rules_.stays_from)); }
        if (rules_.rests) { checks_.push_back(check_rest(bodies, rules_.seconds)); }
        checks_.push_back(measure_stretch(rules_.figure_from));
    }

    HeavyRules rules_;
    std::vector<CheckPointer> checks_;
    CheckedState before_;
};

} // namespace

std::function<std::unique_ptr<Watcher>()> watch_heavy(const HeavyRules& rules) {
    return [rules] { return std::make_unique<HeavyWatcher>(rules); };
}

} // namespace demos
