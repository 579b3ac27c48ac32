/* Contacts of faces (of links where a body has no faces) with convex rigid shapes and with the triangles of meshes,
   which btSoftBody lacks.
   Conservative advancement finds where on the way of a step a face comes near a shape; the normal of that moment makes
   the contact, which keeps the face on the side that it came from however fast the two are. A face that overlaps a core
   at the start of a step is pushed to the side where it last was, the shortest way out when it never was on any. */

#include "base/csr.h"
#include "contact/contact_substep.h"
#include "contact/face_rigid_impl.h"
#include "math/bounds.h"

#define RIGID_FACES_MAX_TARGETS 8
#define RIGID_FACES_LEAST_SHARE 0.02f
#define RIGID_FACES_SAME_NORMAL 0.99f    /* cosine */
#define RIGID_FACES_NEW_POINT 0.05f      /* of the margin, that it must be nearer than those that are kept */
#define RIGID_FACES_SMALLEST_SLACK 1e-3f /* of the size of the way of a face */
#define RIGID_FACES_FLAT 0.9999f         /* cosine of the normals at two nodes */
#define RIGID_FACES_FLAT_DEPTH (-0.1f)   /* of the margin, that a node may be deeper */

// --------------------------------------------------------------------------------------- faces that their nodes hold

/* Finds the contacts of nodes with the candidate. */
static void held_find_nodes(const pli_body* body, plii_rigid_faces_candidate* candidate) {
    const plii_rigid_contacts* nodes = body->node_contacts;
    if (nodes == NULL || !plii_rigid_faces_are_solved(body)) { return; }
    int end = nodes->count;
    while (end > 0 && nodes->contacts[end - 1].rigid == candidate->rigid &&
           nodes->contacts[end - 1].shape != candidate->shape_index) {
        --end;
    }
    int begin = end;
    while (begin > 0 && nodes->contacts[begin - 1].rigid == candidate->rigid &&
           nodes->contacts[begin - 1].shape == candidate->shape_index) {
        --begin;
    }
    candidate->nodes_begin = begin;
    candidate->nodes_count = end - begin;
}

static const plii_rigid_contact* held_find(const pli_body* body, const plii_rigid_faces_candidate* candidate,
                                           int node) {
    const plii_rigid_contacts* nodes = body->node_contacts;
    if (nodes == NULL || candidate->nodes_begin + candidate->nodes_count > nodes->count) { return NULL; }
    const plii_rigid_contact* contacts = nodes->contacts + candidate->nodes_begin;
    const int first =
        plii_csr_first(contacts, sizeof *contacts, offsetof(plii_rigid_contact, node), candidate->nodes_count, node);
    if (first == candidate->nodes_count) { return NULL; }
    const plii_rigid_contact* found = &contacts[first];
    const bool is_it =
        found->node == node && found->rigid == candidate->rigid && found->shape == candidate->shape_index;
    return is_it ? found : NULL;
}

/* Of the plane of its contact, where the step began; and at its end, once that is reached. */
static bool held_is_outside(const plii_rigid_faces_pass* pass, const plii_rigid_contact* contact) {
    const pli_body* body = pass->body;
    const pli_rigid* rigid = contact->rigid;
    const pli_vec3 n = plii_xyz(contact->normal);
    const float least = RIGID_FACES_FLAT_DEPTH * body->collision_margin;
    const float begin = pli_vec3_dot(n, plii_xyz(body->previous[contact->node])) + contact->normal.w;
    if (!(begin >= least)) { return false; }
    if (!pass->is_at_end) { return true; }
    const pli_vec3 x = plii_xyz(body->positions[contact->node]);
    const pli_vec3 surface = plii_rigid_velocity_at(rigid, pli_vec3_sub(x, pass->candidate->begin.origin));
    return pli_vec3_dot(n, x) + contact->normal.w - pli_vec3_dot(n, surface) * body->host_dt >= least;
}

/* A node with no room between two surfaces is held by its own contacts: those of faces would drag it out from there. */
bool plii_rigid_faces_is_squeezed(const pli_body* body, const plii_rigid_faces_candidate* candidate, const int* nodes) {
    for (int k = 0; k < 3; ++k) {
        const plii_rigid_contact* contact = held_find(body, candidate, nodes[k]);
        if (contact != NULL && contact->squeeze > 0.0f) { return true; }
    }
    return false;
}

