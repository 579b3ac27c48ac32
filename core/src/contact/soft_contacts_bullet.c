/* The solve of contacts of nodes with the faces of another soft body as in btSoftBody::PSolve_SContacts, for bodies
   with Bullet's boxes: one body is solved before the other, and a contact moves its nodes. With a recovery speed, which
   Bullet does not have, it gives those of a body that was solved before their velocities, too. */

#include "contact/soft_contacts_impl.h"

/* As if the node had been there at the start of the step, so that no velocity comes of it. */
static void soft_bullet_shift(pli_body* body, int node, pli_vec3 by) {
    plii_add_xyz(&body->positions[node], by);
    plii_add_xyz(&body->previous[node], by);
}

/* Springs and links pull nodes back that were put apart. Had that given them speed, they would wind it up from step to
   step. The normal of a node that the prediction took through the face points the wrong way; it is only stopped. */
void plii_soft_contacts_recover_bullet(pli_body* body, void* data) {
    const plii_soft_contacts_state* state = data;
    const float most = state->def.recovery_speed * body->step.dt;
    for (int i = 0; most > 0.0f && i < state->count; ++i) {
        const plii_soft_contact* contact = &state->contacts[i];
        if (!contact->is_bullet) { continue; }
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(body->previous[contact->node]),
                                            plii_contact_blend(other->previous, face, contact->weights));
        const float distance = pli_vec3_dot(contact->normal, apart);
        const float depth = body->collision_margin + other->collision_margin - distance;
        if (!(depth > 0.0f) || distance < 0.0f) { continue; }
        const pli_vec3 shift = pli_vec3_scale(contact->normal, plii_min(depth, most));
        soft_bullet_shift(body, contact->node, pli_vec3_scale(shift, contact->node_share));
        for (int k = 0; k < 3; ++k) {
            soft_bullet_shift(other, face[k], pli_vec3_scale(shift, -contact->face_share * weights[k]));
        }
    }
}

void plii_soft_contacts_solve_bullet(pli_body* body, void* data) {
    const plii_soft_contacts_state* state = data;
    const bool shifts = state->def.recovery_speed > 0.0f; /* what overlapped before */
    for (int i = 0; i < state->count; ++i) {
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
        const float w[3] = {weights.x, weights.y, weights.z};
        for (int k = 0; k < 3; ++k) {
            plii_add_xyz(&other->positions[face[k]], pli_vec3_scale(correction, -contact->face_share * w[k]));
            if (!shifts || !other->is_solved) { continue; }
            /* It takes its velocities from positions no more. */
            const pli_vec3 share = pli_vec3_scale(correction, contact->face_share);
            plii_add_xyz(&other->velocities[face[k]], pli_vec3_scale(share, -w[k] * other->step.inverse_dt));
        }
        if (i < state->impulse_count) { plii_soft_contacts_note(body, state, i, correction); }
    }
}
