/* Contacts of faces with rigid shapes, as a feature: solve, what solvers and reports ask, substeps, settings. */

#include "body/pipeline.h"
#include "contact/contact_substep.h"
#include "contact/face_rigid_impl.h"
#include "math/bounds.h"

#define RIGID_FACES_LAST_SWEEPS 12
#define RIGID_FACES_REVIEWS 16
#define RIGID_FACES_OPPOSITE (-0.05f) /* cosine of two normals */

// ---------------------------------------------------------------------------------------------------------- the solve

/* Like that of node contacts, with a point of the face in the place of the node, but it looks at the gap between this
   point and the shape that will be left along the normal at the end of the step: a contact that is not needed does
   nothing. It has the last word after links, and looks again and again for what the solve itself has brought about. */

pli_vec3 plii_rigid_faces_point(const pli_vec4* positions, const plii_rigid_face_contact* contact) {
    return plii_contact_blend(positions, contact->nodes, contact->weights);
}

/* From the centre of mass to the tangent plane of the surface at the contact's normal, at the core point. */
static plii_dvec3 rigid_faces_arm(const plii_rigid_faces_candidate* candidate, pli_mat3 rotation,
                                  const plii_rigid_face_contact* contact) {
    const plii_face_core core = {.shape = candidate->shape,
                                 .triangle = contact->is_triangle ? contact->triangle : NULL,
                                 .pose = candidate->shape_pose,
                                 .rotation = rotation};
    const float radius = contact->is_triangle ? 0.0f : candidate->shape->def.radius;
    const plii_dvec3 n = plii_dvec3_from(contact->normal);
    const plii_dvec3 core_arm = plii_dvec3_rotate(&rotation, plii_dvec3_from(contact->core_point));
    const double height = plii_face_core_height(&core, 0.0f, contact->normal) + (double)(radius - contact->excess);
    return plii_dvec3_add_scaled(core_arm, n, height - plii_dvec3_dot(n, core_arm));
}

/* Impulses act where the surface is at the start, and a margin further out, where the face goes round with a body that
   turns. Where it comes to lie, a corner that tips over would be pushed on, and a box that lands on one would spin. */
void plii_rigid_faces_prepare_contact(const pli_body* body, const plii_rigid_faces_candidate* candidate,
                                      pli_transform end, plii_rigid_face_contact* contact) {
    const pli_rigid* rigid = contact->rigid;
    const float dt = body->step.dt;
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    const float face_weight = plii_point_weight(body->positions, 3, contact->nodes, weights, 0.0f);
    const plii_dvec3 end_arm = rigid_faces_arm(candidate, end.rotation, contact);
    const pli_vec3 surface = plii_dvec3_to_float(plii_dvec3_add(plii_dvec3_from(end.origin), end_arm));
    const plii_dvec3 arm = rigid_faces_arm(candidate, candidate->begin.rotation, contact);
    contact->arm = plii_dvec3_to_float(
        plii_dvec3_add_scaled(arm, plii_dvec3_from(contact->normal), (double)body->collision_margin));
    contact->base = pli_vec3_sub(surface, plii_rigid_motion_at(body, rigid, contact->arm));
    plii_effective_mass(dt, face_weight, rigid, true, contact->arm, &contact->impulse_matrix);
    const pli_vec3 torque = pli_vec3_cross(contact->arm, contact->normal);
    const pli_vec3 spin = plii_rigid_spin_of(rigid, contact->normal, contact->arm);
    contact->normal_response =
        dt * (face_weight + plii_rigid_linear_response(rigid, contact->normal) + pli_vec3_dot(spin, torque));
}

/* Gap that another body which cannot move leaves at the point of a contact with one; negative where the two are nearer
   than both margins. Infinite where it is not opposite. */
