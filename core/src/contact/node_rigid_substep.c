/* XPBD: contacts of nodes with rigid bodies. C = n . (node - motion of the surface) + offset >= 0, with Coulomb
   friction on the motion of the substep. Contacts are those that pli_body_enable_rigid_contacts found at the predicted
   positions; their planes move with the rigid body. */

#include "math/simd_float4.h"

#include "body/substep_rigid.h"
#include "body/world_state.h"
#include "contact/contact_substep.h"
#include "pliant/contact.h"
#include "solver/xpbd/xpbd_impl.h"

/* Records of four floats, so that four contacts with fixed bodies are solved at a time. */
typedef struct xpbd_rigid_contact {
    pli_vec4 normal; /* w: offset of the plane that is kept free, at the start of the step */
    /* For one substep; the first two of a fixed body, whose motion nothing changes. */
    pli_vec4 surface;  /* how far it is moved at the end; w: lowest gap */
    pli_vec4 motion;   /* w: coefficient of friction */
    pli_vec4 friction; /* w: multiplier */
    plii_substep_rigid_point point;
    float weight;
    int node;
    bool is_fixed, leads_four; /* this contact and the next three have fixed bodies and ascending nodes */
} xpbd_rigid_contact;

typedef struct xpbd_rigid_contacts_state {
    pli_xpbd_contacts_def def;
    pli_rigid_contact* found;
    int found_capacity;
    xpbd_rigid_contact* contacts;
    int count, capacity;
} xpbd_rigid_contacts_state;

static bool xpbd_rigid_contacts_reserve(pli_body* body, xpbd_rigid_contacts_state* state, int count) {
    return PLII_RESERVE(body->context, &state->found, &state->found_capacity, count) &&
           PLII_RESERVE(body->context, &state->contacts, &state->capacity, count);
}

