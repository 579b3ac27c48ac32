/* Contacts of nodes with rigid bodies in substeps. They were found at the predicted positions; their planes move with
   the rigid body. Those with bodies that nothing moves are solved in groups (node_rigid_groups.h). */

#include "body/world_state.h"
#include "contact/contact_substep.h"
#include "contact/node_rigid_impl.h"

/* Cosine between the way in which a rigid body presses a node and the way into a still surface: at larger angles the
   node slips out from between them, and holds nothing up. */
#define RIGID_SUBSTEP_WEDGE 0.9f
/* A node that slides away before a rigid body gives way so many times as fast: friction takes some in each step. */
#define RIGID_SUBSTEP_GIVING_WAY 2.0f

static bool rigid_groups_reserve(pli_body* body, plii_rigid_groups* groups, int count, int surface_count) {
    return PLII_RESERVE(body->context, &groups->groups, &groups->capacity, count) &&
           PLII_RESERVE(body->context, &groups->surfaces, &groups->surface_capacity, surface_count);
}

/* For `count` contacts, all with dynamic bodies or all with others. */
void plii_rigid_substeps_reserve(pli_body* body, plii_rigid_substeps* substeps, int count) {
    enum { MOST_PARTIAL_GROUPS = 8 }; /* as a rule; one per shape that the body touches may not be full */
    int dynamic_count = 0, surface_count = 0;
    for (PLII_EACH_RIGID(rigid, body->world)) {
        dynamic_count += rigid->kind == PLI_RIGID_DYNAMIC;
        surface_count += rigid->kind == PLI_RIGID_KINEMATIC;
    }
    if (dynamic_count > 0) {
        (void)PLII_RESERVE(body->context, &substeps->contacts.items, &substeps->contacts.capacity, count);
    }
    if (dynamic_count == body->world->rigid_count) { return; }
    const int partial_groups = count < MOST_PARTIAL_GROUPS ? count : MOST_PARTIAL_GROUPS;
    const int groups = count / PLII_RIGID_GROUP_SIZE + partial_groups;
    (void)rigid_groups_reserve(body, &substeps->groups, groups, surface_count > 0 ? groups : 0);
}

// ----------------------------------------------------------------------------------------------------------- groups

/* Lane of a record, see plii_simd_record. */
static int rigid_groups_lane(int record) {
    return record / 2 + 4 * (record % 2);
}
static void rigid_groups_put(float* components, int lane, pli_vec3 value) {
    components[lane] = value.x;
    components[lane + PLII_RIGID_GROUP_SIZE] = value.y;
    components[lane + 2 * PLII_RIGID_GROUP_SIZE] = value.z;
}

static pli_vec3 rigid_groups_get(const float* components, int lane) {
    return pli_vec3_make(components[lane], components[lane + PLII_RIGID_GROUP_SIZE],
                         components[lane + 2 * PLII_RIGID_GROUP_SIZE]);
}

static bool rigid_groups_takes(const plii_rigid_groups* groups, const plii_rigid_contact* contact) {
    if (groups->count == 0 || groups->filled == PLII_RIGID_GROUP_SIZE) { return false; }
    const plii_rigid_group* group = &groups->groups[groups->count - 1];
    return group->scaled_indices[groups->filled - 1] < plii_scaled_index(contact->node) &&
           (group->surface == PLI_NULL_INDEX) == contact->is_still;
}

/* The last group gets its first contact in the lanes that are left. */
static void rigid_groups_fill_up(plii_rigid_groups* groups) {
    if (groups->count == 0) { return; }
    plii_rigid_group* group = &groups->groups[groups->count - 1];
    for (; groups->filled < PLII_RIGID_GROUP_SIZE; ++groups->filled) {
        const int lane = rigid_groups_lane(groups->filled);
        rigid_groups_put(group->normal, lane, rigid_groups_get(group->normal, 0));
        group->offset[lane] = group->offset[0];
        group->friction[lane] = group->friction[0];
        group->squeeze[lane] = group->squeeze[0];
        group->scaled_indices[groups->filled] = group->scaled_indices[0];
        if (group->surface == PLI_NULL_INDEX) { continue; }
        float* velocity = groups->surfaces[group->surface].velocity;
        rigid_groups_put(velocity, lane, rigid_groups_get(velocity, 0));
    }
}

