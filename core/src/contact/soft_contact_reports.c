/* What contacts between soft bodies have pushed, for contact events. A contact stands in the list of the body whose
   node it is; the body of the face finds it there, through the bodies that it met. */

#include "body/pipeline.h"
#include "body/world_state.h"
#include "contact/soft_contacts_impl.h"

static bool soft_pair_is_recorded(const pli_body* a, const pli_body* b) {
    return a->records_contacts || b->records_contacts;
}

bool plii_soft_contacts_record(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* state = pass->node_state;
    if (!soft_pair_is_recorded(pass->node_body, pass->face_body)) { return true; }
    if (state->impulse_count > state->count) { state->impulse_count = state->count; } /* a pair was given up */
    while (state->impulse_count <= state->count) {
        if (!plii_contact_impulses_add(pass->node_body, &state->impulses, state->impulse_count)) { return false; }
        state->impulse_count += 1;
    }
    return true;
}

void plii_soft_contacts_record_reserve(pli_body* body, plii_soft_contacts_state* state, int count) {
    const pli_world* world = body->world;
    bool is_recorded = false;
    for (int i = 0; i < world->body_count; ++i) {
        is_recorded = is_recorded || world->bodies[i]->records_contacts;
    }
    if (is_recorded) { (void)PLII_RESERVE(body->context, &state->impulses.items, &state->impulses.capacity, count); }
    if (body->records_contacts) {
        (void)PLII_RESERVE(body->context, &state->met, &state->met_capacity, world->body_count);
    }
}

static bool soft_contacts_meet(pli_body* body, plii_soft_contacts_state* state, pli_body* other) {
    if (!body->records_contacts) { return true; }
    if (!PLII_RESERVE(body->context, &state->met, &state->met_capacity, state->met_count + 1)) { return false; }
    state->met[state->met_count++] = other;
    return true;
}

bool plii_soft_contacts_record_pair(pli_body* body, plii_soft_contacts_state* state, pli_body* other,
                                    plii_soft_contacts_state* other_state) {
    return soft_contacts_meet(body, state, other) && soft_contacts_meet(other, other_state, body);
}

void plii_soft_contacts_note(const pli_body* body, const plii_soft_contacts_state* state, int index,
                             pli_vec3 correction) {
    const plii_soft_contact* contact = &state->contacts[index];
    const float inverse_mass = body->positions[contact->node].w;
    float mass = inverse_mass > 0.0f ? contact->node_share / inverse_mass : 0.0f;
    if (!(mass > 0.0f)) { /* only the face yields */
        const pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
        for (int k = 0; k < 3; ++k) {
            const float w = other->positions[face[k]].w;
            mass += w > 0.0f ? contact->face_share * weights[k] / w : 0.0f;
        }
    }
    plii_contact_impulses_push(&state->impulses, index, pli_vec3_scale(correction, mass * body->step.inverse_dt));
}

/* Of contact `index` of `node_body`, to the body of its node, or to that of its face. */
static plii_contact_report soft_contact_report(const pli_body* node_body, const plii_soft_contacts_state* state,
                                               int index) {
    const plii_soft_contact* contact = &state->contacts[index];
    const pli_body* other = contact->face_body;
    const int* face = other->topology->faces[contact->face];
    const pli_vec3 point = plii_contact_blend(other->positions, face, contact->weights);
    plii_contact_report report = plii_contact_report_make(NULL, contact->face_body);
    report.node = contact->node;
    report.other_face = contact->face;
    report.point = point;
    report.normal = contact->normal;
    report.impulse = index < state->impulse_count ? state->impulses.items[index] : pli_vec3_make(0, 0, 0);
    report.gap = pli_vec3_dot(contact->normal, pli_vec3_sub(plii_xyz(node_body->positions[contact->node]), point)) -
                 contact->margin;
    return report;
}

void plii_soft_contacts_visit(const pli_body* body, const void* data, plii_contact_visit_fn* visit, void* user) {
    const plii_soft_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_contact_report report = soft_contact_report(body, state, i);
        visit(&report, user);
    }
    for (int m = 0; m < state->met_count; ++m) {
        pli_body* other = state->met[m];
        const plii_soft_contacts_state* others = plii_feature_state(other, &plii_soft_contacts_class);
        for (int i = 0; others != NULL && i < others->count; ++i) {
            if (others->contacts[i].face_body != body) { continue; }
            plii_contact_report report = soft_contact_report(other, others, i);
            report.other = other;
            report.face = report.other_face;
            report.other_node = report.node;
            report.node = report.other_face = PLI_NULL_INDEX;
            report.normal = pli_vec3_neg(report.normal);
            report.impulse = pli_vec3_neg(report.impulse);
            visit(&report, user);
        }
    }
}
