/* Contacts of faces (of links where a body has no faces) with convex rigid shapes, which btSoftBody lacks.

   Conservative advancement (Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996) finds where on the
   way of a step a face comes near a shape; the normal of that moment makes the contact, which keeps the face on the
   side that it came from however fast the two are. Faces that overlap a core from the start are pushed out the shortest
   way.

   The solve is that of node contacts with a point of the face in the place of the node, but looks at the gap between
   this point and the shape that will be left along the normal at the end of the step: a contact that is not needed does
   nothing. It has the last word after links, and looks again for what the solve itself has brought about. */

#include "body_impl.h"
#include "convex_distance.h"
#include "convex_penetration.h"
#include "pliant/contact.h"
#include "rigid_impl.h"
#include "shape_impl.h"
#include "world_impl.h"

#define RIGID_FACES_MAX_ADVANCES 24
#define RIGID_FACES_SMALLEST_SLACK 1e-3f /* of the longest edge */
#define RIGID_FACES_LAST_SWEEPS 12
#define RIGID_FACES_REVIEWS 8

typedef struct rigid_face_contact {
    pli_rigid* rigid;
    int meeting;        /* while the step lasts */
    int shape, element; /* index in the rigid body's shapes; face, or link */
    int nodes[3];
    pli_vec3 weights;
    pli_vec3 normal;     /* out of the rigid body */
    pli_vec3 start;      /* of the step: the witness point of the face */
    pli_vec3 core_point; /* nearest point of the core, in the frame of the rigid body */
    float target;        /* of the gap at the end of the step; m, <= 0 */
    float distance;
    float slip; /* share of the tangential displacement that stays */
    /* Set before the iterations. */
    pli_mat3 impulse_matrix;
    pli_vec3 lever; /* from the rigid body's centre of mass to its surface, at the end of the step */
    pli_vec3 base;  /* base + velocity at the lever * dt = that point of the surface at the end of the step */
} rigid_face_contact;

/* A rigid shape that was met in this step. The host may change the shapes of the rigid body before the solve. */
typedef struct rigid_faces_meeting {
    pli_rigid* rigid;
    int shape_index;
    pli_shape* shape; /* retained until the end of the step */
    pli_transform shape_pose;
    unsigned pose_version;
    pli_transform begin; /* pose of the rigid body at the start of the step */
} rigid_faces_meeting;

typedef struct rigid_faces_state {
    pli_rigid_face_contacts_def def;
    rigid_face_contact* contacts;
    int count, capacity;
    rigid_faces_meeting* meetings;
    int meeting_count, meeting_capacity;
} rigid_faces_state;

pli_rigid_face_contacts_def pli_rigid_face_contacts_def_default(void) {
    pli_rigid_face_contacts_def def = {0};
    def.friction = 0.2f;
    def.dynamic_hardness = 1.0f;
    def.static_hardness = 0.1f;
    def.cookie = PLII_DEF_COOKIE;
    return def;
}

// --------------------------------------------------------------------------------------------------- the way of a face

/* A face and a shape, both relative to the moving centre of mass of the rigid body. */
typedef struct rigid_faces_pair {
    const pli_shape* shape;
    pli_transform shape_pose;  /* in the frame of the rigid body */
    pli_mat3 rotation;         /* of the rigid body at the start */
    pli_vec3 turn;             /* its rotation during the step */
    float reach;               /* of the core from the centre of mass, m */
    pli_vec3 begin[3], end[3]; /* corners */
    float target;              /* distance from the core at which a contact is made, m > 0 */
    float tolerance;           /* of the target, m */
    float margin;              /* of the surface, m */
    float hardness;
    bool is_link;
    bool is_review; /* only what is too near at the end counts, and what is near from the start must come nearer */
} rigid_faces_pair;

typedef struct rigid_faces_hit {
    pli_vec3 normal;     /* from the shape to the face */
    pli_vec3 point;      /* of the face at that moment */
    pli_vec3 core_point; /* in the frame of the rigid body */
    pli_vec3 corners[3]; /* of the face at that moment */
    pli_vec3 weights;
    float begin_gap;           /* distance of the surfaces at the start, minus the margin */
    float end_gap, target_gap; /* of the point along the normal, minus the margin */
} rigid_faces_hit;

