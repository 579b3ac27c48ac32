#ifndef DEMOS_SCENE_RUN_H
#define DEMOS_SCENE_RUN_H

#include "scene_builder.h"

// What the functions behind a scene's controls act on.
struct scene_run {
    virtual ~scene_run() = default;
    virtual void set_wind(int soft, pli_vec3 wind) = 0; // `soft` is in range
    virtual int soft_count() const = 0;
    virtual void drive(float speed, float largest_change) = 0;
    virtual void steer(float angle) = 0;
};

#endif
