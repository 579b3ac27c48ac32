/* Contacts as the iterations see them: how the normal and two tangents move their sides. Impulses are summed over the
   iterations, the sum along the normal pushes only, and friction is bounded by it (Catto, "Iterative dynamics with
   temporal coherence", 2005). A contact is a long chain of operations that waits for the one before, so pairs that have
   nothing movable in common are found first come, first served, and solved four at a time. */

#include "lanes.h"

#include "cluster_contacts_impl.h"

#define GROUPS_MAX_COUNT 7 /* of contacts of a pair; more are taken as another pair */
/* How much heavier than a cluster a rigid body must be to be in more than one lane. */
#define GROUPS_HEAVIER 16.0f

// ----------------------------------------------------------------------------------------------------------- grouping

bool plii_contact_groups_start(pli_context* context, plii_contact_groups* groups, int rigid_count) {
    groups->count = groups->block_count = groups->rigid_count = 0;
    groups->open_groups = 0;
    for (int i = 0; i < 8; ++i) {
        groups->open_counts[i] = 0;
    }
    groups->still[0] = groups->still[1] = (pli_vec4){0, 0, 0, 0};
    if (!PLII_RESERVE(context, &groups->rigids, &groups->rigid_capacity, rigid_count)) { return false; }
    groups->rigid_count = rigid_count;
    for (int i = 0; i < rigid_count; ++i) {
        groups->rigids[i].rigid = NULL;
    }
    return true;
}

static plii_group_rigid* groups_rigid(const plii_contact_groups* groups, const plii_joint_target* target) {
    return target->rigid != NULL ? &groups->rigids[target->rigid->world_index] : NULL;
}

/* Of what an impulse moves; NULL when it moves nothing. */
static uint64_t* groups_marks(const plii_contact_groups* groups, const plii_joint_target* target) {
    if (target->cluster != NULL) { return &target->cluster->open_groups; }
    if (target->rigid == NULL || target->rigid->state.inverse_mass == 0.0f) { return NULL; }
    return &groups_rigid(groups, target)->open_groups;
}

/* By what a De Bruijn sequence has at its top once the bit has moved it (Leiserson, Prokop, Randall, "Using de Bruijn
   sequences to index a 1 in a computer word", 1998). */
static int groups_lowest_bit(uint64_t bits) {
    static const uint8_t places[64] = {0,  1,  48, 2,  57, 49, 28, 3,  61, 58, 50, 42, 38, 29, 17, 4,
                                       62, 55, 59, 36, 53, 51, 43, 22, 45, 39, 33, 30, 24, 18, 12, 5,
                                       63, 47, 56, 27, 60, 41, 37, 16, 54, 35, 52, 21, 44, 32, 23, 11,
                                       46, 26, 40, 15, 34, 20, 31, 10, 25, 14, 19, 9,  13, 8,  7,  6};
    return places[((bits & (~bits + 1)) * UINT64_C(0x03f79d71b4cb0a89)) >> 58];
}

static void groups_close(plii_contact_groups* groups, int place) {
    const plii_contact_group* group = &groups->groups[groups->open[place]];
    const uint64_t others = ~(UINT64_C(1) << place);
    for (int lane = 0; lane < group->lane_count; ++lane) {
        for (int side = 0; side < 2; ++side) {
            uint64_t* marks = groups_marks(groups, &group->contacts[lane]->targets[side]);
            if (marks != NULL) { *marks &= others; }
        }
    }
    groups->open_groups &= others;
    groups->open_counts[group->block_count] &= others;
}

/* The bit of a group that takes the pair, or PLI_NULL_INDEX: first one whose pairs have as many contacts. */
static int groups_find_open(const plii_contact_groups* groups, uint64_t taken, int count) {
    for (int blocks = count; blocks <= GROUPS_MAX_COUNT; ++blocks) {
        const uint64_t fit = groups->open_counts[blocks] & ~taken;
        if (fit != 0) { return groups_lowest_bit(fit); }
    }
    return PLI_NULL_INDEX;
}

