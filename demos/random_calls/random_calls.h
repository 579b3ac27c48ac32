#ifndef RANDOM_CALLS_H
#define RANDOM_CALLS_H

/* Bytes as a sequence of calls of the public interface, with a check after each: known statuses, a message with every
   error, no change by a refused call, finite bodies and rigid bodies, and in the end no memory left. Same bytes, same
   calls. For fuzzers and for soak runs. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What may be in a sequence beside sensible calls. */
enum {
    RANDOM_CALLS_EXTREMES = 1,    /* floats at the borders of what they can be, and of any bits */
    RANDOM_CALLS_ALLOCATIONS = 2, /* allocations that fail */
    RANDOM_CALLS_CALLBACKS = 4,   /* callbacks that call what they must not */
    RANDOM_CALLS_MIXTURES = 8,    /* meshes and shapes of one context in worlds of another */
    RANDOM_CALLS_ALL = 15,
    RANDOM_CALLS_TRACE = 16 /* a line per call on the standard error output */
};

/* What happened, summed up over all runs with the same report. */
typedef struct random_calls_report {
    uint64_t sequences, long_sequences; /* long: of at least 20 calls */
    uint64_t calls, refused, steps, bodies, rigids, cuts, events, failed_allocations;
    uint64_t digest;   /* of everything that the last run saw */
    char finding[256]; /* what the last run found, empty: nothing */
} random_calls_report;

/* False when a check failed, with what it was in `report->finding`. */
bool random_calls_run(const uint8_t* data, size_t size, unsigned kinds, random_calls_report* report);

#ifdef __cplusplus
}
#endif
#endif
