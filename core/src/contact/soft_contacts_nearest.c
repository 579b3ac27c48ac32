/* Which of the faces near a node get a contact: the first one that the node crosses in the step, held on the side that
   it comes from; else the nearest one, and those whose own nearest point lies inside of them and that face another way.
   The others only repeat what these say. */

#include "contact/soft_contacts_impl.h"
#include "geometry/closest_point4.h"

/* Contacts of a node with one other body. */
enum { SOFT_CONTACTS_MOST_NEAREST = 3 };

/* Faces of one node look the same way when the cosine of their normals is above this. */
#define SOFT_CONTACTS_ALIKE 0.7f

/* Of the longest edge: a node that passes so close beside a face crosses it. */
#define SOFT_CONTACTS_EDGE 1e-3f

typedef struct soft_contacts_pick {
    int face;
    pli_vec3 weights, normal;
    float distance, time; /* m; share of the step at which it crosses */
} soft_contacts_pick;

/* Corners of a face as the node sees them. */
typedef struct soft_contacts_corners {
    pli_vec3 at[3];
} soft_contacts_corners;

static soft_contacts_corners soft_contacts_seen(const pli_vec4* faces, const int* face, pli_vec4 node) {
    soft_contacts_corners corners;
    for (int k = 0; k < 3; ++k) {
        corners.at[k] = pli_vec3_sub(plii_xyz(faces[face[k]]), plii_xyz(node));
    }
    return corners;
}

/* The nearest point of a face within reach. */
static bool soft_contacts_is_near(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, const int* face,
                                  const soft_contacts_corners* now, soft_contacts_pick* pick,
                                  plii_triangle_feature* feature) {
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
                                    : plii_soft_contacts_face_normal(pass, near.node, face, closest.weights);
    *feature = closest.feature;
    return true;
}

/* The node is on one side of the face at the start of the step and on the other one now, and meets it between. */
static bool soft_contacts_crosses(const plii_soft_contacts_pass* pass, int node, const int* face,
                                  const soft_contacts_corners* now, const plii_triangle_size* size,
                                  soft_contacts_pick* pick) {
    const soft_contacts_corners before =
        soft_contacts_seen(pass->face_body->previous, face, pass->node_body->previous[node]);
    const float to = -pli_vec3_dot(now->at[0], size->normal);
    const pli_vec3 cross =
        pli_vec3_cross(pli_vec3_sub(before.at[1], before.at[0]), pli_vec3_sub(before.at[2], before.at[0]));
    const float volume = -pli_vec3_dot(before.at[0], cross); /* six times that of the face and the node */
    if (!((volume > 0.0f && to < 0.0f) || (volume < 0.0f && to > 0.0f))) { return false; }
    const float from = volume / pli_vec3_length(cross);
    pick->time = from / (from - to);
    pli_vec3 met[3];
    for (int k = 0; k < 3; ++k) {
        met[k] = pli_vec3_add(pli_vec3_scale(before.at[k], 1.0f - pick->time), pli_vec3_scale(now->at[k], pick->time));
    }
    const plii_triangle_size size_met = plii_measure_triangle(met[0], met[1], met[2]);
    if (!size_met.is_usable) { return false; }
    plii_closest_feature closest;
    const pli_vec3 point = plii_closest_point_on_triangle(pli_vec3_make(0, 0, 0), met[0], met[1], met[2], &closest);
    const float edge = SOFT_CONTACTS_EDGE * SOFT_CONTACTS_EDGE;
    if (!(pli_vec3_length_squared(point) < edge * size_met.longest_squared)) { return false; }
    pick->weights = closest.weights;
    pick->normal = from > 0.0f ? size->normal : pli_vec3_neg(size->normal);
    return true;
}

