/* Groups of contacts with AVX2. */

#define PLII_KERNEL_NAME(name) name##_avx2
#include "contact/node_rigid_groups_base.c"
