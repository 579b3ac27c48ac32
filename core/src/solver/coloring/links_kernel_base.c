/* Lengths of links with what every processor of the target has. */

#include "solver/coloring/links_kernel.inl"

const plii_links_kernel plii_links_kernel_base = {links_groups, links_gather_vectors};
