/* The pipeline of a body: which features are enabled, who needs whom, and what runs in which stage. */

#include "body/pipeline.h"

#include "body/node_constraint.h"
#include "body/substep.h"

static int feature_find(const pli_body* body, const plii_feature_class* klass) {
    const plii_pipeline* pipeline = &body->pipeline;
    for (int i = 0; i < pipeline->feature_count; ++i) {
        if (pipeline->features[i].klass == klass) { return i; }
    }
    return PLI_NULL_INDEX;
}

bool plii_feature_is_enabled(const pli_body* body, const plii_feature_class* klass) {
    return feature_find(body, klass) != PLI_NULL_INDEX;
}

bool plii_feature_is_shared(const pli_body* body, const plii_feature_class* klass) {
    for (PLII_EACH_BODY(other, body->world)) {
        if (other != body && plii_feature_is_enabled(other, klass)) { return true; }
    }
    return false;
}

void* plii_feature_state(const pli_body* body, const plii_feature_class* klass) {
    const int index = feature_find(body, klass);
    return index != PLI_NULL_INDEX ? body->pipeline.features[index].state : NULL;
}

static bool feature_is_in(const plii_feature_class* klass, int stage) {
    if (stage == PLII_COLLIDE_RIGID) { return klass->collide_rigid != NULL; }
    return stage == PLII_SUBSTEPPED ? klass->substepped != NULL : klass->stages[stage].run != NULL;
}
static int feature_order(const pli_body* body, const plii_feature_class* klass, int stage) {
    if (stage == PLII_COLLIDE_RIGID) { return klass->collides_last; }
    const bool acts_on_motion = stage == PLII_STAGE_FORCES && klass->acts_on_motion && !body->world->def.reference_mode;
    if (acts_on_motion) { return body->solver_class->has_substeps ? INT_MIN : INT_MAX; }
    return stage == PLII_SUBSTEPPED ? klass->substepped->order : klass->stages[stage].order;
}

/* Equal orders run in the order of enabling. Room was made before. */
static void feature_rebuild_pipeline(pli_body* body) {
    plii_pipeline* pipeline = &body->pipeline;
    plii_pipeline_entry* entries = pipeline->entries;
    int count = 0;
    body->collides_with_bodies = body->solves_rigids = body->may_be_joined = false;
    body->records_contacts = body->can_sleep = false;
    for (int stage = 0; stage < PLII_PASS_COUNT; ++stage) {
        pipeline->begin[stage] = count;
        for (PLII_EACH(const plii_feature, feature, pipeline->features, pipeline->feature_count)) {
            const plii_feature_class* klass = feature->klass;
            body->collides_with_bodies = body->collides_with_bodies || klass->collide_body != NULL;
            body->solves_rigids = body->solves_rigids || (klass->collide_rigid != NULL && !klass->acts_with_joints);
            body->may_be_joined = body->may_be_joined || klass->visit_joined != NULL;
            body->records_contacts = body->records_contacts || klass->records_contacts;
            body->can_sleep = body->can_sleep || klass->lets_sleep;
            if (!feature_is_in(klass, stage)) { continue; }
            int at = count++;
            for (; at > pipeline->begin[stage] &&
                   feature_order(body, entries[at - 1].klass, stage) > feature_order(body, klass, stage);
                 --at) {
                entries[at] = entries[at - 1];
            }
            plii_run_fn* run = stage < PLII_STAGE_COUNT ? klass->stages[stage].run : NULL;
            entries[at] = (plii_pipeline_entry){run, feature->state, klass};
        }
    }
    pipeline->begin[PLII_PASS_COUNT] = count;
}

static void feature_release(pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    body->sweeping_features -= klass->looks_at_motion;
    if (klass->disable != NULL) { klass->disable(body, feature->state); }
    if (klass->solver != NULL) { body->solver_class = &plii_position_solver; }
    plii_feature_arrays_release(body, klass, feature->state, false);
    plii_release(body->context, feature->state, klass->state_size);
}

/* One user less; without any the feature goes, and so does its use of what it needs. */
static void feature_drop_user(pli_body* body, const plii_feature_class* klass) {
    plii_pipeline* pipeline = &body->pipeline;
    const int index = feature_find(body, klass);
    plii_feature* feature = &pipeline->features[index];
    feature->users -= 1;
    if (feature->users > 0) { return; }
    feature_release(body, feature);
    pipeline->feature_count -= 1;
    pipeline->revision += 1;
    memmove(feature, feature + 1, (size_t)(pipeline->feature_count - index) * sizeof *feature);
    feature_rebuild_pipeline(body);
    for (const plii_feature_class* const* need = klass->needs; need != NULL && *need != NULL; ++need) {
        feature_drop_user(body, *need);
    }
}

