/* How the faces of a body hang together, and a tree over them. */

#include "math/simd_float4.h"

#include "base/edge_map.h"
#include "base/union_find.h"
#include "contact/soft_surface.h"
#include "geometry/bvh.h"

#include <string.h>

/* Neighbours in space one after the other, along the curve that the tree sorts by. */
static bool soft_surface_sort(const pli_body* body, plii_soft_surface* surface) {
    pli_context* context = body->context;
    const int face_count = body->topology->face_count;
    plii_bvh tree = {0};
    const size_t size = (size_t)face_count * sizeof(pli_bounds);
    pli_bounds* boxes = plii_allocate(context, size);
    for (int i = 0; boxes != NULL && i < face_count; ++i) {
        boxes[i] = plii_soft_surface_face_bounds(body->positions, body->topology->faces[i]);
    }
    const bool is_sorted = boxes != NULL && plii_bvh_build(context, &tree, face_count, boxes);
    if (is_sorted) { memcpy(surface->order, tree.items, (size_t)face_count * sizeof *surface->order); }
    plii_bvh_free(context, &tree);
    plii_release(context, boxes, size);
    return is_sorted;
}

/* Flags of an edge: who has it. */
enum { SOFT_EDGE_FORWARD = 1, SOFT_EDGE_BACKWARD = 2, SOFT_EDGE_SHARED = 4, SOFT_EDGE_TWISTED = 8 };

static bool soft_surface_add_edges(const plii_topology* topology, plii_edge_map* map) {
    for (int i = 0; i < topology->face_count; ++i) {
        const int* face = topology->faces[i];
        for (int k = 0; k < 3; ++k) {
            const int a = face[k], b = face[(k + 1) % 3];
            plii_edge* edge = plii_edge_map_add(map, a, b);
            if (edge == NULL) { return false; }
            *(edge->first == PLI_NULL_INDEX ? &edge->first : &edge->node) = i;
            const unsigned way = a < b ? SOFT_EDGE_FORWARD : SOFT_EDGE_BACKWARD;
            unsigned* flags = &edge->flags;
            if ((*flags & (SOFT_EDGE_FORWARD | SOFT_EDGE_BACKWARD)) != 0) {
                *flags |= (*flags & (way | SOFT_EDGE_SHARED)) != 0 ? SOFT_EDGE_TWISTED : 0u;
                *flags |= SOFT_EDGE_SHARED;
            }
            *flags |= way;
        }
    }
    return true;
}

static bool soft_surface_is_one_piece(const plii_topology* topology, int* parents, int node_count) {
    plii_union_start(node_count, parents);
    for (int i = 0; i < topology->face_count; ++i) {
        plii_union_join(parents, topology->faces[i][0], topology->faces[i][1]);
        plii_union_join(parents, topology->faces[i][0], topology->faces[i][2]);
    }
    const int piece = plii_union_root(parents, topology->faces[0][0]);
    for (int i = 1; i < topology->face_count; ++i) {
        if (plii_union_root(parents, topology->faces[i][0]) != piece) { return false; }
    }
    return true;
}

static bool soft_surface_has_loose_nodes(const plii_topology* topology, int* counts, int node_count) {
    memset(counts, 0, (size_t)node_count * sizeof *counts);
    for (int i = 0; i < topology->face_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            counts[topology->faces[i][k]] = 1;
        }
    }
    for (int i = 0; i < node_count; ++i) {
        if (counts[i] == 0) { return true; }
    }
    return false;
}

static void soft_surface_take_edges(const pli_body* body, const plii_edge_map* map, plii_soft_surface* surface) {
    const plii_topology* topology = body->topology;
    bool has_rim = false;
    for (int i = 0; i < topology->face_count; ++i) {
        const int* face = topology->faces[i];
        for (int k = 0; k < 3; ++k) {
            const plii_edge* edge = plii_edge_map_find(map, face[k], face[(k + 1) % 3]);
            const int neighbor = edge->first == i ? edge->node : edge->first;
            surface->neighbors[i][k] = neighbor;
            has_rim |= neighbor == PLI_NULL_INDEX;
            if ((edge->flags & SOFT_EDGE_TWISTED) != 0) { surface->is_whole = false; }
        }
    }
    surface->is_closed = surface->is_whole && !has_rim;
    surface->is_inward = surface->is_closed && plii_body_volume(body) < 0.0f;
}

static bool soft_surface_prepare(const pli_body* body, plii_soft_surface* surface) {
    pli_context* context = body->context;
    const plii_topology* topology = body->topology;
    const int face_count = topology->face_count;
    plii_edge_map map = {.table.context = context};
    const size_t parents_size = (size_t)body->node_count * sizeof(int);
    int* parents = plii_allocate(context, parents_size);
    const bool has_room = parents != NULL && soft_surface_add_edges(topology, &map) &&
                          PLII_RESERVE(context, &surface->order, &surface->order_capacity, face_count) &&
                          PLII_RESERVE(context, &surface->neighbors, &surface->neighbor_capacity, face_count) &&
                          soft_surface_sort(body, surface);
    if (has_room) {
        surface->is_whole = soft_surface_is_one_piece(topology, parents, body->node_count);
        soft_surface_take_edges(body, &map, surface);
        surface->has_loose_nodes = soft_surface_has_loose_nodes(topology, parents, body->node_count);
        surface->face_count = face_count;
    }
    plii_release(context, parents, parents_size);
    plii_edge_map_free(&map);
    return has_room;
}

