/* The search for contacts of nodes with the faces of another soft body: which of them are near, and the contact of a
   node and a face (btSoftColliders::CollideVF_SS). Given the same pairs of node and face, contacts equal Bullet's bit
   for bit. They come in the order of nodes, then of faces; Bullet's order depends on memory addresses.
   Where Bullet is of no use its rule is mended: a node that lies on a face gets the normal of the face instead of NaN,
   and, unless Bullet's boxes are kept, a face is too small by its shape and not by its absolute area. */

#include "body/pipeline.h"
#include "contact/soft_contacts_impl.h"
#include "geometry/closest_point4.h"

/* Of the margins, at least; what moves nodes aside grows with what falls in a step, of which 4 are enough. */
#define SOFT_CONTACTS_LEAST_SLACK 0.1f
#define SOFT_CONTACTS_MOST_SLACK 4.0f

/* How far a node looks for faces. What moves it in the step beside its velocity is taken from the step before. */
static plii_soft_contacts_node soft_reach(const plii_soft_contacts_pass* pass, int node) {
    const pli_body* body = pass->node_body;
    const pli_vec3 motion = pli_vec3_sub(plii_xyz(body->positions[node]), plii_xyz(body->previous[node]));
    const float relative = pli_vec3_length(pli_vec3_sub(motion, pass->common_motion));
    const float reach = pass->margin + relative * 2.0f;
    if (pass->use_boxes) { return (plii_soft_contacts_node){node, reach, reach, 0.0f}; }
    const float least = SOFT_CONTACTS_LEAST_SLACK * pass->margin, most = PLII_SOFT_CONTACTS_SLACK * pass->margin;
    const float slack = plii_clamp(4.0f * pass->fall, least, most) + 2.0f * pass->node_state->missed[node];
    /* What is fast is stopped before it is there, and so stays on its side; gravity in a step does not count. */
    return (plii_soft_contacts_node){node, reach + plii_min(slack, SOFT_CONTACTS_MOST_SLACK * pass->margin),
                                     plii_max(pass->margin, reach - 2.0f * pass->fall), relative + pass->other_motion};
}

/* For a node that lies on its face: the normal of the face, to the side where the node was. If it lay on it then, too,
   nodes of the first body go one way and those of the second the other, so that bodies in the same place part. */
static pli_vec3 soft_face_normal(const plii_soft_contacts_pass* pass, int node, const int* face, pli_vec3 weights) {
    const pli_vec3 a = plii_xyz(pass->face_body->positions[face[0]]);
    const pli_vec3 cross = pli_vec3_cross(pli_vec3_sub(plii_xyz(pass->face_body->positions[face[1]]), a),
                                          pli_vec3_sub(plii_xyz(pass->face_body->positions[face[2]]), a));
    const pli_vec3 normal = plii_vec3_divide(cross, pli_vec3_length(cross));
    const pli_vec3 point = plii_contact_blend(pass->face_body->previous, face, weights);
    const float side = pli_vec3_dot(pli_vec3_sub(plii_xyz(pass->node_body->previous[node]), point), normal);
    const float noise = pass->use_boxes ? 0.0f : 4.0f * PLII_EPSILON * pli_vec3_length(point);
    const bool is_opposite = fabsf(side) > noise || pass->use_boxes ? side < 0.0f : pass->is_second;
    return is_opposite ? pli_vec3_neg(normal) : normal;
}

/* Inverse of the mass that the face shows at a point, 1/kg. In Bullet its mean; one pinned node makes it immovable. */
static float soft_face_weight(const plii_soft_contacts_pass* pass, const int* face, pli_vec3 weights,
                              float node_weight) {
    const pli_vec4* positions = pass->face_body->positions;
    const pli_vec3 w = pli_vec3_make(positions[face[0]].w, positions[face[1]].w, positions[face[2]].w);
    if (!pass->use_boxes) {
        const float shares[3] = {weights.x, weights.y, weights.z};
        if (plii_body_is_idle(pass->face_body)) { return 0.0f; }
        if (node_weight > 0.0f) { return plii_point_weight(positions, 3, face, shares, 0.0f); }
        return plii_point_weight_unpinned(positions, 3, face, shares);
    }
    const bool is_pinned = w.x <= 0.0f || w.y <= 0.0f || w.z <= 0.0f;
    return is_pinned ? 0.0f : w.x * weights.x + w.y * weights.y + w.z * weights.z;
}

