/* Lengths of links under XPBD in planes in AVX-512, sixteen at once. */

#define PLII_SIMD_AVX512
#include "xpbd_links_planes.inl"

void plii_xpbd_links_in_planes_avx512(const plii_xpbd_links_task* task, int color, int begin, int end) {
    xpbd_links_in_planes(task, color, begin, end);
}
