/* Contacts of nodes with rigid bodies by signed distance (btSoftColliders::CollideSDF_RS, btSoftBody::checkContact)
   and their position solve (btSoftBody::PSolve_RContacts). Given the same distances, all results equal Bullet's bit
   for bit, but for the order of the contacts: shape by shape, ascending nodes. */

#include "body/node_constraint.h"
#include "body/pipeline.h"
#include "body/rigid_lanes.h"
#include "contact/contact_substep.h"
#include "contact/node_rigid_impl.h"
#include "math/bounds.h"
#include "pliant/bullet_reference.h"
#include "shape/shape_impl.h"

/* Nodes whose distances are asked in one call. */
#define RIGID_CONTACTS_BATCH 64
/* Shapes that nodes can be inside of are not deeper; a callback's distance is not believed beyond, m. */
#define RIGID_CONTACTS_MAX_DEPTH (4.0f * PLI_MAX_COORDINATE)
/* Of the margin, in sweeps: a node at rest that was not found would fall into the surface, and come back with speed. */
#define RIGID_CONTACTS_REACH 1.0f
/* Of the margin, how far a node may have started behind a surface before another one is looked for. */
#define RIGID_CONTACTS_BEHIND 0.25f
/* Of the margin, how far beyond it a node still touches. Planes of nodes that are only near would spread a cloth around
   a ball that falls into it, until it is through. */
#define RIGID_CONTACTS_TOUCHING 0.1f
/* Of the margin, what a rigid body moves in a step before it matters where on it a node is that goes along. */
#define RIGID_CONTACTS_MOVING 0.05f
/* Of its motion, what a node moves at most against a rigid body that it goes along with; or the margin. */
#define RIGID_CONTACTS_ALONG 0.33f

// ------------------------------------------------------------------------------------------------ making contacts

/* A body that meets a shape of a rigid body, and what all contacts of the two have in common. */
typedef struct rigid_contacts_candidate {
    pli_body* body;
    plii_rigid_contacts* state;
    pli_rigid* rigid;
    int shape;
    bool is_fixed, is_still; /* see plii_rigid_contact */
    bool is_swept;           /* as a substep: see plii_substep_class */
    bool is_as_in_bullet;
    bool is_moving; /* as `motion` tells, m and rad, from its pose to where it ends up in the step */
    plii_twist motion;
    float reach;             /* m, beyond the margin */
    float reach_along;       /* likewise, of nodes that go along */
    const pli_bounds* boxes; /* of all nodes, as Bullet has them; NULL: candidates are nodes near the shape */
} rigid_contacts_candidate;

/* Nodes whose distances are asked for in one call. */
typedef struct rigid_contacts_gathered {
    int count;
    int nodes[RIGID_CONTACTS_BATCH];
    pli_vec3 points[RIGID_CONTACTS_BATCH]; /* of the shape */
    pli_vec3 shifts[RIGID_CONTACTS_BATCH]; /* that the points are behind; see rigid_contacts_shift */
} rigid_contacts_gathered;

/* Response to impulses and friction. */
static void rigid_contacts_prepare(const rigid_contacts_candidate* candidate, plii_rigid_contact* contact, pli_vec3 x) {
    const pli_body* body = candidate->body;
    const plii_rigid_contacts* state = candidate->state;
    const pli_rigid* rigid = candidate->rigid;
    contact->arm = pli_vec3_sub(x, rigid->state.pose.origin);
    plii_effective_mass(body->step.dt, body->positions[contact->node].w, rigid, false, contact->arm, &contact->matrix);
    const pli_vec3 rigid_motion = plii_rigid_motion_at(body, rigid, contact->arm);
    const pli_vec3 motion = pli_vec3_sub(pli_vec3_sub(x, plii_xyz(body->previous[contact->node])), rigid_motion);
    contact->slip = plii_contact_slip(motion, plii_xyz(contact->normal), state->def.friction * rigid->friction);
}

static inline plii_float4 rigid_contacts_motion(const pli_body* body, int node) {
    return plii_float4_from(&body->positions[node]) - plii_float4_from(&body->previous[node]);
}

/* A node that goes along with the rigid body, or comes after one that it cannot move, is where it is on that at the end
   of the step, however fast both are: so far back it is looked at from where the rigid body is now. Zero for others,
   which go past, meet it or lie still. */
