/* Lengths of links in SSE2. */

#define PLII_SIMD_SSE2
#include "solver/coloring/links_kernel.inl"

const plii_links_kernel plii_links_kernel_sse2 = {links_groups, links_serial};
