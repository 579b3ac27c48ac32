/* Contacts as the iterations see them: how the normal and two tangents move their sides. Impulses are summed over the
   iterations, the sum along the normal pushes only, and friction is bounded by it (Catto, "Iterative dynamics with
   temporal coherence", 2005). A contact is a long chain of operations that waits for the one before, so pairs that have
   nothing movable in common are found first come, first served, and solved four at a time. */

#include "base/ranges.h"
#include "cluster/cluster_contacts_impl.h"

#define BATCHES_MAX_COUNT 7 /* of contacts of a pair; more are taken as another pair */
/* How much heavier than a cluster a rigid body must be to be in more than one lane. */
#define BATCHES_HEAVIER 16.0f

bool plii_contact_batches_start(pli_context* context, plii_contact_batches* batches, int rigid_count) {
    batches->count = batches->rigid_count = 0;
    batches->open_batches = 0;
    batches->keeps_momentum = false;
    memset(batches->open_counts, 0, sizeof batches->open_counts);
    batches->still[0] = batches->still[1] = (pli_vec4){0, 0, 0, 0};
    if (!PLII_RESERVE(context, &batches->rigids, &batches->rigid_capacity, rigid_count)) { return false; }
    batches->rigid_count = rigid_count;
    for (int i = 0; i < rigid_count; ++i) {
        batches->rigids[i].rigid = NULL;
    }
    return true;
}

static plii_batch_rigid* batches_rigid(const plii_contact_batches* batches, const plii_joint_target* target) {
    return target->rigid != NULL ? &batches->rigids[target->rigid->world_index] : NULL;
}

/* Of what an impulse moves; NULL when it moves nothing. */
static uint64_t* batches_marks(const plii_contact_batches* batches, const plii_joint_target* target) {
    if (target->cluster != NULL) { return &target->cluster->open_batches; }
    if (target->rigid == NULL || target->rigid->state.inverse_mass == 0.0f) { return NULL; }
    return &batches_rigid(batches, target)->open_batches;
}

static void batches_close(plii_contact_batches* batches, int bit) {
    const plii_contact_batch* batch = &batches->items[batches->open[bit]];
    const uint64_t others = ~(UINT64_C(1) << bit);
    for (int lane = 0; lane < batch->lane_count; ++lane) {
        for (int side = 0; side < 2; ++side) {
            uint64_t* marks = batches_marks(batches, &batch->contacts[lane]->targets[side]);
            if (marks != NULL) { *marks &= others; }
        }
    }
    batches->open_batches &= others;
    batches->open_counts[batch->block_count] &= others;
}

/* The bit of a batch with room for the pair, or PLI_NULL_INDEX: first one whose pairs have as many contacts. */
static int batches_find_open(const plii_contact_batches* batches, uint64_t taken, int count) {
    for (int blocks = count; blocks <= BATCHES_MAX_COUNT; ++blocks) {
        const uint64_t fit = batches->open_counts[blocks] & ~taken;
        if (fit != 0) { return __builtin_ctzll(fit); }
    }
    return PLI_NULL_INDEX;
}

static int batches_open(pli_context* context, plii_contact_batches* batches, int count) {
    if (!PLII_GROW(context, &batches->items, &batches->capacity, batches->count)) { return PLI_NULL_INDEX; }
    int bit = 0;
    if (batches->open_batches == UINT64_MAX) {
        /* The first to have been opened. */
        for (int i = 1; i < 64; ++i) {
            if (batches->open[i] < batches->open[bit]) { bit = i; }
        }
        batches_close(batches, bit);
    } else {
        bit = __builtin_ctzll(~batches->open_batches);
    }
    plii_contact_batch* batch = &batches->items[batches->count];
    memset(batch->counts, 0, sizeof batch->counts);
    batch->lane_count = 0;
    batch->block_count = count;
    batches->open[bit] = batches->count++;
    batches->open_batches |= UINT64_C(1) << bit;
    batches->open_counts[count] |= UINT64_C(1) << bit;
    return bit;
}

