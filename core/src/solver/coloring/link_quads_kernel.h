#ifndef PLII_LINK_QUADS_KERNEL_H
#define PLII_LINK_QUADS_KERNEL_H

/* What kernels over groups of quads have in common. The including file has chosen the instruction set. */

#include "math/simd.h"
#include "solver/coloring/link_colors.h"

/* Places of the nodes of a group: four rows, for single links two. */
typedef const uint32_t (*plii_quad_places)[PLII_LINK_LANES];

PLII_SIMD_INLINE plii_quad_places plii_quad_places_of(const plii_link_colors* colors, const plii_link_group* group) {
    return (plii_quad_places)&colors->places[group->first_place];
}

/* One node of eight quads. */
PLII_SIMD_INLINE plii_records8 plii_quad_gather(const pli_vec4* records, const uint32_t* places) {
    return plii_packed8_turn(plii_packed8_gather(records, places));
}
PLII_SIMD_INLINE void plii_quad_scatter(pli_vec4* records, const uint32_t* places, const plii_records8* a) {
    plii_packed8_scatter(records, places, plii_records8_turn(a));
}

/* Slot of the first link of a group. */
PLII_SIMD_INLINE ptrdiff_t plii_quad_first_slot(const plii_link_group* group) {
    return (ptrdiff_t)PLII_LINK_LANES * group->first_row;
}

/* One link in all lanes; only in the last one, which is stored last, there is a link. */
PLII_SIMD_INLINE void plii_quad_places_of_link(const pli_body* body, int link, uint32_t places[2][PLII_LINK_LANES]) {
    for (int k = 0; k < 2; ++k) {
        for (int lane = 0; lane < PLII_LINK_LANES; ++lane) {
            places[k][lane] = plii_simd_place(body->links[link].nodes[k]);
        }
    }
}

/* How many of the next groups may be solved together, at most `most`. */
PLII_SIMD_INLINE int plii_quad_batch(const plii_link_group* group, int left, int most) {
    const int alike = group->alike < left ? group->alike : left;
    return alike < most ? alike : most;
}

#endif
