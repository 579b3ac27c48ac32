#pragma once

/* Bodies that touch each other are solved together: each stage of the solve goes over all of them before the next one
   begins. */

#include "body/world_state.h"

/* At the start of a step every body is alone. */
void plii_islands_start(pli_world* world);
/* When all pairs have met. */
void plii_islands_find(pli_world* world);
/* Solves those of the bodies that are not frozen, islands in the order of their first bodies; with a body, all of its
   island. */
void plii_islands_solve(pli_body* const* bodies, int count);
