#include "body/pipeline.h"
#include "body/substep_rigid.h"

static void substep_kinds_insert(plii_substep_kinds* kinds, const plii_feature* feature) {
    const int order = feature->klass->substepped->order;
    int place = kinds->count++;
    for (; place > 0 && kinds->at[place - 1]->klass->substepped->order > order; --place) {
        kinds->at[place] = kinds->at[place - 1];
    }
    kinds->at[place] = feature;
}

static void substep_kinds_find_limits(const pli_body* body, plii_substep_limits* limits) {
    limits->count = 0;
    for (PLII_EACH_FEATURE(feature, body)) {
        const plii_substep_class* kind = feature->klass->substepped;
        if (kind == NULL || kind->room == NULL || limits->count == PLII_MAX_SUBSTEP_LIMITS) { continue; }
        if (kind->is_idle != NULL && kind->is_idle(feature->state)) { continue; }
        if (kind->is_limit != NULL && !kind->is_limit(feature->state)) { continue; }
        limits->rooms[limits->count] = kind->room;
        limits->carries[limits->count] = kind->carry;
        limits->states[limits->count++] = feature->state;
    }
}

void plii_substep_kinds_begin(pli_body* body, plii_substep_kinds* kinds, bool in_iterations) {
    kinds->count = 0;
    for (PLII_EACH_FEATURE(feature, body)) {
        const plii_substep_class* kind = feature->klass->substepped;
        if (kind == NULL || (in_iterations && !kind->is_in_iterations)) { continue; }
        if (kinds->count < PLII_MAX_SUBSTEP_KINDS) { substep_kinds_insert(kinds, feature); }
    }
    int busy = 0;
    for (PLII_EACH_AT(const plii_feature, feature, kinds->at, kinds->count)) {
        const plii_substep_class* kind = feature->klass->substepped;
        plii_thread.pass.feature = feature->klass;
        if (kind->begin != NULL) { kind->begin(body, feature->state); }
        const bool is_busy = kind->sweep != NULL && (kind->is_idle == NULL || !kind->is_idle(feature->state));
        if (is_busy) { kinds->at[busy++] = feature; }
    }
    kinds->count = busy;
    substep_kinds_find_limits(body, &kinds->limits);
}

void plii_substep_kinds_restart(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep) {
    plii_substep_rigids_restart(body, substep);
    for (PLII_EACH_AT(const plii_feature, feature, kinds->at, kinds->count)) {
        plii_substep_fn* restart = feature->klass->substepped->restart;
        if (restart != NULL) { restart(body, feature->state, substep); }
    }
}

void plii_substep_kinds_sweep(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep) {
    for (int k = 0; k < kinds->count; ++k) {
        const plii_feature* feature = kinds->at[k];
        feature->klass->substepped->sweep(body, feature->state, substep);
        for (int i = 0; i < k && feature->klass->substepped->order == PLII_ORDER_LINKS; ++i) {
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
    state->done = state->kinds.count = 0;
    if (!body->has_swept_contacts) { return; }
    body->has_swept_contacts = false;
    if (!plii_follows_rigids(body) || body->solver.position_iterations == 0) { return; }
    state->substep = (plii_substep){.dt = body->step.dt,
                                    .inverse_dt = body->step.inverse_dt,
                                    .host_dt = body->host_dt,
                                    .inverse_host_dt = 1.0f / body->host_dt,
                                    .is_absolute = true,
                                    .has_new_positions = true,
                                    .displacements = body->positions,
                                    .start_displacements = body->previous,
                                    .limits = &state->kinds.limits};
    plii_substep_kinds_begin(body, &state->kinds, true);
    if (state->kinds.count > 0) { plii_substep_kinds_restart(body, &state->kinds, &state->substep); }
}

static void iterated_sweeps_iterate(pli_body* body, void* data) {
    iterated_sweeps* state = data;
    if (state->kinds.count == 0 || body->substep != NULL) { return; }
    state->substep.is_first_sweep = state->done == 0;
    state->substep.is_last_sweep = ++state->done == body->solver.position_iterations;
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
