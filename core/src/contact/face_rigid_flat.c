/* Faces that lie flat on a convex shape. Where contacts of their own hold all nodes of a face outside of one plane of
   the shape, no point of the face gets in. Nothing is looked for then: nearest points are what faces at rest would pay
   for. */

#include "contact/face_rigid_impl.h"

#define RIGID_FACES_FLAT 0.9999f       /* cosine of the normals at two nodes */
#define RIGID_FACES_FLAT_DEPTH (-0.1f) /* of the margin, that a node may be deeper */

void plii_rigid_faces_find_held(const pli_body* body, const plii_rigid_faces* state,
                                plii_rigid_faces_candidate* candidate) {
    const plii_rigid_contacts* nodes = body->node_contacts;
    if (nodes == NULL || candidate->shape->triangles != NULL || !plii_rigid_faces_are_solved(body) ||
        nodes->def.compliance > 0.0f || nodes->def.friction != state->def.friction) {
        return;
    }
    int end = nodes->count;
    while (end > 0 && nodes->contacts[end - 1].rigid == candidate->rigid &&
           nodes->contacts[end - 1].shape != candidate->shape_index) {
        --end;
    }
    int begin = end;
    while (begin > 0 && nodes->contacts[begin - 1].rigid == candidate->rigid &&
           nodes->contacts[begin - 1].shape == candidate->shape_index) {
        --begin;
    }
    candidate->held_begin = begin;
    candidate->held_count = end - begin;
}

static const plii_rigid_contact* flat_find(const plii_rigid_faces_pass* pass, int node) {
    const plii_rigid_faces_candidate* candidate = pass->candidate;
    const plii_rigid_contact* contacts = pass->body->node_contacts->contacts + candidate->held_begin;
    int begin = 0, end = candidate->held_count;
    while (begin < end) {
        const int middle = begin + (end - begin) / 2;
        if (contacts[middle].node < node) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    if (begin == candidate->held_count) { return NULL; }
    const plii_rigid_contact* found = &contacts[begin];
    const bool is_it =
        found->node == node && found->rigid == candidate->rigid && found->shape == candidate->shape_index;
    return is_it ? found : NULL;
}

/* Of the plane of its contact, where the step began; and at its end, once that is reached. */
static bool flat_is_outside(const plii_rigid_faces_pass* pass, const plii_rigid_contact* contact) {
    const pli_body* body = pass->body;
    const pli_rigid* rigid = contact->rigid;
    const pli_vec3 n = plii_xyz(contact->normal);
    const float least = RIGID_FACES_FLAT_DEPTH * body->collision_margin;
    const float begin = pli_vec3_dot(n, plii_xyz(body->previous[contact->node])) + contact->normal.w;
    if (!(begin >= least)) { return false; }
    if (!pass->is_at_end) { return true; }
    const pli_vec3 x = plii_xyz(body->positions[contact->node]);
    const pli_vec3 surface = plii_rigid_velocity_at(rigid, pli_vec3_sub(x, pass->begin.origin));
    return pli_vec3_dot(n, x) + contact->normal.w - pli_vec3_dot(n, surface) * body->step.dt >= least;
}

bool plii_rigid_faces_is_flat(const plii_rigid_faces_pass* pass) {
    const plii_rigid_contacts* nodes = pass->body->node_contacts;
    const plii_rigid_faces_candidate* candidate = pass->candidate;
    if (candidate->held_count == 0 || nodes == NULL || candidate->held_begin + candidate->held_count > nodes->count) {
        return false;
    }
    const plii_rigid_contact* first = NULL;
    for (int k = 0; k < 3; ++k) {
        const plii_rigid_contact* contact = flat_find(pass, pass->nodes[k]);
        if (contact == NULL || !flat_is_outside(pass, contact)) { return false; }
        if (first == NULL) { first = contact; }
        if (!(pli_vec3_dot(plii_xyz(first->normal), plii_xyz(contact->normal)) > RIGID_FACES_FLAT)) { return false; }
    }
    return true;
}
