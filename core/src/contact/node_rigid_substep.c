/* Contacts of nodes with rigid bodies in substeps. C = n . (node - motion of the surface) + offset >= 0, with Coulomb
   friction on the motion of the substep. They were found at the predicted positions; their planes move with the rigid
   body. Those with bodies that nothing moves are solved in groups (node_rigid_groups.h). */

#include "body/substep_rigid.h"
#include "body/world_state.h"
#include "contact/contact_substep.h"
#include "contact/node_rigid_impl.h"

/* With a body that takes impulses. */
struct plii_rigid_substep_contact {
    pli_vec3 normal;
    float offset; /* of the plane that is kept free, at the start of the step; m */
    plii_substep_rigid_point point;
    int node;
    float coefficient; /* of friction */
    /* For one substep. */
    float weight, floor, multiplier;
    pli_vec3 friction;
};

// ----------------------------------------------------------------------------------------------------------- memory

static bool rigid_groups_reserve(pli_body* body, plii_rigid_groups* groups, int count, int surface_count) {
    return PLII_RESERVE(body->context, &groups->groups, &groups->capacity, count) &&
           PLII_RESERVE(body->context, &groups->sums, &groups->sum_capacity, count) &&
           PLII_RESERVE(body->context, &groups->surfaces, &groups->surface_capacity, surface_count);
}

/* For `count` contacts, all with dynamic bodies or all with others. */
void plii_rigid_substeps_reserve(pli_body* body, plii_rigid_substeps* substeps, int count) {
    int dynamic_count = 0, surface_count = 0, shape_count = 0;
    for (int i = 0; i < body->world->rigid_count; ++i) {
        const pli_rigid* rigid = body->world->rigids[i];
        dynamic_count += rigid->kind == PLI_RIGID_DYNAMIC;
        surface_count += rigid->kind == PLI_RIGID_KINEMATIC;
        shape_count += rigid->shape_count;
    }
    if (dynamic_count > 0) { (void)PLII_RESERVE(body->context, &substeps->contacts, &substeps->capacity, count); }
    if (dynamic_count == body->world->rigid_count) { return; }
    const int starts = shape_count < count ? shape_count : count; /* of groups that are not full */
    const int groups = count / PLII_RIGID_GROUP_SIZE + starts;
    (void)rigid_groups_reserve(body, &substeps->groups, groups, surface_count > 0 ? groups : 0);
}

size_t plii_rigid_substeps_bytes(const plii_rigid_substeps* substeps) {
    const plii_rigid_groups* groups = &substeps->groups;
    return (size_t)substeps->capacity * sizeof *substeps->contacts + (size_t)groups->capacity * sizeof *groups->groups +
           (size_t)groups->sum_capacity * sizeof *groups->sums +
           (size_t)groups->surface_capacity * sizeof *groups->surfaces;
}

void plii_rigid_substeps_release(pli_body* body, void* data) {
    plii_rigid_substeps* substeps = &((plii_rigid_contacts*)data)->substeps;
    const plii_rigid_groups* groups = &substeps->groups;
    pli_context* context = body->context;
    plii_release(context, substeps->contacts, (size_t)substeps->capacity * sizeof *substeps->contacts);
    plii_release(context, groups->groups, (size_t)groups->capacity * sizeof *groups->groups);
    plii_release(context, groups->sums, (size_t)groups->sum_capacity * sizeof *groups->sums);
    plii_release(context, groups->surfaces, (size_t)groups->surface_capacity * sizeof *groups->surfaces);
    *substeps = (plii_rigid_substeps){0};
}

// ----------------------------------------------------------------------------------------------------------- groups

/* Lane of a record, see plii_nodes8. */
static int rigid_groups_lane(int record) {
    return record / 2 + 4 * (record % 2);
}

static void rigid_groups_put(float* components, int lane, pli_vec3 value) {
    components[lane] = value.x;
    components[lane + PLII_RIGID_GROUP_SIZE] = value.y;
    components[lane + 2 * PLII_RIGID_GROUP_SIZE] = value.z;
}

/* Fills the last group up. */
static void rigid_groups_close(plii_rigid_groups* groups) {
    if (groups->count == 0) { return; }
    plii_rigid_group* group = &groups->groups[groups->count - 1];
    const int last = rigid_groups_lane(groups->filled - 1);
    for (; groups->filled < PLII_RIGID_GROUP_SIZE; ++groups->filled) {
        const int lane = rigid_groups_lane(groups->filled);
        for (int k = 0; k < 3; ++k) {
            group->normal[k * PLII_RIGID_GROUP_SIZE + lane] = group->normal[k * PLII_RIGID_GROUP_SIZE + last];
            if (group->surface != PLI_NULL_INDEX) {
                float* velocity = groups->surfaces[group->surface].velocity + k * PLII_RIGID_GROUP_SIZE;
                velocity[lane] = velocity[last];
            }
        }
        group->offset[lane] = group->offset[last];
        group->friction[lane] = group->friction[last];
        group->scaled_indices[groups->filled] = group->scaled_indices[groups->filled - 1];
    }
}