static int groups_open(pli_context* context, plii_contact_groups* groups, int count) {
    if (!PLII_RESERVE(context, &groups->groups, &groups->capacity, groups->count + 1)) { return PLI_NULL_INDEX; }
    int place = 0;
    if (groups->open_groups == UINT64_MAX) {
        /* The first to have been opened. */
        for (int i = 1; i < 64; ++i) {
            if (groups->open[i] < groups->open[place]) { place = i; }
        }
        groups_close(groups, place);
    } else {
        place = groups_lowest_bit(~groups->open_groups);
    }
    plii_contact_group* group = &groups->groups[groups->count];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        group->counts[lane] = 0;
    }
    group->lane_count = 0;
    group->block_count = count;
    groups->open[place] = groups->count++;
    groups->open_groups |= UINT64_C(1) << place;
    groups->open_counts[count] |= UINT64_C(1) << place;
    return place;
}

static void groups_meet_rigid(plii_contact_groups* groups, const plii_joint_target* target) {
    plii_group_rigid* met = groups_rigid(groups, target);
    if (met == NULL || met->rigid != NULL) { return; }
    met->rigid = target->rigid;
    met->open_groups = 0;
}

/* A rigid body may be in several lanes, each of which then has a share of its mass, and moves as their mean (Tonge,
   Benevolenski, Voroshilov, "Mass splitting for jitter-free parallel rigid body simulation", 2012). Where the cluster
   is much lighter, that changes little for it. */
static bool groups_may_share(const plii_cluster_contact* contact) {
    const plii_cluster* cluster = contact->targets[0].cluster;
    const pli_rigid* rigid = contact->targets[1].rigid;
    return cluster != NULL && rigid != NULL && rigid->state.inverse_mass * GROUPS_HEAVIER <= cluster->inverse_mass;
}

static bool groups_add_pair(pli_context* context, plii_contact_groups* groups, const plii_cluster_contact* contacts,
                            int count) {
    groups_meet_rigid(groups, &contacts->targets[1]);
    uint64_t* const marks[2] = {groups_marks(groups, &contacts->targets[0]),
                                groups_marks(groups, &contacts->targets[1])};
    uint64_t taken = marks[0] != NULL ? *marks[0] : 0;
    if (marks[1] != NULL && !groups_may_share(contacts)) { taken |= *marks[1]; }
    int place = groups_find_open(groups, taken, count);
    if (place == PLI_NULL_INDEX) { place = groups_open(context, groups, count); }
    if (place == PLI_NULL_INDEX) { return false; }
    plii_contact_group* group = &groups->groups[groups->open[place]];
    group->contacts[group->lane_count] = contacts;
    group->counts[group->lane_count++] = count;
    if (group->lane_count == PLII_GROUP_LANES) {
        groups_close(groups, place);
        return true;
    }
    for (int side = 0; side < 2; ++side) {
        if (marks[side] != NULL) { *marks[side] |= UINT64_C(1) << place; }
    }
    return true;
}

bool plii_contact_groups_add(pli_context* context, plii_contact_groups* groups, const plii_cluster_contact* contacts,
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

static inline plii_vec3x4 groups_load(const plii_group_vec3* v) {
    return (plii_vec3x4){plii_float4_load(v->x), plii_float4_load(v->y), plii_float4_load(v->z)};
}
static inline void groups_store(plii_group_vec3* target, plii_vec3x4 v) {
    plii_float4_store(target->x, v.x);
    plii_float4_store(target->y, v.y);
    plii_float4_store(target->z, v.z);
}
static inline plii_vec3x4 groups_mul(plii_vec3x4 a, plii_vec3x4 b) {
    return (plii_vec3x4){plii_float4_mul(a.x, b.x), plii_float4_mul(a.y, b.y), plii_float4_mul(a.z, b.z)};
}

static inline plii_vec3x4 groups_gather(pli_vec4* const records[PLII_GROUP_LANES]) {
    plii_float4 rows[4] = {plii_float4_from(records[0]), plii_float4_from(records[1]), plii_float4_from(records[2]),
                           plii_float4_from(records[3])};
    plii_float4_turn(rows);
    return (plii_vec3x4){rows[0], rows[1], rows[2]};
}
static inline void groups_scatter(pli_vec4* const records[PLII_GROUP_LANES], plii_vec3x4 v) {
    plii_float4 rows[4] = {v.x, v.y, v.z, plii_float4_all(0.0f)};
    plii_float4_turn(rows);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_float4_to(records[lane], rows[lane]);
    }
}
/* Each lane moves its record by its share. */
static void groups_scatter_shares(pli_vec4* const records[PLII_GROUP_LANES], plii_vec3x4 before, plii_vec3x4 after,
                                  plii_float4 shares) {
    const plii_vec3x4 change = plii_vec3x4_scale(plii_vec3x4_sub(after, before), shares);
    plii_float4 rows[4] = {change.x, change.y, change.z, plii_float4_all(0.0f)};
    plii_float4_turn(rows);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_float4_to(records[lane], plii_float4_add(plii_float4_from(records[lane]), rows[lane]));
    }
}
static inline plii_vec3x4 groups_from_vectors(const pli_vec3* const vectors[PLII_GROUP_LANES]) {
    plii_float4 rows[4] = {plii_lanes_from_vec3(vectors[0]), plii_lanes_from_vec3(vectors[1]),
                           plii_lanes_from_vec3(vectors[2]), plii_lanes_from_vec3(vectors[3])};
    plii_float4_turn(rows);
    return (plii_vec3x4){rows[0], rows[1], rows[2]};
}