/* Where contacts of their own hold all nodes of a face outside of one plane of a convex shape, no point of the face
   gets in. Nothing is looked for then: nearest points are what faces at rest would pay for. */
static bool held_is_flat(const plii_rigid_faces_pass* pass) {
    const plii_rigid_contacts* nodes = pass->body->node_contacts;
    const plii_rigid_faces_candidate* candidate = pass->candidate;
    if (candidate->shape->triangles != NULL || nodes == NULL || nodes->def.compliance > 0.0f ||
        nodes->def.friction < pass->state->def.friction) {
        return false;
    }
    const plii_rigid_contact* first = NULL;
    for (int k = 0; k < 3; ++k) {
        const plii_rigid_contact* contact = held_find(pass->body, candidate, pass->nodes[k]);
        if (contact == NULL || !held_is_outside(pass, contact)) { return false; }
        if (first == NULL) { first = contact; }
        if (!(pli_vec3_dot(plii_xyz(first->normal), plii_xyz(contact->normal)) > RIGID_FACES_FLAT)) { return false; }
    }
    return true;
}

// --------------------------------------------------------------------------------------------------- elements in reach

/* How far a point at the distance `reach` from the centre may leave the box around both ends of its way. */
static float rigid_faces_bulge(float reach, float angle) {
    return angle < 3.0f ? reach * (1.0f - cosf(0.5f * angle)) : 2.0f * reach;
}

plii_rigid_faces_pass plii_rigid_faces_make_pass(pli_body* body, plii_rigid_faces* state, int candidate_index) {
    const plii_rigid_faces_candidate* candidate = &state->candidates[candidate_index];
    const pli_shape* shape = candidate->shape;
    plii_rigid_faces_pass pass = {.body = body,
                                  .state = state,
                                  .candidate = candidate,
                                  .has_links = body->topology->face_count == 0,
                                  .end = plii_rigid_end_pose(candidate->rigid, body->host_dt),
                                  .radius = shape->def.support != NULL ? shape->def.radius : 0.0f};
    const pli_bounds local = plii_bounds_transform(shape->def.bounds(shape->def.user), candidate->shape_pose);
    pass.core =
        (plii_face_core){.shape = shape,
                         .pose = candidate->shape_pose,
                         .rotation = candidate->begin.rotation,
                         .rotation_vector = pli_vec3_scale(candidate->rigid->state.angular_velocity, body->host_dt),
                         .reach = pli_vec3_length(plii_vec3_max(pli_vec3_neg(local.min), local.max))};
    const pli_bounds before = plii_bounds_transform(local, candidate->begin),
                     after = plii_bounds_transform(local, pass.end);
    pass.bounds = plii_bounds_grow(plii_bounds_join(before, after),
                                   rigid_faces_bulge(pass.core.reach, pli_vec3_length(pass.core.rotation_vector)));
    return pass;
}

static bool rigid_faces_is_anchored(const plii_rigid_faces_pass* pass) {
    const pli_body* body = pass->body;
    for (int k = 0; body->anchored != NULL && k < 3; ++k) {
        const int node = pass->nodes[k];
        if (body->anchored[node] != 0 && body->is_anchored_to(body, node, pass->candidate->rigid)) { return true; }
    }
    return false;
}

plii_pair_key plii_rigid_faces_key(const plii_rigid_faces_pass* pass) {
    const int part = pass->triangle != NULL ? pass->triangle->index : 0;
    return (plii_pair_key){pass->element, pass->candidate->shape_index, pass->candidate->rigid, part};
}

static pli_bounds rigid_faces_bounds_of(const pli_vec3* begin, const pli_vec3* end) {
    pli_bounds all = plii_bounds_of_triangle(begin[0], begin[1], begin[2]);
    for (int k = 0; k < 3; ++k) {
        all = plii_bounds_add(all, end[k]);
    }
    return all;
}

static void rigid_faces_visit_sweep(const plii_rigid_faces_pass* pass, plii_face_sweep* sweep,
                                    plii_rigid_faces_visit_fn* visit) {
    const plii_convex_cache* side = plii_pair_cache_find(&pass->state->memory, plii_rigid_faces_key(pass));
    sweep->has_side = side != NULL && side->has_normal;
    if (sweep->has_side) { sweep->side = side->normal; }
    visit(pass, sweep);
}