/* A core at its place. */
typedef struct rigid_faces_core {
    const pli_shape* shape;
    pli_transform pose;
} rigid_faces_core;

static pli_vec3 rigid_faces_core_support(const void* user, pli_vec3 direction) {
    const rigid_faces_core* core = user;
    const pli_vec3 local = pli_mat3_mul_vec3(pli_mat3_transpose(core->pose.rotation), direction);
    return pli_transform_point(core->pose, core->shape->def.support(core->shape->def.user, local));
}

static rigid_faces_core rigid_faces_core_at(const rigid_faces_pair* pair, float time) {
    const pli_transform begin = {pair->rotation, {0, 0, 0}};
    const pli_transform pose = plii_rigid_advance(begin, pli_vec3_make(0, 0, 0), pair->turn, time);
    return (rigid_faces_core){pair->shape, pli_transform_mul(pose, pair->shape_pose)};
}

/* How far the surface reaches along `normal`. */
static float rigid_faces_height(const rigid_faces_core* core, pli_vec3 normal) {
    return pli_vec3_dot(rigid_faces_core_support(core, normal), normal) + core->shape->def.radius;
}

static pli_vec3 rigid_faces_support(const void* user, pli_vec3 direction) {
    const pli_vec3* corners = user;
    int farthest = 0;
    float most = pli_vec3_dot(corners[0], direction);
    for (int k = 1; k < 3; ++k) {
        const float along = pli_vec3_dot(corners[k], direction);
        if (along > most) {
            most = along;
            farthest = k;
        }
    }
    return corners[farthest];
}

/* How much nearer face and core may come along `normal` on the whole way. */
static float rigid_faces_approach(const rigid_faces_pair* pair, pli_vec3 normal) {
    float approach = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        approach = plii_max(approach, -pli_vec3_dot(normal, pli_vec3_sub(pair->end[k], pair->begin[k])));
    }
    return approach + pli_vec3_length(pair->turn) * pair->reach;
}

static float rigid_faces_longest_way(const rigid_faces_pair* pair) {
    float longest = 0.0f;
    for (int k = 0; k < 3; ++k) {
        longest = plii_max(longest, pli_vec3_length(pli_vec3_sub(pair->end[k], pair->begin[k])));
    }
    return longest + pli_vec3_length(pair->turn) * pair->reach;
}

/* Where `point` lies between the corners; false for faces without area. A link has twice the same last corner. */
static bool rigid_faces_weights(const pli_vec3* corners, bool is_link, pli_vec3 point, pli_vec3* weights) {
    const pli_vec3 ab = pli_vec3_sub(corners[1], corners[0]), ac = pli_vec3_sub(corners[2], corners[0]);
    const pli_vec3 ap = pli_vec3_sub(point, corners[0]);
    if (is_link) {
        const float t = plii_clamp(pli_vec3_dot(ap, ab) / pli_vec3_length_squared(ab), 0.0f, 1.0f);
        *weights = pli_vec3_make(1.0f - t, t, 0.0f);
    } else {
        const pli_vec3 n = pli_vec3_cross(ab, ac);
        const float inverse = 1.0f / pli_vec3_length_squared(n);
        const float v = plii_max(pli_vec3_dot(pli_vec3_cross(ap, ac), n) * inverse, 0.0f);
        const float w = plii_max(pli_vec3_dot(pli_vec3_cross(ab, ap), n) * inverse, 0.0f);
        const float sum = plii_max(v + w, 1.0f);
        *weights = pli_vec3_make(plii_max(1.0f - v - w, 0.0f), v / sum, w / sum);
    }
    return plii_vec3_is_finite(*weights);
}

static pli_vec3 rigid_faces_blend(const pli_vec3* values, pli_vec3 weights) {
    return pli_vec3_add(pli_vec3_add(pli_vec3_scale(values[0], weights.x), pli_vec3_scale(values[1], weights.y)),
                        pli_vec3_scale(values[2], weights.z));
}

