// A run under the profile hook, and the lists of features of its bodies at the end.

#include "costs.h"

#include "core_modules.h"
#include "engines/pliant_engine.h"
#include "engines/stage_clock.h"

#include <algorithm>

namespace demos {

namespace {

std::vector<pli_feature_cost> features_of(const pli_body* body) {
    std::vector<pli_feature_cost> features(static_cast<size_t>(pli_body_get_features(body, 0, nullptr)));
    pli_body_get_features(body, static_cast<int>(features.size()), features.data());
    return features;
}

FeatureCost* find(std::vector<FeatureCost>& features, const std::string& name) {
    const auto found =
        std::find_if(features.begin(), features.end(), [&](const FeatureCost& each) { return each.name == name; });
    return found != features.end() ? &*found : nullptr;
}

void add_features(const pli_body* body, SceneCosts& costs) {
    for (const pli_feature_cost& feature : features_of(body)) {
        FeatureCost* sum = find(costs.features, feature.name);
        if (sum == nullptr) {
            costs.features.push_back({feature.name, true, feature.has_passes, 0, 0, 0.0});
            sum = &costs.features.back();
        }
        sum->is_needed = sum->is_needed && feature.is_needed;
        sum->bodies += 1;
        sum->bytes += feature.bytes;
    }
}

// ------------------------------------------------------------------------------------------------------ linked size

// As the bridge makes them in exact mode.
void add_shape(const Shape& shape, std::vector<std::string>& functions) {
    switch (shape.kind) {
    case SCENE_SHAPE_BOX:
        functions.emplace_back("pli_shape_create_box");
        break;
    case SCENE_SHAPE_SPHERE:
        functions.emplace_back("pli_shape_create_sphere");
        break;
    case SCENE_SHAPE_CAPSULE:
        functions.emplace_back("pli_shape_create_capsule");
        break;
    case SCENE_SHAPE_CYLINDER:
        functions.emplace_back("pli_shape_create_cylinder");
        break;
    case SCENE_SHAPE_TRIANGLE_MESH:
        functions.emplace_back(shape.is_solid ? "pli_shape_create_sampled_mesh" : "pli_shape_create_triangle_mesh");
        break;
    case SCENE_SHAPE_COMPOUND:
        for (const Shape& child : shape.children) {
            add_shape(child, functions);
        }
        break;
    }
}

// What a program calls that makes a scene like this from meshes of its own, beside what turns features on.
std::vector<std::string> calls_of(const Description& description) {
    std::vector<std::string> functions{"pli_context_create", "pli_world_create", "pli_world_step",
                                       "pli_mesh_create",    "pli_body_create",  "pli_rigid_create"};
    for (const RigidRecord& rigid : description.rigids) {
        add_shape(rigid.shape, functions);
    }
    for (const SoftRecord& soft : description.softs) {
        if (!soft.def.has_clusters) { continue; }
        functions.emplace_back(soft.def.cluster_count > 0 ? "pli_body_generate_clusters"
                                                          : "pli_body_generate_clusters_from_elements");
    }
    for (const JointRecord& joint : description.joints) {
        functions.emplace_back(joint.is_angular ? "pli_body_add_angular_joint" : "pli_body_add_linear_joint");
    }
    if (!description.cuts.empty()) { functions.emplace_back("pli_body_refine"); }
    return functions;
}

void link(const Description& description, SceneCosts& costs) {
    std::vector<std::string> features;
    for (const FeatureCost& feature : costs.features) {
        features.push_back(feature.name);
    }
    LinkedCore linked = linked_core(calls_of(description), features);
    costs.linked_bytes = linked.bytes;
    costs.core_bytes = core_bytes();
    costs.linked_modules = std::move(linked.modules);
}

constexpr const char* stage_order[] = {"forces",      "predict",      "update",  "collide",  "joint prepare",
                                       "joint solve", "joint finish", "prepare", "velocity", "position",
                                       "drift",       "finish",       "solve",   "refresh"};

ptrdiff_t place_of(const std::string& stage) {
    return std::find_if(std::begin(stage_order), std::end(stage_order),
                        [&](const char* each) { return stage == each; }) -
           std::begin(stage_order);
}

} // namespace

SceneCosts measure_costs(const Description& description, const EngineOptions& options, int frames,
                         const Progress& progress) {
    PliantEngine engine(description, options);
    StageClock clock;
    pli_world_set_profile(engine.bridge().world(), StageClock::on_part, &clock);
    for (int frame = 1; frame <= frames; ++frame) {
        engine.step();
        if (progress) { progress(frame, frames); }
    }
    SceneCosts costs;
    for (int i = 0; i < engine.soft_count(); ++i) {
        costs.nodes += pli_body_get_view(engine.body(i)).node_count;
        costs.bytes += pli_body_bytes(engine.body(i));
        add_features(engine.body(i), costs);
    }
    for (const auto& [part, milliseconds] : clock.take()) {
        const auto& [stage, feature] = part;
        const double microseconds = milliseconds * 1000.0 / frames;
        costs.passes.push_back({stage, feature != nullptr ? feature : "", microseconds});
        costs.microseconds += microseconds;
        if (FeatureCost* sum = find(costs.features, costs.passes.back().feature)) { sum->microseconds += microseconds; }
    }
    std::stable_sort(costs.passes.begin(), costs.passes.end(),
                     [](const StageCost& a, const StageCost& b) { return place_of(a.stage) < place_of(b.stage); });
    for (const std::string& name : core_features()) {
        if (find(costs.features, name) == nullptr) { costs.left_out.push_back(name); }
    }
    link(description, costs);
    return costs;
}

} // namespace demos
