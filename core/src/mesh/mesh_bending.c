/* Bending links: a link between every two nodes at a given distance in the graph of the present links, in the order of
   btSoftBody::generateBendingConstraints. Two breadth-first searches per node in place of a table of all pairs. */

#include "base/csr.h"
#include "mesh/mesh_impl.h"

#include <stdlib.h>

typedef struct bending_work {
    plii_scratch scratch;
    int node_count;
    int* begin;             /* [node_count + 1] first neighbour of each node */
    plii_half_link* halves; /* [2 * link_count] */
    int* stamps;            /* [node_count] of the search that saw the node last */
    int* queue;             /* [node_count] */
} bending_work;

/* Neighbour lists of all nodes, one behind the other. */
static bool bending_create(bending_work* work, const pli_mesh* mesh) {
    if (mesh->link_count > INT_MAX / 2) { return false; }
    *work = (bending_work){.scratch = {.context = mesh->context}, .node_count = mesh->node_count};
    work->begin = PLII_TAKE(&work->scratch, int, (size_t)mesh->node_count + 1);
    work->halves = PLII_TAKE(&work->scratch, plii_half_link, (size_t)mesh->link_count * 2);
    work->stamps = PLII_TAKE(&work->scratch, int, mesh->node_count);
    work->queue = PLII_TAKE(&work->scratch, int, mesh->node_count);
    if (work->scratch.is_short) { return false; }
    plii_csr_half_links(mesh->node_count, mesh->link_count, mesh->links, sizeof *mesh->links, work->begin,
                        work->halves);
    return true;
}

static int bending_compare(const void* a, const void* b) {
    const int *first = a, *second = b;
    return (*first > *second) - (*first < *second);
}

/* All nodes at `distance` links from `source` that are larger, in any order: how many, and where in the queue. Each
   search has its own stamp, not 0. */
static int bending_search(bending_work* work, int source, int distance, int stamp, int** found) {
    int first = 0, last = 1; /* nodes of the present depth in the queue */
    work->queue[0] = source;
    work->stamps[source] = stamp;
    for (int depth = 0; depth < distance && first < last; ++depth) {
        const int level_end = last;
        for (; first < level_end; ++first) {
            const int node = work->queue[first];
            for (int k = work->begin[node]; k < work->begin[node + 1]; ++k) {
                const int next = work->halves[k].neighbour;
                if (work->stamps[next] == stamp) { continue; }
                work->stamps[next] = stamp;
                work->queue[last++] = next;
            }
        }
    }
    int count = 0;
    *found = &work->queue[first];
    for (; first < last; ++first) {
        const int other = work->queue[first];
        if (other > source) { (*found)[count++] = other; }
    }
    return count;
}

/* Without a mesh links are only counted, so that they need no memory but their own. More than INT_MAX: too many. */
static int64_t bending_append(bending_work* work, pli_mesh* mesh, int distance, int material) {
    int64_t count = 0;
    int* found = NULL;
    for (int i = 0; i < work->node_count && count <= INT_MAX; ++i) {
        const int own = bending_search(work, i, distance, mesh == NULL ? i + 1 : -i - 1, &found);
        count += own;
        if (mesh == NULL) { continue; }
        qsort(found, (size_t)own, sizeof *found, bending_compare);
        for (int k = 0; k < own; ++k) {
            mesh->links[mesh->link_count++] =
                (pli_link){.nodes = {found[k], i}, .material = material, .is_bending = true};
        }
    }
    return count;
}

pli_status pli_mesh_append_bending_links(pli_mesh* mesh, int distance, int material, int* added) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_mesh_material(mesh, material, __func__));
    PLII_TRY(plii_check_int(mesh->context, distance, 2, INT_MAX, "the distance", __func__));
    const int old_count = mesh->link_count;
    if (old_count > 0) {
        bending_work work = {0};
        bool has_room = bending_create(&work, mesh);
        if (has_room) {
            const int64_t count = bending_append(&work, NULL, distance, material);
            has_room = count <= INT_MAX - old_count && plii_mesh_reserve(mesh, 0, (int)count, 0, 0);
        }
        if (has_room) { (void)bending_append(&work, mesh, distance, material); }
        plii_scratch_free(&work.scratch);
        PLII_FAIL_IF(!has_room, mesh->context, PLI_ERROR_OUT_OF_MEMORY, __func__,
                     "no memory for the bending links of %d nodes and %d links", mesh->node_count, old_count);
    }
    if (added != NULL) { *added = mesh->link_count - old_count; }
    return PLI_OK;
}
