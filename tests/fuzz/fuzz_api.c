/* Bytes as a sequence of calls of the public interface; see random_calls.h. */

#include "entry.h"

#include <random_calls.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static random_calls_report report;

static void print_report(void) {
    fprintf(stderr,
            "api: %" PRIu64 " sequences, %" PRIu64 " of at least 20 calls; %" PRIu64 " calls, %" PRIu64
            " refused; %" PRIu64 " steps, %" PRIu64 " bodies, %" PRIu64 " cuts, %" PRIu64 " bodies frozen, %" PRIu64
            " failed allocations\n",
            report.sequences, report.long_sequences, report.calls, report.refused, report.steps, report.bodies,
            report.cuts, report.events, report.failed_allocations);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static unsigned kinds;
    if (report.sequences == 0) {
        const char* chosen = getenv("PLIANT_FUZZ_KINDS");
        kinds = chosen != NULL ? (unsigned)strtoul(chosen, NULL, 0) : RANDOM_CALLS_ALL;
        atexit(print_report);
    }
    if (!random_calls_run(data, size, kinds, &report)) {
        fprintf(stderr, "finding: %s\n", report.finding);
        abort();
    }
    return 0;
}
