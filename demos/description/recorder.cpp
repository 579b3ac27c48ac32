#include "recorder.h"

#include <cmath>
#include <limits>

namespace demos {

RecordedDescription::RecordedDescription() {
    if (pli_context_create(nullptr, &context) != PLI_OK) { throw Error("out of memory"); }
}

RecordedDescription::~RecordedDescription() {
    softs.clear(); // the meshes belong to the context
    pli_context_destroy(context);
}

pli_bounds empty_bounds() {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
}

void extend_bounds(pli_bounds& bounds, pli_vec3 p) {
    bounds.min = {std::fmin(bounds.min.x, p.x), std::fmin(bounds.min.y, p.y), std::fmin(bounds.min.z, p.z)};
    bounds.max = {std::fmax(bounds.max.x, p.x), std::fmax(bounds.max.y, p.y), std::fmax(bounds.max.z, p.z)};
}

double bounds_diagonal(const pli_bounds& bounds) {
    const double x = static_cast<double>(bounds.max.x) - static_cast<double>(bounds.min.x);
    const double y = static_cast<double>(bounds.max.y) - static_cast<double>(bounds.min.y);
    const double z = static_cast<double>(bounds.max.z) - static_cast<double>(bounds.min.z);
    return std::sqrt(x * x + y * y + z * z);
}

static void describe(scene_builder& builder, const scene& which) {
    RecordedDescription& description = builder.description;
    description.source = &which;
    which.build(&builder);
    if (!builder.error.empty()) { throw Error(std::string("scene ") + which.name + ": " + builder.error); }
    if (builder.options.self_collision.has_value() && !description.has_self_collision) {
        throw Error(std::string("scene ") + which.name + " has no self-collision that could be chosen");
    }
    description.rest_bounds = empty_bounds();
    for (const SoftRecord& soft : description.softs) {
        const pli_mesh_view view = pli_mesh_get_view(soft.mesh.get());
        for (int i = 0; i < view.node_count; ++i) {
            extend_bounds(description.rest_bounds, view.positions[i]);
        }
    }
}

std::unique_ptr<Description> Description::build(const scene& which, const SceneOptions& options) {
    const std::string name = which.name;
    if (!options.mesh_file.empty() && !which.takes_mesh) {
        throw Error("scene " + name + " has no triangle mesh that a file could replace");
    }
    if (!options.tetra_base.empty() && !which.takes_tetra) {
        throw Error("scene " + name + " has no tetrahedral mesh that a file could replace");
    }
    if (options.resolution.columns > 0 && !which.takes_resolution) {
        throw Error("scene " + name + " has no grid whose resolution could be chosen");
    }
    auto description = std::make_unique<RecordedDescription>();
    scene_builder builder{*description, options, {}};
    describe(builder, which);
    return description;
}

} // namespace demos

void scene_builder::guard(const std::function<void()>& action) {
    if (!error.empty()) { return; }
    try {
        action();
    } catch (const std::exception& failure) { error = failure.what(); }
}
