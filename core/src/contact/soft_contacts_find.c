/* The search for contacts of nodes with the faces of another soft body. Of each other body a node gets the nearest
   face, of all bodies together the four that it is deepest in. Which side of a body is the node's is remembered from
   step to step: a node that was pushed through is brought back. */

#include "body/pipeline.h"
#include "body/world_state.h"
#include "contact/soft_contacts_impl.h"
#include "geometry/closest_point.h"
#include "math/bounds.h"
#include "math/range.h"

#include <float.h>
#include <string.h>

/* Faces whose doubled area is below this share of the longest edge squared have no normal. */
#define SOFT_CONTACTS_MIN_SHAPE 1e-6f
/* Of the margins: so much further out contacts are made, for nodes that links pull in. */
#define SOFT_CONTACTS_MORE_REACH 0.25f
/* Squared distances to two faces that differ by less than this share are the same: the nearest point is on the edge or
   at the corner between them. */
#define SOFT_CONTACTS_SAME 1e-5f
/* A node with a contact looks at the neighbours of its face, and every so many steps, when it is fast or on the wrong
 * side, at all. */
enum { SOFT_CONTACTS_LOOK_STEPS = 8, SOFT_CONTACTS_MOST_NEIGHBORS = 8 };
/* Edges at the nearest point of a face by what is nearest, bits: corners belong to two edges. */
static const unsigned soft_contacts_edges[7] = {5, 3, 6, 1, 2, 4, 0};

/* Nodes of one body against faces of another. */
typedef struct soft_contacts_pass {
    pli_body* node_body;
    plii_soft_contacts_state* node_state;
    pli_body* face_body;
    plii_soft_contacts_state* face_state;
    float margin;   /* sum of both */
    bool is_inside; /* the nodes' body is wholly within the bounds of the other: it need not get out */
    bool is_second; /* the nodes are those of the second body */
    bool has_met;   /* there is a contact */
} soft_contacts_pass;

// ------------------------------------------------------------------------------------------------------- what was
// before

void plii_soft_contacts_chain(const pli_body* body, plii_soft_contacts_state* state) {
    memset(state->first_contacts, 0xff, (size_t)body->node_count * sizeof *state->first_contacts);
    for (int i = 0; i < state->count; ++i) {
        state->contacts[i].next = state->first_contacts[state->contacts[i].node];
        state->first_contacts[state->contacts[i].node] = i;
    }
    memset(state->first_sides, 0xff, (size_t)body->node_count * sizeof *state->first_sides);
    for (int i = 0; i < state->side_count; ++i) {
        state->sides[i].next = state->first_sides[state->sides[i].node];
        state->first_sides[state->sides[i].node] = i;
    }
}

void plii_soft_contacts_remember(const pli_body* body, plii_soft_contacts_state* state) {
    const bool has_room = PLII_RESERVE(body->context, &state->sides, &state->side_capacity, state->count);
    state->side_count = 0;
    for (int i = 0; has_room && i < state->count; ++i) {
        const plii_soft_contact* contact = &state->contacts[i];
        if (!contact->has_side) { continue; }
        state->sides[state->side_count++] = (plii_soft_side){.body = contact->face_body,
                                                             .node = contact->node,
                                                             .face = contact->face,
                                                             .is_behind = contact->is_behind,
                                                             .is_inherited = contact->is_inherited,
                                                             .normal = plii_xyz(contact->normal)};
    }
    state->count = 0;
    state->step_count = (state->step_count + 1) % SOFT_CONTACTS_LOOK_STEPS;
    plii_soft_contacts_chain(body, state);
}

static const plii_soft_side* soft_contacts_find_side(const soft_contacts_pass* pass, int node) {
    const plii_soft_contacts_state* state = pass->node_state;
    for (int i = state->first_sides[node]; i != PLI_NULL_INDEX; i = state->sides[i].next) {
        if (state->sides[i].body == pass->face_body) { return &state->sides[i]; }
    }
    return NULL;
}

// ------------------------------------------------------------------------------------------------------ the nearest
// face

/* The nearest point of a face to a node. */
typedef struct soft_contacts_place {
    int face; /* PLI_NULL_INDEX: none */
    plii_closest_feature closest;
    pli_vec3 offset; /* from the point to the node */
    pli_vec3 normal; /* of the face, unit */
    float distance_squared;
    float height; /* of the node over the plane of the face */
} soft_contacts_place;

