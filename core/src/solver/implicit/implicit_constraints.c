/* Anchors and contacts for the implicit system: what they ask of velocities at the end of the step, as in Baraff and
   Witkin, "Large Steps in Cloth Simulation", section 5; here those of the rigid bodies behind them are unknown too. */

#include "solver/implicit/implicit_constraints.h"
#include "base/csr.h"
#include "body/pipeline.h"
#include "body/substep_rigid.h"

/* Pinned nodes count as so many times heavier than the rigid body that they are anchored to. */
#define IMPLICIT_PINNED_RATIO 1e6
#define IMPLICIT_IMMOVABLE 1e30
#define IMPLICIT_HOLD_RECOVERY 0.1   /* s, in which a body comes out of what holds it */
#define IMPLICIT_TURN 0.1            /* rad, by which arms are off before they are taken anew */
#define IMPLICIT_LEAST_RESPONSE 0.01 /* across, of that along a normal: locked axes have next to none */

// ------------------------------------------------------------------------------------------------- rigid bodies

/* Inverse of a symmetric 3x3 matrix. */
static void implicit_invert_inertia(double a[3][3], double least, double inertia[3][3]) {
    const double xx = a[0][0] + least, yy = a[1][1] + least, zz = a[2][2] + least;
    const double xy = 0.5 * (a[0][1] + a[1][0]), xz = 0.5 * (a[0][2] + a[2][0]), yz = 0.5 * (a[1][2] + a[2][1]);
    const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
    const double inverse = 1.0 / (xx * cxx + xy * cxy + xz * cxz);
    const double ixy = cxy * inverse, ixz = cxz * inverse, iyz = (xy * xz - xx * yz) * inverse;
    const double rows[3][3] = {{cxx * inverse, ixy, ixz},
                               {ixy, (xx * zz - xz * xz) * inverse, iyz},
                               {ixz, iyz, (xx * yy - xy * xy) * inverse}};
    memcpy(inertia, rows, sizeof rows);
}

static void implicit_constraints_prepare_rigid(plii_implicit_rigid* touched, pli_rigid* rigid) {
    *touched = (plii_implicit_rigid){.rigid = rigid};
    touched->is_dynamic = rigid->state.inverse_mass > 0.0f && !rigid->is_absent;
    if (!touched->is_dynamic) { return; }
    const float linear[3] = {rigid->linear_factor.x, rigid->linear_factor.y, rigid->linear_factor.z};
    const double factor[3] = {sqrt(fabs((double)rigid->angular_factor.x)), sqrt(fabs((double)rigid->angular_factor.y)),
                              sqrt(fabs((double)rigid->angular_factor.z))};
    for (int i = 0; i < 3; ++i) {
        const double inverse_mass = (double)rigid->state.inverse_mass * (double)linear[i];
        touched->mass[i] = inverse_mass > 0.0 ? 1.0 / inverse_mass : IMPLICIT_IMMOVABLE;
        const pli_vec3 row = rigid->state.inverse_inertia_world.rows[i];
        touched->inverse_inertia[i][0] = (double)row.x * factor[i] * factor[0];
        touched->inverse_inertia[i][1] = (double)row.y * factor[i] * factor[1];
        touched->inverse_inertia[i][2] = (double)row.z * factor[i] * factor[2];
    }
    double(*const a)[3] = touched->inverse_inertia, trace = a[0][0] + a[1][1] + a[2][2];
    const double least = trace > 0.0 ? 1e-12 * trace : 1.0 / IMPLICIT_IMMOVABLE; /* rows of locked axes are zero */
    implicit_invert_inertia(a, least, touched->inertia);
    memcpy(touched->own_inertia, touched->inertia, sizeof touched->inertia);
}

/* What pulls at an arm r by F rights the body as it turns, like a spring of F.r - r F: times h^2, kg m^2. Where that is
   not positive definite, by as much more in all directions. */