static inline plii_vec3x4 groups_turn(const plii_group_vec3 inverse_inertia[3], plii_vec3x4 moment) {
    return (plii_vec3x4){plii_vec3x4_dot(groups_load(&inverse_inertia[0]), moment),
                         plii_vec3x4_dot(groups_load(&inverse_inertia[1]), moment),
                         plii_vec3x4_dot(groups_load(&inverse_inertia[2]), moment)};
}

// ------------------------------------------------------------------------------------------------------------ prepare

static const plii_cluster_contact groups_no_contact = {.normal = {0, 0, 1}};

static const pli_mat3 groups_no_inertia = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};

/* Returns the inverse inertia. */
static const pli_mat3* groups_take_target(plii_contact_groups* groups, const plii_joint_target* target, int lane,
                                          plii_group_side* side) {
    side->clusters[lane] = target->cluster;
    side->linear[lane] = &groups->still[0];
    side->angular[lane] = &groups->still[1];
    side->inverse_masses[lane] = 0.0f;
    if (target->cluster != NULL) {
        side->linear[lane] = &target->cluster->linear_velocity;
        side->angular[lane] = &target->cluster->angular_velocity;
        side->inverse_masses[lane] = target->cluster->inverse_mass;
        return &target->cluster->inverse_inertia;
    }
    if (target->rigid == NULL) { return &groups_no_inertia; }
    plii_group_rigid* met = groups_rigid(groups, target);
    side->linear[lane] = &met->linear_velocity;
    side->angular[lane] = &met->angular_velocity;
    if (target->rigid->state.inverse_mass == 0.0f) { return &groups_no_inertia; }
    side->inverse_masses[lane] = target->rigid->state.inverse_mass;
    return &target->rigid->state.inverse_inertia_world;
}

static void groups_take_side(plii_contact_groups* groups, const plii_contact_group* group, int which,
                             plii_group_side* side) {
    const pli_mat3* inertias[PLII_GROUP_LANES];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        const plii_cluster_contact* contact = lane < group->lane_count ? group->contacts[lane] : &groups_no_contact;
        inertias[lane] = groups_take_target(groups, &contact->targets[which], lane, side);
    }
    for (int i = 0; i < 3; ++i) {
        const pli_vec3* const rows[PLII_GROUP_LANES] = {&inertias[0]->rows[i], &inertias[1]->rows[i],
                                                        &inertias[2]->rows[i], &inertias[3]->rows[i]};
        groups_store(&side->inverse_inertia[i], groups_from_vectors(rows));
    }
}

/* plii_rigid_apply_impulse knows factors. */
static void groups_take_factors(plii_contact_group* group) {
    static const pli_vec3 one = {1, 1, 1};
    const pli_vec3 *linear[PLII_GROUP_LANES], *angular[PLII_GROUP_LANES];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        const pli_rigid* rigid = lane < group->lane_count ? group->contacts[lane]->targets[1].rigid : NULL;
        linear[lane] = rigid != NULL ? &rigid->linear_factor : &one;
        angular[lane] = rigid != NULL ? &rigid->angular_factor : &one;
    }
    groups_store(&group->linear_factors, groups_from_vectors(linear));
    const plii_vec3x4 factors = groups_from_vectors(angular);
    plii_group_vec3* rows = group->sides[1].inverse_inertia;
    groups_store(&rows[0], plii_vec3x4_scale(groups_load(&rows[0]), factors.x));
    groups_store(&rows[1], plii_vec3x4_scale(groups_load(&rows[1]), factors.y));
    groups_store(&rows[2], plii_vec3x4_scale(groups_load(&rows[2]), factors.z));
}

