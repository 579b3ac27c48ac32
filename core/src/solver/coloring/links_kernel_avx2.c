/* Lengths of links with AVX2. */

#define PLII_KERNEL_NAME(name) name##_avx2
#include "solver/coloring/links_kernel_base.c"
