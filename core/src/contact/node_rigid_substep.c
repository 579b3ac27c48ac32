/* Contacts of nodes with rigid bodies in substeps. C = n . (node - motion of the surface) + offset >= 0, with Coulomb
   friction on the motion of the substep. They were found at the predicted positions; their planes move with the rigid
   body. */

#include "math/simd_float4.h"

#include "body/substep_rigid.h"
#include "contact/contact_substep.h"
#include "contact/node_rigid_impl.h"

/* Records of four floats, so that four contacts with fixed bodies are solved at a time. */
struct plii_rigid_substep_contact {
    pli_vec4 normal; /* w: offset of the plane that is kept free, at the start of the step */
    /* For one substep; the first two of a fixed body, whose motion nothing changes. */
    pli_vec4 surface;  /* how far it is moved at the end; w: lowest gap */
    pli_vec4 motion;   /* w: coefficient of friction */
    pli_vec4 friction; /* w: multiplier */
    plii_substep_rigid_point point;
    float weight;
    int node;
    bool is_fixed, leads_four; /* this contact and the next three have fixed bodies and ascending nodes */
};

bool plii_rigid_substeps_reserve(pli_body* body, plii_rigid_substeps* substeps, int count) {
    return PLII_RESERVE(body->context, &substeps->contacts, &substeps->capacity, count);
}

size_t plii_rigid_substeps_bytes(const plii_rigid_substeps* substeps) {
    return (size_t)substeps->capacity * sizeof *substeps->contacts;
}

void plii_rigid_substeps_release(pli_body* body, void* data) {
    plii_rigid_substeps* substeps = &((plii_rigid_contacts*)data)->substeps;
    plii_release(body->context, substeps->contacts, plii_rigid_substeps_bytes(substeps));
    *substeps = (plii_rigid_substeps){0};
}

static bool rigid_substep_is_fixed(const pli_rigid* rigid) {
    const pli_mat3 inverse_inertia = rigid->state.inverse_inertia_world;
    float sum = rigid->state.inverse_mass;
    for (int k = 0; k < 3; ++k) {
        sum += fabsf(inverse_inertia.rows[k].x) + fabsf(inverse_inertia.rows[k].y) + fabsf(inverse_inertia.rows[k].z);
    }
    return sum == 0.0f;
}

static void rigid_substep_begin(pli_body* body, void* data) {
    const plii_rigid_contacts* found = data;
    plii_rigid_substeps* state = &((plii_rigid_contacts*)data)->substeps;
    const bool has_room = plii_rigid_substeps_reserve(body, state, found->count);
    state->count = has_room ? found->count : state->capacity;
    for (int i = 0; i < state->count; ++i) {
        const plii_rigid_contact* from = &found->contacts[i];
        const pli_vec3 x = plii_xyz(body->positions[from->node]);
        plii_rigid_substep_contact* contact = &state->contacts[i];
        *contact = (plii_rigid_substep_contact){.node = from->node};
        plii_set_xyz(&contact->normal, plii_xyz(from->normal));
        contact->normal.w = from->matrix[PLII_RIGID_CONTACT_DISTANCE].w - pli_vec3_dot(plii_xyz(from->normal), x);
        contact->motion.w = found->def.friction * from->rigid->friction;
        contact->is_fixed = rigid_substep_is_fixed(from->rigid);
        contact->point.rigid = from->rigid;
        contact->point.offset = pli_vec3_sub(x, from->rigid->state.pose.origin);
    }
    for (int i = 0; i + PLII_LANES <= state->count; ++i) {
        plii_rigid_substep_contact* c = &state->contacts[i];
        c->leads_four = c[0].is_fixed && c[1].is_fixed && c[2].is_fixed && c[3].is_fixed && c[0].node < c[1].node &&
                        c[1].node < c[2].node && c[2].node < c[3].node;
    }
}

/* Along a unit vector. */
static float rigid_substep_weight(const plii_substep* substep, const plii_rigid_substep_contact* contact,
                                  pli_vec3 direction) {
    const float weight = substep->displacements[contact->node].w;
    return contact->is_fixed ? weight : weight + plii_substep_rigid_point_weight(&contact->point, direction);
}

static pli_vec3 rigid_substep_motion(const plii_substep* substep, const plii_rigid_substep_contact* contact) {
    return contact->is_fixed ? plii_xyz(contact->motion) : plii_substep_rigid_point_motion(&contact->point, substep);
}

static void rigid_substep_restart_one(pli_body* body, const plii_substep* substep, plii_rigid_substep_contact* contact,
                                      float recovery_speed) {
    plii_substep_rigid_point_restart(&contact->point, substep);
    const pli_vec3 before =
        pli_vec3_add(plii_xyz(body->positions[contact->node]), plii_xyz(substep->start_displacements[contact->node]));
    const pli_vec3 normal = plii_xyz(contact->normal), moved = contact->point.moved;
    const float gap = pli_vec3_dot(normal, pli_vec3_sub(before, moved)) + contact->normal.w;
    contact->surface.w = plii_contact_recover(substep, contact->node, normal, gap, 1.0f, recovery_speed);
    contact->weight = rigid_substep_weight(substep, contact, normal);
    contact->friction = (pli_vec4){0};
    if (!contact->is_fixed) { return; }
    const pli_vec3 motion = plii_substep_rigid_point_motion(&contact->point, substep);
    plii_set_xyz(&contact->motion, motion);
    plii_set_xyz(&contact->surface, pli_vec3_add(moved, motion));
}

