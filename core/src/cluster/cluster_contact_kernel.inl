/* How the sides of groups of contacts move, and their iterations, with what the including file has to offer: the two
   sides of four pairs at once where there are eight lanes, and with more registers fewer are put aside. */

#include "cluster/cluster_contacts_impl.h"
#include "math/simd_float8.h"

// -------------------------------------------------------------------------------------------------------------- lanes

static inline void groups_store(plii_group_vec3* target, plii_vec3x4 v) {
    plii_float4_store(target->x, v.x);
    plii_float4_store(target->y, v.y);
    plii_float4_store(target->z, v.z);
}
static inline plii_vec3x8 groups_load_sides(const plii_group_sides3* v) {
    return (plii_vec3x8){plii_float8_load(v->x), plii_float8_load(v->y), plii_float8_load(v->z)};
}
static inline void groups_store_sides(plii_group_sides3* target, plii_vec3x8 v) {
    plii_float8_store(target->x, v.x);
    plii_float8_store(target->y, v.y);
    plii_float8_store(target->z, v.z);
}
/* The same on both sides. */
static inline plii_float8 groups_both(plii_float4 a) {
    return plii_float8_of(a, a);
}
static inline plii_vec3x8 groups_both3(plii_vec3x4 a) {
    return plii_vec3x8_of(a, a);
}

static inline plii_vec3x8 groups_gather(pli_vec4* const a[PLII_GROUP_LANES], pli_vec4* const b[PLII_GROUP_LANES]) {
    plii_float8 rows[PLII_GROUP_LANES];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        rows[lane] = plii_float8_of(plii_float4_from(a[lane]), plii_float4_from(b[lane]));
    }
    plii_float8_transpose4(rows);
    return (plii_vec3x8){rows[0], rows[1], rows[2]};
}
static inline void groups_scatter(pli_vec4* const a[PLII_GROUP_LANES], pli_vec4* const b[PLII_GROUP_LANES],
                                  plii_vec3x8 v) {
    plii_float8 rows[PLII_GROUP_LANES] = {v.x, v.y, v.z, groups_both(plii_float4_all(0.0f))};
    plii_float8_transpose4(rows);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_float4_to(a[lane], plii_float8_low(rows[lane]));
        plii_float4_to(b[lane], plii_float8_high(rows[lane]));
    }
}
/* Side 1, where each lane moves its record by its share. */
static inline void groups_scatter_shares(pli_vec4* const a[PLII_GROUP_LANES], pli_vec4* const b[PLII_GROUP_LANES],
                                         plii_vec3x8 before, plii_vec3x8 after, plii_float4 shares) {
    plii_float4 rows[PLII_GROUP_LANES] = {plii_float8_low(after.x), plii_float8_low(after.y), plii_float8_low(after.z),
                                          plii_float4_all(0.0f)};
    const plii_vec3x4 change = plii_vec3x4_sub(plii_vec3x8_high(after), plii_vec3x8_high(before));
    const plii_vec3x4 share = plii_vec3x4_scale(change, shares);
    plii_float4 moves[PLII_GROUP_LANES] = {share.x, share.y, share.z, plii_float4_all(0.0f)};
    plii_float4_transpose(rows);
    plii_float4_transpose(moves);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_float4_to(a[lane], rows[lane]);
        plii_float4_to(b[lane], plii_float4_from(b[lane]) + moves[lane]);
    }
}
static inline plii_vec3x4 groups_from_vectors(const pli_vec3* const vectors[PLII_GROUP_LANES]) {
    plii_float4 rows[4] = {plii_lanes_from_vec3(vectors[0]), plii_lanes_from_vec3(vectors[1]),
                           plii_lanes_from_vec3(vectors[2]), plii_lanes_from_vec3(vectors[3])};
    plii_float4_transpose(rows);
    return (plii_vec3x4){rows[0], rows[1], rows[2]};
}

