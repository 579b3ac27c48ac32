/* Links on positions: Gauss-Seidel in link order, matching btSoftBody::PSolve_Links bit for bit. */

#include "math/simd_float4.h"

#include "body/body_impl.h"

/* The inverse masses do not change, so they come from memory and not from the lanes that the link before has just
   moved. */
void plii_links_sweep(pli_body* body, void* state) {
    (void)state;
    pli_vec4* restrict positions = body->positions;
    const plii_link* restrict links = body->links;
    const plii_link_tag* restrict tags = body->link_tags;
    const pli_material* restrict materials = body->materials;
    const int count = body->link_count;
    for (int i = 0; i < count; ++i) {
        pli_vec4 *first = &positions[links[i].nodes[0]], *second = &positions[links[i].nodes[1]];
        const int material = tags != NULL ? tags[i] & (PLII_LINK_TAG_BENDING - 1) : 0;
        const float mass_term = (first->w + second->w) / materials[material].linear_stiffness;
        if (!(mass_term > 0.0f)) { continue; }
        const plii_float4 a = plii_float4_from(first), b = plii_float4_from(second);
        const plii_float4 delta = b - a;
        const float rest_squared = links[i].rest_length_squared, length_squared = plii_lanes_dot(delta, delta);
        if (!(rest_squared + length_squared > PLII_EPSILON)) { continue; }
        const float k = (rest_squared - length_squared) / (mass_term * (rest_squared + length_squared));
        const plii_float4 move_a = plii_lanes_xyz(delta * plii_float4_all(k * first->w));
        const plii_float4 move_b = plii_lanes_xyz(delta * plii_float4_all(k * second->w));
        plii_float4_to(first, a - move_a);
        plii_float4_to(second, b + move_b);
    }
}

static void links_solve(pli_body* body, void* state) {
    (void)state;
    body->sweep_links(body, body->sweep_links_state);
}

const plii_feature_class plii_links_class = {
    .name = "links",
    .stages[PLII_STAGE_POSITION] = {links_solve, PLII_ORDER_LINKS},
};