/* Becomes the nearest when the face is nearer, or as near and more across. */
static void soft_contacts_compare(const soft_contacts_pass* pass, pli_vec3 x, int face_index,
                                  soft_contacts_place* nearest) {
    const pli_vec4* positions = pass->face_body->positions;
    const int* face = pass->face_body->topology->faces[face_index];
    const pli_vec3 a = pli_vec3_sub(plii_xyz(positions[face[0]]), x), b = pli_vec3_sub(plii_xyz(positions[face[1]]), x),
                   c = pli_vec3_sub(plii_xyz(positions[face[2]]), x);
    const pli_vec3 ab = pli_vec3_sub(b, a), ac = pli_vec3_sub(c, a), cross = pli_vec3_cross(ab, ac);
    const float area_squared = pli_vec3_length_squared(cross), height = -pli_vec3_dot(a, cross);
    if (height * height > 1.001f * nearest->distance_squared * area_squared) { return; }
    const float longest = plii_max(pli_vec3_length_squared(ab),
                                   plii_max(pli_vec3_length_squared(pli_vec3_sub(c, b)), pli_vec3_length_squared(ac)));
    const float min_area = SOFT_CONTACTS_MIN_SHAPE * longest;
    if (!(area_squared > plii_max(min_area * min_area, FLT_MIN))) { return; }
    soft_contacts_place place = {.face = face_index};
    const pli_vec3 point = plii_closest_point_on_triangle(pli_vec3_make(0, 0, 0), a, b, c, &place.closest);
    place.distance_squared = pli_vec3_length_squared(point);
    if (!(place.distance_squared < nearest->distance_squared * (1.0f + SOFT_CONTACTS_SAME))) { return; }
    const float inverse_area = 1.0f / sqrtf(area_squared);
    place.height = height * inverse_area;
    const bool is_same = place.distance_squared > nearest->distance_squared * (1.0f - SOFT_CONTACTS_SAME);
    if (nearest->face != PLI_NULL_INDEX && is_same && fabsf(place.height) <= fabsf(nearest->height)) { return; }
    place.offset = pli_vec3_neg(point);
    place.normal = pli_vec3_scale(cross, inverse_area);
    *nearest = place;
}

/* From face to face as long as that leads nearer. */
static void soft_contacts_walk(const soft_contacts_pass* pass, pli_vec3 x, soft_contacts_place* nearest) {
    const plii_soft_surface* surface = &pass->face_state->surface;
    for (int i = 0; i < SOFT_CONTACTS_MOST_NEIGHBORS; ++i) {
        const int from = nearest->face;
        const unsigned edges = soft_contacts_edges[nearest->closest.feature];
        for (int k = 0; k < 3; ++k) {
            const int neighbor = (edges >> k & 1u) != 0 ? surface->neighbors[from][k] : PLI_NULL_INDEX;
            if (neighbor != PLI_NULL_INDEX) { soft_contacts_compare(pass, x, neighbor, nearest); }
        }
        if (nearest->face == from) { return; }
    }
}

static soft_contacts_place soft_contacts_nearest(const soft_contacts_pass* pass, int node, float reach,
                                                 const plii_soft_side* side) {
    plii_soft_surface* surface = &pass->face_state->surface;
    const pli_vec3 x = plii_soft_contacts_position(pass->node_body, node);
    soft_contacts_place nearest = {.face = PLI_NULL_INDEX, .distance_squared = INFINITY};
    if (side != NULL) { soft_contacts_compare(pass, x, side->face, &nearest); }
    const int known = nearest.face;
    if (known != PLI_NULL_INDEX) {
        soft_contacts_walk(pass, x, &nearest);
        const bool is_due = node % SOFT_CONTACTS_LOOK_STEPS == pass->node_state->step_count;
        const bool is_outside = side->is_behind ? nearest.height < 0.0f : nearest.height > 0.0f;
        const bool is_near = is_outside && nearest.distance_squared < reach * reach;
        if (is_near && !is_due && reach < 1.5f * pass->margin) { return nearest; }
    } else {
        nearest.distance_squared = reach * reach;
    }
    const float radius = sqrtf(nearest.distance_squared) * (1.0f + SOFT_CONTACTS_SAME);
    const int count = plii_bvh4_find(&surface->tree, x, radius, surface->hits);
    for (int i = 0; i < count; ++i) {
        const int face = surface->order[surface->hits[i]];
        if (face != nearest.face) { soft_contacts_compare(pass, x, face, &nearest); }
    }
    return nearest;
}

/* The nearest point is on a rim, and the node beyond it, where both sides are one. */
static bool soft_contacts_is_beyond_rim(const soft_contacts_pass* pass, const soft_contacts_place* place) {
    const int* neighbors = pass->face_state->surface.neighbors[place->face];
    const unsigned edges = soft_contacts_edges[place->closest.feature];
    bool is_at_rim = false;
    for (int k = 0; k < 3; ++k) {
        is_at_rim |= (edges >> k & 1u) != 0 && neighbors[k] == PLI_NULL_INDEX;
    }
    if (!is_at_rim) { return false; }
    const float across = place->distance_squared - place->height * place->height;
    return across > 0.01f * place->distance_squared;
}

