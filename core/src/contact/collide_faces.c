/* Contacts of nodes with the faces of other soft bodies (btSoftColliders::CollideVF_SS) and their position solve
   (btSoftBody::PSolve_SContacts). Given the same pairs of node and face, contacts equal Bullet's bit for bit. They come
   in the order of nodes, then of faces; Bullet's order depends on memory addresses.

   Bodies are solved one after the other, so, as in Bullet, a contact moves the nodes of a body that was solved before
   without changing their velocities.

   Where Bullet is of no use its rule is mended: a node that lies on a face gets the normal of the face instead of NaN,
   and, unless Bullet's boxes are kept, a face is too small by its shape and not by its absolute area. */

#include "math/lanes.h"

#include "body/body_impl.h"
#include "body/pipeline.h"
#include "body/world_impl.h"
#include "contact/contact_order.h"
#include "geometry/box_tree.h"
#include "geometry/closest_point.h"
#include "geometry/fat_box.h"
#include "geometry/near_boxes.h"
#include "math/bounds.h"
#include "math/range.h"
#include "pliant/bullet_reference.h"
#include "pliant/contact.h"

#include <float.h>
#include <string.h>

/* Faces whose doubled area is below this share of the longest edge squared have no normal. */
#define SOFT_CONTACTS_MIN_SHAPE 1e-6f

/* Contacts of a node that lies on a face act along that face when the cosine of their normals is below this. */
#define SOFT_CONTACTS_MIN_ACROSS 0.1f

typedef struct soft_contact {
    pli_body* face_body;
    int node, face;
    pli_vec3 weights;
    pli_vec3 normal; /* from the face to the node */
    float margin, friction;
    float node_share, face_share; /* of the correction. Bullet: cfm */
} soft_contact;

typedef struct soft_contacts_node {
    int node;
    float reach; /* how far it looks for faces; m */
} soft_contacts_node;

typedef struct soft_contacts_state {
    pli_soft_contacts_def def;
    soft_contact* contacts;
    int count, capacity;
    /* Bullet's boxes, or NULL. */
    pli_bounds* node_boxes; /* [node_count] */
    pli_bounds* face_boxes; /* [face_count] */
    bool has_boxes;         /* false: to be taken from the start of the next step */
    /* For the search; kept by the first body of a pair. */
    soft_contacts_node* nodes; /* near the other body */
    int node_count, node_capacity;
    int* faces; /* near them */
    int face_count, face_capacity;
    pli_bounds* boxes; /* of `faces`, and what finds them */
    int box_capacity;
    plii_box_tree tree; /* with Bullet's boxes */
    plii_near_boxes near;
    int* face_order; /* [order_count] own faces, neighbours in space one after the other; 0: not known */
    int order_count, order_capacity;
    int* hits; /* as many as there are boxes */
    int hit_count, hit_capacity;
} soft_contacts_state;

pli_soft_contacts_def pli_soft_contacts_def_default(void) {
    pli_soft_contacts_def def = {0};
    def.friction = 0.2f;
    def.hardness = 1.0f;
    def.cookie = PLII_DEF_COOKIE;
    return def;
}

static const plii_feature_class soft_contacts_class;

static pli_vec3 soft_contacts_position(const pli_body* body, int node) {
    return plii_xyz(body->positions[node]);
}

static pli_bounds soft_contacts_face_bounds(const pli_vec4* positions, const int* face) {
    const pli_vec3 a = plii_xyz(positions[face[0]]), b = plii_xyz(positions[face[1]]), c = plii_xyz(positions[face[2]]);
    const pli_bounds bounds = {plii_vec3_min(a, plii_vec3_min(b, c)), plii_vec3_max(a, plii_vec3_max(b, c))};
    return bounds;
}

// ----------------------------------------------------------------------------------------------- Bullet's boxes

/* Bullet's trees start without margins. */
static void soft_contacts_start_boxes(const pli_body* body, soft_contacts_state* state) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->previous[i]);
        state->node_boxes[i].min = x;
        state->node_boxes[i].max = x;
    }
    for (int i = 0; i < body->topology->face_count; ++i) {
        state->face_boxes[i] = plii_bounds_grow(soft_contacts_face_bounds(body->previous, body->topology->faces[i]),
                                                100.0f * PLII_EPSILON);
    }
    state->has_boxes = true;
}

static void soft_contacts_update_boxes(const pli_body* body, soft_contacts_state* state, const plii_step* step) {
    const float margin = body->collision_margin;
    const float slack = margin * 0.25f;
    const float ahead = step->dt * 3.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = soft_contacts_position(body, i);
        const pli_bounds box = {x, x};
        plii_fat_box_update(&state->node_boxes[i], plii_bounds_grow(box, margin),
                            pli_vec3_scale(plii_xyz(body->velocities[i]), ahead), slack);
    }
    for (int i = 0; i < body->topology->face_count; ++i) {
        const int* face = body->topology->faces[i];
        const pli_vec3 sum =
            pli_vec3_add(pli_vec3_add(plii_xyz(body->velocities[face[0]]), plii_xyz(body->velocities[face[1]])),
                         plii_xyz(body->velocities[face[2]]));
        plii_fat_box_update(&state->face_boxes[i],
                            plii_bounds_grow(soft_contacts_face_bounds(body->positions, face), margin),
                            pli_vec3_scale(plii_vec3_divide(sum, 3.0f), ahead), slack);
    }
}

