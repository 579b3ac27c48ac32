/* Clusters from the mesh: groups of near nodes, or one per element. Bullet: generateClusters. */

#include "base/csr.h"
#include "body/pipeline.h"
#include "cluster/cluster_impl.h"

/* Everything that one generation needs besides the clusters themselves. */
typedef struct generate_work {
    plii_scratch scratch;
    int group_count;
    float tolerance;    /* m^2, see generate_tolerance */
    int* group_of_node; /* [node_count] */
    int* node_order;    /* [node_count] nodes of one group after the other, in the order they joined */
    int* group_begin;   /* [group_count + 1] into node_order */
    pli_vec3* centres;  /* [group_count] */
    int* corner_groups; /* [3 * face_count] of the nodes of all faces, */
    int* corners;       /* and these group by group, in the order of faces */
    int* corner_begin;  /* [group_count + 1] into them */
    int* members;       /* [node_count] of the group in work */
    int* listed_in1;    /* [node_count] the last group, + 1, that got the node as one beyond its own */
    int* order;         /* [group_count + 1] of the clusters: group, or -1 for all nodes */
} generate_work;

/* m^2: what centres move at most when they have come to rest. Bullet's is the same for bodies of any size; one of a few
   centimetres would keep the groups that it starts with, of nodes from all over the body. */
static float generate_tolerance(const pli_body* body, bool reference_mode) {
    const pli_bounds all = plii_body_bounds_of(body, body->positions);
    const float size_squared = pli_vec3_length_squared(pli_vec3_sub(all.max, all.min));
    return reference_mode ? PLII_EPSILON : PLII_EPSILON * plii_min(size_squared, 1.0f);
}

/* Moves the centre of each group that has nodes towards their mean, past it while `over_relaxation` > 1. */
static bool generate_move_centres(const pli_body* body, generate_work* g, float over_relaxation) {
    bool changed = false;
    for (int i = 0; i < g->group_count; ++i) {
        pli_vec3 mean = pli_vec3_make(0, 0, 0);
        const int begin = g->group_begin[i], end = g->group_begin[i + 1];
        if (begin == end) { continue; }
        for (int k = begin; k < end; ++k) {
            mean = pli_vec3_add(mean, plii_xyz(body->positions[g->node_order[k]]));
        }
        mean = plii_vec3_divide(mean, (float)(end - begin));
        const pli_vec3 old = g->centres[i];
        const pli_vec3 moved = pli_vec3_add(old, pli_vec3_scale(pli_vec3_sub(mean, old), over_relaxation));
        changed = changed || pli_vec3_length_squared(pli_vec3_sub(moved, old)) > g->tolerance;
        g->centres[i] = moved;
    }
    return changed;
}

static float generate_distance(pli_vec3 a, pli_vec3 b) {
    const pli_vec3 d = pli_vec3_sub(a, b);
    return fabsf(d.x) + fabsf(d.y) + fabsf(d.z);
}

static void generate_assign_nodes(const pli_body* body, generate_work* g) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        int best = 0;
        float best_distance = generate_distance(g->centres[0], x);
        for (int k = 1; k < g->group_count; ++k) {
            const float distance = generate_distance(g->centres[k], x);
            if (distance < best_distance) {
                best = k;
                best_distance = distance;
            }
        }
        g->group_of_node[i] = best;
    }
}

/* k-means with the metric |dx| + |dy| + |dz| from a fixed start, over-relaxed in the first 16 rounds. */
static void generate_group_nodes(const pli_body* body, generate_work* g, int max_iterations) {
    pli_vec3 centroid = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < body->node_count; ++i) {
        centroid = pli_vec3_add(centroid, plii_xyz(body->positions[i]));
        g->group_of_node[i] = (int)((int64_t)i * 29873 % g->group_count);
    }
    centroid = plii_vec3_divide(centroid, (float)body->node_count);
    for (int i = 0; i < g->group_count; ++i) {
        g->centres[i] = centroid;
    }
    bool changed = true;
    for (int round = 0; changed && round < max_iterations; ++round) {
        plii_csr_sort(g->group_count, body->node_count, g->group_of_node, g->group_begin, g->node_order);
        changed = generate_move_centres(body, g, 2.0f - plii_min(1.0f, (float)round / 16.0f));
        generate_assign_nodes(body, g);
    }
    plii_csr_sort(g->group_count, body->node_count, g->group_of_node, g->group_begin, g->node_order);
}

/* All nodes, of group -1; else the group's, then those that share a face with one of them. Returns their number. */
static int generate_list_members(const pli_body* body, generate_work* g, int group) {
    int count = 0;
    if (group < 0) {
        for (; count < body->node_count; ++count) {
            g->members[count] = count;
        }
        return count;
    }
    for (int k = g->group_begin[group]; k < g->group_begin[group + 1]; ++k) {
        g->members[count++] = g->node_order[k];
    }
    for (int k = g->corner_begin[group]; k < g->corner_begin[group + 1]; ++k) {
        const int* face = body->topology->faces[g->corners[k] / 3];
        for (int q = 1; q < 3; ++q) {
            const int node = face[(g->corners[k] + q) % 3];
            if (g->group_of_node[node] == group || g->listed_in1[node] == group + 1) { continue; }
            g->listed_in1[node] = group + 1;
            g->members[count++] = node;
        }
    }
    return count;
}

