#include "rollback.h"

#include "engines/pliant_engine.h"

#include <pliant_bullet/snapshot.h>

#include <algorithm>
#include <vector>

namespace demos {

static uint64_t hash_of(const PliantEngine& engine) {
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

static void check(const PliantEngine& engine, pli_status status) {
    if (status == PLI_OK) { return; }
    throw Error(std::string(pli_status_string(status)) + ": " +
                pli_last_error(pli_world_get_context(pli_body_get_world(engine.body(0)))));
}

Rollback compare_rollback(const Description& description, const EngineOptions& options, int save_frame, int frames) {
    EngineOptions ordered = options;
    ordered.ordered_pairs = true;
    PliantEngine engine(description, ordered);
    Rollback result;
    result.solver = choose_solver(description, EngineKind::pliant, options).kind;
    result.threads = options.threads;
    result.frames = frames;
    result.save_frame = save_frame;
    for (const CutRecord& cut : description.cuts) {
        result.save_frame = std::max(result.save_frame, cut.frame + 1);
    }
    for (int i = 0; i < result.save_frame; ++i) {
        engine.step();
    }
    pliant::BridgeSnapshot snapshot;
    check(engine, snapshot.save(engine.bridge()));
    result.bytes = snapshot.bytes();
    const ScriptState script = engine.script_state();
    std::vector<uint64_t> hashes;
    for (int i = 0; i < frames; ++i) {
        engine.step();
        hashes.push_back(hash_of(engine));
    }
    check(engine, snapshot.restore(engine.bridge()));
    engine.set_script_state(script);
    for (int i = 0; i < frames && result.is_equal(); ++i) {
        engine.step();
        if (hash_of(engine) != hashes[static_cast<size_t>(i)]) { result.first_unequal_frame = i + 1; }
    }
    return result;
}

} // namespace demos
