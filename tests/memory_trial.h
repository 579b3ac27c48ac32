#ifndef TESTS_MEMORY_TRIAL_H
#define TESTS_MEMORY_TRIAL_H

/* Runs a set-up, from its meshes to the last step, once with all the memory that it wants and then again and again with
   an allocation that fails: the n-th one alone, or all from the n-th one on until memory is back.

   Whatever fails, a call answers PLI_ERROR_OUT_OF_MEMORY and leaves everything as it was, and then works when it is
   repeated; a step says so and is done to its end. Where nobody says anything, everything comes out as with enough
   memory, to the bit. */

#include "failing_allocator.h"

#include <pliant/pliant.h>

enum { TRIAL_MOST_PLACES = 2048, TRIAL_MOST_STEPS = 64, TRIAL_MOST_RIGIDS = 8, TRIAL_STEPS_WITHOUT = 2 };

/* Of a run with enough memory. */
typedef struct trial_record {
    uint64_t hashes[TRIAL_MOST_STEPS];  /* of the whole world after each step */
    bool is_in_step[TRIAL_MOST_PLACES]; /* of the allocations */
} trial_record;

typedef struct trial {
    const char* name;
    long place; /* 0: with enough memory */
    failing_allocator allocator;
    pli_context* context;
    pli_world* world;
    pli_rigid* rigids[TRIAL_MOST_RIGIDS];
    int rigid_count;
    int step;
    trial_record* record;
    bool is_reference;   /* takes them */
    bool has_deviated;   /* a step has said that something was missing */
    bool moves_previous; /* previous positions are not those before the step */
    int steps_without;   /* since memory ran out for good */
    long failed_before;  /* the call */
    uint64_t hash_before;
    pli_vec4* positions_before; /* of all bodies, one after the other */
} trial;

typedef struct trial_counts {
    long places, in_steps; /* allocations with enough memory */
    long runs, reported;   /* in which one failed; by a step */
    long not_made;         /* runs that came to an end before that allocation */
} trial_counts;

#define TRIAL_FAIL(t, format, ...)                                                                                     \
    fail_msg("%s, allocation %ld%s: " format, (t)->name, (t)->place,                                                   \
             (t)->allocator.fails_for_good ? " and all that follow" : "", __VA_ARGS__)

// ------------------------------------------------------------------------------------------------------------- state

/* Of whole words. */
static inline uint64_t trial_mix(uint64_t hash, const void* data, size_t size) {
    for (size_t i = 0; i < size; i += sizeof(uint32_t)) {
        uint32_t word = 0;
        memcpy(&word, (const char*)data + i, sizeof word);
        hash = (hash ^ word) * 0x100000001b3u;
    }
    return hash;
}

static inline uint64_t trial_hash_body(uint64_t hash, const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    const uint64_t state = pli_body_state_hash(body);
    const int counts[6] = {view.node_count,
                           view.link_count,
                           view.face_count,
                           pli_body_cluster_count(body),
                           pli_body_joint_count(body) + pli_body_anchor_count(body),
                           pli_body_get_features(body, 0, NULL)};
    hash = trial_mix(trial_mix(hash, &state, sizeof state), counts, sizeof counts);
    for (int i = 0; i < view.node_count; ++i) {
        hash = trial_mix(hash, &view.previous[i], 3 * sizeof(float));
    }
    for (int i = 0; i < view.link_count; ++i) {
        const float length = pli_body_get_rest_length(body, i);
        hash = trial_mix(trial_mix(hash, &length, sizeof length), view.link_nodes + i * view.link_node_stride,
                         2 * sizeof(int));
    }
    return hash;
}

static inline uint64_t trial_hash(const trial* t) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (int i = 0; t->world != NULL && i < pli_world_body_count(t->world); ++i) {
        hash = trial_hash_body(hash, pli_world_get_body(t->world, i));
    }
    for (int i = 0; i < t->rigid_count; ++i) {
        const pli_rigid_state state = pli_rigid_get_state(t->rigids[i]);
        hash = trial_mix(hash, &state.pose, sizeof state.pose);
        hash = trial_mix(hash, &state.linear_velocity, sizeof state.linear_velocity);
        hash = trial_mix(hash, &state.angular_velocity, sizeof state.angular_velocity);
    }
    return hash;
}