static inline plii_float4 rigid_contacts_shift(const rigid_contacts_candidate* candidate, int node) {
    const pli_body* body = candidate->body;
    const plii_float4 none = plii_float4_all(0.0f);
    if (!candidate->is_moving) { return none; }
    const plii_float4 motion = rigid_contacts_motion(body, node);
    const plii_float4 offset =
        plii_float4_from(&body->positions[node]) - plii_lanes_from_vec3(&candidate->rigid->state.pose.origin);
    const plii_float4 shift = plii_lanes_from_vec3(&candidate->motion.linear) +
                              plii_lanes_cross(plii_lanes_from_vec3(&candidate->motion.angular), offset);
    const plii_float4 against = motion - shift;
    if (candidate->is_fixed && plii_lanes_dot(against, shift) > 0.0f) { return shift; }
    const float way = plii_lanes_dot(motion, motion), beside = plii_lanes_dot(against, against);
    const float half = 0.5f * candidate->rigid->shape_places[candidate->shape].least_extent;
    const float most = plii_min(RIGID_CONTACTS_ALONG * RIGID_CONTACTS_ALONG * way, half * half);
    return beside < way && beside < plii_max(body->collision_margin * body->collision_margin, most) ? shift : none;
}

/* One node closer than the margin, `shift` behind where it is. */
static inline void rigid_contacts_add(const rigid_contacts_candidate* candidate, int node, plii_float4 normal,
                                      float distance, plii_float4 shift) {
    const pli_body* body = candidate->body;
    plii_rigid_contacts* state = candidate->state;
    pli_rigid* rigid = candidate->rigid;
    if (!(body->positions[node].w + rigid->state.inverse_mass > 0.0f)) { return; }
    if ((state->count == state->capacity &&
         !PLII_GROW(body->context, &state->contacts, &state->capacity, state->count)) ||
        (body->records_contacts && !plii_contact_impulses_add(body, &state->impulses, state->count))) {
        return;
    }
    plii_rigid_contact* contact = &state->contacts[state->count++];
    contact->rigid = rigid;
    contact->node = node;
    contact->shape = candidate->shape;
    contact->is_fixed = candidate->is_fixed;
    contact->is_still = candidate->is_still;
    const plii_float4 x = plii_float4_from(&body->positions[node]) - shift;
    plii_float4_to(&contact->normal, normal);
    contact->normal.w = -plii_lanes_dot(normal, x - normal * distance);
    contact->distance = distance;
    contact->hardness = rigid->kind == PLI_RIGID_DYNAMIC ? state->def.dynamic_hardness : state->def.static_hardness;
    if (candidate->is_as_in_bullet) {
        rigid_contacts_prepare(candidate, contact, plii_lanes_vec3(x));
    } else {
        contact->goes_along = (plii_lanes_bits(shift != 0.0f) & PLII_LANES_XYZ) != 0;
        plii_lanes_to_vec3(&contact->offset, x - plii_lanes_from_vec3(&rigid->state.pose.origin));
        contact->squeeze = 0.0f;
        contact->before = PLI_NULL_INDEX;
    }
}

/* Where the step leads, the nearest surface may be one that the node did not come through, as the side at the edge of a
   box, which would push it out sideways. Then that which was nearest at the start is taken, if it was farther away. */
static void rigid_contacts_look_back(const rigid_contacts_candidate* candidate, int node, plii_float4 shift,
                                     plii_float4* normal, float* distance) {
    const pli_body* body = candidate->body;
    const pli_vec3 start = plii_xyz(body->previous[node]);
    const plii_float4 motion = rigid_contacts_motion(body, node) - shift;
    const float before = *distance - plii_lanes_dot(motion, *normal);
    if (!(before < -RIGID_CONTACTS_BEHIND * body->collision_margin)) { return; }
    const pli_shape* shape = candidate->rigid->shapes[candidate->shape];
    const pli_transform pose = candidate->rigid->shape_places[candidate->shape].pose;
    const pli_vec3 point = pli_transform_inverse_point(pose, start);
    pli_vec3 first_normal;
    float first = 0.0f;
    shape->def.distances(shape->def.user, 1, &point, PLI_MAX_COORDINATE, &first, &first_normal);
    first -= body->collision_margin;
    if (!(first > before) || !plii_is_within(first, RIGID_CONTACTS_MAX_DEPTH) || !plii_vec3_is_finite(first_normal)) {
        return;
    }
    first_normal = pli_mat3_mul_vec3(pose.rotation, first_normal);
    *normal = plii_lanes_from_vec3(&first_normal);
    *distance = first + plii_lanes_dot(motion, *normal);
}

