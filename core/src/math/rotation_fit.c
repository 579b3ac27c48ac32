/* Nearest rotations. Horn ("Closed-form solution of absolute orientation using unit quaternions", 1987): the wanted
   quaternion is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix. Laguerre's iteration finds the
   eigenvalue from above, and the adjugate of the matrix shifted just beyond it, applied to the start a few times, the
   eigenvector: inverse iteration without a division. Where the eigenvalue is multiple, what is left is the part of the
   start in its eigenspace. In double, as the error in float would be 1e-7 over the relative gap of the singular values.
 */

#include "math/rotation_fit.h"

#define ROTATION_SHIFT 1e-6      /* beyond the largest eigenvalue, for matrices of norm 1 */
#define ROTATION_LEAST_PART 0.01 /* of the start, squared, that must lie in the eigenspace */
#define ROTATION_FLAT 1e-7       /* least slope: at a double root there is only rounding left */
#define ROTATION_SMALL_STEP 1e-4 /* the next one, of a cubic iteration, is below 1e-8 */
#define ROTATION_TINY 1e-100
#define ROTATION_HUGE 1e100

/* One step down towards the largest root of x^4 - 2 x^2 + c1 x + c0, whose roots are all real. */
static double rotation_laguerre(double x, double c1, double c0) {
    const double xx = x * x;
    const double p = (xx - 2.0) * xx + c1 * x + c0;
    const double p1 = 4.0 * (xx - 1.0) * x + c1;
    const double p2 = 12.0 * xx - 4.0;
    const double squared = 9.0 * p1 * p1 - 12.0 * p * p2;
    const double slope = p1 + sqrt(squared > 0.0 ? squared : 0.0);
    const double step = 4.0 * p / (slope > ROTATION_FLAT ? slope : ROTATION_FLAT);
    return p > 0.0 ? x - step : x;
}

/* 1 / sqrt(squared), 0 where that is not a positive number. */
static double rotation_inverse_length(double squared) {
    const double inverse = 1.0 / sqrt(squared > 0.0 ? squared : 1.0);
    const double bounded = squared < ROTATION_HUGE ? inverse : 0.0;
    return squared > 0.0 ? bounded : 0.0;
}

typedef struct rotation_problem {
    double matrix[9]; /* in the order of rows; of norm 1, zero when useless */
    double start[4];  /* w, x, y, z; of length 1, identity when useless */
} rotation_problem;

/* Squares of floats neither overflow nor vanish in double. Zero matrices lead to the start. */
static rotation_problem rotation_norm(pli_mat3 m, pli_quat q) {
    rotation_problem problem = {{(double)m.rows[0].x, (double)m.rows[0].y, (double)m.rows[0].z, (double)m.rows[1].x,
                                 (double)m.rows[1].y, (double)m.rows[1].z, (double)m.rows[2].x, (double)m.rows[2].y,
                                 (double)m.rows[2].z},
                                {1.0, 0.0, 0.0, 0.0}};
    double squared = 0.0;
    for (int k = 0; k < 9; ++k) {
        squared += problem.matrix[k] * problem.matrix[k];
    }
    const double scale = rotation_inverse_length(squared);
    for (int k = 0; k < 9; ++k) {
        problem.matrix[k] = scale > 0.0 ? problem.matrix[k] * scale : 0.0;
    }
    const double w = (double)q.w, x = (double)q.x, y = (double)q.y, z = (double)q.z;
    const double start_scale = rotation_inverse_length(w * w + x * x + y * y + z * z);
    if (start_scale > 0.0) {
        problem.start[0] = w * start_scale;
        problem.start[1] = x * start_scale;
        problem.start[2] = y * start_scale;
        problem.start[3] = z * start_scale;
    }
    return problem;
}

