/* Contacts as the iterations see them: how the normal and two tangents move their sides. Impulses are summed over the
   iterations, the sum along the normal pushes only, and friction is bounded by it (Catto, "Iterative dynamics with
   temporal coherence", 2005). A contact is a long chain of operations that waits for the one before, so pairs that have
   nothing movable in common are found first come, first served, and solved four at a time. */

#include "base/ranges.h"
#include "cluster/cluster_contacts_impl.h"

#define GROUPS_MAX_COUNT 7 /* of contacts of a pair; more are taken as another pair */
/* How much heavier than a cluster a rigid body must be to be in more than one lane. */
#define GROUPS_HEAVIER 16.0f

bool plii_contact_batches_start(pli_context* context, plii_contact_batches* groups, int rigid_count) {
    groups->count = groups->rigid_count = 0;
    groups->open_groups = 0;
    groups->keeps_momentum = false;
    memset(groups->open_counts, 0, sizeof groups->open_counts);
    groups->still[0] = groups->still[1] = (pli_vec4){0, 0, 0, 0};
    if (!PLII_RESERVE(context, &groups->rigids, &groups->rigid_capacity, rigid_count)) { return false; }
    groups->rigid_count = rigid_count;
    for (int i = 0; i < rigid_count; ++i) {
        groups->rigids[i].rigid = NULL;
    }
    return true;
}

static plii_group_rigid* groups_rigid(const plii_contact_batches* groups, const plii_joint_target* target) {
    return target->rigid != NULL ? &groups->rigids[target->rigid->world_index] : NULL;
}

/* Of what an impulse moves; NULL when it moves nothing. */
static uint64_t* groups_marks(const plii_contact_batches* groups, const plii_joint_target* target) {
    if (target->cluster != NULL) { return &target->cluster->open_groups; }
    if (target->rigid == NULL || target->rigid->state.inverse_mass == 0.0f) { return NULL; }
    return &groups_rigid(groups, target)->open_groups;
}

static void groups_close(plii_contact_batches* groups, int bit) {
    const plii_contact_batch* group = &groups->groups[groups->open[bit]];
    const uint64_t others = ~(UINT64_C(1) << bit);
    for (int lane = 0; lane < group->lane_count; ++lane) {
        for (int side = 0; side < 2; ++side) {
            uint64_t* marks = groups_marks(groups, &group->contacts[lane]->targets[side]);
            if (marks != NULL) { *marks &= others; }
        }
    }
    groups->open_groups &= others;
    groups->open_counts[group->block_count] &= others;
}

/* The bit of a group with room for the pair, or PLI_NULL_INDEX: first one whose pairs have as many contacts. */
static int groups_find_open(const plii_contact_batches* groups, uint64_t taken, int count) {
    for (int blocks = count; blocks <= GROUPS_MAX_COUNT; ++blocks) {
        const uint64_t fit = groups->open_counts[blocks] & ~taken;
        if (fit != 0) { return __builtin_ctzll(fit); }
    }
    return PLI_NULL_INDEX;
}

static int groups_open(pli_context* context, plii_contact_batches* groups, int count) {
    if (!PLII_GROW(context, &groups->groups, &groups->capacity, groups->count)) { return PLI_NULL_INDEX; }
    int bit = 0;
    if (groups->open_groups == UINT64_MAX) {
        /* The first to have been opened. */
        for (int i = 1; i < 64; ++i) {
            if (groups->open[i] < groups->open[bit]) { bit = i; }
        }
        groups_close(groups, bit);
    } else {
        bit = __builtin_ctzll(~groups->open_groups);
    }
    plii_contact_batch* group = &groups->groups[groups->count];
    memset(group->counts, 0, sizeof group->counts);
    group->lane_count = 0;
    group->block_count = count;
    groups->open[bit] = groups->count++;
    groups->open_groups |= UINT64_C(1) << bit;
    groups->open_counts[count] |= UINT64_C(1) << bit;
    return bit;
}

/* A rigid body may be in several lanes, each with a share of its mass, and moves as their mean (Tonge and others, "Mass
   splitting", 2012). Where the cluster is much lighter, that changes little. */