typedef struct rigid_faces_triangles {
    const plii_rigid_faces_pass* pass;
    const plii_face_sweep* sweep;
    plii_rigid_faces_visit_fn* visit;
} rigid_faces_triangles;

static void rigid_faces_visit_triangle(const plii_shape_triangle* triangle, void* context) {
    const rigid_faces_triangles* all = context;
    plii_rigid_faces_pass pass = *all->pass;
    pass.triangle = triangle;
    pass.core.triangle = triangle->corners;
    pass.core.reach = 0.0f;
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 corner = pli_transform_point(pass.core.pose, triangle->corners[k]);
        pass.core.reach = plii_max(pass.core.reach, pli_vec3_length(corner));
    }
    plii_face_sweep sweep = *all->sweep;
    sweep.core = &pass.core;
    rigid_faces_visit_sweep(&pass, &sweep, all->visit);
}

static pli_vec3 rigid_faces_from_centre(const plii_face_sweep* sweep, pli_vec3 point) {
    return plii_dvec3_to_float(plii_dvec3_add(sweep->origin, plii_dvec3_from(point)));
}

/* The triangles near the way of a face, which the turn of the body bends in the frame of the shape. */
static void rigid_faces_visit_triangles(const plii_rigid_faces_pass* pass, float reach, const plii_face_sweep* sweep,
                                        plii_rigid_faces_visit_fn* visit) {
    const pli_transform before = pli_transform_mul((pli_transform){pass->core.rotation, {0, 0, 0}}, pass->core.pose);
    const pli_transform after = pli_transform_mul((pli_transform){pass->end.rotation, {0, 0, 0}}, pass->core.pose);
    pli_vec3 begin[3], end[3];
    float farthest = 0.0f;
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 at_begin = rigid_faces_from_centre(sweep, sweep->begin[k]);
        const pli_vec3 at_end = rigid_faces_from_centre(sweep, sweep->end[k]);
        begin[k] = pli_transform_inverse_point(before, at_begin);
        end[k] = pli_transform_inverse_point(after, at_end);
        farthest = plii_max(farthest, plii_max(pli_vec3_length(at_begin), pli_vec3_length(at_end)));
    }
    const float bulge = rigid_faces_bulge(farthest, pli_vec3_length(pass->core.rotation_vector));
    const pli_shape* shape = pass->candidate->shape;
    rigid_faces_triangles all = {pass, sweep, visit};
    shape->triangles(shape->def.user, plii_bounds_grow(rigid_faces_bounds_of(begin, end), reach + bulge),
                     rigid_faces_visit_triangle, &all);
}

static pli_vec3 rigid_faces_relative(pli_vec3 point, pli_vec3 centre_of_mass, plii_dvec3 origin) {
    const plii_dvec3 offset = plii_dvec3_sub(plii_dvec3_from(point), plii_dvec3_from(centre_of_mass));
    return plii_dvec3_to_float(plii_dvec3_sub(offset, origin));
}

static void rigid_faces_visit_element(const plii_rigid_faces_pass* pass, float reach,
                                      plii_rigid_faces_visit_fn* visit) {
    const pli_body* body = pass->body;
    pli_vec3 begin[3], end[3];
    for (int k = 0; k < 3; ++k) {
        begin[k] = plii_xyz(body->previous[pass->nodes[k]]);
        end[k] = plii_xyz(body->positions[pass->nodes[k]]);
    }
    if (!plii_bounds_overlap(plii_bounds_grow(rigid_faces_bounds_of(begin, end), reach), pass->bounds)) { return; }
    if (held_is_flat(pass)) { return; }
    plii_face_sweep sweep = {.core = &pass->core, .is_link = pass->has_links};
    sweep.origin = plii_dvec3_sub(plii_dvec3_from(begin[0]), plii_dvec3_from(pass->candidate->begin.origin));
    for (int k = 0; k < 3; ++k) {
        sweep.begin[k] = rigid_faces_relative(begin[k], pass->candidate->begin.origin, sweep.origin);
        sweep.end[k] = rigid_faces_relative(end[k], pass->end.origin, sweep.origin);
    }
    if (rigid_faces_is_anchored(pass)) { return; }
    if (pass->candidate->shape->triangles != NULL) {
        rigid_faces_visit_triangles(pass, reach, &sweep, visit);
    } else {
        rigid_faces_visit_sweep(pass, &sweep, visit);
    }
}