// -------------------------------------------------------------------------------------------------------------
// contacts

/* The side of a node that was not there before: outside of what is closed, else where it was at the start of the step.
   Where it lay on the face then, nodes of the first body go one way and those of the second the other, so that bodies
   in the same place part. */
static bool soft_contacts_starts_behind(const soft_contacts_pass* pass, int node, const soft_contacts_place* place) {
    const plii_soft_surface* surface = &pass->face_state->surface;
    if (surface->is_closed && !pass->is_inside) { return surface->is_inward; }
    const int* face = pass->face_body->topology->faces[place->face];
    const pli_vec3 point = plii_soft_contacts_blend(pass->face_body->previous, face, place->closest.weights);
    const float height = pli_vec3_dot(place->normal, pli_vec3_sub(plii_xyz(pass->node_body->previous[node]), point));
    const float noise = 4.0f * PLII_EPSILON * pli_vec3_length(point);
    return fabsf(height) > noise ? height < 0.0f : pass->is_second;
}

static bool soft_contacts_is_behind(const soft_contacts_pass* pass, int node, const plii_soft_side* side,
                                    const soft_contacts_place* place) {
    if (side == NULL) { return soft_contacts_starts_behind(pass, node, place); }
    if (pass->face_state->surface.is_whole || side->face == place->face) { return side->is_behind; }
    return pli_vec3_dot(side->normal, place->normal) < 0.0f;
}