static float rigid_faces_room(const pli_body* body, const plii_rigid_faces_candidate* other,
                              const plii_rigid_face_contact* contact) {
    const float margin = body->collision_margin;
    const pli_vec3 point = plii_rigid_faces_point(body->positions, contact);
    if (other->rigid->state.inverse_mass > 0.0f ||
        !plii_bounds_overlap(plii_bounds_grow(other->bounds, margin), (pli_bounds){point, point})) {
        return INFINITY;
    }
    const pli_transform pose = pli_transform_mul(plii_rigid_end_pose(other->rigid, body->host_dt), other->shape_pose);
    pli_vec3 normal;
    const float distance = plii_shape_distance(other->shape, pli_transform_inverse_point(pose, point), &normal);
    const float cosine = pli_vec3_dot(pli_mat3_mul_vec3(pose.rotation, normal), contact->normal);
    return cosine < RIGID_FACES_OPPOSITE ? contact->distance + distance - margin : INFINITY;
}

/* Between two bodies that cannot move, and leave less than both margins, the later one gives way. Otherwise the two
   push the face out sideways, step by step, and stretch it. */
static void rigid_faces_share_room(const pli_body* body, plii_rigid_faces* state, int first) {
    for (int i = first; i < state->count; ++i) {
        plii_rigid_face_contact* contact = &state->contacts[i];
        if (contact->rigid->state.inverse_mass > 0.0f) { continue; }
        for (int k = 0; k < contact->candidate; ++k) {
            const float room = rigid_faces_room(body, &state->candidates[k], contact);
            contact->given_up = plii_min(contact->given_up, room);
        }
        contact->target = plii_min(contact->target, contact->given_up);
    }
}

static void rigid_faces_settle(const pli_body* body, plii_rigid_faces* state) {
    PLII_REMOVE_IF(plii_rigid_face_contact, contact, state->contacts, state->count,
                   plii_rigid_faces_is_squeezed(body, &state->candidates[contact->candidate], contact->nodes));
    rigid_faces_share_room(body, state, 0);
}

/* Contacts stand in the order of the meetings, those of reviews behind them. */
static void rigid_faces_prepare_all(const pli_body* body, plii_rigid_faces* state) {
    int candidate = PLI_NULL_INDEX;
    pli_transform end = pli_transform_identity();
    for (PLII_EACH(plii_rigid_face_contact, contact, state->contacts, state->count)) {
        if (contact->candidate != candidate) {
            candidate = contact->candidate;
            end = plii_rigid_end_pose(state->candidates[candidate].rigid, body->host_dt);
        }
        plii_rigid_faces_prepare_contact(body, &state->candidates[candidate], end, contact);
    }
}

static void rigid_faces_prepare(pli_body* body, void* data) {
    if (!plii_follows_rigids(body)) { rigid_faces_settle(body, data); }
    rigid_faces_prepare_all(body, data);
}

/* Impulse from the face to the rigid body; zero when nothing is to be done. A contact that has pushed too much, because
   others have pushed since, takes back what it can: that keeps the torques of contacts around a body in balance. */
static pli_vec3 rigid_faces_impulse(const pli_body* body, const plii_rigid_face_contact* contact) {
    const pli_vec3 n = contact->normal;
    const pli_vec3 point = plii_rigid_faces_point(body->positions, contact);
    const pli_vec3 rigid_motion = plii_rigid_motion_at(body, contact->rigid, contact->arm);
    const pli_vec3 apart = pli_vec3_sub(point, pli_vec3_add(contact->base, rigid_motion));
    const float error = pli_vec3_dot(n, apart) - body->collision_margin - contact->target;
    if (!(error < 0.0f)) { return pli_vec3_scale(n, plii_min(error / contact->normal_response, contact->push)); }
    const pli_vec3 motion = pli_vec3_sub(pli_vec3_sub(point, contact->start), rigid_motion);
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    return pli_mat3_mul_vec3(contact->impulse_matrix,
                             pli_vec3_add(pli_vec3_scale(sliding, 1.0f - contact->slip), pli_vec3_scale(n, error)));
}