static int feature_count_entries(const plii_feature_class* klass) {
    int count = 0;
    for (int stage = 0; stage < PLII_PASS_COUNT; ++stage) {
        count += feature_is_in(klass, stage);
    }
    return count;
}

static pli_status feature_add(pli_body* body, const plii_feature_class* klass) {
    plii_pipeline* pipeline = &body->pipeline;
    const int entry_count = pipeline->begin[PLII_PASS_COUNT] + feature_count_entries(klass);
    if (!PLII_RESERVE(body->context, &pipeline->features, &pipeline->feature_capacity, pipeline->feature_count + 1) ||
        !PLII_RESERVE(body->context, &pipeline->entries, &pipeline->entry_capacity, entry_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    const uint64_t shortages = plii_thread.shortages;
    void* state = plii_allocate(body->context, klass->state_size);
    if (state == NULL && klass->state_size > 0) { return PLI_ERROR_OUT_OF_MEMORY; }
    if (plii_feature_arrays_allocate(body, klass, state) && klass->enable != NULL) { klass->enable(body, state); }
    if (plii_thread.shortages != shortages) {
        plii_feature_arrays_release(body, klass, state, false);
        plii_release(body->context, state, klass->state_size);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    plii_run_fn* refresh = klass->stages[PLII_STAGE_REFRESH].run;
    if (klass->solver != NULL) { body->solver_class = klass->solver; }
    if (klass->build != NULL) { klass->build(body, state); }
    if (refresh != NULL) { refresh(body, state); }
    plii_feature_arrays_release(body, klass, state, true);
    pipeline->features[pipeline->feature_count++] = (plii_feature){.klass = klass, .state = state};
    pipeline->revision += !klass->is_made_by_calls;
    body->sweeping_features += klass->looks_at_motion;
    feature_rebuild_pipeline(body);
    return PLI_OK;
}

/* One more user of a feature, which is added with its needs when it is not there. */
static pli_status feature_add_user(pli_body* body, const plii_feature_class* klass) {
    pli_status status = PLI_OK;
    int met_needs = 0;
    if (!plii_feature_is_enabled(body, klass)) {
        while (status == PLI_OK && klass->needs != NULL && klass->needs[met_needs] != NULL) {
            status = feature_add_user(body, klass->needs[met_needs]);
            met_needs += status == PLI_OK;
        }
        if (status == PLI_OK) { status = feature_add(body, klass); }
    }
    if (status == PLI_OK) { body->pipeline.features[feature_find(body, klass)].users += 1; }
    while (status != PLI_OK && met_needs > 0) {
        feature_drop_user(body, klass->needs[--met_needs]);
    }
    return status;
}

pli_status plii_feature_append(pli_body* body, const plii_feature_class* klass, bool by_user) {
    PLII_TRY(feature_add(body, klass));
    plii_feature* added = &body->pipeline.features[body->pipeline.feature_count - 1];
    added->by_user = by_user;
    added->users = by_user;
    for (const plii_feature_class* const* need = klass->needs; need != NULL && *need != NULL; ++need) {
        body->pipeline.features[feature_find(body, *need)].users += 1;
    }
    body->world->needs_reserve = true;
    return PLI_OK;
}

pli_status plii_feature_enable(pli_body* body, const plii_feature_class* klass, void** state) {
    int index = feature_find(body, klass);
    const bool is_new = index == PLI_NULL_INDEX || !body->pipeline.features[index].by_user;
    if (is_new) {
        const pli_status status = feature_add_user(body, klass);
        PLII_FAIL_IF(status != PLI_OK, body->context, status, __func__, "no memory to enable %s", klass->name);
        index = feature_find(body, klass);
    }
    plii_feature* feature = &body->pipeline.features[index];
    feature->by_user = true;
    feature->is_new = is_new;
    if (state != NULL) { *state = feature->state; }
    body->world->needs_reserve = true;
    return PLI_OK;
}

pli_status plii_feature_enable_with(pli_body* body, const plii_feature_class* klass, const void* given, size_t size,
                                    void** state) {
    void* enabled = NULL;
    PLII_TRY(plii_feature_enable(body, klass, &enabled));
    memcpy((char*)enabled + klass->settings.offset, given, size);
    if (state != NULL) { *state = enabled; }
    return plii_body_changed(body, PLI_OK);
}

bool plii_feature_disable(pli_body* body, const plii_feature_class* klass) {
    const int index = feature_find(body, klass);
    if (index == PLI_NULL_INDEX || !body->pipeline.features[index].by_user) { return false; }
    body->pipeline.features[index].by_user = false;
    feature_drop_user(body, klass);
    return true;
}

void plii_feature_undo(pli_body* body, const plii_feature_class* klass) {
    if (body->pipeline.features[feature_find(body, klass)].is_new) { plii_feature_disable(body, klass); }
}

void plii_features_visit_joined(const pli_body* body, plii_joined_fn* visit, void* user) {
    if (!body->may_be_joined) { return; }
    for (PLII_EACH_FEATURE(feature, body)) {
        if (feature->klass->visit_joined != NULL) { feature->klass->visit_joined(feature->state, visit, user); }
    }
}

int plii_features_list_constraints(const pli_body* body, int parts, plii_node_constraint** listed, int* capacity) {
    for (;;) {
        const int room = *capacity / parts;
        int wanted = 0;
        for (PLII_EACH_FEATURE(feature, body)) {
            if (feature->klass->list_constraints == NULL) { continue; }
            const int left = wanted < room ? room - wanted : 0;
            plii_node_constraint* free = left > 0 ? *listed + wanted : NULL;
            wanted += feature->klass->list_constraints(body, feature->state, left, free);
        }
        if (wanted <= room) { return wanted; }
        if (!PLII_RESERVE(body->context, listed, capacity, parts * wanted)) { return room; }
    }
}

void plii_features_notify(pli_world* world, plii_notice notice, const void* about) {
    world->removals += notice <= PLII_CLUSTERS_REMOVED;
    for (PLII_EACH_BODY(body, world)) {
        if (body == about && notice == PLII_TOPOLOGY_CHANGED) { continue; }
        for (PLII_EACH_FEATURE(feature, body)) {
            plii_notice_fn* on = feature->klass->on[notice];
            if (on != NULL) { on(body, feature->state, notice, about); }
        }
    }
}

void plii_feature_disable_all(pli_body* body) {
    plii_pipeline* pipeline = &body->pipeline;
    /* A feature is enabled after its needs, so going backwards no need goes before its user. */
    for (int i = pipeline->feature_count - 1; i >= 0; --i) {
        feature_release(body, &pipeline->features[i]);
    }
    PLII_RELEASE(body->context, pipeline->features, pipeline->feature_capacity);
    PLII_RELEASE(body->context, pipeline->entries, pipeline->entry_capacity);
    *pipeline = (plii_pipeline){0};
}

static size_t feature_held_bytes(const pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    return klass->state_size + plii_feature_arrays_bytes(body, klass, feature->state);
}

size_t plii_feature_bytes(const pli_body* body) {
    const plii_pipeline* pipeline = &body->pipeline;
    size_t bytes = (size_t)pipeline->feature_capacity * sizeof *pipeline->features +
                   (size_t)pipeline->entry_capacity * sizeof *pipeline->entries;
    for (int i = 0; i < pipeline->feature_count; ++i) {
        bytes += feature_held_bytes(body, &pipeline->features[i]);
    }
    return bytes;
}

int pli_body_get_features(const pli_body* body, int capacity, pli_feature_cost* features) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const plii_pipeline* pipeline = &body->pipeline;
    for (int i = 0; features != NULL && i < pipeline->feature_count && i < capacity; ++i) {
        const plii_feature* feature = &pipeline->features[i];
        const plii_feature_class* klass = feature->klass;
        features[i] = (pli_feature_cost){.name = klass->name,
                                         .bytes = feature_held_bytes(body, feature),
                                         .is_needed = !feature->by_user,
                                         .has_passes = feature_count_entries(klass) > 0 || klass->collide_body != NULL};
    }
    return pipeline->feature_count;
}

void plii_run_stage_profiled(pli_body* body, plii_stage stage) {
    /* In the order of the stages. */
    static const char* const names[] = {"forces",       "update",  "joint prepare", "joint start", "joint solve",
                                        "joint finish", "prepare", "velocity",      "position",    "couple",
                                        "settle",       "drift",   "finish",        "refresh"};
    _Static_assert(sizeof names / sizeof *names == PLII_STAGE_COUNT, "each stage has a name");
    for (PLII_EACH_ENTRY(entry, body, stage)) {
        plii_thread.pass.feature = entry->klass;
        plii_world_profile(body->world, names[stage], entry->klass->name, true);
        entry->run(body, entry->state);
        plii_world_profile(body->world, names[stage], entry->klass->name, false);
    }
}