void plii_rigid_faces_visit(plii_rigid_faces_pass* pass, float reach, plii_rigid_faces_visit_fn* visit) {
    const pli_body* body = pass->body;
    const int count = pass->has_links ? body->link_count : body->topology->face_count;
    for (int i = 0; i < count; ++i) {
        if (pass->has_links && plii_link_is_bending(body, i)) { continue; }
        const int* nodes = pass->has_links ? body->links[i].nodes : body->topology->faces[i];
        pass->element = i;
        pass->nodes[0] = nodes[0];
        pass->nodes[1] = nodes[1];
        pass->nodes[2] = nodes[pass->has_links ? 1 : 2];
        rigid_faces_visit_element(pass, reach, visit);
    }
}

// ---------------------------------------------------------------------------------------------------- making contacts

/* What pinned nodes have of the gap where they are inside of a body that cannot move. The other nodes cannot take that
   back: near a pinned one they would be thrown away by many times the depth. */
static float rigid_faces_pinned_part(const pli_body* body, const plii_rigid_face_contact* contact) {
    const pli_vec3 point = plii_rigid_faces_point(body->positions, contact);
    float part = 0.0f, weights[3];
    memcpy(weights, &contact->weights, sizeof weights);
    for (int k = 0; k < 3 && !(contact->rigid->state.inverse_mass > 0.0f); ++k) {
        const pli_vec4* x = &body->positions[contact->nodes[k]];
        if (x->w > 0.0f) { continue; }
        const float height = pli_vec3_dot(contact->normal, pli_vec3_sub(plii_xyz(*x), point));
        part += weights[k] * plii_min(contact->distance + height, 0.0f);
    }
    return part;
}

/* Where nodes that can move bear next to nothing of the point they bear nothing: they would fly far to mend rounding,
   or a body that is held from both sides. False when nobody is left that can move. */
static bool rigid_faces_drop_light_shares(const pli_body* body, plii_rigid_face_contact* contact) {
    const pli_vec4* x = body->positions;
    const int* nodes = contact->nodes;
    const pli_vec3 weights = contact->weights;
    const pli_vec3 pinned =
        pli_vec3_make(x[nodes[0]].w > 0.0f ? 0.0f : weights.x, x[nodes[1]].w > 0.0f ? 0.0f : weights.y,
                      x[nodes[2]].w > 0.0f ? 0.0f : weights.z);
    const float share = pinned.x + pinned.y + pinned.z;
    if (!(share > 1.0f - RIGID_FACES_LEAST_SHARE)) { return true; }
    contact->weights = pli_vec3_scale(pinned, 1.0f / share);
    return contact->rigid->state.inverse_mass > 0.0f;
}

static void rigid_faces_add(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep,
                            const plii_face_moment* moment, float end_gap, float target_gap) {
    pli_body* body = pass->body;
    plii_rigid_faces* state = pass->state;
    pli_rigid* rigid = pass->candidate->rigid;
    plii_rigid_face_contact contact = {.rigid = rigid,
                                       .candidate = (int)(pass->candidate - state->candidates),
                                       .shape = pass->candidate->shape_index,
                                       .element = pass->element,
                                       .nodes = {pass->nodes[0], pass->nodes[1], pass->nodes[2]},
                                       .weights = moment->weights,
                                       .normal = moment->normal,
                                       .core_point = moment->core_point,
                                       .excess = plii_face_sweep_excess(sweep, moment),
                                       .distance = end_gap};
    contact.is_triangle = pass->triangle != NULL;
    for (int k = 0; k < 3 && contact.is_triangle; ++k) {
        contact.triangle[k] = pass->triangle->corners[k];
    }
    if (!rigid_faces_drop_light_shares(body, &contact)) { return; }
    if (pass->is_at_end && plii_rigid_faces_is_squeezed(body, pass->candidate, contact.nodes)) { return; }
    contact.start = plii_rigid_faces_point(body->previous, &contact);
    contact.given_up = rigid_faces_pinned_part(body, &contact);
    contact.target = plii_min(target_gap, contact.given_up);
    plii_rigid_faces_prepare_contact(body, pass->candidate, pass->end, &contact);
    const pli_vec3 rigid_motion = plii_rigid_motion_at(body, rigid, contact.arm);
    const pli_vec3 face_motion = pli_vec3_sub(plii_rigid_faces_point(body->positions, &contact), contact.start);
    contact.slip = plii_contact_slip(pli_vec3_sub(face_motion, rigid_motion), contact.normal,
                                     state->def.friction * rigid->friction);
    if (!PLII_GROW(body->context, &state->contacts, &state->capacity, state->count) ||
        (body->records_contacts && !plii_contact_impulses_add(body, &state->impulses, state->count))) {
        return;
    }
    state->contacts[state->count++] = contact;
    plii_rigid_touch(rigid);
}