static inline void trial_memory_is_back(trial* t) {
    t->allocator.fail_at = 0;
}

// ------------------------------------------------------------------------------------------------------------- calls

static inline void trial_begin_call(trial* t) {
    t->failed_before = t->allocator.failed;
    t->hash_before = trial_hash(t);
}

/* True when the call has to be repeated, for which there is memory then. */
static inline bool trial_end_call(trial* t, pli_status status, const char* call) {
    if (t->allocator.failed == t->failed_before || status != PLI_ERROR_OUT_OF_MEMORY) {
        if (status != PLI_OK) { TRIAL_FAIL(t, "%s: %s", call, pli_last_error(t->context)); }
        return false;
    }
    if (strstr(pli_last_error(t->context), "memory") == NULL) {
        TRIAL_FAIL(t, "%s: \"%s\" does not speak of memory", call, pli_last_error(t->context));
    }
    if (trial_hash(t) != t->hash_before) { TRIAL_FAIL(t, "%s failed and changed something", call); }
    trial_memory_is_back(t);
    return true;
}

/* `call` is made again when it had no memory. */
#define TRIAL_CALL(t, call)                                                                                            \
    do {                                                                                                               \
        trial_begin_call(t);                                                                                           \
        if (trial_end_call(t, (call), #call)) { assert_int_equal((call), PLI_OK); }                                    \
    } while (0)

// ------------------------------------------------------------------------------------------------------------- steps

static inline int trial_node_count(const trial* t) {
    int count = 0;
    for (int i = 0; i < pli_world_body_count(t->world); ++i) {
        count += pli_body_get_view(pli_world_get_body(t->world, i)).node_count;
    }
    return count;
}

static inline void trial_keep_positions(trial* t) {
    t->positions_before =
        (pli_vec4*)realloc(t->positions_before, (size_t)trial_node_count(t) * sizeof *t->positions_before);
    assert_non_null(t->positions_before);
    pli_vec4* kept = t->positions_before;
    for (int i = 0; i < pli_world_body_count(t->world); ++i) {
        const pli_body_view view = pli_body_get_view(pli_world_get_body(t->world, i));
        memcpy(kept, view.positions, (size_t)view.node_count * sizeof *kept);
        kept += view.node_count;
    }
}

static inline bool trial_is_finite(pli_vec4 v) {
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* Wholly: from where it was before, all of its nodes. */
static inline void trial_check_stepped(const trial* t, const pli_body* body, const pli_vec4* before) {
    const pli_body_view view = pli_body_get_view(body);
    int moved = 0, flying = 0;
    assert_false(pli_body_is_frozen(body));
    for (int k = 0; k < view.node_count; ++k) {
        const pli_vec4 x = view.positions[k], p = view.previous[k], b = before[k];
        if (!trial_is_finite(x) || !trial_is_finite(view.velocities[k])) { TRIAL_FAIL(t, "node %d is not finite", k); }
        if (!t->moves_previous && (p.x != b.x || p.y != b.y || p.z != b.z)) {
            TRIAL_FAIL(t, "node %d has no start", k);
        }
        moved += x.x != b.x || x.y != b.y || x.z != b.z;
        const pli_vec4 v = view.velocities[k];
        flying += v.x != 0.0f || v.y != 0.0f || v.z != 0.0f;
    }
    assert_true(moved > 0 || flying == 0); /* what does not move lies still */
    const bool is_truncated = pli_body_get_self_collision_report(body).is_truncated ||
                              pli_body_get_self_grids_report(body).is_truncated ||
                              pli_body_get_self_faces_report(body).is_truncated;
    if (is_truncated && t->allocator.failed == t->failed_before) { TRIAL_FAIL(t, "step %d lacks pairs", t->step); }
}

static inline void trial_check_step(trial* t, pli_status status) {
    const bool has_failed = t->allocator.failed != t->failed_before;
    if (has_failed && status == PLI_ERROR_OUT_OF_MEMORY) {
        t->has_deviated = true;
        if (strstr(pli_last_error(t->context), "pli_world_step: no memory") == NULL ||
            strstr(pli_last_error(t->context), "of body") == NULL || strstr(pli_last_error(t->context), "-1") != NULL) {
            TRIAL_FAIL(t, "\"%s\" does not say what there was no memory for", pli_last_error(t->context));
        }
    } else if (status != PLI_OK) {
        TRIAL_FAIL(t, "step %d: %s", t->step, pli_last_error(t->context));
    }
    const pli_vec4* before = t->positions_before;
    for (int i = 0; i < pli_world_body_count(t->world); ++i) {
        const pli_body* body = pli_world_get_body(t->world, i);
        trial_check_stepped(t, body, before);
        before += pli_body_get_view(body).node_count;
    }
}

static inline void trial_steps(trial* t, int count) {
    const float dt = 1.0f / 60.0f;
    for (int i = 0; i < count; ++i) {
        trial_keep_positions(t);
        t->failed_before = t->allocator.failed;
        const long first = t->allocator.calls + 1;
        trial_check_step(t, pli_world_step(t->world, dt));
        for (int k = 0; k < t->rigid_count; ++k) {
            assert_int_equal(pli_rigid_integrate(t->rigids[k], pli_vec3_make(0, -10, 0), dt), PLI_OK);
        }
        for (long k = first; t->is_reference && k <= t->allocator.calls; ++k) {
            assert_in_range(k, 1, TRIAL_MOST_PLACES - 1);
            t->record->is_in_step[k] = true;
        }
        if (t->allocator.failed > 0 && ++t->steps_without >= TRIAL_STEPS_WITHOUT) { trial_memory_is_back(t); }
        assert_in_range(t->step, 0, TRIAL_MOST_STEPS - 1);
        const uint64_t hash = trial_hash(t);
        if (t->is_reference) {
            t->record->hashes[t->step] = hash;
        } else if (!t->has_deviated && hash != t->record->hashes[t->step]) {
            TRIAL_FAIL(t, "step %d came out otherwise, and nobody said why", t->step);
        }
        ++t->step;
    }
}

// --------------------------------------------------------------------------------------------------------------- runs

typedef struct trial_setup {
    const char* name;
    void (*run)(trial* t);
    bool moves_previous; /* so do drift iterations, and contacts that recover */
} trial_setup;

/* Fails the allocation `place`, 0: none. */
static inline trial trial_run(const trial_setup* setup, bool preallocates, long place, bool for_good,
                              trial_record* record) {
    trial t = {.name = setup->name,
               .place = place,
               .record = record,
               .is_reference = place == 0,
               .moves_previous = setup->moves_previous};
    t.context = failing_context(&t.allocator);
    const long own = t.allocator.alive;
    t.allocator.calls = 0;
    t.allocator.fail_at = place;
    t.allocator.fails_for_good = for_good;
    pli_world_def def = pli_world_def_default();
    def.preallocates = preallocates;
    TRIAL_CALL(&t, pli_world_create(t.context, &def, &t.world));
    setup->run(&t);
    pli_world_destroy(t.world);
    assert_int_equal(pli_context_allocated_bytes(t.context), 0);
    assert_int_equal(t.allocator.alive, own);
    pli_context_destroy(t.context);
    assert_int_equal(t.allocator.alive, 0);
    free(t.positions_before);
    return t;
}

/* Each so many-th place, those in steps and those in other calls; `phase`: which ones. */
typedef struct trial_strides {
    long in_steps, in_calls, phase;
} trial_strides;

static inline trial_counts trial_run_all(const trial_setup* setup, bool preallocates, trial_strides strides) {
    trial_record record = {0};
    trial_counts counts = {0};
    counts.places = trial_run(setup, preallocates, 0, false, &record).allocator.calls;
    for (long place = 1; place <= counts.places; ++place) {
        const bool is_in_step = record.is_in_step[place];
        counts.in_steps += is_in_step;
        if ((place + strides.phase) % (is_in_step ? strides.in_steps : strides.in_calls) != 0) { continue; }
        for (int for_good = 0; for_good < 2; ++for_good) {
            const trial t = trial_run(setup, preallocates, place, for_good != 0, &record);
            if (t.allocator.failed == 0) {
                /* A checked build asks again for blocks that lie where handles were, as often as addresses want it. */
                if (!PLIANT_CHECKED) { TRIAL_FAIL(&t, "%s", "was not made"); }
                counts.not_made += 1;
                continue;
            }
            counts.runs += 1;
            counts.reported += t.has_deviated;
        }
    }
    return counts;
}

#endif