static bool groups_may_share(const plii_cluster_contact* contact) {
    const plii_cluster* cluster = contact->targets[0].cluster;
    const pli_rigid* rigid = contact->targets[1].rigid;
    return cluster != NULL && rigid != NULL && rigid->state.inverse_mass * GROUPS_HEAVIER <= cluster->inverse_mass;
}

static bool groups_add_pair(pli_context* context, plii_contact_batches* groups, const plii_cluster_contact* contacts,
                            int count) {
    plii_group_rigid* touched = groups_rigid(groups, &contacts->targets[1]);
    if (touched != NULL && touched->rigid == NULL) {
        *touched = (plii_group_rigid){.rigid = contacts->targets[1].rigid};
    }
    uint64_t* const marks[2] = {groups_marks(groups, &contacts->targets[0]),
                                groups_marks(groups, &contacts->targets[1])};
    uint64_t taken = marks[0] != NULL ? *marks[0] : 0;
    if (marks[1] != NULL && !groups_may_share(contacts)) { taken |= *marks[1]; }
    plii_cluster *cluster = contacts->targets[0].cluster, *other = contacts->targets[1].cluster;
    /* With rigid bodies impulses that nodes of several clusters get are averaged: what lies on them rests better. */
    if (cluster != NULL && other != NULL) {
        groups->keeps_momentum = cluster->keeps_momentum = other->keeps_momentum = true;
    }
    int bit = groups_find_open(groups, taken, count);
    if (bit == PLI_NULL_INDEX) { bit = groups_open(context, groups, count); }
    if (bit == PLI_NULL_INDEX) { return false; }
    plii_contact_batch* group = &groups->groups[groups->open[bit]];
    group->contacts[group->lane_count] = contacts;
    group->counts[group->lane_count++] = count;
    if (group->lane_count == PLII_LANES) {
        groups_close(groups, bit);
        return true;
    }
    for (int side = 0; side < 2; ++side) {
        if (marks[side] != NULL) { *marks[side] |= UINT64_C(1) << bit; }
    }
    return true;
}

bool plii_contact_batches_add(pli_context* context, plii_contact_batches* groups, const plii_cluster_contact* contacts,
                              int count) {
    for (int first = 0; first < count; first += GROUPS_MAX_COUNT) {
        const int rest = count - first;
        if (!groups_add_pair(context, groups, contacts + first, rest < GROUPS_MAX_COUNT ? rest : GROUPS_MAX_COUNT)) {
            return false;
        }
    }
    return true;
}

// -------------------------------------------------------------------------------------------------------------- lanes

static inline plii_vec3x4 groups_gather(pli_vec4* const records[PLII_LANES]) {
    return plii_vec3x4_of(plii_float4_from(records[0]), plii_float4_from(records[1]), plii_float4_from(records[2]),
                          plii_float4_from(records[3]));
}
static inline void groups_to_records(plii_vec3x4 v, plii_float4 records[PLII_LANES]) {
    records[0] = v.x;
    records[1] = v.y;
    records[2] = v.z;
    records[3] = plii_float4_all(0.0f);
    plii_float4_transpose(records);
}
static inline void groups_scatter(pli_vec4* const records[PLII_LANES], plii_vec3x4 v) {
    plii_float4 rows[PLII_LANES];
    groups_to_records(v, rows);
    PLII_UNROLL(4)
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        plii_float4_to(records[lane], rows[lane]);
    }
}
/* Each lane moves its record by its share. */
static inline void groups_scatter_shares(pli_vec4* const records[PLII_LANES], plii_vec3x4 before, plii_vec3x4 after,
                                         plii_float4 shares) {
    plii_float4 moves[PLII_LANES];
    groups_to_records(plii_vec3x4_scale(plii_vec3x4_sub(after, before), shares), moves);
    PLII_UNROLL(4)
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        plii_float4_to(records[lane], plii_float4_from(records[lane]) + moves[lane]);
    }
}
static inline plii_vec3x4 groups_from_vectors(const pli_vec3* const vectors[PLII_LANES]) {
    return plii_vec3x4_of(plii_lanes_from_vec3(vectors[0]), plii_lanes_from_vec3(vectors[1]),
                          plii_lanes_from_vec3(vectors[2]), plii_lanes_from_vec3(vectors[3]));
}

