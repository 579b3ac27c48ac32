#pragma once

#include "math/vec.h"

/* As below, and with nothing that mends it: not finite where that of Bullet is not. */
pli_mat3 plii_polar_factor_of_bullet(pli_mat3 a);

/* Factor U of a = U S with S symmetric and positive definite. det U has the sign of det a, so an inverted matrix gives
   a reflection. Bit-equal to btPolarDecomposition with its default settings wherever that gives numbers, with its one
   flaw: a matrix whose norms are below about 3e-4 or above about 3e3 comes back unchanged. Where it gives none, a flat
   matrix (rank 2) gets the rotation of the flat part and what has no factor gets `fallback`. Always finite. */
pli_mat3 plii_polar_factor(pli_mat3 a, pli_mat3 fallback);