/* From the first one on. The longest way that a node was moved, m; 0 when no contact had anything to do. That by
   contacts which are to stay deep is added to `deep_way`. */
static float rigid_faces_sweep(pli_body* body, const plii_rigid_faces* state, int first, bool with_velocities,
                               float* deep_way) {
    const float dt = body->step.dt;
    float longest = 0.0f, longest_deep = 0.0f;
    for (int i = first; i < state->count; ++i) {
        plii_rigid_face_contact* contact = &state->contacts[i];
        const pli_vec3 impulse = rigid_faces_impulse(body, contact);
        if (!(pli_vec3_length_squared(impulse) > 0.0f)) { continue; }
        contact->push = plii_max(contact->push - pli_vec3_dot(impulse, contact->normal), 0.0f);
        const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
        for (int k = 0; k < 3; ++k) {
            const int node = contact->nodes[k];
            const pli_vec3 change = pli_vec3_scale(impulse, -weights[k] * body->positions[node].w);
            plii_add_xyz(&body->positions[node], pli_vec3_scale(change, dt));
            if (with_velocities) { plii_add_xyz(&body->velocities[node], change); }
            const float way = pli_vec3_length(change) * dt;
            longest = plii_max(longest, way);
            if (contact->target < -body->collision_margin) { longest_deep = plii_max(longest_deep, way); }
        }
        if (body->solver_class->solves_constraints) { continue; }
        if (body->records_contacts) { plii_contact_impulses_push(&state->impulses, i, pli_vec3_neg(impulse)); }
        plii_rigid_push_at(body, contact->rigid, impulse, contact->arm);
        contact->rigid->needs_reintegration = true;
    }
    *deep_way += longest_deep;
    return longest;
}

/* Points that were only moved back must not go on into the surface: the speed would be moved back in each step. */
static void rigid_faces_stop(pli_body* body, const plii_rigid_faces* state, int first) {
    for (int i = first; i < state->count; ++i) {
        const plii_rigid_face_contact* contact = &state->contacts[i];
        const pli_vec3 n = contact->normal, surface = plii_rigid_pace_at(body, contact->rigid, contact->arm);
        const pli_vec3 point = plii_contact_blend(body->velocities, contact->nodes, contact->weights);
        const float speed = pli_vec3_dot(n, pli_vec3_sub(point, surface));
        if (!(contact->push > 0.0f) || !(speed < 0.0f) || !(contact->normal_response > 0.0f)) { continue; }
        const pli_vec3 impulse = pli_vec3_scale(n, speed * body->step.dt / contact->normal_response);
        const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
        for (int k = 0; k < 3; ++k) {
            const int node = contact->nodes[k];
            plii_add_xyz(&body->velocities[node], pli_vec3_scale(impulse, -weights[k] * body->positions[node].w));
        }
        if (body->records_contacts) { plii_contact_impulses_push(&state->impulses, i, pli_vec3_neg(impulse)); }
        plii_rigid_push_at(body, contact->rigid, impulse, contact->arm);
    }
}

static void rigid_faces_solve(pli_body* body, void* data) {
    float way = 0.0f;
    if (!plii_rigid_faces_are_solved(body)) { (void)rigid_faces_sweep(body, data, 0, false, &way); }
}

// ------------------------------------------------------------------------------------------------------------- memory

/* The side at the end of the step; a face that overlaps keeps the one that it had, if any. */
static void rigid_faces_remember_element(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep) {
    plii_face_sweep free = *sweep;
    free.has_side = false;
    plii_face_moment moment;
    const float reach = pass->radius + 2.0f * pass->body->collision_margin + plii_face_sweep_length(sweep);
    if (!plii_face_sweep_look(&free, 1.0f, reach, &moment)) { return; }
    if (moment.is_overlapping && !sweep->has_side) { return; }
    const pli_mat3 rotation = pli_mat3_mul(pass->end.rotation, pass->core.pose.rotation);
    const pli_vec3 front = pass->triangle != NULL ? pass->triangle->normal : pli_vec3_make(0, 0, 0);
    if (pli_vec3_dot(moment.normal, pli_mat3_mul_vec3(rotation, front)) < 0.0f) { return; }
    plii_pair_record* record =
        plii_pair_cache_get(pass->body->context, &pass->state->memory, plii_rigid_faces_key(pass));
    if (record == NULL) { return; }
    if (!(moment.is_overlapping && sweep->has_side)) { record->cache.normal = moment.normal; }
    record->cache.has_normal = true;
    record->cache.count = 0;
}

