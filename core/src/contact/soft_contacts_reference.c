/* Contacts between two bodies in reference mode, as in btSoftBody: the search with Bullet's boxes
   (btSoftColliders::CollideVF_SS) and the solve. Given the same pairs of node and face, contacts equal Bullet's bit for
   bit. They come in the order of nodes, then of faces; Bullet's order depends on memory addresses.

   A node that lies on a face gets the normal of the face instead of NaN. */

#include "body/pipeline.h"
#include "contact/soft_contacts_impl.h"
#include "geometry/closest_point.h"
#include "math/bounds.h"
#include "math/range.h"

// ------------------------------------------------------------------------------------------------------- one candidate

/* Nodes of one body against faces of another. */
typedef struct reference_pass {
    pli_body* node_body;
    plii_soft_contacts_state* node_state;
    pli_body* face_body;
    plii_soft_contacts_state* face_state;
    plii_soft_contacts_state* search;
    float margin; /* sum of both */
} reference_pass;

/* How far a node looks for faces. */
static float reference_reach(const reference_pass* pass, int node) {
    const pli_vec3 motion =
        pli_vec3_sub(plii_soft_contacts_position(pass->node_body, node), plii_xyz(pass->node_body->previous[node]));
    return pass->margin + pli_vec3_length(motion) * 2.0f;
}

/* The normal for a node that lies on its face: that of the face, to the side where the node was before. */
static pli_vec3 reference_face_normal(const reference_pass* pass, int node, const int* face, pli_vec3 weights) {
    const pli_vec3 a = plii_soft_contacts_position(pass->face_body, face[0]);
    const pli_vec3 cross = pli_vec3_cross(pli_vec3_sub(plii_soft_contacts_position(pass->face_body, face[1]), a),
                                          pli_vec3_sub(plii_soft_contacts_position(pass->face_body, face[2]), a));
    const pli_vec3 normal = plii_vec3_divide(cross, pli_vec3_length(cross));
    const pli_vec3 before = pli_vec3_sub(plii_xyz(pass->node_body->previous[node]),
                                         plii_soft_contacts_blend(pass->face_body->previous, face, weights));
    return pli_vec3_dot(before, normal) < 0.0f ? pli_vec3_neg(normal) : normal;
}

