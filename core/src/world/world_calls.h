#pragma once

/* What the calls that make up a step have in common. */

#include "body/world_state.h"

/* Around what may run out of memory: what a step could not get is told at its end, and by the call itself where it has
   a `function` to name. */
uint64_t plii_world_begin_call(pli_world* world, plii_walk* walk);
pli_status plii_world_end_call(pli_world* world, const plii_walk* walk, uint64_t before, const char* function);

/* A pair whose members are of these worlds may meet now. */
pli_status plii_check_pair(const pli_world* world, const pli_world* world_a, const pli_world* world_b,
                           const char* function);

/* Pairs of soft bodies whose bounds overlap. */
void plii_world_collide_soft_pairs(pli_world* world);
/* Every pair whose bounds overlap. */
void plii_world_collide_all(pli_world* world);
