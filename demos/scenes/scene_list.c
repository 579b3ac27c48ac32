/* The list of all scenes, and how to find one by its name. */

#include "scenes.h"

#include <ctype.h>

#define SCENE(object) &object,
const scene* const scene_list[] = {
#include "scene_names.inc"
};
#undef SCENE

const int scene_count = (int)(sizeof scene_list / sizeof scene_list[0]);
const int scene_demo_count = 33;

static bool scene_has_name(const scene* candidate, const char* name) {
    const char* own = candidate->name;
    while (*own != '\0' && tolower((unsigned char)*own) == tolower((unsigned char)*name)) {
        ++own;
        ++name;
    }
    return *own == '\0' && *name == '\0';
}

const scene* scene_find(const char* name) {
    for (int i = 0; name != NULL && i < scene_count; ++i) {
        if (scene_has_name(scene_list[i], name)) { return scene_list[i]; }
    }
    return NULL;
}