static pli_status reference_test(const reference_pass* pass, int node, float margin, int face_index) {
    const pli_body* face_body = pass->face_body;
    const int* face = face_body->topology->faces[face_index];
    const pli_vec3 origin = plii_soft_contacts_position(pass->node_body, node);
    const pli_vec3 x[3] = {plii_soft_contacts_position(face_body, face[0]),
                           plii_soft_contacts_position(face_body, face[1]),
                           plii_soft_contacts_position(face_body, face[2])};
    pli_vec3 point;
    float distance_squared;
    if (!plii_project_origin_on_triangle(pli_vec3_sub(x[0], origin), pli_vec3_sub(x[1], origin),
                                         pli_vec3_sub(x[2], origin), PLII_EPSILON, PLII_EPSILON, &point,
                                         &distance_squared)) {
        return PLI_OK;
    }
    if (!(distance_squared < margin * margin)) { return PLI_OK; }

    const pli_vec3 weights = plii_barycentric_by_areas(x[0], x[1], x[2], pli_vec3_add(point, origin));
    const float node_response = pass->node_body->positions[node].w;
    const float w[3] = {face_body->positions[face[0]].w, face_body->positions[face[1]].w,
                        face_body->positions[face[2]].w};
    /* One pinned node makes the whole face immovable. */
    const bool is_pinned = w[0] <= 0.0f || w[1] <= 0.0f || w[2] <= 0.0f;
    const float face_response = is_pinned ? 0.0f : w[0] * weights.x + w[1] * weights.y + w[2] * weights.z;
    const float sum = node_response + face_response;
    if (!(sum > 0.0f)) { return PLI_OK; }

    const float distance = sqrtf(distance_squared);
    const pli_vec3 normal =
        distance > 0.0f ? plii_vec3_divide(point, -distance) : reference_face_normal(pass, node, face, weights);
    if (!plii_vec3_is_finite(normal) || !plii_vec3_is_finite(weights)) { return PLI_OK; }

    plii_soft_contacts_state* state = pass->node_state;
    pli_context* context = pass->node_body->context;
    if (!PLII_RESERVE(context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    state->contacts[state->count++] = (plii_soft_contact){
        .face_body = pass->face_body,
        .node = node,
        .face = face_index,
        .next = PLI_NULL_INDEX,
        .is_reference = true,
        .weights = {weights.x, weights.y, weights.z, 0},
        .normal = {normal.x, normal.y, normal.z, 0},
        .margin = margin,
        .friction = plii_max(state->def.friction, pass->face_state->def.friction),
        .node_share = node_response / sum * state->def.hardness,
        .face_share = face_response / sum * pass->face_state->def.hardness,
    };
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------------------- finding pairs

/* All nodes and faces with finite boxes that can meet. */
static void reference_collect_boxes(const reference_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    pli_bounds all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < pass->node_body->node_count; ++i) {
        const pli_bounds box = pass->node_state->node_boxes[i];
        if (!plii_soft_contacts_box_is_finite(box)) { continue; }
        search->nodes[search->node_count++] = (plii_soft_contacts_node){i, reference_reach(pass, i)};
        all.min = plii_vec3_min(all.min, box.min);
        all.max = plii_vec3_max(all.max, box.max);
    }
    for (int i = 0; i < pass->face_body->topology->face_count; ++i) {
        const pli_bounds box = pass->face_state->face_boxes[i];
        if (!plii_bounds_overlap(box, all) || !plii_soft_contacts_box_is_finite(box)) { continue; }
        search->faces[search->face_count] = i;
        search->boxes[search->face_count++] = box;
    }
}

/* What a search in which a body takes part needs. */
bool plii_soft_reference_reserve(pli_context* context, plii_soft_contacts_state* search, int nodes, int faces) {
    return PLII_RESERVE(context, &search->nodes, &search->node_capacity, nodes) &&
           PLII_RESERVE(context, &search->faces, &search->face_capacity, faces) &&
           PLII_RESERVE(context, &search->boxes, &search->box_capacity, faces) &&
           PLII_RESERVE(context, &search->hits, &search->hit_capacity, faces) &&
           plii_bvh_reserve(context, &search->tree, faces);
}

/* Nodes and faces that can be near each other, and what finds the faces. False when out of memory. */
static bool reference_collect(const reference_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    pli_context* context = pass->node_body->context;
    search->node_count = search->face_count = 0;
    if (!plii_soft_reference_reserve(context, search, pass->node_body->node_count,
                                     pass->face_body->topology->face_count)) {
        return false;
    }
    reference_collect_boxes(pass);
    return plii_bvh_build(context, &search->tree, search->face_count, search->boxes);
}

/* Shell's sort: in place, and quick enough for the few faces near one node. Most nodes have a handful, for which the
   wide steps gain nothing. */
static void reference_sort(int* values, int count) {
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

static void reference_hit(int item, void* user) {
    plii_soft_contacts_state* search = user;
    search->hits[search->hit_count++] = search->faces[item];
}

static pli_status reference_run_pass(const reference_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    if (pass->face_body->topology->face_count == 0) { return PLI_OK; }
    if (!reference_collect(pass)) { return PLI_ERROR_OUT_OF_MEMORY; }
    for (int i = 0; search->face_count > 0 && i < search->node_count; ++i) {
        const plii_soft_contacts_node near = search->nodes[i];
        search->hit_count = 0;
        plii_bvh_overlaps(&search->tree, pass->node_state->node_boxes[near.node], reference_hit, search);
        reference_sort(search->hits, search->hit_count);
        for (int k = 0; k < search->hit_count; ++k) {
            PLII_TRY(reference_test(pass, near.node, near.reach, search->hits[k]));
        }
    }
    return PLI_OK;
}

pli_status plii_soft_reference_collide(pli_body* body, plii_soft_contacts_state* state, pli_body* other,
                                       plii_soft_contacts_state* other_state) {
    const int count = state->count, other_count = other_state->count;
    const float margin = body->collision_margin + other->collision_margin;
    const reference_pass first = {body, state, other, other_state, state, margin};
    const reference_pass second = {other, other_state, body, state, state, margin};
    pli_status status = reference_run_pass(&first);
    if (status == PLI_OK) { status = reference_run_pass(&second); }
    if (status != PLI_OK) {
        state->count = count;
        other_state->count = other_count;
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------ the
// solve

static void reference_move(pli_vec4* position, pli_vec3 step) {
    plii_set_xyz(position, pli_vec3_sub(plii_xyz(*position), step));
}

static void reference_solve_contact(pli_body* body, const plii_soft_contact* contact) {
    pli_body* other = contact->face_body;
    const int* face = other->topology->faces[contact->face];
    const pli_vec3 n = plii_xyz(contact->normal), weights = plii_xyz(contact->weights);
    const pli_vec3 x = plii_soft_contacts_position(body, contact->node);
    const pli_vec3 point = plii_soft_contacts_blend(other->positions, face, weights);
    const pli_vec3 point_before = plii_soft_contacts_blend(other->previous, face, weights);
    const pli_vec3 motion =
        pli_vec3_sub(pli_vec3_sub(x, plii_xyz(body->previous[contact->node])), pli_vec3_sub(point, point_before));
    const float along_normal = pli_vec3_dot(motion, n);
    pli_vec3 correction = pli_vec3_make(0, 0, 0);
    if (along_normal < 0.0f) {
        const float depth = contact->margin - (pli_vec3_dot(n, x) - pli_vec3_dot(n, point));
        correction = pli_vec3_add(correction, pli_vec3_scale(n, depth));
    }
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, along_normal));
    correction = pli_vec3_sub(correction, pli_vec3_scale(sliding, contact->friction));
    plii_set_xyz(&body->positions[contact->node], pli_vec3_add(x, pli_vec3_scale(correction, contact->node_share)));
    reference_move(&other->positions[face[0]], pli_vec3_scale(correction, contact->face_share * weights.x));
    reference_move(&other->positions[face[1]], pli_vec3_scale(correction, contact->face_share * weights.y));
    reference_move(&other->positions[face[2]], pli_vec3_scale(correction, contact->face_share * weights.z));
}

static void reference_solve(pli_body* body, void* data, const plii_step* step) {
    const plii_soft_contacts_state* state = plii_feature_state(body, &plii_soft_contacts_class);
    (void)data;
    (void)step;
    for (int i = 0; i < state->count; ++i) {
        if (state->contacts[i].is_reference) { reference_solve_contact(body, &state->contacts[i]); }
    }
}

static const plii_feature_class* const reference_needs[] = {&plii_soft_contacts_class, NULL};

enum { SOFT_REFERENCE_ORDER = 30 }; /* after contacts with rigid bodies and before the links */

const plii_feature_class plii_soft_reference_class = {
    .name = "soft contacts in reference mode",
    .needs = reference_needs,
    .stages = {[PLII_STAGE_POSITION] = {reference_solve, SOFT_REFERENCE_ORDER}},
};
