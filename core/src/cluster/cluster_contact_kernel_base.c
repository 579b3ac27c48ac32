/* Groups of contacts with what every processor of the target has. */

#include "cluster/cluster_contact_kernel.inl"

const plii_contact_kernel plii_contact_kernel_base = {groups_prepare, groups_solve, groups_finish};
