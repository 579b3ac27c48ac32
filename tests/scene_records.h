#ifndef TESTS_SCENE_RECORDS_H
#define TESTS_SCENE_RECORDS_H

// Scenes of a test's own, and how to get at the message of a failure.

#include "engines/engine.h"
#include "scenes/scenes.h"

#include <functional>

using DescriptionPointer = std::unique_ptr<demos::Description>;

inline scene test_scene(void (*build)(scene_builder*)) {
    scene made{};
    made.name = "Test";
    made.summary = "A scene of a test.";
    made.takes_mesh = true;
    made.build = build;
    return made;
}

inline DescriptionPointer describe(const char* name, const demos::SceneOptions& options = {}) {
    return demos::Description::build(*scene_find(name), options);
}

// The message of the demos::Error that the action throws; empty: it throws none.
inline std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const demos::Error& error) { return error.what(); }
    return "";
}

#endif
