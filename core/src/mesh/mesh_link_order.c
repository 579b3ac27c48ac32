/* Orders of links: btSoftBody::randomizeConstraints, a fixed shuffle, and btSoftBodyHelpers::ReoptimizeLinkOrder. */

#include "mesh/mesh_impl.h"
#include "pliant/bullet_reference.h"

/* By the linear congruential generator of Numerical Recipes. */
#define ORDER_SHUFFLE(type, items, count, seed)                                                                        \
    for (PLII_EACH(type, item, items, count)) {                                                                        \
        (seed) = UINT32_C(1664525) * (seed) + UINT32_C(1013904223);                                                    \
        type* other = (items) + (seed) % (uint32_t)(count);                                                            \
        PLII_SWAP(type, *item, *other);                                                                                \
    }

void plii_mesh_shuffle(pli_mesh* mesh) {
    uint32_t seed = 243703;
    ORDER_SHUFFLE(pli_link, mesh->links, mesh->link_count, seed)
    ORDER_SHUFFLE(pli_face, mesh->faces, mesh->face_count, seed)
    plii_mesh_clear_topology(mesh);
}

pli_status pli_mesh_shuffle_links(pli_mesh* mesh) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    plii_mesh_shuffle(mesh);
    return PLI_OK;
}

/* A link waits for the last earlier link at each of its two nodes. Input 2 * i + k is node k of link i. */
pli_status pli_mesh_interleave_links(pli_mesh* mesh) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    const int count = mesh->link_count;
    plii_scratch scratch = {.context = mesh->context};
    int* written_by = PLII_TAKE(&scratch, int, mesh->node_count);  /* last link so far that moves the node, plus 1 */
    int* first_input = PLII_TAKE(&scratch, int, count);            /* that waits for this link, the latest; plus 1 */
    int* next_input = PLII_TAKE(&scratch, int, (size_t)count * 2); /* the next one in that list; plus 1 */
    int* waiting = PLII_TAKE(&scratch, int, count);                /* inputs that are not ready */
    int* ready = PLII_TAKE(&scratch, int, count);                  /* queue of links without waiting inputs */
    pli_link* links = PLII_TAKE(&scratch, pli_link, count);        /* in the old order */
    const bool ok = !scratch.is_short && count <= (INT_MAX - 1) / 2;
    int ready_count = 0;
    for (int i = 0; ok && i < count; ++i) {
        links[i] = mesh->links[i];
        const int* nodes = links[i].nodes;
        for (int k = 0; k < 2; ++k) {
            const int producer = written_by[nodes[k]];
            if (producer == 0) { continue; }
            next_input[2 * i + k] = first_input[producer - 1];
            first_input[producer - 1] = 2 * i + k + 1;
            ++waiting[i];
        }
        if (waiting[i] == 0) { ready[ready_count++] = i; }
        written_by[nodes[0]] = written_by[nodes[1]] = i + 1;
    }
    for (int i = 0; i < ready_count; ++i) {
        mesh->links[i] = links[ready[i]];
        for (int input = first_input[ready[i]]; input != 0; input = next_input[input - 1]) {
            const int consumer = (input - 1) / 2;
            if (--waiting[consumer] == 0) { ready[ready_count++] = consumer; }
        }
    }
    plii_scratch_free(&scratch);
    PLII_FAIL_IF(!ok, mesh->context, PLI_ERROR_OUT_OF_MEMORY, __func__, "no memory to order %d links", count);
    return PLI_OK;
}
