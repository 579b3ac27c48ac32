/* Lengths of links under XPBD in NEON. */

#define PLII_SIMD_NEON
#include "solver/xpbd/xpbd_links_kernel.inl"

const plii_xpbd_links_kernel plii_xpbd_links_kernel_neon = {xpbd_links_groups, xpbd_links_serial};
