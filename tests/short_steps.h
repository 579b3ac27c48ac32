#ifndef TESTS_SHORT_STEPS_H
#define TESTS_SHORT_STEPS_H

/* For those who tamper with files of worlds: a header that fits, and whether what came of it can be stepped in time. */

#include "body/all_features.h"
#include "body/body_impl.h"
#include "file/file_impl.h"

#include <pliant/pliant.h>

static inline void file_seal_number(unsigned char* at, uint64_t number) {
    for (int i = 0; i < 8; ++i) {
        at[i] = (unsigned char)(number >> (8 * i));
    }
}

/* Size and checksum of at least a header. */
static inline void file_seal(unsigned char* bytes, size_t size) {
    file_seal_number(bytes + 16, size);
    file_seal_number(bytes + 24, plii_file_checksum(bytes + PLII_FILE_HEADER_SIZE, size - PLII_FILE_HEADER_SIZE));
}

/* As many iterations as a file may ask for take for ever. */
static inline bool has_short_steps(const pli_body* body) {
    enum { MOST = 100 };
    const pli_solver_settings settings = body->solver;
    bool is_short = settings.position_iterations < MOST && settings.velocity_iterations < MOST &&
                    settings.drift_iterations < MOST && body->joint_iterations < MOST;
    for (int i = 0; i < body->pipeline.feature_count; ++i) {
        const plii_feature* feature = &body->pipeline.features[i];
        if (feature->klass == &plii_xpbd_class) {
            const void* state = (const char*)feature->state + feature->klass->state_parts[0].offset; /* its def */
            const pli_xpbd_def* def = state;
            is_short = is_short && def->substeps < MOST && def->sweeps < MOST;
        }
        if (feature->klass == &plii_implicit_class) {
            const pli_implicit_def* def = feature->state;
            is_short = is_short && def->sweeps < MOST && def->finishing_iterations < MOST;
        }
    }
    return is_short;
}

#endif
