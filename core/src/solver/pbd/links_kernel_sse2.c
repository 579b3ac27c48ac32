/* Coloured links in SSE2. */

#define PLII_SIMD_SSE2
#include "solver/pbd/links_kernel.inl"

const plii_links_kernel plii_links_kernel_sse2 = {links_groups, links_serial, links_sweep};
