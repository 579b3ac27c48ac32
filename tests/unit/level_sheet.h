#ifndef TESTS_UNIT_LEVEL_SHEET_H
#define TESTS_UNIT_LEVEL_SHEET_H

/* The cloth that many tests begin with. */

#include <pliant/generate.h>

/* A square around the axis y, `half` m to each side, with so many nodes along each and a diagonal in each cell. */
static inline pli_patch_def level_sheet(float half, float height, int nodes) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-half, height, -half);
    def.corner_10 = pli_vec3_make(half, height, -half);
    def.corner_01 = pli_vec3_make(-half, height, half);
    def.corner_11 = pli_vec3_make(half, height, half);
    def.columns = def.rows = nodes;
    return def;
}

static inline bool level_sheet_is_rim(int node, int nodes) {
    const int column = node % nodes, row = node / nodes, last = nodes - 1;
    return column == 0 || column == last || row == 0 || row == last;
}

#endif
