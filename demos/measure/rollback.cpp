#include "rollback.h"

#include "recording.h"

#include <pliant_bullet/snapshot.h>

#include <algorithm>
#include <vector>

namespace demos {

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
        hashes.push_back(hash_frame(engine));
    }
    check(engine, snapshot.restore(engine.bridge()));
    engine.set_script_state(script);
    for (int i = 0; i < frames && result.is_equal(); ++i) {
        engine.step();
        if (hash_frame(engine) != hashes[static_cast<size_t>(i)]) { result.first_unequal_frame = i + 1; }
    }
    return result;
}

} // namespace demos