static void soft_contacts_update(pli_body* body, void* data, const plii_step* step) {
    soft_contacts_state* state = data;
    state->count = 0;
    if (state->node_boxes == NULL) { return; }
    if (!state->has_boxes) { soft_contacts_start_boxes(body, state); }
    soft_contacts_update_boxes(body, state, step);
    body->soft_node_boxes = state->node_boxes;
}

// -------------------------------------------------------------------------------------------------- one candidate

/* Nodes of one body against faces of another. */
typedef struct soft_contacts_pass {
    pli_body* node_body;
    soft_contacts_state* node_state;
    pli_body* face_body;
    soft_contacts_state* face_state;
    soft_contacts_state* search;
    float margin; /* sum of both */
    bool use_boxes;
    bool is_second; /* the nodes are those of the second body */
} soft_contacts_pass;

/* How far a node looks for faces. */
static float soft_contacts_reach(const soft_contacts_pass* pass, int node) {
    const pli_vec3 motion =
        pli_vec3_sub(soft_contacts_position(pass->node_body, node), plii_xyz(pass->node_body->previous[node]));
    return pass->margin + pli_vec3_length(motion) * 2.0f;
}

/* The normal for a node that lies on its face: that of the face, to the side where the node was before. Where it lay on
   the face then, too, nodes of the first body go one way and those of the second the other, so that bodies in the same
   place part. */
static pli_vec3 soft_contacts_face_normal(const soft_contacts_pass* pass, int node, const int* face, pli_vec3 weights) {
    const pli_vec3 a = soft_contacts_position(pass->face_body, face[0]);
    const pli_vec3 cross = pli_vec3_cross(pli_vec3_sub(soft_contacts_position(pass->face_body, face[1]), a),
                                          pli_vec3_sub(soft_contacts_position(pass->face_body, face[2]), a));
    const pli_vec3 normal = plii_vec3_divide(cross, pli_vec3_length(cross));
    const pli_vec4* previous = pass->face_body->previous;
    const pli_vec3 point = pli_vec3_add(pli_vec3_add(pli_vec3_scale(plii_xyz(previous[face[0]]), weights.x),
                                                     pli_vec3_scale(plii_xyz(previous[face[1]]), weights.y)),
                                        pli_vec3_scale(plii_xyz(previous[face[2]]), weights.z));
    const pli_vec3 before = pli_vec3_sub(plii_xyz(pass->node_body->previous[node]), point);
    const float side = pli_vec3_dot(before, normal);
    const float noise = pass->use_boxes ? 0.0f : 4.0f * PLII_EPSILON * pli_vec3_length(point);
    const bool is_opposite = fabsf(side) > noise || pass->use_boxes ? side < 0.0f : pass->is_second;
    return is_opposite ? pli_vec3_neg(normal) : normal;
}

/* The nearest point of a face, relative to the node, and its weights where they come with it, unless it is certainly
   farther than `reach`. */
static bool soft_contacts_project(const soft_contacts_pass* pass, pli_vec3 a, pli_vec3 b, pli_vec3 c, float reach,
                                  pli_vec3* point, float* distance_squared, pli_vec3* weights) {
    if (pass->use_boxes) {
        return plii_project_origin_on_triangle(a, b, c, PLII_EPSILON, PLII_EPSILON, point, distance_squared);
    }
    const pli_vec3 ab = pli_vec3_sub(b, a), ac = pli_vec3_sub(c, a), normal = pli_vec3_cross(ab, ac);
    const float area_squared = pli_vec3_length_squared(normal), height = pli_vec3_dot(a, normal);
    if (height * height > 1.001f * reach * reach * area_squared) { return false; }
    const float longest = plii_max(pli_vec3_length_squared(ab),
                                   plii_max(pli_vec3_length_squared(pli_vec3_sub(c, b)), pli_vec3_length_squared(ac)));
    const float min_area = SOFT_CONTACTS_MIN_SHAPE * longest;
    if (!(area_squared > plii_max(min_area * min_area, FLT_MIN))) { return false; }
    plii_triangle_place place;
    *point = plii_closest_point_on_triangle(pli_vec3_make(0, 0, 0), a, b, c, &place);
    *weights = place.weights;
    *distance_squared = pli_vec3_length_squared(*point);
    return true;
}