/* A sum of three vectors by impulses. */
static inline plii_vec3x4 groups_sum(const plii_vec3x4 directions[3], const plii_float4 impulses[3]) {
    return plii_vec3x4_add(
        plii_vec3x4_add(plii_vec3x4_scale(directions[0], impulses[0]), plii_vec3x4_scale(directions[1], impulses[1])),
        plii_vec3x4_scale(directions[2], impulses[2]));
}

/* Velocities of both sides. */
typedef struct group_motion {
    plii_vec3x4 linear[2], angular[2];
} group_motion;

/* Of side 0 against side 1, at the contact. */
static inline plii_vec3x4 groups_velocity_at(const group_motion* motion, const plii_vec3x4 arms[2]) {
    return plii_vec3x4_sub(plii_vec3x4_add(motion->linear[0], plii_vec3x4_cross(motion->angular[0], arms[0])),
                           plii_vec3x4_add(motion->linear[1], plii_vec3x4_cross(motion->angular[1], arms[1])));
}

// ------------------------------------------------------------------------------------------------------------ prepare

static const plii_cluster_contact groups_no_contact = {.normal = {0, 0, 1}};

static const pli_mat3 groups_no_inertia = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};

/* Returns the inverse inertia. */
static const pli_mat3* groups_load_target(plii_contact_batches* groups, const plii_joint_target* target, int lane,
                                          plii_group_side* side, plii_float4* inverse_masses) {
    side->clusters[lane] = target->cluster;
    side->linear[lane] = &groups->still[0];
    side->angular[lane] = &groups->still[1];
    (*inverse_masses)[lane] = 0.0f;
    side->splits[lane] = 1.0f;
    if (target->cluster != NULL) {
        side->linear[lane] = &target->cluster->linear_velocity;
        side->angular[lane] = &target->cluster->angular_velocity;
        (*inverse_masses)[lane] = target->cluster->inverse_mass;
        side->splits[lane] = target->cluster->split;
        return &target->cluster->inverse_inertia;
    }
    if (target->rigid == NULL) { return &groups_no_inertia; }
    plii_group_rigid* touched = &groups->rigids[target->rigid->world_index];
    side->linear[lane] = &touched->linear_velocity;
    side->angular[lane] = &touched->angular_velocity;
    if (target->rigid->state.inverse_mass == 0.0f) { return &groups_no_inertia; }
    (*inverse_masses)[lane] = target->rigid->state.inverse_mass;
    return &target->rigid->state.inverse_inertia_world;
}

/* How many lanes have the rigid body of each; 1 where they have none that moves. */
static plii_float4 groups_count_lanes(plii_contact_batch* group, plii_float4 inverse_masses) {
    const plii_group_side* side = &group->sides[1];
    plii_float4 counts;
    group->is_split = false;
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        counts[lane] = group->shares[lane] = 1.0f;
        if (side->clusters[lane] != NULL || inverse_masses[lane] == 0.0f) { continue; }
        int count = 0;
        for (int other = 0; other < PLII_LANES; ++other) {
            count += side->linear[other] == side->linear[lane] ? 1 : 0;
        }
        if (count == 1) { continue; }
        group->is_split = true;
        counts[lane] = (float)count;
        group->shares[lane] = 1.0f / (float)count;
    }
    return counts;
}

/* What the contacts of a group have in common while they are prepared. */
typedef struct group_terms {
    plii_float4 inverse_masses[2];
    plii_vec3x4 inertia[2][3];   /* rows of the inverse inertias */
    plii_vec3x4 angular_factors; /* of side 1, as plii_rigid_apply_impulse knows them, negative */
    group_motion motion; /* part of the depth: measured after this step's motion, which the impulses will change; of
                            rigid bodies 0 as yet, see other_speed */
    plii_float4 factors; /* of impulses between clusters of one body */
} group_terms;

