#pragma once

#include "math/vec.h"

/* To start at, of any length: that of a rotation, or where it is half a turn one nearby or with other signs. */
static inline pli_quat plii_quat_near(const pli_mat3* rotation) {
    const pli_vec3* rows = rotation->rows;
    const float xx = rows[0].x, yy = rows[1].y, zz = rows[2].z;
    const pli_quat turned = {copysignf(sqrtf(plii_max(0.0f, 1.0f + xx - yy - zz)), rows[2].y - rows[1].z),
                             copysignf(sqrtf(plii_max(0.0f, 1.0f - xx + yy - zz)), rows[0].z - rows[2].x),
                             copysignf(sqrtf(plii_max(0.0f, 1.0f - xx - yy + zz)), rows[1].x - rows[0].y),
                             sqrtf(plii_max(0.0f, 1.0f + xx + yy + zz))};
    return turned;
}

/* Makes a symmetric matrix diagonal by Jacobi's rotations; the rows of `axes`, first a basis, become eigenvectors. */
void plii_diagonalize(double matrix[4][4], double axes[4][4]);

/* The rotation nearest to a matrix, that is the one of largest trace(transpose(rotation) * matrix): a proper rotation
   (determinant +1) for every input, inverted, flat or zero. Where several are as near (rank 1 or 0, some inversions) it
   is one close to the start; a matrix that is not finite counts as zero. quaternion: the start, such as the result of
   the last step; any length, identity when useless. Replaced by the result, unit, on the start's side. */
pli_mat3 plii_rotation_fit(const pli_mat3* matrix, pli_quat* quaternion);

/* plii_rotation_fit of one to four matrices, which the rotations replace, for starts that are near the results, such as
   those of the last step, in float: right to 3e-6 rad, with bits that do not depend on the others. What turns out not
   to be near, or has no one nearest rotation, is left to plii_rotation_fit. */
void plii_rotations_fit_warm(int count, pli_mat3* matrices, pli_quat* const* quaternions);

/* Factor U of a = U S with S symmetric and positive definite. det U has the sign of det a, so an inverted matrix gives
   a reflection. Bit-equal to btPolarDecomposition with its default settings wherever that gives numbers, with its one
   flaw: a matrix whose norms are below about 3e-4 or above about 3e3 comes back unchanged. Where it gives none, of flat
   matrices and the like, plii_rotation_fit from a rotation to start at does. */
pli_mat3 plii_polar_factor(pli_mat3 a, pli_mat3 start);
/* The same with nothing that mends it: not finite where that of Bullet is not. */
pli_mat3 plii_polar_factor_of_bullet(pli_mat3 a);
