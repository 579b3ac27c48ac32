/* One contact of a cluster. As Bullet (SolveContact, CJoint, in their order of operations) every iteration adds a share
   of the correction and of the sliding velocity; other contacts are solved as rows. */

#include "cluster/cluster_contacts_impl.h"

/* Share of the margin that contacts may be too deep without being corrected, so that bodies keep their contacts when
   they rest. */
#define CLUSTER_CONTACT_SLOP 0.05f

/* Distances may come from the user. */
static bool cluster_contact_is_usable(const pli_cluster_contact* info) {
    const float far = 4.0f * PLI_MAX_COORDINATE;
    return plii_is_within(info->distance, far) && plii_vec3_is_within(info->witness, far) &&
           plii_vec3_is_within(info->other_witness, far) && plii_vec3_is_within(info->normal, far) &&
           pli_vec3_length_squared(info->normal) > FLT_MIN;
}

static pli_vec3 cluster_contact_velocity(const plii_cluster_contact* contact) {
    return pli_vec3_sub(plii_joint_velocity_at(&contact->targets[0], contact->arms[0]),
                        plii_joint_velocity_at(&contact->targets[1], contact->arms[1]));
}

static void cluster_contact_make_as_reference(plii_cluster_contact* contact, const plii_joint_end sides[2],
                                              const plii_contact_terms* terms) {
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float approach = pli_vec3_dot(velocity, contact->normal);
    const pli_vec3 sliding = pli_vec3_sub(velocity, pli_vec3_scale(contact->normal, approach));
    const float cone = approach * terms->friction * approach * terms->friction;
    contact->as.reference.friction = pli_vec3_length_squared(sliding) < cone ? 1.0f : terms->friction;
    contact->as.reference.drift = pli_vec3_scale(contact->normal, contact->info.distance - terms->margin);
    contact->as.reference.erp = terms->hardness;
    contact->as.reference.split = terms->split;
    contact->as.reference.split_drift = pli_vec3_make(0, 0, 0);
    contact->as.reference.impulse_matrix =
        plii_joint_impulse_matrix(&sides[0], contact->arms[0], &sides[1], contact->arms[1]);
}

void plii_cluster_contact_set(plii_cluster_contact* contact, const pli_cluster_contact* info, pli_vec3 normal,
                              const plii_joint_target targets[2], pli_vec3 centre, pli_vec3 other_centre,
                              const plii_contact_terms* terms) {
    contact->info = *info;
    contact->targets[0] = targets[0];
    contact->targets[1] = targets[1];
    contact->normal = normal;
    contact->is_self = contact->reference_mode = false;
    /* Bullet acts on the cores, at two points: friction between them would make angular momentum. */
    const pli_vec3 surface = pli_vec3_add(info->other_witness, pli_vec3_scale(normal, terms->radius));
    const pli_vec3 point = pli_vec3_lerp(info->witness, surface, 0.5f);
    contact->arms[0] = pli_vec3_sub(point, centre);
    contact->arms[1] = pli_vec3_sub(point, other_centre);
    const float depth = terms->margin - info->distance - CLUSTER_CONTACT_SLOP * (terms->margin - terms->radius);
    contact->as.terms = (pli_vec4){depth, terms->hardness, terms->split, terms->friction};
}

bool plii_cluster_contact_make(const pli_cluster_contact* info, const plii_joint_end sides[2],
                               const plii_contact_terms* terms, bool reference_mode, plii_cluster_contact* contact) {
    if (!(info->distance < terms->margin) || !cluster_contact_is_usable(info)) { return false; }
    const pli_vec3 normal = plii_vec3_divide(info->normal, pli_vec3_length(info->normal));
    const plii_joint_target targets[2] = {sides[0].target, sides[1].target};
    plii_cluster_contact_set(contact, info, normal, targets, sides[0].frame.origin, sides[1].frame.origin, terms);
    if (!reference_mode) { return true; }
    contact->arms[0] = pli_vec3_sub(info->witness, sides[0].frame.origin);
    contact->arms[1] = pli_vec3_sub(info->other_witness, sides[1].frame.origin);
    contact->reference_mode = true;
    cluster_contact_make_as_reference(contact, sides, terms);
    return true;
}

void plii_cluster_contact_prepare(plii_cluster_contact* contact, float dt, int iterations) {
    plii_cluster_contact_as_reference* state = &contact->as.reference;
    state->drift = plii_vec3_divide(pli_vec3_scale(state->drift, state->erp), dt);
    if (state->split > 0.0f) {
        state->split_drift = pli_mat3_mul_vec3(state->impulse_matrix, pli_vec3_scale(state->drift, state->split));
        state->drift = pli_vec3_scale(state->drift, 1.0f - state->split);
    }
    state->drift = plii_vec3_divide(state->drift, (float)iterations);
}

void plii_cluster_contact_solve(plii_cluster_contact* contact) {
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float approach = pli_vec3_dot(velocity, contact->normal);
    pli_vec3 change = contact->as.reference.drift;
    if (approach < 0.0f) {
        const pli_vec3 closing = pli_vec3_scale(contact->normal, approach);
        const pli_vec3 sliding = pli_vec3_sub(velocity, closing);
        change = pli_vec3_add(change, pli_vec3_add(closing, pli_vec3_scale(sliding, contact->as.reference.friction)));
    }
    const pli_vec3 impulse = pli_mat3_mul_vec3(contact->as.reference.impulse_matrix, change);
    plii_joint_apply_impulse(&contact->targets[0], pli_vec3_neg(impulse), contact->arms[0]);
    plii_joint_apply_impulse(&contact->targets[1], impulse, contact->arms[1]);
}

void plii_cluster_contact_finish(plii_cluster_contact* contact) {
    if (!(contact->as.reference.split > 0.0f)) { return; }
    const pli_vec3 drift = contact->as.reference.split_drift;
    plii_joint_apply_drift(&contact->targets[0], pli_vec3_neg(drift), contact->arms[0]);
    plii_joint_apply_drift(&contact->targets[1], drift, contact->arms[1]);
}