static void groups_load_factors(plii_contact_batch* group, group_terms* terms) {
    static const pli_vec3 one = {1, 1, 1};
    const pli_vec3 *linear[PLII_LANES], *angular[PLII_LANES];
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        const pli_rigid* rigid = lane < group->lane_count ? group->contacts[lane]->targets[1].rigid : NULL;
        linear[lane] = rigid != NULL ? &rigid->linear_factor : &one;
        angular[lane] = rigid != NULL ? &rigid->angular_factor : &one;
    }
    const plii_float4 inverse_mass = terms->inverse_masses[0];
    terms->angular_factors = plii_vec3x4_neg(groups_from_vectors(angular));
    group->inverse_masses[0] = (plii_vec3x4){inverse_mass, inverse_mass, inverse_mass};
    group->inverse_masses[1] =
        plii_vec3x4_scale(plii_vec3x4_neg(groups_from_vectors(linear)), terms->inverse_masses[1]);
}

static group_terms groups_load_terms(plii_contact_batches* groups, plii_contact_batch* group) {
    plii_group_side *a = &group->sides[0], *b = &group->sides[1];
    const pli_mat3* inertias[2][PLII_LANES];
    group_terms terms;
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        const plii_cluster_contact* contact = lane < group->lane_count ? group->contacts[lane] : &groups_no_contact;
        inertias[0][lane] = groups_load_target(groups, &contact->targets[0], lane, a, &terms.inverse_masses[0]);
        inertias[1][lane] = groups_load_target(groups, &contact->targets[1], lane, b, &terms.inverse_masses[1]);
        terms.factors[lane] = contact->is_self ? a->clusters[lane]->settings.self_impulse_factor : 1.0f;
        group->limits[lane] = contact->is_self ? a->clusters[lane]->settings.max_self_impulse : INFINITY;
        group->frictions[lane] = contact->as.terms.w;
    }
    const plii_float4 splits[2] = {a->splits, groups_count_lanes(group, terms.inverse_masses[1]) * b->splits};
    terms.inverse_masses[0] *= splits[0];
    terms.inverse_masses[1] *= splits[1];
    for (int i = 0; i < 3; ++i) {
        const pli_vec3* rows[2][PLII_LANES];
        for (int lane = 0; lane < PLII_LANES; ++lane) {
            rows[0][lane] = &inertias[0][lane]->rows[i];
            rows[1][lane] = &inertias[1][lane]->rows[i];
        }
        terms.inertia[0][i] = plii_vec3x4_scale(groups_from_vectors(rows[0]), splits[0]);
        terms.inertia[1][i] = plii_vec3x4_scale(groups_from_vectors(rows[1]), splits[1]);
    }
    groups_load_factors(group, &terms);
    terms.motion = (group_motion){{groups_gather(a->linear), groups_gather(b->linear)},
                                  {groups_gather(a->angular), groups_gather(b->angular)}};
    return terms;
}

/* Unit vectors at right angles to a third and each other: Duff and others, "Building an orthonormal basis". */
static inline void groups_find_tangents(plii_vec3x4 n, plii_vec3x4 tangents[2]) {
    const plii_float4 one = plii_float4_all(1.0f), zero = plii_float4_all(0.0f);
    const plii_float4 sign = plii_lanes_select(n.z < zero, -one, one);
    const plii_float4 a = -one / (sign + n.z);
    const plii_float4 xa = n.x * a, b = xa * n.y;
    tangents[0] = (plii_vec3x4){one + sign * (xa * n.x), sign * b, -(sign * n.x)};
    tangents[1] = (plii_vec3x4){b, sign + n.y * n.y * a, -n.y};
}

/* That impulses meet along direction `k`; how they turn the sides goes to the block. */
static inline plii_float4 groups_load_direction(const group_terms* common, plii_contact_block* block, int k) {
    plii_float4 responses[2];
    PLII_UNROLL(2)
    for (int side = 0; side < 2; ++side) {
        const plii_vec3x4* inertia = common->inertia[side];
        const plii_vec3x4 moment = plii_vec3x4_cross(block->arms[side], block->directions[k]);
        const plii_vec3x4 rotation = {plii_vec3x4_dot(inertia[0], moment), plii_vec3x4_dot(inertia[1], moment),
                                      plii_vec3x4_dot(inertia[2], moment)};
        block->rotations[side][k] = side == 0 ? rotation : plii_vec3x4_mul(rotation, common->angular_factors);
        responses[side] = common->inverse_masses[side] + plii_vec3x4_dot(moment, rotation);
    }
    const plii_float4 response = responses[0] + responses[1];
    const plii_mask4 can_move = (plii_float4_all(FLT_MIN) < response) & plii_lanes_finite(response);
    return plii_lanes_select(can_move, plii_float4_all(1.0f) / response, plii_float4_all(0.0f));
}

