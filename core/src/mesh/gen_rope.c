/* A chain of nodes on a segment, in the operation order of btSoftBodyHelpers::CreateRope. */

#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

pli_status pli_mesh_create_rope(pli_context* context, pli_vec3 from, pli_vec3 to, int inner_nodes, int pins,
                                pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    const pli_vec3 ends[2] = {from, to};
    PLII_TRY(plii_check_finite_points(context, 2, ends, "point", __func__));
    PLII_TRY(plii_check_int(context, inner_nodes, 0, INT_MAX, "the number of inner nodes", __func__));
    PLII_FAIL_IF((pins & ~(PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST)) != 0, context, PLI_ERROR_INVALID_VALUE, __func__,
                 "the pins 0x%x name ends that a rope does not have", (unsigned)pins);
    const int64_t wanted = (int64_t)inner_nodes + 2;
    PLII_TRY(plii_mesh_create_reserved(context, wanted, wanted - 1, 0, 0, __func__, mesh));
    pli_mesh* made = *mesh;
    const int count = (int)wanted;
    for (int i = 0; i < count; ++i) {
        const float t = (float)i / (float)(count - 1);
        plii_mesh_push_node(made, plii_clamp_point(pli_vec3_lerp(from, to, t)), 1.0f);
    }
    if ((pins & PLI_ROPE_PIN_FIRST) != 0) { made->inverse_masses[0] = 0.0f; }
    if ((pins & PLI_ROPE_PIN_LAST) != 0) { made->inverse_masses[count - 1] = 0.0f; }
    for (int i = 1; i < count; ++i) {
        plii_mesh_push_link(made, i - 1, i);
    }
    return PLI_OK;
}