static inline plii_vec3x8 groups_sum(const plii_group_sides3 rotations[3], const plii_float4 impulses[3]) {
    const plii_vec3x8 first = plii_vec3x8_scale(groups_load_sides(&rotations[0]), groups_both(impulses[0]));
    const plii_vec3x8 second = plii_vec3x8_scale(groups_load_sides(&rotations[1]), groups_both(impulses[1]));
    const plii_vec3x8 third = plii_vec3x8_scale(groups_load_sides(&rotations[2]), groups_both(impulses[2]));
    return plii_vec3x8_add(plii_vec3x8_add(first, second), third);
}
static inline plii_vec3x4 groups_push(const plii_vec3x4 directions[3], const plii_float4 impulses[3]) {
    return plii_vec3x4_add(
        plii_vec3x4_add(plii_vec3x4_scale(directions[0], impulses[0]), plii_vec3x4_scale(directions[1], impulses[1])),
        plii_vec3x4_scale(directions[2], impulses[2]));
}

/* Velocities of both sides. */
typedef struct group_motion {
    plii_vec3x8 linear, angular;
} group_motion;

/* Of side 0 against side 1, at the contact. */
static inline plii_vec3x4 groups_velocity_at(const group_motion* motion, plii_vec3x8 arms) {
    const plii_vec3x8 both = plii_vec3x8_add(motion->linear, plii_vec3x8_cross(motion->angular, arms));
    return plii_vec3x4_sub(plii_vec3x8_low(both), plii_vec3x8_high(both));
}

// ------------------------------------------------------------------------------------------------------------ prepare

static const plii_cluster_contact groups_no_contact = {.normal = {0, 0, 1}};

static const pli_mat3 groups_no_inertia = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};

/* Returns the inverse inertia. */
static const pli_mat3* groups_load_target(plii_contact_batches* groups, const plii_joint_target* target, int lane,
                                          plii_group_side* side, float* inverse_mass) {
    side->clusters[lane] = target->cluster;
    side->linear[lane] = &groups->still[0];
    side->angular[lane] = &groups->still[1];
    *inverse_mass = 0.0f;
    if (target->cluster != NULL) {
        side->linear[lane] = &target->cluster->linear_velocity;
        side->angular[lane] = &target->cluster->angular_velocity;
        *inverse_mass = target->cluster->inverse_mass;
        return &target->cluster->inverse_inertia;
    }
    if (target->rigid == NULL) { return &groups_no_inertia; }
    plii_group_rigid* touched = &groups->rigids[target->rigid->world_index];
    side->linear[lane] = &touched->linear_velocity;
    side->angular[lane] = &touched->angular_velocity;
    if (target->rigid->state.inverse_mass == 0.0f) { return &groups_no_inertia; }
    *inverse_mass = target->rigid->state.inverse_mass;
    return &target->rigid->state.inverse_inertia_world;
}

/* How many lanes have the rigid body of each; 1 where they have none that moves. */
static void groups_count_lanes(plii_contact_batch* group, const float inverse_masses[PLII_GROUP_LANES],
                               float counts[PLII_GROUP_LANES]) {
    const plii_group_side* side = &group->sides[1];
    group->is_split = false;
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        counts[lane] = group->shares[lane] = 1.0f;
        if (side->clusters[lane] != NULL || inverse_masses[lane] == 0.0f) { continue; }
        int count = 0;
        for (int other = 0; other < PLII_GROUP_LANES; ++other) {
            count += side->linear[other] == side->linear[lane] ? 1 : 0;
        }
        if (count == 1) { continue; }
        group->is_split = true;
        counts[lane] = (float)count;
        group->shares[lane] = 1.0f / (float)count;
    }
}

/* What the contacts of a group have in common while they are prepared. */
typedef struct group_terms {
    float inverse_dt;
    plii_float8 inverse_masses;
    plii_vec3x8 inertia[3];      /* rows of the inverse inertias */
    plii_vec3x8 angular_factors; /* of rigid bodies, as plii_rigid_apply_impulse knows them; of side 1 negative */
    group_motion motion; /* part of the depth: it was measured after this step's motion, which the impulses will change;
                            but rigid bodies have not moved yet */
    plii_float4 factors; /* of impulses between clusters of one body */
} group_terms;

