#pragma once

/* Of large blocks, against damage by accident. */

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef uint64_t plii_checksum_lanes __attribute__((vector_size(16)));
enum { PLII_CHECKSUM_LANES = 4, PLII_CHECKSUM_BLOCK = PLII_CHECKSUM_LANES * (int)sizeof(plii_checksum_lanes) };

/* Sums, and sums of sums, by lanes: any word that changes and any two that change places make it another one; of two
   that change in their highest bit alone, half of the places do. As fast as the bytes come. */
typedef struct plii_checksum {
    plii_checksum_lanes sums[PLII_CHECKSUM_LANES], weighted[PLII_CHECKSUM_LANES];
} plii_checksum;

static inline plii_checksum_lanes plii_checksum_take(unsigned char* to, const unsigned char* from, size_t at) {
    plii_checksum_lanes words;
    memcpy(&words, from + at, sizeof words);
    if (to != NULL) { memcpy(to + at, &words, sizeof words); }
    return words;
}

/* Whole blocks, which are copied when `to` is given. The sums of four lanes are kept in registers. Inlined, so that a
   NULL costs nothing in the loop. */
__attribute__((always_inline)) static inline void plii_checksum_add_blocks(plii_checksum* checksum, unsigned char* to,
                                                                           const unsigned char* bytes, size_t size) {
    plii_checksum_lanes *sums = checksum->sums, *weighted = checksum->weighted;
    plii_checksum_lanes s0 = sums[0], s1 = sums[1], s2 = sums[2], s3 = sums[3];
    plii_checksum_lanes w0 = weighted[0], w1 = weighted[1], w2 = weighted[2], w3 = weighted[3];
    const size_t width = sizeof(plii_checksum_lanes);
    for (size_t at = 0; at < size; at += PLII_CHECKSUM_BLOCK) {
        w0 += s0 += plii_checksum_take(to, bytes, at);
        w1 += s1 += plii_checksum_take(to, bytes, at + width);
        w2 += s2 += plii_checksum_take(to, bytes, at + 2 * width);
        w3 += s3 += plii_checksum_take(to, bytes, at + 3 * width);
    }
    sums[0] = s0, sums[1] = s1, sums[2] = s2, sums[3] = s3;
    weighted[0] = w0, weighted[1] = w1, weighted[2] = w2, weighted[3] = w3;
}

/* What is left over of the last block counts as zeros: whole blocks but for the end. */
static inline void plii_checksum_add(plii_checksum* checksum, const unsigned char* bytes, size_t size) {
    const size_t left = size % PLII_CHECKSUM_BLOCK, whole = size - left;
    plii_checksum_add_blocks(checksum, NULL, bytes, whole);
    if (left > 0) {
        unsigned char rest[PLII_CHECKSUM_BLOCK] = {0};
        memcpy(rest, bytes + whole, left);
        plii_checksum_add_blocks(checksum, NULL, rest, sizeof rest);
    }
}

static inline void plii_checksum_end(const plii_checksum* checksum, uint64_t result[2]) {
    result[0] = result[1] = 0;
    for (int k = 0; k < PLII_CHECKSUM_LANES; ++k) {
        for (int i = 0; i < 2; ++i) {
            result[0] = result[0] * UINT64_C(0x9e3779b97f4a7c15) + checksum->sums[k][i];
            result[1] = result[1] * UINT64_C(0xbf58476d1ce4e5b9) + checksum->weighted[k][i];
        }
    }
}