/* How many lanes have the rigid body of each. */
static void groups_split_rigids(plii_contact_group* group) {
    plii_group_side* side = &group->sides[1];
    group->is_split = false;
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        group->shares[lane] = 1.0f;
        if (side->clusters[lane] != NULL || side->inverse_masses[lane] == 0.0f) { continue; }
        int count = 0;
        for (int other = 0; other < PLII_GROUP_LANES; ++other) {
            count += side->linear[other] == side->linear[lane] ? 1 : 0;
        }
        if (count == 1) { continue; }
        group->is_split = true;
        group->shares[lane] = 1.0f / (float)count;
    }
    if (!group->is_split) { return; }
    const plii_float4 shares = plii_float4_load(group->shares);
    plii_float4_store(side->inverse_masses, plii_float4_div(plii_float4_load(side->inverse_masses), shares));
    for (int i = 0; i < 3; ++i) {
        const plii_vec3x4 row = groups_load(&side->inverse_inertia[i]);
        groups_store(&side->inverse_inertia[i],
                     (plii_vec3x4){plii_float4_div(row.x, shares), plii_float4_div(row.y, shares),
                                   plii_float4_div(row.z, shares)});
    }
}

/* Velocity along a direction per unit of impulse along it, 1/kg. */
static inline plii_float4 groups_response(const plii_group_side* side, plii_vec3x4 arm, plii_vec3x4 direction) {
    const plii_vec3x4 moment = plii_vec3x4_cross(arm, direction);
    return plii_float4_add(plii_float4_load(side->inverse_masses),
                           plii_vec3x4_dot(moment, groups_turn(side->inverse_inertia, moment)));
}

static inline plii_float4 groups_mass(const plii_contact_group* group, const plii_vec3x4 arms[2],
                                      plii_vec3x4 direction) {
    const plii_float4 response = plii_float4_add(groups_response(&group->sides[0], arms[0], direction),
                                                 groups_response(&group->sides[1], arms[1], direction));
    const plii_mask4 can_move =
        plii_lanes_both(plii_lanes_less(plii_float4_all(FLT_MIN), response), plii_lanes_finite(response));
    return plii_lanes_select(can_move, plii_float4_div(plii_float4_all(1.0f), response), plii_float4_all(0.0f));
}

/* Two unit vectors at right angles to a third and to each other (Duff and others, "Building an orthonormal basis,
   revisited", 2017). */
static inline void groups_find_tangents(plii_vec3x4 n, plii_vec3x4 tangents[2]) {
    const plii_float4 one = plii_float4_all(1.0f), zero = plii_float4_all(0.0f);
    const plii_float4 sign = plii_lanes_select(plii_lanes_less(n.z, zero), plii_float4_negate(one), one);
    const plii_float4 a = plii_float4_div(plii_float4_negate(one), plii_float4_add(sign, n.z));
    const plii_float4 xa = plii_float4_mul(n.x, a), b = plii_float4_mul(xa, n.y);
    tangents[0] = (plii_vec3x4){plii_float4_add(one, plii_float4_mul(sign, plii_float4_mul(xa, n.x))),
                                plii_float4_mul(sign, b), plii_float4_negate(plii_float4_mul(sign, n.x))};
    tangents[1] =
        (plii_vec3x4){b, plii_float4_add(sign, plii_float4_mul(plii_float4_mul(n.y, n.y), a)), plii_float4_negate(n.y)};
}

static inline plii_vec3x4 groups_velocity_at(plii_vec3x4 linear, plii_vec3x4 angular, plii_vec3x4 arm) {
    return plii_vec3x4_add(linear, plii_vec3x4_cross(angular, arm));
}

/* What the contacts of a group have in common while they are prepared. */
typedef struct group_terms {
    float inverse_dt;
    plii_vec3x4 linear[2], angular[2]; /* velocities that are part of the depth: it was measured after this step's
                                          motion, which the impulses will change; but rigid bodies have not moved yet */
    plii_float4 factors, limits;       /* of impulses between clusters of one body */
} group_terms;

