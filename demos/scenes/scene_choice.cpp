#include "scene_choice.h"

#include "description/error.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace demos {

static std::string lower_case(std::string text) {
    for (char& c : text) {
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return text;
}

// Levenshtein's distance: insertions, deletions and replacements that turn one word into the other.
static size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < b.size(); ++j) {
            const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
        }
    }
    return row[b.size()];
}

// Up to three names, nearest first: those that begin like the word or differ in at most a third of it.
static std::string nearest_names(const std::string& word) {
    const std::string wanted = lower_case(word);
    std::vector<std::pair<size_t, std::string>> near;
    for (int i = 0; i < scene_count; ++i) {
        const std::string name = lower_case(scene_list[i]->name);
        const bool begins = wanted.size() >= 2 && name.compare(0, wanted.size(), wanted) == 0;
        const size_t distance = begins ? 1 : edit_distance(wanted, name);
        if (distance <= std::max<size_t>(1, wanted.size() / 3)) { near.emplace_back(distance, scene_list[i]->name); }
    }
    std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::string names;
    for (size_t i = 0; i < near.size() && i < 3; ++i) {
        names += (i == 0 ? "" : " or ") + near[i].second;
    }
    return names;
}

const scene& choose_scene(const std::string& name) {
    const scene* found = scene_find(name.c_str());
    if (found != nullptr) { return *found; }
    const std::string names = nearest_names(name);
    const std::string hint = names.empty() ? "pliant list shows all" : "did you mean " + names + "?";
    throw Error("there is no scene named " + name + "; " + hint);
}

std::vector<const scene*> choose_scenes(const std::vector<std::string>& names) {
    std::vector<const scene*> chosen;
    const auto add = [&](const scene* which) {
        if (std::find(chosen.begin(), chosen.end(), which) == chosen.end()) { chosen.push_back(which); }
    };
    for (const std::string& name : names) {
        if (lower_case(name) == "all") {
            std::for_each(scene_list, scene_list + scene_demo_count, add);
        } else {
            add(&choose_scene(name));
        }
    }
    return chosen;
}

} // namespace demos
