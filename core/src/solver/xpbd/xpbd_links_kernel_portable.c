/* Lengths of links under XPBD in plain C. */

#define PLII_SIMD_PORTABLE
#include "solver/xpbd/xpbd_links_kernel.inl"

const plii_xpbd_links_kernel plii_xpbd_links_kernel_portable = {xpbd_links_groups, xpbd_links_serial};