/* The largest eigenvalue. */
static double rotation_root(const double m[9]) {
    const double a = m[0], b = m[1], c = m[2], d = m[3], e = m[4], f = m[5], g = m[6], h = m[7], k = m[8];
    const double c00 = e * k - f * h, c01 = f * g - d * k, c02 = d * h - e * g;
    const double c10 = c * h - b * k, c11 = a * k - c * g, c12 = b * g - a * h;
    const double c20 = b * f - c * e, c21 = c * d - a * f, c22 = a * e - b * d;
    const double cofactors =
        c00 * c00 + c01 * c01 + c02 * c02 + c10 * c10 + c11 * c11 + c12 * c12 + c20 * c20 + c21 * c21 + c22 * c22;
    const double c1 = -8.0 * (a * c00 + b * c01 + c * c02), c0 = 1.0 - 4.0 * cofactors;

    /* The sum of the singular values, squared, is 1 plus twice the sum of their products. */
    double x = sqrt(1.0 + 3.4641016151377544 * sqrt(cofactors));
    x = rotation_laguerre(x, c1, c0);
    x = rotation_laguerre(x, c1, c0);
    const double next = rotation_laguerre(x, c1, c0);
    /* More steps where the last was not small: nearly multiple roots. */
    const int more = x - next < ROTATION_SMALL_STEP ? 0 : 6;
    x = next;
    for (int i = 0; i < more; ++i) {
        x = rotation_laguerre(x, c1, c0);
    }
    return x;
}

