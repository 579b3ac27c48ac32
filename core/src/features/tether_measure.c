/* Distances along a body: nodes hand theirs on to their neighbours, the nearest first (Dijkstra), along links and
   across faces as in Novotni and Klein, "Computing Geodesic Distances on Triangular Meshes": two nodes whose distances
   are known tell where the origin is once their face is laid flat, and the third is straight away from it if the line
   to it passes between the two. A node that is found nearer later hands on once more. */

#include "features/tether_measure.h"

/* Of the length: what rounding makes of equal ones must not go round for ever. */
#define TETHER_LEAST_GAIN 1e-5f

static float edge_length(const plii_tether_surface* surface, int a, int b) {
    float length = INFINITY;
    for (int k = surface->link_begin[a]; k < surface->link_begin[a + 1]; ++k) {
        const plii_half_link half = surface->halves[k];
        if (half.neighbour == b && !plii_link_is_bending(surface->body, half.link)) {
            length = plii_min(length, sqrtf(surface->body->links[half.link].rest_length_squared));
        }
    }
    return length;
}

static void surface_fill_faces(const plii_tether_surface* surface) {
    const plii_topology* topology = surface->body->topology;
    for (int f = 0; f < topology->face_count; ++f) {
        const int* nodes = topology->faces[f];
        float* lengths = surface->edges[f];
        for (int k = 0; k < 3; ++k) {
            lengths[k] = edge_length(surface, nodes[k], nodes[(k + 1) % 3]);
        }
        if (lengths[1] == INFINITY || lengths[2] == INFINITY) { lengths[0] = INFINITY; }
    }
    plii_csr_sort(surface->body->node_count, 3 * topology->face_count, topology->faces[0], surface->face_begin,
                  surface->corners);
}

plii_tether_surface plii_tether_surface_create(const pli_body* body, plii_scratch* scratch) {
    const int node_count = body->node_count, face_count = body->topology->face_count;
    plii_tether_surface surface = {
        .body = body,
        .link_begin = PLII_TAKE(scratch, int, node_count + 1),
        .halves = PLII_TAKE(scratch, plii_half_link, 2 * (size_t)body->link_count),
        .face_begin = PLII_TAKE(scratch, int, node_count + 1),
        .corners = PLII_TAKE(scratch, int, 3 * (size_t)face_count),
        .edges = PLII_TAKE(scratch, float[3], face_count),
        .front = PLII_TAKE(scratch, int, node_count),
        .waits = PLII_TAKE(scratch, bool, node_count),
    };
    if (scratch->is_short) { return surface; }
    plii_csr_half_links(node_count, body->link_count, body->links, sizeof *body->links, surface.link_begin,
                        surface.halves);
    if (face_count > 0) { surface_fill_faces(&surface); }
    return surface;
}

/* New, or nearer than it was. */
static void front_add(plii_tether_surface* surface, int node) {
    if (surface->waits[node]) { return; }
    const int place = surface->front_first + surface->front_count++, room = surface->body->node_count;
    surface->front[place < room ? place : place - room] = node;
    surface->waits[node] = true;
}

static int front_take(plii_tether_surface* surface) {
    const int node = surface->front[surface->front_first++];
    if (surface->front_first == surface->body->node_count) { surface->front_first = 0; }
    surface->front_count -= 1;
    surface->waits[node] = false;
    return node;
}

static void tether_shorten(plii_tether_surface* surface, pli_tether* tethers, int node, int origin, float length) {
    if (!(length < tethers[node].length * (1.0f - TETHER_LEAST_GAIN))) { return; }
    tethers[node] = (pli_tether){origin, length};
    front_add(surface, node);
}

/* From a and b across their face to c. With a at 0 and b on the x axis the origin is below it, and c above. */
static void tether_cross(plii_tether_surface* surface, pli_tether* tethers, const int nodes[3], const float edges[3]) {
    const pli_tether *a = &tethers[nodes[0]], *b = &tethers[nodes[1]];
    const float ab = edges[0], bc = edges[1], ca = edges[2];
    if (a->origin == PLI_NULL_INDEX || a->origin != b->origin || !(ab > 0.0f)) { return; }
    const float origin_x = 0.5f * (ab + (a->length - b->length) * (a->length + b->length) / ab);
    const float x = 0.5f * (ab + (ca - bc) * (ca + bc) / ab);
    const float origin_y2 = (a->length - origin_x) * (a->length + origin_x), y2 = (ca - x) * (ca + x);
    if (!(origin_y2 > 0.0f && y2 > 0.0f)) { return; }
    const float below = sqrtf(origin_y2), height = below + sqrtf(y2), sideways = x - origin_x;
    const float passes = origin_x * height + sideways * below; /* of the edge, times the height */
    if (!(passes >= 0.0f && passes <= ab * height)) { return; }
    tether_shorten(surface, tethers, nodes[2], a->origin, sqrtf(sideways * sideways + height * height));
}

static void tether_pass_face(plii_tether_surface* surface, pli_tether* tethers, int node, int face) {
    const int* corners = surface->body->topology->faces[face];
    const float* edges = surface->edges[face];
    const int a = corners[0] == node ? 0 : corners[1] == node ? 1 : 2, b = (a + 1) % 3, c = (a + 2) % 3;
    if (edges[0] == INFINITY) { return; }
    tether_cross(surface, tethers, (int[]){node, corners[b], corners[c]}, (float[]){edges[a], edges[b], edges[c]});
    tether_cross(surface, tethers, (int[]){corners[c], node, corners[b]}, (float[]){edges[c], edges[a], edges[b]});
}

void plii_tether_measure(plii_tether_surface* surface, pli_tether* tethers) {
    const pli_body* body = surface->body;
    for (int i = 0; i < body->node_count; ++i) {
        if (tethers[i].origin == i) { front_add(surface, i); }
    }
    while (surface->front_count > 0) {
        const int node = front_take(surface);
        const pli_tether here = tethers[node];
        for (int k = surface->link_begin[node]; k < surface->link_begin[node + 1]; ++k) {
            const plii_half_link half = surface->halves[k];
            if (plii_link_is_bending(body, half.link)) { continue; }
            const float length = sqrtf(body->links[half.link].rest_length_squared);
            tether_shorten(surface, tethers, half.neighbour, here.origin, here.length + length);
        }
        for (int k = surface->face_begin[node]; k < surface->face_begin[node + 1]; ++k) {
            tether_pass_face(surface, tethers, node, surface->corners[k] / 3);
        }
    }
}
