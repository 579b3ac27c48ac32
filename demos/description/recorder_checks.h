#ifndef DEMOS_RECORDER_CHECKS_H
#define DEMOS_RECORDER_CHECKS_H

// What the functions behind scene_builder.h check. They throw Error.

#include "finite.h"
#include "recorder.h"

#include <cmath>

namespace demos {

inline void require(bool condition, const std::string& message) {
    if (!condition) { throw Error(message); }
}

inline bool is_positive(float value) {
    return value > 0.0f && std::isfinite(value);
}

inline int checked_index(int index, size_t count, const std::string& what) {
    require(index >= 0 && static_cast<size_t>(index) < count,
            "there is no " + what + " " + std::to_string(index) + ", the scene has " + std::to_string(count) + " yet");
    return index;
}

inline SoftRecord& soft_record(scene_builder* builder, int soft) {
    std::vector<SoftRecord>& softs = builder->description.softs;
    return softs[static_cast<size_t>(checked_index(soft, softs.size(), "soft body"))];
}

inline int checked_node(const SoftRecord& record, int node) {
    const int count = pli_mesh_get_view(record.mesh.get()).node_count;
    require(node >= 0 && node < count, record.name + ": node " + std::to_string(node) +
                                           " is out of range, the mesh has " + std::to_string(count) + " nodes");
    return node;
}

} // namespace demos
#endif