static void rigid_faces_remember(pli_body* body, plii_rigid_faces* state) {
    for (int i = 0; i < state->candidate_count; ++i) {
        const plii_rigid_faces_candidate* candidate = &state->candidates[i];
        const pli_rigid* rigid = candidate->rigid;
        const int index = candidate->shape_index;
        if (index >= rigid->shape_count || rigid->shapes[index] != candidate->shape) { continue; } /* replaced since */
        plii_rigid_faces_pass pass = plii_rigid_faces_make_pass(body, state, i);
        pass.is_at_end = true;
        plii_rigid_faces_visit(&pass, 2.0f * body->collision_margin, rigid_faces_remember_element);
    }
}

/* Those of convex shapes, for the next step; the oldest go where a face has more than there is room for. */
static void rigid_faces_remember_points(plii_rigid_faces* state, int count) {
    for (PLII_EACH(const plii_rigid_face_contact, contact, state->contacts, count)) {
        const plii_pair_key key = {contact->element, contact->shape, contact->rigid, 0};
        plii_convex_cache* cache = contact->is_triangle ? NULL : plii_pair_cache_find(&state->memory, key);
        if (cache == NULL) { continue; }
        pli_vec3* points = cache->points;
        if (cache->count == PLII_CONVEX_CACHE_POINTS) {
            memmove(points, points + 1, (size_t)--cache->count * sizeof *points);
        }
        points[cache->count++] = contact->weights;
    }
}

// ------------------------------------------------------------------------------------------------------------- finish

/* How far a contact may have to bring a node back: what nodes and surfaces have moved in this step, and margins. */
static float rigid_faces_longest_way(const pli_body* body, const plii_rigid_faces* state) {
    float nodes = 0.0f, surfaces = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 way = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
        nodes = plii_max(nodes, pli_vec3_length_squared(way));
    }
    for (PLII_EACH(const plii_rigid_faces_candidate, candidate, state->candidates, state->candidate_count)) {
        const plii_twist velocity = plii_rigid_velocity(candidate->rigid);
        const float radius = 0.5f * pli_vec3_length(pli_vec3_sub(candidate->bounds.max, candidate->bounds.min));
        surfaces = plii_max(surfaces, pli_vec3_length(velocity.linear) + pli_vec3_length(velocity.angular) * radius);
    }
    return sqrtf(nodes) + surfaces * body->host_dt + 2.0f * body->collision_margin;
}

/* Links that were solved after the contacts may have pulled faces through a body. Drift iterations lose the start of
   the step, without which only the contacts that there are can be solved. */
