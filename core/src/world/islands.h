#pragma once

/* Bodies that touch each other are solved together: each stage of the solve goes over all of them before the next one
   begins. */

#include "body/world_state.h"

/* At the start of a step every body is alone. */
void plii_islands_start(pli_world* world);
/* Solves all bodies that are not frozen, islands in the order of their first bodies. */
void plii_islands_solve(pli_world* world);
