#pragma once

/* Features of a body: enabling them, and running those that act in a stage. */

#include "body/world_state.h"

/* Enables with its needs, all or nothing. When enabled already only returns the state. `state` may be NULL. */
pli_status plii_feature_enable(pli_body* body, const plii_feature_class* klass, void** state);
/* The same with what the user gives, checked: so many bytes, to where the `settings` of the class are in the state.
   Nothing can fail after it: the body has changed. */
pli_status plii_feature_enable_with(pli_body* body, const plii_feature_class* klass, const void* given, size_t size,
                                    void** state);
/* Of such a call: `used` is what the user gives, or the default for NULL, checked by the class; returns as PLII_TRY. */
#define PLII_TRY_SETTINGS(body, type, used, def, klass)                                                                \
    const type used = (def) != NULL ? *(def) : type##_default();                                                       \
    PLII_TRY(PLII_CHECK_MADE((body)->context, type, &used, __func__));                                                 \
    PLII_TRY(plii_check_limits((body)->context, &used, &(klass).settings, __func__))
/* Of a call: `state` becomes the state of a feature, which is enabled; returns early as PLII_TRY. */
#define PLII_TRY_ENABLE(body, type, state, klass)                                                                      \
    type* state = NULL;                                                                                                \
    PLII_TRY(plii_feature_enable(body, &(klass), (void**)&state))
/* After it, when the call fails: the feature is as before. */
void plii_feature_undo(pli_body* body, const plii_feature_class* klass);
#define PLII_FAIL_ENABLED(body, klass, function, ...)                                                                  \
    (plii_feature_undo(body, &(klass)), plii_fail((body)->context, PLI_ERROR_OUT_OF_MEMORY, function, __VA_ARGS__))
/* One that is not enabled, while its needs are; those that only others need are appended before these. */
pli_status plii_feature_append(pli_body* body, const plii_feature_class* klass, bool by_user);
/* Undoes plii_feature_enable, and the needs that nobody else has. False, and nothing, when not enabled. */
bool plii_feature_disable(pli_body* body, const plii_feature_class* klass);
/* The call of a user, which looks the same for all features; and that which enables one, where settings are all it
   takes. */
#define PLII_DEFINE_DISABLE(function, check, klass)                                                                    \
    pli_status function(pli_body* body) {                                                                              \
        PLII_TRY(check(body, __func__));                                                                               \
        return plii_feature_disable(body, &(klass)) ? plii_body_changed(body, PLI_OK) : PLI_OK;                        \
    }
#define PLII_DEFINE_ENABLE(function, check, type, klass)                                                               \
    pli_status function(pli_body* body, const type* def) {                                                             \
        PLII_TRY(check(body, __func__));                                                                               \
        PLII_TRY_SETTINGS(body, type, used, def, klass);                                                               \
        return plii_feature_enable_with(body, &(klass), &used, sizeof used, NULL);                                     \
    }

bool plii_feature_is_enabled(const pli_body* body, const plii_feature_class* klass);
/* Another body of the world has it. */
bool plii_feature_is_shared(const pli_body* body, const plii_feature_class* klass);
/* NULL when not enabled, or without state. */
void* plii_feature_state(const pli_body* body, const plii_feature_class* klass);
/* For a call that only looks: NULL with a wrong handle, too, which is an error. */
static inline void* plii_feature_state_for(const pli_body* body, const plii_feature_class* klass,
                                           const char* function) {
    return plii_check_body(body, function) == PLI_OK ? plii_feature_state(body, klass) : NULL;
}
/* Such a call: `value` of the `state`, or `otherwise`. */
#define PLII_DEFINE_STATE_GET(type, function, state_type, klass, value, otherwise)                                     \
    type function(const pli_body* body) {                                                                              \
        const state_type* state = plii_feature_state_for(body, &(klass), __func__);                                    \
        return state != NULL ? (value) : (otherwise);                                                                  \
    }
/* What its features join it to. */
void plii_features_visit_joined(const pli_body* body, plii_joined_fn* visit, void* user);
/* Lists what they demand of nodes, those of one after those of the other, in the first of `parts` equal parts of a list
   that grows; returns how many there are. What there is no memory for is left out. */