/* For contact events: a contact is about to be appended. False without memory. */
static bool soft_record(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* state = pass->node_state;
    if (!pass->node_body->records_contacts && !pass->face_body->records_contacts) { return true; }
    while (state->impulse_count <= state->count) {
        if (!plii_contact_impulses_add(pass->node_body, &state->impulses, state->impulse_count)) { return false; }
        state->impulse_count += 1;
    }
    return true;
}
/* Likewise, of two bodies. */
static void soft_meet(pli_body* body, plii_soft_contacts_state* state, pli_body* other) {
    if (!body->records_contacts) { return; }
    if (!PLII_GROW(body->context, &state->met, &state->met_capacity, state->met_count)) { return; }
    state->met[state->met_count++] = other;
}

/* What a node looks at, and how it is held off it. */
typedef struct soft_pick {
    int face;
    pli_vec3 weights, normal;
    float distance, time; /* m; share of the step at which it crosses */
} soft_pick;

/* Unless nothing in it can move. */
static void soft_append(const plii_soft_contacts_pass* pass, int node, float margin, const soft_pick* pick) {
    const float node_weight = pass->node_body->positions[node].w;
    const float face_weight =
        soft_face_weight(pass, pass->face_body->topology->faces[pick->face], pick->weights, node_weight);
    const float sum = node_weight + face_weight;
    if (!(sum > 0.0f) || !plii_vec3_is_finite(pick->normal) || !plii_vec3_is_finite(pick->weights)) { return; }
    plii_soft_contacts_state* state = pass->node_state;
    if (!PLII_RESERVE(pass->node_body->context, &state->contacts, &state->capacity, state->count + 1) ||
        !soft_record(pass)) {
        return;
    }
    plii_soft_contact* contact = &state->contacts[state->count++];
    *contact = (plii_soft_contact){.face_body = pass->face_body,
                                   .node = node,
                                   .face = pick->face,
                                   .weights = pick->weights,
                                   .distance = pick->distance,
                                   .normal = pick->normal,
                                   .margin = margin,
                                   .friction = plii_max(state->def.friction, pass->face_state->def.friction),
                                   .is_bullet = pass->use_boxes};
    if (contact->is_bullet) {
        contact->node_share = node_weight / sum * state->def.hardness;
        contact->face_share = face_weight / sum * pass->face_state->def.hardness;
    } else {
        contact->hardness = plii_min(state->def.hardness, pass->face_state->def.hardness);
        contact->weight = sum;
    }
}

/* As Bullet does it. */
static void soft_test(const plii_soft_contacts_pass* pass, int node, float margin, int face_index) {
    const int* face = pass->face_body->topology->faces[face_index];
    const pli_vec3 origin = plii_xyz(pass->node_body->positions[node]);
    const pli_vec3 a = plii_xyz(pass->face_body->positions[face[0]]);
    const pli_vec3 b = plii_xyz(pass->face_body->positions[face[1]]);
    const pli_vec3 c = plii_xyz(pass->face_body->positions[face[2]]);
    pli_vec3 point;
    float distance_squared;
    if (!plii_project_origin_on_triangle(pli_vec3_sub(a, origin), pli_vec3_sub(b, origin), pli_vec3_sub(c, origin),
                                         &point, &distance_squared) ||
        !(distance_squared < margin * margin)) {
        return;
    }
    soft_pick pick = {.face = face_index, .weights = plii_barycentric_by_areas(a, b, c, pli_vec3_add(point, origin))};
    const float distance = sqrtf(distance_squared);
    pick.normal =
        distance > 0.0f ? plii_vec3_divide(point, -distance) : soft_face_normal(pass, node, face, pick.weights);
    soft_append(pass, node, margin, &pick);
}

// ---------------------------------------------------------------------------------------------- which faces of a node

/* Faces near a node that get a contact: the first one that it crosses in the step, held on the side that it comes from;
   else the nearest, and those that have their nearest point inside and face another way. Others only repeat these. */

/* Contacts of a node with one other body. */
enum { SOFT_CONTACTS_MOST_NEAREST = 3 };
/* Faces of one node look the same way when the cosine of their normals is above this. */
#define SOFT_CONTACTS_ALIKE 0.7f
/* Of the longest edge: a node that passes so close beside a face crosses it. */
#define SOFT_CONTACTS_EDGE 1e-3f
enum { SOFT_CONTACTS_ROUNDS = 8 }; /* to the time of a crossing */

