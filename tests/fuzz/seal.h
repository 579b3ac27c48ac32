#ifndef TESTS_FUZZ_SEAL_H
#define TESTS_FUZZ_SEAL_H

/* short_steps.h for C++, which has the core's own headers. */

#include <pliant/world.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Nothing where `size` is less than a header. */
void seal_world_file(unsigned char* bytes, size_t size);
bool world_has_short_steps(const pli_world* world);

#ifdef __cplusplus
}
#endif

#endif