static bool rigid_groups_takes(const plii_rigid_groups* groups, const plii_rigid_contact* contact) {
    if (groups->count == 0 || groups->filled == PLII_RIGID_GROUP_SIZE) { return false; }
    const plii_rigid_group* group = &groups->groups[groups->count - 1];
    return group->scaled_indices[groups->filled - 1] < plii_scaled_index(contact->node) &&
           (group->surface == PLI_NULL_INDEX) == contact->is_still;
}

/* False without memory. */
static bool rigid_groups_open(pli_body* body, plii_rigid_groups* groups, bool is_still) {
    rigid_groups_close(groups);
    const int surfaces = groups->surface_count + !is_still;
    if (!rigid_groups_reserve(body, groups, groups->count + 1, surfaces)) { return false; }
    groups->groups[groups->count++].surface = is_still ? PLI_NULL_INDEX : groups->surface_count;
    groups->surface_count = surfaces;
    groups->filled = 0;
    return true;
}

static void rigid_groups_add(pli_body* body, plii_rigid_groups* groups, const plii_rigid_contact* from,
                             float friction) {
    if (!rigid_groups_takes(groups, from) && !rigid_groups_open(body, groups, from->is_still)) { return; }
    plii_rigid_group* group = &groups->groups[groups->count - 1];
    const int lane = rigid_groups_lane(groups->filled);
    rigid_groups_put(group->normal, lane, plii_xyz(from->normal));
    group->offset[lane] = from->normal.w;
    group->friction[lane] = friction;
    group->scaled_indices[groups->filled++] = plii_scaled_index(from->node);
    if (from->is_still) { return; }
    const pli_rigid* rigid = from->rigid;
    const pli_vec3 offset = pli_vec3_sub(plii_xyz(body->positions[from->node]), rigid->state.pose.origin);
    rigid_groups_put(groups->surfaces[group->surface].velocity, lane, plii_rigid_velocity_at(rigid, offset));
}

static plii_rigid_groups_sweep* rigid_groups_kernel(const pli_context* context) {
#if PLIANT_SIMD_X86
    if (context->simd == PLI_SIMD_AVX2) { return plii_rigid_groups_sweep_avx2; }
#else
    (void)context;
#endif
    return plii_rigid_groups_sweep_base;
}

// ------------------------------------------------------------------------------------- with bodies that take impulses

static void rigid_substep_add(pli_body* body, plii_rigid_substeps* substeps, const plii_rigid_contact* from,
                              float friction) {
    if (!PLII_RESERVE(body->context, &substeps->contacts, &substeps->capacity, substeps->count + 1)) { return; }
    plii_rigid_substep_contact* contact = &substeps->contacts[substeps->count++];
    *contact = (plii_rigid_substep_contact){.normal = plii_xyz(from->normal), .offset = from->normal.w};
    contact->node = from->node;
    contact->coefficient = friction;
    contact->point.rigid = from->rigid;
    contact->point.offset = pli_vec3_sub(plii_xyz(body->positions[from->node]), from->rigid->state.pose.origin);
}

/* Along a unit vector. */
static float rigid_substep_weight(const plii_substep* substep, const plii_rigid_substep_contact* contact,
                                  pli_vec3 direction) {
    return substep->displacements[contact->node].w + plii_substep_rigid_point_weight(&contact->point, direction);
}

static void rigid_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    const plii_rigid_contacts* found = data;
    const float recovery_speed = plii_contact_recovery_speed(found->def.recovery_speed);
    for (int i = 0; i < found->substeps.count; ++i) {
        plii_rigid_substep_contact* contact = &found->substeps.contacts[i];
        plii_substep_rigid_point_restart(&contact->point, substep);
        const pli_vec3 before = pli_vec3_add(plii_xyz(body->positions[contact->node]),
                                             plii_xyz(substep->start_displacements[contact->node]));
        const float gap = pli_vec3_dot(contact->normal, pli_vec3_sub(before, contact->point.moved)) + contact->offset;
        contact->floor = plii_contact_recover(substep, contact->node, contact->normal, gap, 1.0f, recovery_speed);
        contact->weight = rigid_substep_weight(substep, contact, contact->normal);
        contact->multiplier = 0.0f;
        contact->friction = pli_vec3_make(0, 0, 0);
    }
}