/* *on_face becomes the contact when the node lies on the face. */
static pli_status soft_contacts_test(const soft_contacts_pass* pass, int node, float margin, int face_index,
                                     int* on_face) {
    const pli_body* face_body = pass->face_body;
    const int* face = face_body->topology->faces[face_index];
    const pli_vec3 origin = soft_contacts_position(pass->node_body, node);
    const pli_vec3 x[3] = {soft_contacts_position(face_body, face[0]), soft_contacts_position(face_body, face[1]),
                           soft_contacts_position(face_body, face[2])};
    pli_vec3 point, weights;
    float distance_squared;
    if (!soft_contacts_project(pass, pli_vec3_sub(x[0], origin), pli_vec3_sub(x[1], origin), pli_vec3_sub(x[2], origin),
                               margin, &point, &distance_squared, &weights)) {
        return PLI_OK;
    }
    if (!(distance_squared < margin * margin)) { return PLI_OK; }

    if (pass->use_boxes) { weights = plii_barycentric_by_areas(x[0], x[1], x[2], pli_vec3_add(point, origin)); }
    const float node_response = pass->node_body->positions[node].w;
    const float w[3] = {face_body->positions[face[0]].w, face_body->positions[face[1]].w,
                        face_body->positions[face[2]].w};
    /* One pinned node makes the whole face immovable. */
    const bool is_pinned = w[0] <= 0.0f || w[1] <= 0.0f || w[2] <= 0.0f;
    const float face_response = is_pinned ? 0.0f : w[0] * weights.x + w[1] * weights.y + w[2] * weights.z;
    const float sum = node_response + face_response;
    if (!(sum > 0.0f)) { return PLI_OK; }

    /* A direction of the length of rounding errors means nothing; Bullet's is kept while it is a number. */
    const float noise = pass->use_boxes ? 0.0f : 4.0f * PLII_EPSILON * pli_vec3_length(origin);
    const float distance = sqrtf(distance_squared);
    const pli_vec3 normal =
        distance > noise ? plii_vec3_divide(point, -distance) : soft_contacts_face_normal(pass, node, face, weights);
    if (!plii_vec3_is_finite(normal) || !plii_vec3_is_finite(weights)) { return PLI_OK; }

    soft_contacts_state* state = pass->node_state;
    pli_context* context = pass->node_body->context;
    if (!PLII_RESERVE(context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    if (!(distance > noise)) { *on_face = state->count; }
    soft_contact* contact = &state->contacts[state->count++];
    contact->face_body = pass->face_body;
    contact->node = node;
    contact->face = face_index;
    contact->weights = weights;
    contact->normal = normal;
    contact->margin = margin;
    contact->friction = plii_max(state->def.friction, pass->face_state->def.friction);
    contact->node_share = node_response / sum * state->def.hardness;
    contact->face_share = face_response / sum * pass->face_state->def.hardness;
    return PLI_OK;
}

// -------------------------------------------------------------------------------------------------- finding pairs

static bool soft_contacts_box_is_finite(pli_bounds box) {
    return plii_vec3_is_finite(box.min) && plii_vec3_is_finite(box.max);
}

/* All nodes and faces with finite boxes that can meet. */
static void soft_contacts_collect_boxes(const soft_contacts_pass* pass) {
    soft_contacts_state* search = pass->search;
    pli_bounds all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < pass->node_body->node_count; ++i) {
        const pli_bounds box = pass->node_state->node_boxes[i];
        if (!soft_contacts_box_is_finite(box)) { continue; }
        search->nodes[search->node_count++] = (soft_contacts_node){i, soft_contacts_reach(pass, i)};
        all.min = plii_vec3_min(all.min, box.min);
        all.max = plii_vec3_max(all.max, box.max);
    }
    for (int i = 0; i < pass->face_body->topology->face_count; ++i) {
        const pli_bounds box = pass->face_state->face_boxes[i];
        if (!plii_bounds_overlap(box, all) || !soft_contacts_box_is_finite(box)) { continue; }
        search->faces[search->face_count] = i;
        search->boxes[search->face_count++] = box;
    }
}

/* Nodes whose reach touches the bounds of the other body, and the faces there. The positions of predicted bodies are
   finite. */
static void soft_contacts_collect_near(const soft_contacts_pass* pass) {
    soft_contacts_state* search = pass->search;
    const pli_body *node_body = pass->node_body, *face_body = pass->face_body;
    const plii_float4 body_low = plii_lanes_from_vec3(&face_body->bounds.min);
    const plii_float4 body_high = plii_lanes_from_vec3(&face_body->bounds.max);
    plii_float4 low = plii_float4_all(INFINITY), high = plii_float4_all(-INFINITY);
    for (int i = 0; i < node_body->node_count; ++i) {
        const float reach = soft_contacts_reach(pass, i);
        /* A little more, for what rounding takes away. */
        const plii_float4 x = plii_float4_from(&node_body->positions[i]), wide = plii_float4_all(reach * 1.0001f);
        const plii_float4 from = plii_float4_sub(x, wide), to = plii_float4_add(x, wide);
        const plii_mask4 is_near =
            plii_lanes_both(plii_lanes_at_most(from, body_high), plii_lanes_at_most(body_low, to));
        if ((plii_lanes_bits(is_near) & PLII_LANES_XYZ) != PLII_LANES_XYZ) { continue; }
        search->nodes[search->node_count++] = (soft_contacts_node){i, reach};
        low = plii_lanes_min(from, low);
        high = plii_lanes_max(to, high);
    }
    for (int i = 0; search->node_count > 0 && i < face_body->topology->face_count; ++i) {
        const int face_index = pass->face_state->face_order[i];
        const int* face = face_body->topology->faces[face_index];
        const plii_float4 a = plii_float4_from(&face_body->positions[face[0]]);
        const plii_float4 b = plii_float4_from(&face_body->positions[face[1]]);
        const plii_float4 c = plii_float4_from(&face_body->positions[face[2]]);
        const plii_float4 from = plii_lanes_min(a, plii_lanes_min(b, c)), to = plii_lanes_max(a, plii_lanes_max(b, c));
        const plii_mask4 is_near = plii_lanes_both(plii_lanes_at_most(from, high), plii_lanes_at_most(low, to));
        if ((plii_lanes_bits(is_near) & PLII_LANES_XYZ) != PLII_LANES_XYZ) { continue; }
        search->faces[search->face_count] = face_index;
        plii_lanes_to_vec3(&search->boxes[search->face_count].min, from);
        plii_lanes_to_vec3(&search->boxes[search->face_count++].max, to);
    }
}

/* Along the curve that the tree sorts by; good for as long as the body has these faces, however it bends. */
static bool soft_contacts_order_faces(const pli_body* body, soft_contacts_state* state) {
    pli_context* context = body->context;
    const int face_count = body->topology->face_count;
    if (state->order_count == face_count) { return true; }
    plii_box_tree tree = {0};
    const size_t size = (size_t)face_count * sizeof(pli_bounds);
    pli_bounds* boxes = plii_allocate(context, size);
    for (int i = 0; boxes != NULL && i < face_count; ++i) {
        boxes[i] = soft_contacts_face_bounds(body->positions, body->topology->faces[i]);
    }
    const bool is_ordered = boxes != NULL &&
                            PLII_RESERVE(context, &state->face_order, &state->order_capacity, face_count) &&
                            plii_box_tree_build(context, &tree, face_count, boxes);
    if (is_ordered) {
        memcpy(state->face_order, tree.items, (size_t)face_count * sizeof *state->face_order);
        state->order_count = face_count;
    }
    plii_box_tree_free(context, &tree);
    plii_release(context, boxes, size);
    return is_ordered;
}

/* For a search in which a body takes part. */
static bool soft_contacts_reserve_search(pli_context* context, soft_contacts_state* search, int nodes, int faces) {
    const bool has_boxes = search->node_boxes != NULL;
    return PLII_RESERVE(context, &search->nodes, &search->node_capacity, nodes) &&
           PLII_RESERVE(context, &search->faces, &search->face_capacity, faces) &&
           PLII_RESERVE(context, &search->boxes, &search->box_capacity, faces) &&
           PLII_RESERVE(context, &search->hits, &search->hit_capacity, faces) &&
           (has_boxes ? plii_box_tree_reserve(context, &search->tree, faces)
                      : plii_near_boxes_reserve(context, &search->near, faces));
}

/* Of large bodies most nodes are far from others. */
#define SOFT_CONTACTS_MAX_ROOM 1024
/* A node beside a corner of a triangle mesh is near six faces. */
#define SOFT_CONTACTS_PER_NODE 6

static void soft_contacts_make_room(pli_body* body, void* data) {
    soft_contacts_state* state = data;
    const pli_world* world = body->world;
    pli_context* context = body->context;
    if (!plii_feature_is_shared(body, &soft_contacts_class)) { return; }
    const int nodes = body->node_count < SOFT_CONTACTS_MAX_ROOM ? body->node_count : SOFT_CONTACTS_MAX_ROOM;
    (void)PLII_RESERVE(context, &state->contacts, &state->capacity, SOFT_CONTACTS_PER_NODE * nodes);
    /* Made later, from other positions, the order is another one. */
    if (state->node_boxes == NULL && body->topology->face_count > 0 && !soft_contacts_order_faces(body, state)) {
        plii_world_note_shortage(body->world);
    }
    /* The first body of a pair searches for both. */
    if (body->world_index + 1 < world->body_count) {
        (void)soft_contacts_reserve_search(context, state, world->most_nodes, world->most_faces);
    }
}

/* Nodes and faces that can be near each other, and what finds the faces. False when out of memory. */
static bool soft_contacts_collect(const soft_contacts_pass* pass) {
    soft_contacts_state* search = pass->search;
    pli_context* context = pass->node_body->context;
    const int face_count = pass->face_body->topology->face_count;
    search->node_count = search->face_count = 0;
    if (!soft_contacts_reserve_search(context, search, pass->node_body->node_count, face_count)) { return false; }
    if (pass->use_boxes) {
        soft_contacts_collect_boxes(pass);
        return plii_box_tree_build(context, &search->tree, search->face_count, search->boxes);
    }
    if (!soft_contacts_order_faces(pass->face_body, pass->face_state)) { return false; }
    soft_contacts_collect_near(pass);
    return plii_near_boxes_build(context, &search->near, search->face_count, search->boxes);
}

/* Shell's sort: in place, and quick enough for the few faces near one node. Most nodes have a handful, for which the
   wide steps gain nothing. */
static void soft_contacts_sort(int* values, int count) {
    for (int gap = count > 16 ? count / 2 : 1; gap > 0; gap /= 2) {
        for (int i = gap; i < count; ++i) {
            const int value = values[i];
            int k = i;
            for (; k >= gap && values[k - gap] > value; k -= gap) {
                values[k] = values[k - gap];
            }
            values[k] = value;
        }
    }
}

static void soft_contacts_hit(int item, void* user) {
    soft_contacts_state* search = user;
    search->hits[search->hit_count++] = item;
}

/* Faces whose contacts with a node are to be looked for: ascending, or in the order of the curve. */
static void soft_contacts_find(const soft_contacts_pass* pass, soft_contacts_node near) {
    soft_contacts_state* search = pass->search;
    search->hit_count = 0;
    if (pass->use_boxes) {
        plii_box_tree_overlaps(&search->tree, pass->node_state->node_boxes[near.node], soft_contacts_hit, search);
    } else {
        const pli_vec3 x = soft_contacts_position(pass->node_body, near.node);
        search->hit_count = plii_near_boxes_find(&search->near, x, near.reach, search->hits);
    }
    for (int i = 0; i < search->hit_count; ++i) {
        search->hits[i] = search->faces[search->hits[i]];
    }
    if (pass->use_boxes) { soft_contacts_sort(search->hits, search->hit_count); }
}

/* The faces around the one that a node lies on would push it along that one, out of the whole surface. */
static void soft_contacts_drop_along(soft_contacts_state* state, int first, pli_vec3 normal) {
    int kept = first;
    for (int i = first; i < state->count; ++i) {
        const float across = pli_vec3_dot(state->contacts[i].normal, normal);
        if (fabsf(across) > SOFT_CONTACTS_MIN_ACROSS) { state->contacts[kept++] = state->contacts[i]; }
    }
    state->count = kept;
}

static pli_status soft_contacts_run_pass(const soft_contacts_pass* pass) {
    soft_contacts_state* search = pass->search;
    if (pass->face_body->topology->face_count == 0) { return PLI_OK; }
    if (!soft_contacts_collect(pass)) { return PLI_ERROR_OUT_OF_MEMORY; }
    for (int i = 0; search->face_count > 0 && i < search->node_count; ++i) {
        const soft_contacts_node near = search->nodes[i];
        const int first = pass->node_state->count;
        int on_face = PLI_NULL_INDEX;
        soft_contacts_find(pass, near);
        for (int k = 0; k < search->hit_count; ++k) {
            PLII_TRY(soft_contacts_test(pass, near.node, near.reach, search->hits[k], &on_face));
        }
        if (on_face != PLI_NULL_INDEX && !pass->use_boxes) {
            soft_contacts_drop_along(pass->node_state, first, pass->node_state->contacts[on_face].normal);
        }
    }
    return PLI_OK;
}

static pli_status soft_contacts_collide(pli_body* body, void* data, pli_body* other, void* other_data) {
    soft_contacts_state *state = data, *other_state = other_data;
    const int count = state->count, other_count = other_state->count;
    soft_contacts_pass pass = {body,
                               state,
                               other,
                               other_state,
                               state,
                               body->collision_margin + other->collision_margin,
                               state->node_boxes != NULL && other_state->node_boxes != NULL,
                               false};
    pli_status status = soft_contacts_run_pass(&pass);
    if (status == PLI_OK) {
        pass.node_body = other;
        pass.node_state = other_state;
        pass.face_body = body;
        pass.face_state = state;
        pass.is_second = true;
        status = soft_contacts_run_pass(&pass);
    }
    if (status != PLI_OK) {
        state->count = count;
        other_state->count = other_count;
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------- solving

static pli_vec3 soft_contacts_blend(const pli_vec4* values, const int* face, pli_vec3 weights) {
    return pli_vec3_add(pli_vec3_add(pli_vec3_scale(plii_xyz(values[face[0]]), weights.x),
                                     pli_vec3_scale(plii_xyz(values[face[1]]), weights.y)),
                        pli_vec3_scale(plii_xyz(values[face[2]]), weights.z));
}

static void soft_contacts_move(pli_vec4* position, pli_vec3 step) {
    plii_set_xyz(position, pli_vec3_sub(plii_xyz(*position), step));
}

/* m/s, where springs hold nodes and the definition names no other. */
#define SOFT_CONTACTS_RECOVERY_SPEED 1.0f

/* 0: overlaps go at once, as in Bullet. */
static float soft_contacts_recovery_speed(const pli_body* body, const soft_contacts_state* state) {
    if (state->def.recovery_speed > 0.0f) { return state->def.recovery_speed; }
    return body->solver_class->holds_nodes ? SOFT_CONTACTS_RECOVERY_SPEED : 0.0f;
}

/* As if the node had been there at the start of the step, so that no velocity comes of it. */
static void soft_contacts_shift(pli_body* body, int node, pli_vec3 by) {
    plii_set_xyz(&body->positions[node], pli_vec3_add(plii_xyz(body->positions[node]), by));
    plii_set_xyz(&body->previous[node], pli_vec3_add(plii_xyz(body->previous[node]), by));
}

/* Springs and links pull nodes back that were put apart. Had that given them speed, they would wind it up from step to
   step. The normal of a node that the prediction took through the face points the wrong way; it is only stopped. */
static void soft_contacts_recover(pli_body* body, void* data, const plii_step* step) {
    const soft_contacts_state* state = data;
    const float most = soft_contacts_recovery_speed(body, state) * step->dt;
    if (!(most > 0.0f)) { return; }
    for (int i = 0; i < state->count; ++i) {
        const soft_contact* contact = &state->contacts[i];
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(body->previous[contact->node]),
                                            soft_contacts_blend(other->previous, face, contact->weights));
        const float distance = pli_vec3_dot(contact->normal, apart);
        const float depth = body->collision_margin + other->collision_margin - distance;
        if (!(depth > 0.0f) || distance < 0.0f) { continue; }
        const pli_vec3 shift = pli_vec3_scale(contact->normal, plii_min(depth, most));
        soft_contacts_shift(body, contact->node, pli_vec3_scale(shift, contact->node_share));
        for (int k = 0; k < 3; ++k) {
            soft_contacts_shift(other, face[k], pli_vec3_scale(shift, -contact->face_share * weights[k]));
        }
    }
}

/* A body that was solved before takes its velocities from positions no more. */
static void soft_contacts_push_solved(pli_body* other, const int* face, pli_vec3 weights, pli_vec3 correction) {
    const float w[3] = {weights.x, weights.y, weights.z};
    for (int k = 0; k < 3; ++k) {
        pli_vec4* velocity = &other->velocities[face[k]];
        const pli_vec3 change = pli_vec3_scale(correction, w[k] * other->step.inverse_dt);
        plii_set_xyz(velocity, pli_vec3_sub(plii_xyz(*velocity), change));
    }
}

static void soft_contacts_solve(pli_body* body, void* data, const plii_step* step) {
    const soft_contacts_state* state = data;
    const bool shifts = soft_contacts_recovery_speed(body, state) > 0.0f; /* what overlapped before */
    (void)step;
    for (int i = 0; i < state->count; ++i) {
        const soft_contact* contact = &state->contacts[i];
        pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const pli_vec3 n = contact->normal, weights = contact->weights;
        const pli_vec3 x = soft_contacts_position(body, contact->node);
        const pli_vec3 point = soft_contacts_blend(other->positions, face, weights);
        const pli_vec3 point_before = soft_contacts_blend(other->previous, face, weights);
        const pli_vec3 motion =
            pli_vec3_sub(pli_vec3_sub(x, plii_xyz(body->previous[contact->node])), pli_vec3_sub(point, point_before));
        const float along_normal = pli_vec3_dot(motion, n);
        pli_vec3 correction = pli_vec3_make(0, 0, 0);
        if (along_normal < 0.0f) {
            float depth = contact->margin - (pli_vec3_dot(n, x) - pli_vec3_dot(n, point));
            if (shifts) { depth = plii_min(depth, -along_normal); }
            correction = pli_vec3_add(correction, pli_vec3_scale(n, depth));
        }
        const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, along_normal));
        correction = pli_vec3_sub(correction, pli_vec3_scale(sliding, contact->friction));
        plii_set_xyz(&body->positions[contact->node], pli_vec3_add(x, pli_vec3_scale(correction, contact->node_share)));
        soft_contacts_move(&other->positions[face[0]], pli_vec3_scale(correction, contact->face_share * weights.x));
        soft_contacts_move(&other->positions[face[1]], pli_vec3_scale(correction, contact->face_share * weights.y));
        soft_contacts_move(&other->positions[face[2]], pli_vec3_scale(correction, contact->face_share * weights.z));
        if (shifts && other->world_index < body->world_index) {
            soft_contacts_push_solved(other, face, weights, pli_vec3_scale(correction, contact->face_share));
        }
    }
}

