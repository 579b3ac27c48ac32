#ifndef DEMOS_RENDER_PICTURE_H
#define DEMOS_RENDER_PICTURE_H

// Pictures of scenes, drawn with OpenGL without a display.

#include "engines/engine.h"
#include "image.h"

#include <memory>
#include <string>
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

struct Panel {
    const Snapshot* snapshot;
    std::string title;  // drawn in the corner
    std::string detail; // a second, smaller line; may be empty
};

class Painter {
public:
    // Throws demos::Error when there is no OpenGL.
    Painter();
    ~Painter();

    // Draws the panels side by side, all seen by the same camera, each `width` by `height` pixels. Throws demos::Error
    // when a snapshot has a node that is not finite.
    Image draw(const std::vector<Panel>& panels, int width, int height) const;

private:
    struct Tools; // what OpenGL needs for any picture
    std::unique_ptr<Tools> tools_;
};

} // namespace render
#endif
