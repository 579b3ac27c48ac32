/* Nodes of the position-based solver with what every processor of the target has. */

#include "solver/pbd/pbd_nodes.inl"

const plii_pbd_nodes_kernel plii_pbd_nodes_base = NODES_KERNEL;
