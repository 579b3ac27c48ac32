#include "measure.h"

#include "description/finite.h"
#include "engines/components.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace demos {

namespace {

// FNV-1a over the bits of floats.
void hash_vector(uint64_t& hash, pli_vec3 v) {
    unsigned char bytes[3 * sizeof(float)];
    std::memcpy(bytes, &v.x, sizeof(float));
    std::memcpy(bytes + sizeof(float), &v.y, sizeof(float));
    std::memcpy(bytes + 2 * sizeof(float), &v.z, sizeof(float));
    for (const unsigned char byte : bytes) {
        hash = (hash ^ byte) * 1099511628211u;
    }
}

double length_squared(pli_vec3 v) {
    const double x = static_cast<double>(v.x), y = static_cast<double>(v.y), z = static_cast<double>(v.z);
    return x * x + y * y + z * z;
}

// Adds squares to `rms_speed`, and returns how many.
int measure_nodes(const SoftState& state, Measures& measures) {
    int moving = 0;
    for (size_t i = 0; i < state.positions.size(); ++i) {
        measures.finite = measures.finite && is_finite(state.positions[i]) && is_finite(state.velocities[i]);
        if (state.inverse_masses[i] > 0.0f) {
            measures.rms_speed += length_squared(state.velocities[i]);
            ++moving;
            measures.kinetic_energy +=
                0.5 * length_squared(state.velocities[i]) / static_cast<double>(state.inverse_masses[i]);
        }
        hash_vector(measures.state_hash, state.positions[i]);
        hash_vector(measures.state_hash, state.velocities[i]);
    }
    return moving;
}

// Adds squares to `rms_stretch`, and returns how many.
int measure_links(const SoftState& state, Measures& measures) {
    int measured = 0;
    for (size_t i = 0; i < state.rest_lengths.size(); ++i) {
        const double rest = static_cast<double>(state.rest_lengths[i]);
        if (!(rest > 0.0)) { continue; }
        const pli_vec3 a = state.positions[static_cast<size_t>(state.link_nodes[2 * i])];
        const pli_vec3 b = state.positions[static_cast<size_t>(state.link_nodes[2 * i + 1])];
        const double length = std::sqrt(length_squared(pli_vec3_sub(b, a)));
        const double stretch = std::fabs(length / rest - 1.0);
        measures.max_stretch = std::fmax(measures.max_stretch, stretch);
        measures.rms_stretch += stretch * stretch;
        ++measured;
    }
    return measured;
}

} // namespace

Measures measure(const Engine& engine) {
    Measures measures;
    measures.state_hash = 14695981039346656037u;
    const size_t count = engine.description().softs.size();
    int measured_links = 0, moving_nodes = 0;
    for (size_t i = 0; i < count; ++i) {
        const SoftState state = engine.soft(static_cast<int>(i));
        measures.nodes += static_cast<int>(state.positions.size());
        measures.links += static_cast<int>(state.rest_lengths.size());
        measures.faces += static_cast<int>(state.face_nodes.size() / 3);
        measures.tetras += static_cast<int>(state.tetra_nodes.size() / 4);
        measures.clusters += state.cluster_count;
        moving_nodes += measure_nodes(state, measures);
        measured_links += measure_links(state, measures);
    }
    if (moving_nodes > 0) { measures.rms_speed = std::sqrt(measures.rms_speed / moving_nodes); }
    if (measured_links > 0) { measures.rms_stretch = std::sqrt(measures.rms_stretch / measured_links); }
    return measures;
}

int part_count(const SoftState& state) {
    Components parts(static_cast<int>(state.positions.size()));
    std::vector<bool> is_used(state.positions.size());
    const auto join = [&](const std::vector<int>& nodes, size_t each) {
        for (size_t i = 0; i < nodes.size(); ++i) {
            parts.join(nodes[i - i % each], nodes[i]);
            is_used[static_cast<size_t>(nodes[i])] = true;
        }
    };
    join(state.link_nodes, 2);
    join(state.face_nodes, 3);
    join(state.tetra_nodes, 4);
    return parts.count() - static_cast<int>(std::count(is_used.begin(), is_used.end(), false));
}

} // namespace demos