static group_terms groups_take_terms(const plii_contact_group* group, const plii_step* step) {
    float included[PLII_GROUP_LANES], factors[PLII_GROUP_LANES], limits[PLII_GROUP_LANES];
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        included[lane] = group->sides[1].clusters[lane] != NULL ? 1.0f : 0.0f;
        factors[lane] = 1.0f;
        limits[lane] = INFINITY;
        if (lane < group->lane_count && group->contacts[lane]->is_self) {
            factors[lane] = group->sides[0].clusters[lane]->settings.self_impulse_factor;
            limits[lane] = group->sides[0].clusters[lane]->settings.max_self_impulse;
        }
    }
    const plii_group_side *a = &group->sides[0], *b = &group->sides[1];
    const plii_float4 share = plii_float4_load(included);
    return (group_terms){
        step->inverse_dt,
        {groups_gather(a->linear), plii_vec3x4_scale(groups_gather(b->linear), share)},
        {groups_gather(a->angular), plii_vec3x4_scale(groups_gather(b->angular), share)},
        plii_float4_load(factors),
        plii_float4_load(limits),
    };
}

static void groups_prepare_block(const plii_contact_group* group, const group_terms* common,
                                 const plii_cluster_contact* const contacts[PLII_GROUP_LANES],
                                 plii_contact_block* block) {
    const pli_vec3* const vectors[3][PLII_GROUP_LANES] = {
        {&contacts[0]->normal, &contacts[1]->normal, &contacts[2]->normal, &contacts[3]->normal},
        {&contacts[0]->arms[0], &contacts[1]->arms[0], &contacts[2]->arms[0], &contacts[3]->arms[0]},
        {&contacts[0]->arms[1], &contacts[1]->arms[1], &contacts[2]->arms[1], &contacts[3]->arms[1]}};
    plii_vec3x4 directions[3] = {groups_from_vectors(vectors[0])};
    groups_find_tangents(directions[0], directions + 1);
    const plii_vec3x4 arms[2] = {groups_from_vectors(vectors[1]), groups_from_vectors(vectors[2])};
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    plii_float4 masses[3];
    for (int k = 0; k < 3; ++k) {
        masses[k] = groups_mass(group, arms, directions[k]);
        groups_store(&block->directions[k], directions[k]);
        plii_float4_store(block->masses[k], plii_float4_mul(masses[k], common->factors));
        plii_float4_store(block->impulses[k], zero);
    }
    groups_store(&block->arms[0], arms[0]);
    groups_store(&block->arms[1], arms[1]);

    plii_float4 terms[4] = {plii_float4_from(&contacts[0]->as.own.terms), plii_float4_from(&contacts[1]->as.own.terms),
                            plii_float4_from(&contacts[2]->as.own.terms), plii_float4_from(&contacts[3]->as.own.terms)};
    plii_float4_turn(terms);
    const plii_float4 depth = terms[0], hardness = terms[1], split = terms[2];
    plii_float4_store(block->frictions, terms[3]);
    plii_float4_store(block->limits, common->limits);
    const plii_vec3x4 velocity = plii_vec3x4_sub(groups_velocity_at(common->linear[0], common->angular[0], arms[0]),
                                                 groups_velocity_at(common->linear[1], common->angular[1], arms[1]));
    const plii_float4 included = plii_lanes_min(plii_vec3x4_dot(velocity, directions[0]), zero);
    const plii_float4 speed_out =
        plii_float4_add(plii_float4_mul(depth, plii_float4_all(common->inverse_dt)), included);
    /* Not there yet: slow enough not to get deeper. */
    const plii_mask4 is_deep = plii_lanes_less(zero, speed_out);
    const plii_float4 corrected = plii_float4_mul(speed_out, hardness);
    const plii_float4 wanted = plii_float4_mul(corrected, plii_float4_sub(one, split));
    plii_float4_store(block->wanted_speeds, plii_lanes_select(is_deep, wanted, speed_out));
    const plii_float4 drift = plii_float4_mul(plii_float4_mul(corrected, split), masses[0]);
    const plii_float4 limited = plii_float4_mul(plii_lanes_min(drift, common->limits), common->factors);
    plii_float4_store(block->drifts, plii_lanes_select(is_deep, limited, zero));
}

static void groups_prepare_group(plii_contact_groups* groups, plii_contact_group* group, const plii_step* step) {
    groups_take_side(groups, group, 0, &group->sides[0]);
    groups_take_side(groups, group, 1, &group->sides[1]);
    groups_split_rigids(group);
    const group_terms common = groups_take_terms(group, step);
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
    groups_take_factors(group);
}