static void rigid_faces_finish(pli_body* body, void* data) {
    plii_rigid_faces* state = data;
    if (state->candidate_count == 0 && state->memory.before.count == 0) { return; }
    const bool has_start = body->solver.drift_iterations == 0;
    const int first = plii_rigid_faces_are_solved(body) ? state->count : 0;
    const float longest_way = rigid_faces_longest_way(body, state);
    float deep_way = 0.0f;
    for (int i = 0;; ++i) {
        rigid_faces_prepare_all(body, state);
        float longest = 0.0f;
        for (int k = 0; k < RIGID_FACES_LAST_SWEEPS && deep_way <= longest_way; ++k) {
            const float moved =
                rigid_faces_sweep(body, state, first, !body->solver_class->solves_constraints, &deep_way);
            if (!(moved > 0.0f)) { break; }
            longest = plii_max(longest, moved);
        }
        if (body->solver_class->solves_constraints) { rigid_faces_stop(body, state, first); }
        const int known = state->count;
        /* Contacts that contradict each other drive nodes on and on: at once, or, where a body started inside of the
           cloth, bit by bit to and fro. */
        const bool is_astray = plii_max(longest, deep_way) > longest_way;
        const bool is_last = !has_start || i == RIGID_FACES_REVIEWS || is_astray;
        if (is_last || plii_rigid_faces_review(body, state) == 0) { break; }
        rigid_faces_share_room(body, state, known);
    }
    if (has_start) { rigid_faces_remember(body, state); }
    /* Without memory, faces that overlap are pushed out the shortest way. */
    (void)plii_pair_cache_begin_step(body->context, &state->memory);
    if (plii_rigid_faces_are_solved(body)) { rigid_faces_remember_points(state, first); }
    plii_rigid_faces_drop_candidates(state, 0);
}

/* Of the plane that is kept free at the start: the height of the witness point above it is the gap, less the margin and
   what is given up of it. */
static float rigid_faces_offset(const plii_rigid_face_contact* contact) {
    const plii_dvec3 apart =
        plii_dvec3_sub(plii_dvec3_from(contact->start), plii_dvec3_from(contact->rigid->path.begin.origin));
    const plii_dvec3 arm = plii_dvec3_from(contact->arm);
    const double height = plii_dvec3_dot(plii_dvec3_from(contact->normal), plii_dvec3_sub(apart, arm));
    return (float)height - contact->given_up - pli_vec3_dot(contact->normal, contact->start);
}

static int rigid_faces_list_constraints(const pli_body* body, const void* data, int capacity,
                                        plii_node_constraint* constraints) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->count && i < capacity; ++i) {
        const plii_rigid_face_contact* from = &state->contacts[i];
        const pli_rigid* rigid = from->rigid;
        plii_node_constraint* constraint = &constraints[i];
        *constraint = (plii_node_constraint){.node = PLI_NULL_INDEX, .weights = from->weights, .rigid = from->rigid};
        memcpy(constraint->face_nodes, from->nodes, sizeof constraint->face_nodes);
        constraint->pivot = pli_mat3_mul_vec3(pli_mat3_transpose(rigid->path.begin.rotation), from->arm);
        constraint->normal = from->normal;
        constraint->offset = rigid_faces_offset(from);
        constraint->friction = state->def.friction * rigid->friction;
        constraint->hardness =
            rigid->kind == PLI_RIGID_DYNAMIC ? state->def.dynamic_hardness : state->def.static_hardness;
        constraint->recovery_speed = plii_contact_recovery_speed(0.0f);
        constraint->influence = 1.0f;
        if (body->records_contacts) { constraint->impulse = &state->impulses.items[i]; }
    }
    return state->count;
}

static void rigid_faces_visit_contacts(pli_body* body, const void* data, plii_contact_visit_fn* visit, void* user) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->count; ++i) {
        const plii_rigid_face_contact* contact = &state->contacts[i];
        const pli_vec3 x = plii_rigid_faces_point(body->positions, contact), n = contact->normal;
        const pli_vec3 motion = plii_rigid_motion_at(body, contact->rigid, contact->arm);
        plii_contact_report report = plii_contact_report_make(contact->rigid, NULL);
        report.shape = contact->shape;
        *(body->topology->face_count > 0 ? &report.face : &report.link) = contact->element;
        report.point = pli_vec3_sub(x, pli_vec3_scale(n, body->collision_margin));
        report.normal = n;
        report.node_count = 3;
        memcpy(report.nodes, contact->nodes, sizeof report.nodes);
        memcpy(report.weights, &contact->weights, sizeof report.weights);
        report.impulse = plii_contact_impulses_get(body, &state->impulses, i);
        report.gap = pli_vec3_dot(n, pli_vec3_sub(x, pli_vec3_add(contact->base, motion))) - body->collision_margin;
        visit(body, &report, user);
    }
}

