/* Groups of contacts in AVX2. */

#include "cluster/cluster_contact_kernel.inl"

const plii_contact_kernel plii_contact_kernel_avx2 = {groups_prepare, groups_solve, groups_finish};