/* Distance of the surfaces along the normal at the end, minus the margin. */
static float rigid_faces_end_gap(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep,
                                 const plii_face_moment* moment) {
    return plii_face_sweep_end_gap(sweep, moment) - pass->radius - pass->body->collision_margin;
}

static float rigid_faces_slack(const pli_body* body, const plii_face_sweep* sweep) {
    const pli_bounds swept = rigid_faces_bounds_of(sweep->begin, sweep->end);
    const float size = pli_vec3_length(pli_vec3_sub(swept.max, swept.min));
    return plii_max(0.5f * body->collision_margin, RIGID_FACES_SMALLEST_SLACK * size);
}

/* A face that was on no side before goes at the recovery speed at most: a body put into cloth would throw it away. */
static float rigid_faces_target_gap(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep, float begin_gap) {
    const pli_rigid_face_contacts_def* def = &pass->state->def;
    const bool is_dynamic = pass->candidate->rigid->kind == PLI_RIGID_DYNAMIC;
    const float gap = plii_min(begin_gap, 0.0f);
    const float left = gap * (1.0f - (is_dynamic ? def->dynamic_hardness : def->static_hardness));
    return sweep->has_side ? left : plii_min(left, gap + plii_contact_recovery_speed(0.0f) * pass->body->step.dt);
}

/* At the start of a step. Of a triangle only its front counts: faces behind it are inside or belong to another one. */
static bool rigid_faces_begin(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep, float max_distance,
                              plii_face_moment* moment) {
    if (pass->triangle == NULL) { return plii_face_sweep_look(sweep, 0.0f, max_distance, moment); }
    const pli_mat3 rotation = pli_mat3_mul(pass->core.rotation, pass->core.pose.rotation);
    const pli_vec3 front = pli_mat3_mul_vec3(rotation, pass->triangle->normal);
    plii_face_sweep known = *sweep;
    if (!plii_face_sweep_look(&known, 0.0f, max_distance, moment)) { return false; }
    if (moment->is_overlapping && !known.has_side) {
        known.has_side = true;
        known.side = front;
        return plii_face_sweep_look(&known, 0.0f, max_distance, moment);
    }
    return pli_vec3_dot(moment->normal, front) > 0.0f;
}

/* Whether another triangle is nearer to the point of the face: that one makes the contact. What is left takes its
   normal from the whole mesh, so that faces do not catch on the edges between triangles. */
static bool rigid_faces_is_covered(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep,
                                   plii_face_moment* moment) {
    if (pass->triangle == NULL || moment->is_overlapping) { return false; }
    const plii_face_core* core = &pass->core;
    const pli_transform begin = {core->rotation, {0, 0, 0}};
    const pli_transform turned =
        plii_rigid_advance(begin, (plii_twist){{0, 0, 0}, core->rotation_vector}, moment->time);
    const pli_transform pose = pli_transform_mul(turned, core->pose);
    const pli_vec3 local = pli_transform_inverse_point(pose, rigid_faces_from_centre(sweep, moment->point));
    pli_vec3 local_normal;
    const float distance = plii_shape_distance(core->shape, local, &local_normal);
    if (distance < 0.999f * moment->distance - 1e-6f * pli_vec3_length(local)) { return true; }
    const pli_vec3 normal = pli_mat3_mul_vec3(pose.rotation, local_normal);
    if (pli_vec3_dot(normal, moment->normal) > RIGID_FACES_SAME_NORMAL) { moment->normal = normal; }
    return false;
}

