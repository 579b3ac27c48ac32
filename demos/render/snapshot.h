#ifndef DEMOS_RENDER_SNAPSHOT_H
#define DEMOS_RENDER_SNAPSHOT_H

// What pictures are drawn of.

#include "engines/engine.h"

#include <vector>

namespace render {

// A scene at one moment, detached from the engine that made it.
struct Snapshot {
    const demos::Description* description;
    std::vector<demos::SoftState> softs;
    std::vector<demos::RigidState> rigids;
    std::vector<demos::RigidRecord> balls; // records of the last rigid bodies, which the description does not know
    // What is drawn on top when it is wanted, for each soft body.
    std::vector<std::vector<demos::ContactMark>> contacts;
    std::vector<std::vector<demos::ClusterMark>> clusters;

    const demos::RigidRecord& rigid_record(size_t index) const {
        const size_t described = description->rigids.size();
        return index < described ? description->rigids[index] : balls.at(index - described);
    }
};

// How soft bodies are drawn.
struct Look {
    bool mesh_lines = true; // along the edges of triangles
    bool wireframe = false; // these lines alone
    bool normals = false, contacts = false, clusters = false;
};

Snapshot take_snapshot(const demos::Engine& engine, const Look& look = {});

} // namespace render
#endif
