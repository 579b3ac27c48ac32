/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "lanes.h"

#include "body_impl.h"

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
    const plii_float4 zero = plii_float4_all(0.0f);
    for (int i = 0; i < body->node_count; ++i) {
        const plii_float4 force = plii_lanes_from_vec3(&body->forces[i]);
        const plii_float4 added =
            plii_float4_mul(plii_lanes_from_vec3(&body->normals[i]), plii_float4_all(body->areas[i] * scale));
        const plii_mask4 is_free = plii_lanes_less(zero, plii_float4_all(body->positions[i].w));
        plii_lanes_to_vec3(&body->forces[i], plii_lanes_select(is_free, plii_float4_add(force, added), force));
    }
}