/* Distances of gathered nodes, and contacts from those below the margin and `reach`. With `is_departing` the points are
   those of the start, and the nodes keep its planes. */
static void rigid_contacts_batch(const rigid_contacts_candidate* candidate, rigid_contacts_gathered* gathered,
                                 float reach, bool is_departing) {
    const pli_body* body = candidate->body;
    const pli_shape* shape = candidate->rigid->shapes[candidate->shape];
    const float margin = body->collision_margin, along = is_departing ? reach : candidate->reach_along;
    const plii_lanes_mat3 columns = plii_lanes_columns(&candidate->rigid->shape_places[candidate->shape].pose.rotation);
    const int count = gathered->count;
    if (count == 0) { return; }
    gathered->count = 0;
    float distances[RIGID_CONTACTS_BATCH];
    pli_vec3 normals[RIGID_CONTACTS_BATCH];
    shape->def.distances(shape->def.user, count, gathered->points, margin + reach, distances, normals);
    for (int i = 0; i < count; ++i) {
        float distance = distances[i] - margin;
        if (!(distance < reach) || !plii_is_within(distance, RIGID_CONTACTS_MAX_DEPTH)) { continue; }
        if (distance >= along && !plii_vec3_is_zero(gathered->shifts[i])) { continue; }
        const plii_float4 local = plii_lanes_from_vec3(&normals[i]);
        if (!plii_lanes_xyz_finite(local)) { continue; }
        const int node = gathered->nodes[i];
        const plii_float4 shift = plii_lanes_from_vec3(&gathered->shifts[i]);
        plii_float4 normal = plii_lanes_combine(columns, local);
        if (is_departing) {
            distance += plii_lanes_dot(rigid_contacts_motion(body, node) - shift, normal);
        } else if (body->solver_class->solves_constraints) {
            rigid_contacts_look_back(candidate, node, shift, &normal, &distance);
        }
        rigid_contacts_add(candidate, node, normal, distance, shift);
    }
}

/* Points of a shape of those in the world, in registers. */
typedef struct rigid_contacts_frame {
    plii_float4 origin;
    plii_lanes_mat3 rows;
} rigid_contacts_frame;

static inline rigid_contacts_frame rigid_contacts_frame_of(const rigid_contacts_candidate* candidate) {
    const pli_transform* pose = &candidate->rigid->shape_places[candidate->shape].pose;
    return (rigid_contacts_frame){plii_lanes_from_vec3(&pose->origin), plii_lanes_rows(&pose->rotation)};
}

/* A node that is at x, but for the shift. */
static inline void rigid_contacts_gather(const rigid_contacts_candidate* candidate, rigid_contacts_frame frame,
                                         rigid_contacts_gathered* gathered, int node, plii_float4 x, plii_float4 shift,
                                         float reach, bool is_departing) {
    const plii_float4 point = plii_lanes_combine(frame.rows, x - frame.origin);
    plii_lanes_to_vec3(&gathered->points[gathered->count], point);
    plii_lanes_to_vec3(&gathered->shifts[gathered->count], shift);
    gathered->nodes[gathered->count++] = node;
    if (gathered->count == RIGID_CONTACTS_BATCH) { rigid_contacts_batch(candidate, gathered, reach, is_departing); }
}

