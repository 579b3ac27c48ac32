/* Contacts of faces with rigid shapes, as a feature: what solvers and reports ask of them, their part in substeps, and
   settings. */

#include "body/pipeline.h"
#include "body/substep_kinds.h"
#include "contact/contact_substep.h"
#include "contact/face_rigid_impl.h"

#include <string.h>

/* Height of the witness point above the surface at the start of the step, less the margin and what is given up of it.
 */
static float faces_start_gap(const pli_body* body, const plii_rigid_face_contact* contact) {
    const plii_dvec3 apart =
        plii_dvec3_sub(plii_dvec3_from(contact->start), plii_dvec3_from(contact->rigid->path.begin.origin));
    const plii_dvec3 arm = plii_dvec3_from(contact->arm);
    const double height = plii_dvec3_dot(plii_dvec3_from(contact->normal), plii_dvec3_sub(apart, arm));
    return (float)height - contact->given_up;
}

static int rigid_faces_list_constraints(const pli_body* body, const void* data, int capacity,
                                        plii_node_constraint* constraints) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->count && i < capacity; ++i) {
        const plii_rigid_face_contact* from = &state->contacts[i];
        const pli_rigid* rigid = from->rigid;
        plii_node_constraint* constraint = &constraints[i];
        *constraint = (plii_node_constraint){.node = PLI_NULL_INDEX, .weights = from->weights, .rigid = from->rigid};
        memcpy(constraint->face_nodes, from->nodes, sizeof constraint->face_nodes);
        constraint->pivot = pli_mat3_mul_vec3(pli_mat3_transpose(rigid->path.begin.rotation), from->arm);
        constraint->normal = from->normal;
        constraint->offset = faces_start_gap(body, from) - pli_vec3_dot(from->normal, from->start);
        constraint->friction = state->def.friction * rigid->friction;
        constraint->hardness =
            rigid->kind == PLI_RIGID_DYNAMIC ? state->def.dynamic_hardness : state->def.static_hardness;
        constraint->recovery_speed = plii_contact_recovery_speed(0.0f);
        constraint->influence = 1.0f;
        if (body->records_contacts) { constraint->impulse = &state->impulses.items[i]; }
    }
    return state->count;
}

static void rigid_faces_visit_contacts(const pli_body* body, const void* data, plii_contact_visit_fn* visit,
                                       void* user) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_rigid_face_contact* contact = &state->contacts[i];
        const pli_vec3 x = plii_rigid_faces_point(body->positions, contact), n = contact->normal;
        const pli_vec3 surface = pli_vec3_add(
            contact->base, pli_vec3_scale(plii_rigid_velocity_at(contact->rigid, contact->arm), body->step.dt));
        plii_contact_report report = plii_contact_report_make(contact->rigid, NULL);
        report.shape = contact->shape;
        *(body->topology->face_count > 0 ? &report.face : &report.link) = contact->element;
        report.point = pli_vec3_sub(x, pli_vec3_scale(n, body->collision_margin));
        report.normal = n;
        report.node_count = 3;
        memcpy(report.nodes, contact->nodes, sizeof report.nodes);
        memcpy(report.weights, &contact->weights, sizeof report.weights);
        report.impulse = plii_contact_impulses_get(body, &state->impulses, i);
        report.gap = pli_vec3_dot(n, pli_vec3_sub(x, surface)) - body->collision_margin;
        visit(&report, user);
    }
}

static void rigid_faces_visit_met(const void* data, plii_joined_fn* visit, void* user) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->candidate_count; ++i) {
        visit(NULL, state->candidates[i].rigid, user);
    }
}

// ----------------------------------------------------------------------------------------------------------- substeps

/* Those that the free motion of the step has shown. */

