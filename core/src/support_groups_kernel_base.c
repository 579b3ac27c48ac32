/* Searches of packed coordinates with what every processor of the target has. */

#include "support_groups_kernel.inl"

const plii_support_kernel plii_support_kernel_base = {support_farthest, support_reach, support_find_way,
                                                      support_find_below};
