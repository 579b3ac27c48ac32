/* Lengths of links under XPBD in SSE2. */

#define PLII_SIMD_SSE2
#include "solver/xpbd/xpbd_links_kernel.inl"

const plii_xpbd_links_kernel plii_xpbd_links_kernel_sse2 = {xpbd_links_groups, xpbd_links_serial};