/* Of four contacts, or of their nodes. */
typedef struct rigid_substep_four {
    plii_vec3x4 xyz;
    plii_float4 w;
} rigid_substep_four;

PLII_SIMD_INLINE rigid_substep_four rigid_substep_load_four(const pli_vec4* a, const pli_vec4* b, const pli_vec4* c,
                                                            const pli_vec4* d) {
    plii_float4 r[PLII_LANES] = {plii_float4_from(a), plii_float4_from(b), plii_float4_from(c), plii_float4_from(d)};
    plii_float4_transpose(r);
    return (rigid_substep_four){{r[0], r[1], r[2]}, r[3]};
}
PLII_SIMD_INLINE void rigid_substep_store_four(const rigid_substep_four* four, pli_vec4* a, pli_vec4* b, pli_vec4* c,
                                               pli_vec4* d) {
    plii_float4 r[PLII_LANES] = {four->xyz.x, four->xyz.y, four->xyz.z, four->w};
    plii_float4_transpose(r);
    plii_float4_to(a, r[0]);
    plii_float4_to(b, r[1]);
    plii_float4_to(c, r[2]);
    plii_float4_to(d, r[3]);
}
#define RIGID_SUBSTEP_LOAD_FOUR(c, field)                                                                              \
    rigid_substep_load_four(&(c)[0].field, &(c)[1].field, &(c)[2].field, &(c)[3].field)
#define RIGID_SUBSTEP_STORE_FOUR(four, c, field)                                                                       \
    rigid_substep_store_four(four, &(c)[0].field, &(c)[1].field, &(c)[2].field, &(c)[3].field)
#define RIGID_SUBSTEP_LOAD_NODES(records, c)                                                                           \
    rigid_substep_load_four(&(records)[(c)[0].node], &(records)[(c)[1].node], &(records)[(c)[2].node],                 \
                            &(records)[(c)[3].node])
#define RIGID_SUBSTEP_STORE_NODES(four, records, c)                                                                    \
    rigid_substep_store_four(four, &(records)[(c)[0].node], &(records)[(c)[1].node], &(records)[(c)[2].node],          \
                             &(records)[(c)[3].node])

/* rigid_substep_restart_one after the first substep: the surface begins where it ended. */
static void rigid_substep_restart_four(const pli_body* body, const plii_substep* substep, plii_rigid_substep_contact* c,
                                       float recovery_speed) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const rigid_substep_four normal = RIGID_SUBSTEP_LOAD_FOUR(c, normal), motion = RIGID_SUBSTEP_LOAD_FOUR(c, motion);
    const rigid_substep_four x = RIGID_SUBSTEP_LOAD_NODES(body->positions, c);
    rigid_substep_four start_displacements = RIGID_SUBSTEP_LOAD_NODES(substep->start_displacements, c);
    rigid_substep_four surface = RIGID_SUBSTEP_LOAD_FOUR(c, surface);
    const plii_vec3x4 before = plii_vec3x4_add(x.xyz, start_displacements.xyz);
    const plii_float4 gap =
        plii_float4_add(plii_vec3x4_dot(normal.xyz, plii_vec3x4_sub(before, surface.xyz)), normal.w);
    const plii_mask4 recovers =
        plii_lanes_both(plii_lanes_less(gap, zero), plii_lanes_less(zero, start_displacements.w));
    surface.w = plii_lanes_min(gap, zero);
    if (plii_lanes_bits(recovers) != 0) {
        rigid_substep_four displacement = RIGID_SUBSTEP_LOAD_NODES(substep->displacements, c);
        const plii_float4 shift =
            plii_lanes_min(plii_float4_negate(gap), plii_float4_all(recovery_speed * substep->dt));
        const plii_vec3x4 shifts = plii_vec3x4_scale(normal.xyz, shift);
        displacement.xyz = plii_vec3x4_select(recovers, plii_vec3x4_add(displacement.xyz, shifts), displacement.xyz);
        start_displacements.xyz =
            plii_vec3x4_select(recovers, plii_vec3x4_add(start_displacements.xyz, shifts), start_displacements.xyz);
        surface.w = plii_lanes_select(recovers, plii_float4_add(gap, shift), surface.w);
        RIGID_SUBSTEP_STORE_NODES(&displacement, substep->displacements, c);
        RIGID_SUBSTEP_STORE_NODES(&start_displacements, substep->start_displacements, c);
    }
    surface.xyz = plii_vec3x4_add(surface.xyz, motion.xyz);
    RIGID_SUBSTEP_STORE_FOUR(&surface, c, surface);
    for (int k = 0; k < PLII_LANES; ++k) {
        c[k].friction = (pli_vec4){0};
    }
}