// ---------------------------------------------------------------------------------------------------- the feature

static void soft_contacts_forget_body(pli_body* body, void* data, const pli_body* other) {
    soft_contacts_state* state = data;
    (void)body;
    int kept = 0;
    for (int i = 0; i < state->count; ++i) {
        if (state->contacts[i].face_body != other) { state->contacts[kept++] = state->contacts[i]; }
    }
    state->count = kept;
}

static void soft_contacts_release_boxes(pli_body* body, soft_contacts_state* state) {
    plii_release(body->context, state->node_boxes, (size_t)body->node_count * sizeof *state->node_boxes);
    plii_release(body->context, state->face_boxes, (size_t)body->topology->face_count * sizeof *state->face_boxes);
    state->node_boxes = NULL;
    state->face_boxes = NULL;
    state->has_boxes = false;
    body->soft_node_boxes = NULL;
}

static void soft_contacts_disable(pli_body* body, void* data) {
    soft_contacts_state* state = data;
    pli_context* context = body->context;
    soft_contacts_release_boxes(body, state);
    plii_release(context, state->contacts, (size_t)state->capacity * sizeof *state->contacts);
    plii_release(context, state->faces, (size_t)state->face_capacity * sizeof *state->faces);
    plii_release(context, state->boxes, (size_t)state->box_capacity * sizeof *state->boxes);
    plii_release(context, state->hits, (size_t)state->hit_capacity * sizeof *state->hits);
    plii_release(context, state->nodes, (size_t)state->node_capacity * sizeof *state->nodes);
    plii_box_tree_free(context, &state->tree);
    plii_near_boxes_free(context, &state->near);
    plii_release(context, state->face_order, (size_t)state->order_capacity * sizeof *state->face_order);
}

