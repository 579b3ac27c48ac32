#ifndef DEMOS_SCENE_CHOICE_H
#define DEMOS_SCENE_CHOICE_H

// Scenes by the names that users type.

#include "scenes.h"

#include <string>
#include <vector>

namespace demos {

// Throws Error, with the names that are nearest, when there is no such scene.
const scene& choose_scene(const std::string& name);
// The same for several; "all" stands for every scene. Each scene comes once.
std::vector<const scene*> choose_scenes(const std::vector<std::string>& names);

} // namespace demos
#endif