/* The eigenvector. */
static void rotation_eigenvector(const rotation_problem* problem, double x, double result[4]) {
    const double *m = problem->matrix, *start = problem->start;
    const double a = m[0], b = m[1], c = m[2], d = m[3], e = m[4], f = m[5], g = m[6], h = m[7], k = m[8];
    /* Upper half of the 4x4 matrix less x. */
    const double n00 = a + e + k - x, n01 = h - f, n02 = c - g, n03 = d - b;
    const double n11 = a - e - k - x, n12 = b + d, n13 = c + g;
    const double n22 = e - a - k - x, n23 = f + h;
    const double n33 = k - a - e - x;
    /* Minors of the upper and of the lower two rows. */
    const double s0 = n00 * n11 - n01 * n01, s1 = n00 * n12 - n01 * n02, s2 = n00 * n13 - n01 * n03;
    const double s3 = n01 * n12 - n11 * n02, s4 = n01 * n13 - n11 * n03, s5 = n02 * n13 - n12 * n03;
    const double t1 = n02 * n23 - n22 * n03, t2 = n02 * n33 - n23 * n03;
    const double t3 = n12 * n23 - n22 * n13, t4 = n12 * n33 - n23 * n13, t5 = n22 * n33 - n23 * n23;
    const double m00 = n11 * t5 - n12 * t4 + n13 * t3;
    const double m01 = n02 * t4 - n01 * t5 - n03 * t3;
    const double m02 = n13 * s5 - n23 * s4 + n33 * s3;
    const double m03 = n22 * s4 - n12 * s5 - n23 * s3;
    const double m11 = n00 * t5 - n02 * t2 + n03 * t1;
    const double m12 = n23 * s2 - n03 * s5 - n33 * s1;
    const double m13 = n02 * s5 - n22 * s2 + n23 * s1;
    const double m22 = n03 * s4 - n13 * s2 + n33 * s0;
    const double m23 = n12 * s2 - n02 * s4 - n23 * s0;
    const double m33 = n02 * s3 - n12 * s1 + n22 * s0;

    /* The start, or the largest column when the start lies across. */
    const double norm = m00 * m00 + m11 * m11 + m22 * m22 + m33 * m33 +
                        2.0 * (m01 * m01 + m02 * m02 + m03 * m03 + m12 * m12 + m13 * m13 + m23 * m23);
    const double w = start[0], sx = start[1], y = start[2], z = start[3];
    double qw = m00 * w + m01 * sx + m02 * y + m03 * z, qx = m01 * w + m11 * sx + m12 * y + m13 * z;
    double qy = m02 * w + m12 * sx + m22 * y + m23 * z, qz = m03 * w + m13 * sx + m23 * y + m33 * z;
    const double d0 = fabs(m00), d1 = fabs(m11), d2 = fabs(m22), d3 = fabs(m33);
    const double upper = d0 > d1 ? d0 : d1, lower = d2 > d3 ? d2 : d3;
    const double uw = d0 > d1 ? m00 : m01, ux = d0 > d1 ? m01 : m11;
    const double uy = d0 > d1 ? m02 : m12, uz = d0 > d1 ? m03 : m13;
    const double lw = d2 > d3 ? m02 : m03, lx = d2 > d3 ? m12 : m13;
    const double ly = d2 > d3 ? m22 : m23, lz = d2 > d3 ? m23 : m33;
    const double part = qw * qw + qx * qx + qy * qy + qz * qz;
    const double least = ROTATION_LEAST_PART * norm;
    const double vw = upper > lower ? uw : lw, vx = upper > lower ? ux : lx;
    const double vy = upper > lower ? uy : ly, vz = upper > lower ? uz : lz;
    qw = part > least ? qw : vw;
    qx = part > least ? qx : vx;
    qy = part > least ? qy : vy;
    qz = part > least ? qz : vz;

    /* Twice more, at about unit length. */
    const double scale = 1.0 / (sqrt(norm) + ROTATION_TINY);
    const double scale2 = scale * scale;
    const double rw = (m00 * qw + m01 * qx + m02 * qy + m03 * qz) * scale2;
    const double rx = (m01 * qw + m11 * qx + m12 * qy + m13 * qz) * scale2;
    const double ry = (m02 * qw + m12 * qx + m22 * qy + m23 * qz) * scale2;
    const double rz = (m03 * qw + m13 * qx + m23 * qy + m33 * qz) * scale2;
    const double ow = (m00 * rw + m01 * rx + m02 * ry + m03 * rz) * scale;
    const double ox = (m01 * rw + m11 * rx + m12 * ry + m13 * rz) * scale;
    const double oy = (m02 * rw + m12 * rx + m22 * ry + m23 * rz) * scale;
    const double oz = (m03 * rw + m13 * rx + m23 * ry + m33 * rz) * scale;

    const double length_squared = ow * ow + ox * ox + oy * oy + oz * oz;
    const double along = ow * w + ox * sx + oy * y + oz * z;
    const double inverse = (along < 0.0 ? -1.0 : 1.0) / (sqrt(length_squared) + ROTATION_TINY);
    result[0] = length_squared > ROTATION_TINY ? ow * inverse : w;
    result[1] = length_squared > ROTATION_TINY ? ox * inverse : sx;
    result[2] = length_squared > ROTATION_TINY ? oy * inverse : y;
    result[3] = length_squared > ROTATION_TINY ? oz * inverse : z;
}

static pli_mat3 rotation_matrix(double w, double x, double y, double z) {
    pli_mat3 m;
    m.rows[0] = pli_vec3_make((float)(1.0 - 2.0 * (y * y + z * z)), (float)(2.0 * (x * y - w * z)),
                              (float)(2.0 * (x * z + w * y)));
    m.rows[1] = pli_vec3_make((float)(2.0 * (x * y + w * z)), (float)(1.0 - 2.0 * (x * x + z * z)),
                              (float)(2.0 * (y * z - w * x)));
    m.rows[2] = pli_vec3_make((float)(2.0 * (x * z - w * y)), (float)(2.0 * (y * z + w * x)),
                              (float)(1.0 - 2.0 * (x * x + y * y)));
    return m;
}

pli_mat3 plii_rotation_fit(const pli_mat3* matrix, pli_quat* quaternion) {
    const rotation_problem problem = rotation_norm(*matrix, *quaternion);
    double q[4];
    rotation_eigenvector(&problem, rotation_root(problem.matrix) + ROTATION_SHIFT, q);
    *quaternion = (pli_quat){.x = (float)q[1], .y = (float)q[2], .z = (float)q[3], .w = (float)q[0]};
    return rotation_matrix(q[0], q[1], q[2], q[3]);
}