/* Weights and gaps of a hit. False for faces without area. */
static bool rigid_faces_measure(const rigid_faces_pair* pair, rigid_faces_hit* hit) {
    if (!rigid_faces_weights(hit->corners, pair->is_link, hit->point, &hit->weights)) { return false; }
    const rigid_faces_core core = rigid_faces_core_at(pair, 1.0f);
    const float along_normal = pli_vec3_dot(hit->normal, rigid_faces_blend(pair->end, hit->weights));
    hit->end_gap = along_normal - rigid_faces_height(&core, hit->normal) - pair->margin;
    hit->target_gap = plii_min(hit->begin_gap, 0.0f) * (1.0f - pair->hardness);
    return plii_is_finite(hit->target_gap) && plii_is_finite(hit->end_gap);
}

/* False when face and shape stay apart. */
static bool rigid_faces_advance(const rigid_faces_pair* pair, rigid_faces_hit* hit) {
    rigid_faces_core core;
    plii_convex rigid = {rigid_faces_core_support, &core, {0, 0, 0}, pair->shape->def.radius};
    pli_vec3* corners = hit->corners;
    plii_convex face = {.support = rigid_faces_support, .user = corners};
    plii_convex_options options = plii_convex_options_default();
    options.max_distance = pair->target + rigid_faces_longest_way(pair);
#if PLIANT_WITH_CCD
    options.penetration = plii_penetration_mpr;
#endif
    plii_convex_cache cache = {0};
    float time = 0.0f, target = pair->target, tolerance = pair->tolerance;
    for (int i = 0; i < RIGID_FACES_MAX_ADVANCES; ++i) {
        for (int k = 0; k < 3; ++k) {
            const pli_vec3 way = pli_vec3_sub(pair->end[k], pair->begin[k]);
            corners[k] = pli_vec3_add(pair->begin[k], pli_vec3_scale(way, time));
        }
        core = rigid_faces_core_at(pair, time);
        rigid.centre = core.pose.origin;
        face.centre = pli_vec3_scale(pli_vec3_add(pli_vec3_add(corners[0], corners[1]), corners[2]), 1.0f / 3.0f);
        plii_convex_result result;
        plii_convex_distance(&face, &rigid, &options, &cache, &result);
        if (result.relation == PLII_CONVEX_UNDEFINED || result.relation == PLII_CONVEX_BEYOND) { return false; }
        /* On the way cores cannot overlap but for rounding: then the moment before counts. */
        if (result.relation == PLII_CONVEX_OVERLAPPING && i > 0) { break; }
        if (i == 0) { hit->begin_gap = result.distance - rigid.radius - pair->margin; }
        if (pair->is_review && i == 0) {
            if (result.relation == PLII_CONVEX_OVERLAPPING) { return false; }
            target = plii_min(target, 0.5f * result.distance);
            tolerance = plii_min(tolerance, 0.25f * target);
        }
        hit->point = result.point_a;
        hit->core_point = pli_transform_point(pair->shape_pose, pli_transform_inverse_point(core.pose, result.point_b));
        hit->normal = result.normal;
        if (!(result.distance - target > tolerance)) {
            if (!rigid_faces_measure(pair, hit)) { return false; }
            if (!pair->is_review || hit->end_gap < hit->target_gap) { return true; }
            /* This point of the face gets out of the way in time, others may not. */
            target *= 0.5f;
            tolerance = 0.25f * target;
            continue;
        }
        const float gap = result.distance - target;
        const float approach = rigid_faces_approach(pair, result.normal);
        if (!(approach * (1.0f - time) > gap)) { return false; }
        time += gap / approach;
    }
    return rigid_faces_measure(pair, hit) && (!pair->is_review || hit->end_gap < hit->target_gap);
}

// ---------------------------------------------------------------------------------------------------- making contacts

static pli_vec3 rigid_faces_point(const pli_vec4* positions, const rigid_face_contact* contact) {
    pli_vec3 corners[3];
    for (int k = 0; k < 3; ++k) {
        corners[k] = plii_xyz(positions[contact->nodes[k]]);
    }
    return rigid_faces_blend(corners, contact->weights);
}

/* Of the witness point of the face. */
static float rigid_faces_inverse_mass(const pli_body* body, const rigid_face_contact* contact) {
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    float sum = 0.0f;
    for (int k = 0; k < 3; ++k) {
        sum += weights[k] * weights[k] * body->positions[contact->nodes[k]].w;
    }
    return sum;
}

