/* Contacts as the iterations see them: how the normal and two tangents move their sides. Impulses are summed over the
   iterations, the sum along the normal pushes only, and friction is bounded by it (Catto, "Iterative dynamics with
   temporal coherence", 2005). A contact is a long chain of operations that waits for the one before, so pairs that have
   nothing movable in common are found first come, first served, and solved four at a time. */

#include "cluster/cluster_contacts_impl.h"

#include <string.h>

#define GROUPS_MAX_COUNT 7 /* of contacts of a pair; more are taken as another pair */
/* How much heavier than a cluster a rigid body must be to be in more than one lane. */
#define GROUPS_HEAVIER 16.0f

bool plii_contact_batches_start(pli_context* context, plii_contact_batches* groups, int rigid_count) {
    groups->count = groups->block_count = groups->rigid_count = 0;
    groups->open_groups = 0;
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
    if (!PLII_RESERVE(context, &groups->groups, &groups->capacity, groups->count + 1)) { return PLI_NULL_INDEX; }
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

static void groups_meet_rigid(plii_contact_batches* groups, const plii_joint_target* target) {
    plii_group_rigid* touched = groups_rigid(groups, target);
    if (touched == NULL || touched->rigid != NULL) { return; }
    touched->rigid = target->rigid;
    touched->open_groups = 0;
}

/* A rigid body may be in several lanes, each of which then has a share of its mass, and moves as their mean (Tonge,
   Benevolenski, Voroshilov, "Mass splitting for jitter-free parallel rigid body simulation", 2012). Where the cluster
   is much lighter, that changes little for it. */
static bool groups_may_share(const plii_cluster_contact* contact) {
    const plii_cluster* cluster = contact->targets[0].cluster;
    const pli_rigid* rigid = contact->targets[1].rigid;
    return cluster != NULL && rigid != NULL && rigid->state.inverse_mass * GROUPS_HEAVIER <= cluster->inverse_mass;
}

static bool groups_add_pair(pli_context* context, plii_contact_batches* groups, const plii_cluster_contact* contacts,
                            int count) {
    groups_meet_rigid(groups, &contacts->targets[1]);
    uint64_t* const marks[2] = {groups_marks(groups, &contacts->targets[0]),
                                groups_marks(groups, &contacts->targets[1])};
    uint64_t taken = marks[0] != NULL ? *marks[0] : 0;
    if (marks[1] != NULL && !groups_may_share(contacts)) { taken |= *marks[1]; }
    int bit = groups_find_open(groups, taken, count);
    if (bit == PLI_NULL_INDEX) { bit = groups_open(context, groups, count); }
    if (bit == PLI_NULL_INDEX) { return false; }
    plii_contact_batch* group = &groups->groups[groups->open[bit]];
    group->contacts[group->lane_count] = contacts;
    group->counts[group->lane_count++] = count;
    if (group->lane_count == PLII_GROUP_LANES) {
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

/* w stays 0. */
static void groups_read_rigids(plii_contact_batches* groups) {
    for (PLII_EACH(plii_group_rigid, touched, groups->rigids, groups->rigid_count)) {
        if (touched->rigid == NULL) { continue; }
        plii_set_xyz(&touched->linear_velocity, touched->rigid->state.linear_velocity);
        plii_set_xyz(&touched->angular_velocity, touched->rigid->state.angular_velocity);
    }
}

bool plii_contact_batches_prepare(pli_context* context, plii_contact_batches* groups, const plii_step* step) {
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
    groups->block_count = block_count;
    groups_read_rigids(groups);
    plii_contact_groups_prepare(groups, step);
    return true;
}

void plii_contact_batches_solve(plii_contact_batches* groups) {
    if (groups->count == 0) { return; }
    groups_read_rigids(groups); /* joints may have moved them */
    plii_contact_groups_solve(groups);
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