static bool batches_add_pair(pli_context* context, plii_contact_batches* batches, const plii_cluster_contact* contacts,
                             int count) {
    plii_batch_rigid* touched = batches_rigid(batches, &contacts->targets[1]);
    if (touched != NULL && touched->rigid == NULL) {
        *touched = (plii_batch_rigid){.rigid = contacts->targets[1].rigid};
    }
    uint64_t* const marks[2] = {batches_marks(batches, &contacts->targets[0]),
                                batches_marks(batches, &contacts->targets[1])};
    uint64_t taken = marks[0] != NULL ? *marks[0] : 0;
    plii_cluster *cluster = contacts->targets[0].cluster, *other = contacts->targets[1].cluster;
    const pli_rigid* rigid = contacts->targets[1].rigid;
    /* A rigid body may be in several lanes, each with a share of its mass, and moves as their mean (Tonge and others,
       "Mass splitting", 2012). Where the cluster is much lighter, that changes little. */
    const bool may_share =
        cluster != NULL && rigid != NULL && rigid->state.inverse_mass * BATCHES_HEAVIER <= cluster->inverse_mass;
    if (marks[1] != NULL && !may_share) { taken |= *marks[1]; }
    /* With rigid bodies impulses that nodes of several clusters get are averaged: what lies on them rests better. */
    if (cluster != NULL && other != NULL) {
        batches->keeps_momentum = cluster->keeps_momentum = other->keeps_momentum = true;
    }
    int bit = batches_find_open(batches, taken, count);
    if (bit == PLI_NULL_INDEX) { bit = batches_open(context, batches, count); }
    if (bit == PLI_NULL_INDEX) { return false; }
    plii_contact_batch* batch = &batches->items[batches->open[bit]];
    batch->contacts[batch->lane_count] = contacts;
    batch->counts[batch->lane_count++] = count;
    if (batch->lane_count == PLII_LANES) {
        batches_close(batches, bit);
        return true;
    }
    for (int side = 0; side < 2; ++side) {
        if (marks[side] != NULL) { *marks[side] |= UINT64_C(1) << bit; }
    }
    return true;
}

bool plii_contact_batches_add(pli_context* context, plii_contact_batches* batches, const plii_cluster_contact* contacts,
                              int count) {
    bool is_added = true;
    for (int first = 0; first < count && is_added; first += BATCHES_MAX_COUNT) {
        const int rest = count - first, added = rest < BATCHES_MAX_COUNT ? rest : BATCHES_MAX_COUNT;
        is_added = batches_add_pair(context, batches, contacts + first, added);
    }
    return is_added;
}

// -------------------------------------------------------------------------------------------------------------- lanes

static inline plii_vec3x4 batches_gather(pli_vec4* const records[PLII_LANES]) {
    return plii_vec3x4_of(plii_float4_from(records[0]), plii_float4_from(records[1]), plii_float4_from(records[2]),
                          plii_float4_from(records[3]));
}
static inline void batches_to_records(plii_vec3x4 v, plii_float4 records[PLII_LANES]) {
    records[0] = v.x;
    records[1] = v.y;
    records[2] = v.z;
    records[3] = plii_float4_all(0.0f);
    plii_float4_transpose(records);
}
static inline void batches_scatter(pli_vec4* const records[PLII_LANES], plii_vec3x4 v) {
    plii_float4 rows[PLII_LANES];
    batches_to_records(v, rows);
    PLII_UNROLL(4)
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        plii_float4_to(records[lane], rows[lane]);
    }
}
/* Each lane moves its record by its share. */
static inline void batches_scatter_shares(pli_vec4* const records[PLII_LANES], plii_vec3x4 before, plii_vec3x4 after,
                                          plii_float4 shares) {
    plii_float4 moves[PLII_LANES];
    batches_to_records(plii_vec3x4_scale(plii_vec3x4_sub(after, before), shares), moves);
    PLII_UNROLL(4)
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        plii_float4_to(records[lane], plii_float4_from(records[lane]) + moves[lane]);
    }
}
static inline plii_vec3x4 batches_from_vectors(const pli_vec3* const vectors[PLII_LANES]) {
    return plii_vec3x4_of(plii_lanes_from_vec3(vectors[0]), plii_lanes_from_vec3(vectors[1]),
                          plii_lanes_from_vec3(vectors[2]), plii_lanes_from_vec3(vectors[3]));
}

/* A sum of three vectors by impulses. */
static inline plii_vec3x4 batches_sum(const plii_vec3x4 directions[3], const plii_float4 impulses[3]) {
    return plii_vec3x4_add(
        plii_vec3x4_add(plii_vec3x4_scale(directions[0], impulses[0]), plii_vec3x4_scale(directions[1], impulses[1])),
        plii_vec3x4_scale(directions[2], impulses[2]));
}

/* Velocities of both sides. */
typedef struct batch_motion {
    plii_vec3x4 linear[2], angular[2];
} batch_motion;