/* Clusters of the groups that have nodes. With several groups a cluster of all nodes comes first and the first group
   last; empty groups are filled by the last cluster that there is, as a removal by swapping leaves it. */
static pli_status generate_append_clusters(pli_body* body, generate_work* g, plii_clusters* clusters) {
    int count = g->group_count > 1 ? g->group_count + 1 : 1;
    int* order = g->order;
    for (int i = 0; i < g->group_count; ++i) {
        order[i] = i;
    }
    if (count > 1) {
        order[count - 1] = 0;
        order[0] = -1;
    }
    for (int i = 0; i < count;) {
        if (order[i] >= 0 && g->group_begin[order[i]] == g->group_begin[order[i] + 1]) {
            order[i] = order[--count];
            continue;
        }
        PLII_TRY(plii_clusters_append(body, clusters, g->members, generate_list_members(body, g, order[i])));
        if (order[i++] < 0) { clusters->items[clusters->count - 1].settings.collides = false; }
    }
    return PLI_OK;
}

static pli_status generate_run(pli_body* body, generate_work* g, int max_iterations, plii_clusters* clusters) {
    const int corner_count = 3 * body->topology->face_count;
    g->group_of_node = PLII_TAKE(&g->scratch, int, body->node_count);
    g->node_order = PLII_TAKE(&g->scratch, int, body->node_count);
    g->group_begin = PLII_TAKE(&g->scratch, int, (size_t)g->group_count + 1);
    g->centres = PLII_TAKE(&g->scratch, pli_vec3, g->group_count);
    g->members = PLII_TAKE(&g->scratch, int, body->node_count);
    g->order = PLII_TAKE(&g->scratch, int, (size_t)g->group_count + 1);
    g->corner_groups = PLII_TAKE(&g->scratch, int, corner_count);
    g->corners = PLII_TAKE(&g->scratch, int, corner_count);
    g->corner_begin = PLII_TAKE(&g->scratch, int, (size_t)g->group_count + 1);
    g->listed_in1 = PLII_TAKE(&g->scratch, int, body->node_count);
    if (g->scratch.is_short) { return PLI_ERROR_OUT_OF_MEMORY; }
    g->tolerance = generate_tolerance(body, clusters->def.reference_mode);
    generate_group_nodes(body, g, max_iterations);
    for (int c = 0; c < corner_count; ++c) {
        g->corner_groups[c] = g->group_of_node[body->topology->faces[c / 3][c % 3]];
    }
    plii_csr_sort(g->group_count, corner_count, g->corner_groups, g->corner_begin, g->corners);
    return generate_append_clusters(body, g, clusters);
}

static pli_status generate_elements(pli_body* body, plii_clusters* clusters) {
    const plii_topology* topology = body->topology;
    for (int i = 0; i < topology->tetra_count; ++i) {
        PLII_TRY(plii_clusters_append(body, clusters, topology->tetras[i], 4));
    }
    for (int i = 0; topology->tetra_count == 0 && i < topology->face_count; ++i) {
        PLII_TRY(plii_clusters_append(body, clusters, topology->faces[i], 3));
    }
    return PLI_OK;
}

/* Makes the new clusters beside the old ones and swaps them in when all went well. `count` 0: from elements. */
static pli_status generate_replace(pli_body* body, int count, int max_iterations, int* made, const char* function) {
    PLII_TRY_ENABLE(body, plii_clusters, clusters, plii_clusters_class);
    plii_clusters fresh = {.def = clusters->def, .node_sums = clusters->node_sums};
    pli_status status;
    if (count > 0) {
        generate_work g = {.scratch = {.context = body->context}, .group_count = count};
        status = generate_run(body, &g, max_iterations, &fresh);
        plii_scratch_free(&g.scratch);
    } else {
        status = generate_elements(body, &fresh);
    }
    if (status != PLI_OK) {
        plii_clusters_release(body, &fresh);
        return PLII_FAIL_ENABLED(body, plii_clusters_class, function, "no memory for the clusters of %d nodes",
                                 body->node_count);
    }
    PLII_TRY(pli_body_remove_clusters(body));
    *clusters = fresh;
    plii_clusters_settle(body, clusters, 0);
    if (made != NULL) { *made = clusters->count; }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_generate_clusters(pli_body* body, int count, int max_iterations, int* made) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_FAIL_IF(count < 1 || max_iterations < 1, body->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "%d clusters, %d iterations: at least 1 of each", count, max_iterations);
    const int used = count < body->node_count ? count : body->node_count;
    return generate_replace(body, used, max_iterations, made, __func__);
}

pli_status pli_body_generate_clusters_from_elements(pli_body* body, int* made) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_FAIL_IF(body->topology->tetra_count == 0 && body->topology->face_count == 0, body->context,
                 PLI_ERROR_INVALID_MESH, __func__, "the body has neither tetrahedra nor faces");
    return generate_replace(body, 0, 0, made, __func__);
}
