/* One contact of a cluster. As Bullet (SolveContact, CJoint, in their order of operations) every iteration adds a share
   of the correction and of the sliding velocity; otherwise impulses are summed over the iterations, the sum along the
   normal pushes only, and friction is bounded by it (Catto, "Iterative dynamics with temporal coherence", 2005). */

#include "lanes.h"

#include "cluster_contacts_impl.h"

/* Share of the margin that contacts may be too deep without being corrected, so that bodies keep their contacts when
   they rest. */
#define CLUSTER_CONTACT_SLOP 0.05f

/* Distances may come from the user. */
static bool cluster_contact_is_usable(const pli_cluster_contact* info) {
    return plii_is_finite(info->distance) && plii_vec3_is_finite(info->witness) &&
           plii_vec3_is_finite(info->other_witness) && plii_vec3_is_finite(info->normal) &&
           pli_vec3_length_squared(info->normal) > FLT_MIN;
}

static pli_vec3 cluster_contact_velocity(const plii_cluster_contact* contact) {
    return pli_vec3_sub(plii_joint_velocity_at(&contact->targets[0], contact->arms[0]),
                        plii_joint_velocity_at(&contact->targets[1], contact->arms[1]));
}

/* plii_joint_side_response of four directions. */
static plii_float4 cluster_contact_responses(const plii_joint_side* side, pli_vec3 arm, plii_vec3x4 directions) {
    const plii_vec3x4 turns = plii_vec3x4_cross(plii_vec3x4_all(arm), directions);
    const pli_vec3* rows = side->inverse_inertia.rows;
    const plii_vec3x4 changes = {plii_vec3x4_dot(plii_vec3x4_all(rows[0]), turns),
                                 plii_vec3x4_dot(plii_vec3x4_all(rows[1]), turns),
                                 plii_vec3x4_dot(plii_vec3x4_all(rows[2]), turns)};
    return plii_float4_add(
        plii_float4_mul(plii_float4_all(side->inverse_mass), plii_vec3x4_dot(directions, directions)),
        plii_vec3x4_dot(turns, changes));
}

/* kg that impulses along the normal and the tangents meet; 0 when nothing can move. */
static void cluster_contact_find_masses(plii_cluster_contact* contact, const plii_joint_side sides[2]) {
    plii_cluster_contact_own* own = &contact->as.own;
    const pli_vec3 n = contact->normal, t = own->tangents[0], u = own->tangents[1];
    const plii_vec3x4 directions = {plii_lanes_xyzw(n.x, t.x, u.x, 0), plii_lanes_xyzw(n.y, t.y, u.y, 0),
                                    plii_lanes_xyzw(n.z, t.z, u.z, 0)};
    float responses[PLII_LANES], masses[3];
    plii_float4_store(responses, plii_float4_add(cluster_contact_responses(&sides[0], contact->arms[0], directions),
                                                 cluster_contact_responses(&sides[1], contact->arms[1], directions)));
    for (int i = 0; i < 3; ++i) {
        const bool can_move = responses[i] > FLT_MIN && plii_is_finite(responses[i]);
        masses[i] = can_move ? 1.0f / responses[i] : 0.0f;
    }
    own->normal_mass = masses[0];
    own->tangent_masses[0] = masses[1];
    own->tangent_masses[1] = masses[2];
}

static void cluster_contact_make_as_bullet(plii_cluster_contact* contact, const plii_joint_side sides[2],
                                           const plii_contact_terms* terms) {
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float approach = pli_vec3_dot(velocity, contact->normal);
    const pli_vec3 sliding = pli_vec3_sub(velocity, pli_vec3_scale(contact->normal, approach));
    const float cone = approach * terms->friction * approach * terms->friction;
    contact->friction = pli_vec3_length_squared(sliding) < cone ? 1.0f : terms->friction;
    contact->as.bullet.drift = pli_vec3_scale(contact->normal, contact->info.distance - terms->margin);
    contact->as.bullet.impulse_matrix =
        plii_joint_impulse_matrix(&sides[0], contact->arms[0], &sides[1], contact->arms[1]);
}

