/* Bending links: a link between every two nodes at a given distance in the graph of the present links. Gives the links
   of btSoftBody::generateBendingConstraints in the same order, from one breadth-first search per node instead of a
   table of all pairs. */

#include "mesh_impl.h"

#include <limits.h>

typedef struct bending_work {
    pli_context* context;
    int node_count, half_edge_count;
    int* begin;      /* [node_count + 1] first neighbour of each node */
    int* neighbours; /* [half_edge_count] */
    int* stamps;     /* [node_count] source of the search that saw the node last, plus 1 */
    int* queue;      /* [node_count] */
    int* counts;     /* [node_count + 1] new links per smaller node, then their first place */
    int (*pairs)[2]; /* [pair_count] smaller node, larger node, ordered by the larger */
    int pair_count, pair_capacity;
} bending_work;

static void bending_destroy(bending_work* work) {
    const size_t per_node = (size_t)work->node_count * sizeof(int);
    plii_release(work->context, work->begin, per_node + sizeof(int));
    plii_release(work->context, work->neighbours, (size_t)work->half_edge_count * sizeof(int));
    plii_release(work->context, work->stamps, per_node);
    plii_release(work->context, work->queue, per_node);
    plii_release(work->context, work->counts, per_node + sizeof(int));
    plii_release(work->context, work->pairs, (size_t)work->pair_capacity * sizeof *work->pairs);
}

/* Neighbour lists of all nodes, one behind the other. */
static bool bending_create(bending_work* work, const pli_mesh* mesh) {
    if (mesh->link_count > INT_MAX / 2) { return false; }
    const size_t per_node = (size_t)mesh->node_count * sizeof(int);
    *work = (bending_work){
        .context = mesh->context, .node_count = mesh->node_count, .half_edge_count = 2 * mesh->link_count};
    work->begin = plii_allocate(mesh->context, per_node + sizeof(int));
    work->neighbours = plii_allocate(mesh->context, (size_t)work->half_edge_count * sizeof(int));
    work->stamps = plii_allocate(mesh->context, per_node);
    work->queue = plii_allocate(mesh->context, per_node);
    work->counts = plii_allocate(mesh->context, per_node + sizeof(int));
    if (work->begin == NULL || work->neighbours == NULL || work->stamps == NULL || work->queue == NULL ||
        work->counts == NULL) {
        return false;
    }
    for (int i = 0; i < mesh->link_count; ++i) {
        ++work->begin[mesh->links[i].nodes[0]];
        ++work->begin[mesh->links[i].nodes[1]];
    }
    int sum = 0;
    for (int i = 0; i <= mesh->node_count; ++i) {
        sum += i < mesh->node_count ? work->begin[i] : 0;
        work->begin[i] = sum;
    }
    for (int i = 0; i < mesh->link_count; ++i) {
        const int* n = mesh->links[i].nodes;
        work->neighbours[--work->begin[n[0]]] = n[1];
        work->neighbours[--work->begin[n[1]]] = n[0];
    }
    return true;
}

/* Notes all smaller nodes at `distance` links from `source`. */
static bool bending_search(bending_work* work, int source, int distance) {
    int first = 0, last = 1; /* nodes of the present depth in the queue */
    work->queue[0] = source;
    work->stamps[source] = source + 1;
    for (int depth = 0; depth < distance && first < last; ++depth) {
        const int level_end = last;
        for (; first < level_end; ++first) {
            const int node = work->queue[first];
            for (int k = work->begin[node]; k < work->begin[node + 1]; ++k) {
                const int next = work->neighbours[k];
                if (work->stamps[next] == source + 1) { continue; }
                work->stamps[next] = source + 1;
                work->queue[last++] = next;
            }
        }
    }
    for (; first < last; ++first) {
        const int other = work->queue[first];
        if (other > source) { continue; }
        if (work->pair_count == INT_MAX ||
            !PLII_RESERVE(work->context, &work->pairs, &work->pair_capacity, work->pair_count + 1)) {
            return false;
        }
        work->pairs[work->pair_count][0] = other;
        work->pairs[work->pair_count++][1] = source;
        ++work->counts[other + 1];
    }
    return true;
}

pli_status pli_mesh_append_bending_links(pli_mesh* mesh, int distance, int material, int* added) {
    PLII_TRY(plii_check_mesh(mesh));
    PLII_TRY(plii_check_mesh_material(mesh, material, __func__));
    if (distance < 2) {
        return PLII_FAIL(mesh->context, PLI_ERROR_INVALID_VALUE, "the distance is %d, it must be 2 or more", distance);
    }
    int pair_count = 0;
    if (mesh->link_count > 0) {
        bending_work work = {0};
        bool ok = bending_create(&work, mesh);
        for (int i = 0; ok && i < mesh->node_count; ++i) {
            ok = bending_search(&work, i, distance);
        }
        ok = ok && plii_mesh_reserve(mesh, 0, work.pair_count, 0, 0);
        if (ok) {
            pair_count = work.pair_count;
            for (int i = 0; i < mesh->node_count; ++i) {
                work.counts[i + 1] += work.counts[i];
            }
            pli_link* links = mesh->links + mesh->link_count;
            for (int i = 0; i < pair_count; ++i) { /* a stable sort by the smaller node */
                const int* pair = work.pairs[i];
                links[work.counts[pair[0]]++] =
                    (pli_link){.nodes = {pair[1], pair[0]}, .material = material, .is_bending = true};
            }
            mesh->link_count += pair_count;
        }
        bending_destroy(&work);
        if (!ok) {
            return PLII_FAIL(mesh->context, PLI_ERROR_OUT_OF_MEMORY,
                             "no memory for the bending links of %d nodes and %d links", mesh->node_count,
                             mesh->link_count);
        }
    }
    if (added != NULL) { *added = pair_count; }
    return PLI_OK;
}