/* Corners of a face as the node sees them. */
typedef struct soft_corners {
    pli_vec3 at[3];
} soft_corners;

static soft_corners soft_seen(const pli_vec4* faces, const int* face, pli_vec4 node) {
    soft_corners corners;
    for (int k = 0; k < 3; ++k) {
        corners.at[k] = pli_vec3_sub(plii_xyz(faces[face[k]]), plii_xyz(node));
    }
    return corners;
}

/* The nearest point of a face within reach. */
static bool soft_is_near(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, const int* face,
                         const soft_corners* now, soft_pick* pick, plii_triangle_feature* feature) {
    plii_closest_feature closest;
    const pli_vec3 point =
        plii_closest_point_on_triangle(pli_vec3_make(0, 0, 0), now->at[0], now->at[1], now->at[2], &closest);
    const float distance = pli_vec3_length(point);
    if (!(distance < near.reach)) { return false; }
    /* A direction of the length of rounding errors means nothing. */
    const float noise = 4.0f * PLII_EPSILON * pli_vec3_length(plii_xyz(pass->node_body->positions[near.node]));
    pick->distance = distance;
    pick->weights = closest.weights;
    pick->normal = distance > noise ? plii_vec3_divide(point, -distance)
                                    : soft_face_normal(pass, near.node, face, closest.weights);
    *feature = closest.feature;
    return true;
}

/* The node is on one side of the face at the start of the step and on the other one now, and meets it between. */
static bool soft_crosses(const plii_soft_contacts_pass* pass, int node, const int* face, const soft_corners* now,
                         soft_pick* pick) {
    const pli_vec3 normal = plii_measure_triangle(now->at[0], now->at[1], now->at[2]).normal;
    const soft_corners before = soft_seen(pass->face_body->previous, face, pass->node_body->previous[node]);
    const float to = -pli_vec3_dot(now->at[0], normal);
    const pli_vec3 cross =
        pli_vec3_cross(pli_vec3_sub(before.at[1], before.at[0]), pli_vec3_sub(before.at[2], before.at[0]));
    const float volume = -pli_vec3_dot(before.at[0], cross); /* six times that of the face and the node */
    if (!((volume > 0.0f && to < 0.0f) || (volume < 0.0f && to > 0.0f))) { return false; }
    /* Faces turn on the way: the time by the heights at both ends is a guess, which false position (Illinois) mends. */
    const float from = volume / pli_vec3_length(cross), edge = SOFT_CONTACTS_EDGE * SOFT_CONTACTS_EDGE;
    float times[2] = {0.0f, 1.0f}, heights[2] = {from, to};
    pli_vec3 met[3];
    plii_triangle_size size_met = {0};
    for (int round = 0, last = -1; round < SOFT_CONTACTS_ROUNDS; ++round) {
        pick->time = times[0] + (times[1] - times[0]) * (heights[0] / (heights[0] - heights[1]));
        for (int k = 0; k < 3; ++k) {
            met[k] =
                pli_vec3_add(pli_vec3_scale(before.at[k], 1.0f - pick->time), pli_vec3_scale(now->at[k], pick->time));
        }
        size_met = plii_measure_triangle(met[0], met[1], met[2]);
        if (!size_met.is_usable) { return false; }
        const float height = -pli_vec3_dot(met[0], size_met.normal);
        if (height * height <= 0.25f * edge * size_met.longest_squared) { break; }
        const int end = height * from > 0.0f ? 0 : 1;
        if (end == last) { heights[1 - end] *= 0.5f; }
        times[end] = pick->time;
        heights[end] = height;
        last = end;
    }
    plii_closest_feature closest;
    const pli_vec3 point = plii_closest_point_on_triangle(pli_vec3_make(0, 0, 0), met[0], met[1], met[2], &closest);
    if (!(pli_vec3_length_squared(point) < edge * size_met.longest_squared)) { return false; }
    if (pass->looks_inside && from < 0.0f) { return false; }
    pick->distance = 0.0f;
    pick->weights = closest.weights;
    pick->normal = from > 0.0f ? normal : pli_vec3_neg(normal);
    return true;
}

