#ifndef DEMOS_RENDER_PICTURE_H
#define DEMOS_RENDER_PICTURE_H

// Pictures of scenes, drawn with OpenGL without a display.

#include "image.h"
#include "snapshot.h"

#include <memory>
#include <string>
#include <vector>

namespace render {

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
