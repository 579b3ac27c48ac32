/* Nodes between two surfaces that nothing moves, as between two fingers. Where they leave less room than the margins
   take, both cannot be kept: a node that comes out of the one gets into the other one, and would leave a wedge
   sideways, the faster the narrower it is. So each surface gives way by half of what is missing, and what is missing
   presses the node on both of them, for their friction. */

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
    return speed * body->host_dt;
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

static void squeeze_contact(const pli_body* body, plii_rigid_contacts* found, int index) {
    plii_rigid_contact* contact = &found->contacts[index];
    if (!contact->is_fixed) { return; }
    const int node = contact->node;
    int* last = &found->fixed_of_node[node];
    for (int i = *last, end = index; plii_rigid_contacts_has_fixed(found, i, end, node);
         i = found->contacts[i].before) {
        squeeze_node(body, &found->contacts[i], contact);
        end = i;
    }
    contact->before = *last;
    *last = index;
}

void plii_rigid_contacts_squeeze(const pli_body* body, plii_rigid_contacts* found) {
    const plii_rigid_contact* newest = &found->contacts[found->count - 1];
    const bool is_alone = found->contacts[0].rigid == newest->rigid && newest->rigid->shape_count == 1;
    if (!newest->is_fixed || is_alone) { return; }
    for (; found->linked < found->count; ++found->linked) {
        squeeze_contact(body, found, found->linked);
    }
}