/* A point of the face at the start of the step. */
static plii_face_moment rigid_faces_measure_point(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep,
                                                  pli_vec3 weights) {
    const plii_face_core* core = &pass->core;
    const pli_transform pose = pli_transform_mul((pli_transform){core->rotation, {0, 0, 0}}, core->pose);
    plii_face_moment moment = {.weights = weights, .point = plii_face_blend(sweep->begin, weights)};
    const pli_vec3 local = pli_transform_inverse_point(pose, rigid_faces_from_centre(sweep, moment.point));
    pli_vec3 normal;
    moment.distance = plii_shape_distance(core->shape, local, &normal) + pass->radius;
    moment.normal = pli_mat3_mul_vec3(pose.rotation, normal);
    moment.nearest = pli_vec3_sub(moment.point, pli_vec3_scale(moment.normal, moment.distance));
    moment.core_point = pli_transform_point(core->pose, pli_vec3_sub(local, pli_vec3_scale(normal, moment.distance)));
    return moment;
}

/* Contacts at the points that were some in the step before, as long as they are near: the nearest point of a face alone
   goes to and fro, and the face rocks. `nearest` becomes the least distance of theirs. */
static void rigid_faces_keep(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep, float target,
                             float* nearest) {
    const plii_convex_cache* before = plii_pair_cache_find(&pass->state->memory, plii_rigid_faces_key(pass));
    for (int i = 0; before != NULL && i < before->count; ++i) {
        const plii_face_moment moment = rigid_faces_measure_point(pass, sweep, before->points[i]);
        const float end_gap = rigid_faces_end_gap(pass, sweep, &moment);
        if (!(moment.distance <= target) || !plii_is_finite(end_gap)) { continue; }
        *nearest = plii_min(*nearest, moment.distance);
        const float begin_gap = moment.distance - pass->radius - pass->body->collision_margin;
        const float target_gap = rigid_faces_target_gap(pass, sweep, begin_gap);
        rigid_faces_add(pass, sweep, &moment, end_gap, target_gap);
    }
}

/* The first moment at which face and shape are near. */
static void rigid_faces_collide_element(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep) {
    const float margin = pass->body->collision_margin, slack = rigid_faces_slack(pass->body, sweep);
    const float target = pass->radius + margin + slack;
    plii_face_moment moment;
    if (!rigid_faces_begin(pass, sweep, target + plii_face_sweep_length(sweep), &moment)) { return; }
    float kept = INFINITY;
    if (!moment.is_overlapping) { rigid_faces_keep(pass, sweep, target, &kept); }
    if (moment.distance > kept - RIGID_FACES_NEW_POINT * margin) { return; }
    const float target_gap = rigid_faces_target_gap(pass, sweep, moment.distance - pass->radius - margin);
    if (!plii_face_sweep_advance(sweep, target, 0.25f * slack, &moment) || !plii_face_sweep_weigh(sweep, &moment)) {
        return;
    }
    if (rigid_faces_is_covered(pass, sweep, &moment)) { return; }
    const float end_gap = rigid_faces_end_gap(pass, sweep, &moment);
    if (!plii_is_finite(end_gap)) { return; }
    rigid_faces_add(pass, sweep, &moment, end_gap, target_gap);
}

/* Substeps and systems have solved what the planes of contacts know: only what is about to pass the core is left. */
static float rigid_faces_tolerance(const pli_body* body) {
    return plii_rigid_faces_are_solved(body) ? 0.5f * body->collision_margin : 0.0f;
}

/* A face that passed the core where no point told so on its way. */
static void rigid_faces_review_end(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep, pli_vec3 side,
                                   float target_gap) {
    plii_face_sweep end = *sweep;
    end.has_side = true;
    end.side = side;
    plii_face_moment moment;
    if (!plii_face_sweep_look(&end, 1.0f, INFINITY, &moment) || !moment.is_overlapping) { return; }
    if (!plii_face_sweep_weigh(sweep, &moment)) { return; }
    const float end_gap = rigid_faces_end_gap(pass, sweep, &moment);
    if (!(end_gap < target_gap - rigid_faces_tolerance(pass->body))) { return; }
    rigid_faces_add(pass, sweep, &moment, end_gap, target_gap);
}