static void faces_begin(pli_body* body, void* data) {
    plii_rigid_faces* state = data;
    plii_rigid_faces_settle(body, state);
    state->substeps.count = 0;
    for (int i = 0; i < state->count; ++i) { /* those without memory are left out in this step */
        const plii_rigid_face_contact* from = &state->contacts[i];
        plii_point_contact* contact = plii_point_contacts_add(body, &state->substeps);
        if (contact == NULL) { return; }
        contact->normal = from->normal;
        contact->offset = faces_start_gap(body, from) - pli_vec3_dot(from->normal, from->start);
        contact->surface = (plii_substep_rigid_point){from->rigid, from->arm};
        contact->node_count = 3;
        memcpy(contact->nodes, from->nodes, sizeof contact->nodes);
        memcpy(contact->weights, &from->weights, sizeof contact->weights);
        contact->coefficient = state->def.friction * from->rigid->friction;
        plii_point_contact_begin(body, contact);
    }
}

static void faces_restart(pli_body* body, void* data, const plii_substep* substep) {
    plii_point_contacts_restart(body, &((plii_rigid_faces*)data)->substeps, substep, plii_contact_recovery_speed(0.0f));
}

static void faces_sweep(pli_body* body, void* data, const plii_substep* substep) {
    plii_rigid_faces* state = data;
    plii_point_contacts_sweep(body, &state->substeps, substep, 0.0f);
    if (!body->records_contacts || !substep->is_last_sweep) { return; }
    for (int i = 0; i < state->substeps.count; ++i) { /* in the order of the contacts */
        plii_contact_impulses_push(&state->impulses, i, plii_point_contact_impulse(&state->substeps.items[i], substep));
    }
}

enum { RIGID_FACES_SUBSTEP_ORDER = 58 }; /* before those of nodes */
static const plii_substep_class rigid_faces_substepped = {
    .order = RIGID_FACES_SUBSTEP_ORDER,
    .is_in_iterations = true,
    .begin = faces_begin,
    .restart = faces_restart,
    .sweep = faces_sweep,
};

// -------------------------------------------------------------------------------------------------------- the feature

pli_rigid_face_contacts_def pli_rigid_face_contacts_def_default(void) {
    return (pli_rigid_face_contacts_def){
        .friction = 0.2f, .dynamic_hardness = 1.0f, .static_hardness = 0.1f, .cookie = PLII_DEF_COOKIE};
}

static void rigid_faces_clear(pli_body* body, void* data) {
    plii_rigid_faces* state = data;
    state->count = 0;
    plii_rigid_faces_drop_candidates(state, 0);
}

static void rigid_faces_on_rigid_removed(pli_body* body, void* data, const pli_rigid* rigid) {
    plii_rigid_faces* state = data;
    plii_pair_cache_release(body->context, &state->memory);
    PLII_REMOVE_IF(plii_rigid_face_contact, contact, state->contacts, state->count, contact->rigid == rigid);
}

static pli_status rigid_faces_enable(pli_body* body, void* data) {
    ++body->sweeping_features;
    return PLI_OK;
}

static void rigid_faces_build(pli_body* body, void* data) {
    rigid_faces_clear(body, data);
    plii_pair_cache_release(body->context, &((plii_rigid_faces*)data)->memory);
}

static void rigid_faces_disable(pli_body* body, void* data) {
    --body->sweeping_features;
    rigid_faces_build(body, data);
}

/* After contacts of nodes with rigid bodies. */
enum { RIGID_FACES_CLEAR_ORDER = 5, RIGID_FACES_ORDER = 25 };

static void rigid_faces_on_restored(pli_body* body, void* data) {
    (void)plii_pair_cache_index_before(body->context, &((plii_rigid_faces*)data)->memory);
}
static bool rigid_faces_is_sound(const pli_body* body, const void* data) {
    return plii_pair_cache_is_sound(&((const plii_rigid_faces*)data)->memory, INT32_MAX);
}

