#include "recording.h"

#include "description/error.h"

#include <pliant/world_file.h>
#include <pliant_bullet/snapshot.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace demos {

static constexpr int recording_version = 1;

// ------------------------------------------------------------------------------------------------------------ files

const Keyframe* Recording::keyframe_before(int frame) const {
    const Keyframe* last = nullptr;
    for (const Keyframe& keyframe : keyframes) {
        if (keyframe.frame <= frame) { last = &keyframe; }
    }
    return last;
}

std::string Recording::to_bytes() const {
    nlohmann::json states = nlohmann::json::array();
    for (const Keyframe& keyframe : keyframes) {
        states.push_back({{"frame", keyframe.frame}, {"state", nlohmann::json::binary(keyframe.state)}});
    }
    std::vector<uint8_t> packed;
    for (const uint64_t hash : hashes) {
        for (unsigned i = 0; i < 8; ++i) {
            packed.push_back(static_cast<uint8_t>(hash >> (8 * i)));
        }
    }
    const nlohmann::json all = {{"pliant_recording", recording_version},
                                {"scene", settings.scene},
                                {"self_collision", settings.self_collision},
                                {"resolution", settings.resolution},
                                {"solver", settings.solver},
                                {"substeps", settings.substeps},
                                {"iterations", settings.iterations},
                                {"threads", settings.threads},
                                {"step_seconds", settings.step_seconds},
                                {"reference", settings.is_reference},
                                {"hashes", nlohmann::json::binary(packed)},
                                {"keyframes", states}};
    const std::vector<uint8_t> bytes = nlohmann::json::to_cbor(all);
    return std::string(bytes.begin(), bytes.end());
}

Recording Recording::from_bytes(const std::string& bytes, const std::string& name) {
    try {
        const nlohmann::json all = nlohmann::json::from_cbor(bytes);
        const int version = all.at("pliant_recording").get<int>();
        if (version != recording_version) {
            throw Error(name + ": the recording is of version " + std::to_string(version) + ", this is " +
                        std::to_string(recording_version));
        }
        Recording result;
        result.settings.scene = all.at("scene").get<std::string>();
        result.settings.self_collision = all.at("self_collision").get<std::string>();
        result.settings.resolution = all.at("resolution").get<std::string>();
        result.settings.solver = all.at("solver").get<std::string>();
        result.settings.substeps = all.at("substeps").get<int>();
        result.settings.iterations = all.at("iterations").get<int>();
        result.settings.threads = all.at("threads").get<int>();
        result.settings.step_seconds = all.at("step_seconds").get<float>();
        result.settings.is_reference = all.at("reference").get<bool>();
        const auto& packed = all.at("hashes").get_binary();
        for (size_t i = 0; i + 8 <= packed.size(); i += 8) {
            uint64_t hash = 0;
            for (unsigned k = 0; k < 8; ++k) {
                hash |= static_cast<uint64_t>(packed[i + k]) << (8 * k);
            }
            result.hashes.push_back(hash);
        }
        for (const nlohmann::json& keyframe : all.at("keyframes")) {
            const auto& state = keyframe.at("state").get_binary();
            result.keyframes.push_back({keyframe.at("frame").get<int>(), {state.begin(), state.end()}});
        }
        return result;
    } catch (const nlohmann::json::exception&) { throw Error(name + " is no recording, or it is damaged"); }
}

Recording Recording::read(const std::filesystem::path& path) {
    if (std::filesystem::is_directory(path)) { throw Error("cannot read " + path.string() + ": it is a folder"); }
    std::ifstream file(path, std::ios::binary);
    if (!file) { throw Error("cannot read " + path.string()); }
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    return from_bytes(bytes, path.string());
}

// -------------------------------------------------------------------------------------------------- recording, playing

uint64_t hash_frame(const PliantEngine& engine) {
    uint64_t hash = 14695981039346656037u;
    const auto mix = [&](const void* data, size_t size) {
        for (size_t i = 0; i < size; ++i) {
            hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
        }
    };
    for (int i = 0; i < engine.soft_count(); ++i) {
        const uint64_t body = pli_body_state_hash(engine.body(i));
        mix(&body, sizeof body);
    }
    for (int i = 0; i < engine.rigid_count(); ++i) {
        const RigidState state = engine.rigid(i);
        mix(&state.pose, sizeof state.pose);
        mix(&state.linear_velocity, sizeof state.linear_velocity);
        mix(&state.angular_velocity, sizeof state.angular_velocity);
    }
    return hash;
}

static void check(PliantEngine& engine, pli_status status, const char* what) {
    if (status == PLI_OK) { return; }
    throw Error(std::string(what) + ": " + pli_status_string(status) + ": " +
                pli_last_error(engine.bridge().context()));
}

std::vector<unsigned char> write_state(PliantEngine& engine) {
    std::vector<unsigned char> state;
    check(engine, pliant::BridgeSnapshot::write_file(engine.bridge(), state), "the keyframe was not written");
    return state;
}

void read_state(PliantEngine& engine, const std::vector<unsigned char>& state) {
    check(engine, pliant::BridgeSnapshot::read_file(engine.bridge(), state.data(), state.size()),
          "the keyframe does not fit");
}

