/* Nodes under XPBD with AVX2. */

#include "solver/xpbd/xpbd_nodes.inl"

const plii_xpbd_nodes_kernel plii_xpbd_nodes_avx2 = NODES_KERNEL;
