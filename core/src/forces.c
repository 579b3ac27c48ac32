/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "body_impl.h"

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

const plii_feature_class plii_forces_class = {
    .name = "forces", .enable = forces_enable, .disable = forces_disable, .bytes = forces_bytes};