/* Comes after the search, which was enabled before. */
static pli_status xpbd_rigid_contacts_collide(pli_body* body, void* data, pli_rigid* rigid) {
    const int count = pli_body_get_rigid_contacts(body, 0, NULL);
    (void)rigid;
    return xpbd_rigid_contacts_reserve(body, data, count) ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static void xpbd_rigid_contacts_preallocate(pli_body* body, void* data) {
    if (body->world->rigid_count > 0) { (void)xpbd_rigid_contacts_reserve(body, data, plii_body_contact_bound(body)); }
}

static bool xpbd_rigid_contacts_is_fixed(const pli_rigid* rigid) {
    const pli_mat3 inverse_inertia = rigid->state.inverse_inertia_world;
    float sum = rigid->state.inverse_mass;
    for (int k = 0; k < 3; ++k) {
        sum += fabsf(inverse_inertia.rows[k].x) + fabsf(inverse_inertia.rows[k].y) + fabsf(inverse_inertia.rows[k].z);
    }
    return sum == 0.0f;
}

static void xpbd_rigid_contacts_begin(pli_body* body, void* data) {
    xpbd_rigid_contacts_state* state = data;
    /* Fails only where the search was enabled after this; the contacts without room are left out then. */
    (void)xpbd_rigid_contacts_reserve(body, state, pli_body_get_rigid_contacts(body, 0, NULL));
    const int capacity = state->capacity < state->found_capacity ? state->capacity : state->found_capacity;
    const int found = pli_body_get_rigid_contacts(body, capacity, state->found);
    state->count = found < capacity ? found : capacity;
    for (int i = 0; i < state->count; ++i) {
        const pli_rigid_contact* from = &state->found[i];
        const pli_vec3 x = plii_xyz(body->positions[from->node]);
        xpbd_rigid_contact* contact = &state->contacts[i];
        *contact = (xpbd_rigid_contact){.node = from->node};
        plii_set_xyz(&contact->normal, from->normal);
        contact->normal.w = from->distance - pli_vec3_dot(from->normal, x);
        contact->motion.w = state->def.friction * from->rigid->friction;
        contact->is_fixed = xpbd_rigid_contacts_is_fixed(from->rigid);
        contact->point.rigid = from->rigid;
        contact->point.offset = pli_vec3_sub(x, from->rigid->state.pose.origin);
    }
    for (int i = 0; i + PLII_LANES <= state->count; ++i) {
        xpbd_rigid_contact* c = &state->contacts[i];
        c->leads_four = c[0].is_fixed && c[1].is_fixed && c[2].is_fixed && c[3].is_fixed && c[0].node < c[1].node &&
                        c[1].node < c[2].node && c[2].node < c[3].node;
    }
}

/* Along a unit vector. */
static float xpbd_rigid_contacts_weight(const plii_substep* substep, const xpbd_rigid_contact* contact,
                                        pli_vec3 direction) {
    const float weight = substep->displacements[contact->node].w;
    return contact->is_fixed ? weight : weight + plii_substep_rigid_point_weight(&contact->point, direction);
}

static pli_vec3 xpbd_rigid_contacts_motion(const plii_substep* substep, const xpbd_rigid_contact* contact) {
    return contact->is_fixed ? plii_xyz(contact->motion) : plii_substep_rigid_point_motion(&contact->point, substep);
}

static void xpbd_rigid_contacts_restart_one(pli_body* body, const plii_substep* substep, xpbd_rigid_contact* contact,
                                            float recovery_speed) {
    plii_substep_rigid_point_restart(&contact->point, substep);
    const pli_vec3 before =
        pli_vec3_add(plii_xyz(body->positions[contact->node]), plii_xyz(substep->start_displacements[contact->node]));
    const pli_vec3 normal = plii_xyz(contact->normal), moved = contact->point.moved;
    const float gap = pli_vec3_dot(normal, pli_vec3_sub(before, moved)) + contact->normal.w;
    contact->surface.w = plii_xpbd_contact_recover(substep, contact->node, normal, gap, 1.0f, recovery_speed);
    contact->weight = xpbd_rigid_contacts_weight(substep, contact, normal);
    contact->friction = (pli_vec4){0};
    if (!contact->is_fixed) { return; }
    const pli_vec3 motion = plii_substep_rigid_point_motion(&contact->point, substep);
    plii_set_xyz(&contact->motion, motion);
    plii_set_xyz(&contact->surface, pli_vec3_add(moved, motion));
}

/* Of four contacts, or of their nodes. */
typedef struct xpbd_rigid_four {
    plii_vec3x4 xyz;
    plii_float4 w;
} xpbd_rigid_four;

PLII_SIMD_INLINE xpbd_rigid_four xpbd_rigid_contacts_load_four(const pli_vec4* a, const pli_vec4* b, const pli_vec4* c,
                                                               const pli_vec4* d) {
    plii_float4 r[PLII_LANES] = {plii_float4_from(a), plii_float4_from(b), plii_float4_from(c), plii_float4_from(d)};
    plii_float4_transpose(r);
    return (xpbd_rigid_four){{r[0], r[1], r[2]}, r[3]};
}
PLII_SIMD_INLINE void xpbd_rigid_contacts_store_four(const xpbd_rigid_four* four, pli_vec4* a, pli_vec4* b, pli_vec4* c,
                                                     pli_vec4* d) {
    plii_float4 r[PLII_LANES] = {four->xyz.x, four->xyz.y, four->xyz.z, four->w};
    plii_float4_transpose(r);
    plii_float4_to(a, r[0]);
    plii_float4_to(b, r[1]);
    plii_float4_to(c, r[2]);
    plii_float4_to(d, r[3]);
}
#define XPBD_LOAD_FOUR(c, field)                                                                                       \
    xpbd_rigid_contacts_load_four(&(c)[0].field, &(c)[1].field, &(c)[2].field, &(c)[3].field)
#define XPBD_STORE_FOUR(four, c, field)                                                                                \
    xpbd_rigid_contacts_store_four(four, &(c)[0].field, &(c)[1].field, &(c)[2].field, &(c)[3].field)
#define XPBD_LOAD_NODES(records, c)                                                                                    \
    xpbd_rigid_contacts_load_four(&(records)[(c)[0].node], &(records)[(c)[1].node], &(records)[(c)[2].node],           \
                                  &(records)[(c)[3].node])
#define XPBD_STORE_NODES(four, records, c)                                                                             \
    xpbd_rigid_contacts_store_four(four, &(records)[(c)[0].node], &(records)[(c)[1].node], &(records)[(c)[2].node],    \
                                   &(records)[(c)[3].node])

/* xpbd_rigid_contacts_restart_one after the first substep: the surface begins where it ended. */
static void xpbd_rigid_contacts_restart_four(const pli_body* body, const plii_substep* substep, xpbd_rigid_contact* c,
                                             float recovery_speed) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const xpbd_rigid_four normal = XPBD_LOAD_FOUR(c, normal), motion = XPBD_LOAD_FOUR(c, motion);
    const xpbd_rigid_four x = XPBD_LOAD_NODES(body->positions, c);
    xpbd_rigid_four start_displacements = XPBD_LOAD_NODES(substep->start_displacements, c);
    xpbd_rigid_four surface = XPBD_LOAD_FOUR(c, surface);
    const plii_vec3x4 before = plii_vec3x4_add(x.xyz, start_displacements.xyz);
    const plii_float4 gap =
        plii_float4_add(plii_vec3x4_dot(normal.xyz, plii_vec3x4_sub(before, surface.xyz)), normal.w);
    const plii_mask4 recovers =
        plii_lanes_both(plii_lanes_less(gap, zero), plii_lanes_less(zero, start_displacements.w));
    surface.w = plii_lanes_min(gap, zero);
    if (plii_lanes_bits(recovers) != 0) {
        xpbd_rigid_four displacement = XPBD_LOAD_NODES(substep->displacements, c);
        const plii_float4 shift =
            plii_lanes_min(plii_float4_negate(gap), plii_float4_all(recovery_speed * substep->dt));
        const plii_vec3x4 shifts = plii_vec3x4_scale(normal.xyz, shift);
        displacement.xyz = plii_vec3x4_select(recovers, plii_vec3x4_add(displacement.xyz, shifts), displacement.xyz);
        start_displacements.xyz =
            plii_vec3x4_select(recovers, plii_vec3x4_add(start_displacements.xyz, shifts), start_displacements.xyz);
        surface.w = plii_lanes_select(recovers, plii_float4_add(gap, shift), surface.w);
        XPBD_STORE_NODES(&displacement, substep->displacements, c);
        XPBD_STORE_NODES(&start_displacements, substep->start_displacements, c);
    }
    surface.xyz = plii_vec3x4_add(surface.xyz, motion.xyz);
    XPBD_STORE_FOUR(&surface, c, surface);
    for (int k = 0; k < PLII_LANES; ++k) {
        c[k].friction = (pli_vec4){0};
    }
}