static void rigid_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    const plii_rigid_contacts* found = data;
    const plii_rigid_substeps* state = &found->substeps;
    const float recovery_speed = plii_contact_recovery_speed(found->def.recovery_speed);
    for (int i = 0; i < state->count; ++i) {
        plii_rigid_substep_contact* contact = &state->contacts[i];
        if (contact->leads_four && substep->index > 0) {
            rigid_substep_restart_four(body, substep, contact, recovery_speed);
            i += PLII_LANES - 1;
        } else {
            rigid_substep_restart_one(body, substep, contact, recovery_speed);
        }
    }
}

static void rigid_substep_push(const plii_substep* substep, const plii_rigid_substep_contact* contact, pli_vec3 push) {
    plii_substep_move(substep, contact->node, push, 1.0f);
    if (!contact->is_fixed) { plii_substep_rigid_point_push(&contact->point, pli_vec3_neg(push), substep); }
}

static void rigid_substep_press(pli_body* body, const plii_substep* substep, float alpha,
                                plii_rigid_substep_contact* contact) {
    const pli_vec3 surface = contact->is_fixed
                                 ? plii_xyz(contact->surface)
                                 : pli_vec3_add(contact->point.moved, rigid_substep_motion(substep, contact));
    const pli_vec3 to_node = pli_vec3_sub(plii_substep_position(body, substep, contact->node), surface);
    const pli_vec3 normal = plii_xyz(contact->normal);
    const float gap = pli_vec3_dot(normal, to_node) + contact->normal.w, floor = contact->surface.w;
    const float before = contact->friction.w;
    if (before == 0.0f && !(gap < floor)) { return; }
    const float change = plii_contact_multiplier(gap - floor, contact->weight, alpha, before);
    const float multiplier = plii_max(0.0f, before + change);
    if (multiplier == before) { return; }
    rigid_substep_push(substep, contact, pli_vec3_scale(normal, multiplier - before));
    contact->friction.w = multiplier;
}

static void rigid_substep_rub(const plii_substep* substep, plii_rigid_substep_contact* contact) {
    const pli_vec3 n = plii_xyz(contact->normal), before = plii_xyz(contact->friction);
    const pli_vec3 motion =
        pli_vec3_sub(plii_substep_motion(substep, contact->node), rigid_substep_motion(substep, contact));
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    const float length = pli_vec3_length(sliding);
    if (!(length > 0.0f) || !(contact->weight > 0.0f)) { return; }
    const float weight = rigid_substep_weight(substep, contact, pli_vec3_scale(sliding, 1.0f / length));
    const pli_vec3 friction = plii_contact_friction(before, sliding, weight, contact->motion.w * contact->friction.w);
    if (!plii_vec3_is_finite(friction)) { return; }
    rigid_substep_push(substep, contact, pli_vec3_sub(friction, before));
    plii_set_xyz(&contact->friction, friction);
}

static void rigid_substep_solve_one(pli_body* body, const plii_substep* substep, float alpha,
                                    plii_rigid_substep_contact* contact) {
    rigid_substep_press(body, substep, alpha, contact);
    const bool rubs = contact->friction.w > 0.0f || pli_vec3_length_squared(plii_xyz(contact->friction)) > 0.0f;
    if (rubs) { rigid_substep_rub(substep, contact); }
}

/* The same for four. `alpha`: see plii_contact_multiplier. */
static void rigid_substep_solve_four(const pli_body* body, const plii_substep* substep, float alpha,
                                     plii_rigid_substep_contact* c) {
    const plii_float4 zero = plii_float4_all(0.0f), alphas = plii_float4_all(alpha);
    const rigid_substep_four x = RIGID_SUBSTEP_LOAD_NODES(body->positions, c);
    rigid_substep_four moved = RIGID_SUBSTEP_LOAD_NODES(substep->displacements, c),
                       friction = RIGID_SUBSTEP_LOAD_FOUR(c, friction);
    const rigid_substep_four normal = RIGID_SUBSTEP_LOAD_FOUR(c, normal), surface = RIGID_SUBSTEP_LOAD_FOUR(c, surface);
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

    const rigid_substep_four start_displacements = RIGID_SUBSTEP_LOAD_NODES(substep->start_displacements, c),
                             motion = RIGID_SUBSTEP_LOAD_FOUR(c, motion);
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
    RIGID_SUBSTEP_STORE_NODES(&moved, substep->displacements, c);
    RIGID_SUBSTEP_STORE_FOUR(&friction, c, friction);
}

static void rigid_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const plii_rigid_contacts* found = data;
    const plii_rigid_substeps* state = &found->substeps;
    const float alpha = found->def.compliance * substep->inverse_dt * substep->inverse_dt;
    for (int i = 0; i < state->count; ++i) {
        plii_rigid_substep_contact* contact = &state->contacts[i];
        if (contact->leads_four) {
            rigid_substep_solve_four(body, substep, alpha, contact);
            i += PLII_LANES - 1;
        } else {
            rigid_substep_solve_one(body, substep, alpha, contact);
        }
    }
}

static bool rigid_substep_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const plii_rigid_contacts*)data)->substeps.count == 0;
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
