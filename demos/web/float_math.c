/* The mathematical functions of single precision by those of double precision, whose results, rounded, do not depend on
   the C library but for one argument in some hundred million. C libraries differ in the last bit of the originals.
   Part of the module; built as a shared library and loaded first, it gives the native program the same functions. */

#include <math.h>

float acosf(float x) {
    return (float)acos((double)x);
}

float asinf(float x) {
    return (float)asin((double)x);
}

float atan2f(float y, float x) {
    return (float)atan2((double)y, (double)x);
}

float cosf(float x) {
    return (float)cos((double)x);
}

float sinf(float x) {
    return (float)sin((double)x);
}

/* Compilers make one call of a sine and a cosine of the same angle. */
void sincosf(float x, float* sine, float* cosine);
void sincosf(float x, float* sine, float* cosine) {
    *sine = sinf(x);
    *cosine = cosf(x);
}

float expf(float x) {
    return (float)exp((double)x);
}

float logf(float x) {
    return (float)log((double)x);
}

float powf(float x, float y) {
    return (float)pow((double)x, (double)y);
}

float hypotf(float x, float y) {
    return (float)sqrt((double)x * (double)x + (double)y * (double)y);
}