static void implicit_add_righting(const plii_implicit_constraints* constraints, int index, double h) {
    plii_implicit_rigid* touched = &constraints->rigids[index];
    double sum[3][3] = {0}, square = 0.0;
    for (PLII_EACH(const plii_implicit_constraint, anchor, constraints->items, constraints->count)) {
        if (anchor->rigid != index) { continue; }
        const plii_dvec3 push = plii_dvec3_scale(anchor->impulse, h);
        const double r[3] = {anchor->arm.x, anchor->arm.y, anchor->arm.z}, p[3] = {push.x, push.y, push.z};
        for (int i = 0; i < 9; ++i) {
            sum[i / 3][i % 3] += 0.5 * (r[i / 3] * p[i % 3] + p[i / 3] * r[i % 3]);
            sum[i / 3][i % 3] -= i % 4 == 0 ? plii_dvec3_dot(push, anchor->arm) : 0.0;
        }
    }
    const double mean = (sum[0][0] + sum[1][1] + sum[2][2]) / 3.0;
    for (int i = 0; i < 9; ++i) {
        const double off = sum[i / 3][i % 3] - (i % 4 == 0 ? mean : 0.0);
        square += off * off;
    }
    const double more = fmax(2.0 * sqrt(square / 6.0) - mean, 0.0); /* no eigenvalue is below -more */
    if (!(mean > 0.0)) { return; }
    for (int i = 0; i < 9; ++i) {
        touched->inertia[i / 3][i % 3] += sum[i / 3][i % 3] + (i % 4 == 0 ? more : 0.0);
    }
    implicit_invert_inertia(touched->inertia, 0.0, touched->inverse_inertia);
}

/* PLI_NULL_INDEX without memory. */
static int implicit_constraints_find_rigid(pli_body* body, plii_implicit_constraints* constraints, pli_rigid* rigid) {
    const int count = constraints->rigid_count;
    for (int i = count - 1; i >= 0; --i) {
        if (constraints->rigids[i].rigid == rigid) { return i; }
    }
    if (!PLII_GROW(body->context, &constraints->rigids, &constraints->rigid_capacity, count)) { return PLI_NULL_INDEX; }
    implicit_constraints_prepare_rigid(&constraints->rigids[constraints->rigid_count++], rigid);
    return count;
}

void plii_implicit_constraints_push_rigids(const pli_body* body, plii_implicit_constraints* constraints) {
    for (PLII_EACH(const plii_implicit_rigid, touched, constraints->rigids, constraints->rigid_count)) {
        const double* q = touched->change;
        const plii_twist change = {{(float)q[0], (float)q[1], (float)q[2]}, {(float)q[3], (float)q[4], (float)q[5]}};
        const bool is_finite = plii_vec3_is_finite(change.linear) && plii_vec3_is_finite(change.angular);
        if (!touched->is_dynamic || !is_finite) { continue; }
        const plii_twist own = plii_twist_scale(change, 1.0f / body->rigid_pace);
        plii_rigid_set_velocity(touched->rigid, plii_twist_add(plii_rigid_velocity(touched->rigid), own));
        if (plii_rigid_is_moved_by_host(touched->rigid)) { touched->rigid->needs_reintegration = true; }
    }
}

static void implicit_constraint_report(const plii_implicit_constraint* constraint, plii_dvec3 impulse) {
    if (constraint->reported == NULL) { return; }
    const pli_vec3 sum = pli_vec3_add(*constraint->reported, plii_dvec3_to_float(impulse));
    if (plii_vec3_is_finite(sum)) { *constraint->reported = sum; }
}

/* What impulses leave of the change of momentum of each rigid body, and what they are in all. */
static void implicit_sum_impulses(plii_implicit_constraints* constraints) {
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        memset(rigid->residual, 0, sizeof rigid->residual);
        for (int k = 0; k < 3 && rigid->is_dynamic; ++k) {
            rigid->residual[k] = rigid->mass[k] < IMPLICIT_IMMOVABLE ? rigid->mass[k] * rigid->change[k] : 0.0;
        }
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
        const double impulse[3] = {constraint->impulse.x, constraint->impulse.y, constraint->impulse.z};
        for (int k = 0; k < 3; ++k) {
            rigid->residual[k] += rigid->mass[k] < IMPLICIT_IMMOVABLE ? impulse[k] : 0.0;
        }
        rigid->residual[3] += constraint->reported != NULL ? plii_dvec3_length(constraint->impulse) : 0.0;
    }
}