static void groups_load_factors(plii_contact_batch* group, group_terms* terms) {
    static const pli_vec3 one = {1, 1, 1};
    const pli_vec3 *linear[PLII_GROUP_LANES], *angular[PLII_GROUP_LANES];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        const pli_rigid* rigid = lane < group->lane_count ? group->contacts[lane]->targets[1].rigid : NULL;
        linear[lane] = rigid != NULL ? &rigid->linear_factor : &one;
        angular[lane] = rigid != NULL ? &rigid->angular_factor : &one;
    }
    const plii_vec3x4 ones = plii_vec3x4_all(one);
    terms->angular_factors = plii_vec3x8_of(ones, plii_vec3x4_neg(groups_from_vectors(angular)));
    const plii_vec3x8 linear_factors = plii_vec3x8_of(ones, plii_vec3x4_neg(groups_from_vectors(linear)));
    groups_store_sides(&group->inverse_masses, plii_vec3x8_scale(linear_factors, terms->inverse_masses));
}

static group_terms groups_load_terms(plii_contact_batches* groups, plii_contact_batch* group, const plii_step* step) {
    plii_group_side *a = &group->sides[0], *b = &group->sides[1];
    const pli_mat3* inertias[2][PLII_GROUP_LANES];
    float inverse_masses[2][PLII_GROUP_LANES], included[PLII_GROUP_LANES], factors[PLII_GROUP_LANES];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        const plii_cluster_contact* contact = lane < group->lane_count ? group->contacts[lane] : &groups_no_contact;
        inertias[0][lane] = groups_load_target(groups, &contact->targets[0], lane, a, &inverse_masses[0][lane]);
        inertias[1][lane] = groups_load_target(groups, &contact->targets[1], lane, b, &inverse_masses[1][lane]);
        included[lane] = b->clusters[lane] != NULL ? 1.0f : 0.0f;
        factors[lane] = contact->is_self ? a->clusters[lane]->settings.self_impulse_factor : 1.0f;
        group->limits[lane] = contact->is_self ? a->clusters[lane]->settings.max_self_impulse : INFINITY;
        group->frictions[lane] = contact->as.terms.w;
    }
    float counts[PLII_GROUP_LANES];
    groups_count_lanes(group, inverse_masses[1], counts);
    const plii_float4 one = plii_float4_all(1.0f);
    const plii_float8 lanes = plii_float8_of(one, plii_float4_load(counts));
    group_terms terms;
    terms.inverse_dt = step->inverse_dt;
    terms.inverse_masses = plii_float8_mul(
        plii_float8_of(plii_float4_load(inverse_masses[0]), plii_float4_load(inverse_masses[1])), lanes);
    for (int i = 0; i < 3; ++i) {
        plii_float8 rows[PLII_GROUP_LANES];
        for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
            rows[lane] = plii_float8_of(plii_lanes_from_vec3(&inertias[0][lane]->rows[i]),
                                        plii_lanes_from_vec3(&inertias[1][lane]->rows[i]));
        }
        plii_float8_transpose4(rows);
        terms.inertia[i] = plii_vec3x8_scale((plii_vec3x8){rows[0], rows[1], rows[2]}, lanes);
    }
    groups_load_factors(group, &terms);
    const plii_float8 share = plii_float8_of(one, plii_float4_load(included));
    terms.motion.linear = plii_vec3x8_scale(groups_gather(a->linear, b->linear), share);
    terms.motion.angular = plii_vec3x8_scale(groups_gather(a->angular, b->angular), share);
    terms.factors = plii_float4_load(factors);
    return terms;
}

/* Two unit vectors at right angles to a third and to each other (Duff and others, "Building an orthonormal basis,
   revisited", 2017). */
static inline void groups_find_tangents(plii_vec3x4 n, plii_vec3x4 tangents[2]) {
    const plii_float4 one = plii_float4_all(1.0f), zero = plii_float4_all(0.0f);
    const plii_float4 sign = plii_lanes_select(n.z < zero, -one, one);
    const plii_float4 a = -one / (sign + n.z);
    const plii_float4 xa = n.x * a, b = xa * n.y;
    tangents[0] = (plii_vec3x4){one + sign * (xa * n.x), sign * b, -(sign * n.x)};
    tangents[1] = (plii_vec3x4){b, sign + n.y * n.y * a, -n.y};
}