const plii_feature_class plii_rigid_faces_class = {
    .name = "rigid face contacts",
    .state_size = sizeof(plii_rigid_faces),
    .settings = PLII_LIMITS_AT(offsetof(plii_rigid_faces, def),
                               PLII_FIELD(pli_rigid_face_contacts_def, friction, 0, PLI_MAX_FACTOR),
                               PLII_FIELD(pli_rigid_face_contacts_def, dynamic_hardness, 0, 1),
                               PLII_FIELD(pli_rigid_face_contacts_def, static_hardness, 0, 1)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_rigid_faces, def, PLII_SAVED, "3fu"),
                                    PLII_STATE(plii_rigid_faces, candidate_count, PLII_LEFT),
                                    PLII_STATE(plii_rigid_faces, memory.table, PLII_LEFT),
                                    PLII_STATE(plii_rigid_faces, substeps, PLII_LEFT)),
    .is_sound = rigid_faces_is_sound,
    .on_restored = rigid_faces_on_restored,
    .needs = PLII_NEEDS(&plii_iterated_sweeps_class),
    .arrays = PLII_ARRAYS({PLII_LIST_OF(plii_rigid_faces, contacts, capacity), PLII_COUNTED_BY(plii_rigid_faces, count),
                           .snapshot = PLII_LEFT},
                          {PLII_CONTACT_IMPULSES_OF(plii_rigid_faces, impulses)},
                          {PLII_LIST_OF(plii_rigid_faces, candidates, candidate_capacity), .snapshot = PLII_LEFT},
                          {PLII_LIST_OF(plii_rigid_faces, substeps.items, substeps.capacity), .snapshot = PLII_LEFT},
                          PLII_PAIR_CACHE_LISTS(plii_rigid_faces, memory, PLII_LEFT, PLII_SAVED)),
    .stages = {[PLII_STAGE_UPDATE] = {rigid_faces_clear, RIGID_FACES_CLEAR_ORDER},
               [PLII_STAGE_PREPARE] = {plii_rigid_faces_prepare, RIGID_FACES_ORDER},
               [PLII_STAGE_POSITION] = {plii_rigid_faces_solve, RIGID_FACES_ORDER},
               [PLII_STAGE_FINISH] = {plii_rigid_faces_finish, RIGID_FACES_ORDER}},
    .substepped = &rigid_faces_substepped,
    .enable = rigid_faces_enable,
    .disable = rigid_faces_disable,
    .collide_rigid = plii_rigid_faces_collide,
    .collides_last = true,
    .list_constraints = rigid_faces_list_constraints,
    .visit_contacts = rigid_faces_visit_contacts,
    .visit_met = rigid_faces_visit_met,
    .on_rigid_removed = rigid_faces_on_rigid_removed,
    .build = rigid_faces_build,
};

pli_status pli_body_enable_rigid_face_contacts(pli_body* body, const pli_rigid_face_contacts_def* def) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY_SETTINGS(body, pli_rigid_face_contacts_def, used, def, plii_rigid_faces_class);
    return plii_feature_enable_with(body, &plii_rigid_faces_class, &used, sizeof used, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_rigid_face_contacts, plii_check_body_change, plii_rigid_faces_class)

int pli_body_get_rigid_face_contacts(const pli_body* body, int capacity, pli_rigid_face_contact* contacts) {
    const plii_rigid_faces* state = plii_feature_state_for(body, &plii_rigid_faces_class, __func__);
    if (state == NULL) { return 0; }
    const bool has_links = body->topology->face_count == 0;
    for (int i = 0; contacts != NULL && i < capacity && i < state->count; ++i) {
        const plii_rigid_face_contact* contact = &state->contacts[i];
        contacts[i].face = has_links ? PLI_NULL_INDEX : contact->element;
        contacts[i].link = has_links ? contact->element : PLI_NULL_INDEX;
        memcpy(contacts[i].weights, &contact->weights, sizeof contacts[i].weights);
        contacts[i].rigid = contact->rigid;
        contacts[i].shape = contact->shape;
        contacts[i].normal = contact->normal;
        contacts[i].distance = contact->distance;
    }
    return state->count;
}
