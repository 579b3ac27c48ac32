#pragma once

#include "math/vec.h"

/* Makes a symmetric matrix diagonal by Jacobi's rotations; the rows of `axes`, first a basis, become eigenvectors. */
void plii_diagonalize(double matrix[4][4], double axes[4][4]);

/* The rotation nearest to a matrix, that is the one of largest trace(transpose(rotation) * matrix): a proper rotation
   (determinant +1) for every input, inverted, flat or zero. Where several are as near (rank 1 or 0, some inversions) it
   is one close to the start; a matrix that is not finite counts as zero. quaternion: the start, such as the result of
   the last step; any length, identity when useless. Replaced by the result, unit, on the start's side. */
pli_mat3 plii_rotation_fit(const pli_mat3* matrix, pli_quat* quaternion);

/* plii_rotation_fit for a start that is near the result, such as that of the last step, in float: right to 3e-6 rad.
   What turns out not to be near, or has no one nearest rotation, is left to plii_rotation_fit. */
pli_mat3 plii_rotation_fit_warm(const pli_mat3* matrix, pli_quat* quaternion);
