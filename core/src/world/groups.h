#pragma once

/* Bodies on several threads. What bodies share in a step joins them into groups: contacts with each other, and rigid
   bodies that are not static, which both may push. Groups are solved side by side, the bodies of one in the order in
   which all are solved on one thread: so bits do not depend on threads. A pair of bodies whose bounds overlap is
   joined, whether it touches or not; that only makes groups larger than they have to be. */

#include "body/world_state.h"

/* Room for one more body. False when out of memory. */
bool plii_groups_reserve(pli_world* world, int body_count);
void plii_groups_release(pli_world* world);

/* At the start of a step: every body is alone. Nothing, here and below, where there are no threads. */
void plii_groups_start(pli_world* world);
/* The pair is going to meet. */
void plii_groups_join_rigid(pli_world* world, const pli_body* body, pli_rigid* rigid);
void plii_groups_join_bodies(pli_world* world, const pli_body* body, const pli_body* other);
/* When all pairs have met. False: all bodies are one group, or too few to part them. */
bool plii_groups_find(pli_world* world);

/* Of `count` items that have so many nodes: how many of them make a part that is worth a thread, of a prediction or of
   contacts with rigid bodies. */
int plii_groups_grain(int count, int64_t nodes);

typedef void plii_groups_fn(pli_body* const* bodies, int count);
/* All groups, on any thread. */
void plii_groups_run(pli_world* world, plii_groups_fn* run);
/* Each body for itself, as far as there are enough of them to part. False: nothing was done. */
bool plii_groups_run_bodies(pli_world* world, void (*run)(pli_body* body));
