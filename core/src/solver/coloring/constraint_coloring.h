#pragma once

/* An order of constraints in which neighbours come far apart: greedy colours, one after the other. Gauss-Seidel along a
   mesh carries errors ahead of it; between colours they have nowhere to go. Linear time. */

#include "base/csr.h"

#include <stdint.h>

/* Constraints of a colour share no node; those of the last one may, which have found no other free. */
enum { PLII_CONSTRAINT_COLORS = 64 };

/* nodes: [count]; masks: [node_count] zero; colors: [count]; order: [count] receives a permutation. */
static inline void plii_constraint_order(int count, const int (*nodes)[4], uint64_t* masks, uint8_t* colors,
                                         int* order) {
    int begin[PLII_CONSTRAINT_COLORS + 1] = {0};
    for (int i = 0; i < count; ++i) {
        uint64_t used = 0;
        for (int k = 0; k < 4; ++k) {
            used |= masks[nodes[i][k]];
        }
        int color = 0;
        while (color < PLII_CONSTRAINT_COLORS - 1 && (used >> color & 1u) != 0) {
            ++color;
        }
        for (int k = 0; k < 4; ++k) {
            masks[nodes[i][k]] |= (uint64_t)1 << color;
        }
        colors[i] = (uint8_t)color;
        ++begin[color];
    }
    plii_csr_sum(PLII_CONSTRAINT_COLORS, begin);
    for (int i = count - 1; i >= 0; --i) {
        order[--begin[colors[i]]] = i;
    }
}
