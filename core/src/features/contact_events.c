/* Contacts that begin, go on and end, from what the features that make contacts tell of them at the end of a step. */

#include "pliant/contact_events.h"
#include "body/contact_report.h"
#include "body/pipeline.h"
#include "geometry/pair_cache.h"
#include "math/bounds.h"
#include "shape/shape_impl.h"

/* Of the margin: so far from the surface a contact does not end yet. What rests leaves and comes back by less. */
#define CONTACT_EVENTS_SLACK 0.25f

enum {
    CONTACT_EVENTS_ROOM = 1024, /* contacts that there is room for ahead, at most */
    CONTACT_PHASES = PLI_CONTACT_END + 1
};

typedef struct contact_item {
    pli_contact_event event; /* point and normal: sums by weight until the step ends */
    plii_pair_key key;
    float weight, strongest; /* N s: sum and largest of the impulses */
    float gap;               /* m, the smallest, while nothing pushes */
    bool goes_on;            /* into the next step */
} contact_item;

typedef struct contact_list {
    contact_item* items;
    int count, capacity;
    plii_key_table table; /* of `items`, by hashes of keys */
} contact_list;

typedef struct contact_events {
    pli_contact_events_def def;
    contact_list present, past; /* of the last step, and of the one before */
    pli_rigid** sensed;         /* met in this step */
    int sensed_count, sensed_capacity;
    pli_contact_event* events;                          /* phase by phase */
    int event_capacity, event_ends[CONTACT_PHASES + 1]; /* of each phase, after the start of the first: 0 */
} contact_events;

static int contact_list_find(const contact_list* list, plii_pair_key key) {
    const int index = plii_key_table_find(&list->table, plii_pair_key_hash(key));
    return index != PLI_NULL_INDEX && plii_pair_keys_equal(list->items[index].key, key) ? index : PLI_NULL_INDEX;
}
static bool contact_list_reserve(pli_context* context, contact_list* list, int count) {
    list->table.context = context;
    return PLII_RESERVE(context, &list->items, &list->capacity, count) && plii_key_table_reserve(&list->table, count);
}
static void contact_list_clear(contact_list* list) {
    list->count = 0;
    plii_key_table_clear(&list->table);
}

// ------------------------------------------------------------------------------------------------------ gathering

/* Of a node, or of a face or link, which is odd. */
static int contact_element(int node, int face) {
    return node != PLI_NULL_INDEX ? 2 * node : 2 * face + 1;
}

static plii_pair_key contact_key(const contact_events* state, const plii_contact_report* report) {
    plii_pair_key key = {.other = report->rigid != NULL ? (const void*)report->rigid : (const void*)report->other};
    if (!state->def.each_element) { return key; }
    key.first = contact_element(report->node, report->face != PLI_NULL_INDEX ? report->face : report->link);
    key.second = contact_element(report->other_node, report->other_face);
    key.part = report->shape;
    return key;
}

static void contact_item_add(contact_item* item, const plii_contact_report* report, float weight) {
    pli_contact_event* event = &item->event;
    const bool is_nearest = item->weight == 0.0f && weight == 0.0f && report->gap < item->gap;
    if (is_nearest) { item->gap = report->gap; }
    if (is_nearest || weight > item->strongest) {
        event->shape = report->shape;
        event->node = report->node;
        event->face = report->face;
        event->link = report->link;
        event->other_node = report->other_node;
        event->other_face = report->other_face;
    }
    if (weight > 0.0f) {
        const float before = item->weight > 0.0f ? 1.0f : 0.0f;
        event->point = pli_vec3_add(pli_vec3_scale(event->point, before), pli_vec3_scale(report->point, weight));
        event->normal = pli_vec3_add(pli_vec3_scale(event->normal, before), pli_vec3_scale(report->normal, weight));
        event->impulse = pli_vec3_add(event->impulse, report->impulse);
        item->weight += weight;
        item->strongest = plii_max(item->strongest, weight);
    } else if (is_nearest) {
        event->point = report->point;
        event->normal = report->normal;
    }
    event->is_sensor = event->is_sensor || report->is_sensor;
    event->contact_count += weight > 0.0f || report->is_sensor;
}