static void cluster_contact_make_own(plii_cluster_contact* contact, const plii_joint_side sides[2],
                                     const plii_contact_terms* terms) {
    plii_cluster_contact_own* own = &contact->as.own;
    *own = (plii_cluster_contact_own){0};
    const pli_vec3 n = contact->normal;
    contact->friction = terms->friction;
    own->depth = terms->margin - contact->info.distance - CLUSTER_CONTACT_SLOP * (terms->margin - terms->radius);
    /* Rigid bodies have not moved yet. */
    pli_vec3 included = plii_joint_velocity_at(&contact->targets[0], contact->arms[0]);
    if (contact->targets[1].cluster != NULL) { included = cluster_contact_velocity(contact); }
    own->included_speed = pli_vec3_dot(included, n);
    const pli_vec3 across = fabsf(n.x) > 0.6f ? pli_vec3_make(0, 1, 0) : pli_vec3_make(1, 0, 0);
    own->tangents[0] = plii_vec3_safe_normalize(pli_vec3_cross(n, across));
    own->tangents[1] = pli_vec3_cross(n, own->tangents[0]);
    cluster_contact_find_masses(contact, sides);
}

bool plii_cluster_contact_make(const pli_cluster_contact* info, const plii_joint_side sides[2],
                               const plii_contact_terms* terms, bool as_bullet, plii_cluster_contact* contact) {
    if (!(info->distance < terms->margin) || !cluster_contact_is_usable(info)) { return false; }
    const pli_vec3 normal = plii_vec3_divide(info->normal, pli_vec3_length(info->normal));
    pli_vec3 point_a = info->witness, point_b = info->other_witness;
    if (!as_bullet) {
        /* Bullet acts on the cores, at two points: friction between them would make angular momentum. */
        point_b = pli_vec3_add(point_b, pli_vec3_scale(normal, terms->radius));
        point_a = point_b = pli_vec3_lerp(point_a, point_b, 0.5f);
    }
    contact->info = *info;
    contact->targets[0] = sides[0].target;
    contact->targets[1] = sides[1].target;
    contact->arms[0] = pli_vec3_sub(point_a, sides[0].frame.origin);
    contact->arms[1] = pli_vec3_sub(point_b, sides[1].frame.origin);
    contact->normal = normal;
    contact->erp = terms->hardness;
    contact->split = terms->split;
    contact->is_self = false;
    contact->as_bullet = as_bullet;
    contact->split_drift = pli_vec3_make(0, 0, 0);
    (as_bullet ? cluster_contact_make_as_bullet : cluster_contact_make_own)(contact, sides, terms);
    return true;
}

// ------------------------------------------------------------------------------------------------------------ prepare

static void cluster_contact_prepare_as_bullet(plii_cluster_contact* contact, const plii_step* step, int iterations) {
    plii_cluster_contact_as_bullet* own = &contact->as.bullet;
    own->drift = plii_vec3_divide(pli_vec3_scale(own->drift, contact->erp), step->dt);
    if (contact->split > 0.0f) {
        contact->split_drift = pli_mat3_mul_vec3(own->impulse_matrix, pli_vec3_scale(own->drift, contact->split));
        own->drift = pli_vec3_scale(own->drift, 1.0f - contact->split);
    }
    own->drift = plii_vec3_divide(own->drift, (float)iterations);
}

/* `depth` was measured after this step's motion, which the impulses will change. */
static void cluster_contact_prepare_own(plii_cluster_contact* contact, const plii_step* step) {
    plii_cluster_contact_own* own = &contact->as.own;
    const float speed_out = own->depth * step->inverse_dt + plii_min(own->included_speed, 0.0f);
    if (speed_out <= 0.0f) {
        own->wanted_speed = speed_out; /* not there yet: slow enough not to get deeper */
        return;
    }
    const float corrected = speed_out * contact->erp;
    own->wanted_speed = corrected * (1.0f - contact->split);
    contact->split_drift = pli_vec3_scale(contact->normal, -corrected * contact->split * own->normal_mass);
}

void plii_cluster_contact_prepare(plii_cluster_contact* contact, const plii_step* step, int iterations) {
    if (contact->as_bullet) {
        cluster_contact_prepare_as_bullet(contact, step, iterations);
    } else {
        cluster_contact_prepare_own(contact, step);
    }
}

// -------------------------------------------------------------------------------------------------------------- solve