/* That impulses meet along a direction; how they turn the sides goes to the block. */
static inline plii_float4 groups_load_direction(const group_terms* common, plii_vec3x8 arms, plii_vec3x4 direction,
                                                plii_group_sides3* rotations) {
    const plii_vec3x8 moment = plii_vec3x8_cross(arms, groups_both3(direction));
    const plii_vec3x8 rotation = {plii_vec3x8_dot(common->inertia[0], moment),
                                  plii_vec3x8_dot(common->inertia[1], moment),
                                  plii_vec3x8_dot(common->inertia[2], moment)};
    groups_store_sides(rotations, plii_vec3x8_mul(rotation, common->angular_factors));
    const plii_float8 responses = plii_float8_add(common->inverse_masses, plii_vec3x8_dot(moment, rotation));
    const plii_float4 response = plii_float8_low(responses) + plii_float8_high(responses);
    const plii_mask4 can_move = (plii_float4_all(FLT_MIN) < response) & plii_lanes_finite(response);
    return plii_lanes_select(can_move, plii_float4_all(1.0f) / response, plii_float4_all(0.0f));
}

static inline void groups_prepare_block(const plii_contact_batch* group, const group_terms* common,
                                        const plii_cluster_contact* const contacts[PLII_GROUP_LANES],
                                        plii_contact_block* block) {
    const pli_vec3* const vectors[3][PLII_GROUP_LANES] = {
        {&contacts[0]->normal, &contacts[1]->normal, &contacts[2]->normal, &contacts[3]->normal},
        {&contacts[0]->arms[0], &contacts[1]->arms[0], &contacts[2]->arms[0], &contacts[3]->arms[0]},
        {&contacts[0]->arms[1], &contacts[1]->arms[1], &contacts[2]->arms[1], &contacts[3]->arms[1]}};
    plii_vec3x4 directions[3] = {groups_from_vectors(vectors[0])};
    groups_find_tangents(directions[0], directions + 1);
    const plii_vec3x8 arms = plii_vec3x8_of(groups_from_vectors(vectors[1]), groups_from_vectors(vectors[2]));
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    plii_float4 masses[3];
    for (int k = 0; k < 3; ++k) {
        masses[k] = groups_load_direction(common, arms, directions[k], &block->rotations[k]);
        groups_store(&block->directions[k], directions[k]);
        plii_float4_store(block->masses[k], masses[k] * common->factors);
        plii_float4_store(block->impulses[k], zero);
    }
    groups_store_sides(&block->arms, arms);

    plii_float4 terms[4] = {plii_float4_from(&contacts[0]->as.terms), plii_float4_from(&contacts[1]->as.terms),
                            plii_float4_from(&contacts[2]->as.terms), plii_float4_from(&contacts[3]->as.terms)};
    plii_float4_transpose(terms);
    const plii_float4 depth = terms[0], hardness = terms[1], split = terms[2];
    const plii_vec3x4 velocity = groups_velocity_at(&common->motion, arms);
    const plii_float4 included = plii_lanes_min(plii_vec3x4_dot(velocity, directions[0]), zero);
    const plii_float4 speed_out = depth * plii_float4_all(common->inverse_dt) + included;
    /* Not there yet: slow enough not to get deeper. */
    const plii_mask4 is_deep = zero < speed_out;
    const plii_float4 corrected = speed_out * hardness;
    const plii_float4 wanted = corrected * (one - split);
    plii_float4_store(block->wanted_speeds, plii_lanes_select(is_deep, wanted, speed_out));
    const plii_float4 drift = corrected * split * masses[0];
    const plii_float4 limited = plii_lanes_min(drift, plii_float4_load(group->limits)) * common->factors;
    plii_float4_store(block->drifts, plii_lanes_select(is_deep, limited, zero));
}

