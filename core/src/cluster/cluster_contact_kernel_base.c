/* Groups of contacts with what every processor of the target has. */

#include "cluster/cluster_contact_kernel.inl"

const plii_groups_kernel plii_groups_kernel_base = {groups_prepare, groups_solve, groups_finish};