int plii_features_list_constraints(const pli_body* body, int parts, struct plii_node_constraint** listed,
                                   int* capacity);
/* Tells the features of all bodies. */
void plii_features_notify(pli_world* world, plii_notice notice, const void* about);
void plii_feature_disable_all(pli_body* body);
size_t plii_feature_bytes(const pli_body* body);

static inline bool plii_stage_is_empty(const pli_body* body, plii_stage stage) {
    return body->pipeline.begin[stage] == body->pipeline.begin[stage + 1];
}
void plii_run_stage_profiled(pli_body* body, plii_stage stage);
/* Inline: bodies of a few nodes would notice. */
static inline void plii_run_stage(pli_body* body, plii_stage stage) {
    if (plii_stage_is_empty(body, stage)) { return; }
    if (body->world->profile != NULL) {
        plii_run_stage_profiled(body, stage);
        return;
    }
    for (PLII_EACH_ENTRY(entry, body, stage)) {
        plii_thread.pass.feature = entry->klass;
        entry->run(body, entry->state);
    }
}

/* A part of a solve, of one body after the other: alone, or of those that are solved side by side (world/islands.c). */
typedef void plii_solve_fn(pli_body* body);
static inline void plii_run_island(pli_body* first, plii_solve_fn* run) {
    for (pli_body* body = first; body != NULL; body = body->island_next) {
        plii_world_begin_body(body);
        run(body);
    }
}
/* Until little is left to settle; what lies on each other takes one round. */
enum { PLII_MOST_SETTLES = 8 };
static inline void plii_settle_island(pli_body* first) {
    bool goes_on = true;
    for (int round = 0; goes_on && round < PLII_MOST_SETTLES; ++round) {
        goes_on = false;
        for (pli_body* body = first; body != NULL; body = body->island_next) {
            plii_world_begin_body(body);
            plii_run_stage(body, PLII_STAGE_SETTLE);
            goes_on = goes_on || body->is_parting;
        }
    }
}
/* The solve of a solver by its parts, which are in line so. */
static inline void plii_solve_island(pli_body* first, plii_solver_pace pace, plii_solve_fn* begin, plii_solve_fn* sweep,
                                     plii_solve_fn* couple, plii_solve_fn* end) {
    plii_run_island(first, begin);
    for (int substep = 0; substep < pace.substeps; ++substep) {
        for (int i = 0; i < pace.sweeps; ++i) {
            plii_run_island(first, sweep);
            plii_run_island(first, couple);
        }
        for (int i = 0; i < plii_body_last_couples(first); ++i) {
            plii_run_island(first, couple);
        }
        plii_settle_island(first);
    }
    plii_run_island(first, end);
    for (pli_body* body = first; body != NULL; body = body->island_next) {
        body->is_solved = true;
    }
}

/* The arrays that a feature declares: allocating, counting and releasing them, and letting them follow a cut. */

/* All or none; zeroed. */
bool plii_feature_arrays_allocate(pli_body* body, const plii_feature_class* klass, void* state);
void plii_feature_arrays_release(pli_body* body, const plii_feature_class* klass, void* state, bool only_scratch);
size_t plii_feature_arrays_bytes(const pli_body* body, const plii_feature_class* klass, const void* state);
/* Of one array: bytes that it has now, and where it is; NULL when it is not there. */
size_t plii_feature_array_bytes(const pli_body* body, const plii_feature_array* array, const void* state);
void* plii_feature_array_address(const pli_body* body, const plii_feature_array* array, const void* state);
/* Whether it has lists with contents that have to follow a cut. */
bool plii_feature_arrays_need_commit(const plii_feature_class* klass);

/* For a change of topology: sizes of the new arrays; 0 for what does not follow the body. */
int plii_feature_arrays_sizes(const plii_feature_class* klass, const plii_topology_change* change, size_t* sizes);
/* Exchanges the arrays with new ones; `blocks` holds the old ones then. Contents go along where they are kept. */
void plii_feature_arrays_exchange(pli_body* body, const plii_feature_class* klass, void* state,
                                  const plii_topology_change* change, void** blocks);
/* Releases the old ones, and scratch. */
void plii_feature_arrays_drop(pli_body* body, const plii_feature_class* klass, void* state,
                              const plii_topology_change* change, void** blocks);
