#include "snapshot.h"

namespace render {

Snapshot take_snapshot(const demos::Engine& engine, const Look& look) {
    Snapshot snapshot{&engine.description(), {}, {}, {}, {}, {}};
    const int soft_count = engine.soft_count(), rigid_count = engine.rigid_count();
    for (int i = 0; i < soft_count; ++i) {
        snapshot.softs.push_back(engine.soft(i));
        if (look.contacts) { snapshot.contacts.push_back(engine.contacts(i)); }
        if (look.clusters) { snapshot.clusters.push_back(engine.clusters(i)); }
    }
    for (int i = 0; i < rigid_count; ++i) {
        snapshot.rigids.push_back(engine.rigid(i));
        if (static_cast<size_t>(i) >= snapshot.description->rigids.size()) {
            snapshot.balls.push_back(engine.rigid_record(i));
        }
    }
    return snapshot;
}

} // namespace render