static inline bool rigid_contacts_is_between(plii_float4 x, plii_float4 low, plii_float4 high) {
    return (plii_lanes_bits((low <= x) & (x <= high)) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

/* What holds a body together may press nodes back to surfaces that they touch where the step starts and that it leads
   them away from. Contacts from `first` on, in ascending order of nodes, are those found where it ends. */
static void rigid_contacts_keep_departing(const rigid_contacts_candidate* candidate, int first) {
    const pli_body* body = candidate->body;
    const plii_rigid_contacts* state = candidate->state;
    const plii_shape_place* place = &candidate->rigid->shape_places[candidate->shape];
    const float touching = RIGID_CONTACTS_TOUCHING * body->collision_margin;
    const plii_float4 margin = plii_float4_all(body->collision_margin), reach = margin + touching;
    const plii_float4 low = place->low - reach, high = place->high + reach;
    const int end = state->count;
    const rigid_contacts_frame frame = rigid_contacts_frame_of(candidate);
    rigid_contacts_gathered gathered;
    gathered.count = 0;
    for (int i = 0; i < body->node_count; ++i) {
        if (!rigid_contacts_is_between(plii_float4_from(&body->previous[i]), low, high)) { continue; }
        if (body->anchored != NULL && body->anchored[i] != 0) { continue; }
        while (first < end && state->contacts[first].node < i) {
            ++first;
        }
        if (first < end && state->contacts[first].node == i) { continue; }
        const plii_float4 shift = rigid_contacts_shift(candidate, i);
        const plii_float4 apart = rigid_contacts_motion(body, i) - shift;
        if (rigid_contacts_is_between(apart, -margin, margin)) { continue; }
        const plii_float4 x = plii_float4_from(&body->previous[i]);
        rigid_contacts_gather(candidate, frame, &gathered, i, x, shift, touching, true);
    }
    rigid_contacts_batch(candidate, &gathered, touching, true);
}

/* As Bullet chooses the nodes. */
static void rigid_contacts_collide_boxes(const rigid_contacts_candidate* candidate) {
    const pli_body* body = candidate->body;
    const pli_transform pose = candidate->rigid->shape_places[candidate->shape].pose;
    const pli_bounds local = plii_shape_source_bounds(candidate->rigid->shapes[candidate->shape]);
    const pli_bounds search = plii_bounds_grow(plii_bounds_transform(local, pose), body->collision_margin);
    rigid_contacts_gathered gathered;
    for (int i = 0; i < body->node_count; ++i) {
        if (!plii_bounds_overlap(candidate->boxes[i], search)) { continue; }
        if (body->anchored != NULL && body->anchored[i] != 0) { continue; }
        gathered.count = 1;
        gathered.nodes[0] = i;
        gathered.points[0] = pli_transform_inverse_point(pose, plii_xyz(body->positions[i]));
        gathered.shifts[0] = pli_vec3_make(0, 0, 0);
        rigid_contacts_batch(candidate, &gathered, candidate->reach, false);
    }
}

/* Where contacts are looked for once for many substeps, or must last, as far as the surface gets meanwhile, and a node
   falls from a body that its host moves later; not farther than the plane of a contact stands for the shape. To nodes
   that go along the surface does not get nearer by its own motion. */
static void rigid_contacts_set_reach(rigid_contacts_candidate* candidate, const plii_shape_place* place) {
    const pli_body* body = candidate->body;
    const pli_rigid* rigid = candidate->rigid;
    const float share = candidate->is_swept ? RIGID_CONTACTS_REACH : body->solver_class->contact_reach;
    candidate->reach = candidate->reach_along = body->collision_margin * share;
    if (rigid->kind == PLI_RIGID_STATIC || !(share > 0.0f)) { return; }
    if (!candidate->is_swept) { candidate->reach_along += plii_step_fall(body); }
    const float speed =
        pli_vec3_length(rigid->state.linear_velocity) + pli_vec3_length(rigid->state.angular_velocity) * place->radius;
    candidate->reach = candidate->reach_along + plii_min(speed * body->host_dt, 0.5f * place->least_extent);
}

static void rigid_contacts_collide_shape(rigid_contacts_candidate* candidate) {
    if (candidate->boxes != NULL) {
        rigid_contacts_collide_boxes(candidate);
        return;
    }
    const pli_body* body = candidate->body;
    const plii_shape_place* place = &candidate->rigid->shape_places[candidate->shape];
    rigid_contacts_set_reach(candidate, place);
    const plii_float4 reach = plii_float4_all(body->collision_margin + candidate->reach);
    plii_float4 low = place->low - reach, high = place->high + reach;
    const plii_float4 near_low = low, near_high = high;
    if (candidate->is_moving) { /* nodes that go along may be where the shape will be */
        const float turn = pli_vec3_length(candidate->motion.angular) * place->radius;
        const plii_float4 way = plii_lanes_from_vec3(&candidate->motion.linear), bulge = plii_float4_all(turn);
        low = plii_lanes_min(low, low + way) - bulge;
        high = plii_lanes_max(high, high + way) + bulge;
    }
    const plii_mask4 overlaps =
        (low <= plii_lanes_from_vec3(&body->bounds.max)) & (plii_lanes_from_vec3(&body->bounds.min) <= high);
    if ((plii_lanes_bits(overlaps) & PLII_LANES_XYZ) != PLII_LANES_XYZ) { return; }
    const pli_vec4* restrict positions = body->positions;
    const uint8_t* restrict anchored = body->anchored;
    const int node_count = body->node_count;
    const int first = candidate->state->count;
    const rigid_contacts_frame frame = rigid_contacts_frame_of(candidate);
    rigid_contacts_gathered gathered;
    gathered.count = 0;
    for (int i = 0; i < node_count; ++i) {
        if (!rigid_contacts_is_between(plii_float4_from(&positions[i]), low, high)) { continue; }
        if (anchored != NULL && anchored[i] != 0) { continue; }
        const plii_float4 shift = rigid_contacts_shift(candidate, i), x = plii_float4_from(&positions[i]) - shift;
        if (candidate->is_moving && !rigid_contacts_is_between(x, near_low, near_high)) { continue; }
        rigid_contacts_gather(candidate, frame, &gathered, i, x, shift, candidate->reach, false);
    }
    rigid_contacts_batch(candidate, &gathered, candidate->reach, false);
    if (body->leaps) { rigid_contacts_keep_departing(candidate, first); }
}

static void rigid_contacts_collide(pli_body* body, void* data, pli_rigid* rigid) {
    plii_rigid_contacts* state = data;
    const int before = state->count;
    const pli_rigid_state* motion = &rigid->state;
    rigid_contacts_candidate candidate = {.body = body, .state = state, .rigid = rigid, .boxes = body->node_boxes};
    candidate.is_fixed = motion->inverse_mass == 0.0f && plii_mat3_is_zero(&motion->inverse_inertia_world);
    candidate.is_still =
        candidate.is_fixed && plii_vec3_is_zero(motion->linear_velocity) && plii_vec3_is_zero(motion->angular_velocity);
    candidate.is_swept = plii_follows_rigids(body);
    candidate.is_as_in_bullet = !candidate.is_swept && !body->solver_class->solves_constraints;
    const bool may_move = rigid->kind != PLI_RIGID_STATIC && candidate.boxes == NULL;
    if (may_move && !candidate.is_as_in_bullet) {
        plii_rigid_begin_path(rigid);
        candidate.motion = plii_twist_scale(plii_rigid_end_velocity(rigid, body->host_dt), body->host_dt);
    }
    for (int i = 0; i < rigid->shape_count; ++i) {
        candidate.shape = i;
        const float way = pli_vec3_length(candidate.motion.linear) +
                          pli_vec3_length(candidate.motion.angular) * rigid->shape_places[i].radius;
        candidate.is_moving = way > RIGID_CONTACTS_MOVING * body->collision_margin;
        rigid_contacts_collide_shape(&candidate);
    }
    if (state->count > before) {
        if (!candidate.is_as_in_bullet) { plii_rigid_contacts_squeeze(body, state); }
        plii_rigid_touch(rigid);
        body->has_swept_contacts = body->has_swept_contacts || candidate.is_swept;
    }
}

// -------------------------------------------------------------------------------------------------------- solving

static void rigid_contacts_solve_one(pli_body* body, const plii_rigid_contacts* state, int index) {
    const plii_rigid_contact* contact = &state->contacts[index];
    const pli_vec3 normal = plii_xyz(contact->normal);
    pli_vec4* position = &body->positions[contact->node];
    const pli_vec3 x = plii_xyz(*position), moved = pli_vec3_sub(x, plii_xyz(body->previous[contact->node]));
    const pli_vec3 motion = pli_vec3_sub(moved, plii_rigid_motion_at(body, contact->rigid, contact->arm));
    const float along_normal = pli_vec3_dot(motion, normal);
    if (!(along_normal <= PLII_EPSILON)) { return; }
    const float gap = plii_min(pli_vec3_dot(x, normal) + contact->normal.w, body->collision_margin);
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(normal, along_normal));
    const pli_vec3 error = pli_vec3_add(pli_vec3_sub(motion, pli_vec3_scale(sliding, contact->slip)),
                                        pli_vec3_scale(normal, gap * contact->hardness));
    const pli_vec3 impulse = pli_mat3_mul_vec3(contact->matrix, error);
    plii_set_xyz(position, pli_vec3_sub(x, pli_vec3_scale(impulse, position->w * body->step.dt)));
    plii_rigid_apply_impulse(contact->rigid, impulse, contact->arm);
    if (body->records_contacts) { plii_contact_impulses_push(&state->impulses, index, pli_vec3_neg(impulse)); }
}

static void rigid_contacts_solve(pli_body* body, void* data) {
    const plii_rigid_contacts* state = data;
    if (body->solver_class->solves_constraints || plii_follows_rigids(body)) { return; }
    for (int i = 0; i < state->count; ++i) {
        rigid_contacts_solve_one(body, state, i);
    }
}

static int rigid_contacts_list_constraints(const pli_body* body, const void* data, int capacity,
                                           plii_node_constraint* constraints) {
    const plii_rigid_contacts* state = data;
    for (int i = 0; i < state->count && i < capacity; ++i) {
        const plii_rigid_contact* contact = &state->contacts[i];
        constraints[i] =
            (plii_node_constraint){.node = contact->node, .rigid = contact->rigid, .normal = plii_xyz(contact->normal)};
        constraints[i].offset = contact->normal.w;
        constraints[i].friction = state->def.friction * contact->rigid->friction;
        constraints[i].hardness = contact->hardness;
        constraints[i].recovery_speed = plii_contact_recovery_speed(state->def.recovery_speed);
        constraints[i].squeeze = contact->squeeze;
        constraints[i].influence = 1.0f;
        constraints[i].has_pivot = contact->goes_along;
        if (contact->goes_along) {
            const pli_mat3 rotation = contact->rigid->path.begin.rotation;
            constraints[i].pivot = pli_mat3_mul_vec3(pli_mat3_transpose(rotation), contact->offset);
        }
        if (body->records_contacts) { constraints[i].impulse = &state->impulses.items[i]; }
    }
    return state->count;
}

static void rigid_contacts_visit(pli_body* body, const void* data, plii_contact_visit_fn* visit, void* user) {
    const plii_rigid_contacts* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_rigid_contact* contact = &state->contacts[i];
        const pli_vec3 x = plii_xyz(body->positions[contact->node]), n = plii_xyz(contact->normal);
        plii_contact_report report = plii_contact_report_make(contact->rigid, NULL);
        report.shape = contact->shape;
        report.node = contact->node;
        report.point = pli_vec3_sub(x, pli_vec3_scale(n, body->collision_margin));
        report.normal = n;
        report.node_count = 1;
        report.nodes[0] = contact->node;
        report.weights[0] = 1.0f;
        report.impulse = plii_contact_impulses_get(body, &state->impulses, i);
        const pli_vec3 arm =
            pli_vec3_sub(x, contact->rigid->state.pose.origin); /* what moves alone takes planes along */
        const float moved = pli_vec3_dot(plii_rigid_velocity_at(contact->rigid, arm), n) * body->host_dt;
        report.gap = pli_vec3_dot(n, x) + contact->normal.w - (contact->is_fixed ? moved : 0.0f);
        visit(body, &report, user);
    }
}