/* Where iterations end early impulses are not yet what moves the rigid body; the rest is shared among them. */
void plii_implicit_constraints_report(plii_implicit_constraints* constraints) {
    implicit_sum_impulses(constraints);
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        const plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
        const double* rest = rigid->residual;
        plii_dvec3 impulse = constraint->impulse;
        const double size = plii_dvec3_length(impulse);
        if (rigid->is_dynamic && size > 0.0 && rest[3] > 0.0) {
            impulse = plii_dvec3_add_scaled(impulse, plii_dvec3_make(rest[0], rest[1], rest[2]), -size / rest[3]);
        }
        implicit_constraint_report(constraint, impulse);
    }
}

void plii_implicit_constraint_reproject(pli_body* body, plii_implicit_constraints* constraints,
                                        plii_implicit_constraint* constraint) {
    plii_implicit_rigid* touched = &constraints->rigids[constraint->rigid];
    const double h = (double)body->step.dt;
    const plii_dvec3 x = plii_implicit_xyz(&body->positions[constraint->nodes[0]]);
    plii_dvec3 off = plii_dvec3_sub(constraint->goal_position, x);
    if (touched->is_dynamic) {
        off = plii_dvec3_add_scaled(off, plii_implicit_point_change(touched->change, constraint->arm), h);
    }
    if (!constraint->is_anchor) {
        const double depth = plii_dvec3_dot(off, constraint->normal), friction = constraint->friction * depth;
        const plii_dvec3 across = plii_dvec3_across(off, constraint->normal);
        const double sliding = plii_dvec3_length(across);
        if (!(depth > 0.0)) { return; }
        off = plii_dvec3_add_scaled(off, across, sliding > friction ? friction / sliding - 1.0 : 0.0);
    }
    const double distance = plii_dvec3_length(off);
    const plii_dvec3 direction = plii_dvec3_scale(off, distance > 0.0 ? 1.0 / distance : 0.0);
    if (!(distance > 0.0) || !plii_is_finite((float)distance)) { return; }
    const pli_vec3 unit = plii_dvec3_to_float(direction), arm = plii_dvec3_to_float(constraint->arm);
    const double node_weight = (double)body->positions[constraint->nodes[0]].w;
    const plii_substep_rigid_point point = {touched->rigid, arm};
    const double rigid_weight = (double)plii_substep_rigid_point_weight(&point, unit);
    const double push = constraint->influence * distance / (node_weight + rigid_weight); /* kg m */
    plii_set_xyz(&body->positions[constraint->nodes[0]],
                 plii_dvec3_to_float(plii_dvec3_add_scaled(x, direction, push * node_weight)));
    implicit_constraint_report(constraint, plii_dvec3_scale(direction, push / h));
    if (!touched->is_dynamic) { return; }
    const plii_twist before = plii_rigid_velocity(point.rigid);
    plii_rigid_push_at(body, point.rigid, pli_vec3_scale(unit, (float)(-push / h)), arm);
    const plii_twist change =
        plii_twist_scale(plii_twist_sub(plii_rigid_velocity(point.rigid), before), body->rigid_pace);
    plii_implicit_add_twist(touched->change, plii_dvec3_from(change.linear), plii_dvec3_from(change.angular), 1.0);
}

// --------------------------------------------------------------------------------------------------- conditions

/* Points of faces, of PLI_NULL_INDEX, come last. */
static bool implicit_constraint_is_after(const plii_node_constraint* a, const plii_node_constraint* b) {
    return (unsigned)a->node > (unsigned)b->node;
}

/* Merges sorted runs until there is one; constraints of a node keep their order. `to` is as long as `from`. */
static void implicit_constraints_sort(plii_node_constraint* from, plii_node_constraint* to, int count) {
    for (int width = 1; width < count; width *= 2) {
        for (int begin = 0; begin < count; begin += 2 * width) {
            const int middle = begin + width < count ? begin + width : count;
            const int end = middle + width < count ? middle + width : count;
            int a = begin, b = middle;
            for (int i = begin; i < end; ++i) {
                to[i] = b >= end || (a < middle && !implicit_constraint_is_after(&from[a], &from[b])) ? from[a++]
                                                                                                      : from[b++];
            }
        }
        memcpy(from, to, (size_t)count * sizeof *from);
    }
}

