// pliant replay: a recording, played again and compared with what was recorded. pliant diverge: where two recordings,
// or a recording and this build, part.

#include "commands.h"
#include "description/error.h"
#include "measure/recording.h"
#include "progress.h"
#include "scenes/scene_choice.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <iostream>

namespace app {

namespace {

std::unique_ptr<demos::Description> description_of(const demos::Recording& recording) {
    return demos::Description::build(demos::choose_scene(recording.settings.scene),
                                     scene_options({recording.settings.self_collision, recording.settings.resolution}));
}

std::string text_of(uint64_t hash) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

} // namespace

int run_replay(const ReplayOptions& options) {
    const demos::Recording recording = demos::Recording::read(options.file);
    const int frames = recording.frame_count();
    if (options.from > frames) {
        throw demos::Error("--from " + std::to_string(options.from) + " is after the last frame, " +
                           std::to_string(frames));
    }
    const std::unique_ptr<demos::Description> description = description_of(recording);
    Progress progress(options.json);
    progress.start(recording.settings.scene);
    const demos::Keyframe* keyframe = recording.keyframe_before(options.from);
    const int first = keyframe != nullptr ? keyframe->frame : 0;
    demos::Player player(recording, *description, first);
    int first_unequal = 0;
    while (player.frame() < frames && (first_unequal == 0 || !options.verify)) {
        if (!player.step() && first_unequal == 0) { first_unequal = player.frame(); }
        progress.show(player.frame(), frames);
    }
    progress.clear();
    const uint64_t hash = demos::hash_frame(player.engine());
    if (options.json) {
        std::cout << nlohmann::ordered_json{{"scene", recording.settings.scene},
                                            {"solver", recording.settings.solver},
                                            {"frames", frames},
                                            {"from", options.from},
                                            {"keyframe", first},
                                            {"hash", text_of(hash)},
                                            {"first_unequal_frame", first_unequal},
                                            {"equal", first_unequal == 0}}
                         .dump(2)
                  << '\n';
    } else {
        std::cout << recording.settings.scene << ", " << recording.settings.solver << ": frames " << first << " to "
                  << player.frame() << " of " << frames << ", hash " << text_of(hash) << '\n';
        std::cout << (first_unequal == 0 ? "all as recorded"
                                         : "other than recorded from frame " + std::to_string(first_unequal) + " on")
                  << '\n';
    }
    return options.verify && first_unequal != 0 ? 1 : 0;
}

int run_diverge(const DivergeOptions& options) {
    const demos::Recording first = demos::Recording::read(options.first);
    const bool has_second = !options.second.empty();
    const demos::Recording second = has_second ? demos::Recording::read(options.second) : first;
    if (first.settings.scene != second.settings.scene) {
        throw demos::Error("the recordings are of two scenes, " + first.settings.scene + " and " +
                           second.settings.scene);
    }
    const std::unique_ptr<demos::Description> description = description_of(first), other = description_of(second);
    const int frames = std::min(first.frame_count(), second.frame_count());
    int frame = 0;
    bool is_played = true; // both go as they were recorded, up to the frame
    demos::Difference difference;
    Progress progress(options.json);
    progress.start(first.settings.scene);
    if (has_second) {
        for (int i = 0; i < frames && frame == 0; ++i) {
            if (first.hashes[static_cast<size_t>(i)] != second.hashes[static_cast<size_t>(i)]) { frame = i + 1; }
        }
        if (frame > 0) {
            demos::Player a(first, *description, frame - 1), b(second, *other, frame - 1);
            const std::string cause = demos::find_difference(a.engine(), b.engine()).part;
            const bool goes_a = a.step(), goes_b = b.step();
            is_played = goes_a && goes_b;
            difference = demos::find_difference(a.engine(), b.engine());
            if (!cause.empty()) { difference.part = cause; } // after the step all that follows from it differs too
        }
    } else { // against this build, from the start; then from its last keyframe before, where it was right
        const demos::Recording without_keyframes{first.settings, first.hashes, {}};
        demos::Player player(without_keyframes, *description, 0);
        while (player.frame() < frames && frame == 0) {
            if (!player.step()) { frame = player.frame(); }
            progress.show(player.frame(), frames);
        }
        const demos::Keyframe* next = nullptr;
        for (const demos::Keyframe& keyframe : first.keyframes) {
            if (frame > 0 && keyframe.frame >= frame && next == nullptr) { next = &keyframe; }
        }
        is_played = next != nullptr;
        if (next != nullptr) { // the first state that is known of the recording after it
            while (player.frame() < next->frame) {
                (void)player.step();
            }
            demos::Player recorded(first, *description, next->frame);
            difference = demos::find_difference(recorded.engine(), player.engine());
        }
    }
    progress.clear();
    const std::string body =
        difference.body < 0 ? "" : (difference.is_rigid ? "rigid body " : "body ") + std::to_string(difference.body);
    if (options.json) {
        std::cout << nlohmann::ordered_json{{"scene", first.settings.scene},   {"frames", frames},
                                            {"first_unequal_frame", frame},    {"equal", frame == 0},
                                            {"is_played", is_played},          {"body", difference.body},
                                            {"is_rigid", difference.is_rigid}, {"node", difference.node},
                                            {"feature", difference.part}}
                         .dump(2)
                  << '\n';
    } else if (frame == 0) {
        std::cout << "equal: " << frames << " frames\n";
    } else {
        std::cout << "frame " << frame << ": " << (body.empty() ? "no body that this build can show" : body);
        if (difference.node >= 0) { std::cout << ", node " << difference.node; }
        if (!difference.part.empty()) { std::cout << ", " << difference.part; }
        std::cout << '\n';
        if (!is_played) { std::cout << "this build does not go as it was recorded: bodies are as it makes them\n"; }
    }
    return frame == 0 ? 0 : 1;
}

} // namespace app
