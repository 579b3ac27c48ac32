/* Contacts of nodes with the faces of other soft bodies, as a feature; Bullet's boxes and solve; reports. */

#include "body/pipeline.h"
#include "contact/soft_contacts_impl.h"
#include "pliant/bullet_reference.h"

// --------------------------------------------------------------------------------------------------- Bullet's solve

/* As btSoftBody::PSolve_SContacts, for bodies with Bullet's boxes: one body is solved before the other. With a recovery
   speed, which Bullet lacks, a contact gives the nodes of a body that was solved before their velocities too. */

/* Springs and links pull nodes back that were put apart. Had that given them speed, they would wind it up from step to
   step. The normal of a node that the prediction took through the face points the wrong way; it is only stopped. */
static void soft_recover_bullet(pli_body* body, void* data) {
    const plii_soft_contacts_state* state = data;
    const float most = state->def.recovery_speed * body->step.dt;
    for (PLII_EACH(const plii_soft_contact, contact, state->contacts, most > 0.0f ? state->count : 0)) {
        if (!contact->is_bullet) { continue; }
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const pli_vec3 at = plii_contact_blend(other->previous, face, contact->weights);
        const float distance = pli_vec3_dot(contact->normal, pli_vec3_sub(plii_xyz(body->previous[contact->node]), at));
        const float depth = body->collision_margin + other->collision_margin - distance;
        if (!(depth > 0.0f) || distance < 0.0f) { continue; }
        const pli_vec3 shift = pli_vec3_scale(contact->normal, plii_min(depth, most));
        const pli_vec3 by = pli_vec3_scale(shift, contact->node_share);
        const pli_vec3 shares = pli_vec3_scale(contact->weights, -contact->face_share);
        plii_add_xyz(&body->positions[contact->node], by);
        plii_contact_add(other->positions, face, shares, shift);
        /* As if they had been there at the start of the step, so that no velocity comes of it. */
        plii_add_xyz(&body->previous[contact->node], by);
        plii_contact_add(other->previous, face, shares, shift);
    }
}

/* A contact of Bullet's, below impulse_count, has moved its node and face apart by shares of `correction`, m. */
static void soft_note(const pli_body* body, const plii_soft_contacts_state* state, int index, pli_vec3 correction) {
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

static void soft_solve_bullet(pli_body* body, void* data) {
    const plii_soft_contacts_state* state = data;
    const bool shifts = state->def.recovery_speed > 0.0f;           /* what overlapped before */
    for (int i = 0; i < state->count && !state->is_sweeping; ++i) { /* without boxes none is Bullet's */
        const plii_soft_contact* contact = &state->contacts[i];
        if (!contact->is_bullet) { continue; }
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const pli_vec3 n = contact->normal, weights = contact->weights;
        const pli_vec3 x = plii_xyz(body->positions[contact->node]);
        const pli_vec3 point = plii_contact_blend(other->positions, face, weights);
        const pli_vec3 point_before = plii_contact_blend(other->previous, face, weights);
        const pli_vec3 motion =
            pli_vec3_sub(pli_vec3_sub(x, plii_xyz(body->previous[contact->node])), pli_vec3_sub(point, point_before));
        const float along_normal = pli_vec3_dot(motion, n);
        float depth = 0.0f;
        if (along_normal < 0.0f) {
            depth = contact->margin - (pli_vec3_dot(n, x) - pli_vec3_dot(n, point));
            if (shifts) { depth = plii_min(depth, -along_normal); }
        }
        const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, along_normal));
        const pli_vec3 correction = pli_vec3_sub(pli_vec3_scale(n, depth), pli_vec3_scale(sliding, contact->friction));
        plii_set_xyz(&body->positions[contact->node], pli_vec3_add(x, pli_vec3_scale(correction, contact->node_share)));
        plii_contact_add(other->positions, face, pli_vec3_scale(weights, -contact->face_share), correction);
        if (shifts && other->is_solved) { /* it takes its velocities from positions no more */
            plii_contact_add(other->velocities, face, pli_vec3_scale(weights, -other->step.inverse_dt),
                             pli_vec3_scale(correction, contact->face_share));
        }
        if (i < state->impulse_count) { soft_note(body, state, i, correction); }
    }
}

// ------------------------------------------------------------------------------------------------------- reports

/* What contacts have pushed, for contact events. A contact stands in the list of the body whose node it is; the body of
   the face finds it there, through the bodies that it met. */

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

static void soft_visit(pli_body* body, const void* data, plii_contact_visit_fn* visit, void* user) {
    const plii_soft_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_contact_report report = soft_contact_report(body, state, i);
        visit(body, &report, user);
    }
    for (PLII_EACH_AT(pli_body, other, state->met, state->met_count)) {
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
            visit(body, &report, user);
        }
    }
}

// ------------------------------------------------------------------------------------------------ contacts of a node

