#ifndef PLII_POLAR_H
#define PLII_POLAR_H

#include "vec.h"

/* Orthogonal factor U of a = U S with S symmetric and positive definite; det U has the sign of det a, so an inverted
   matrix gives a reflection. Bit-equal to btPolarDecomposition with its default settings wherever that ends at an
   orthogonal matrix. Very small, very large and flat (rank 2) matrices, for which it does not, get the factor of the
   scaled matrix, the flat ones a rotation. `fallback` is returned where no factor is defined: rank 1 or 0, or not
   finite. */
pli_mat3 plii_polar_orthogonal(pli_mat3 a, pli_mat3 fallback);

#endif
