/* The solve of contacts of nodes with the faces of another soft body (btSoftBody::PSolve_SContacts).

   In reference mode, and of bodies that cannot be solved side by side, one is solved before the other. As in Bullet a
   contact moves its nodes then; outside of reference mode it gives them their velocities, too. */

#include "contact/contact_substep.h"
#include "contact/soft_contacts_impl.h"

static void soft_contacts_move(pli_vec4* position, pli_vec3 step) {
    plii_set_xyz(position, pli_vec3_sub(plii_xyz(*position), step));
}

/* Overlaps go at this speed; those of Bullet's contacts at once where 0 is wanted. */
static float soft_contacts_recovery_speed(const plii_soft_contacts_state* state, const plii_soft_contact* contact) {
    return contact->is_bullet ? state->def.recovery_speed : plii_contact_recovery_speed(state->def.recovery_speed);
}

/* As if the node had been there at the start of the step, so that no velocity comes of it. */
static void soft_contacts_shift(pli_body* body, int node, pli_vec3 by) {
    plii_set_xyz(&body->positions[node], pli_vec3_add(plii_xyz(body->positions[node]), by));
    plii_set_xyz(&body->previous[node], pli_vec3_add(plii_xyz(body->previous[node]), by));
}

/* Springs and links pull nodes back that were put apart. Had that given them speed, they would wind it up from step to
   step. The normal of a node that the prediction took through the face points the wrong way; it is only stopped. */
void plii_soft_contacts_recover(pli_body* body, void* data) {
    const plii_soft_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_soft_contact* contact = &state->contacts[i];
        const float most = soft_contacts_recovery_speed(state, contact) * body->step.dt;
        if (!(most > 0.0f)) { continue; }
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(body->previous[contact->node]),
                                            plii_soft_contacts_blend(other->previous, face, contact->weights));
        const float distance = pli_vec3_dot(contact->normal, apart);
        const float depth = body->collision_margin + other->collision_margin - distance;
        if (!(depth > 0.0f) || (contact->is_bullet && distance < 0.0f)) { continue; }
        const pli_vec3 shift = pli_vec3_scale(contact->normal, plii_min(depth, most));
        soft_contacts_shift(body, contact->node, pli_vec3_scale(shift, contact->node_share));
        for (int k = 0; k < 3; ++k) {
            soft_contacts_shift(other, face[k], pli_vec3_scale(shift, -contact->face_share * weights[k]));
        }
    }
}

/* A body that was solved before takes its velocities from positions no more. */
static void soft_contacts_push_solved(pli_body* other, const int* face, pli_vec3 weights, pli_vec3 correction) {
    const float w[3] = {weights.x, weights.y, weights.z};
    for (int k = 0; k < 3; ++k) {
        pli_vec4* velocity = &other->velocities[face[k]];
        const pli_vec3 change = pli_vec3_scale(correction, w[k] * other->step.inverse_dt);
        plii_set_xyz(velocity, pli_vec3_sub(plii_xyz(*velocity), change));
    }
}

/* What is taken from the sliding: a fixed share, as in Bullet; else what stops it, but not above Coulomb's limit. */
static pli_vec3 soft_contacts_friction(const plii_soft_contact* contact, pli_vec3 sliding, float depth) {
    if (contact->is_bullet) { return pli_vec3_scale(sliding, contact->friction); }
    const float length = pli_vec3_length(sliding), limit = contact->friction * depth;
    return length > limit ? pli_vec3_scale(sliding, limit / length) : sliding;
}

void plii_soft_contacts_solve(pli_body* body, void* data) {
    const plii_soft_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_soft_contact* contact = &state->contacts[i];
        const bool shifts = soft_contacts_recovery_speed(state, contact) > 0.0f; /* what overlapped before */
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const pli_vec3 n = contact->normal, weights = contact->weights;
        const pli_vec3 x = plii_soft_contacts_position(body, contact->node);
        const pli_vec3 point = plii_soft_contacts_blend(other->positions, face, weights);
        const pli_vec3 point_before = plii_soft_contacts_blend(other->previous, face, weights);
        const pli_vec3 motion =
            pli_vec3_sub(pli_vec3_sub(x, plii_xyz(body->previous[contact->node])), pli_vec3_sub(point, point_before));
        const float along_normal = pli_vec3_dot(motion, n);
        float depth = 0.0f;
        if (along_normal < 0.0f) {
            depth = contact->margin - (pli_vec3_dot(n, x) - pli_vec3_dot(n, point));
            if (shifts) { depth = plii_min(depth, -along_normal); }
        }
        if (!contact->is_bullet && !(depth > 0.0f)) { continue; }
        const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, along_normal));
        const pli_vec3 correction =
            pli_vec3_sub(pli_vec3_scale(n, depth), soft_contacts_friction(contact, sliding, depth));
        plii_set_xyz(&body->positions[contact->node], pli_vec3_add(x, pli_vec3_scale(correction, contact->node_share)));
        soft_contacts_move(&other->positions[face[0]], pli_vec3_scale(correction, contact->face_share * weights.x));
        soft_contacts_move(&other->positions[face[1]], pli_vec3_scale(correction, contact->face_share * weights.y));
        soft_contacts_move(&other->positions[face[2]], pli_vec3_scale(correction, contact->face_share * weights.z));
        if (i < state->impulse_count) { plii_soft_contacts_note(body, state, i, correction); }
        if (shifts && other->is_solved) {
            soft_contacts_push_solved(other, face, weights, pli_vec3_scale(correction, contact->face_share));
        }
    }
}