/* With all other bodies together: layers behind the nearest ones are stopped by these. */
#define SOFT_CONTACTS_MOST_PER_NODE 4.0f

/* In a round each node loses one: `of_node` is minus the distance of the farthest, m. */
static bool soft_is_too_many(float* of_node, const plii_soft_contact* contact) {
    const bool is_too_many = *of_node <= 0.0f && !(contact->distance < -*of_node);
    if (is_too_many) { *of_node = 1.0f; }
    return is_too_many;
}

void plii_soft_contacts_keep_nearest(const pli_body* body, plii_soft_contacts_state* state) {
    float* of_nodes = state->missed; /* read in the search, and anew at the end of the step: contacts, here */
    for (bool is_crowded = state->count > 0 && state->is_sweeping; is_crowded;) {
        is_crowded = false;
        memset(of_nodes, 0, (size_t)body->node_count * sizeof *of_nodes);
        for (PLII_EACH(const plii_soft_contact, contact, state->contacts, state->count)) {
            of_nodes[contact->node] += 1.0f;
            is_crowded = is_crowded || of_nodes[contact->node] > SOFT_CONTACTS_MOST_PER_NODE;
        }
        if (!is_crowded) { break; }
        for (PLII_EACH(const plii_soft_contact, contact, state->contacts, state->count)) {
            float* of_node = &of_nodes[contact->node];
            if (*of_node > SOFT_CONTACTS_MOST_PER_NODE) { *of_node = 0.0f; }
            if (*of_node <= 0.0f) { *of_node = plii_min(*of_node, -contact->distance); }
        }
        PLII_REMOVE_IF(plii_soft_contact, contact, state->contacts, state->count,
                       soft_is_too_many(&of_nodes[contact->node], contact));
    }
}

// ----------------------------------------------------------------------------------------------------- the feature

static void soft_refresh(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    if (pli_vec3_dot(state->parting, state->parting) > 0.0f) {
        for (int i = 0; i < body->node_count; ++i) {
            plii_add_xyz(&body->positions[i], state->parting);
        }
        (void)plii_body_update_bounds(body); /* the next step looks whether it is lost */
        state->parting = pli_vec3_make(0, 0, 0);
    }
    for (int i = 0; state->is_sweeping && i < body->node_count; ++i) {
        state->missed[i] = pli_vec3_length(pli_vec3_sub(plii_xyz(body->positions[i]), state->predicted[i]));
    }
}

static void soft_update(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    state->count = state->impulse_count = state->met_count = 0;
    state->sweeps = 0;
    state->parting = pli_vec3_make(0, 0, 0);
    body->overlap_steps -= body->overlap_steps > 0;
    memset(state->shifts, 0, (size_t)body->node_count * sizeof *state->shifts);
    body->soft_shifts = state->shifts;
    body->soft_slack = state->is_sweeping ? PLII_SOFT_CONTACTS_SLACK * body->collision_margin : 0.0f;
    if (state->is_sweeping) { plii_body_copy_positions(body, state->predicted); }
}

static void soft_on_body_removed(pli_body* body, void* data, plii_notice notice, const void* other) {
    plii_soft_contacts_state* state = data;
    PLII_REMOVE_IF(plii_soft_contact, contact, state->contacts, state->count, contact->face_body == other);
    state->impulse_count = state->met_count = 0;
}

static void soft_build(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    state->count = state->order_count = 0;
    body->soft_shifts = NULL;
    body->is_parting = false;
    body->soft_slack = 0.0f;
}
static void soft_disable(pli_body* body, void* data) {
    body->sweeping_features -= ((plii_soft_contacts_state*)data)->is_sweeping;
    soft_build(body, data);
}

enum { SOFT_CONTACTS_ORDER = 30 }; /* after contacts with rigid bodies and before the links */

static bool soft_is_sound(const pli_body* body, const void* data) {
    const plii_soft_contacts_state* state = data;
    if (state->is_sweeping == plii_feature_is_enabled(body, &plii_bullet_boxes_class)) { return false; }
    return state->order_count == 0 || state->order_count == body->topology->face_count;
}