static void cluster_contact_apply(plii_cluster_contact* contact, pli_vec3 impulse) {
    plii_joint_apply_impulse(&contact->targets[0], pli_vec3_neg(impulse), contact->arms[0]);
    plii_joint_apply_impulse(&contact->targets[1], impulse, contact->arms[1]);
}

static void cluster_contact_solve_as_bullet(plii_cluster_contact* contact) {
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float approach = pli_vec3_dot(velocity, contact->normal);
    pli_vec3 change = contact->as.bullet.drift;
    if (approach < 0.0f) {
        const pli_vec3 closing = pli_vec3_scale(contact->normal, approach);
        const pli_vec3 sliding = pli_vec3_sub(velocity, closing);
        change = pli_vec3_add(change, pli_vec3_add(closing, pli_vec3_scale(sliding, contact->friction)));
    }
    cluster_contact_apply(contact, pli_mat3_mul_vec3(contact->as.bullet.impulse_matrix, change));
}

/* Impulses between clusters of one body: limited and scaled as the first cluster says. */
static float cluster_contact_self_factor(const plii_cluster_contact* contact) {
    return contact->is_self ? contact->targets[0].cluster->settings.self_impulse_factor : 1.0f;
}
static float cluster_contact_self_limit(const plii_cluster_contact* contact) {
    return contact->is_self ? contact->targets[0].cluster->settings.max_self_impulse : INFINITY;
}

static void cluster_contact_solve_own(plii_cluster_contact* contact) {
    plii_cluster_contact_own* own = &contact->as.own;
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float factor = cluster_contact_self_factor(contact);
    const float missing = own->wanted_speed - pli_vec3_dot(velocity, contact->normal);
    const float old_normal = own->normal_impulse;
    /* Going apart, with nothing to take back: no friction either. */
    if (old_normal == 0.0f && !(missing > 0.0f)) { return; }
    own->normal_impulse =
        plii_clamp(old_normal + factor * missing * own->normal_mass, 0.0f, cluster_contact_self_limit(contact));
    pli_vec3 push = pli_vec3_scale(contact->normal, own->normal_impulse - old_normal);

    float wanted[2];
    float length_squared = 0.0f;
    for (int i = 0; i < 2; ++i) {
        const float sliding = pli_vec3_dot(velocity, own->tangents[i]);
        wanted[i] = own->tangent_impulses[i] - factor * sliding * own->tangent_masses[i];
        length_squared += wanted[i] * wanted[i];
    }
    const float bound = contact->friction * own->normal_impulse;
    const float scale = length_squared > bound * bound ? bound / sqrtf(length_squared) : 1.0f;
    for (int i = 0; i < 2; ++i) {
        push = pli_vec3_add(push, pli_vec3_scale(own->tangents[i], wanted[i] * scale - own->tangent_impulses[i]));
        own->tangent_impulses[i] = wanted[i] * scale;
    }
    /* The motions of clusters that share nodes are averaged over those that were pushed. */
    if (pli_vec3_length_squared(push) > 0.0f) { cluster_contact_apply(contact, pli_vec3_neg(push)); }
}

void plii_cluster_contact_solve(plii_cluster_contact* contact) {
    (contact->as_bullet ? cluster_contact_solve_as_bullet : cluster_contact_solve_own)(contact);
}

void plii_cluster_contact_finish(plii_cluster_contact* contact) {
    if (!(contact->split > 0.0f)) { return; }
    pli_vec3 drift = contact->split_drift;
    if (contact->is_self) {
        const float size = pli_vec3_length(drift), limit = cluster_contact_self_limit(contact);
        drift = pli_vec3_scale(drift, cluster_contact_self_factor(contact) * (size > limit ? limit / size : 1.0f));
    }
    /* Displacements are averaged by their number: none must not count. */
    if (!contact->as_bullet && pli_vec3_length_squared(drift) == 0.0f) { return; }
    plii_joint_apply_drift(&contact->targets[0], pli_vec3_neg(drift), contact->arms[0]);
    /* A rigid body is not displaced; Bullet gives it a velocity instead, and momentum from nothing. */
    if (contact->as_bullet || contact->targets[1].rigid == NULL) {
        plii_joint_apply_drift(&contact->targets[1], drift, contact->arms[1]);
    }
}
