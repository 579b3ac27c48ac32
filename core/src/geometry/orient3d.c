/* Exact side-of-plane test: a double product with an error bound first, an exact sum where the bound does not decide.
   Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", 1997. */

#include "geometry/orient3d.h"

#include <float.h>

/* A value as a sum of doubles that do not overlap, smallest first. */
typedef struct exact_sum {
    int count;
    double terms[48];
} exact_sum;

static void exact_add(exact_sum* sum, double value) {
    int count = 0;
    double carry = value;
    for (int i = 0; i < sum->count; ++i) {
        const double term = sum->terms[i];
        const double total = carry + term;
        const double part = total - carry;
        const double rest = (carry - (total - part)) + (term - part);
        if (rest != 0.0) { sum->terms[count++] = rest; }
        carry = total;
    }
    if (carry != 0.0) { sum->terms[count++] = carry; }
    sum->count = count;
}

/* x * y of floats is exact in double; the product with z needs two doubles. */
static void exact_add_product(exact_sum* sum, double x, double y, double z) {
    const double xy = x * y;
    const double high = xy * z;
    exact_add(sum, fma(xy, z, -high));
    exact_add(sum, high);
}

static void exact_add_determinant(exact_sum* sum, double sign, pli_vec3 a, pli_vec3 b, pli_vec3 c) {
    const double ax = sign * (double)a.x, ay = sign * (double)a.y, az = sign * (double)a.z;
    exact_add_product(sum, ax, (double)b.y, (double)c.z);
    exact_add_product(sum, -ax, (double)b.z, (double)c.y);
    exact_add_product(sum, ay, (double)b.z, (double)c.x);
    exact_add_product(sum, -ay, (double)b.x, (double)c.z);
    exact_add_product(sum, az, (double)b.x, (double)c.y);
    exact_add_product(sum, -az, (double)b.y, (double)c.x);
}

static int orientation_exact(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3 p) {
    exact_sum sum = {0};
    exact_add_determinant(&sum, 1.0, b, c, p);
    exact_add_determinant(&sum, -1.0, a, c, p);
    exact_add_determinant(&sum, 1.0, a, b, p);
    exact_add_determinant(&sum, -1.0, a, b, c);
    const double largest = sum.count > 0 ? sum.terms[sum.count - 1] : 0.0;
    return (largest > 0.0) - (largest < 0.0);
}

int plii_orient3d(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3 p) {
    const double bx = (double)b.x - (double)a.x, by = (double)b.y - (double)a.y, bz = (double)b.z - (double)a.z;
    const double cx = (double)c.x - (double)a.x, cy = (double)c.y - (double)a.y, cz = (double)c.z - (double)a.z;
    const double px = (double)p.x - (double)a.x, py = (double)p.y - (double)a.y, pz = (double)p.z - (double)a.z;
    const double by_cz = by * cz, bz_cy = bz * cy, bz_cx = bz * cx, bx_cz = bx * cz, bx_cy = bx * cy, by_cx = by * cx;
    const double determinant = (by_cz - bz_cy) * px + (bz_cx - bx_cz) * py + (bx_cy - by_cx) * pz;
    const double magnitude = (fabs(by_cz) + fabs(bz_cy)) * fabs(px) + (fabs(bz_cx) + fabs(bx_cz)) * fabs(py) +
                             (fabs(bx_cy) + fabs(by_cx)) * fabs(pz);
    const double unit = DBL_EPSILON / 2.0;
    const double bound = (7.0 + 56.0 * unit) * unit * magnitude;
    if (determinant > bound) { return 1; }
    if (determinant < -bound) { return -1; }
    return magnitude == 0.0 ? 0 : orientation_exact(a, b, c, p);
}
