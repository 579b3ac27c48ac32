/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "math/simd_float4.h"

#include "body/body_impl.h"

#include <string.h>

static pli_status forces_enable(pli_body* body, void* state) {
    (void)state;
    body->forces = plii_allocate(body->context, (size_t)body->node_count * sizeof *body->forces);
    return body->forces != NULL ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static size_t forces_bytes(const pli_body* body, const void* state) {
    (void)state;
    return (size_t)body->node_count * sizeof *body->forces;
}

static void forces_disable(pli_body* body, void* state) {
    plii_release(body->context, body->forces, forces_bytes(body, state));
    body->forces = NULL;
}

static int forces_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                  size_t* sizes) {
    (void)state;
    sizes[0] = (size_t)change->node_count * sizeof *body->forces;
    return 1;
}

static void forces_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    (void)state;
    const size_t old_size = (size_t)change->old_node_count * sizeof *body->forces;
    memcpy(blocks[0], body->forces, old_size);
    plii_release(body->context, body->forces, old_size);
    body->forces = blocks[0];
}

const plii_feature_class plii_forces_class = {
    .name = "forces",
    .enable = forces_enable,
    .disable = forces_disable,
    .bytes = forces_bytes,
    .topology_blocks = forces_topology_blocks,
    .topology_commit = forces_topology_commit,
};

void plii_forces_add_along_normals(pli_body* body, float scale) {
    const plii_float4 zero = plii_float4_all(0.0f), all_scale = plii_float4_all(scale);
    const pli_vec4* restrict positions = body->positions;
    const pli_vec3* restrict normals = body->normals;
    const float* restrict areas = body->areas;
    pli_vec3* restrict forces = body->forces;
    const int count = body->node_count;
    int i = 0;
    for (; i + PLII_LANES <= count; i += PLII_LANES) {
        const plii_vec3x4 force = plii_vec3x4_from(&forces[i]);
        const plii_float4 share = plii_float4_mul(plii_float4_load(&areas[i]), all_scale);
        const plii_vec3x4 added = plii_vec3x4_scale(plii_vec3x4_from(&normals[i]), share);
        const plii_mask4 is_free = plii_lanes_less(
            zero, plii_lanes_xyzw(positions[i].w, positions[i + 1].w, positions[i + 2].w, positions[i + 3].w));
        plii_vec3x4_to(&forces[i], plii_vec3x4_select(is_free, plii_vec3x4_add(force, added), force));
    }
    for (; i < count; ++i) {
        if (!(positions[i].w > 0.0f)) { continue; }
        forces[i] = pli_vec3_add(forces[i], pli_vec3_scale(normals[i], areas[i] * scale));
    }
}