/* Keeps the nearest ones that differ, the nearest first. */
static int soft_keep(soft_pick* kept, int count, const soft_pick* pick) {
    int place = count;
    while (place > 0 && pick->distance < kept[place - 1].distance) {
        --place;
    }
    if (place == SOFT_CONTACTS_MOST_NEAREST) { return count; }
    if (count == SOFT_CONTACTS_MOST_NEAREST) { --count; }
    for (int k = count; k > place; --k) {
        kept[k] = kept[k - 1];
    }
    kept[place] = *pick;
    return count + 1;
}

static bool soft_is_alike(const soft_pick* const* kept, int count, const soft_pick* pick) {
    for (int k = 0; k < count; ++k) {
        if (pli_vec3_dot(kept[k]->normal, pick->normal) > SOFT_CONTACTS_ALIKE) { return true; }
    }
    return false;
}

/* The faces of one node and one other body. */
typedef struct soft_picks {
    soft_pick crossed, nearest; /* INFINITY as time or distance: none */
    soft_pick inside[SOFT_CONTACTS_MOST_NEAREST];
    int inside_count;
} soft_picks;

static void soft_look_at(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, int face_index,
                         bool may_cross, soft_picks* picks) {
    const int* face = pass->face_body->topology->faces[face_index];
    const soft_corners now = soft_seen(pass->face_body->positions, face, pass->node_body->positions[near.node]);
    soft_pick pick = {.face = face_index};
    if (may_cross && soft_crosses(pass, near.node, face, &now, &pick)) {
        if (pick.time < picks->crossed.time) { picks->crossed = pick; }
        return;
    }
    plii_triangle_feature feature;
    if (!soft_is_near(pass, near, face, &now, &pick, &feature)) { return; }
    if (pick.distance < picks->nearest.distance) { picks->nearest = pick; }
    if (feature == PLII_TRIANGLE_FACE) { picks->inside_count = soft_keep(picks->inside, picks->inside_count, &pick); }
}

/* Of faces whose nearest point is on their rim only the nearest one counts. */
typedef struct soft_rim {
    float squared; /* of the distance, m^2 */
    int face_index;
} soft_rim;

/* A triangle this much longer than the reach is not measured in float. */
#define SOFT_CONTACTS_COARSE 1e3f

/* Faces that a node may have met in the step: only what is no farther than both moved. */
static int soft_may_cross(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, const int* const faces[4],
                          const plii_distance4* now) {
    const float edge = SOFT_CONTACTS_EDGE * SOFT_CONTACTS_EDGE;
    const plii_float4 most = now->longest_squared * (3.0f * edge) + 3.0f * near.motion * near.motion;
    if (plii_lanes_bits(now->squared <= most) == 0) { return 0; }
    const plii_triangle4 before =
        plii_triangle4_seen(pass->face_body->previous, faces, plii_xyz(pass->node_body->previous[near.node]));
    return plii_lanes_bits(plii_triangle4_volume(&before) * now->height <= 0.0f);
}

/* Looks at four faces from afar, and closer at those that the node may cross or whose nearest point lies inside. */
static void soft_look_at_four(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, const int* hits,
                              int count, soft_picks* picks, soft_rim* rim) {
    const pli_body *node_body = pass->node_body, *face_body = pass->face_body;
    const int* faces[4];
    int face_indices[4];
    for (int k = 0; k < 4; ++k) {
        face_indices[k] = pass->search->faces[hits[k < count ? k : 0]];
        faces[k] = face_body->topology->faces[face_indices[k]];
    }
    const plii_triangle4 now =
        plii_triangle4_seen(face_body->positions, faces, plii_xyz(node_body->positions[near.node]));
    const float reach = 1.001f * near.reach;
    if (!plii_triangle4_may_be_near(&now, reach)) { return; }
    const plii_distance4 distance = plii_triangle4_distance(&now);
    const float coarse = SOFT_CONTACTS_COARSE * near.reach;
    const plii_float4 height = distance.height, squared = distance.squared;
    const int low = plii_lanes_bits((height <= reach) & (height >= -reach));
    const int close = plii_lanes_bits(squared <= reach * reach);
    const int is_coarse = plii_lanes_bits(distance.longest_squared > coarse * coarse);
    const int crossed = is_coarse | soft_may_cross(pass, near, faces, &distance);
    const int wanted = distance.usable & low & ((1 << count) - 1);
    const int looked_at = wanted & (crossed | (close & distance.inside));
    for (int bits = looked_at; bits != 0; bits &= bits - 1) {
        const int k = __builtin_ctz((unsigned)bits);
        soft_look_at(pass, near, face_indices[k], (crossed >> k & 1) != 0, picks);
    }
    const int nearer = wanted & close & ~looked_at & plii_lanes_bits(squared < rim->squared);
    for (int bits = nearer; bits != 0; bits &= bits - 1) {
        const int k = __builtin_ctz((unsigned)bits);
        if (squared[k] < rim->squared) { *rim = (soft_rim){squared[k], face_indices[k]}; }
    }
}

