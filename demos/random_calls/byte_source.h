#ifndef RANDOM_CALLS_BYTE_SOURCE_H
#define RANDOM_CALLS_BYTE_SOURCE_H

/* Values out of bytes: mostly sensible ones, sometimes those at the border of what is allowed, sometimes the bits of a
   float. Behind the last byte all is 0. What is read does not depend on `is_tame`, so bytes mean the same calls. */

#include <pliant/math.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct byte_source {
    const uint8_t* at;
    const uint8_t* end;
    bool is_tame; /* floats are sensible only */
} byte_source;

bool bytes_are_done(const byte_source* bytes);
int bytes_next(byte_source* bytes);
/* [0, count), 1 to 256 of them */
int bytes_below(byte_source* bytes, int count);
bool bytes_flag(byte_source* bytes);
/* True for `share` of 256. */
bool bytes_seldom(byte_source* bytes, int share);

/* [least, most], seldom one below or 0 */
int bytes_small(byte_source* bytes, int least, int most);
/* [least, most], seldom any border of int */
int bytes_count(byte_source* bytes, int least, int most);
/* An index of `count` things, seldom one that is none. */
int bytes_index(byte_source* bytes, int count);

/* [least, most], seldom a border of float or any bits */
float bytes_float(byte_source* bytes, float least, float most);
pli_vec3 bytes_vec3(byte_source* bytes, float least, float most);
/* A rotation, seldom a matrix that is none. */
pli_mat3 bytes_rotation(byte_source* bytes);
pli_transform bytes_transform(byte_source* bytes, float reach);

#endif
