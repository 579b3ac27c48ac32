/* Nearest rotations without branches, so that compilers work on several matrices at once. Horn ("Closed-form solution
   of absolute orientation using unit quaternions", 1987): the wanted quaternion is the eigenvector of the largest
   eigenvalue of a symmetric 4x4 matrix. Laguerre's iteration finds the eigenvalue from above, and the adjugate of the
   matrix shifted just beyond it, applied to the start a few times, the eigenvector: inverse iteration without a
   division. Where the eigenvalue is multiple, what is left is the part of the start in its eigenspace. In double, as
   the error in float would be 1e-7 over the relative gap of the singular values. */

#include "rotation_batch.h"

#define LANES PLII_ROTATION_LANES
#define ROTATION_SHIFT 1e-6      /* beyond the largest eigenvalue, for matrices of norm 1 */
#define ROTATION_LEAST_PART 0.01 /* of the start, squared, that must lie in the eigenspace */
#define ROTATION_FLAT 1e-7       /* least slope: at a double root there is only rounding left */
#define ROTATION_SMALL_STEP 1e-4 /* the next one, of a cubic iteration, is below 1e-8 */
#define ROTATION_TINY 1e-100
#define ROTATION_HUGE 1e100

typedef struct rotation_block {
    double matrix[9][LANES]; /* in the order of rows; normed in place, zero when useless */
    double start[4][LANES];  /* w, x, y, z; normed in place, identity when useless */
    double result[4][LANES];
    double c1[LANES], c0[LANES]; /* of the characteristic polynomial */
    double root[LANES], step[LANES];
} rotation_block;