/* The faces near a node that are found. */
static void soft_look(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, soft_picks* picks) {
    const plii_soft_contacts_state* search = pass->search;
    picks->crossed.time = picks->nearest.distance = INFINITY;
    picks->inside_count = 0;
    soft_rim rim = {INFINITY, -1};
    for (int i = 0; i < search->hit_count; i += 4) {
        const int left = search->hit_count - i;
        soft_look_at_four(pass, near, &search->hits[i], left < 4 ? left : 4, picks, &rim);
    }
    if (rim.squared < 1.001f * picks->nearest.distance * picks->nearest.distance) {
        soft_look_at(pass, near, rim.face_index, false, picks);
    }
}

/* Inside of a closed surface, as all faces see it that are nearest. */
static bool soft_is_inside(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, float distance) {
    near.reach = 1.001f * distance + FLT_MIN;
    for (int i = 0; i < pass->search->hit_count; ++i) {
        const int* face = pass->face_body->topology->faces[pass->search->faces[pass->search->hits[i]]];
        const soft_corners now = soft_seen(pass->face_body->positions, face, pass->node_body->positions[near.node]);
        if (pli_vec3_dot(plii_measure_triangle(now.at[0], now.at[1], now.at[2]).normal, now.at[0]) > 0.0f) { continue; }
        soft_pick pick;
        plii_triangle_feature feature;
        if (soft_is_near(pass, near, face, &now, &pick, &feature)) { return false; }
    }
    return true;
}

static void soft_add_nearest(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near) {
    if (pass->search->hit_count == 0) { return; }
    soft_picks picks; /* what is not set is not read */
    soft_look(pass, near, &picks);
    if (picks.crossed.time < INFINITY) { soft_append(pass, near.node, near.margin, &picks.crossed); }
    if (picks.crossed.time < INFINITY || !(picks.nearest.distance < INFINITY)) { return; }
    if (pass->looks_inside && soft_is_inside(pass, near, picks.nearest.distance)) {
        picks.nearest.normal = pli_vec3_neg(picks.nearest.normal);
        picks.nearest.distance = 0.0f;
        picks.inside_count = 0;
    }
    soft_append(pass, near.node, near.margin, &picks.nearest);
    const soft_pick* added[SOFT_CONTACTS_MOST_NEAREST] = {&picks.nearest};
    int count = 1;
    for (int k = 0; k < picks.inside_count && count < SOFT_CONTACTS_MOST_NEAREST; ++k) {
        if (soft_is_alike(added, count, &picks.inside[k])) { continue; }
        soft_append(pass, near.node, near.margin, &picks.inside[k]);
        added[count++] = &picks.inside[k];
    }
}

// --------------------------------------------------------------------------------------------------------- the search

/* All nodes and faces with finite boxes that can meet. */
static void soft_collect_boxes(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    pli_bounds all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < pass->node_body->node_count; ++i) {
        const pli_bounds box = pass->node_body->node_boxes[i];
        if (!plii_soft_contacts_box_is_finite(box)) { continue; }
        search->nodes[search->node_count++] = soft_reach(pass, i);
        all = plii_bounds_join(all, box);
    }
    for (int i = 0; i < pass->face_body->topology->face_count; ++i) {
        const pli_bounds box = pass->face_body->face_boxes[i];
        if (!plii_bounds_overlap(box, all) || !plii_soft_contacts_box_is_finite(box)) { continue; }
        search->faces[search->face_count] = i;
        search->boxes[search->face_count++] = box;
    }
}

