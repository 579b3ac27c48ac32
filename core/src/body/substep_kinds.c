#include "body/pipeline.h"
#include "body/substep_rigid.h"

void plii_substep_kinds_begin(pli_body* body, plii_substep_kinds* kinds, bool in_iterations) {
    plii_substep_limits* limits = &kinds->limits;
    kinds->count = limits->count = 0;
    for (PLII_EACH_ENTRY(entry, body, PLII_SUBSTEPPED)) {
        const plii_substep_class* kind = entry->klass->substepped;
        const bool takes_part = !in_iterations || kind->is_in_iterations;
        plii_thread.pass.feature = entry->klass;
        if (takes_part && kind->begin != NULL) { kind->begin(body, entry->state); }
        if (kind->is_idle != NULL && kind->is_idle(entry->state)) { continue; }
        if (takes_part && kind->sweep != NULL && kinds->count < PLII_MAX_SUBSTEP_KINDS) {
            kinds->at[kinds->count++] = entry;
        }
        if (kind->room == NULL || limits->count == PLII_MAX_SUBSTEP_LIMITS) { continue; }
        if (kind->is_limit == NULL || kind->is_limit(entry->state)) { limits->at[limits->count++] = entry; }
    }
}

void plii_substep_kinds_restart(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep) {
    plii_substep_rigids_restart(body, substep);
    for (PLII_EACH_AT(const plii_pipeline_entry, entry, kinds->at, kinds->count)) {
        plii_substep_fn* restart = entry->klass->substepped->restart;
        if (restart != NULL) { restart(body, entry->state, substep); }
    }
}

void plii_substep_kinds_sweep(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep) {
    for (int k = 0; k < kinds->count; ++k) {
        const plii_pipeline_entry* entry = kinds->at[k];
        entry->klass->substepped->sweep(body, entry->state, substep);
        for (int i = 0; i < k && entry->klass->substepped->order == PLII_ORDER_LINKS; ++i) {
            plii_substep_fn* after_links = kinds->at[i]->klass->substepped->after_links;
            if (after_links != NULL) { after_links(body, kinds->at[i]->state, substep); }
        }
    }
}

/* A feature: to contacts with rigid bodies the step is one substep, each iteration a sweep, which has the last word. */
typedef struct iterated_sweeps {
    plii_substep substep;
    plii_substep_kinds kinds;
    int done; /* iterations */
} iterated_sweeps;

static void iterated_sweeps_prepare(pli_body* body, void* data) {
    iterated_sweeps* state = data;
    if (!body->has_swept_contacts) { return; }
    state->done = state->kinds.count = 0;
    if (!plii_follows_rigids(body) || body->solver.position_iterations == 0) { return; }
    state->substep = plii_substep_of_step(body, body->positions, body->previous);
    state->substep.limits = &state->kinds.limits;
    plii_substep_kinds_begin(body, &state->kinds, true);
    if (state->kinds.count > 0) { plii_substep_kinds_restart(body, &state->kinds, &state->substep); }
}

static void iterated_sweeps_iterate(pli_body* body, void* data) {
    iterated_sweeps* state = data;
    if (!body->has_swept_contacts || body->substep != NULL) { return; }
    state->substep.is_first_sweep = state->done == 0;
    const int count = body->solver.position_iterations + plii_body_last_couples(body);
    state->substep.is_last_sweep = ++state->done == count;
    plii_substep_kinds_sweep(body, &state->kinds, &state->substep);
}

enum { ITERATED_SWEEPS_ORDER = 300 }; /* after all else */
const plii_feature_class plii_iterated_sweeps_class = {
    .name = "iterated sweeps",
    .state_size = sizeof(iterated_sweeps),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(iterated_sweeps, substep, done, PLII_LEFT, NULL)),
    .stages = {[PLII_STAGE_PREPARE] = {iterated_sweeps_prepare, ITERATED_SWEEPS_ORDER},
               [PLII_STAGE_COUPLE] = {iterated_sweeps_iterate, ITERATED_SWEEPS_ORDER}},
};