/* Of side 0 against side 1, at the contact. */
static inline plii_vec3x4 batches_velocity_at(const batch_motion* motion, const plii_vec3x4 arms[2]) {
    return plii_vec3x4_sub(plii_vec3x4_add(motion->linear[0], plii_vec3x4_cross(motion->angular[0], arms[0])),
                           plii_vec3x4_add(motion->linear[1], plii_vec3x4_cross(motion->angular[1], arms[1])));
}

// ------------------------------------------------------------------------------------------------------------ prepare

static const plii_cluster_contact batches_no_contact = {.normal = {0, 0, 1}};

static const pli_mat3 batches_no_inertia = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};

/* Returns the inverse inertia. */
static const pli_mat3* batches_load_target(plii_contact_batches* batches, const plii_joint_target* target, int lane,
                                           plii_batch_side* side, plii_float4* inverse_masses) {
    side->clusters[lane] = target->cluster;
    side->linear[lane] = &batches->still[0];
    side->angular[lane] = &batches->still[1];
    (*inverse_masses)[lane] = 0.0f;
    side->splits[lane] = 1.0f;
    if (target->cluster != NULL) {
        side->linear[lane] = &target->cluster->linear_velocity;
        side->angular[lane] = &target->cluster->angular_velocity;
        (*inverse_masses)[lane] = target->cluster->inverse_mass;
        side->splits[lane] = target->cluster->split;
        return &target->cluster->inverse_inertia;
    }
    if (target->rigid == NULL) { return &batches_no_inertia; }
    plii_batch_rigid* touched = &batches->rigids[target->rigid->world_index];
    side->linear[lane] = &touched->linear_velocity;
    side->angular[lane] = &touched->angular_velocity;
    if (target->rigid->state.inverse_mass == 0.0f) { return &batches_no_inertia; }
    (*inverse_masses)[lane] = target->rigid->state.inverse_mass;
    return &target->rigid->state.inverse_inertia_world;
}

/* How many lanes have the rigid body of each; 1 where they have none that moves. */
static plii_float4 batches_count_lanes(plii_contact_batch* batch, plii_float4 inverse_masses) {
    const plii_batch_side* side = &batch->sides[1];
    plii_float4 counts;
    batch->is_split = false;
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        counts[lane] = batch->shares[lane] = 1.0f;
        if (side->clusters[lane] != NULL || inverse_masses[lane] == 0.0f) { continue; }
        int count = 0;
        for (int other = 0; other < PLII_LANES; ++other) {
            count += side->linear[other] == side->linear[lane] ? 1 : 0;
        }
        if (count == 1) { continue; }
        batch->is_split = true;
        counts[lane] = (float)count;
        batch->shares[lane] = 1.0f / (float)count;
    }
    return counts;
}

/* What the contacts of a batch have in common while they are prepared. */
typedef struct batch_terms {
    plii_float4 inverse_masses[2];
    plii_vec3x4 inertia[2][3];   /* rows of the inverse inertias */
    plii_vec3x4 angular_factors; /* of side 1, as plii_rigid_apply_impulse knows them, negative */
    batch_motion motion; /* part of the depth: measured after this step's motion, which the impulses will change; of
                            rigid bodies 0 as yet, see other_speed */
    plii_float4 factors; /* of impulses between clusters of one body */
} batch_terms;

static void batches_load_factors(plii_contact_batch* batch, batch_terms* terms) {
    static const pli_vec3 one = {1, 1, 1};
    const pli_vec3 *linear[PLII_LANES], *angular[PLII_LANES];
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        const pli_rigid* rigid = lane < batch->lane_count ? batch->contacts[lane]->targets[1].rigid : NULL;
        linear[lane] = rigid != NULL ? &rigid->linear_factor : &one;
        angular[lane] = rigid != NULL ? &rigid->angular_factor : &one;
    }
    const plii_float4 inverse_mass = terms->inverse_masses[0];
    terms->angular_factors = plii_vec3x4_neg(batches_from_vectors(angular));
    batch->inverse_masses[0] = (plii_vec3x4){inverse_mass, inverse_mass, inverse_mass};
    batch->inverse_masses[1] =
        plii_vec3x4_scale(plii_vec3x4_neg(batches_from_vectors(linear)), terms->inverse_masses[1]);
}

