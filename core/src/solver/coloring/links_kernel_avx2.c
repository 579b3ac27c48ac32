/* Lengths of links with AVX2. */

#include "solver/coloring/links_kernel.inl"

const plii_links_kernel plii_links_kernel_avx2 = {links_groups, links_gather_vectors};
