#ifndef DEMOS_RECORDER_H
#define DEMOS_RECORDER_H

// Behind scene_builder.h: turns the calls of a scene into a Description.

#include "description.h"

#include <functional>

namespace demos {

class RecordedDescription final : public Description {
public:
    RecordedDescription();
    ~RecordedDescription() override;

    pli_context* context = nullptr;
};

// The triangles that scene_triangle_mesh knows, or the file in their place. Throws Error.
MeshPointer make_named_mesh(pli_context* context, const std::string& name, const std::string& mesh_file);

// The same for the tetrahedra that scene_tetra_mesh knows.
MeshPointer make_named_tetra_mesh(pli_context* context, const std::string& name, const std::string& base);

pli_bounds empty_bounds();
void extend_bounds(pli_bounds& bounds, pli_vec3 point);
double bounds_diagonal(const pli_bounds& bounds);

} // namespace demos

struct scene_builder {
    demos::RecordedDescription& description;
    const demos::SceneOptions& options;
    std::string error; // the first thing that went wrong; empty: nothing yet

    // Scenes are C: no exception may pass through them.
    void guard(const std::function<void()>& action);
};

#endif
