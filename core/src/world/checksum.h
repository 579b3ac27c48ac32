#pragma once

/* Of large blocks, against damage by accident: sums, and sums of sums, of each eighth word. Any word that changes and
   any two that change places make it another one; of two that change in their highest bit alone, half of the places do.
   One kernel per instruction set, from checksum_base.c, as fast as the bytes come. */

#include "base/context.h"

#include <string.h>

enum { PLII_CHECKSUM_WORDS = 8, PLII_CHECKSUM_BLOCK = PLII_CHECKSUM_WORDS * (int)sizeof(uint64_t) };

typedef struct plii_checksum {
    uint64_t sums[PLII_CHECKSUM_WORDS], weighted[PLII_CHECKSUM_WORDS];
} plii_checksum;

/* Whole blocks, which are copied when `to` is given. */
typedef void plii_checksum_kernel(plii_checksum* checksum, unsigned char* to, const unsigned char* bytes, size_t size);
plii_checksum_kernel plii_checksum_blocks_base, plii_checksum_blocks_avx2;

/* What is left over of the last block counts as zeros: whole blocks but for the end. */
static inline void plii_checksum_add(const pli_context* context, plii_checksum* checksum, const unsigned char* bytes,
                                     size_t size) {
    const size_t left = size % PLII_CHECKSUM_BLOCK, whole = size - left;
    plii_checksum_kernel* add_blocks = PLII_KERNEL(context, plii_checksum_blocks);
    add_blocks(checksum, NULL, bytes, whole);
    if (left > 0) {
        unsigned char rest[PLII_CHECKSUM_BLOCK] = {0};
        memcpy(rest, bytes + whole, left);
        add_blocks(checksum, NULL, rest, sizeof rest);
    }
}

static inline void plii_checksum_end(const plii_checksum* checksum, uint64_t result[2]) {
    result[0] = result[1] = 0;
    for (int i = 0; i < PLII_CHECKSUM_WORDS; ++i) {
        result[0] = result[0] * UINT64_C(0x9e3779b97f4a7c15) + checksum->sums[i];
        result[1] = result[1] * UINT64_C(0xbf58476d1ce4e5b9) + checksum->weighted[i];
    }
}