static void xpbd_rigid_contacts_restart(pli_body* body, void* data, const plii_substep* substep) {
    xpbd_rigid_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        xpbd_rigid_contact* contact = &state->contacts[i];
        if (contact->leads_four && substep->index > 0) {
            xpbd_rigid_contacts_restart_four(body, substep, contact, state->def.recovery_speed);
            i += PLII_LANES - 1;
        } else {
            xpbd_rigid_contacts_restart_one(body, substep, contact, state->def.recovery_speed);
        }
    }
}

static void xpbd_rigid_contacts_push(const plii_substep* substep, const xpbd_rigid_contact* contact, pli_vec3 push) {
    plii_substep_move(substep, contact->node, push, 1.0f);
    if (!contact->is_fixed) { plii_substep_rigid_point_push(&contact->point, pli_vec3_neg(push), substep); }
}

static void xpbd_rigid_contacts_press(pli_body* body, const plii_substep* substep,
                                      const xpbd_rigid_contacts_state* state, xpbd_rigid_contact* contact) {
    const pli_vec3 surface = contact->is_fixed
                                 ? plii_xyz(contact->surface)
                                 : pli_vec3_add(contact->point.moved, xpbd_rigid_contacts_motion(substep, contact));
    const pli_vec3 to_node = pli_vec3_sub(plii_substep_position(body, substep, contact->node), surface);
    const pli_vec3 normal = plii_xyz(contact->normal);
    const float gap = pli_vec3_dot(normal, to_node) + contact->normal.w, floor = contact->surface.w;
    const float before = contact->friction.w;
    if (before == 0.0f && !(gap < floor)) { return; }
    const float change =
        plii_xpbd_multiplier(gap - floor, contact->weight, state->def.compliance, 0.0f, before, 0.0f, substep);
    const float multiplier = plii_max(0.0f, before + change);
    if (multiplier == before) { return; }
    xpbd_rigid_contacts_push(substep, contact, pli_vec3_scale(normal, multiplier - before));
    contact->friction.w = multiplier;
}