/* What one rigid shape does in the step. */
typedef struct rigid_faces_pass {
    pli_body* body;
    rigid_faces_state* state;
    const rigid_faces_meeting* meeting;
    int meeting_index;
    float hardness;
    bool has_links;           /* elements are links */
    bool is_review;           /* after the iterations: only contacts that are still violated */
    pli_transform begin, end; /* poses of the rigid body */
    pli_vec3 turn;
    float core_reach;
    pli_bounds bounds; /* of the shape on its way */
} rigid_faces_pass;

/* Lever, base and response, with the rigid body at the end of the step. */
static void rigid_faces_prepare_contact(const pli_body* body, const rigid_faces_meeting* meeting, pli_transform end,
                                        rigid_face_contact* contact) {
    const pli_rigid* rigid = contact->rigid;
    const float dt = body->step.dt;
    const pli_transform turned = {end.rotation, {0, 0, 0}};
    const rigid_faces_core core = {meeting->shape, pli_transform_mul(turned, meeting->shape_pose)};
    const pli_vec3 n = contact->normal;
    const pli_vec3 arm = pli_mat3_mul_vec3(end.rotation, contact->core_point);
    const float height = rigid_faces_height(&core, n);
    contact->lever = pli_vec3_add(arm, pli_vec3_scale(n, height - pli_vec3_dot(n, arm)));
    contact->base = pli_vec3_sub(pli_vec3_add(end.origin, contact->lever),
                                 pli_vec3_scale(plii_rigid_velocity_at(rigid, contact->lever), dt));
    contact->impulse_matrix =
        plii_impulse_matrix(dt, rigid_faces_inverse_mass(body, contact), rigid->state.inverse_mass,
                            rigid->state.inverse_inertia_world, contact->lever);
}

/* Friction as for node contacts. */
static float rigid_faces_slip(const rigid_faces_pass* pass, const rigid_face_contact* contact) {
    const pli_rigid* rigid = contact->rigid;
    const pli_vec3 rigid_motion = pli_vec3_scale(plii_rigid_velocity_at(rigid, contact->lever), pass->body->step.dt);
    const pli_vec3 face_motion = pli_vec3_sub(rigid_faces_point(pass->body->positions, contact), contact->start);
    const pli_vec3 motion = pli_vec3_sub(face_motion, rigid_motion);
    const float along_normal = pli_vec3_dot(motion, contact->normal);
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(contact->normal, along_normal));
    const float friction = pass->state->def.friction * rigid->friction;
    const bool sticks = pli_vec3_length_squared(sliding) < along_normal * friction * along_normal * friction;
    return sticks ? 0.0f : 1.0f - friction;
}

