#include "picture.h"

#include "context.h"
#include "renderer.h"

#include <memory>

namespace render {

struct Painter::Tools {
    Context context; // first, as the renderer needs it
    Renderer renderer{fine_shadows};
};

Painter::Painter() : tools_(std::make_unique<Tools>()) {}

Painter::~Painter() = default;

Image Painter::draw(const std::vector<Panel>& panels, int width, int height) const {
    std::vector<Extent> extents;
    for (const Panel& panel : panels) {
        extents.push_back(measure_extent(*panel.snapshot));
    }
    const View view = make_view(extents);
    if (view.points.empty()) { throw demos::Error("no picture of a scene without soft bodies"); }
    const Camera camera = choose_camera(*panels.front().snapshot->description, view,
                                        static_cast<float>(width) / static_cast<float>(height));
    const Canvas canvas(width, height, 2); // twice the size: lines and edges come out finer
    Image image(width * static_cast<int>(panels.size()), height);
    for (size_t i = 0; i < panels.size(); ++i) {
        tools_->renderer.draw(canvas, *panels[i].snapshot, extents[i], view, camera, {});
        if (!panels[i].title.empty()) { tools_->renderer.draw_caption(canvas, panels[i].title, panels[i].detail); }
        image.paste(canvas.read(), width * static_cast<int>(i), 0);
    }
    return image;
}

} // namespace render