/* The second half of the list is for sorting. */
static int implicit_constraints_list(pli_body* body, plii_implicit_constraints* constraints, bool with_contacts) {
    const int count = plii_features_list_constraints(body, 2, &constraints->listed, &constraints->listed_capacity);
    plii_node_constraint* listed = constraints->listed;
    bool is_sorted = true;
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        if (!with_contacts && !listed[i].is_anchor) { continue; }
        listed[kept++] = listed[i];
        is_sorted = is_sorted && (kept == 1 || !implicit_constraint_is_after(&listed[kept - 2], &listed[kept - 1]));
    }
    if (!is_sorted) { implicit_constraints_sort(listed, listed + kept, kept); }
    /* Each may hold its rigid body twice. */
    return PLII_RESERVE(body->context, &constraints->items, &constraints->capacity, 2 * kept)
               ? kept
               : constraints->capacity / 2;
}

/* With which a point of the rigid body leaves where it was at the start of the step, as far as it is known yet: where
   the solution leads, less what that adds along `arm`, of the point there. */
static plii_dvec3 implicit_point_velocity(const pli_body* body, const plii_implicit_rigid* touched, pli_vec3 local,
                                          plii_dvec3* arm) {
    const pli_rigid* rigid = touched->rigid;
    const double* q = touched->change;
    const plii_twist change = {{(float)q[0], (float)q[1], (float)q[2]}, {(float)q[3], (float)q[4], (float)q[5]}};
    const float dt = body->host_dt, lead = body->interval.lead / dt;
    const pli_transform begin = rigid->path.begin;
    plii_twist velocity = plii_rigid_end_velocity(rigid, dt);
    /* By a step of the world, which that of the body may go beyond. */
    if (lead > 0.0f && plii_rigid_is_moved_by_host(rigid)) {
        velocity = plii_twist_add(velocity, plii_twist_scale(rigid->given, lead));
    }
    velocity = plii_twist_add(velocity, plii_twist_scale(change, 1.0f / body->rigid_pace));
    const pli_transform end = plii_rigid_advance(rigid->state.pose, velocity, dt);
    *arm = plii_dvec3_from(pli_mat3_mul_vec3(end.rotation, local));
    const plii_dvec3 turned = plii_dvec3_sub(*arm, plii_dvec3_from(pli_mat3_mul_vec3(begin.rotation, local)));
    plii_dvec3 moved = plii_dvec3_sub(plii_dvec3_from(rigid->state.pose.origin), plii_dvec3_from(begin.origin));
    moved = plii_dvec3_add_scaled(moved, plii_dvec3_from(velocity.linear), (double)dt);
    moved = plii_dvec3_scale(plii_dvec3_add(moved, turned), 1.0 / (double)body->step.dt);
    return plii_dvec3_sub(moved, plii_implicit_point_change(q, *arm));
}

/* Those of a point of a face without the ones that have no weight. */
static void implicit_constraint_set_nodes(const pli_body* body, const plii_node_constraint* from,
                                          plii_implicit_constraint* item) {
    const bool is_of_face = from->node == PLI_NULL_INDEX;
    const float weights[3] = {is_of_face ? from->weights.x : 1.0f, from->weights.y, from->weights.z};
    const int* nodes = is_of_face ? from->face_nodes : &from->node;
    item->is_pinned = true;
    for (int k = 0; k < (is_of_face ? 3 : 1); ++k) {
        if (!(weights[k] > 0.0f)) { continue; }
        item->nodes[item->node_count] = nodes[k];
        item->weights[item->node_count++] = (double)weights[k];
        item->is_pinned = item->is_pinned && !(body->positions[nodes[k]].w > 0.0f);
    }
}