static pli_status rigid_faces_add(const rigid_faces_pass* pass, int element, const int* nodes,
                                  const rigid_faces_hit* hit) {
    pli_body* body = pass->body;
    rigid_faces_state* state = pass->state;
    pli_rigid* rigid = pass->meeting->rigid;
    rigid_face_contact contact = {.rigid = rigid,
                                  .meeting = pass->meeting_index,
                                  .shape = pass->meeting->shape_index,
                                  .element = element,
                                  .nodes = {nodes[0], nodes[1], nodes[2]}};
    contact.weights = hit->weights;
    if (!(rigid_faces_inverse_mass(body, &contact) + rigid->state.inverse_mass > 0.0f)) { return PLI_OK; }
    contact.distance = hit->end_gap;
    contact.normal = hit->normal;
    contact.core_point = hit->core_point;
    contact.start = rigid_faces_point(body->previous, &contact);
    contact.target = hit->target_gap;
    rigid_faces_prepare_contact(body, pass->meeting, pass->end, &contact);
    contact.slip = rigid_faces_slip(pass, &contact);
    if (!PLII_RESERVE(body->context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d contacts", state->count + 1);
    }
    state->contacts[state->count++] = contact;
    rigid->was_touched = true;
    return PLI_OK;
}

static bool rigid_faces_is_anchored(const pli_body* body, const int* nodes) {
    return body->anchored != NULL && (body->anchored[nodes[0]] | body->anchored[nodes[1]] | body->anchored[nodes[2]]);
}

static pli_status rigid_faces_collide_element(const rigid_faces_pass* pass, int element, const int* nodes) {
    const pli_body* body = pass->body;
    const float margin = body->collision_margin;
    pli_bounds swept = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 before = plii_xyz(body->previous[nodes[k]]), after = plii_xyz(body->positions[nodes[k]]);
        swept.min = plii_vec3_min(plii_vec3_min(before, after), swept.min);
        swept.max = plii_vec3_max(plii_vec3_max(before, after), swept.max);
    }
    const float edge = pli_vec3_length(pli_vec3_sub(swept.max, swept.min));
    const float slack = plii_max(0.5f * margin, RIGID_FACES_SMALLEST_SLACK * edge);
    if (!plii_bounds_overlap(plii_bounds_grow(swept, margin + slack), pass->bounds)) { return PLI_OK; }
    if (rigid_faces_is_anchored(body, nodes)) { return PLI_OK; }
    rigid_faces_pair pair = {.shape = pass->meeting->shape,
                             .shape_pose = pass->meeting->shape_pose,
                             .rotation = pass->begin.rotation,
                             .turn = pass->turn,
                             .reach = pass->core_reach,
                             .tolerance = 0.25f * slack,
                             .margin = margin,
                             .hardness = pass->hardness,
                             .is_link = pass->has_links,
                             .is_review = pass->is_review};
    pair.target = pair.shape->def.radius + margin + slack;
    for (int k = 0; k < 3; ++k) {
        pair.begin[k] = pli_vec3_sub(plii_xyz(body->previous[nodes[k]]), pass->begin.origin);
        pair.end[k] = pli_vec3_sub(plii_xyz(body->positions[nodes[k]]), pass->end.origin);
    }
    rigid_faces_hit hit;
    return rigid_faces_advance(&pair, &hit) ? rigid_faces_add(pass, element, nodes, &hit) : PLI_OK;
}

static pli_status rigid_faces_collide_elements(const rigid_faces_pass* pass) {
    const pli_body* body = pass->body;
    if (!pass->has_links) {
        for (int i = 0; i < body->topology->face_count; ++i) {
            PLII_TRY(rigid_faces_collide_element(pass, i, body->topology->faces[i]));
        }
        return PLI_OK;
    }
    for (int i = 0; i < body->link_count; ++i) {
        const bool is_bending = body->link_tags != NULL && (body->link_tags[i] & PLII_LINK_TAG_BENDING) != 0;
        const int nodes[3] = {body->links[i].nodes[0], body->links[i].nodes[1], body->links[i].nodes[1]};
        if (!is_bending) { PLII_TRY(rigid_faces_collide_element(pass, i, nodes)); }
    }
    return PLI_OK;
}

/* Where the body will be at the end of the step. One that has a new pose since the collision was moved by its host, and
   will once more be moved by what the solve changed; see pli_rigid_was_held_back. */
static pli_transform rigid_faces_end_pose(const rigid_faces_meeting* meeting, float dt) {
    const pli_rigid* rigid = meeting->rigid;
    const pli_rigid_state* state = &rigid->state;
    if (rigid->pose_version == meeting->pose_version) {
        return plii_rigid_advance(state->pose, state->linear_velocity, state->angular_velocity, dt);
    }
    const pli_vec3 linear = pli_vec3_sub(state->linear_velocity, rigid->given_linear_velocity);
    const pli_vec3 angular = pli_vec3_sub(state->angular_velocity, rigid->given_angular_velocity);
    return plii_rigid_advance(state->pose, linear, angular, dt);
}

/* How far a point at the distance `reach` from the centre may leave the box around both ends of its way. */
static float rigid_faces_bulge(float reach, float angle) {
    return angle < 3.0f ? reach * (1.0f - cosf(0.5f * angle)) : 2.0f * reach;
}

