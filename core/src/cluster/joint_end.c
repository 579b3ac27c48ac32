/* Ends of joints and of cluster contacts. */

#include "cluster/joint_end.h"

plii_joint_end plii_joint_end_of_cluster(const pli_body* body, int cluster) {
    plii_cluster* item = &body->clusters->items[cluster];
    plii_cluster_update_frame(body, item);
    plii_joint_end side = {.frame = item->frame, .rest_centre = item->rest_centre};
    /* A frozen body takes no impulses. */
    if (plii_body_is_idle(body)) { return side; }
    side.target.cluster = item;
    side.inverse_mass = item->inverse_mass;
    side.inverse_inertia = item->inverse_inertia;
    return side;
}

plii_joint_end plii_joint_end_of_rigid(pli_rigid* rigid) {
    return (plii_joint_end){.target = {.rigid = rigid},
                            .frame = rigid->state.pose,
                            .inverse_mass = rigid->state.inverse_mass,
                            .inverse_inertia = rigid->state.inverse_inertia_world};
}

/* That of `other` where the inverse is not finite: what is held along an axis takes no impulse along it anyway. */
static pli_mat3 joint_inverse_or(pli_mat3 m, const pli_mat3* other) {
    const pli_mat3 inverse = plii_mat3_inverse(m);
    if (plii_mat3_is_finite(inverse)) { return inverse; }
    return other != NULL ? joint_inverse_or(*other, NULL) : plii_mat3_diagonal(0, 0, 0);
}

pli_mat3 plii_joint_impulse_matrix(const plii_joint_end* a, pli_vec3 r_a, const plii_joint_end* b, pli_vec3 r_b) {
    const pli_mat3 own = plii_point_response(a->inverse_mass, &a->inverse_inertia, r_a);
    const pli_mat3 all = plii_mat3_add(own, plii_point_response(b->inverse_mass, &b->inverse_inertia, r_b));
    if (!b->has_factors) { return joint_inverse_or(all, NULL); }
    return joint_inverse_or(plii_mat3_add(own, plii_rigid_response(b->target.rigid, r_b)), &all);
}
pli_mat3 plii_joint_angular_impulse_matrix(const plii_joint_end* a, const plii_joint_end* b) {
    const pli_mat3 all = plii_mat3_add(a->inverse_inertia, b->inverse_inertia);
    return joint_inverse_or(plii_mat3_add(a->inverse_inertia, plii_joint_end_inertia(b)), &all);
}

pli_mat3 plii_joint_end_inertia(const plii_joint_end* side) {
    return side->has_factors ? plii_rigid_inertia(side->target.rigid) : side->inverse_inertia;
}

float plii_joint_end_response(const plii_joint_end* side, pli_vec3 offset, pli_vec3 direction) {
    const pli_vec3 angular_change = pli_vec3_cross(offset, direction);
    if (side->has_factors) {
        return plii_rigid_linear_response(side->target.rigid, direction) +
               pli_vec3_dot(angular_change, plii_rigid_spin_of(side->target.rigid, direction, offset));
    }
    return side->inverse_mass * pli_vec3_length_squared(direction) +
           pli_vec3_dot(angular_change, pli_mat3_mul_vec3(side->inverse_inertia, angular_change));
}

pli_vec3 plii_joint_angular_velocity(const plii_joint_target* target) {
    if (target->rigid != NULL) { return target->rigid->state.angular_velocity; }
    return target->cluster != NULL ? plii_xyz(target->cluster->angular_velocity) : pli_vec3_make(0, 0, 0);
}

void plii_joint_apply_torque(const plii_joint_target* target, pli_vec3 impulse, bool is_drift) {
    if (target->rigid != NULL) { plii_rigid_apply_torque_impulse(target->rigid, impulse); }
    plii_cluster* cluster = target->cluster;
    if (cluster == NULL) { return; }
    const pli_vec3 change = pli_mat3_mul_vec3(cluster->inverse_inertia, impulse);
    plii_cluster_impulse_add(is_drift ? &cluster->drift : &cluster->impulse, pli_vec3_make(0, 0, 0), change, 1);
    if (is_drift) { return; }
    plii_add_xyz(&cluster->angular_velocity, change);
}