static void rigid_contacts_visit_met(const void* data, plii_joined_fn* visit, void* user) {
    const plii_rigid_contacts* state = data;
    for (int i = 0; i < state->count; ++i) {
        if (i == 0 || state->contacts[i].rigid != state->contacts[i - 1].rigid) {
            visit(NULL, state->contacts[i].rigid, user);
        }
    }
}

// ---------------------------------------------------------------------------------------------------- the feature

static void rigid_contacts_clear(pli_body* body, void* data) {
    plii_rigid_contacts* state = data;
    state->count = state->linked = 0;
}

static void rigid_contacts_on_rigid_removed(pli_body* body, void* data, plii_notice notice, const void* rigid) {
    plii_rigid_contacts* state = data; /* between steps: the next one clears what is linked before it links */
    PLII_REMOVE_IF(plii_rigid_contact, contact, state->contacts, state->count, contact->rigid == rigid);
}

static void rigid_contacts_preallocate(pli_body* body, void* data) {
    plii_rigid_contacts* state = data;
    if (body->world->rigid_count == 0) { return; }
    const int room = plii_body_contact_bound(body);
    (void)PLII_RESERVE(body->context, &state->contacts, &state->capacity, room);
    if (body->records_contacts) {
        (void)PLII_RESERVE(body->context, &state->impulses.items, &state->impulses.capacity, room);
    }
    if (plii_follows_rigids(body)) { plii_rigid_substeps_reserve(body, &state->substeps, room); }
}