static void groups_read_rigids(plii_contact_groups* groups) {
    for (int i = 0; i < groups->rigid_count; ++i) {
        plii_group_rigid* met = &groups->rigids[i];
        if (met->rigid == NULL) { continue; }
        plii_float4_to(&met->linear_velocity, plii_lanes_from_vec3(&met->rigid->state.linear_velocity));
        plii_float4_to(&met->angular_velocity, plii_lanes_from_vec3(&met->rigid->state.angular_velocity));
    }
}

bool plii_contact_groups_prepare(pli_context* context, plii_contact_groups* groups, const plii_step* step) {
    while (groups->open_groups != 0) {
        groups_close(groups, groups_lowest_bit(groups->open_groups));
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
    groups->block_count = block_count;
    groups_read_rigids(groups);
    for (int i = 0; i < groups->count; ++i) {
        groups_prepare_group(groups, &groups->groups[i], step);
    }
    return true;
}

// -------------------------------------------------------------------------------------------------------------- solve

/* Velocities of a side while its contacts are solved. */
typedef struct group_motion {
    plii_vec3x4 linear, angular;
} group_motion;

static inline plii_vec3x4 groups_sum(const plii_vec3x4 directions[3], const plii_float4 impulses[3]) {
    return plii_vec3x4_add(
        plii_vec3x4_add(plii_vec3x4_scale(directions[0], impulses[0]), plii_vec3x4_scale(directions[1], impulses[1])),
        plii_vec3x4_scale(directions[2], impulses[2]));
}

/* The new impulses along the directions; what they were goes to `before`. */
static inline void groups_find_impulses(const plii_contact_block* block, const plii_vec3x4 directions[3],
                                        plii_vec3x4 velocity, plii_float4 before[3], plii_float4 after[3]) {
    plii_float4 missing[3] = {
        plii_float4_sub(plii_float4_load(block->wanted_speeds), plii_vec3x4_dot(directions[0], velocity)),
        plii_float4_negate(plii_vec3x4_dot(directions[1], velocity)),
        plii_float4_negate(plii_vec3x4_dot(directions[2], velocity))};
    for (int k = 0; k < 3; ++k) {
        before[k] = plii_float4_load(block->impulses[k]);
        after[k] = plii_float4_add(before[k], plii_float4_mul(missing[k], plii_float4_load(block->masses[k])));
    }
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    after[0] = plii_lanes_min(plii_lanes_max(after[0], zero), plii_float4_load(block->limits));
    const plii_float4 bound = plii_float4_mul(plii_float4_load(block->frictions), after[0]);
    const plii_float4 squared =
        plii_float4_add(plii_float4_mul(after[1], after[1]), plii_float4_mul(after[2], after[2]));
    const plii_mask4 slides = plii_lanes_less(plii_float4_mul(bound, bound), squared);
    const plii_float4 scale = plii_lanes_select(slides, plii_float4_div(bound, plii_float4_sqrt(squared)), one);
    after[1] = plii_float4_mul(after[1], scale);
    after[2] = plii_float4_mul(after[2], scale);
}

static void groups_solve_block(const plii_contact_group* group, plii_contact_block* block, group_motion motions[2]) {
    const plii_vec3x4 directions[3] = {groups_load(&block->directions[0]), groups_load(&block->directions[1]),
                                       groups_load(&block->directions[2])};
    const plii_vec3x4 arms[2] = {groups_load(&block->arms[0]), groups_load(&block->arms[1])};
    const plii_vec3x4 velocity = plii_vec3x4_sub(groups_velocity_at(motions[0].linear, motions[0].angular, arms[0]),
                                                 groups_velocity_at(motions[1].linear, motions[1].angular, arms[1]));
    plii_float4 before[3], after[3];
    groups_find_impulses(block, directions, velocity, before, after);
    plii_float4 changes[3];
    for (int k = 0; k < 3; ++k) {
        plii_float4_store(block->impulses[k], after[k]);
        changes[k] = plii_float4_sub(after[k], before[k]);
    }
    const plii_group_side *a = &group->sides[0], *b = &group->sides[1];
    const plii_vec3x4 push = groups_sum(directions, changes);
    const plii_vec3x4 back = groups_mul(push, groups_load(&group->linear_factors));
    motions[0].linear =
        plii_vec3x4_add(motions[0].linear, plii_vec3x4_scale(push, plii_float4_load(a->inverse_masses)));
    motions[0].angular =
        plii_vec3x4_add(motions[0].angular, groups_turn(a->inverse_inertia, plii_vec3x4_cross(arms[0], push)));
    motions[1].linear =
        plii_vec3x4_sub(motions[1].linear, plii_vec3x4_scale(back, plii_float4_load(b->inverse_masses)));
    motions[1].angular =
        plii_vec3x4_sub(motions[1].angular, groups_turn(b->inverse_inertia, plii_vec3x4_cross(arms[1], back)));
}

void plii_contact_groups_solve(plii_contact_groups* groups) {
    groups_read_rigids(groups); /* joints may have moved them */
    for (int i = 0; i < groups->count; ++i) {
        const plii_contact_group* group = &groups->groups[i];
        const plii_group_side *a = &group->sides[0], *b = &group->sides[1];
        group_motion motions[2] = {{groups_gather(a->linear), groups_gather(a->angular)},
                                   {groups_gather(b->linear), groups_gather(b->angular)}};
        const group_motion before = motions[1];
        plii_contact_block* end = groups->blocks + group->first_block + group->block_count;
        for (plii_contact_block* block = end - group->block_count; block < end; ++block) {
            groups_solve_block(group, block, motions);
        }
        groups_scatter(a->linear, motions[0].linear);
        groups_scatter(a->angular, motions[0].angular);
        if (group->is_split) {
            const plii_float4 shares = plii_float4_load(group->shares);
            groups_scatter_shares(b->linear, before.linear, motions[1].linear, shares);
            groups_scatter_shares(b->angular, before.angular, motions[1].angular, shares);
        } else {
            groups_scatter(b->linear, motions[1].linear);
            groups_scatter(b->angular, motions[1].angular);
        }
    }
    for (int i = 0; i < groups->rigid_count; ++i) {
        const plii_group_rigid* met = &groups->rigids[i];
        if (met->rigid == NULL || met->rigid->state.inverse_mass == 0.0f) { continue; }
        met->rigid->state.linear_velocity = plii_xyz(met->linear_velocity);
        met->rigid->state.angular_velocity = plii_xyz(met->angular_velocity);
    }
}

// ------------------------------------------------------------------------------------------------------------- finish

/* Over the contacts of each lane. */
typedef struct group_sums {
    plii_vec3x4 push, moments[2];        /* of impulses */
    plii_vec3x4 drift, drift_moments[2]; /* of displacements */
    plii_float4 pushed, drift_counts;    /* pushed: > 0 where any impulse is not 0 */
} group_sums;

static group_sums groups_sum_up(const plii_contact_groups* groups, const plii_contact_group* group) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_vec3x4 nothing = {zero, zero, zero};
    group_sums sums = {nothing, {nothing, nothing}, nothing, {nothing, nothing}, zero, zero};
    for (int i = 0; i < group->block_count; ++i) {
        const plii_contact_block* block = &groups->blocks[group->first_block + i];
        const plii_vec3x4 directions[3] = {groups_load(&block->directions[0]), groups_load(&block->directions[1]),
                                           groups_load(&block->directions[2])};
        const plii_float4 impulses[3] = {plii_float4_load(block->impulses[0]), plii_float4_load(block->impulses[1]),
                                         plii_float4_load(block->impulses[2])};
        const plii_vec3x4 push = groups_sum(directions, impulses);
        const plii_float4 drift_size = plii_float4_load(block->drifts);
        const plii_vec3x4 drift = plii_vec3x4_scale(directions[0], drift_size);
        sums.push = plii_vec3x4_add(sums.push, push);
        sums.drift = plii_vec3x4_add(sums.drift, drift);
        for (int side = 0; side < 2; ++side) {
            const plii_vec3x4 arm = groups_load(&block->arms[side]);
            sums.moments[side] = plii_vec3x4_add(sums.moments[side], plii_vec3x4_cross(arm, push));
            sums.drift_moments[side] = plii_vec3x4_add(sums.drift_moments[side], plii_vec3x4_cross(arm, drift));
        }
        /* Friction has no impulse without the normal. */
        sums.pushed = plii_lanes_max(sums.pushed, impulses[0]);
        sums.drift_counts =
            plii_float4_add(sums.drift_counts, plii_lanes_select(plii_lanes_less(zero, drift_size), one, zero));
    }
    return sums;
}

