#ifndef DEMOS_FUNCTION_SCENE_H
#define DEMOS_FUNCTION_SCENE_H

// A scene that a function object builds. Scenes are plain C; this one finds its function through the record that is
// being made.

#include "description.h"

#include <functional>

namespace demos {

struct FunctionScene : scene {
    FunctionScene(const std::string& of_name, std::function<void(scene_builder*)> of_function);
    FunctionScene(const FunctionScene&) = delete;
    FunctionScene& operator=(const FunctionScene&) = delete;

    std::string text; // of the name
    std::function<void(scene_builder*)> function;
};

} // namespace demos
#endif
