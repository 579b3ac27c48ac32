// pliant list: the scenes.

#include "commands.h"
#include "scenes/scenes.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iostream>
#include <string>

namespace app {

int run_list(const ListOptions& options) {
    if (options.json) {
        nlohmann::ordered_json scenes = nlohmann::ordered_json::array();
        for (int i = 0; i < scene_count; ++i) {
            const scene& each = *scene_list[i];
            scenes.push_back({{"name", each.name},
                              {"summary", each.summary},
                              {"takes_mesh", each.takes_mesh},
                              {"takes_tetra", each.takes_tetra},
                              {"takes_resolution", each.takes_resolution},
                              {"group", each.is_own ? "own" : "bullet"},
                              {"picture_frame", each.picture_frame}});
        }
        std::cout << nlohmann::ordered_json{{"scenes", scenes}}.dump(2) << '\n';
        return 0;
    }
    size_t longest = 0;
    for (int i = 0; i < scene_count; ++i) {
        longest = std::max(longest, std::string(scene_list[i]->name).size());
    }
    for (int i = 0; i < scene_count; ++i) {
        const scene& each = *scene_list[i];
        const std::string name = each.name;
        const char* takes = each.takes_mesh    ? " (--mesh)"
                            : each.takes_tetra ? " (--tetra)"
                            : each.is_own      ? " (own scene)"
                                               : "";
        std::cout << name << std::string(longest + 2 - name.size(), ' ') << each.summary << takes << '\n';
    }
    return 0;
}

} // namespace app
