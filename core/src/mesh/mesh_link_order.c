/* Orders of links: btSoftBody::randomizeConstraints, a fixed shuffle, and btSoftBodyHelpers::ReoptimizeLinkOrder. */

#include "mesh/mesh_impl.h"
#include "pliant/bullet_reference.h"

#include <string.h>

/* By the linear congruential generator of Numerical Recipes. */
#define ORDER_SHUFFLE(type, items, count, seed)                                                                        \
    for (PLII_EACH(type, item, items, count)) {                                                                        \
        (seed) = UINT32_C(1664525) * (seed) + UINT32_C(1013904223);                                                    \
        type *other = (items) + (seed) % (uint32_t)(count), swapped = *item;                                           \
        *item = *other;                                                                                                \
        *other = swapped;                                                                                              \
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
typedef struct order_work {
    int* written_by;  /* [node_count] last link so far that moves the node, plus 1 */
    int* first_input; /* [link_count] inputs that wait for this link, latest first; plus 1 */
    int* next_input;  /* [2 * link_count] the next one in that list; plus 1 */
    int* waiting;     /* [link_count] inputs that are not ready */
    int* ready;       /* [link_count] queue of links without waiting inputs */
    pli_link* links;  /* [link_count] copy in the old order */
} order_work;

static void order_run(pli_mesh* mesh, order_work* work) {
    int ready_count = 0;
    for (int i = 0; i < mesh->link_count; ++i) {
        for (int k = 0; k < 2; ++k) {
            const int producer = work->written_by[mesh->links[i].nodes[k]];
            if (producer == 0) { continue; }
            work->next_input[2 * i + k] = work->first_input[producer - 1];
            work->first_input[producer - 1] = 2 * i + k + 1;
            ++work->waiting[i];
        }
        if (work->waiting[i] == 0) { work->ready[ready_count++] = i; }
        work->written_by[mesh->links[i].nodes[0]] = work->written_by[mesh->links[i].nodes[1]] = i + 1;
    }
    for (int i = 0; i < ready_count; ++i) {
        mesh->links[i] = work->links[work->ready[i]];
        for (int input = work->first_input[work->ready[i]]; input != 0; input = work->next_input[input - 1]) {
            const int consumer = (input - 1) / 2;
            if (--work->waiting[consumer] == 0) { work->ready[ready_count++] = consumer; }
        }
    }
}

pli_status pli_mesh_interleave_links(pli_mesh* mesh) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    if (mesh->link_count == 0) { return PLI_OK; }
    const size_t links_size = (size_t)mesh->link_count * sizeof(pli_link);
    plii_scratch scratch = {.context = mesh->context};
    order_work work = {
        .written_by = PLII_TAKE(&scratch, int, mesh->node_count),
        .first_input = PLII_TAKE(&scratch, int, mesh->link_count),
        .next_input = PLII_TAKE(&scratch, int, (size_t)mesh->link_count * 2),
        .waiting = PLII_TAKE(&scratch, int, mesh->link_count),
        .ready = PLII_TAKE(&scratch, int, mesh->link_count),
        .links = plii_scratch_take(&scratch, links_size),
    };
    const bool ok = !scratch.is_short && mesh->link_count <= (INT_MAX - 1) / 2;
    if (ok) { memcpy(work.links, mesh->links, links_size); }
    if (ok) { order_run(mesh, &work); }
    plii_scratch_free(&scratch);
    PLII_FAIL_IF(!ok, mesh->context, PLI_ERROR_OUT_OF_MEMORY, __func__, "no memory to order %d links",
                 mesh->link_count);
    return PLI_OK;
}
