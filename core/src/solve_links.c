/* Links on positions: Gauss-Seidel in link order, matching btSoftBody::PSolve_Links bit for bit. */

#include "body_impl.h"

void plii_links_sweep(pli_body* body, void* state) {
    (void)state;
    pli_vec4* restrict positions = body->positions;
    const plii_link* restrict links = body->links;
    for (int i = 0; i < body->link_count; ++i) {
        const plii_link link = links[i];
        const float mass_term = plii_link_mass_term(body, i);
        if (!(mass_term > 0.0f)) { continue; }
        pli_vec4* a = &positions[link.nodes[0]];
        pli_vec4* b = &positions[link.nodes[1]];
        const pli_vec3 delta = pli_vec3_sub(plii_xyz(*b), plii_xyz(*a));
        const float length_squared = pli_vec3_length_squared(delta);
        if (!(link.rest_length_squared + length_squared > PLII_EPSILON)) { continue; }
        const float k =
            (link.rest_length_squared - length_squared) / (mass_term * (link.rest_length_squared + length_squared));
        plii_set_xyz(a, pli_vec3_sub(plii_xyz(*a), pli_vec3_scale(delta, k * a->w)));
        plii_set_xyz(b, pli_vec3_add(plii_xyz(*b), pli_vec3_scale(delta, k * b->w)));
    }
}

static void links_solve(pli_body* body, void* state, const plii_step* step) {
    (void)state;
    (void)step;
    body->sweep_links(body, body->sweep_links_state);
}

const plii_feature_class plii_links_class = {
    .name = "links",
    .stages[PLII_STAGE_POSITION] = {links_solve, PLII_ORDER_LINKS},
};
