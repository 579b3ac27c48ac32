/* Coloured links in AVX-512VL: the code of AVX2, in which the nodes of a quad take all sixteen registers, with as many
   again for what is made of them. */

#define PLII_SIMD_AVX2
#include "links_kernel.inl"

const plii_links_kernel plii_links_kernel_avx512 = {links_runs, links_in_planes, links_groups, links_serial,
                                                    links_sweep};