static void groups_to_vectors(plii_vec3x4 v, pli_vec3 vectors[PLII_GROUP_LANES]) {
    plii_float4 rows[4] = {v.x, v.y, v.z, plii_float4_all(0.0f)};
    plii_float4_turn(rows);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_lanes_to_vec3(&vectors[lane], rows[lane]);
    }
}

/* What the iterations did to the velocity of a cluster its nodes have still to follow. The motions of clusters that
   share nodes are averaged over those that were pushed, displacements by their number: none must not count. A rigid
   body is not displaced; Bullet gives it a velocity instead, and momentum from nothing. */
static void groups_finish_side(const plii_group_side* side, const group_sums* sums, plii_vec3x4 moment,
                               plii_vec3x4 drift_moment, float sign) {
    const plii_float4 scale = plii_float4_mul(plii_float4_load(side->inverse_masses), plii_float4_all(sign));
    const plii_float4 direction = plii_float4_all(sign);
    pli_vec3 linear[PLII_GROUP_LANES], angular[PLII_GROUP_LANES];
    pli_vec3 drift[PLII_GROUP_LANES], angular_drift[PLII_GROUP_LANES];
    float pushed[PLII_GROUP_LANES], drift_counts[PLII_GROUP_LANES];
    groups_to_vectors(plii_vec3x4_scale(sums->push, scale), linear);
    groups_to_vectors(plii_vec3x4_scale(groups_turn(side->inverse_inertia, moment), direction), angular);
    groups_to_vectors(plii_vec3x4_scale(sums->drift, scale), drift);
    groups_to_vectors(plii_vec3x4_scale(groups_turn(side->inverse_inertia, drift_moment), direction), angular_drift);
    plii_float4_store(pushed, sums->pushed);
    plii_float4_store(drift_counts, sums->drift_counts);
    for (int lane = 0; lane < PLII_GROUP_LANES; ++lane) {
        plii_cluster* cluster = side->clusters[lane];
        if (cluster == NULL) { continue; }
        if (pushed[lane] > 0.0f) {
            cluster->velocity_impulse = pli_vec3_add(cluster->velocity_impulse, linear[lane]);
            cluster->angular_velocity_impulse = pli_vec3_add(cluster->angular_velocity_impulse, angular[lane]);
            cluster->velocity_impulse_count += 1;
        }
        if (drift_counts[lane] > 0.0f) {
            cluster->drift_impulse = pli_vec3_add(cluster->drift_impulse, drift[lane]);
            cluster->angular_drift_impulse = pli_vec3_add(cluster->angular_drift_impulse, angular_drift[lane]);
            cluster->drift_impulse_count += (int)drift_counts[lane];
        }
    }
}