static void rigid_faces_visit_met(const void* data, plii_joined_fn* visit, void* user) {
    const plii_rigid_faces* state = data;
    for (int i = 0; i < state->candidate_count; ++i) {
        visit(NULL, state->candidates[i].rigid, user);
    }
}

// ----------------------------------------------------------------------------------------------------------- substeps

/* Those that the free motion of the step has shown. */
static void faces_begin(pli_body* body, void* data) {
    plii_rigid_faces* state = data;
    rigid_faces_settle(body, state);
    state->substeps.count = 0;
    for (PLII_EACH(const plii_rigid_face_contact, from, state->contacts, state->count)) {
        plii_point_contact* contact = plii_point_contacts_add(body, &state->substeps);
        if (contact == NULL) { return; } /* left out in this step */
        contact->normal = from->normal;
        contact->offset = rigid_faces_offset(from);
        contact->surface = (plii_substep_rigid_point){from->rigid, from->arm};
        contact->node_count = 3;
        memcpy(contact->nodes, from->nodes, sizeof contact->nodes);
        memcpy(contact->weights, &from->weights, sizeof contact->weights);
        contact->coefficient = state->def.friction * from->rigid->friction;
        plii_point_contact_prepare(body, contact);
    }
}

static void faces_restart(pli_body* body, void* data, const plii_substep* substep) {
    plii_point_contacts_restart(body, &((plii_rigid_faces*)data)->substeps, substep, plii_contact_recovery_speed(0.0f));
}

static void faces_sweep(pli_body* body, void* data, const plii_substep* substep) {
    plii_rigid_faces* state = data;
    plii_point_contacts_sweep(body, &state->substeps, substep, 0.0f);
    if (!body->records_contacts || !substep->is_last_sweep) { return; }
    for (int i = 0; i < state->substeps.count; ++i) { /* in the order of the contacts */
        plii_contact_impulses_push(&state->impulses, i, plii_point_contact_impulse(&state->substeps.items[i], substep));
    }
}

// -------------------------------------------------------------------------------------------------------- the feature

static void rigid_faces_clear(pli_body* body, void* data) {
    plii_rigid_faces* state = data;
    state->count = 0;
    plii_rigid_faces_drop_candidates(state, 0);
}

static void rigid_faces_on_rigid_removed(pli_body* body, void* data, plii_notice notice, const void* rigid) {
    plii_rigid_faces* state = data;
    plii_pair_cache_release(body->context, &state->memory);
    PLII_REMOVE_IF(plii_rigid_face_contact, contact, state->contacts, state->count, contact->rigid == rigid);
}

/* Those that only lie in other places have moved, as with their body. */
static void rigid_faces_on_shapes_replaced(pli_body* body, void* data, plii_notice notice, const void* rigid) {
    plii_pair_cache_forget(body->context, &((plii_rigid_faces*)data)->memory, rigid);
}

static void rigid_faces_build(pli_body* body, void* data) {
    rigid_faces_clear(body, data);
    plii_pair_cache_release(body->context, &((plii_rigid_faces*)data)->memory);
}

/* After contacts of nodes with rigid bodies; in substeps before them. */
enum { RIGID_FACES_CLEAR_ORDER = 5, RIGID_FACES_ORDER = 25, RIGID_FACES_SUBSTEP_ORDER = 58 };

static void rigid_faces_on_restored(pli_body* body, void* data) {
    (void)plii_pair_cache_index_before(body->context, &((plii_rigid_faces*)data)->memory);
}
static bool rigid_faces_is_sound(const pli_body* body, const void* data) {
    return plii_pair_cache_is_sound(&((const plii_rigid_faces*)data)->memory);
}