/* `start` and `velocity`: of the point that is held, without what the solution adds. */
static void implicit_constraint_set_target(const pli_body* body, const plii_node_constraint* from,
                                           const plii_implicit_rigid* touched, plii_dvec3 start, plii_dvec3 velocity,
                                           plii_implicit_constraint* item) {
    const double inverse_dt = (double)body->step.inverse_dt, hardness = (double)from->hardness;
    const pli_rigid* rigid = from->rigid;
    pli_vec3 local = from->pivot;
    if (from->is_anchor) {
        const plii_dvec3 pivot = plii_dvec3_from(pli_transform_point(rigid->path.begin, local));
        const plii_dvec3 off = plii_dvec3_sub(pivot, start);
        const double length = sqrt(plii_dvec3_dot(off, off)), pace = hardness * inverse_dt;
        const double most = fmax((double)from->recovery_speed, (double)PLII_ANCHOR_RECOVERY_RATE * length);
        item->recovery = plii_dvec3_scale(off, pace * length > most ? most / length : pace);
        item->target = item->recovery;
    } else {
        if (from->node != PLI_NULL_INDEX && !from->has_pivot) {
            local = pli_transform_inverse_point(rigid->path.begin, plii_xyz(body->positions[from->node]));
        }
        item->normal = plii_dvec3_from(from->normal);
        item->friction = (double)from->friction;
        const double gap = item->gap = plii_dvec3_dot(item->normal, start) + (double)from->offset;
        const double speed =
            gap > 0.0 ? -gap * inverse_dt : fmin(-gap * hardness * inverse_dt, (double)from->recovery_speed);
        item->target = plii_dvec3_scale(item->normal, speed);
        if (speed > 0.0) { item->recovery = item->target; }
    }
    item->surface_velocity = implicit_point_velocity(body, touched, local, &item->arm);
    item->local = local;
    item->target = plii_dvec3_add(item->target, item->surface_velocity);
    item->goal_position = plii_dvec3_add_scaled(start, item->target, (double)body->step.dt);
    item->target = plii_dvec3_sub(item->target, velocity);
    if (!(rigid->state.inverse_mass > 0.0f)) {
        item->fall = plii_dvec3_scale(plii_dvec3_from(body->world->def.gravity), (double)body->step.dt);
    }
    /* Contacts press where their normals were found: turned on with the body, the arm would spin a ball up. */
    if (!from->is_anchor) { item->arm = plii_dvec3_from(pli_mat3_mul_vec3(rigid->path.begin.rotation, local)); }
}

/* Without memory for the rigid body it is left out, as where there is nothing to hold. */
static void implicit_constraints_add(pli_body* body, plii_implicit_constraints* constraints,
                                     const plii_node_constraint* from, const plii_dvec3* base, bool is_point) {
    plii_implicit_constraint* item = &constraints->items[constraints->count];
    *item = (plii_implicit_constraint){
        .is_anchor = from->is_anchor, .influence = (double)from->influence, .share = 1.0, .is_point = is_point};
    item->reported = from->impulse;
    implicit_constraint_set_nodes(body, from, item);
    plii_rigid_touch(from->rigid);
    if ((item->is_pinned && !(from->rigid->state.inverse_mass > 0.0f)) || !(from->influence > 0.0f)) { return; }
    item->rigid = implicit_constraints_find_rigid(body, constraints, from->rigid);
    if (item->rigid == PLI_NULL_INDEX) { return; }
    plii_dvec3 start = {0}, velocity = {0};
    for (int k = 0; k < item->node_count; ++k) {
        const int node = item->nodes[k];
        const pli_vec4 x = base != NULL ? body->previous[node] : body->positions[node];
        plii_dvec3 v = plii_implicit_xyz(&body->velocities[node]);
        if (base != NULL) { v = plii_dvec3_sub(v, base[node]); }
        start = plii_dvec3_add_scaled(start, plii_implicit_xyz(&x), item->weights[k]);
        velocity = plii_dvec3_add_scaled(velocity, v, item->weights[k]);
    }
    implicit_constraint_set_target(body, from, &constraints->rigids[item->rigid], start, velocity, item);
    const double inverse = (double)from->rigid->state.inverse_mass / IMPLICIT_PINNED_RATIO;
    item->block = item->is_pinned ? (plii_implicit_block){.inverse_d = {inverse, inverse, inverse}}
                                  : constraints->blocks[item->nodes[0]];
    item->squeeze = (double)(from->squeeze * body->step.inverse_dt) * plii_implicit_block_stiffness(&item->block);
    constraints->count += 1;
}

