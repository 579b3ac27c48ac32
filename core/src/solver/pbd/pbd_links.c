/* Links on positions: Gauss-Seidel in link order, matching btSoftBody::PSolve_Links bit for bit. */

#include "body/world_state.h"
#include "math/simd_float4.h"

/* One link waits for the other, so what counts is the way from its positions to the next one's. Mass terms are taken a
   link ahead: behind the stores of the link before, their division would wait for these. Along a chain the second node
   is taken as it is, without the way through memory; and sums and factors are in all lanes from the start. */
void plii_links_sweep(pli_body* restrict body, void* state) {
    pli_vec4* restrict positions = body->positions;
    const plii_link* restrict links = body->links;
    const int count = body->link_count;
    const float least = body->world->def.reference_mode ? PLII_EPSILON : 1e-20f; /* m^2 */
    pli_vec4* moved = NULL; /* the second node of the link before, which is at */
    plii_float4 place = plii_float4_all(0.0f);
    float next_mass_term = count > 0 ? plii_link_mass_term(body, 0) : 0.0f;
    for (int i = 0; i < count; ++i) {
        pli_vec4 *first = &positions[links[i].nodes[0]], *second = &positions[links[i].nodes[1]];
        const float mass_term = next_mass_term;
        if (i + 1 < count) { next_mass_term = plii_link_mass_term(body, i + 1); }
        if (!(mass_term > 0.0f)) { continue; }
        const plii_float4 a = first == moved ? place : plii_float4_from(first), b = plii_float4_from(second);
        const plii_float4 delta = b - a, squares = delta * delta;
        const plii_float4 length_squared =
            plii_lanes_all_x(squares) + plii_lanes_all_y(squares) + plii_lanes_all_z(squares);
        const plii_float4 rest_squared = plii_float4_all(links[i].rest_length_squared);
        const plii_float4 sum = rest_squared + length_squared;
        if (!(plii_lanes_first(sum) > least)) { continue; }
        const plii_float4 missing = plii_lanes_xyz(rest_squared - length_squared);
        const plii_float4 k = missing / (plii_float4_all(mass_term) * sum);
        place = b + delta * (k * plii_float4_all(second->w));
        moved = second;
        plii_float4_to(first, a - delta * (k * plii_float4_all(first->w)));
        plii_float4_to(second, place);
    }
}

void plii_links_run(pli_body* body, void* state) {
    body->sweep_links(body, body->sweep_links_state);
}

const plii_feature_class plii_links_class = {
    .name = "links",
    .stages[PLII_STAGE_POSITION] = {plii_links_run, PLII_ORDER_LINKS},
};