/* False without memory. */
static bool rigid_groups_open(pli_body* body, plii_rigid_groups* groups, bool is_still) {
    const int surfaces = groups->surface_count + !is_still;
    rigid_groups_fill_up(groups);
    if (!rigid_groups_reserve(body, groups, groups->count + 1, surfaces)) { return false; }
    groups->groups[groups->count++].surface = is_still ? PLI_NULL_INDEX : groups->surface_count;
    groups->surface_count = surfaces;
    groups->filled = 0;
    return true;
}

/* Returns the place of the contact in the groups. */
static int rigid_groups_add(pli_body* body, plii_rigid_groups* groups, const plii_rigid_contact* from, float friction) {
    if (!rigid_groups_takes(groups, from) && !rigid_groups_open(body, groups, from->is_still)) {
        return PLI_NULL_INDEX;
    }
    plii_rigid_group* group = &groups->groups[groups->count - 1];
    const int record = groups->filled++, lane = rigid_groups_lane(record);
    rigid_groups_put(group->normal, lane, plii_xyz(from->normal));
    group->offset[lane] = from->normal.w;
    group->friction[lane] = friction;
    group->squeeze[lane] = from->squeeze;
    group->scaled_indices[record] = plii_scaled_index(from->node);
    if (!from->is_still) {
        const pli_rigid* rigid = from->rigid;
        const pli_vec3 x = plii_xyz(body->positions[from->node]);
        const pli_vec3 offset = from->goes_along ? from->offset : pli_vec3_sub(x, rigid->state.pose.origin);
        rigid_groups_put(groups->surfaces[group->surface].velocity, lane, plii_rigid_pace_at(body, rigid, offset));
    }
    return (groups->count - 1) * PLII_RIGID_GROUP_SIZE + record;
}

// ----------------------------------------------------------------------------------------------------------- sweeps

static int rigid_substep_add(pli_body* body, plii_rigid_substeps* substeps, const plii_rigid_contact* from,
                             float friction) {
    const pli_vec3 x = plii_xyz(body->positions[from->node]);
    const pli_vec3 arm = from->goes_along ? from->offset : pli_vec3_sub(x, from->rigid->path.begin.origin);
    plii_point_contact* contact = plii_point_contacts_add(body, &substeps->contacts);
    if (contact == NULL) { return PLI_NULL_INDEX; }
    contact->normal = plii_xyz(from->normal);
    contact->offset = from->normal.w;
    contact->surface = (plii_substep_rigid_point){from->rigid, arm};
    contact->node_count = 1;
    contact->nodes[0] = from->node;
    contact->weights[0] = 1.0f;
    contact->coefficient = friction;
    plii_point_contact_prepare(body, contact);
    return substeps->contacts.count - 1;
}

static void rigid_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    plii_rigid_contacts* found = data;
    plii_point_contacts_restart(body, &found->substeps.contacts, substep,
                                plii_contact_recovery_speed(found->def.recovery_speed));
}

/* The nearest contact of each node with a body that nothing moves. */
static void rigid_substep_find_fixed(plii_rigid_contacts* found) {
    for (int i = 0; i < found->count; ++i) {
        const plii_rigid_contact* contact = &found->contacts[i];
        int* nearest = &found->fixed_of_node[contact->node];
        const bool is_first = !plii_rigid_contacts_has_fixed(found, *nearest, i, contact->node);
        if (contact->is_fixed && (is_first || contact->distance < found->contacts[*nearest].distance)) { *nearest = i; }
    }
}
/* NULL: there is none. */
static const plii_rigid_contact* rigid_substep_fixed_of(const plii_rigid_contacts* found, int node) {
    const int nearest = found->fixed_of_node[node];
    return plii_rigid_contacts_has_fixed(found, nearest, found->count, node) ? &found->contacts[nearest] : NULL;
}