static size_t soft_contacts_bytes(const pli_body* body, const void* data) {
    const soft_contacts_state* state = data;
    size_t bytes = plii_box_tree_bytes(&state->tree) + plii_near_boxes_bytes(&state->near);
    bytes += (size_t)state->node_capacity * sizeof *state->nodes;
    bytes += (size_t)state->order_capacity * sizeof *state->face_order;
    bytes += (size_t)state->capacity * sizeof *state->contacts;
    bytes += (size_t)state->face_capacity * sizeof *state->faces + (size_t)state->box_capacity * sizeof *state->boxes;
    bytes += (size_t)state->hit_capacity * sizeof *state->hits;
    if (state->node_boxes != NULL) {
        bytes += ((size_t)body->node_count + (size_t)body->topology->face_count) * sizeof(pli_bounds);
    }
    return bytes;
}

static int soft_contacts_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                         size_t* sizes) {
    const soft_contacts_state* state = data;
    (void)body;
    if (state->node_boxes == NULL) { return 0; }
    sizes[0] = (size_t)change->node_count * sizeof *state->node_boxes;
    sizes[1] = (size_t)change->face_count * sizeof *state->face_boxes;
    return 2;
}

/* Boxes start anew with the next step. */
static void soft_contacts_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                          void** blocks) {
    soft_contacts_state* state = data;
    state->count = state->order_count = 0;
    if (state->node_boxes == NULL) { return; }
    plii_release(body->context, state->node_boxes, (size_t)change->old_node_count * sizeof *state->node_boxes);
    plii_release(body->context, state->face_boxes, (size_t)change->old_face_count * sizeof *state->face_boxes);
    state->node_boxes = blocks[0];
    state->face_boxes = blocks[1];
    state->has_boxes = false;
    body->soft_node_boxes = NULL;
}