/* What else holds a node, if a rigid body that moves presses on it, is a point like those of faces. */
static bool implicit_is_point(const plii_node_constraint* listed, int index, int count) {
    const plii_node_constraint* from = &listed[index];
    if (from->node == PLI_NULL_INDEX) { return true; }
    const bool is_alone = !(index > 0 && listed[index - 1].node == from->node) &&
                          !(index + 1 < count && listed[index + 1].node == from->node);
    return !from->is_anchor && from->rigid->state.inverse_mass > 0.0f && !is_alone;
}

/* Where nodes of a face touch the same rigid body, their own contacts hold it. */
static bool implicit_is_covered(const plii_node_constraint* listed, int count, const plii_node_constraint* from) {
    const float weights[3] = {from->weights.x, from->weights.y, from->weights.z};
    double covered = 0.0;
    for (int k = 0; k < 3 && from->node == PLI_NULL_INDEX; ++k) {
        const int node = from->face_nodes[k];
        int i = plii_csr_first(listed, sizeof *listed, offsetof(plii_node_constraint, node), count, node);
        for (; i < count && listed[i].node == node; ++i) {
            if (listed[i].rigid != from->rigid) { continue; }
            covered += (double)weights[k];
            break;
        }
    }
    return covered > 0.99;
}

/* How far a node can go along a unit vector until it meets a surface that takes no impulses; what that does, m/s. */
static double implicit_room(const plii_implicit_constraints* constraints, int node, plii_dvec3 direction,
                            plii_dvec3* velocity) {
    double room = (double)INFINITY;
    const int count = constraints->node_bound_count;
    int i = plii_csr_first(constraints->items, sizeof *constraints->items, offsetof(plii_implicit_constraint, nodes),
                           count, node);
    for (; i < count && constraints->items[i].nodes[0] == node; ++i) {
        const plii_implicit_constraint* constraint = &constraints->items[i];
        const double approach = -plii_dvec3_dot(constraint->normal, direction);
        if (constraint->is_anchor || constraints->rigids[constraint->rigid].is_dynamic || !(approach > 0.1)) {
            continue;
        }
        const double found = fmax(constraint->gap, 0.0) / approach;
        if (!(found < room)) { continue; }
        room = found;
        *velocity = constraint->surface_velocity;
    }
    return room;
}

/* m/s: how the surface moves along itself, from what it touches as that came into the step. */
static plii_dvec3 implicit_across(const plii_implicit_constraint* constraint) {
    return plii_dvec3_across(constraint->target, constraint->normal);
}

/* Nodes are light: a body that presses them against what nothing moves is held by that directly. */
static void implicit_constraints_add_hold(const pli_body* body, plii_implicit_constraints* constraints, int index) {
    const plii_implicit_constraint* from = &constraints->items[index];
    const plii_implicit_rigid* rigid = &constraints->rigids[from->rigid];
    if (!from->is_point || from->is_pinned || !rigid->is_dynamic) { return; }
    const double share = fmin((double)body->step.dt / IMPLICIT_HOLD_RECOVERY, 1.0);
    double way = from->gap > 0.0 ? from->gap : share * from->gap;
    plii_dvec3 holding = {0};
    for (int k = 0; k < from->node_count; ++k) {
        plii_dvec3 velocity = {0};
        way += from->weights[k] * implicit_room(constraints, from->nodes[k], from->normal, &velocity);
        holding = plii_dvec3_add_scaled(holding, velocity, from->weights[k]);
    }
    if (!isfinite(way)) { return; }
    plii_implicit_constraint* hold = &constraints->items[constraints->count++];
    *hold = *from;
    hold->is_pinned = true;
    hold->node_count = 0;
    const plii_dvec3 approach = plii_dvec3_sub(from->surface_velocity, holding);
    const double speed = plii_dvec3_dot(from->normal, approach) - way * (double)body->step.inverse_dt;
    hold->target = plii_dvec3_add_scaled(implicit_across(from), from->normal, speed);
    hold->recovery = (plii_dvec3){0};
    const double response = plii_implicit_point_response(constraints, hold, hold->normal);
    if (!(response > 1e-9 * (double)rigid->rigid->state.inverse_mass)) { constraints->count -= 1; } /* locked */
}