const plii_feature_class plii_rigid_faces_class = {
    .name = "rigid face contacts",
    .state_size = sizeof(plii_rigid_faces),
    .settings = PLII_LIMITS_AT(offsetof(plii_rigid_faces, def),
                               PLII_FIELD(pli_rigid_face_contacts_def, friction, 0, PLI_MAX_FACTOR),
                               PLII_FIELD(pli_rigid_face_contacts_def, dynamic_hardness, 0, 1),
                               PLII_FIELD(pli_rigid_face_contacts_def, static_hardness, 0, 1)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_rigid_faces, def, PLII_SAVED, "3fu"),
                                    PLII_STATE(plii_rigid_faces, candidate_count, PLII_LEFT),
                                    PLII_STATE(plii_rigid_faces, memory.table, PLII_LEFT),
                                    PLII_STATE(plii_rigid_faces, substeps, PLII_LEFT)),
    .is_sound = rigid_faces_is_sound,
    .on_restored = rigid_faces_on_restored,
    .needs = PLII_NEEDS(&plii_iterated_sweeps_class),
    .arrays = PLII_ARRAYS(PLII_LEFT_COUNTED(plii_rigid_faces, contacts, capacity, count),
                          {PLII_CONTACT_IMPULSES_OF(plii_rigid_faces, impulses)},
                          PLII_LEFT_LIST(plii_rigid_faces, candidates, candidate_capacity),
                          PLII_LEFT_LIST(plii_rigid_faces, substeps.items, substeps.capacity),
                          PLII_PAIR_CACHE_LISTS(plii_rigid_faces, memory, PLII_LEFT, PLII_SAVED)),
    .stages = {[PLII_STAGE_UPDATE] = {rigid_faces_clear, RIGID_FACES_CLEAR_ORDER},
               [PLII_STAGE_PREPARE] = {rigid_faces_prepare, RIGID_FACES_ORDER},
               [PLII_STAGE_POSITION] = {rigid_faces_solve, RIGID_FACES_ORDER},
               [PLII_STAGE_FINISH] = {rigid_faces_finish, RIGID_FACES_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = RIGID_FACES_SUBSTEP_ORDER, .is_in_iterations = true, .begin = faces_begin,
                                  .restart = faces_restart, .sweep = faces_sweep),
    .disable = rigid_faces_build,
    .looks_at_motion = true,
    .collide_rigid = plii_rigid_faces_collide,
    .collides_last = true,
    .list_constraints = rigid_faces_list_constraints,
    .visit_contacts = rigid_faces_visit_contacts,
    .visit_met = rigid_faces_visit_met,
    .on =
        {[PLII_RIGID_REMOVED] = rigid_faces_on_rigid_removed, [PLII_SHAPES_REPLACED] = rigid_faces_on_shapes_replaced},
    .build = rigid_faces_build,
};

PLII_DEFINE_DEFAULT(pli_rigid_face_contacts_def, .friction = 0.2f, .dynamic_hardness = 1.0f, .static_hardness = 0.1f)
PLII_DEFINE_ENABLE(pli_body_enable_rigid_face_contacts, plii_check_body_change, pli_rigid_face_contacts_def,
                   plii_rigid_faces_class)
PLII_DEFINE_DISABLE(pli_body_disable_rigid_face_contacts, plii_check_body_change, plii_rigid_faces_class)

PLII_DEFINE_CONTACTS_GET(pli_body_get_rigid_face_contacts, pli_rigid_face_contact, plii_rigid_faces,
                         plii_rigid_face_contact, plii_rigid_faces_class,
                         (pli_rigid_face_contact){
                             .face = body->topology->face_count > 0 ? contact->element : PLI_NULL_INDEX,
                             .link = body->topology->face_count > 0 ? PLI_NULL_INDEX : contact->element,
                             .weights = {contact->weights.x, contact->weights.y, contact->weights.z},
                             .rigid = contact->rigid,
                             .shape = contact->shape,
                             .normal = contact->normal,
                             .distance = contact->distance})
