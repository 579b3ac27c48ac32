// A run under the profile hook, and the lists of features of its bodies at the end.

#include "costs.h"

#include "pliant_engine.h"
#include "stage_clock.h"

#include <algorithm>

namespace demos {

namespace {

// All that a body can have, by the names that it is listed with.
constexpr const char* all_features[] = {"links",
                                        "colored links",
                                        "velocity links",
                                        "anchors",
                                        "joints",
                                        "rigid_contacts",
                                        "rigid_face_contacts",
                                        "soft_contacts",
                                        "clusters",
                                        "cluster contacts",
                                        "vertex aerodynamics",
                                        "face aerodynamics",
                                        "pressure",
                                        "volume",
                                        "pose matching",
                                        "forces",
                                        "normals",
                                        "face normals",
                                        "areas",
                                        "link graph",
                                        "link colors",
                                        "self-collision of nodes",
                                        "self-collision by two grids",
                                        "self-collision of faces",
                                        "cut trace",
                                        "implicit solver",
                                        "XPBD solver",
                                        "XPBD links",
                                        "XPBD bending",
                                        "XPBD tetrahedra",
                                        "XPBD volume",
                                        "XPBD anchors",
                                        "XPBD rigid contacts",
                                        "XPBD soft contacts"};

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
    for (const char* name : all_features) {
        if (find(costs.features, name) == nullptr) { costs.left_out.emplace_back(name); }
    }
    return costs;
}

} // namespace demos
