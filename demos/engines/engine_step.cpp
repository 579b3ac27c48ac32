// How a scene begins and how it makes a step, the same in both engines.

#include "rigid_world.h"
#include "stopwatch.h"

namespace demos {

void Engine::add_bodies() {
    size_t next_rigid = 0;
    for (const SoftRecord& soft : description_.softs) {
        while (next_rigid < static_cast<size_t>(soft.order)) {
            rigids().add(description_.rigids[next_rigid++]);
        }
        add_soft(soft);
    }
    while (next_rigid < description_.rigids.size()) {
        rigids().add(description_.rigids[next_rigid++]);
    }
}

void Engine::step() {
    const Stopwatch watch;
    clock_.advance();
    drive_.advance(clock_.frame());
    prepare_step();
    rigids().move(description_, clock_.seconds());
    for (const CutRecord& cut : description_.cuts) {
        if (clock_.begins(cut.frame)) { cut_sphere(cut.soft, node_position(cut.soft, cut.node), cut.radius); }
    }
    rigids().clock().start_step();
    rigids().world().stepSimulation(options_.step_seconds, 0);
    milliseconds_ = watch.milliseconds();
    check_step();
}

const StepTimes& Engine::step_times() const {
    return rigids().clock().times();
}

int Engine::rigid_count() const {
    return rigids().object_count();
}

RigidState Engine::rigid(int index) const {
    return rigids().state(index);
}

const RigidRecord& Engine::rigid_record(int index) const {
    return rigids().record(index);
}

} // namespace demos
