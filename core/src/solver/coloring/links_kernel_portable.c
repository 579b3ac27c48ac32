/* Lengths of links in plain C. */

#define PLII_SIMD_PORTABLE
#include "solver/coloring/links_kernel.inl"

const plii_links_kernel plii_links_kernel_portable = {links_groups, links_serial};