static rigid_faces_pass rigid_faces_make_pass(pli_body* body, rigid_faces_state* state,
                                              const rigid_faces_meeting* meeting, int meeting_index) {
    const pli_rigid* rigid = meeting->rigid;
    const pli_shape* shape = meeting->shape;
    const pli_transform shape_pose = meeting->shape_pose;
    const bool is_dynamic = rigid->kind == PLI_RIGID_DYNAMIC;
    rigid_faces_pass pass = {.body = body,
                             .state = state,
                             .meeting = meeting,
                             .meeting_index = meeting_index,
                             .hardness = is_dynamic ? state->def.dynamic_hardness : state->def.static_hardness,
                             .has_links = body->topology->face_count == 0,
                             .begin = meeting->begin,
                             .end = rigid_faces_end_pose(meeting, body->step.dt),
                             .turn = pli_vec3_scale(rigid->state.angular_velocity, body->step.dt)};
    const pli_bounds local = shape->def.bounds(shape->def.user);
    const pli_vec3 centre = pli_transform_point(shape_pose, pli_vec3_scale(pli_vec3_add(local.min, local.max), 0.5f));
    const float radius = shape->def.radius;
    const pli_vec3 core =
        pli_vec3_sub(pli_vec3_sub(local.max, local.min), pli_vec3_make(2 * radius, 2 * radius, 2 * radius));
    pass.core_reach = pli_vec3_length(centre) + 0.5f * pli_vec3_length(core);
    const pli_bounds before = plii_bounds_transform(local, pli_transform_mul(pass.begin, shape_pose));
    const pli_bounds after = plii_bounds_transform(local, pli_transform_mul(pass.end, shape_pose));
    const float bulge = rigid_faces_bulge(pass.core_reach, pli_vec3_length(pass.turn));
    pass.bounds.min = plii_vec3_min(before.min, after.min);
    pass.bounds.max = plii_vec3_max(before.max, after.max);
    pass.bounds = plii_bounds_grow(pass.bounds, bulge);
    return pass;
}

static void rigid_faces_forget_meetings(rigid_faces_state* state, int count) {
    while (state->meeting_count > count) {
        pli_shape_release(state->meetings[--state->meeting_count].shape);
    }
}

static pli_status rigid_faces_collide_shape(pli_body* body, rigid_faces_state* state, pli_rigid* rigid, int index) {
    if (rigid->shapes[index]->def.support == NULL) { return PLI_OK; }
    const int count = state->meeting_count;
    if (!PLII_RESERVE(body->context, &state->meetings, &state->meeting_capacity, count + 1)) {
        return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d shapes", count + 1);
    }
    rigid_faces_meeting* meeting = &state->meetings[count];
    *meeting = (rigid_faces_meeting){.rigid = rigid,
                                     .shape_index = index,
                                     .shape = rigid->shapes[index],
                                     .shape_pose = rigid->shape_poses[index],
                                     .pose_version = rigid->pose_version,
                                     .begin = rigid->state.pose};
    const rigid_faces_pass pass = rigid_faces_make_pass(body, state, meeting, count);
    if (!plii_bounds_overlap(plii_bounds_grow(pass.bounds, body->collision_margin), body->bounds)) { return PLI_OK; }
    pli_shape_retain(meeting->shape);
    ++state->meeting_count;
    return rigid_faces_collide_elements(&pass);
}