static void rigid_substep_push(const plii_substep* substep, const plii_rigid_substep_contact* contact, pli_vec3 push) {
    plii_substep_move(substep, contact->node, push, 1.0f);
    plii_substep_rigid_point_push(&contact->point, pli_vec3_neg(push), substep);
}

static void rigid_substep_press(const pli_body* body, const plii_substep* substep, float alpha,
                                plii_rigid_substep_contact* contact) {
    const pli_vec3 surface =
        pli_vec3_add(contact->point.moved, plii_substep_rigid_point_motion(&contact->point, substep));
    const pli_vec3 to_node = pli_vec3_sub(plii_substep_position(body, substep, contact->node), surface);
    const float gap = pli_vec3_dot(contact->normal, to_node) + contact->offset;
    const float before = contact->multiplier;
    if (before == 0.0f && !(gap < contact->floor)) { return; }
    const float change = plii_contact_multiplier(gap - contact->floor, contact->weight, alpha, before);
    contact->multiplier = plii_max(0.0f, before + change);
    rigid_substep_push(substep, contact, pli_vec3_scale(contact->normal, contact->multiplier - before));
}

static void rigid_substep_rub(const plii_substep* substep, plii_rigid_substep_contact* contact) {
    const pli_vec3 n = contact->normal, before = contact->friction;
    const pli_vec3 motion = pli_vec3_sub(plii_substep_motion(substep, contact->node),
                                         plii_substep_rigid_point_motion(&contact->point, substep));
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    const float length = pli_vec3_length(sliding);
    if (!(length > 0.0f) || !(contact->weight > 0.0f)) { return; }
    const float weight = rigid_substep_weight(substep, contact, pli_vec3_scale(sliding, 1.0f / length));
    const pli_vec3 friction =
        plii_contact_friction(before, sliding, weight, contact->coefficient * contact->multiplier);
    if (!plii_vec3_is_finite(friction)) { return; }
    rigid_substep_push(substep, contact, pli_vec3_sub(friction, before));
    contact->friction = friction;
}

// ----------------------------------------------------------------------------------------------------------- sweeps

static bool rigid_substep_is_fixed(const pli_rigid* rigid) {
    return rigid->state.inverse_mass == 0.0f && plii_mat3_is_zero(&rigid->state.inverse_inertia_world);
}

static void rigid_substep_begin(pli_body* body, void* data) {
    plii_rigid_contacts* found = data;
    plii_rigid_substeps* substeps = &found->substeps;
    substeps->count = substeps->groups.count = substeps->groups.surface_count = 0;
    const pli_rigid* rigid = NULL;
    bool is_fixed = false;
    for (int i = 0; i < found->count; ++i) { /* those without memory are left out in this step */
        const plii_rigid_contact* contact = &found->contacts[i];
        if (contact->rigid != rigid) {
            rigid = contact->rigid;
            is_fixed = rigid_substep_is_fixed(rigid);
        }
        const float friction = found->def.friction * rigid->friction;
        if (is_fixed) {
            rigid_groups_add(body, &substeps->groups, contact, friction);
        } else {
            rigid_substep_add(body, substeps, contact, friction);
        }
    }
    rigid_groups_close(&substeps->groups);
}

/* What cannot yield has the last word. */
static void rigid_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    plii_rigid_contacts* found = data;
    const plii_rigid_groups_settings settings = {found->def.compliance,
                                                 plii_contact_recovery_speed(found->def.recovery_speed)};
    const float alpha = settings.compliance * substep->inverse_dt * substep->inverse_dt;
    for (int i = 0; i < found->substeps.count; ++i) {
        plii_rigid_substep_contact* contact = &found->substeps.contacts[i];
        rigid_substep_press(body, substep, alpha, contact);
        const bool rubs = contact->multiplier > 0.0f || pli_vec3_length_squared(contact->friction) > 0.0f;
        if (rubs) { rigid_substep_rub(substep, contact); }
    }
    rigid_groups_kernel(body->context)(&found->substeps.groups, &settings, body->positions, substep);
}

static bool rigid_substep_is_idle(const pli_body* body, const void* data) {
    const plii_rigid_substeps* substeps = &((const plii_rigid_contacts*)data)->substeps;
    (void)body;
    return substeps->count == 0 && substeps->groups.count == 0;
}

enum { RIGID_SUBSTEP_ORDER = 60 }; /* after all that holds the body together and self-collision of nodes */

const plii_substep_class plii_rigid_contacts_substepped = {
    .order = RIGID_SUBSTEP_ORDER,
    .klass = &plii_rigid_contacts_class,
    .begin = rigid_substep_begin,
    .restart = rigid_substep_restart,
    .sweep = rigid_substep_sweep,
    .is_idle = rigid_substep_is_idle,
    .leave = plii_rigid_substeps_release,
};