static const plii_feature_class soft_contacts_class = {
    .name = "soft_contacts",
    .state_size = sizeof(soft_contacts_state),
    .stages = {[PLII_STAGE_UPDATE] = {soft_contacts_update, PLII_ORDER_BOXES},
               [PLII_STAGE_PREPARE] = {soft_contacts_recover, PLII_ORDER_SOFT_CONTACTS},
               [PLII_STAGE_POSITION] = {soft_contacts_solve, PLII_ORDER_SOFT_CONTACTS}},
    .disable = soft_contacts_disable,
    .collide_body = soft_contacts_collide,
    .forget_body = soft_contacts_forget_body,
    .forget_topology = soft_contacts_forget_body,
    .bytes = soft_contacts_bytes,
    .make_room = soft_contacts_make_room,
    .topology_blocks = soft_contacts_topology_blocks,
    .topology_commit = soft_contacts_topology_commit,
};

static pli_status soft_contacts_check_def(pli_context* context, const pli_soft_contacts_def* def,
                                          const char* function) {
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "start from pli_soft_contacts_def_default()");
    }
    if (!plii_is_finite(def->friction) || !plii_is_finite(def->hardness) || !plii_is_finite(def->recovery_speed)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "friction, hardness or recovery_speed is not finite");
    }
    if (!(def->recovery_speed >= 0.0f)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "recovery_speed %g is negative",
                         (double)def->recovery_speed);
    }
    if (!(def->friction >= 0.0f)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "friction %g is negative", (double)def->friction);
    }
    if (!(def->hardness >= 0.0f && def->hardness <= 1.0f)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "hardness %g is not in [0, 1]",
                         (double)def->hardness);
    }
    PLII_TRY(plii_check_within(context, def->friction, PLI_MAX_FACTOR, "friction", function));
    return plii_check_within(context, def->recovery_speed, PLI_MAX_SPEED, "recovery_speed", function);
}