bool plii_soft_surface_reserve(const pli_body* body, plii_soft_surface* surface) {
    pli_context* context = body->context;
    const int face_count = body->topology->face_count;
    return (surface->face_count == face_count || soft_surface_prepare(body, surface)) &&
           PLII_RESERVE(context, &surface->boxes, &surface->box_capacity, face_count) &&
           PLII_RESERVE(context, &surface->hits, &surface->hit_capacity, face_count) &&
           PLII_RESERVE(context, &surface->near_nodes, &surface->near_capacity, body->node_count) &&
           plii_bvh4_reserve(context, &surface->tree, face_count);
}

static pli_vec3 soft_surface_mean_motion(const pli_body* body) {
    plii_float4 sum = plii_float4_all(0.0f);
    for (int i = 0; i < body->node_count; ++i) {
        sum = plii_float4_add(
            sum, plii_float4_sub(plii_float4_from(&body->positions[i]), plii_float4_from(&body->previous[i])));
    }
    pli_vec3 motion;
    plii_lanes_to_vec3(&motion, sum);
    return pli_vec3_scale(motion, 1.0f / (float)body->node_count);
}

/* Boxes of the tree whose faces are looked at together: of level 2 and so 64 faces would be too wide, single faces too
   many. */
enum { SOFT_SURFACE_NEAR_LEVEL = 1, SOFT_SURFACE_NEAR_FACES = 4 };

void plii_soft_surface_find_near(const pli_body* body, plii_soft_surface* surface, const plii_soft_surface* other,
                                 float reach) {
    const plii_bvh4* tree = &surface->tree;
    const int face_count = body->topology->face_count;
    if (surface->has_loose_nodes || tree->level_count <= SOFT_SURFACE_NEAR_LEVEL) {
        memset(surface->near_nodes, 1, (size_t)body->node_count);
        return;
    }
    memset(surface->near_nodes, 0, (size_t)body->node_count);
    for (int i = 0; i * SOFT_SURFACE_NEAR_FACES < face_count; ++i) {
        const plii_box4* group = &tree->groups[tree->begin[SOFT_SURFACE_NEAR_LEVEL] + i / 4];
        const int lane = i % 4;
        const pli_bounds box = {
            {group->low[0][lane] - reach, group->low[1][lane] - reach, group->low[2][lane] - reach},
            {group->high[0][lane] + reach, group->high[1][lane] + reach, group->high[2][lane] + reach}};
        if (!plii_bvh4_touches(&other->tree, &box)) { continue; }
        for (int k = SOFT_SURFACE_NEAR_FACES * i; k < SOFT_SURFACE_NEAR_FACES * (i + 1) && k < face_count; ++k) {
            const int* face = body->topology->faces[surface->order[k]];
            surface->near_nodes[face[0]] = surface->near_nodes[face[1]] = surface->near_nodes[face[2]] = 1;
        }
    }
}

static float soft_surface_inverse_mass(const pli_body* body) {
    float mass = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const float inverse_mass = body->positions[i].w;
        if (!(inverse_mass > 0.0f) || (body->anchored != NULL && body->anchored[i] != 0)) { return 0.0f; }
        mass += 1.0f / inverse_mass;
    }
    return 1.0f / mass;
}

bool plii_soft_surface_place(const pli_body* body, plii_soft_surface* surface) {
    if (surface->is_placed) { return true; }
    const int face_count = body->topology->face_count;
    surface->inverse_mass = soft_surface_inverse_mass(body);
    surface->motion = soft_surface_mean_motion(body);
    if (!plii_soft_surface_reserve(body, surface)) { return false; }
    if (face_count > 0) {
        for (int i = 0; i < face_count; ++i) {
            const int* face = body->topology->faces[surface->order[i]];
            const plii_float4 a = plii_float4_from(&body->positions[face[0]]);
            const plii_float4 b = plii_float4_from(&body->positions[face[1]]);
            const plii_float4 c = plii_float4_from(&body->positions[face[2]]);
            plii_lanes_to_vec3(&surface->boxes[i].min, plii_lanes_min(a, plii_lanes_min(b, c)));
            plii_lanes_to_vec3(&surface->boxes[i].max, plii_lanes_max(a, plii_lanes_max(b, c)));
        }
        if (!plii_bvh4_build(body->context, &surface->tree, face_count, surface->boxes)) { return false; }
    }
    surface->is_placed = true;
    return true;
}