static pli_status rigid_faces_collide(pli_body* body, void* data, pli_rigid* rigid) {
    rigid_faces_state* state = data;
    const int before = state->count, meetings_before = state->meeting_count;
    const bool was_touched = rigid->was_touched;
    for (int i = 0; i < rigid->shape_count; ++i) {
        const pli_status status = rigid_faces_collide_shape(body, state, rigid, i);
        if (status != PLI_OK) {
            state->count = before;
            rigid_faces_forget_meetings(state, meetings_before);
            rigid->was_touched = was_touched;
            return status;
        }
    }
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------------------------ solving

/* Contacts stand in the order of the meetings. */
static void rigid_faces_prepare(pli_body* body, void* data, const plii_step* step) {
    rigid_faces_state* state = data;
    int next = 0;
    for (int i = 0; i < state->meeting_count; ++i) {
        const rigid_faces_meeting* meeting = &state->meetings[i];
        const pli_transform end = rigid_faces_end_pose(meeting, step->dt);
        for (; next < state->count && state->contacts[next].meeting == i; ++next) {
            rigid_faces_prepare_contact(body, meeting, end, &state->contacts[next]);
        }
    }
}

static void rigid_faces_push(pli_body* body, const rigid_face_contact* contact, pli_vec3 impulse, float dt,
                             bool with_velocities) {
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    for (int k = 0; k < 3; ++k) {
        const int node = contact->nodes[k];
        pli_vec4* position = &body->positions[node];
        const pli_vec3 change = pli_vec3_scale(impulse, weights[k] * position->w);
        plii_set_xyz(position, pli_vec3_sub(plii_xyz(*position), pli_vec3_scale(change, dt)));
        if (with_velocities) {
            pli_vec4* velocity = &body->velocities[node];
            plii_set_xyz(velocity, pli_vec3_sub(plii_xyz(*velocity), change));
        }
    }
}

/* False when no contact had anything to do. */
static bool rigid_faces_sweep(pli_body* body, const rigid_faces_state* state, float dt, bool with_velocities) {
    bool has_acted = false;
    for (int i = 0; i < state->count; ++i) {
        const rigid_face_contact* contact = &state->contacts[i];
        const pli_vec3 n = contact->normal;
        const pli_vec3 point = rigid_faces_point(body->positions, contact);
        const pli_vec3 rigid_motion = pli_vec3_scale(plii_rigid_velocity_at(contact->rigid, contact->lever), dt);
        const pli_vec3 apart = pli_vec3_sub(point, pli_vec3_add(contact->base, rigid_motion));
        const float gap = pli_vec3_dot(n, apart) - body->collision_margin;
        if (!(gap < contact->target)) { continue; }
        const pli_vec3 motion = pli_vec3_sub(pli_vec3_sub(point, contact->start), rigid_motion);
        const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
        const pli_vec3 error =
            pli_vec3_add(pli_vec3_scale(sliding, 1.0f - contact->slip), pli_vec3_scale(n, gap - contact->target));
        const pli_vec3 impulse = pli_mat3_mul_vec3(contact->impulse_matrix, error);
        rigid_faces_push(body, contact, impulse, dt, with_velocities);
        plii_rigid_apply_impulse(contact->rigid, impulse, contact->lever);
        contact->rigid->was_held_back = true;
        has_acted = true;
    }
    return has_acted;
}

static void rigid_faces_solve(pli_body* body, void* data, const plii_step* step) {
    (void)rigid_faces_sweep(body, data, step->dt, false);
}

/* Contacts that the motion before the solve did not foresee. Returns how many there are. */
static int rigid_faces_review(pli_body* body, rigid_faces_state* state) {
    const int before = state->count;
    for (int i = 0; i < state->meeting_count; ++i) {
        rigid_faces_pass pass = rigid_faces_make_pass(body, state, &state->meetings[i], i);
        pass.is_review = true;
        if (rigid_faces_collide_elements(&pass) != PLI_OK) { break; }
    }
    return state->count - before;
}

/* Links that were solved after the contacts may have pulled faces through a body. */
static void rigid_faces_finish(pli_body* body, void* data, const plii_step* step) {
    rigid_faces_state* state = data;
    if (state->meeting_count == 0) { return; }
    for (int i = 0; i < RIGID_FACES_REVIEWS; ++i) {
        for (int k = 0; k < RIGID_FACES_LAST_SWEEPS; ++k) {
            if (!rigid_faces_sweep(body, state, step->dt, true)) { break; }
        }
        /* Drift iterations lose the start of the step. */
        if (body->solver.drift_iterations > 0 || rigid_faces_review(body, state) == 0) { break; }
    }
    rigid_faces_forget_meetings(state, 0);
}

// -------------------------------------------------------------------------------------------------------- the feature

static void rigid_faces_forget_all(rigid_faces_state* state) {
    state->count = 0;
    rigid_faces_forget_meetings(state, 0);
}

static void rigid_faces_clear(pli_body* body, void* data, const plii_step* step) {
    (void)body;
    (void)step;
    rigid_faces_forget_all(data);
}

static void rigid_faces_forget_rigid(pli_body* body, void* data, const pli_rigid* rigid) {
    rigid_faces_state* state = data;
    (void)body;
    int kept = 0;
    for (int i = 0; i < state->count; ++i) {
        if (state->contacts[i].rigid != rigid) { state->contacts[kept++] = state->contacts[i]; }
    }
    state->count = kept;
}

static pli_status rigid_faces_enable(pli_body* body, void* data) {
    (void)data;
    ++body->sweeping_features;
    return PLI_OK;
}

static void rigid_faces_disable(pli_body* body, void* data) {
    rigid_faces_state* state = data;
    --body->sweeping_features;
    rigid_faces_forget_all(state);
    plii_release(body->context, state->contacts, (size_t)state->capacity * sizeof *state->contacts);
    plii_release(body->context, state->meetings, (size_t)state->meeting_capacity * sizeof *state->meetings);
}

static size_t rigid_faces_bytes(const pli_body* body, const void* data) {
    const rigid_faces_state* state = data;
    (void)body;
    return (size_t)state->capacity * sizeof *state->contacts +
           (size_t)state->meeting_capacity * sizeof *state->meetings;
}

static void rigid_faces_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    (void)body;
    (void)change;
    (void)blocks;
    rigid_faces_forget_all(data);
}

