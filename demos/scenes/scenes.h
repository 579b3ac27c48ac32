#ifndef SCENES_H
#define SCENES_H

/* The scenes, each defined in a file of its subject; scene_names.inc is the list. */

#include "description/scene_builder.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SCENE(object) extern const scene object;
#include "scene_names.inc"
#undef SCENE

/* All scenes in the order of the list. */
extern const scene* const scene_list[];
extern const int scene_count;
extern const int scene_demo_count; /* those of Bullet's demo, which come first */
/* NULL when there is none of that name; letter case does not matter. */
const scene* scene_find(const char* name);

#ifdef __cplusplus
}
#endif
#endif
