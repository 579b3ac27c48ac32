#include "math/simd_float8.h"
#include "world/checksum.h"

#if defined(__AVX2__)
typedef uint64_t checksum_lanes __attribute__((vector_size(32)));
#else
typedef uint64_t checksum_lanes __attribute__((vector_size(16)));
#endif
enum { CHECKSUM_LANES = PLII_CHECKSUM_BLOCK / (int)sizeof(checksum_lanes) }; /* of a block */

/* Inlined, so that a NULL costs nothing in the loop. The sums are kept in registers. */
PLII_SIMD_INLINE void checksum_sum_up(plii_checksum* checksum, unsigned char* to, const unsigned char* bytes,
                                      size_t size) {
    checksum_lanes sums[CHECKSUM_LANES], weighted[CHECKSUM_LANES];
    memcpy(sums, checksum->sums, sizeof sums);
    memcpy(weighted, checksum->weighted, sizeof weighted);
    for (size_t at = 0; at < size; at += PLII_CHECKSUM_BLOCK) {
        PLII_UNROLL(4)
        for (size_t k = 0; k < CHECKSUM_LANES; ++k) {
            checksum_lanes words;
            memcpy(&words, bytes + at + k * sizeof words, sizeof words);
            if (to != NULL) { memcpy(to + at + k * sizeof words, &words, sizeof words); }
            sums[k] += words;
            weighted[k] += sums[k];
        }
    }
    memcpy(checksum->sums, sums, sizeof sums);
    memcpy(checksum->weighted, weighted, sizeof weighted);
}

void PLII_KERNEL_NAME(plii_checksum_blocks)(plii_checksum* checksum, unsigned char* to, const unsigned char* bytes,
                                            size_t size) {
    if (to != NULL) {
        checksum_sum_up(checksum, to, bytes, size);
    } else {
        checksum_sum_up(checksum, NULL, bytes, size);
    }
}
