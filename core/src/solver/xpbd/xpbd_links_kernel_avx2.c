/* Lengths of links under XPBD in AVX2. */

#define PLII_SIMD_AVX2
#include "solver/xpbd/xpbd_links_kernel.inl"

const plii_xpbd_links_kernel plii_xpbd_links_kernel_avx2 = {xpbd_links_groups, xpbd_links_serial};