/* Only what is too near at the end counts, and what is near from the start must come nearer. */
static void rigid_faces_review_element(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep) {
    const float margin = pass->body->collision_margin, slack = rigid_faces_slack(pass->body, sweep);
    float target = pass->radius + margin + slack;
    plii_face_moment moment;
    if (!rigid_faces_begin(pass, sweep, target + plii_face_sweep_length(sweep), &moment)) { return; }
    const float target_gap = rigid_faces_target_gap(pass, sweep, moment.distance - pass->radius - margin);
    if (!moment.is_overlapping) {
        target = plii_min(target, 0.5f * moment.distance);
        float tolerance = plii_min(0.25f * slack, 0.25f * target);
        for (int i = 0; i < RIGID_FACES_MAX_TARGETS; ++i) {
            if (!plii_face_sweep_advance(sweep, target, tolerance, &moment)) { return; }
            if (!plii_face_sweep_weigh(sweep, &moment)) { return; }
            plii_face_moment touch = moment;
            if (rigid_faces_is_covered(pass, sweep, &touch)) { return; }
            const float end_gap = rigid_faces_end_gap(pass, sweep, &touch);
            if (end_gap < target_gap - rigid_faces_tolerance(pass->body)) {
                rigid_faces_add(pass, sweep, &touch, end_gap, target_gap);
                return;
            }
            /* This point of the face gets out of the way in time, others may not. */
            target *= 0.5f;
            tolerance = 0.25f * target;
        }
    }
    rigid_faces_review_end(pass, sweep, moment.normal, target_gap);
}

static float rigid_faces_reach(const pli_body* body) {
    return 1.5f * body->collision_margin;
}

int plii_rigid_faces_review(pli_body* body, plii_rigid_faces* state) {
    const int before = state->count;
    for (int i = 0; i < state->candidate_count; ++i) {
        plii_rigid_faces_pass pass = plii_rigid_faces_make_pass(body, state, i);
        pass.is_at_end = true;
        plii_rigid_faces_visit(&pass, rigid_faces_reach(body), rigid_faces_review_element);
    }
    return state->count - before;
}

void plii_rigid_faces_drop_candidates(plii_rigid_faces* state, int count) {
    while (state->candidate_count > count) {
        plii_shape_release(state->candidates[--state->candidate_count].shape);
    }
}

static void rigid_faces_collide_shape(pli_body* body, plii_rigid_faces* state, pli_rigid* rigid, int index) {
    if (rigid->shapes[index]->def.support == NULL && rigid->shapes[index]->triangles == NULL) { return; }
    const int count = state->candidate_count;
    if (!PLII_GROW(body->context, &state->candidates, &state->candidate_capacity, count)) { return; }
    state->candidates[count] = (plii_rigid_faces_candidate){.rigid = rigid,
                                                            .shape_index = index,
                                                            .shape = rigid->shapes[index],
                                                            .shape_pose = rigid->shape_poses[index],
                                                            .begin = rigid->state.pose};
    plii_rigid_begin_path(rigid);
    plii_rigid_faces_pass pass = plii_rigid_faces_make_pass(body, state, count);
    state->candidates[count].bounds = pass.bounds;
    if (!plii_bounds_overlap(plii_bounds_grow(pass.bounds, body->collision_margin), body->bounds)) { return; }
    held_find_nodes(body, &state->candidates[count]);
    plii_shape_retain(rigid->shapes[index]);
    ++state->candidate_count;
    plii_rigid_faces_visit(&pass, rigid_faces_reach(body), rigid_faces_collide_element);
}

void plii_rigid_faces_collide(pli_body* body, void* data, pli_rigid* rigid) {
    plii_rigid_faces* state = data;
    const int before = state->count;
    for (int i = 0; i < rigid->shape_count; ++i) {
        rigid_faces_collide_shape(body, state, rigid, i);
    }
    body->has_swept_contacts = body->has_swept_contacts || state->count > before;
}
