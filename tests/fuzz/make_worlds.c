/* Writes small files of worlds into a folder: where the fuzzer of their reader begins. */

#define TRIAL_GRID 3
#define TRIAL_BALL 10
#include "state_trials.h"

#include <stdio.h>

static void write_trial(const char* folder, trial_kind kind, solver_choice solver) {
    trial t;
    start(&t, kind, solver, 1);
    for (int i = 0; i < BEFORE; ++i) {
        step(&t);
    }
    const size_t size = pli_world_file_size(t.world);
    void* bytes = malloc(size);
    assert_non_null(bytes);
    assert_int_equal(pli_world_file_write(t.world, NULL, bytes, size, NULL), PLI_OK);
    char path[512];
    snprintf(path, sizeof path, "%s/world_%d_%d", folder, (int)kind, (int)solver);
    FILE* file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
    free(bytes);
    end(&t);
}

int main(int argc, char** argv) {
    if (argc != 2) { return 2; }
    for (int kind = 0; kind < TRIAL_KINDS; ++kind) {
        for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
            if (has_trial((trial_kind)kind, (solver_choice)solver)) {
                write_trial(argv[1], (trial_kind)kind, (solver_choice)solver);
            }
        }
    }
    return 0;
}