static void xpbd_rigid_contacts_rub(const plii_substep* substep, xpbd_rigid_contact* contact) {
    const pli_vec3 n = plii_xyz(contact->normal), before = plii_xyz(contact->friction);
    const pli_vec3 motion =
        pli_vec3_sub(plii_substep_motion(substep, contact->node), xpbd_rigid_contacts_motion(substep, contact));
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    const float length = pli_vec3_length(sliding);
    if (!(length > 0.0f) || !(contact->weight > 0.0f)) { return; }
    const float weight = xpbd_rigid_contacts_weight(substep, contact, pli_vec3_scale(sliding, 1.0f / length));
    const pli_vec3 friction =
        plii_xpbd_contact_friction(before, sliding, weight, contact->motion.w * contact->friction.w);
    if (!plii_vec3_is_finite(friction)) { return; }
    xpbd_rigid_contacts_push(substep, contact, pli_vec3_sub(friction, before));
    plii_set_xyz(&contact->friction, friction);
}

static void xpbd_rigid_contacts_solve_one(pli_body* body, const plii_substep* substep,
                                          const xpbd_rigid_contacts_state* state, xpbd_rigid_contact* contact) {
    xpbd_rigid_contacts_press(body, substep, state, contact);
    const bool rubs = contact->friction.w > 0.0f || pli_vec3_length_squared(plii_xyz(contact->friction)) > 0.0f;
    if (rubs) { xpbd_rigid_contacts_rub(substep, contact); }
}

/* The same for four. `alpha`: see plii_xpbd_multiplier. */
static void xpbd_rigid_contacts_solve_four(const pli_body* body, const plii_substep* substep, float alpha,
                                           xpbd_rigid_contact* c) {
    const plii_float4 zero = plii_float4_all(0.0f), alphas = plii_float4_all(alpha);
    const xpbd_rigid_four x = XPBD_LOAD_NODES(body->positions, c);
    xpbd_rigid_four moved = XPBD_LOAD_NODES(substep->displacements, c), friction = XPBD_LOAD_FOUR(c, friction);
    const xpbd_rigid_four normal = XPBD_LOAD_FOUR(c, normal), surface = XPBD_LOAD_FOUR(c, surface);
    const plii_float4 weight = moved.w, before = friction.w;
    const plii_vec3x4 to_node = plii_vec3x4_sub(plii_vec3x4_add(x.xyz, moved.xyz), surface.xyz);
    const plii_float4 gap = plii_float4_add(plii_vec3x4_dot(normal.xyz, to_node), normal.w);
    const plii_mask4 is_low = plii_lanes_less(gap, surface.w), was_pressed = plii_lanes_less(zero, before);
    const plii_mask4 was_rubbed = plii_lanes_less(zero, plii_vec3x4_dot(friction.xyz, friction.xyz));
    if (plii_lanes_bits(plii_lanes_either(is_low, plii_lanes_either(was_pressed, was_rubbed))) == 0) { return; }

    const plii_float4 wanted =
        plii_float4_sub(plii_float4_negate(plii_float4_sub(gap, surface.w)), plii_float4_mul(alphas, before));
    const plii_float4 quotient = plii_float4_div(wanted, plii_float4_add(weight, alphas));
    const plii_mask4 has_weight = plii_lanes_less(zero, weight);
    const plii_float4 change =
        plii_lanes_select(plii_lanes_both(has_weight, plii_lanes_finite(quotient)), quotient, zero);
    const plii_float4 pressed = plii_lanes_max(zero, plii_float4_add(before, change));
    const plii_mask4 differs = plii_lanes_either(plii_lanes_less(pressed, before), plii_lanes_less(before, pressed));
    const plii_mask4 presses = plii_lanes_both(plii_lanes_either(is_low, was_pressed), differs);
    const plii_vec3x4 push = plii_vec3x4_scale(normal.xyz, plii_float4_sub(pressed, before));
    moved.xyz = plii_vec3x4_select(presses, plii_vec3x4_add(moved.xyz, plii_vec3x4_scale(push, weight)), moved.xyz);
    friction.w = plii_lanes_select(presses, pressed, before);

    const xpbd_rigid_four start_displacements = XPBD_LOAD_NODES(substep->start_displacements, c),
                          motion = XPBD_LOAD_FOUR(c, motion);
    const plii_vec3x4 relative = plii_vec3x4_sub(plii_vec3x4_sub(moved.xyz, start_displacements.xyz), motion.xyz);
    const plii_vec3x4 sliding =
        plii_vec3x4_sub(relative, plii_vec3x4_scale(normal.xyz, plii_vec3x4_dot(relative, normal.xyz)));
    const plii_vec3x4 stopping =
        plii_vec3x4_sub(friction.xyz, plii_vec3x4_scale(sliding, plii_float4_div(plii_float4_all(1.0f), weight)));
    const plii_float4 length = plii_float4_sqrt(plii_vec3x4_dot(stopping, stopping));
    const plii_float4 limit = plii_float4_mul(motion.w, friction.w);
    const plii_vec3x4 rubbed = plii_vec3x4_select(
        plii_lanes_less(limit, length), plii_vec3x4_scale(stopping, plii_float4_div(limit, length)), stopping);
    const plii_mask4 is_finite = plii_lanes_both(
        plii_lanes_finite(rubbed.x), plii_lanes_both(plii_lanes_finite(rubbed.y), plii_lanes_finite(rubbed.z)));
    const plii_mask4 slides = plii_lanes_both(plii_lanes_less(zero, plii_vec3x4_dot(sliding, sliding)), has_weight);
    const plii_mask4 is_rubbed = plii_lanes_either(was_rubbed, plii_lanes_less(zero, friction.w));
    const plii_mask4 rubs = plii_lanes_both(is_rubbed, plii_lanes_both(slides, is_finite));
    const plii_vec3x4 pull = plii_vec3x4_scale(plii_vec3x4_sub(rubbed, friction.xyz), weight);
    moved.xyz = plii_vec3x4_select(rubs, plii_vec3x4_add(moved.xyz, pull), moved.xyz);
    friction.xyz = plii_vec3x4_select(rubs, rubbed, friction.xyz);
    XPBD_STORE_NODES(&moved, substep->displacements, c);
    XPBD_STORE_FOUR(&friction, c, friction);
}

