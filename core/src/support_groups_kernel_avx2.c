/* Searches of packed coordinates in AVX2. */

#include "support_groups_kernel.inl"

const plii_support_kernel plii_support_kernel_avx2 = {support_farthest, support_reach, support_find_way,
                                                      support_find_below};
