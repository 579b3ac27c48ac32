#pragma once

/* Diagonal 3x3 blocks of the implicit system. */

#include "math/dvec3.h"

#include <stdbool.h>

static inline plii_dvec3 plii_implicit_xyz(const pli_vec4* v) {
    return plii_dvec3_from(plii_xyz(*v));
}

/* W_ii = L D L^T with unit lower L; all zero for pinned nodes, whose solution is thereby zero. */
typedef struct plii_implicit_block {
    double l10, l20, l21;
    double inverse_d[3];
} plii_implicit_block;

static inline plii_dvec3 plii_implicit_block_solve(const plii_implicit_block* block, plii_dvec3 b) {
    const double y1 = b.y - block->l10 * b.x;
    const double y2 = b.z - block->l20 * b.x - block->l21 * y1;
    const double z = y2 * block->inverse_d[2];
    const double y = y1 * block->inverse_d[1] - block->l21 * z;
    const double x = b.x * block->inverse_d[0] - block->l10 * y - block->l20 * z;
    return plii_dvec3_make(x, y, z);
}

static inline bool plii_implicit_block_is_pinned(const plii_implicit_block* block) {
    return !(block->inverse_d[0] > 0.0);
}

/* W_ii x; the block must not be of a pinned node. */
static inline plii_dvec3 plii_implicit_block_mul(const plii_implicit_block* block, plii_dvec3 x) {
    const double z0 = (x.x + block->l10 * x.y + block->l20 * x.z) / block->inverse_d[0];
    const double z1 = (x.y + block->l21 * x.z) / block->inverse_d[1];
    const double z2 = x.z / block->inverse_d[2];
    return plii_dvec3_make(z0, block->l10 * z0 + z1, block->l20 * z0 + block->l21 * z1 + z2);
}
/* Of the stiffest direction, nearly; kg. */
static inline double plii_implicit_block_stiffness(const plii_implicit_block* block) {
    const double* d = block->inverse_d;
    return 1.0 / fmin(d[0], fmin(d[1], d[2]));
}