/* Nodes whose reach touches where the other body will be, and the faces there; predicted positions are finite. */
static void soft_collect_near(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    const pli_body *node_body = pass->node_body, *face_body = pass->face_body;
    const plii_float4 body_low = plii_lanes_from_vec3(&pass->other_bounds.min);
    const plii_float4 body_high = plii_lanes_from_vec3(&pass->other_bounds.max);
    plii_float4 low = plii_float4_all(INFINITY), high = plii_float4_all(-INFINITY);
    for (int i = 0; i < node_body->node_count; ++i) {
        const plii_soft_contacts_node near = soft_reach(pass, i);
        /* A little more, for what rounding takes away. */
        const plii_float4 x = plii_float4_from(&node_body->positions[i]), wide = plii_float4_all(near.reach * 1.0001f);
        const plii_float4 from = x - wide, to = x + wide;
        const plii_mask4 is_near = (from <= body_high) & (body_low <= to);
        if ((plii_lanes_bits(is_near) & PLII_LANES_XYZ) != PLII_LANES_XYZ) { continue; }
        search->nodes[search->node_count++] = near;
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
        const plii_mask4 is_near = (from <= high) & (low <= to);
        if ((plii_lanes_bits(is_near) & PLII_LANES_XYZ) != PLII_LANES_XYZ) { continue; }
        search->faces[search->face_count] = face_index;
        search->boxes[search->face_count++] = (pli_bounds){plii_lanes_vec3(from), plii_lanes_vec3(to)};
    }
}

/* Along the curve that the tree sorts by; good for as long as the body has these faces, however it bends. */
static bool soft_order_faces(const pli_body* body, plii_soft_contacts_state* state) {
    pli_context* context = body->context;
    const int face_count = body->topology->face_count;
    if (state->order_count == face_count) { return true; }
    plii_bvh tree = {0};
    const bool is_ordered = PLII_RESERVE(context, &state->face_order, &state->order_capacity, face_count) &&
                            plii_bvh_build_from(context, &tree, face_count, plii_body_face_box, body);
    if (is_ordered) {
        memcpy(state->face_order, tree.items, (size_t)face_count * sizeof *state->face_order);
        state->order_count = face_count;
    }
    plii_bvh_free(context, &tree);
    return is_ordered;
}

/* For a search in which a body takes part. */
static bool soft_reserve_search(pli_context* context, plii_soft_contacts_state* search, int nodes, int faces) {
    return PLII_RESERVE(context, &search->nodes, &search->node_capacity, nodes) &&
           PLII_RESERVE(context, &search->faces, &search->face_capacity, faces) &&
           PLII_RESERVE(context, &search->boxes, &search->box_capacity, faces) &&
           PLII_RESERVE(context, &search->hits, &search->hit_capacity, PLII_BVH4_ROOM(faces)) &&
           PLII_RESERVE(context, &search->groups, &search->group_capacity, PLII_BVH4_GROUP_ROOM(faces)) &&
           plii_bvh4_reserve(context, &search->near, faces);
}

/* Most nodes have one with each body near them. */
#define SOFT_CONTACTS_PER_NODE 4

void plii_soft_contacts_reserve(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    const pli_world* world = body->world;
    pli_context* context = body->context;
    if (!plii_feature_is_shared(body, &plii_soft_contacts_class)) { return; }
    const int room = SOFT_CONTACTS_PER_NODE * plii_body_contact_bound(body);
    (void)PLII_RESERVE(context, &state->contacts, &state->capacity, room);
    bool is_recorded = false;
    for (PLII_EACH_BODY(other, world)) {
        is_recorded = is_recorded || other->records_contacts;
    }
    if (is_recorded) { (void)PLII_RESERVE(context, &state->impulses.items, &state->impulses.capacity, room); }
    if (body->records_contacts) { (void)PLII_RESERVE(context, &state->met, &state->met_capacity, world->body_count); }
    /* Made later, from other positions, the order is another one. */
    if (state->is_sweeping && body->topology->face_count > 0 && !soft_order_faces(body, state)) {
        plii_world_note_shortage(body->world);
    }
    /* The first body of a pair searches for both. */
    if (body->world_index + 1 < world->body_count) {
        (void)soft_reserve_search(context, state, world->most_nodes, world->most_faces);
    }
}

/* Nodes and faces that can be near each other, and what finds the faces. False when out of memory. */
static bool soft_collect(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    pli_context* context = pass->node_body->context;
    const int face_count = pass->face_body->topology->face_count;
    search->node_count = search->face_count = 0;
    if (!soft_reserve_search(context, search, pass->node_body->node_count, face_count)) { return false; }
    if (pass->use_boxes) { soft_collect_boxes(pass); }
    if (!pass->use_boxes && !soft_order_faces(pass->face_body, pass->face_state)) { return false; }
    if (!pass->use_boxes) { soft_collect_near(pass); }
    return plii_bvh4_build(context, &search->near, search->face_count, search->boxes, NULL);
}