static void contact_events_visit(pli_body* body, const plii_contact_report* report, void* data) {
    contact_events* state = data;
    const float weight = pli_vec3_length(report->impulse);
    const bool touches = weight > 0.0f || report->is_sensor;
    if (!touches && !(report->gap <= CONTACT_EVENTS_SLACK * body->collision_margin)) { return; }
    const plii_pair_key key = contact_key(state, report);
    contact_list* list = &state->present;
    int index = contact_list_find(list, key);
    if (index == PLI_NULL_INDEX) {
        if (!touches && contact_list_find(&state->past, key) == PLI_NULL_INDEX) { return; }
        /* Without memory a contact is left out; the step tells. */
        if (!contact_list_reserve(body->context, list, list->count + 1)) { return; }
        index = list->count++;
        (void)plii_key_table_add(&list->table, plii_pair_key_hash(key), index);
        contact_item* item = &list->items[index];
        *item = (contact_item){.key = key, .gap = INFINITY};
        item->event.rigid = report->rigid;
        item->event.other = report->other;
        item->event.user_data = report->rigid != NULL ? report->rigid->user_data : report->other->user_data;
    }
    contact_item_add(&list->items[index], report, weight);
}

static void contact_events_collide(pli_body* body, void* data, pli_rigid* rigid) {
    contact_events* state = data;
    if (!rigid->is_sensor && !state->def.senses_all) { return; }
    if (!PLII_GROW(body->context, &state->sensed, &state->sensed_capacity, state->sensed_count)) { return; }
    state->sensed[state->sensed_count++] = rigid;
}

static void contact_events_sense(pli_body* body, contact_events* state, pli_rigid* sensor, int shape) {
    const pli_shape_def* def = &sensor->shapes[shape]->def;
    const pli_transform pose = plii_rigid_shape_transform(sensor, shape);
    const float margin = body->collision_margin;
    const pli_bounds bounds = plii_bounds_grow(plii_bounds_transform(def->bounds(def->user), pose), margin);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        if (!plii_bounds_overlap(bounds, (pli_bounds){x, x})) { continue; }
        const pli_vec3 point = pli_transform_inverse_point(pose, x);
        pli_vec3 local;
        float distance;
        def->distances(def->user, 1, &point, margin, &distance, &local);
        const pli_vec3 normal = pli_mat3_mul_vec3(pose.rotation, local);
        if (!(distance < margin) || !plii_is_finite(distance) || !plii_vec3_is_finite(normal)) { continue; }
        plii_contact_report report = plii_contact_report_make(sensor, NULL);
        report.shape = shape;
        report.node = i;
        report.normal = normal;
        report.point = pli_vec3_sub(x, pli_vec3_scale(normal, distance));
        report.gap = distance - margin;
        report.is_sensor = true;
        contact_events_visit(body, &report, state);
    }
}

// --------------------------------------------------------------------------------------------------------- the step

static void contact_events_begin(pli_body* body, void* data) {
    ((contact_events*)data)->sensed_count = 0;
}

/* Phases come one after the other. */
static pli_contact_event* contact_events_append(contact_events* state, int phase, const contact_item* item) {
    pli_contact_event* event = &state->events[state->event_ends[CONTACT_PHASES]];
    *event = item->event;
    for (int k = phase + 1; k <= CONTACT_PHASES; ++k) {
        state->event_ends[k] += 1;
    }
    return event;
}

static void contact_events_list(pli_body* body, contact_events* state) {
    contact_list *present = &state->present, *past = &state->past;
    memset(state->event_ends, 0, sizeof state->event_ends);
    if (!PLII_RESERVE(body->context, &state->events, &state->event_capacity, present->count + past->count)) { return; }
    for (int phase = PLI_CONTACT_BEGIN; phase <= PLI_CONTACT_PERSIST; ++phase) {
        for (int i = 0; i < present->count; ++i) {
            const int before = contact_list_find(past, present->items[i].key);
            if ((before == PLI_NULL_INDEX) != (phase == PLI_CONTACT_BEGIN)) { continue; }
            if (before != PLI_NULL_INDEX) { past->items[before].goes_on = true; }
            (void)contact_events_append(state, phase, &present->items[i]);
        }
    }
    for (int i = 0; i < past->count; ++i) {
        if (past->items[i].goes_on) { continue; }
        pli_contact_event* event = contact_events_append(state, PLI_CONTACT_END, &past->items[i]);
        event->impulse = pli_vec3_make(0, 0, 0);
        event->contact_count = 0;
    }
}