const plii_feature_class plii_soft_contacts_class = {
    .name = "soft contacts",
    .state_size = sizeof(plii_soft_contacts_state),
    .settings = PLII_LIMITS_AT(offsetof(plii_soft_contacts_state, def),
                               PLII_FIELD(pli_soft_contacts_def, friction, 0, PLI_MAX_FACTOR),
                               PLII_FIELD(pli_soft_contacts_def, hardness, 0, 1),
                               PLII_FIELD(pli_soft_contacts_def, recovery_speed, 0, PLI_MAX_SPEED),
                               PLII_FIELD(pli_soft_contacts_def, compliance, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_soft_contacts_state, def, PLII_SAVED, "4fBu"),
                                    PLII_STATE(plii_soft_contacts_state, impulse_count, PLII_LEFT),
                                    PLII_STATE_SPAN(plii_soft_contacts_state, sweeps, parting, PLII_LEFT, NULL),
                                    PLII_STATE_OF(plii_soft_contacts_state, is_sweeping, PLII_SAVED, "B"),
                                    PLII_STATE(plii_soft_contacts_state, near, PLII_LEFT)),
    .is_sound = soft_is_sound,
    .arrays = PLII_ARRAYS(
        PLII_LEFT_COUNTED(plii_soft_contacts_state, contacts, capacity, count),
        PLII_LEFT_PER_NODE(plii_soft_contacts_state, predicted), PLII_LEFT_PER_NODE(plii_soft_contacts_state, shifts),
        {PLII_MEMBER(plii_soft_contacts_state, missed), PLII_PER_NODE, PLII_SAVED_AS("f")},
        {PLII_CONTACT_IMPULSES_OF(plii_soft_contacts_state, impulses)},
        PLII_LEFT_COUNTED(plii_soft_contacts_state, met, met_capacity, met_count),
        PLII_LEFT_COUNTED(plii_soft_contacts_state, faces, face_capacity, face_count),
        PLII_LEFT_LIST(plii_soft_contacts_state, boxes, box_capacity),
        PLII_LEFT_LIST(plii_soft_contacts_state, near.groups, near.capacity),
        PLII_LEFT_COUNTED(plii_soft_contacts_state, hits, hit_capacity, hit_count),
        PLII_LEFT_LIST(plii_soft_contacts_state, groups, group_capacity),
        PLII_LEFT_COUNTED(plii_soft_contacts_state, nodes, node_capacity, node_count),
        {PLII_COUNTED_LIST(plii_soft_contacts_state, face_order, order_capacity, order_count), PLII_SAVED_AS("F")}),
    .stages = {[PLII_STAGE_UPDATE] = {soft_update, SOFT_CONTACTS_ORDER},
               [PLII_STAGE_PREPARE] = {soft_recover_bullet, SOFT_CONTACTS_ORDER},
               [PLII_STAGE_POSITION] = {soft_solve_bullet, SOFT_CONTACTS_ORDER},
               [PLII_STAGE_COUPLE] = {plii_soft_contacts_couple, SOFT_CONTACTS_ORDER},
               [PLII_STAGE_SETTLE] = {plii_soft_contacts_settle, SOFT_CONTACTS_ORDER},
               [PLII_STAGE_REFRESH] = {soft_refresh, SOFT_CONTACTS_ORDER}},
    .disable = soft_disable,
    .collide_body = plii_soft_contacts_collide,
    .on = {[PLII_BODY_REMOVED] = soft_on_body_removed, [PLII_TOPOLOGY_CHANGED] = soft_on_body_removed},
    .visit_contacts = soft_visit,
    .reserve = plii_soft_contacts_reserve,
    .build = soft_build,
};

PLII_DEFINE_DEFAULT(pli_soft_contacts_def, .friction = 0.2f, .hardness = 1.0f)
pli_status pli_body_enable_soft_contacts(pli_body* body, const pli_soft_contacts_def* def) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY_SETTINGS(body, pli_soft_contacts_def, used, def, plii_soft_contacts_class);
    PLII_TRY_ENABLE(body, plii_soft_contacts_state, state, plii_soft_contacts_class);
    if (!used.bullet_boxes) { plii_feature_disable(body, &plii_bullet_boxes_class); }
    const pli_status status = used.bullet_boxes ? plii_feature_enable(body, &plii_bullet_boxes_class, NULL) : PLI_OK;
    if (status != PLI_OK) {
        plii_feature_undo(body, &plii_soft_contacts_class);
        return status;
    }
    body->sweeping_features += !used.bullet_boxes - state->is_sweeping;
    state->is_sweeping = !used.bullet_boxes;
    state->def = used;
    return plii_body_changed(body, PLI_OK);
}
pli_status pli_body_disable_soft_contacts(pli_body* body) {
    PLII_TRY(plii_check_body_change(body, __func__));
    plii_feature_disable(body, &plii_bullet_boxes_class);
    return plii_feature_disable(body, &plii_soft_contacts_class) ? plii_body_changed(body, PLI_OK) : PLI_OK;
}

PLII_DEFINE_CONTACTS_GET(pli_body_get_soft_contacts, pli_soft_contact, plii_soft_contacts_state, plii_soft_contact,
                         plii_soft_contacts_class,
                         (pli_soft_contact){.node = contact->node,
                                            .face_body = contact->face_body,
                                            .face = contact->face,
                                            .weights = {contact->weights.x, contact->weights.y, contact->weights.z},
                                            .normal = contact->normal,
                                            .margin = contact->margin})

pli_status pli_body_reorder_soft_contacts(pli_body* body, const int* order, int count) {
    return plii_reorder_contacts(body, &plii_soft_contacts_class, order, count, __func__);
}