static pli_status soft_contacts_allocate_boxes(pli_body* body, soft_contacts_state* state) {
    const size_t faces = (size_t)body->topology->face_count;
    state->node_boxes = plii_allocate(body->context, (size_t)body->node_count * sizeof *state->node_boxes);
    state->face_boxes = plii_allocate(body->context, faces * sizeof *state->face_boxes);
    if (state->node_boxes != NULL && (state->face_boxes != NULL || faces == 0)) { return PLI_OK; }
    soft_contacts_release_boxes(body, state);
    return PLI_ERROR_OUT_OF_MEMORY;
}

pli_status pli_body_enable_soft_contacts(pli_body* body, const pli_soft_contacts_def* def) {
    PLII_TRY(plii_check_body_change(body, __func__));
    const pli_soft_contacts_def used = def != NULL ? *def : pli_soft_contacts_def_default();
    PLII_TRY(soft_contacts_check_def(body->context, &used, __func__));
    const bool was_enabled = plii_feature_state(body, &soft_contacts_class) != NULL;
    void* data = NULL;
    PLII_TRY(plii_feature_enable(body, &soft_contacts_class, &data));
    soft_contacts_state* state = data;
    if (used.bullet_boxes && state->node_boxes == NULL && soft_contacts_allocate_boxes(body, state) != PLI_OK) {
        if (!was_enabled) { plii_feature_disable(body, &soft_contacts_class); }
        return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for boxes");
    }
    if (!used.bullet_boxes) { soft_contacts_release_boxes(body, state); }
    state->def = used;
    return PLI_OK;
}

