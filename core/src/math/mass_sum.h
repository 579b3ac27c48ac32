#pragma once

/* The motion of a rigid body that has the momentum and the angular momentum of many masses. */

#include "math/dvec3.h"
#include "math/simd_float4.h"

/* Of motions about the origin: linear, then angular. */
typedef struct plii_mass_sum {
    double mass[6][6];  /* lower half; the rest is of no use */
    double momentum[6]; /* of the masses; once solved the motion, m/s and rad/s */
} plii_mass_sum;

static inline void plii_mass_sum_add(plii_mass_sum* sum, double mass, plii_dvec3 x, plii_dvec3 v) {
    const plii_dvec3 spin = plii_dvec3_cross(x, v);
    const double r[3] = {x.x, x.y, x.z}, square = plii_dvec3_dot(x, x), q[6] = {v.x, v.y, v.z, spin.x, spin.y, spin.z};
    PLII_UNROLL(3)
    for (int i = 0; i < 3; ++i) {
        sum->momentum[i] += mass * q[i];
        sum->momentum[3 + i] += mass * q[3 + i];
        sum->mass[i][i] += mass;
        sum->mass[3 + i][(i + 1) % 3] -= mass * r[(i + 2) % 3];
        sum->mass[3 + i][(i + 2) % 3] += mass * r[(i + 1) % 3];
        sum->mass[3 + i][3 + i] += mass * square;
        PLII_UNROLL(3)
        for (int k = 0; k < 3; ++k) {
            sum->mass[3 + i][3 + k] -= mass * r[i] * r[k];
        }
    }
}

/* Cholesky of a 6x6 matrix in place, lower; false if it is not positive definite. */
bool plii_factorise6(double m[6][6]);
void plii_solve6(const double m[6][6], double b[6]);
/* False where the masses have no rotation. */
bool plii_mass_sum_solve(plii_mass_sum* sum);