/* Takes the place of the contact of the node that it is least deep in when it has as many as it may. */
static pli_status soft_contacts_keep(soft_contacts_pass* pass, plii_soft_contact contact) {
    plii_soft_contacts_state* state = pass->node_state;
    int count = 0, last = PLI_NULL_INDEX;
    for (int i = state->first_contacts[contact.node]; i != PLI_NULL_INDEX; i = state->contacts[i].next) {
        ++count;
        if (last == PLI_NULL_INDEX || state->contacts[i].gap > state->contacts[last].gap) { last = i; }
    }
    if (count == PLII_SOFT_CONTACTS_PER_NODE) {
        if (contact.gap < state->contacts[last].gap) {
            pass->has_met = true;
            contact.next = state->contacts[last].next;
            state->contacts[last] = contact;
        }
        return PLI_OK;
    }
    if (!PLII_RESERVE(pass->node_body->context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    pass->has_met = true;
    contact.next = state->first_contacts[contact.node];
    state->first_contacts[contact.node] = state->count;
    state->contacts[state->count++] = contact;
    return PLI_OK;
}

/* m, at the start of the step, along the normal. */
static float soft_contacts_begin_distance(const soft_contacts_pass* pass, int node, const soft_contacts_place* place,
                                          pli_vec3 normal) {
    const int* face = pass->face_body->topology->faces[place->face];
    const pli_vec3 point = plii_soft_contacts_blend(pass->face_body->previous, face, place->closest.weights);
    return pli_vec3_dot(normal, pli_vec3_sub(plii_xyz(pass->node_body->previous[node]), point));
}

static pli_status soft_contacts_meet(soft_contacts_pass* pass, int node, float reach) {
    const plii_soft_side* side = soft_contacts_find_side(pass, node);
    const soft_contacts_place place = soft_contacts_nearest(pass, node, reach, side);
    if (place.face == PLI_NULL_INDEX) { return PLI_OK; }
    const pli_vec3 weights = place.closest.weights;
    const int* face = pass->face_body->topology->faces[place.face];
    const pli_vec4* positions = pass->face_body->positions;
    const pli_vec4 inverse_masses = {positions[face[0]].w * weights.x, positions[face[1]].w * weights.y,
                                     positions[face[2]].w * weights.z, pass->node_body->positions[node].w};
    const float weight =
        inverse_masses.x * weights.x + inverse_masses.y * weights.y + inverse_masses.z * weights.z + inverse_masses.w;
    if (!(weight > 0.0f)) { return PLI_OK; }
    const float distance = sqrtf(place.distance_squared);
    const float noise = 4.0f * PLII_EPSILON * pli_vec3_length(plii_soft_contacts_position(pass->node_body, node));
    const bool is_beyond_rim = distance > noise && soft_contacts_is_beyond_rim(pass, &place);
    const bool is_behind = soft_contacts_is_behind(pass, node, side, &place);
    const bool is_outside =
        is_beyond_rim || (distance > noise && (is_behind ? place.height <= 0.0f : place.height >= 0.0f));
    /* How far it is on the wrong side. */
    if (is_outside && distance > reach) { return PLI_OK; }
    const pli_vec3 normal = is_outside  ? pli_vec3_scale(place.offset, 1.0f / distance)
                            : is_behind ? pli_vec3_neg(place.normal)
                                        : place.normal;
    if (!plii_vec3_is_finite(normal) || !plii_vec3_is_finite(weights)) { return PLI_OK; }
    const bool is_inherited = (side == NULL || side->is_inherited) &&
                              pass->node_state->surface.inverse_mass + pass->face_state->surface.inverse_mass > 0.0f &&
                              soft_contacts_begin_distance(pass, node, &place, normal) < pass->margin;
    const plii_soft_contact contact = {
        .face_body = pass->face_body,
        .node = node,
        .face = place.face,
        .is_behind = is_behind,
        .is_inherited = is_inherited,
        .has_side = side != NULL || !is_beyond_rim,
        .corners = {face[0], face[1], face[2]},
        .weights = {weights.x, weights.y, weights.z, 0},
        .inverse_masses = inverse_masses,
        .weight = weight,
        .normal = {normal.x, normal.y, normal.z, 0},
        .margin = pass->margin,
        .friction = plii_max(pass->node_state->def.friction, pass->face_state->def.friction),
        .gap = (is_outside ? distance : pli_vec3_dot(normal, place.offset)) - pass->margin,
    };
    return soft_contacts_keep(pass, contact);
}

// --------------------------------------------------------------------------------------------------------- finding
// pairs

/* How far a node looks for faces: by its motion against that of their body. */
static float soft_contacts_reach(const soft_contacts_pass* pass, int node) {
    const pli_vec3 motion =
        pli_vec3_sub(plii_soft_contacts_position(pass->node_body, node), plii_xyz(pass->node_body->previous[node]));
    return pass->margin * (1.0f + SOFT_CONTACTS_MORE_REACH) +
           pli_vec3_length(pli_vec3_sub(motion, pass->face_state->surface.motion));
}

/* A node that is far behind may be so from all faces. */
static bool soft_contacts_is_near(const soft_contacts_pass* pass, int node) {
    return pass->node_state->surface.near_nodes[node] != 0 || soft_contacts_find_side(pass, node) != NULL;
}

static pli_status soft_contacts_run_pass(soft_contacts_pass* pass) {
    const pli_body* body = pass->node_body;
    if (pass->face_body->topology->face_count == 0) { return PLI_OK; }
    float most = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        most = plii_max(most, soft_contacts_reach(pass, i));
    }
    plii_soft_surface_find_near(body, &pass->node_state->surface, &pass->face_state->surface, most);
    for (int i = 0; i < body->node_count; ++i) {
        if (!soft_contacts_is_near(pass, i)) { continue; }
        PLII_TRY(soft_contacts_meet(pass, i, soft_contacts_reach(pass, i)));
    }
    return PLI_OK;
}

static bool soft_contacts_is_within(pli_bounds inner, pli_bounds outer) {
    return inner.min.x > outer.min.x && inner.min.y > outer.min.y && inner.min.z > outer.min.z &&
           inner.max.x < outer.max.x && inner.max.y < outer.max.y && inner.max.z < outer.max.z;
}

static pli_status soft_contacts_collide(pli_body* body, plii_soft_contacts_state* state, pli_body* other,
                                        plii_soft_contacts_state* other_state) {
    if (!plii_soft_surface_place(body, &state->surface) || !plii_soft_surface_place(other, &other_state->surface)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    const float margin = body->collision_margin + other->collision_margin;
    soft_contacts_pass passes[2] = {{.node_body = body,
                                     .node_state = state,
                                     .face_body = other,
                                     .face_state = other_state,
                                     .margin = margin,
                                     .is_inside = soft_contacts_is_within(body->bounds, other->bounds)},
                                    {.node_body = other,
                                     .node_state = other_state,
                                     .face_body = body,
                                     .face_state = state,
                                     .margin = margin,
                                     .is_inside = soft_contacts_is_within(other->bounds, body->bounds),
                                     .is_second = true}};
    pli_status status = soft_contacts_run_pass(&passes[0]);
    if (status == PLI_OK) { status = soft_contacts_run_pass(&passes[1]); }
    if (passes[0].has_met || passes[1].has_met) {
        body->is_coupled = other->is_coupled = true;
        state->has_new_contacts = other_state->has_new_contacts = true;
    }
    return status;
}

pli_status plii_soft_contacts_collide(pli_body* body, void* data, pli_body* other, void* other_data) {
    plii_soft_contacts_state *state = data, *other_state = other_data;
    const bool is_reference = state->node_boxes != NULL && other_state->node_boxes != NULL;
    return is_reference ? plii_soft_reference_collide(body, state, other, other_state)
                        : soft_contacts_collide(body, state, other, other_state);
}