static inline void groups_prepare_block(const plii_contact_batch* group, const group_terms* common,
                                        const plii_cluster_contact* const contacts[PLII_LANES],
                                        plii_contact_block* block) {
    const pli_vec3* const vectors[3][PLII_LANES] = {
        {&contacts[0]->normal, &contacts[1]->normal, &contacts[2]->normal, &contacts[3]->normal},
        {&contacts[0]->arms[0], &contacts[1]->arms[0], &contacts[2]->arms[0], &contacts[3]->arms[0]},
        {&contacts[0]->arms[1], &contacts[1]->arms[1], &contacts[2]->arms[1], &contacts[3]->arms[1]}};
    block->directions[0] = groups_from_vectors(vectors[0]);
    groups_find_tangents(block->directions[0], block->directions + 1);
    block->arms[0] = groups_from_vectors(vectors[1]);
    block->arms[1] = groups_from_vectors(vectors[2]);
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    plii_float4 masses[3];
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        masses[k] = groups_load_direction(common, block, k);
        block->masses[k] = masses[k] * common->factors;
        block->impulses[k] = zero;
    }

    const plii_vec3x4 terms =
        plii_vec3x4_of(plii_float4_from(&contacts[0]->as.terms), plii_float4_from(&contacts[1]->as.terms),
                       plii_float4_from(&contacts[2]->as.terms), plii_float4_from(&contacts[3]->as.terms));
    const plii_float4 recovery = terms.x, hardness = terms.y, split = terms.z;
    const plii_vec3x4 velocity = groups_velocity_at(&common->motion, block->arms);
    const plii_float4 others = plii_lanes_xyzw(contacts[0]->other_speed, contacts[1]->other_speed,
                                               contacts[2]->other_speed, contacts[3]->other_speed);
    const plii_float4 included = plii_lanes_min(plii_vec3x4_dot(velocity, block->directions[0]) - others, zero);
    const plii_float4 speed_out = recovery + included;
    /* Not there yet: slow enough not to get deeper. */
    const plii_mask4 is_deep = zero < speed_out;
    const plii_float4 corrected = speed_out * hardness;
    const plii_float4 wanted = corrected * (one - split);
    block->wanted_speeds = plii_lanes_select(is_deep, wanted, speed_out);
    const plii_float4 drift = corrected * split * masses[0];
    const plii_float4 limited = plii_lanes_min(drift, group->limits) * common->factors;
    block->drifts = plii_lanes_select(is_deep, limited, zero);
}

enum { GROUPS_PREPARE_NS = 300 }; /* of a group */

