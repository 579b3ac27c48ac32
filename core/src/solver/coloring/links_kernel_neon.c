/* Lengths of links in NEON. */

#define PLII_SIMD_NEON
#include "solver/coloring/links_kernel.inl"

const plii_links_kernel plii_links_kernel_neon = {links_groups, links_serial};
