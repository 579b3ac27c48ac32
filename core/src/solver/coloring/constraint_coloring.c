/* Greedy colouring in the order of constraints. What finds none of the colours free comes last; orders need no proper
   colouring. */

#include "solver/coloring/constraint_coloring.h"

#include "base/csr.h"

void plii_constraint_order(int count, int arity, const int* nodes, uint64_t* masks, uint8_t* colors, int* order) {
    int begin[PLII_CONSTRAINT_COLORS + 1] = {0};
    for (int i = 0; i < count; ++i) {
        const int* own = nodes + (int64_t)arity * i;
        uint64_t used = 0;
        for (int k = 0; k < arity; ++k) {
            used |= masks[own[k]];
        }
        int color = 0;
        while (color < PLII_CONSTRAINT_COLORS - 1 && (used >> color & 1u) != 0) {
            ++color;
        }
        for (int k = 0; k < arity; ++k) {
            masks[own[k]] |= (uint64_t)1 << color;
        }
        colors[i] = (uint8_t)color;
        ++begin[color];
    }
    (void)plii_csr_sum(PLII_CONSTRAINT_COLORS, begin);
    for (int i = count - 1; i >= 0; --i) {
        order[--begin[colors[i]]] = i;
    }
}
