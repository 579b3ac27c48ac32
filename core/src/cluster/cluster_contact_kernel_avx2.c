/* Groups of contacts in AVX2. */

#include "cluster/cluster_contact_kernel.inl"

const plii_groups_kernel plii_groups_kernel_avx2 = {groups_prepare, groups_solve, groups_finish};
