#pragma once

/* What the files of the world's step have in common: islands, groups, calls. */

#include "body/world_state.h"

/* Bodies that touch each other are solved together: a stage goes over all of them before the next one begins. */

/* At the start of a step every body is alone. */
void plii_islands_start(pli_world* world);
/* When all pairs have met. */
void plii_islands_find(pli_world* world);
/* Solves those of the bodies that are not frozen, with a body all of its island. */
void plii_islands_solve(pli_body* const* bodies, int count);

/* Bodies on several threads. What bodies share in a step joins them into groups: contacts with each other, and rigid
   bodies that are not static, which both may push. Groups are solved side by side, the bodies of one in the order in
   which all are solved on one thread: so bits do not depend on threads. A pair of bodies whose bounds overlap is
   joined, whether it touches or not; that only makes groups larger than they have to be. */

/* Room for one more body. False when out of memory. */
bool plii_groups_reserve(pli_world* world, int body_count);

/* At the start of a step: every body is alone. Nothing, here and below, where there are no threads. */
void plii_groups_start(pli_world* world);
/* The pair is going to meet. */
void plii_groups_join_rigid(pli_world* world, const pli_body* body, pli_rigid* rigid);
void plii_groups_join_bodies(pli_world* world, const pli_body* body, const pli_body* other);
/* When all pairs have met. False: all bodies are one group, or too few to part them. */
bool plii_groups_find(pli_world* world);

/* How many of `count` items with so many nodes make a part worth a thread, of a prediction or of rigid contacts. */
int plii_groups_grain(const pli_world* world, int count, int64_t nodes);

/* All groups, on any thread. */
void plii_groups_run(pli_world* world, void (*run)(pli_body* const* bodies, int count));
/* Each body for itself, where there are groups and enough bodies to part. False: nothing was done. */
bool plii_groups_run_bodies(pli_world* world, void (*run)(pli_body* body));

/* Around what may run out of memory: a step tells at its end, and a call itself where it has a `function` to name. */
uint64_t plii_world_begin_call(pli_world* world, plii_walk* walk);
pli_status plii_world_end_call(pli_world* world, const plii_walk* walk, uint64_t before, const char* function);

/* What a profile is told the begin and the end of. */
#define PLII_WORLD_RUN_PROFILED(world, stage, feature, call)                                                           \
    do {                                                                                                               \
        plii_world_profile(world, stage, feature, true);                                                               \
        call;                                                                                                          \
        plii_world_profile(world, stage, feature, false);                                                              \
    } while (0)

/* Every pair whose bounds overlap. */
void plii_world_collide_all(pli_world* world);