/* m/s along the normal, of the node. */
static double implicit_wanted_speed(const plii_implicit_constraint* constraint, double recovery, double dt) {
    const double speed = plii_dvec3_dot(constraint->normal, constraint->surface_velocity);
    return constraint->gap > 0.0 ? speed - constraint->gap / dt : speed + recovery;
}

static void implicit_want_less(plii_implicit_constraint* constraint, double recovery, double rest, double dt) {
    const plii_dvec3 n = constraint->normal;
    constraint->recovery = plii_dvec3_add_scaled(constraint->recovery, n, -recovery);
    constraint->target = plii_dvec3_add_scaled(constraint->target, n, -recovery - rest);
    constraint->goal_position = plii_dvec3_add_scaled(constraint->goal_position, n, (-recovery - rest) * dt);
}

/* A node between two surfaces comes out of one as far as the other lets it, and stays on that of more friction. */
static void implicit_squeeze(plii_implicit_constraint* a, plii_implicit_constraint* b, double dt) {
    const double of_a = plii_dvec3_dot(a->normal, a->recovery), of_b = plii_dvec3_dot(b->normal, b->recovery);
    const double excess = fmax(implicit_wanted_speed(a, of_a, dt) + implicit_wanted_speed(b, of_b, dt), 0.0);
    const double less_a = fmin(of_a, excess), less_b = fmin(of_b, excess);
    const double rest = 0.5 * fmax(excess - less_a - less_b, 0.0);
    implicit_want_less(a, less_a, rest, dt);
    implicit_want_less(b, less_b, rest, dt);
    const double less_across = plii_dvec3_length(implicit_across(b)) - plii_dvec3_length(implicit_across(a));
    const bool is_on_a = a->friction != b->friction ? a->friction > b->friction : less_across >= 0.0;
    (is_on_a ? b : a)->squeeze = 0.0;
}

static void implicit_squeeze_nodes(plii_implicit_constraints* constraints, double dt) {
    for (PLII_EACH(plii_implicit_constraint, a, constraints->items, constraints->node_bound_count)) {
        const plii_implicit_constraint* const end = &constraints->items[constraints->node_bound_count];
        for (plii_implicit_constraint* b = a + 1; b < end && b->nodes[0] == a->nodes[0]; ++b) {
            if (a->squeeze > 0.0 && b->squeeze > 0.0) { implicit_squeeze(a, b, dt); }
        }
    }
}

void plii_implicit_constraints_gather(pli_body* body, plii_implicit_constraints* constraints, bool with_contacts,
                                      const plii_implicit_block* blocks, const plii_dvec3* base) {
    const int listed = implicit_constraints_list(body, constraints, with_contacts);
    if (base == NULL) { constraints->rigid_count = 0; }
    /* As their host has left them since the prediction. Arms do not turn with the solution: what its anchors have just
       pulled by counts as inertia, or a body that they right stiffly would swing up. */
    for (int i = 0; i < constraints->rigid_count; ++i) {
        implicit_constraints_prepare_rigid(&constraints->rigids[i], constraints->rigids[i].rigid);
        if (constraints->rigids[i].is_dynamic) { implicit_add_righting(constraints, i, (double)body->step.dt); }
    }
    constraints->count = constraints->node_bound_count = 0;
    constraints->blocks = blocks;
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = 0; i < listed; ++i) {
            const bool is_point = implicit_is_point(constraints->listed, i, listed);
            if (is_point != (pass == 1) || implicit_is_covered(constraints->listed, listed, &constraints->listed[i])) {
                continue;
            }
            implicit_constraints_add(body, constraints, &constraints->listed[i], base, is_point);
        }
        if (pass == 0) { constraints->node_bound_count = constraints->count; }
    }
    implicit_squeeze_nodes(constraints, (double)body->step.dt);
    const int count = constraints->count;
    for (int i = constraints->node_bound_count; i < count; ++i) {
        implicit_constraints_add_hold(body, constraints, i);
    }
    plii_implicit_share_nodes(constraints);
}

