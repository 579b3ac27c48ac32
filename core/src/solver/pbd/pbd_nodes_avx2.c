/* Nodes of the position-based solver with AVX2. */

#include "solver/pbd/pbd_nodes.inl"

const plii_pbd_nodes_kernel plii_pbd_nodes_avx2 = NODES_KERNEL;
