#ifndef TESTS_UNIT_HASH_MIX_H
#define TESTS_UNIT_HASH_MIX_H

#include <stddef.h>
#include <stdint.h>

#define HASH_START 0xcbf29ce484222325u

/* FNV-1a. */
static inline uint64_t hash_mix(uint64_t hash, const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i) {
        hash = (hash ^ ((const unsigned char*)data)[i]) * 0x100000001b3u;
    }
    return hash;
}

#endif
