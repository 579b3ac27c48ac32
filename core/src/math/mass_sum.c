#include "math/mass_sum.h"

#define MASS_SUM_LEAST_INERTIA 1e-12 /* about any axis, of all: nodes in a line have none about it */

bool plii_factorise6(double m[6][6]) {
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k <= i; ++k) {
            double sum = m[i][k];
            for (int l = 0; l < k; ++l) {
                sum -= m[i][l] * m[k][l];
            }
            if (i == k) {
                if (!(sum > 0.0)) { return false; }
                m[i][i] = sqrt(sum);
            } else {
                m[i][k] = sum / m[k][k];
            }
        }
    }
    return true;
}

void plii_solve6(const double m[6][6], double b[6]) {
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < i; ++k) {
            b[i] -= m[i][k] * b[k];
        }
        b[i] /= m[i][i];
    }
    for (int i = 5; i >= 0; --i) {
        for (int k = i + 1; k < 6; ++k) {
            b[i] -= m[k][i] * b[k];
        }
        b[i] /= m[i][i];
    }
}

bool plii_mass_sum_solve(plii_mass_sum* sum) {
    double(*const m)[6] = sum->mass;
    const double least = MASS_SUM_LEAST_INERTIA * (m[3][3] + m[4][4] + m[5][5]);
    for (int k = 3; k < 6; ++k) {
        m[k][k] += least;
    }
    if (!plii_factorise6(m)) { return false; }
    plii_solve6((const double(*)[6])m, sum->momentum);
    return true;
}