/* Nodes or faces, which come before, have met rigid bodies that give way. */
static bool rigid_substep_is_pressed(const pli_body* body) {
    for (const pli_rigid* rigid = body->followed_rigids; rigid != NULL; rigid = rigid->path.next) {
        const pli_rigid_state* state = &rigid->state;
        if (state->inverse_mass > 0.0f || !plii_mat3_is_zero(&state->inverse_inertia_world)) { return true; }
    }
    return false;
}

static void rigid_substep_begin(pli_body* body, void* data) {
    plii_rigid_contacts* found = data;
    plii_rigid_substeps* substeps = &found->substeps;
    substeps->contacts.count = substeps->groups.count = substeps->groups.surface_count = 0;
    bool has_fixed = false;
    for (int is_still = 0; is_still <= 1; ++is_still) {
        for (PLII_EACH(plii_rigid_contact, contact, found->contacts, found->count)) { /* without memory left out */
            if (contact->is_still != (is_still == 1)) { continue; }
            has_fixed = has_fixed || contact->is_fixed;
            const float friction = found->def.friction * contact->rigid->friction;
            contact->place = contact->is_fixed ? rigid_groups_add(body, &substeps->groups, contact, friction)
                                               : rigid_substep_add(body, substeps, contact, friction);
        }
    }
    rigid_groups_fill_up(&substeps->groups);
    substeps->has_fixed_nodes = has_fixed && rigid_substep_is_pressed(body);
    if (substeps->has_fixed_nodes) { rigid_substep_find_fixed(found); }
}

/* m/s, of the surface of a contact with a body that nothing moves. */
static pli_vec3 rigid_groups_velocity(const plii_rigid_groups* groups, const plii_rigid_contact* contact) {
    const int place = contact->place;
    if (contact->is_still || place == PLI_NULL_INDEX) { return pli_vec3_make(0, 0, 0); }
    const int surface = groups->groups[place / PLII_RIGID_GROUP_SIZE].surface;
    return rigid_groups_get(groups->surfaces[surface].velocity, rigid_groups_lane(place % PLII_RIGID_GROUP_SIZE));
}

/* To the surfaces of bodies that nothing moves. */
static float rigid_substep_room(const pli_body* body, const void* data, const plii_substep* substep, int node,
                                pli_vec3 direction, float wanted) {
    const plii_rigid_contacts* found = data;
    const plii_rigid_contact* contact = rigid_substep_fixed_of(found, node);
    if (contact == NULL) { return INFINITY; }
    const pli_vec3 normal = plii_xyz(contact->normal);
    const float approach = -pli_vec3_dot(normal, direction);
    if (!(approach > RIGID_SUBSTEP_WEDGE)) { return INFINITY; }
    const float time = (float)(substep->index + 1) * substep->dt;
    const pli_vec3 moved = pli_vec3_scale(rigid_groups_velocity(&found->substeps.groups, contact), time);
    const pli_vec3 apart = pli_vec3_sub(plii_substep_position(body, substep, node), moved);
    const float gap = pli_vec3_dot(normal, apart) + contact->normal.w;
    return plii_max(gap, 0.0f) / approach;
}

static bool rigid_substep_carry(const pli_body* body, const void* data, const plii_substep* substep, int node,
                                pli_vec3 direction, pli_vec3 own, pli_vec3* motion) {
    const plii_rigid_contacts* found = data;
    const plii_rigid_contact* contact = rigid_substep_fixed_of(found, node);
    if (contact == NULL) { return false; }
    const pli_vec3 surface = pli_vec3_scale(rigid_groups_velocity(&found->substeps.groups, contact), substep->dt);
    const pli_vec3 normal = plii_xyz(contact->normal), apart = pli_vec3_sub(own, surface);
    const pli_vec3 sliding = pli_vec3_sub(apart, pli_vec3_scale(normal, pli_vec3_dot(normal, apart)));
    const float away = RIGID_SUBSTEP_GIVING_WAY * plii_max(pli_vec3_dot(direction, sliding), 0.0f);
    *motion = pli_vec3_add(surface, pli_vec3_scale(direction, away));
    return false;
}