pli_status pli_body_disable_soft_contacts(pli_body* body) {
    PLII_TRY(plii_check_body_change(body, __func__));
    plii_feature_disable(body, &soft_contacts_class);
    return PLI_OK;
}

int pli_body_get_soft_contacts(const pli_body* body, int capacity, pli_soft_contact* contacts) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const soft_contacts_state* state = plii_feature_state(body, &soft_contacts_class);
    if (state == NULL) { return 0; }
    for (int i = 0; contacts != NULL && i < capacity && i < state->count; ++i) {
        const soft_contact* contact = &state->contacts[i];
        contacts[i].node = contact->node;
        contacts[i].face_body = contact->face_body;
        contacts[i].face = contact->face;
        contacts[i].weights[0] = contact->weights.x;
        contacts[i].weights[1] = contact->weights.y;
        contacts[i].weights[2] = contact->weights.z;
        contacts[i].normal = contact->normal;
        contacts[i].margin = contact->margin;
    }
    return state->count;
}

pli_status pli_body_reorder_soft_contacts(pli_body* body, const int* order, int count) {
    PLII_TRY(plii_check_body_change(body, __func__));
    soft_contacts_state* state = plii_feature_state(body, &soft_contacts_class);
    if (state == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "soft contacts are not enabled"); }
    return plii_reorder_contacts(body, state->contacts, sizeof *state->contacts, state->count, order, count, __func__);
}

static pli_status soft_contacts_check_boxes(pli_context* context, const pli_bounds* boxes, int count, const char* what,
                                            const char* function) {
    if (boxes == NULL && count > 0) {
        return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "%s_boxes is null", what);
    }
    for (int i = 0; i < count; ++i) {
        if (!soft_contacts_box_is_finite(boxes[i])) {
            return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "the box of %s %d is not finite", what, i);
        }
    }
    return PLI_OK;
}

pli_status pli_body_set_bullet_boxes(pli_body* body, const pli_bounds* node_boxes, const pli_bounds* face_boxes) {
    PLII_TRY(plii_check_body_change(body, __func__));
    soft_contacts_state* state = plii_feature_state(body, &soft_contacts_class);
    const bool has_faces = state != NULL && state->node_boxes != NULL;
    if (!has_faces && body->node_boxes == NULL) {
        return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE,
                         "neither soft contacts with bullet_boxes nor pli_body_enable_bullet_node_boxes are enabled");
    }
    const int face_count = has_faces ? body->topology->face_count : 0;
    PLII_TRY(soft_contacts_check_boxes(body->context, node_boxes, body->node_count, "node", __func__));
    PLII_TRY(soft_contacts_check_boxes(body->context, face_boxes, face_count, "face", __func__));
    for (int i = 0; i < body->node_count; ++i) {
        if (body->node_boxes != NULL) { body->node_boxes[i] = node_boxes[i]; }
        if (has_faces) { state->node_boxes[i] = node_boxes[i]; }
    }
    if (!has_faces) { return PLI_OK; }
    for (int i = 0; i < face_count; ++i) {
        state->face_boxes[i] = face_boxes[i];
    }
    state->has_boxes = true;
    body->soft_node_boxes = state->node_boxes;
    return PLI_OK;
}