static void groups_prepare_range(int begin, int end, void* data) {
    plii_contact_batches* groups = data;
    for (PLII_EACH(plii_contact_batch, group, &groups->groups[begin], end - begin)) {
        const group_terms common = groups_load_terms(groups, group);
        for (int k = 0; k < group->block_count; ++k) {
            const plii_cluster_contact* contacts[PLII_LANES];
            for (int lane = 0; lane < PLII_LANES; ++lane) {
                contacts[lane] = k < group->counts[lane] ? &group->contacts[lane][k] : &groups_no_contact;
            }
            plii_contact_block* block = &groups->blocks[group->first_block + k];
            groups_prepare_block(group, &common, contacts, block);
            for (int lane = 0; lane < PLII_LANES; ++lane) {
                if (k < group->counts[lane]) { continue; }
                block->masses[0][lane] = block->masses[1][lane] = block->masses[2][lane] = block->drifts[lane] = 0.0f;
            }
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- solve

/* Friction as far as the normal impulse allows. What slides is hard to foresee: a branch costs more than the root. */
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
    const plii_vec3x4* directions = block->directions;
    const plii_vec3x4 velocity = groups_velocity_at(motion, block->arms);
    const plii_float4 missing[3] = {block->wanted_speeds - plii_vec3x4_dot(directions[0], velocity),
                                    -plii_vec3x4_dot(directions[1], velocity),
                                    -plii_vec3x4_dot(directions[2], velocity)};
    const plii_float4 zero = plii_float4_all(0.0f);
    plii_float4 before[3], after[3], changes[3];
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        before[k] = block->impulses[k];
        after[k] = before[k] + missing[k] * block->masses[k];
    }
    after[0] = plii_lanes_min(plii_lanes_max(after[0], zero), group->limits);
    /* Nothing pushed and nothing does: a quarter of all, of which the next one need not wait for the result. */
    if (plii_lanes_bits(zero < plii_lanes_max(before[0], after[0])) == 0) { return; }
    groups_bound_friction(group->frictions, after);
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        block->impulses[k] = after[k];
        changes[k] = after[k] - before[k];
    }
    const plii_vec3x4 push = groups_sum(directions, changes);
    PLII_UNROLL(2)
    for (int side = 0; side < 2; ++side) {
        plii_vec3x4 *linear = &motion->linear[side], *angular = &motion->angular[side];
        *linear = plii_vec3x4_add(*linear, plii_vec3x4_mul(push, group->inverse_masses[side]));
        *angular = plii_vec3x4_add(*angular, groups_sum(block->rotations[side], changes));
    }
}

static void groups_solve(plii_contact_batches* groups) {
    for (PLII_EACH(const plii_contact_batch, group, groups->groups, groups->count)) {
        const plii_group_side *a = &group->sides[0], *b = &group->sides[1];
        group_motion motion = {{groups_gather(a->linear), groups_gather(b->linear)},
                               {groups_gather(a->angular), groups_gather(b->angular)}};
        const group_motion before = motion;
        plii_contact_block* end = groups->blocks + group->first_block + group->block_count;
        for (plii_contact_block* block = end - group->block_count; block < end; ++block) {
            groups_solve_block(group, block, &motion);
        }
        groups_scatter(a->linear, motion.linear[0]);
        groups_scatter(a->angular, motion.angular[0]);
        if (group->is_split) {
            groups_scatter_shares(b->linear, before.linear[1], motion.linear[1], group->shares);
            groups_scatter_shares(b->angular, before.angular[1], motion.angular[1], group->shares);
        } else {
            groups_scatter(b->linear, motion.linear[1]);
            groups_scatter(b->angular, motion.angular[1]);
        }
    }
}

bool plii_contact_batches_prepare(pli_context* context, plii_contact_batches* groups) {
    while (groups->open_groups != 0) {
        groups_close(groups, __builtin_ctzll(groups->open_groups));
    }
    int block_count = 0;
    for (int i = 0; i < groups->count; ++i) {
        groups->groups[i].first_block = block_count;
        block_count += groups->groups[i].block_count;
    }
    if (!PLII_RESERVE(context, &groups->blocks, &groups->block_capacity, block_count)) {
        groups->count = 0;
        return false;
    }
    plii_parallel_for(context, groups_prepare_range, groups, groups->count, plii_grain(GROUPS_PREPARE_NS));
    return true;
}

void plii_contact_batches_solve(plii_contact_batches* groups) {
    if (groups->count == 0) { return; }
    for (PLII_EACH(plii_group_rigid, touched, groups->rigids, groups->rigid_count)) {
        if (touched->rigid == NULL) { continue; }
        /* Joints may have moved them. w stays 0. */
        plii_set_xyz(&touched->linear_velocity, touched->rigid->state.linear_velocity);
        plii_set_xyz(&touched->angular_velocity, touched->rigid->state.angular_velocity);
    }
    groups_solve(groups);
    for (PLII_EACH(const plii_group_rigid, touched, groups->rigids, groups->rigid_count)) {
        if (touched->rigid == NULL || touched->rigid->state.inverse_mass == 0.0f) { continue; }
        touched->rigid->state.linear_velocity = plii_xyz(touched->linear_velocity);
        touched->rigid->state.angular_velocity = plii_xyz(touched->angular_velocity);
    }
}

