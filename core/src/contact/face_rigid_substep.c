/* Contacts of faces with rigid shapes in substeps: those that the free motion of the step has shown. */

#include "body/node_constraint.h"
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

int plii_rigid_faces_list_constraints(const pli_body* body, const void* data, int capacity,
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

void plii_rigid_faces_visit_contacts(const pli_body* body, const void* data, plii_contact_visit_fn* visit, void* user) {
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

void plii_rigid_faces_visit_met(const void* data, plii_joined_fn* visit, void* user) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->candidate_count; ++i) {
        visit(NULL, state->candidates[i].rigid, user);
    }
}

static void faces_begin(pli_body* body, void* data) {
    plii_rigid_faces* state = data;
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

static bool faces_are_idle(const void* data) {
    return ((const plii_rigid_faces*)data)->substeps.count == 0;
}

static void faces_leave(pli_body* body, void* data) {
    plii_point_contacts* contacts = &((plii_rigid_faces*)data)->substeps;
    PLII_RELEASE(body->context, contacts->items, contacts->capacity);
    *contacts = (plii_point_contacts){0};
}

enum { RIGID_FACES_SUBSTEP_ORDER = 58 }; /* before those of nodes */

const plii_substep_class plii_rigid_faces_substepped = {
    .order = RIGID_FACES_SUBSTEP_ORDER,
    .is_in_iterations = true,
    .begin = faces_begin,
    .restart = faces_restart,
    .sweep = faces_sweep,
    .is_idle = faces_are_idle,
    .leave = faces_leave,
};