static batch_terms batches_load_terms(plii_contact_batches* batches, plii_contact_batch* batch) {
    plii_batch_side *a = &batch->sides[0], *b = &batch->sides[1];
    const pli_mat3* inertias[2][PLII_LANES];
    batch_terms terms;
    for (int lane = 0; lane < PLII_LANES; ++lane) {
        const plii_cluster_contact* contact = lane < batch->lane_count ? batch->contacts[lane] : &batches_no_contact;
        inertias[0][lane] = batches_load_target(batches, &contact->targets[0], lane, a, &terms.inverse_masses[0]);
        inertias[1][lane] = batches_load_target(batches, &contact->targets[1], lane, b, &terms.inverse_masses[1]);
        terms.factors[lane] = contact->is_self ? a->clusters[lane]->settings.self_impulse_factor : 1.0f;
        batch->limits[lane] = contact->is_self ? a->clusters[lane]->settings.max_self_impulse : INFINITY;
        batch->frictions[lane] = contact->as.terms.w;
    }
    const plii_float4 splits[2] = {a->splits, batches_count_lanes(batch, terms.inverse_masses[1]) * b->splits};
    terms.inverse_masses[0] *= splits[0];
    terms.inverse_masses[1] *= splits[1];
    for (int i = 0; i < 3; ++i) {
        const pli_vec3* rows[2][PLII_LANES];
        for (int lane = 0; lane < PLII_LANES; ++lane) {
            rows[0][lane] = &inertias[0][lane]->rows[i];
            rows[1][lane] = &inertias[1][lane]->rows[i];
        }
        terms.inertia[0][i] = plii_vec3x4_scale(batches_from_vectors(rows[0]), splits[0]);
        terms.inertia[1][i] = plii_vec3x4_scale(batches_from_vectors(rows[1]), splits[1]);
    }
    batches_load_factors(batch, &terms);
    terms.motion = (batch_motion){{batches_gather(a->linear), batches_gather(b->linear)},
                                  {batches_gather(a->angular), batches_gather(b->angular)}};
    return terms;
}

/* Unit vectors at right angles to a third and each other: Duff and others, "Building an orthonormal basis". */
static inline void batches_find_tangents(plii_vec3x4 n, plii_vec3x4 tangents[2]) {
    const plii_float4 one = plii_float4_all(1.0f), zero = plii_float4_all(0.0f);
    const plii_float4 sign = plii_lanes_select(n.z < zero, -one, one);
    const plii_float4 a = -one / (sign + n.z);
    const plii_float4 xa = n.x * a, b = xa * n.y;
    tangents[0] = (plii_vec3x4){one + sign * (xa * n.x), sign * b, -(sign * n.x)};
    tangents[1] = (plii_vec3x4){b, sign + n.y * n.y * a, -n.y};
}

/* That impulses meet along direction `k`; how they turn the sides goes to the block. */
static inline plii_float4 batches_load_direction(const batch_terms* common, plii_contact_block* block, int k) {
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

static inline void batches_prepare_block(const plii_contact_batch* batch, const batch_terms* common,
                                         const plii_cluster_contact* const contacts[PLII_LANES],
                                         plii_contact_block* block) {
    const pli_vec3* const vectors[3][PLII_LANES] = {
        {&contacts[0]->normal, &contacts[1]->normal, &contacts[2]->normal, &contacts[3]->normal},
        {&contacts[0]->arms[0], &contacts[1]->arms[0], &contacts[2]->arms[0], &contacts[3]->arms[0]},
        {&contacts[0]->arms[1], &contacts[1]->arms[1], &contacts[2]->arms[1], &contacts[3]->arms[1]}};
    block->directions[0] = batches_from_vectors(vectors[0]);
    batches_find_tangents(block->directions[0], block->directions + 1);
    block->arms[0] = batches_from_vectors(vectors[1]);
    block->arms[1] = batches_from_vectors(vectors[2]);
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    plii_float4 masses[3];
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        masses[k] = batches_load_direction(common, block, k);
        block->masses[k] = masses[k] * common->factors;
        block->impulses[k] = zero;
    }

    const plii_vec3x4 terms =
        plii_vec3x4_of(plii_float4_from(&contacts[0]->as.terms), plii_float4_from(&contacts[1]->as.terms),
                       plii_float4_from(&contacts[2]->as.terms), plii_float4_from(&contacts[3]->as.terms));
    const plii_float4 recovery = terms.x, hardness = terms.y, split = terms.z;
    const plii_vec3x4 velocity = batches_velocity_at(&common->motion, block->arms);
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
    const plii_float4 limited = plii_lanes_min(drift, batch->limits) * common->factors;
    block->drifts = plii_lanes_select(is_deep, limited, zero);
}

enum { BATCHES_PREPARE_NS = 300 }; /* of a batch */

