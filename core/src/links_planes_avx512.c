/* Coloured links in planes in AVX-512, sixteen at once. */

#define PLII_SIMD_AVX512
#include "links_planes.inl"

void plii_links_in_planes_avx512(const plii_links_task* task, int color, int begin, int end) {
    links_in_planes(task, color, begin, end);
}