/* Four contacts to a block, in some disorder. */
bool plii_contact_batches_reserve(pli_context* context, plii_contact_batches* groups, int contacts) {
    return PLII_RESERVE(context, &groups->groups, &groups->capacity, contacts / 4 + 1) &&
           PLII_RESERVE(context, &groups->blocks, &groups->block_capacity, contacts / 2 + 1);
}

// ------------------------------------------------------------------------------------------------------------- finish

/* What the contacts of each lane have done. */
typedef struct group_sums {
    group_motion velocities, drifts; /* these are displacements, over the step */
    plii_float4 pushed;              /* > 0 where any impulse is not 0 */
    plii_float4 drift_counts;
} group_sums;

static inline group_sums groups_sum_up(const plii_contact_batches* groups, const plii_contact_batch* group) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_vec3x4 nothing = {zero, zero, zero};
    const group_motion still = {{nothing, nothing}, {nothing, nothing}};
    group_sums sums = {still, still, zero, zero};
    plii_vec3x4 pushes = nothing, drifts = nothing;
    for (int i = 0; i < group->block_count; ++i) {
        const plii_contact_block* block = &groups->blocks[group->first_block + i];
        pushes = plii_vec3x4_add(pushes, groups_sum(block->directions, block->impulses));
        drifts = plii_vec3x4_add(drifts, plii_vec3x4_scale(block->directions[0], block->drifts));
        PLII_UNROLL(2)
        for (int side = 0; side < 2; ++side) {
            plii_vec3x4 *angular = &sums.velocities.angular[side], *drift = &sums.drifts.angular[side];
            *angular = plii_vec3x4_add(*angular, groups_sum(block->rotations[side], block->impulses));
            *drift = plii_vec3x4_add(*drift, plii_vec3x4_scale(block->rotations[side][0], block->drifts));
        }
        /* Friction has no impulse without the normal. */
        sums.pushed = plii_lanes_max(sums.pushed, block->impulses[0]);
        sums.drift_counts += plii_lanes_select(zero < block->drifts, one, zero);
    }
    PLII_UNROLL(2)
    for (int side = 0; side < 2; ++side) {
        sums.velocities.linear[side] = plii_vec3x4_mul(pushes, group->inverse_masses[side]);
        sums.drifts.linear[side] = plii_vec3x4_mul(drifts, group->inverse_masses[side]);
    }
    return sums;
}

/* Adds the motion of a side to sums of its clusters, where `counts` is above 0: so many, or each as one. */
static void groups_hand_on(const plii_group_side* side, plii_vec3x4 linear, plii_vec3x4 angular, plii_float4 counts,
                           bool is_drift) {
    plii_float4 linears[PLII_LANES], angulars[PLII_LANES];
    groups_to_records(linear, linears);
    groups_to_records(angular, angulars);
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        plii_cluster* cluster = side->clusters[lane];
        if (cluster == NULL || !(counts[lane] > 0.0f)) { continue; }
        const float own = is_drift ? 1.0f : 1.0f / cluster->split;
        plii_cluster_impulse_add(is_drift ? &cluster->drift : &cluster->impulse, plii_lanes_vec3(linears[lane] * own),
                                 plii_lanes_vec3(angulars[lane] * own), is_drift ? (int)counts[lane] : 1);
    }
}

/* What the iterations did to the velocity of a cluster its nodes have still to follow. The motions of clusters that
   share nodes are averaged over those that were pushed, displacements by their number: none must not count. A rigid
   body is not displaced; Bullet gives it a velocity instead, and momentum from nothing. */
void plii_contact_batches_finish(plii_contact_batches* groups) {
    for (PLII_EACH(const plii_contact_batch, group, groups->groups, groups->count)) {
        const group_sums sums = groups_sum_up(groups, group);
        for (int i = 0; i < 2; ++i) {
            const plii_group_side* side = &group->sides[i];
            groups_hand_on(side, sums.velocities.linear[i], sums.velocities.angular[i], sums.pushed, false);
            groups_hand_on(side, sums.drifts.linear[i], sums.drifts.angular[i], sums.drift_counts, true);
        }
    }
    groups->count = 0;
}
