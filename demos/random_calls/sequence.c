/* A sequence of calls. */

#include "calls.h"

#include <stdlib.h>
#include <string.h>

/* As often as it stands there. */
static calls_fn* const choices[] = {
    calls_make_mesh,
    calls_make_mesh,
    calls_edit_mesh,
    calls_edit_mesh,
    calls_make_shape,
    calls_make_shape,
    calls_use_shape,
    calls_make_world,
    calls_make_body,
    calls_make_body,
    calls_make_rigid,
    calls_make_rigid,
    calls_set_up_body,
    calls_set_up_body,
    calls_move_body,
    calls_move_body,
    calls_save_state,
    calls_set_state_back,
    calls_measure_body,
    calls_change_feature,
    calls_change_feature,
    calls_change_feature,
    calls_change_feature,
    calls_change_feature,
    calls_change_feature,
    calls_change_feature,
    calls_change_solver,
    calls_change_solver,
    calls_change_solver,
    calls_change_clusters,
    calls_change_clusters,
    calls_change_clusters,
    calls_add_joint,
    calls_add_joint,
    calls_cut,
    calls_cut,
    calls_cut,
    calls_change_rigid,
    calls_change_rigid,
    calls_add_anchor,
    calls_add_anchor,
    calls_step,
    calls_step,
    calls_step,
    calls_step,
    calls_step,
    calls_step,
    calls_step,
    calls_step,
    calls_step_in_parts,
    calls_step_in_parts,
    calls_step_in_parts,
    calls_set_up_world,
    calls_cast_ray,
    calls_destroy_something,
    calls_fail_allocations,
};

bool random_calls_run(const uint8_t* data, size_t size, unsigned kinds, random_calls_report* report) {
    report->finding[0] = '\0';
    report->digest = 1;
    calls* c = calloc(1, sizeof *c);
    if (c == NULL) { return true; }
    c->bytes = (byte_source){data, data + size, (kinds & RANDOM_CALLS_EXTREMES) == 0};
    c->kinds = kinds;
    c->report = report;
    c->whim = 1;
    if (calls_open(c)) {
        while (!bytes_are_done(&c->bytes) && c->call_count < CALLS_MOST && !calls_have_finding(c)) {
            choices[bytes_below(&c->bytes, (int)(sizeof choices / sizeof *choices))](c);
        }
    }
    calls_close(c);
    ++report->sequences;
    report->long_sequences += c->call_count >= 20;
    free(c);
    return report->finding[0] == '\0';
}