static void xpbd_rigid_contacts_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_rigid_contacts_state* state = data;
    const float alpha = state->def.compliance * substep->inverse_dt * substep->inverse_dt;
    for (int i = 0; i < state->count; ++i) {
        xpbd_rigid_contact* contact = &state->contacts[i];
        if (contact->leads_four) {
            xpbd_rigid_contacts_solve_four(body, substep, alpha, contact);
            i += PLII_LANES - 1;
        } else {
            xpbd_rigid_contacts_solve_one(body, substep, state, contact);
        }
    }
}

static void xpbd_rigid_contacts_disable(pli_body* body, void* data) {
    const xpbd_rigid_contacts_state* state = data;
    plii_release(body->context, state->found, (size_t)state->found_capacity * sizeof *state->found);
    plii_release(body->context, state->contacts, (size_t)state->capacity * sizeof *state->contacts);
}

static size_t xpbd_rigid_contacts_bytes(const pli_body* body, const void* data) {
    const xpbd_rigid_contacts_state* state = data;
    (void)body;
    return (size_t)state->found_capacity * sizeof *state->found + (size_t)state->capacity * sizeof *state->contacts;
}

static void xpbd_rigid_contacts_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                                void** blocks) {
    (void)body;
    (void)change;
    (void)blocks;
    ((xpbd_rigid_contacts_state*)data)->count = 0; /* made anew in each step */
}

static const plii_feature_class xpbd_rigid_contacts_class = {
    .name = "XPBD rigid contacts",
    .state_size = sizeof(xpbd_rigid_contacts_state),
    .disable = xpbd_rigid_contacts_disable,
    .reserve = xpbd_rigid_contacts_preallocate,
    .collide_rigid = xpbd_rigid_contacts_collide,
    .bytes = xpbd_rigid_contacts_bytes,
    .topology_commit = xpbd_rigid_contacts_topology_commit,
};

static bool xpbd_rigid_contacts_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const xpbd_rigid_contacts_state*)data)->count == 0;
}

enum { XPBD_RIGID_CONTACTS_ORDER = 60 }; /* after all that holds the body together and self-collision of nodes */

static const plii_substep_class xpbd_rigid_contacts_kind = {
    .order = XPBD_RIGID_CONTACTS_ORDER,
    .klass = &xpbd_rigid_contacts_class,
    .begin = xpbd_rigid_contacts_begin,
    .restart = xpbd_rigid_contacts_restart,
    .sweep = xpbd_rigid_contacts_sweep,
    .is_idle = xpbd_rigid_contacts_is_idle,
};

pli_status pli_body_enable_xpbd_rigid_contacts(pli_body* body, const pli_xpbd_contacts_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_xpbd_contacts_def used = def != NULL ? *def : pli_xpbd_contacts_def_default();
    PLII_TRY(plii_xpbd_check_contacts_def(body, &used, __func__));
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_rigid_contacts_kind, __func__, &state));
    ((xpbd_rigid_contacts_state*)state)->def = used;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_rigid_contacts(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_rigid_contacts_kind, __func__);
}
