#include "function_scene.h"

#include "recorder.h"

namespace demos {

static void build_function_scene(scene_builder* builder) {
    static_cast<const FunctionScene*>(builder->description.source)->function(builder);
}

FunctionScene::FunctionScene(const std::string& of_name, std::function<void(scene_builder*)> of_function)
    : scene(), text(of_name), function(std::move(of_function)) {
    name = text.c_str();
    summary = "";
    takes_resolution = true;
    build = build_function_scene;
}

} // namespace demos
