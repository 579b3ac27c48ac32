#pragma once

/* An order of constraints in which neighbours come far apart: greedy colours, one after the other. Gauss-Seidel along a
   mesh carries errors ahead of it; between colours they have nowhere to go. Deterministic, linear time, no memory of
   its own. */

#include <stdint.h>

/* Constraints of a colour share no node, those of the last one may. */
enum { PLII_CONSTRAINT_COLORS = 64 };

/* nodes: [arity * count]; masks: [node_count] zero; colors: [count]; order: [count] receives a permutation. */
void plii_constraint_order(int count, int arity, const int* nodes, uint64_t* masks, uint8_t* colors, int* order);