static const plii_feature_class rigid_faces_class = {
    .name = "rigid_face_contacts",
    .state_size = sizeof(rigid_faces_state),
    .stages = {[PLII_STAGE_UPDATE] = {rigid_faces_clear, PLII_ORDER_CLEAR_CONTACTS},
               [PLII_STAGE_PREPARE] = {rigid_faces_prepare, PLII_ORDER_RIGID_FACE_CONTACTS},
               [PLII_STAGE_POSITION] = {rigid_faces_solve, PLII_ORDER_RIGID_FACE_CONTACTS},
               [PLII_STAGE_FINISH] = {rigid_faces_finish, PLII_ORDER_RIGID_FACE_CONTACTS}},
    .enable = rigid_faces_enable,
    .disable = rigid_faces_disable,
    .collide_rigid = rigid_faces_collide,
    .forget_rigid = rigid_faces_forget_rigid,
    .bytes = rigid_faces_bytes,
    .topology_commit = rigid_faces_topology_commit,
};

static pli_status rigid_faces_check_hardness(pli_context* context, float hardness, const char* name,
                                             const char* function) {
    if (!plii_is_finite(hardness)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "%s is not finite", name);
    }
    if (!(hardness >= 0.0f && hardness <= 1.0f)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %g, not in [0, 1]", name, (double)hardness);
    }
    return PLI_OK;
}

static pli_status rigid_faces_check_def(pli_context* context, const pli_rigid_face_contacts_def* def,
                                        const char* function) {
    if (def == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "start from pli_rigid_face_contacts_def_default()");
    }
    if (!plii_is_finite(def->friction)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "friction is not finite");
    }
    if (!(def->friction >= 0.0f)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "friction is %g, it must not be negative",
                         (double)def->friction);
    }
    PLII_TRY(rigid_faces_check_hardness(context, def->dynamic_hardness, "dynamic_hardness", function));
    return rigid_faces_check_hardness(context, def->static_hardness, "static_hardness", function);
}

pli_status pli_body_enable_rigid_face_contacts(pli_body* body, const pli_rigid_face_contacts_def* def) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(rigid_faces_check_def(body->context, def, __func__));
    void* state = NULL;
    PLII_TRY(plii_feature_enable(body, &rigid_faces_class, &state));
    ((rigid_faces_state*)state)->def = *def;
    return PLI_OK;
}

void pli_body_disable_rigid_face_contacts(pli_body* body) {
    if (plii_check_body(body, __func__) == PLI_OK) { plii_feature_disable(body, &rigid_faces_class); }
}

int pli_body_get_rigid_face_contacts(const pli_body* body, int capacity, pli_rigid_face_contact* contacts) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const rigid_faces_state* state = plii_feature_state(body, &rigid_faces_class);
    if (state == NULL) { return 0; }
    const bool has_links = body->topology->face_count == 0;
    for (int i = 0; contacts != NULL && i < capacity && i < state->count; ++i) {
        const rigid_face_contact* contact = &state->contacts[i];
        contacts[i].face = has_links ? PLI_NULL_INDEX : contact->element;
        contacts[i].link = has_links ? contact->element : PLI_NULL_INDEX;
        contacts[i].weights[0] = contact->weights.x;
        contacts[i].weights[1] = contact->weights.y;
        contacts[i].weights[2] = contact->weights.z;
        contacts[i].rigid = contact->rigid;
        contacts[i].shape = contact->shape;
        contacts[i].normal = contact->normal;
        contacts[i].distance = contact->distance;
    }
    return state->count;
}