/* One step down towards the largest root of x^4 - 2 x^2 + c1 x + c0, whose roots are all real. */
static inline double rotation_laguerre(double x, double c1, double c0) {
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
static inline double rotation_inverse_length(double squared) {
    const double inverse = 1.0 / sqrt(squared > 0.0 ? squared : 1.0);
    const double bounded = squared < ROTATION_HUGE ? inverse : 0.0;
    return squared > 0.0 ? bounded : 0.0;
}

/* Squares of floats neither overflow nor vanish in double. Zero matrices lead to the start. */
static void rotation_norm(rotation_block* restrict block) {
    double squared[LANES] = {0.0}, scale[LANES];
    for (int k = 0; k < 9; ++k) {
        for (int i = 0; i < LANES; ++i) {
            squared[i] += block->matrix[k][i] * block->matrix[k][i];
        }
    }
    for (int i = 0; i < LANES; ++i) {
        scale[i] = rotation_inverse_length(squared[i]);
    }
    for (int k = 0; k < 9; ++k) {
        for (int i = 0; i < LANES; ++i) {
            const double scaled = block->matrix[k][i] * scale[i];
            block->matrix[k][i] = scale[i] > 0.0 ? scaled : 0.0;
        }
    }
    for (int i = 0; i < LANES; ++i) {
        const double w = block->start[0][i], x = block->start[1][i], y = block->start[2][i], z = block->start[3][i];
        const double start_scale = rotation_inverse_length(w * w + x * x + y * y + z * z);
        const double sw = w * start_scale, sx = x * start_scale, sy = y * start_scale, sz = z * start_scale;
        block->start[0][i] = start_scale > 0.0 ? sw : 1.0;
        block->start[1][i] = start_scale > 0.0 ? sx : 0.0;
        block->start[2][i] = start_scale > 0.0 ? sy : 0.0;
        block->start[3][i] = start_scale > 0.0 ? sz : 0.0;
    }
}

/* The largest eigenvalue by a few steps, which is enough for most. */
static void rotation_find_root(rotation_block* restrict block) {
    for (int i = 0; i < LANES; ++i) {
        const double a = block->matrix[0][i], b = block->matrix[1][i], c = block->matrix[2][i];
        const double d = block->matrix[3][i], e = block->matrix[4][i], f = block->matrix[5][i];
        const double g = block->matrix[6][i], h = block->matrix[7][i], k = block->matrix[8][i];

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
        block->c1[i] = c1;
        block->c0[i] = c0;
        block->root[i] = next;
        block->step[i] = x - next;
    }
}

/* More steps where the last was not small: nearly multiple roots. A lane that was done keeps its root, whatever its
   neighbours need. */
static void rotation_refine_root(rotation_block* restrict block) {
    bool is_done = true;
    for (int i = 0; i < LANES; ++i) {
        is_done = is_done && block->step[i] < ROTATION_SMALL_STEP;
    }
    if (is_done) { return; }
    for (int i = 0; i < LANES; ++i) {
        const double c1 = block->c1[i], c0 = block->c0[i];
        double x = block->root[i];
        x = rotation_laguerre(x, c1, c0);
        x = rotation_laguerre(x, c1, c0);
        x = rotation_laguerre(x, c1, c0);
        x = rotation_laguerre(x, c1, c0);
        x = rotation_laguerre(x, c1, c0);
        x = rotation_laguerre(x, c1, c0);
        block->root[i] = block->step[i] < ROTATION_SMALL_STEP ? block->root[i] : x;
    }
}

/* The eigenvector. */
static void rotation_find_quaternion(rotation_block* restrict block) {
    for (int i = 0; i < LANES; ++i) {
        const double a = block->matrix[0][i], b = block->matrix[1][i], c = block->matrix[2][i];
        const double d = block->matrix[3][i], e = block->matrix[4][i], f = block->matrix[5][i];
        const double g = block->matrix[6][i], h = block->matrix[7][i], k = block->matrix[8][i];
        const double x = block->root[i] + ROTATION_SHIFT;

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
        const double w = block->start[0][i], sx = block->start[1][i], y = block->start[2][i], z = block->start[3][i];
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
        block->result[0][i] = length_squared > ROTATION_TINY ? ow * inverse : w;
        block->result[1][i] = length_squared > ROTATION_TINY ? ox * inverse : sx;
        block->result[2][i] = length_squared > ROTATION_TINY ? oy * inverse : y;
        block->result[3][i] = length_squared > ROTATION_TINY ? oz * inverse : z;
    }
}

static void rotation_load(rotation_block* block, int lane, pli_mat3 m, pli_quat q) {
    for (int k = 0; k < 3; ++k) {
        block->matrix[3 * k][lane] = (double)m.rows[k].x;
        block->matrix[3 * k + 1][lane] = (double)m.rows[k].y;
        block->matrix[3 * k + 2][lane] = (double)m.rows[k].z;
    }
    block->start[0][lane] = (double)q.w;
    block->start[1][lane] = (double)q.x;
    block->start[2][lane] = (double)q.y;
    block->start[3][lane] = (double)q.z;
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

void plii_rotation_batch(int count, const pli_mat3* matrices, pli_quat* quaternions, pli_mat3* rotations) {
    for (int begin = 0; begin < count; begin += LANES) {
        const int lane_count = count - begin < LANES ? count - begin : LANES;
        rotation_block block;
        for (int i = 0; i < LANES; ++i) {
            const int source = begin + (i < lane_count ? i : 0); /* surplus lanes repeat the first */
            rotation_load(&block, i, matrices[source], quaternions[source]);
        }
        rotation_norm(&block);
        rotation_find_root(&block);
        rotation_refine_root(&block);
        rotation_find_quaternion(&block);
        for (int i = 0; i < lane_count; ++i) {
            const double w = block.result[0][i], x = block.result[1][i];
            const double y = block.result[2][i], z = block.result[3][i];
            quaternions[begin + i] = (pli_quat){.x = (float)x, .y = (float)y, .z = (float)z, .w = (float)w};
            if (rotations != NULL) { rotations[begin + i] = rotation_matrix(w, x, y, z); }
        }
    }
}