static void groups_prepare(plii_contact_batches* groups, const plii_step* step) {
    for (PLII_EACH(plii_contact_batch, group, groups->groups, groups->count)) {
        const group_terms common = groups_load_terms(groups, group, step);
        for (int k = 0; k < group->block_count; ++k) {
            const plii_cluster_contact* contacts[PLII_GROUP_LANES];
            for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
                contacts[lane] = k < group->counts[lane] ? &group->contacts[lane][k] : &groups_no_contact;
            }
            plii_contact_block* block = &groups->blocks[group->first_block + k];
            groups_prepare_block(group, &common, contacts, block);
            for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
                if (k < group->counts[lane]) { continue; }
                block->masses[0][lane] = block->masses[1][lane] = block->masses[2][lane] = block->drifts[lane] = 0.0f;
            }
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- solve

/* Friction as far as the impulse along the normal allows. What slides cannot be foreseen: a branch would cost more than
   the root and the quotient. */
static inline void groups_bound_friction(plii_float4 friction, plii_float4 impulses[3]) {
    const plii_float4 bound = friction * impulses[0];
    const plii_float4 squared = impulses[1] * impulses[1] + impulses[2] * impulses[2];
    const plii_mask4 slides = bound * bound < squared;
    const plii_float4 scale = plii_lanes_select(slides, bound / plii_float4_sqrt(squared), plii_float4_all(1.0f));
    impulses[1] = impulses[1] * scale;
    impulses[2] = impulses[2] * scale;
}

static inline void groups_solve_block(const plii_contact_batch* group, plii_contact_block* block,
                                      group_motion* motion) {
    const plii_vec3x4 directions[3] = {plii_group_vec3_load(&block->directions[0]),
                                       plii_group_vec3_load(&block->directions[1]),
                                       plii_group_vec3_load(&block->directions[2])};
    const plii_vec3x4 velocity = groups_velocity_at(motion, groups_load_sides(&block->arms));
    const plii_float4 missing[3] = {plii_float4_load(block->wanted_speeds) - plii_vec3x4_dot(directions[0], velocity),
                                    -plii_vec3x4_dot(directions[1], velocity),
                                    -plii_vec3x4_dot(directions[2], velocity)};
    const plii_float4 zero = plii_float4_all(0.0f);
    plii_float4 before[3], after[3], changes[3];
    for (int k = 0; k < 3; ++k) {
        before[k] = plii_float4_load(block->impulses[k]);
        after[k] = before[k] + missing[k] * plii_float4_load(block->masses[k]);
    }
    after[0] = plii_lanes_min(plii_lanes_max(after[0], zero), plii_float4_load(group->limits));
    /* Nothing pushed and nothing does: a quarter of all, of which the next one need not wait for the result. */
    if (plii_lanes_bits(zero < plii_lanes_max(before[0], after[0])) == 0) { return; }
    groups_bound_friction(plii_float4_load(group->frictions), after);
    for (int k = 0; k < 3; ++k) {
        plii_float4_store(block->impulses[k], after[k]);
        changes[k] = after[k] - before[k];
    }
    const plii_vec3x8 push = groups_both3(groups_push(directions, changes));
    motion->linear = plii_vec3x8_add(motion->linear, plii_vec3x8_mul(push, groups_load_sides(&group->inverse_masses)));
    motion->angular = plii_vec3x8_add(motion->angular, groups_sum(block->rotations, changes));
}

static void groups_solve(plii_contact_batches* groups) {
    for (PLII_EACH(const plii_contact_batch, group, groups->groups, groups->count)) {
        const plii_group_side *a = &group->sides[0], *b = &group->sides[1];
        group_motion motion = {groups_gather(a->linear, b->linear), groups_gather(a->angular, b->angular)};
        const group_motion before = motion;
        plii_contact_block* end = groups->blocks + group->first_block + group->block_count;
        for (plii_contact_block* block = end - group->block_count; block < end; ++block) {
            groups_solve_block(group, block, &motion);
        }
        if (group->is_split) {
            const plii_float4 shares = plii_float4_load(group->shares);
            groups_scatter_shares(a->linear, b->linear, before.linear, motion.linear, shares);
            groups_scatter_shares(a->angular, b->angular, before.angular, motion.angular, shares);
        } else {
            groups_scatter(a->linear, b->linear, motion.linear);
            groups_scatter(a->angular, b->angular, motion.angular);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- finish

/* What the contacts of each lane have done. */
typedef struct group_sums {
    plii_vec3x8 linear, angular;      /* velocities */
    plii_vec3x8 drift, angular_drift; /* and displacements, over the step */
    float pushed[PLII_GROUP_LANES];   /* > 0 where any impulse is not 0 */
    float drift_counts[PLII_GROUP_LANES];
} group_sums;

static inline void groups_sum_up(const plii_contact_batches* groups, const plii_contact_batch* group,
                                 group_sums* sums) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_vec3x4 nothing = {zero, zero, zero};
    plii_vec3x4 pushes = nothing, drifts = nothing;
    plii_vec3x8 rotations = groups_both3(nothing), drift_rotations = rotations;
    plii_float4 pushed = zero, drift_counts = zero;
    for (int i = 0; i < group->block_count; ++i) {
        const plii_contact_block* block = &groups->blocks[group->first_block + i];
        const plii_vec3x4 directions[3] = {plii_group_vec3_load(&block->directions[0]),
                                           plii_group_vec3_load(&block->directions[1]),
                                           plii_group_vec3_load(&block->directions[2])};
        const plii_float4 impulses[3] = {plii_float4_load(block->impulses[0]), plii_float4_load(block->impulses[1]),
                                         plii_float4_load(block->impulses[2])};
        const plii_float4 drift = plii_float4_load(block->drifts);
        pushes = plii_vec3x4_add(pushes, groups_push(directions, impulses));
        drifts = plii_vec3x4_add(drifts, plii_vec3x4_scale(directions[0], drift));
        rotations = plii_vec3x8_add(rotations, groups_sum(block->rotations, impulses));
        drift_rotations = plii_vec3x8_add(
            drift_rotations, plii_vec3x8_scale(groups_load_sides(&block->rotations[0]), groups_both(drift)));
        /* Friction has no impulse without the normal. */
        pushed = plii_lanes_max(pushed, impulses[0]);
        drift_counts = drift_counts + plii_lanes_select(zero < drift, one, zero);
    }
    const plii_vec3x8 inverse_masses = groups_load_sides(&group->inverse_masses);
    sums->linear = plii_vec3x8_mul(groups_both3(pushes), inverse_masses);
    sums->angular = rotations;
    sums->drift = plii_vec3x8_mul(groups_both3(drifts), inverse_masses);
    sums->angular_drift = drift_rotations;
    plii_float4_store(sums->pushed, pushed);
    plii_float4_store(sums->drift_counts, drift_counts);
}

/* As eight records: the lanes of side 0, then those of side 1. */
static inline void groups_to_vec4s(plii_vec3x8 v, pli_vec4 records[2 * PLII_GROUP_LANES]) {
    plii_float8 rows[PLII_GROUP_LANES] = {v.x, v.y, v.z, groups_both(plii_float4_all(0.0f))};
    plii_float8_transpose4(rows);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_float4_to(&records[lane], plii_float8_low(rows[lane]));
        plii_float4_to(&records[lane + PLII_GROUP_LANES], plii_float8_high(rows[lane]));
    }
}

/* What the iterations did to the velocity of a cluster its nodes have still to follow. The motions of clusters that
   share nodes are averaged over those that were pushed, displacements by their number: none must not count. A rigid
   body is not displaced; Bullet gives it a velocity instead, and momentum from nothing. */
static void groups_finish(plii_contact_batches* groups) {
    for (PLII_EACH(const plii_contact_batch, group, groups->groups, groups->count)) {
        group_sums sums;
        groups_sum_up(groups, group, &sums);
        pli_vec4 linear[2 * PLII_GROUP_LANES], angular[2 * PLII_GROUP_LANES];
        pli_vec4 drift[2 * PLII_GROUP_LANES], angular_drift[2 * PLII_GROUP_LANES];
        groups_to_vec4s(sums.linear, linear);
        groups_to_vec4s(sums.angular, angular);
        groups_to_vec4s(sums.drift, drift);
        groups_to_vec4s(sums.angular_drift, angular_drift);
        for (int k = 0; k < 2 * PLII_GROUP_LANES; ++k) {
            const int lane = k % PLII_GROUP_LANES;
            plii_cluster* cluster = group->sides[k / PLII_GROUP_LANES].clusters[lane];
            if (cluster == NULL) { continue; }
            if (sums.pushed[lane] > 0.0f) {
                plii_cluster_impulse_add(&cluster->impulse, plii_xyz(linear[k]), plii_xyz(angular[k]), 1);
            }
            if (sums.drift_counts[lane] > 0.0f) {
                plii_cluster_impulse_add(&cluster->drift, plii_xyz(drift[k]), plii_xyz(angular_drift[k]),
                                         (int)sums.drift_counts[lane]);
            }
        }
    }
}