static void rigid_contacts_enable(pli_body* body, void* data) {
    body->node_contacts = data;
}
static void rigid_contacts_disable(pli_body* body, void* data) {
    body->node_contacts = NULL;
}

/* As in Bullet after anchors and before the links. */
enum { RIGID_CONTACTS_CLEAR_ORDER = 5, RIGID_CONTACTS_ORDER = 20 };
const plii_feature_class plii_rigid_contacts_class = {
    .name = "rigid contacts",
    .state_size = sizeof(plii_rigid_contacts),
    .settings = PLII_LIMITS_AT(offsetof(plii_rigid_contacts, def),
                               PLII_FIELD(pli_rigid_contacts_def, friction, 0, PLI_MAX_FACTOR),
                               PLII_FIELD(pli_rigid_contacts_def, dynamic_hardness, 0, 1),
                               PLII_FIELD(pli_rigid_contacts_def, static_hardness, 0, 1),
                               PLII_FIELD(pli_rigid_contacts_def, recovery_speed, 0, PLI_MAX_SPEED),
                               PLII_FIELD(pli_rigid_contacts_def, compliance, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_rigid_contacts, def, PLII_SAVED, "5fu"),
                                    PLII_STATE(plii_rigid_contacts, linked, PLII_LEFT),
                                    PLII_STATE(plii_rigid_contacts, substeps, PLII_LEFT)),
    .needs = PLII_NEEDS(&plii_iterated_sweeps_class),
    .arrays =
        PLII_ARRAYS(PLII_LEFT_COUNTED(plii_rigid_contacts, contacts, capacity, count),
                    PLII_LEFT_PER_NODE(plii_rigid_contacts, fixed_of_node),
                    {PLII_CONTACT_IMPULSES_OF(plii_rigid_contacts, impulses)},
                    PLII_LEFT_LIST(plii_rigid_contacts, substeps.contacts.items, substeps.contacts.capacity),
                    PLII_LEFT_LIST(plii_rigid_contacts, substeps.groups.groups, substeps.groups.capacity),
                    PLII_LEFT_LIST(plii_rigid_contacts, substeps.groups.surfaces, substeps.groups.surface_capacity)),
    .stages = {[PLII_STAGE_UPDATE] = {rigid_contacts_clear, RIGID_CONTACTS_CLEAR_ORDER},
               [PLII_STAGE_POSITION] = {rigid_contacts_solve, RIGID_CONTACTS_ORDER}},
    .substepped = &plii_rigid_contacts_substepped,
    .enable = rigid_contacts_enable,
    .disable = rigid_contacts_disable,
    .collide_rigid = rigid_contacts_collide,
    .list_constraints = rigid_contacts_list_constraints,
    .visit_contacts = rigid_contacts_visit,
    .visit_met = rigid_contacts_visit_met,
    .on[PLII_RIGID_REMOVED] = rigid_contacts_on_rigid_removed,
    .reserve = rigid_contacts_preallocate,
    .build = rigid_contacts_clear,
};

PLII_DEFINE_DEFAULT(pli_rigid_contacts_def, .friction = 0.2f, .dynamic_hardness = 1.0f, .static_hardness = 0.1f)
PLII_DEFINE_ENABLE(pli_body_enable_rigid_contacts, plii_check_body_change, pli_rigid_contacts_def,
                   plii_rigid_contacts_class)
PLII_DEFINE_DISABLE(pli_body_disable_rigid_contacts, plii_check_body_change, plii_rigid_contacts_class)

PLII_DEFINE_CONTACTS_GET(pli_body_get_rigid_contacts, pli_rigid_contact, plii_rigid_contacts, plii_rigid_contact,
                         plii_rigid_contacts_class,
                         (pli_rigid_contact){.node = contact->node,
                                             .rigid = contact->rigid,
                                             .shape = contact->shape,
                                             .normal = plii_xyz(contact->normal),
                                             .distance = contact->distance})

pli_status pli_body_reorder_rigid_contacts(pli_body* body, const int* order, int count) {
    return plii_reorder_contacts(body, &plii_rigid_contacts_class, order, count, __func__);
}