static void batches_prepare_range(int begin, int end, void* data) {
    plii_contact_batches* batches = data;
    for (PLII_EACH(plii_contact_batch, batch, &batches->items[begin], end - begin)) {
        const batch_terms common = batches_load_terms(batches, batch);
        for (int k = 0; k < batch->block_count; ++k) {
            const plii_cluster_contact* contacts[PLII_LANES];
            for (int lane = 0; lane < PLII_LANES; ++lane) {
                contacts[lane] = k < batch->counts[lane] ? &batch->contacts[lane][k] : &batches_no_contact;
            }
            plii_contact_block* block = &batches->blocks[batch->first_block + k];
            batches_prepare_block(batch, &common, contacts, block);
            for (int lane = 0; lane < PLII_LANES; ++lane) {
                if (k < batch->counts[lane]) { continue; }
                block->masses[0][lane] = block->masses[1][lane] = block->masses[2][lane] = block->drifts[lane] = 0.0f;
            }
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- solve

/* Friction as far as the normal impulse allows. What slides is hard to foresee: a branch costs more than the root. */
static inline void batches_bound_friction(plii_float4 friction, plii_float4 impulses[3]) {
    const plii_float4 bound = friction * impulses[0];
    const plii_float4 squared = impulses[1] * impulses[1] + impulses[2] * impulses[2];
    const plii_mask4 slides = bound * bound < squared;
    const plii_float4 scale = plii_lanes_select(slides, bound / plii_float4_sqrt(squared), plii_float4_all(1.0f));
    impulses[1] = impulses[1] * scale;
    impulses[2] = impulses[2] * scale;
}

static inline void batches_solve_block(const plii_contact_batch* batch, plii_contact_block* block,
                                       batch_motion* motion) {
    const plii_vec3x4* directions = block->directions;
    const plii_vec3x4 velocity = batches_velocity_at(motion, block->arms);
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
    after[0] = plii_lanes_min(plii_lanes_max(after[0], zero), batch->limits);
    /* Nothing pushed and nothing does: a quarter of all, of which the next one need not wait for the result. */
    if (plii_lanes_bits(zero < plii_lanes_max(before[0], after[0])) == 0) { return; }
    batches_bound_friction(batch->frictions, after);
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        block->impulses[k] = after[k];
        changes[k] = after[k] - before[k];
    }
    const plii_vec3x4 push = batches_sum(directions, changes);
    PLII_UNROLL(2)
    for (int side = 0; side < 2; ++side) {
        plii_vec3x4 *linear = &motion->linear[side], *angular = &motion->angular[side];
        *linear = plii_vec3x4_add(*linear, plii_vec3x4_mul(push, batch->inverse_masses[side]));
        *angular = plii_vec3x4_add(*angular, batches_sum(block->rotations[side], changes));
    }
}

static void batches_solve(plii_contact_batches* batches) {
    for (PLII_EACH(const plii_contact_batch, batch, batches->items, batches->count)) {
        const plii_batch_side *a = &batch->sides[0], *b = &batch->sides[1];
        batch_motion motion = {{batches_gather(a->linear), batches_gather(b->linear)},
                               {batches_gather(a->angular), batches_gather(b->angular)}};
        const batch_motion before = motion;
        plii_contact_block* end = batches->blocks + batch->first_block + batch->block_count;
        for (plii_contact_block* block = end - batch->block_count; block < end; ++block) {
            batches_solve_block(batch, block, &motion);
        }
        batches_scatter(a->linear, motion.linear[0]);
        batches_scatter(a->angular, motion.angular[0]);
        if (batch->is_split) {
            batches_scatter_shares(b->linear, before.linear[1], motion.linear[1], batch->shares);
            batches_scatter_shares(b->angular, before.angular[1], motion.angular[1], batch->shares);
        } else {
            batches_scatter(b->linear, motion.linear[1]);
            batches_scatter(b->angular, motion.angular[1]);
        }
    }
}

void plii_contact_batches_prepare(pli_context* context, plii_contact_batches* batches) {
    while (batches->open_batches != 0) {
        batches_close(batches, __builtin_ctzll(batches->open_batches));
    }
    int block_count = 0;
    for (int i = 0; i < batches->count; ++i) {
        batches->items[i].first_block = block_count;
        block_count += batches->items[i].block_count;
    }
    if (!PLII_RESERVE(context, &batches->blocks, &batches->block_capacity, block_count)) { batches->count = 0; }
    plii_parallel_for(context, batches_prepare_range, batches, batches->count, plii_grain(BATCHES_PREPARE_NS));
}

void plii_contact_batches_solve(plii_contact_batches* batches) {
    if (batches->count == 0) { return; }
    for (PLII_EACH(plii_batch_rigid, touched, batches->rigids, batches->rigid_count)) {
        if (touched->rigid == NULL) { continue; }
        /* Joints may have moved them. w stays 0. */
        plii_set_xyz(&touched->linear_velocity, touched->rigid->state.linear_velocity);
        plii_set_xyz(&touched->angular_velocity, touched->rigid->state.angular_velocity);
    }
    batches_solve(batches);
    for (PLII_EACH(const plii_batch_rigid, touched, batches->rigids, batches->rigid_count)) {
        if (touched->rigid == NULL || touched->rigid->state.inverse_mass == 0.0f) { continue; }
        touched->rigid->state.linear_velocity = plii_xyz(touched->linear_velocity);
        touched->rigid->state.angular_velocity = plii_xyz(touched->angular_velocity);
    }
}

/* Four contacts to a block, in some disorder. */
void plii_contact_batches_reserve(pli_context* context, plii_contact_batches* batches, int contacts) {
    (void)PLII_RESERVE(context, &batches->items, &batches->capacity, contacts / 4 + 1);
    (void)PLII_RESERVE(context, &batches->blocks, &batches->block_capacity, contacts / 2 + 1);
}

// ------------------------------------------------------------------------------------------------------------- finish

/* What the contacts of each lane have done. */
typedef struct batch_sums {
    batch_motion velocities, drifts; /* these are displacements, over the step */
    plii_float4 pushed;              /* > 0 where any impulse is not 0 */
    plii_float4 drift_counts;
} batch_sums;

static inline batch_sums batches_sum_up(const plii_contact_batches* batches, const plii_contact_batch* batch) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_vec3x4 nothing = {zero, zero, zero};
    const batch_motion still = {{nothing, nothing}, {nothing, nothing}};
    batch_sums sums = {still, still, zero, zero};
    plii_vec3x4 pushes = nothing, drifts = nothing;
    for (int i = 0; i < batch->block_count; ++i) {
        const plii_contact_block* block = &batches->blocks[batch->first_block + i];
        pushes = plii_vec3x4_add(pushes, batches_sum(block->directions, block->impulses));
        drifts = plii_vec3x4_add(drifts, plii_vec3x4_scale(block->directions[0], block->drifts));
        PLII_UNROLL(2)
        for (int side = 0; side < 2; ++side) {
            plii_vec3x4 *angular = &sums.velocities.angular[side], *drift = &sums.drifts.angular[side];
            *angular = plii_vec3x4_add(*angular, batches_sum(block->rotations[side], block->impulses));
            *drift = plii_vec3x4_add(*drift, plii_vec3x4_scale(block->rotations[side][0], block->drifts));
        }
        /* Friction has no impulse without the normal. */
        sums.pushed = plii_lanes_max(sums.pushed, block->impulses[0]);
        sums.drift_counts += plii_lanes_select(zero < block->drifts, one, zero);
    }
    PLII_UNROLL(2)
    for (int side = 0; side < 2; ++side) {
        sums.velocities.linear[side] = plii_vec3x4_mul(pushes, batch->inverse_masses[side]);
        sums.drifts.linear[side] = plii_vec3x4_mul(drifts, batch->inverse_masses[side]);
    }
    return sums;
}

/* Adds the motion of a side to sums of its clusters, where `counts` is above 0: so many, or each as one. */
static void batches_hand_on(const plii_batch_side* side, plii_vec3x4 linear, plii_vec3x4 angular, plii_float4 counts,
                            bool is_drift) {
    plii_float4 linears[PLII_LANES], angulars[PLII_LANES];
    batches_to_records(linear, linears);
    batches_to_records(angular, angulars);
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
void plii_contact_batches_finish(plii_contact_batches* batches) {
    for (PLII_EACH(const plii_contact_batch, batch, batches->items, batches->count)) {
        const batch_sums sums = batches_sum_up(batches, batch);
        for (int i = 0; i < 2; ++i) {
            const plii_batch_side* side = &batch->sides[i];
            batches_hand_on(side, sums.velocities.linear[i], sums.velocities.angular[i], sums.pushed, false);
            batches_hand_on(side, sums.drifts.linear[i], sums.drifts.angular[i], sums.drift_counts, true);
        }
    }
    batches->count = 0;
}