/* Also called where positions were set between steps, in which nothing touches. */
static void contact_events_end(pli_body* body, void* data) {
    contact_events* state = data;
    if (!body->world->is_stepping) { return; }
    contact_list* next = &state->present;
    PLII_SWAP(contact_list, state->present, state->past);
    contact_list_clear(next);
    plii_match_capacity(body->context, (void**)&next->items, &next->capacity, state->past.capacity,
                        sizeof *next->items);
    for (PLII_EACH_FEATURE(feature, body)) {
        if (feature->klass->visit_contacts == NULL) { continue; }
        feature->klass->visit_contacts(body, feature->state, contact_events_visit, state);
    }
    for (PLII_EACH_AT(pli_rigid, rigid, state->sensed, state->sensed_count)) {
        for (int k = 0; k < rigid->shape_count; ++k) {
            contact_events_sense(body, state, rigid, k);
        }
    }
    for (PLII_EACH(contact_item, item, state->present.items, state->present.count)) {
        if (!(item->weight > 0.0f)) { continue; }
        item->event.point = pli_vec3_scale(item->event.point, 1.0f / item->weight);
        item->event.normal = plii_vec3_safe_normalize(item->event.normal);
    }
    contact_events_list(body, state);
}

// ------------------------------------------------------------------------------------------- what goes away or changes

static void contact_forget(pli_contact_event* event, const void* gone) {
    if (event->rigid == gone) { event->rigid = NULL; }
    if (event->other == gone) { event->other = NULL; }
}

/* The next step tells that its contacts have ended. */
static void contact_events_forget(pli_body* body, void* data, plii_notice notice, const void* gone) {
    contact_events* state = data;
    for (PLII_EACH(contact_item, item, state->present.items, state->present.count)) {
        if (item->key.other == gone) { item->key.other = NULL; }
        contact_forget(&item->event, gone);
    }
    for (int i = 0; i < state->event_ends[CONTACT_PHASES]; ++i) {
        contact_forget(&state->events[i], gone);
    }
    PLII_REMOVE_IF(pli_rigid*, at, state->sensed, state->sensed_count, *at == gone);
}

/* Faces and links have other indices now: those of `other`, or of the body itself (NULL). */
static void contact_events_drop_faces(pli_body* body, void* data, plii_notice notice, const void* other) {
    contact_events* state = data;
    for (PLII_EACH(contact_item, item, state->present.items, state->present.count)) {
        pli_contact_event* event = &item->event;
        int* face = other != NULL ? &event->other_face : &event->face;
        if (other != NULL && event->other != other) { continue; }
        const bool is_of_face = *face != PLI_NULL_INDEX || (other == NULL && event->link != PLI_NULL_INDEX);
        if (is_of_face && state->def.each_element) { item->key.other = NULL; }
        *face = PLI_NULL_INDEX;
        if (other == NULL) { event->link = PLI_NULL_INDEX; }
    }
}

static void contact_events_build(pli_body* body, void* data) {
    contact_events_drop_faces(body, data, PLII_TOPOLOGY_CHANGED, NULL);
}

// ------------------------------------------------------------------------------------------------------ the feature

static void contact_events_reserve(pli_body* body, void* data) {
    contact_events* state = data;
    const int faces = body->topology->face_count;
    int room = body->world->rigid_count + body->world->body_count;
    if (state->def.each_element) { room = body->node_count + faces; }
    if (room > CONTACT_EVENTS_ROOM) { room = CONTACT_EVENTS_ROOM; }
    (void)contact_list_reserve(body->context, &state->present, room);
    (void)contact_list_reserve(body->context, &state->past, room);
    (void)PLII_RESERVE(body->context, &state->events, &state->event_capacity, 2 * room);
}

