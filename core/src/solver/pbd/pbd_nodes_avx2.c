/* Nodes of the position-based solver with AVX2. */

#define PLII_KERNEL_NAME(name) name##_avx2
#include "solver/pbd/pbd_nodes_base.c"
