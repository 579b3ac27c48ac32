/* Nodes under XPBD with AVX2. */

#define PLII_KERNEL_NAME(name) name##_avx2
#include "solver/xpbd/xpbd_nodes_base.c"