/* Of an anchor: a light body that is hit at its edge turns far in a step, and is righted from there. */
static void implicit_constraint_turn(const pli_body* body, const plii_implicit_rigid* touched,
                                     plii_implicit_constraint* anchor) {
    plii_dvec3 arm;
    const plii_dvec3 velocity = implicit_point_velocity(body, touched, anchor->local, &arm);
    const plii_dvec3 off = plii_dvec3_sub(arm, anchor->arm);
    if (!(plii_dvec3_dot(off, off) > IMPLICIT_TURN * IMPLICIT_TURN * plii_dvec3_dot(arm, arm))) { return; }
    const plii_dvec3 more = plii_dvec3_sub(velocity, anchor->surface_velocity);
    anchor->arm = arm;
    anchor->surface_velocity = velocity;
    anchor->target = plii_dvec3_add(anchor->target, more);
    anchor->goal_position = plii_dvec3_add_scaled(anchor->goal_position, more, (double)body->step.dt);
}

void plii_implicit_constraints_update(const pli_body* body, plii_implicit_constraints* constraints, bool are_released) {
    for (PLII_EACH(plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        const plii_implicit_rigid* touched = &constraints->rigids[constraint->rigid];
        if (constraint->is_anchor && touched->is_dynamic) { implicit_constraint_turn(body, touched, constraint); }
        if (!constraint->is_pinned) { constraint->block = constraints->blocks[constraint->nodes[0]]; }
        if (!are_released || constraint->is_anchor) { continue; }
        constraint->rows = 0;
        constraint->impulse = (plii_dvec3){0};
    }
    plii_implicit_share_nodes(constraints);
}

double plii_implicit_point_response(const plii_implicit_constraints* constraints,
                                    const plii_implicit_constraint* constraint, plii_dvec3 unit) {
    double response = 0.0, push[6] = {0};
    if (constraint->is_pinned) {
        plii_implicit_add_velocity(&constraints->rigids[constraint->rigid], constraint->arm, unit, push);
        return plii_dvec3_dot(unit, plii_implicit_point_change(push, constraint->arm));
    }
    for (int k = 0; k < constraint->node_count; ++k) {
        const int node = constraint->nodes[k];
        const double load = fmax(constraints->loads[node], constraint->weights[k]);
        const plii_dvec3 moved = plii_implicit_block_solve(&constraints->blocks[node], unit);
        response += constraint->weights[k] * load * plii_dvec3_dot(unit, moved);
    }
    return response;
}

void plii_implicit_share_nodes(plii_implicit_constraints* constraints) {
    const int first = constraints->node_bound_count;
    double* loads = constraints->loads;
    if (constraints->count == first) { return; }
    plii_implicit_constraint* const points = constraints->items + first; /* of faces */
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        for (int k = 0; k < constraint->node_count; ++k) {
            loads[constraint->nodes[k]] = 0.0;
        }
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, points, constraints->count - first)) {
        for (int k = 0; k < constraint->node_count && constraint->rows > 0; ++k) {
            loads[constraint->nodes[k]] += constraint->weights[k];
        }
    }
    for (PLII_EACH(plii_implicit_constraint, constraint, constraints->items, first)) {
        constraint->share = 1.0 / (1.0 + loads[constraint->nodes[0]]);
    }
    for (int i = 0; i < first; ++i) {
        loads[constraints->items[i].nodes[0]] += constraints->items[i].rows > 0 ? 1.0 : 0.0;
    }
    for (PLII_EACH(plii_implicit_constraint, constraint, points, constraints->count - first)) {
        const plii_dvec3 n = constraint->normal;
        const double along = plii_implicit_point_response(constraints, constraint, n);
        const plii_dvec3 a = plii_dvec3_perpendicular(n), c = plii_dvec3_cross(n, a);
        const double across = plii_implicit_point_response(constraints, constraint, a) +
                              plii_implicit_point_response(constraints, constraint, c);
        constraint->stiffness = 1.0 / along;
        constraint->stiffness_across = 2.0 / fmax(across, IMPLICIT_LEAST_RESPONSE * along);
    }
}
