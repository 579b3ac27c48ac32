#ifndef SCENES_H
#define SCENES_H

/* The scenes, each defined in a file of its subject; scene_names.inc is the list. */

#include "description/scene_builder.h"

#define SCENE(object) extern const scene object;
#include "scene_names.inc"
#undef SCENE

#endif
