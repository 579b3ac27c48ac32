// The reader of files of a bridge, and steps of what it makes of one file in eight. The begin of the header is that of
// a file of now, and sizes and checksums are made to fit: else nothing but their check would be reached.

#include "bridge_scene.hpp"
#include "entry.h"
#include "seal.h"

#include <cmath>
#include <cstring>

namespace {

// Of the header (bullet_bridge/src/snapshot/bridge_file.cpp): what tells the format, and places of numbers.
constexpr std::size_t format_size = 20, core_size_at = 32, checksum_at = 40, header_size = 48;

pli_context* context;

void seal(std::vector<unsigned char>& file, const std::vector<unsigned char>& sound) {
    if (file.size() < header_size) { return; }
    std::memcpy(file.data(), sound.data(), format_size);
    std::uint64_t core_size = 0;
    std::memcpy(&core_size, file.data() + core_size_at, sizeof core_size);
    if (core_size > file.size() - header_size) { return; }
    seal_world_file(file.data() + header_size, static_cast<std::size_t>(core_size));
    std::uint64_t sum = 14695981039346656037u;
    for (std::size_t i = header_size + static_cast<std::size_t>(core_size); i < file.size(); ++i) {
        sum = (sum ^ file[i]) * 1099511628211u;
    }
    std::memcpy(file.data() + checksum_at, &sum, sizeof sum);
}

// What the core may count on in each step.
void check_nodes(const pliant::Bridge& bridge) {
    for (int i = 0; i < pli_world_body_count(bridge.world()); ++i) {
        const pli_body_view view = pli_body_get_view(pli_world_get_body(bridge.world(), i));
        for (int k = 0; k < view.node_count; ++k) {
            const pli_vec4 p = view.positions[k];
            fuzz::require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
        }
    }
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (context == nullptr) { fuzz::require(pli_context_create(nullptr, &context) == PLI_OK); }
    unsigned sum = 0; // by all bytes: other inputs around one that takes no steps do
    for (size_t i = 0; i < size; ++i) {
        sum += data[i];
    }
    const size_t bytes = pli_context_allocated_bytes(context);
    {
        fuzz::Scene scene(context, sum / 8 % 2 == 1);
        const std::vector<unsigned char> before = scene.file();
        std::vector<unsigned char> file(data, data + size);
        seal(file, before);
        const pli_status status = pliant::BridgeSnapshot::read_file(scene.bridge, file.data(), file.size());
        if (status != PLI_OK) {
            fuzz::require(pli_last_error(context)[0] != '\0' && scene.file() == before);
        } else {
            const std::vector<unsigned char> after = scene.file();
            fuzz::require(pliant::BridgeSnapshot::read_file(scene.bridge, after.data(), after.size()) == PLI_OK);
            if (sum % 8 == 0 && world_has_short_steps(scene.bridge.world())) {
                scene.stock.step(2);
                check_nodes(scene.bridge);
            }
        }
    }
    fuzz::require(pli_context_allocated_bytes(context) == bytes);
    return 0;
}