static void soft_run_boxes(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    for (int i = 0; search->face_count > 0 && i < search->node_count; ++i) {
        const plii_soft_contacts_node near = search->nodes[i];
        const int count = plii_bvh4_overlaps(&search->near, &pass->node_body->node_boxes[near.node], 0, search->hits);
        for (int k = 0; k < count; ++k) {
            soft_test(pass, near.node, near.reach, search->faces[search->hits[k]]);
        }
    }
}

/* Nodes that look for faces together. */
enum { SOFT_CONTACTS_TOGETHER = 8 };

static pli_bounds soft_looked_at(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near) {
    const pli_vec3 x = plii_xyz(pass->node_body->positions[near.node]);
    return plii_bounds_grow((pli_bounds){x, x}, near.reach * 1.0001f);
}

/* Of the nodes from `first` on, those that follow each other in space too. */
static int soft_gather(const plii_soft_contacts_pass* pass, int first, pli_bounds* all) {
    const plii_soft_contacts_state* search = pass->search;
    const pli_vec3 face = pli_vec3_sub(search->boxes[0].max, search->boxes[0].min); /* others are hardly larger */
    const float wide = 2.0f * search->nodes[first].reach, size = plii_max(face.x, plii_max(face.y, face.z));
    const float most = wide + plii_max(wide, 2.0f * size);
    *all = soft_looked_at(pass, search->nodes[first]);
    int end = first + 1;
    for (; end < search->node_count && end - first < SOFT_CONTACTS_TOGETHER; ++end) {
        const pli_bounds both = plii_bounds_join(*all, soft_looked_at(pass, search->nodes[end]));
        const pli_vec3 extent = pli_vec3_sub(both.max, both.min);
        if (!(plii_max(extent.x, plii_max(extent.y, extent.z)) <= most)) { break; }
        *all = both;
    }
    return end;
}

static void soft_run_near(const plii_soft_contacts_pass* pass) {
    plii_soft_contacts_state* search = pass->search;
    for (int first = 0, end; search->face_count > 0 && first < search->node_count; first = end) {
        pli_bounds all;
        end = soft_gather(pass, first, &all);
        const int group_count = plii_bvh4_overlaps(&search->near, &all, 1, search->groups);
        for (int i = first; i < end && group_count > 0; ++i) {
            const plii_soft_contacts_node near = search->nodes[i];
            const pli_vec3 x = plii_xyz(pass->node_body->positions[near.node]);
            search->hit_count = plii_bvh4_find(&search->near, search->groups, group_count, x, near.reach, search->hits);
            soft_add_nearest(pass, near);
        }
    }
}

void plii_soft_contacts_collide(pli_body* body, void* data, pli_body* other, void* other_data) {
    plii_soft_contacts_state *state = data, *other_state = other_data;
    const int count = state->count, other_count = other_state->count;
    const bool use_boxes = !state->is_sweeping && !other_state->is_sweeping;
    const bool may_be_inside = !use_boxes && plii_soft_contacts_may_be_inside(body, other);
    for (int i = 0; i < 2; ++i) { /* nodes of the one, then of the other */
        plii_soft_contacts_pass pass = {.node_body = i == 0 ? body : other,
                                        .node_state = i == 0 ? state : other_state,
                                        .face_body = i == 0 ? other : body,
                                        .face_state = i == 0 ? other_state : state,
                                        .search = state,
                                        .margin = body->collision_margin + other->collision_margin,
                                        .fall = plii_step_fall(body),
                                        .use_boxes = use_boxes,
                                        .is_second = i == 1,
                                        .looks_inside = may_be_inside};
        if (pass.face_body->topology->face_count == 0) { continue; }
        if (!use_boxes) {
            pass.other_motion = plii_body_measure_motion(pass.face_body, &pass.common_motion, &pass.other_bounds);
        }
        if (soft_collect(&pass)) { (use_boxes ? soft_run_boxes : soft_run_near)(&pass); }
    }
    if (may_be_inside) { plii_soft_contacts_part(body, state, count, other, other_state, other_count); }
    soft_meet(body, state, other);
    soft_meet(other, other_state, body);
    if (!use_boxes && (state->count > count || other_state->count > other_count)) {
        plii_world_join_bodies(body->world, body, other);
    }
}
