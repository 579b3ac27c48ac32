/* Nearest rotations. Horn ("Closed-form solution of absolute orientation using unit quaternions", 1987): the wanted
   quaternion is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix, found by Jacobi's rotations. Where
   that eigenvalue is multiple, or nearly so, it is the part of the start in its eigenspace. In double, as the error in
   float would be 1e-7 over the relative gap of the singular values. */

#include "math/rotation_fit.h"

#include <string.h>

#define ROTATION_NEAR 1e-6       /* of the norm: eigenvalues so near to the largest share its eigenspace */
#define ROTATION_LEAST_PART 0.01 /* of the start, squared, that must lie in the eigenspace */
#define ROTATION_NOTHING 1e-30   /* of the norm */
#define ROTATION_SWEEPS 8        /* convergence is quadratic: six reach the precision of double */

/* Scales to length 1; false, and nothing changed, for what has no length or is not finite. */
static bool rotation_normalize(int count, double* values) {
    double squared = 0.0;
    for (int k = 0; k < count; ++k) {
        squared += values[k] * values[k];
    }
    if (!(squared > 0.0) || !isfinite(squared)) { return false; }
    for (int k = 0; k < count; ++k) {
        values[k] /= sqrt(squared);
    }
    return true;
}

static double rotation_dot(const double a[4], const double b[4]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/* Makes a symmetric matrix diagonal; the rows of `axes` become its eigenvectors. */
static void rotation_diagonalize(double n[4][4], double axes[4][4]) {
    for (int sweep = 0; sweep < ROTATION_SWEEPS; ++sweep) {
        for (int pair = 0; pair < 6; ++pair) {
            static const int rows[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
            const int p = rows[pair][0], q = rows[pair][1];
            if (fabs(n[p][q]) < ROTATION_NOTHING) { continue; }
            const double cotangent = (n[q][q] - n[p][p]) / (2.0 * n[p][q]);
            const double t = copysign(1.0, cotangent) / (fabs(cotangent) + sqrt(cotangent * cotangent + 1.0));
            const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
            for (int k = 0; k < 4; ++k) {
                const double from_p = n[k][p], from_q = n[k][q];
                n[k][p] = c * from_p - s * from_q;
                n[k][q] = s * from_p + c * from_q;
            }
            for (int k = 0; k < 4; ++k) {
                const double from_p = n[p][k], from_q = n[q][k], axis_p = axes[p][k], axis_q = axes[q][k];
                n[p][k] = c * from_p - s * from_q;
                n[q][k] = s * from_p + c * from_q;
                axes[p][k] = c * axis_p - s * axis_q;
                axes[q][k] = s * axis_p + c * axis_q;
            }
        }
    }
}

/* The part of the start in the eigenspace of the largest eigenvalue, unit. */
static void rotation_project(double n[4][4], double axes[4][4], const double start[4], double q[4]) {
    int largest = 0;
    for (int i = 1; i < 4; ++i) {
        if (n[i][i] > n[largest][largest]) { largest = i; }
    }
    for (int i = 0; i < 4; ++i) {
        /* Smoothly from all to nothing, lest a small change of the matrix makes a large one of the result. */
        const double near = ROTATION_NEAR / (n[largest][largest] - n[i][i] + ROTATION_NEAR);
        const double part = near * near * near * rotation_dot(axes[i], start);
        for (int k = 0; k < 4; ++k) {
            q[k] += part * axes[i][k];
        }
    }
    if (rotation_dot(q, q) > ROTATION_LEAST_PART && rotation_normalize(4, q)) { return; }
    const double sign = rotation_dot(axes[largest], start) < 0.0 ? -1.0 : 1.0;
    for (int k = 0; k < 4; ++k) {
        q[k] = sign * axes[largest][k];
    }
}

pli_mat3 plii_rotation_fit(const pli_mat3* matrix, pli_quat* quaternion) {
    const pli_vec3* rows = matrix->rows;
    /* Squares of floats neither overflow nor vanish in double. */
    double m[9] = {(double)rows[0].x, (double)rows[0].y, (double)rows[0].z, (double)rows[1].x, (double)rows[1].y,
                   (double)rows[1].z, (double)rows[2].x, (double)rows[2].y, (double)rows[2].z};
    double start[4] = {(double)quaternion->w, (double)quaternion->x, (double)quaternion->y, (double)quaternion->z};
    double q[4] = {0.0, 0.0, 0.0, 0.0};
    if (!rotation_normalize(4, start)) {
        start[0] = 1.0;
        start[1] = start[2] = start[3] = 0.0;
    }
    double n[4][4] = {{0.0}}, axes[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    if (rotation_normalize(9, m)) {
        const double trace = m[0] + m[4] + m[8];
        const double wx = m[7] - m[5], wy = m[2] - m[6], wz = m[3] - m[1];
        const double xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
        const double horn[4][4] = {{trace, wx, wy, wz},
                                   {wx, 2.0 * m[0] - trace, xy, xz},
                                   {wy, xy, 2.0 * m[4] - trace, yz},
                                   {wz, xz, yz, 2.0 * m[8] - trace}};
        memcpy(n, horn, sizeof n);
        rotation_diagonalize(n, axes);
    }
    rotation_project(n, axes, start, q);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    *quaternion = (pli_quat){.x = (float)x, .y = (float)y, .z = (float)z, .w = (float)w};
    return (pli_mat3){
        {{(float)(1.0 - 2.0 * (y * y + z * z)), (float)(2.0 * (x * y - w * z)), (float)(2.0 * (x * z + w * y))},
         {(float)(2.0 * (x * y + w * z)), (float)(1.0 - 2.0 * (x * x + z * z)), (float)(2.0 * (y * z - w * x))},
         {(float)(2.0 * (x * z - w * y)), (float)(2.0 * (y * z + w * x)), (float)(1.0 - 2.0 * (x * x + y * y))}}};
}