static bool rigid_substep_is_limit(const void* data) {
    return ((const plii_rigid_contacts*)data)->substeps.has_fixed_nodes;
}

/* What a contact of a group has pushed its node by in a substep, N s. */
static pli_vec3 rigid_groups_impulse(const plii_rigid_groups* groups, const plii_rigid_contact* contact,
                                     const plii_substep* substep) {
    const plii_rigid_group* group = &groups->groups[contact->place / PLII_RIGID_GROUP_SIZE];
    const int lane = rigid_groups_lane(contact->place % PLII_RIGID_GROUP_SIZE);
    const float inverse_mass = substep->displacements[contact->node].w;
    if (!(inverse_mass > 0.0f)) { return pli_vec3_make(0, 0, 0); }
    const pli_vec3 moved = pli_vec3_add(pli_vec3_scale(rigid_groups_get(group->normal, lane), group->pushed[lane]),
                                        rigid_groups_get(group->rubbed, lane));
    return pli_vec3_scale(moved, substep->inverse_dt / inverse_mass);
}

/* After the last sweep. */
static void rigid_substep_record(plii_rigid_contacts* found, const plii_substep* substep) {
    const plii_rigid_substeps* substeps = &found->substeps;
    for (int i = 0; i < found->count; ++i) {
        const plii_rigid_contact* contact = &found->contacts[i];
        if (contact->place == PLI_NULL_INDEX) { continue; }
        const pli_vec3 impulse = contact->is_fixed
                                     ? rigid_groups_impulse(&substeps->groups, contact, substep)
                                     : plii_point_contact_impulse(&substeps->contacts.items[contact->place], substep);
        plii_contact_impulses_push(&found->impulses, i, impulse);
    }
}

/* What cannot yield has the last word. */
static void rigid_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    plii_rigid_contacts* found = data;
    const float compliance = found->def.compliance;
    const plii_rigid_groups_pass pass = {.substep = substep,
                                         .positions = body->positions,
                                         .share = substep->dt * body->step.inverse_dt,
                                         .alpha = compliance * substep->inverse_dt * substep->inverse_dt,
                                         .recovery =
                                             plii_contact_recovery_speed(found->def.recovery_speed) * substep->dt,
                                         .leaves_sums = !substep->is_last_sweep || body->records_contacts};
    plii_point_contacts_sweep(body, &found->substeps.contacts, substep, compliance);
    if (found->substeps.groups.count > 0) {
        PLII_KERNEL(body->context, plii_rigid_groups_sweep)(&found->substeps.groups, &pass);
    }
    if (body->records_contacts && substep->is_last_sweep) { rigid_substep_record(found, substep); }
}

static bool rigid_substep_is_idle(const void* data) {
    const plii_rigid_substeps* substeps = &((const plii_rigid_contacts*)data)->substeps;
    return substeps->contacts.count == 0 && substeps->groups.count == 0;
}

enum { RIGID_SUBSTEP_ORDER = 60 }; /* after all that holds the body together and self-collision of nodes */
const plii_substep_class plii_rigid_contacts_substepped = {
    .order = RIGID_SUBSTEP_ORDER,
    .is_in_iterations = true,
    .begin = rigid_substep_begin,
    .restart = rigid_substep_restart,
    .sweep = rigid_substep_sweep,
    .room = rigid_substep_room,
    .carry = rigid_substep_carry,
    .is_limit = rigid_substep_is_limit,
    .is_idle = rigid_substep_is_idle,
};
