/* Nodes under XPBD with what every processor of the target has. */

#include "solver/xpbd/xpbd_nodes.inl"

const plii_xpbd_nodes_kernel plii_xpbd_nodes_base = NODES_KERNEL;