/* Keeps the nearest ones that differ, the nearest first. */
static int soft_contacts_keep(soft_contacts_pick* kept, int count, const soft_contacts_pick* pick) {
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

static bool soft_contacts_is_alike(const soft_contacts_pick* kept, int count, const soft_contacts_pick* pick) {
    for (int k = 0; k < count; ++k) {
        if (pli_vec3_dot(kept[k].normal, pick->normal) > SOFT_CONTACTS_ALIKE) { return true; }
    }
    return false;
}

/* The faces of one node and one other body. */
typedef struct soft_contacts_picks {
    soft_contacts_pick crossed, nearest; /* INFINITY as time or distance: none */
    soft_contacts_pick inside[SOFT_CONTACTS_MOST_NEAREST];
    int inside_count;
} soft_contacts_picks;

static void soft_contacts_look_at(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near, int face_index,
                                  bool may_cross, soft_contacts_picks* picks) {
    const int* face = pass->face_body->topology->faces[face_index];
    const soft_contacts_corners now =
        soft_contacts_seen(pass->face_body->positions, face, pass->node_body->positions[near.node]);
    const plii_triangle_size size = plii_measure_triangle(now.at[0], now.at[1], now.at[2]);
    const float height = -pli_vec3_dot(now.at[0], size.normal);
    if (!size.is_usable || fabsf(height) > 1.001f * near.reach) { return; }
    soft_contacts_pick pick = {.face = face_index};
    if (may_cross && soft_contacts_crosses(pass, near.node, face, &now, &size, &pick)) {
        if (pick.time < picks->crossed.time) { picks->crossed = pick; }
        return;
    }
    plii_triangle_feature feature;
    if (!soft_contacts_is_near(pass, near, face, &now, &pick, &feature)) { return; }
    if (pick.distance < picks->nearest.distance) { picks->nearest = pick; }
    if (feature == PLII_TRIANGLE_FACE) {
        picks->inside_count = soft_contacts_keep(picks->inside, picks->inside_count, &pick);
    }
}

/* Of faces whose nearest point is on their rim only the nearest one counts. */
typedef struct soft_contacts_rim {
    float squared; /* of the distance, m^2 */
    int face_index;
} soft_contacts_rim;

/* A triangle this much longer than the reach is not measured in float. */
#define SOFT_CONTACTS_COARSE 1e3f

/* Faces that a node may have met in the step: only what is no farther than both moved. */
static int soft_contacts_may_cross(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near,
                                   const int* const faces[4], const plii_distance4* now) {
    const float edge = SOFT_CONTACTS_EDGE * SOFT_CONTACTS_EDGE;
    const plii_float4 most = now->longest_squared * (3.0f * edge) + 3.0f * near.motion * near.motion;
    if (plii_lanes_bits(now->squared <= most) == 0) { return 0; }
    const plii_triangle4 before =
        plii_triangle4_seen(pass->face_body->previous, faces, plii_xyz(pass->node_body->previous[near.node]));
    return plii_lanes_bits(plii_triangle4_volume(&before) * now->height <= 0.0f);
}

/* Looks at four faces from afar, and closer at those that the node may cross or whose nearest point lies inside. */
static void soft_contacts_look_at_four(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near,
                                       const int* face_indices, int count, soft_contacts_picks* picks,
                                       soft_contacts_rim* rim) {
    const pli_body *node_body = pass->node_body, *face_body = pass->face_body;
    const int* faces[4];
    for (int k = 0; k < 4; ++k) {
        faces[k] = face_body->topology->faces[face_indices[k < count ? k : 0]];
    }
    const plii_triangle4 now =
        plii_triangle4_seen(face_body->positions, faces, plii_xyz(node_body->positions[near.node]));
    const plii_distance4 distance = plii_triangle4_distance(&now);
    const float reach = 1.001f * near.reach, coarse = SOFT_CONTACTS_COARSE * near.reach;
    const plii_float4 height = distance.height, squared = distance.squared;
    const int low = plii_lanes_bits((height <= reach) & (height >= -reach));
    const int close = plii_lanes_bits(squared <= reach * reach);
    const int is_coarse = plii_lanes_bits(distance.longest_squared > coarse * coarse);
    const int crossed = is_coarse | soft_contacts_may_cross(pass, near, faces, &distance);
    const int wanted = distance.usable & low & ((1 << count) - 1);
    const int looked_at = wanted & (crossed | (close & distance.inside));
    for (int k = 0; k < count; ++k) {
        if (looked_at >> k & 1) {
            soft_contacts_look_at(pass, near, face_indices[k], (crossed >> k & 1) != 0, picks);
        } else if ((wanted & close) >> k & 1 && squared[k] < rim->squared) {
            *rim = (soft_contacts_rim){squared[k], face_indices[k]};
        }
    }
}

/* The faces near a node that are found. */
static soft_contacts_picks soft_contacts_look(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near) {
    const plii_soft_contacts_state* search = pass->search;
    soft_contacts_picks picks; /* what is not set is not read */
    picks.crossed.time = picks.nearest.distance = INFINITY;
    picks.inside_count = 0;
    soft_contacts_rim rim = {INFINITY, -1};
    for (int i = 0; i < search->hit_count; i += 4) {
        const int left = search->hit_count - i;
        soft_contacts_look_at_four(pass, near, &search->hits[i], left < 4 ? left : 4, &picks, &rim);
    }
    if (rim.squared < 1.001f * picks.nearest.distance * picks.nearest.distance) {
        soft_contacts_look_at(pass, near, rim.face_index, false, &picks);
    }
    return picks;
}

static pli_status soft_contacts_add(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near,
                                    const soft_contacts_pick* pick) {
    return plii_soft_contacts_append(pass, (plii_soft_contact){.node = near.node,
                                                               .face = pick->face,
                                                               .weights = pick->weights,
                                                               .normal = pick->normal,
                                                               .margin = near.margin});
}

pli_status plii_soft_contacts_add_nearest(const plii_soft_contacts_pass* pass, plii_soft_contacts_node near) {
    if (pass->search->hit_count == 0) { return PLI_OK; }
    const soft_contacts_picks picks = soft_contacts_look(pass, near);
    if (picks.crossed.time < INFINITY) { return soft_contacts_add(pass, near, &picks.crossed); }
    if (!(picks.nearest.distance < INFINITY)) { return PLI_OK; }
    PLII_TRY(soft_contacts_add(pass, near, &picks.nearest));
    if (picks.inside_count == 0) { return PLI_OK; }
    soft_contacts_pick added[SOFT_CONTACTS_MOST_NEAREST] = {picks.nearest};
    int count = 1;
    for (int k = 0; k < picks.inside_count && count < SOFT_CONTACTS_MOST_NEAREST; ++k) {
        if (soft_contacts_is_alike(added, count, &picks.inside[k])) { continue; }
        PLII_TRY(soft_contacts_add(pass, near, &picks.inside[k]));
        added[count++] = picks.inside[k];
    }
    return PLI_OK;
}
