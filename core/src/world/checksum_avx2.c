/* Checksums with AVX2. */

#define PLII_KERNEL_NAME(name) name##_avx2
#include "world/checksum_base.c"
