/* Nodes between two surfaces that nothing moves, as between two fingers. Where they leave less room than the margins
   take, both cannot be kept: a node that comes out of the one gets into the other one, and would leave a wedge
   sideways, the faster the narrower it is. So each surface gives way by half of what is missing, and what is missing
   presses the node on both of them, for their friction. */

#include "body/rigid_lanes.h"
#include "body/world_state.h"
#include "contact/node_rigid_impl.h"

/* Cosine between the normals of two surfaces that a node is between. */
#define RIGID_SQUEEZE_FACING (-0.8f)

/* What presses the node, as a motion that is stopped, in what is missing: the surfaces are firm. */
#define RIGID_SQUEEZE_FIRMNESS 4.0f

static float squeeze_gap(const plii_rigid_contact* contact, const pli_vec4* x) {
    return pli_vec3_dot(plii_xyz(contact->normal), plii_xyz(*x)) + contact->normal.w;
}

static float squeeze_approach(const pli_body* body, const plii_rigid_contact* contact) {
    const pli_vec3 arm = pli_vec3_sub(plii_xyz(body->positions[contact->node]), contact->rigid->state.pose.origin);
    const float speed = pli_vec3_dot(plii_xyz(contact->normal), plii_rigid_velocity_at(contact->rigid, arm));
    return speed * body->step.dt;
}

static void squeeze_node(const pli_body* body, plii_rigid_contact* a, plii_rigid_contact* b) {
    if (!(pli_vec3_dot(plii_xyz(a->normal), plii_xyz(b->normal)) < RIGID_SQUEEZE_FACING)) { return; }
    const pli_vec4* x = &body->previous[a->node];
    const float gap_a = squeeze_gap(a, x), gap_b = squeeze_gap(b, x);
    const float missing = squeeze_approach(body, a) + squeeze_approach(body, b) - gap_a - gap_b;
    if (!(missing > 0.0f)) { return; }
    a->squeeze += RIGID_SQUEEZE_FIRMNESS * missing;
    b->squeeze += RIGID_SQUEEZE_FIRMNESS * missing;
    if (!plii_follows_rigids(body)) { return; } /* solvers of whole systems choose what gives way */
    a->normal.w += 0.5f * missing;
    b->normal.w += 0.5f * missing;
}

/* The end of the contacts with one shape in ascending order of nodes. */
static int squeeze_run_end(const plii_rigid_contacts* found, int begin, int end) {
    const plii_rigid_contact* contacts = found->contacts;
    int i = begin + 1;
    while (i < end && contacts[i].rigid == contacts[begin].rigid && contacts[i].shape == contacts[begin].shape &&
           contacts[i].node > contacts[i - 1].node) {
        ++i;
    }
    return i;
}

static bool squeeze_are_near(const pli_body* body, const plii_rigid_contact* a, const plii_rigid_contact* b) {
    const plii_shape_place *of_a = &a->rigid->shape_places[a->shape], *of_b = &b->rigid->shape_places[b->shape];
    const plii_float4 margins = plii_float4_all(2.0f * body->collision_margin);
    const plii_mask4 overlap =
        (of_a->bounds.low - margins <= of_b->bounds.high) & (of_b->bounds.low <= of_a->bounds.high + margins);
    return plii_rigid_is_fixed(a->rigid) && (plii_lanes_bits(overlap) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

static void squeeze_runs(const pli_body* body, plii_rigid_contact* a, const plii_rigid_contact* a_end,
                         plii_rigid_contact* b, const plii_rigid_contact* b_end) {
    if (!squeeze_are_near(body, a, b)) { return; }
    while (a < a_end && b < b_end) {
        if (a->node == b->node) { squeeze_node(body, a, b); }
        if (a->node <= b->node) {
            ++a;
        } else {
            ++b;
        }
    }
}

void plii_rigid_contacts_squeeze(const pli_body* body, plii_rigid_contacts* found, int first) {
    plii_rigid_contact* contacts = found->contacts;
    if (!plii_rigid_is_fixed(contacts[first].rigid)) { return; }
    for (int b = first, b_end; b < found->count; b = b_end) {
        b_end = squeeze_run_end(found, b, found->count);
        for (int a = 0, a_end; a < b; a = a_end) {
            a_end = squeeze_run_end(found, a, b);
            squeeze_runs(body, &contacts[a], &contacts[a_end], &contacts[b], &contacts[b_end]);
        }
    }
}
