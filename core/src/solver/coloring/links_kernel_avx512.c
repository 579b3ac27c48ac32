/* Lengths of links with AVX-512. */

#define PLII_WIDE_OF_SIXTEEN
#define PLII_KERNEL_NAME(name) name##_avx512
#include "solver/coloring/links_kernel_base.c"
