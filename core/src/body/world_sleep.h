#pragma once

/* Sleep, as the world's step sees it. A program that enables no sleep has none of it (features/sleep.c). */

#include "body/body_impl.h"

typedef struct plii_world_sleep {
    void (*begin_step)(pli_world* world, float dt); /* before the prediction: wakes */
    /* After it: wakes those whom predicted bodies meet, and predicts them. */
    void (*wake_met)(pli_world* world, void (*predict)(pli_body* body));
    void (*end_step)(pli_world* world, float dt); /* after the solve: puts to sleep */
} plii_world_sleep;

extern const plii_feature_class plii_sleep_class;
enum { PLII_SLEEP_ORDER = 60 }; /* last of what is made anew */

/* A number of a group that falls asleep now; never 0. */
uint32_t plii_world_next_sleep_group(pli_world* world);
/* With the others of the group. */
void plii_body_fall_asleep(pli_body* body, uint32_t group);