void plii_contact_groups_finish(plii_contact_groups* groups) {
    for (int i = 0; i < groups->count; ++i) {
        const plii_contact_group* group = &groups->groups[i];
        const group_sums sums = groups_sum_up(groups, group);
        groups_finish_side(&group->sides[0], &sums, sums.moments[0], sums.drift_moments[0], 1.0f);
        groups_finish_side(&group->sides[1], &sums, sums.moments[1], sums.drift_moments[1], -1.0f);
    }
    groups->count = 0;
}

// ------------------------------------------------------------------------------------------------------------- memory

/* Four contacts to a block, in some disorder. */
bool plii_contact_groups_reserve(pli_context* context, plii_contact_groups* groups, int contacts) {
    return PLII_RESERVE(context, &groups->groups, &groups->capacity, contacts / 4 + 1) &&
           PLII_RESERVE(context, &groups->blocks, &groups->block_capacity, contacts / 2 + 1);
}

void plii_contact_groups_release(pli_context* context, plii_contact_groups* groups) {
    plii_release(context, groups->groups, (size_t)groups->capacity * sizeof *groups->groups);
    plii_release(context, groups->blocks, (size_t)groups->block_capacity * sizeof *groups->blocks);
    plii_release(context, groups->rigids, (size_t)groups->rigid_capacity * sizeof *groups->rigids);
    *groups = (plii_contact_groups){0};
}

size_t plii_contact_groups_bytes(const plii_contact_groups* groups) {
    return (size_t)groups->capacity * sizeof *groups->groups + (size_t)groups->block_capacity * sizeof *groups->blocks +
           (size_t)groups->rigid_capacity * sizeof *groups->rigids;
}