void Recorder::add_frame(PliantEngine& engine) {
    recording_.hashes.push_back(hash_frame(engine));
    if (interval_ > 0 && recording_.frame_count() % interval_ == 0) { add_keyframe(engine); }
}

void Recorder::add_keyframe(PliantEngine& engine) {
    recording_.keyframes.push_back({recording_.frame_count(), write_state(engine)});
}

static EngineOptions options_of(const RecordedSettings& settings) {
    EngineOptions options;
    options.reference = settings.is_reference;
    options.ordered_pairs = true;
    options.solver.kind = settings.solver == "implicit" ? SolverKind::implicit
                          : settings.solver == "xpbd"   ? SolverKind::xpbd
                                                        : SolverKind::position_based;
    options.solver.substeps =
        options.solver.kind == SolverKind::xpbd ? std::optional<int>(settings.substeps) : std::nullopt;
    if (settings.iterations > 0) { options.solver.iterations = settings.iterations; }
    options.threads = settings.threads;
    options.step_seconds = settings.step_seconds;
    return options;
}

Player::Player(const Recording& recording, const Description& description, int frame)
    : recording_(recording), engine_(std::make_unique<PliantEngine>(description, options_of(recording.settings))) {
    const Keyframe* keyframe = recording.keyframe_before(frame);
    if (keyframe != nullptr) {
        read_state(*engine_, keyframe->state);
        engine_->skip_script(keyframe->frame);
        frame_ = keyframe->frame;
    }
    while (frame_ < frame) {
        (void)step();
    }
}

bool Player::step() {
    engine_->step();
    ++frame_;
    return frame_ > recording_.frame_count() ||
           hash_frame(*engine_) == recording_.hashes[static_cast<size_t>(frame_ - 1)];
}

// ------------------------------------------------------------------------------------------------------- differences

namespace {

// A world as a file, and where its parts begin.
struct Parts {
    struct Part {
        size_t begin;
        int body;
        std::string name;
    };
    std::vector<Part> list;
    std::vector<unsigned char> bytes;

    explicit Parts(const PliantEngine& engine) {
        const pli_world* world = pli_body_get_world(engine.body(0));
        pli_world_file_def def = pli_world_file_def_default();
        def.user = this;
        def.begin_part = [](const char* part, int body, size_t offset, void* user) {
            static_cast<Parts*>(user)->list.push_back({offset, body, part});
        };
        bytes.resize(pli_world_file_size(world));
        if (pli_world_file_write(world, &def, bytes.data(), bytes.size(), nullptr) != PLI_OK) { bytes.clear(); }
    }
    // The bytes of a part; its end is where the next one begins.
    size_t end(size_t index) const { return index + 1 < list.size() ? list[index + 1].begin : bytes.size(); }
    bool has_same(size_t index, const Parts& other) const {
        const size_t begin = list[index].begin, size = end(index) - begin, other_begin = other.list[index].begin;
        return size == other.end(index) - other_begin &&
               std::equal(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                          bytes.begin() + static_cast<std::ptrdiff_t>(begin + size),
                          other.bytes.begin() + static_cast<std::ptrdiff_t>(other_begin));
    }
};

bool are_same(pli_vec4 a, pli_vec4 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w;
}

int first_node(const pli_body* a, const pli_body* b) {
    const pli_body_view left = pli_body_get_view(a), right = pli_body_get_view(b);
    const int common = std::min(left.node_count, right.node_count);
    for (int i = 0; i < common; ++i) {
        if (!are_same(left.positions[i], right.positions[i]) || !are_same(left.velocities[i], right.velocities[i])) {
            return i;
        }
    }
    return left.node_count != right.node_count ? common : -1;
}

} // namespace

Difference find_difference(const PliantEngine& a, const PliantEngine& b) {
    Difference result;
    for (int i = 0; i < std::min(a.soft_count(), b.soft_count()) && result.node < 0; ++i) {
        result.node = first_node(a.body(i), b.body(i));
        if (result.node >= 0) { result.body = i; }
    }
    for (int i = 0; i < std::min(a.rigid_count(), b.rigid_count()) && result.body < 0; ++i) {
        const RigidState left = a.rigid(i), right = b.rigid(i);
        const pli_vec3 way = pli_vec3_sub(left.pose.origin, right.pose.origin);
        const pli_vec3 change = pli_vec3_sub(left.linear_velocity, right.linear_velocity);
        if (pli_vec3_length_squared(way) > 0.0f || pli_vec3_length_squared(change) > 0.0f) {
            result.body = i;
            result.is_rigid = true;
        }
    }
    const Parts left(a), right(b);
    const size_t parts = std::min(left.list.size(), right.list.size());
    for (size_t i = 0; i < parts && result.part.empty(); ++i) {
        const bool is_mesh = left.list[i].name == "nodes"; // what differs there is said by the node
        const bool is_of_body = result.body < 0 || result.is_rigid || left.list[i].body == result.body;
        if (is_mesh || !is_of_body) { continue; }
        const bool is_same = left.list[i].name == right.list[i].name && left.has_same(i, right);
        if (!is_same) { result.part = left.list[i].name; }
    }
    return result;
}

} // namespace demos
