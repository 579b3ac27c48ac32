#ifndef PLII_ROTATION_BATCH_H
#define PLII_ROTATION_BATCH_H

#include "vec.h"

/* Matrices are worked on in blocks of this many; a whole number of blocks is the best use of the time. */
#define PLII_ROTATION_LANES 8

/* The rotation nearest to each matrix, that is the one of largest trace(transpose(rotation) * matrix): a proper
   rotation (determinant +1) for every input, inverted, flat or zero. Where several are as near (rank 1 or 0, some
   inversions) it is one close to the start; a matrix that is not finite counts as zero. quaternions [count] the starts,
   such as the result of the last step; any length, identity when useless. Replaced by the result, unit, on the start's
   side. rotations   [count] the same as matrices; may be `matrices` itself; may be NULL A result depends only on its
   own matrix and start. */
void plii_rotation_batch(int count, const pli_mat3* matrices, pli_quat* quaternions, pli_mat3* rotations);

#endif