enum { CONTACT_EVENTS_BEGIN_ORDER = 0, CONTACT_EVENTS_END_ORDER = 100 }; /* after normals */

/* What has begun and ended was told already. */
static void contact_events_on_restored(pli_body* body, void* data) {
    contact_events* state = data;
    memset(state->event_ends, 0, sizeof state->event_ends);
    plii_key_table_clear(&state->past.table);
    plii_key_table_clear(&state->present.table);
    if (!contact_list_reserve(body->context, &state->present, state->present.count)) { return; } /* all begin anew */
    for (int i = 0; i < state->present.count; ++i) {
        (void)plii_key_table_add(&state->present.table, plii_pair_key_hash(state->present.items[i].key), i);
    }
}

const plii_feature_class plii_contact_events_class = {
    .name = "contact events",
    .state_size = sizeof(contact_events),
    .state_parts = PLII_STATE_PARTS(
        PLII_STATE_OF(contact_events, def, PLII_SAVED, "2Bu"), PLII_STATE(contact_events, present.table, PLII_LEFT),
        PLII_STATE(contact_events, past.table, PLII_LEFT), PLII_STATE(contact_events, event_ends, PLII_LEFT)),
    .on_restored = contact_events_on_restored,
    /* What there is outlives a cut. */
    .arrays =
        PLII_ARRAYS({PLII_COUNTED_LIST(contact_events, present.items, present.capacity, present.count), .is_kept = true,
                     PLII_SAVED_AS("RPXiNHLiii9fB|iiOi|3fB")},
                    {PLII_COUNTED_LIST(contact_events, past.items, past.capacity, past.count), .is_kept = true,
                     .snapshot = PLII_LEFT},
                    {PLII_KEY_TABLE_OF(contact_events, present.table)}, {PLII_KEY_TABLE_OF(contact_events, past.table)},
                    {PLII_COUNTED_LIST(contact_events, sensed, sensed_capacity, sensed_count), .is_kept = true,
                     .snapshot = PLII_LEFT},
                    {PLII_LIST_OF(contact_events, events, event_capacity), .is_kept = true, .snapshot = PLII_LEFT}),
    .stages = {[PLII_STAGE_UPDATE] = {contact_events_begin, CONTACT_EVENTS_BEGIN_ORDER},
               [PLII_STAGE_REFRESH] = {contact_events_end, CONTACT_EVENTS_END_ORDER}},
    .records_contacts = true,
    .collide_rigid = contact_events_collide,
    .meets_sensors = true,
    .on = {[PLII_RIGID_REMOVED] = contact_events_forget,
           [PLII_BODY_REMOVED] = contact_events_forget,
           [PLII_TOPOLOGY_CHANGED] = contact_events_drop_faces},
    .reserve = contact_events_reserve,
    .build = contact_events_build,
};

PLII_DEFINE_DEFAULT(pli_contact_events_def, 0)
pli_status pli_body_enable_contact_events(pli_body* body, const pli_contact_events_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_contact_events_def, used, def, plii_contact_events_class);
    PLII_TRY_ENABLE(body, contact_events, state, plii_contact_events_class);
    state->def = used;
    contact_list_clear(&state->present);
    memset(state->event_ends, 0, sizeof state->event_ends);
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_DISABLE(pli_body_disable_contact_events, plii_check_body_idle, plii_contact_events_class)

const pli_contact_event* pli_body_get_contact_events(const pli_body* body, pli_contact_phase phase, int* count) {
    if (count != NULL) { *count = 0; }
    if (plii_check_body(body, __func__) != PLI_OK || (unsigned)phase >= CONTACT_PHASES) { return NULL; }
    const contact_events* state = plii_feature_state(body, &plii_contact_events_class);
    if (state == NULL || plii_body_is_idle(body)) { return NULL; }
    const int begin = state->event_ends[phase], end = state->event_ends[phase + 1];
    if (count != NULL) { *count = end - begin; }
    return end > begin ? &state->events[begin] : NULL;
}
