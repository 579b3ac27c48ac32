/* Anchors and contacts for the implicit system: what they ask of the velocities at the end of the step, and the rigid
   bodies behind them. Baraff and Witkin, "Large Steps in Cloth Simulation", section 5, prescribe velocities likewise;
   here the rigid body's are unknown too. */

#include "solver/implicit/implicit_constraints.h"

#include "body/rigid_impl.h"

#include <string.h>

/* Pinned nodes count as so many times heavier than the rigid body that they are anchored to. */
#define IMPLICIT_PINNED_RATIO 1e6
#define IMPLICIT_IMMOVABLE 1e30

// ------------------------------------------------------------------------------------------------- rigid bodies

static int implicit_constraints_find_rigid(const plii_implicit_constraints* constraints, const pli_rigid* rigid) {
    for (int i = constraints->rigid_count - 1; i >= 0; --i) {
        if (constraints->rigids[i].rigid == rigid) { return i; }
    }
    return PLI_NULL_INDEX;
}

bool plii_implicit_constraints_find_contacts(pli_body* body, plii_implicit_constraints* constraints, pli_rigid* rigid) {
    if (implicit_constraints_find_rigid(constraints, rigid) != PLI_NULL_INDEX) { return true; }
    if (!PLII_RESERVE(body->context, &constraints->rigids, &constraints->rigid_capacity,
                      constraints->rigid_count + 1)) {
        return false;
    }
    plii_implicit_rigid* touched = &constraints->rigids[constraints->rigid_count++];
    *touched = (plii_implicit_rigid){.rigid = rigid, .pose = rigid->state.pose, .pose_version = rigid->pose_version};
    return true;
}

void plii_implicit_constraints_clear(plii_implicit_constraints* constraints, const pli_rigid* rigid) {
    const int index = implicit_constraints_find_rigid(constraints, rigid);
    if (index == PLI_NULL_INDEX) { return; }
    for (int i = index; i + 1 < constraints->rigid_count; ++i) {
        constraints->rigids[i] = constraints->rigids[i + 1];
    }
    constraints->rigid_count -= 1;
    constraints->count = 0;
}

/* Inverse of a symmetric 3x3 matrix that may have zero rows where axes are locked. */
static void implicit_invert_inertia(double a[3][3], double inertia[6]) {
    const double trace = a[0][0] + a[1][1] + a[2][2], least = trace > 0.0 ? 1e-12 * trace : 1.0 / IMPLICIT_IMMOVABLE;
    const double xx = a[0][0] + least, yy = a[1][1] + least, zz = a[2][2] + least;
    const double xy = 0.5 * (a[0][1] + a[1][0]), xz = 0.5 * (a[0][2] + a[2][0]), yz = 0.5 * (a[1][2] + a[2][1]);
    const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
    const double inverse = 1.0 / (xx * cxx + xy * cxy + xz * cxz);
    inertia[0] = cxx * inverse;
    inertia[1] = cxy * inverse;
    inertia[2] = cxz * inverse;
    inertia[3] = (xx * zz - xz * xz) * inverse;
    inertia[4] = (xy * xz - xx * yz) * inverse;
    inertia[5] = (xx * yy - xy * xy) * inverse;
}

static double implicit_axis_mass(float inverse_mass, float factor) {
    const double inverse = (double)inverse_mass * (double)factor;
    return inverse > 0.0 ? 1.0 / inverse : IMPLICIT_IMMOVABLE;
}

static void implicit_constraints_prepare_rigid(plii_implicit_rigid* touched) {
    const pli_rigid* rigid = touched->rigid;
    touched->moves_by_host = rigid->pose_version != touched->pose_version;
    touched->is_dynamic = rigid->state.inverse_mass > 0.0f;
    memset(touched->change, 0, sizeof touched->change);
    if (!touched->is_dynamic) { return; }
    touched->mass[0] = implicit_axis_mass(rigid->state.inverse_mass, rigid->linear_factor.x);
    touched->mass[1] = implicit_axis_mass(rigid->state.inverse_mass, rigid->linear_factor.y);
    touched->mass[2] = implicit_axis_mass(rigid->state.inverse_mass, rigid->linear_factor.z);
    const double factor[3] = {sqrt(fabs((double)rigid->angular_factor.x)), sqrt(fabs((double)rigid->angular_factor.y)),
                              sqrt(fabs((double)rigid->angular_factor.z))};
    double inverse_inertia[3][3];
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 row = rigid->state.inverse_inertia_world.rows[i];
        inverse_inertia[i][0] = (double)row.x * factor[i] * factor[0];
        inverse_inertia[i][1] = (double)row.y * factor[i] * factor[1];
        inverse_inertia[i][2] = (double)row.z * factor[i] * factor[2];
    }
    implicit_invert_inertia(inverse_inertia, touched->inertia);
}

void plii_implicit_constraints_push_rigids(plii_implicit_constraints* constraints) {
    for (int i = 0; i < constraints->rigid_count; ++i) {
        const plii_implicit_rigid* touched = &constraints->rigids[i];
        const double* q = touched->change;
        const pli_vec3 linear = pli_vec3_make((float)q[0], (float)q[1], (float)q[2]);
        const pli_vec3 angular = pli_vec3_make((float)q[3], (float)q[4], (float)q[5]);
        if (!touched->is_dynamic || !plii_vec3_is_finite(linear) || !plii_vec3_is_finite(angular)) { continue; }
        pli_rigid_state* state = &touched->rigid->state;
        state->linear_velocity = pli_vec3_add(state->linear_velocity, linear);
        state->angular_velocity = pli_vec3_add(state->angular_velocity, angular);
        if (touched->moves_by_host) { touched->rigid->needs_reintegration = true; }
    }
}

void plii_implicit_constraint_reproject(pli_body* body, plii_implicit_constraints* constraints,
                                        plii_implicit_constraint* constraint) {
    plii_implicit_rigid* touched = &constraints->rigids[constraint->rigid];
    pli_rigid* rigid = touched->rigid;
    const double h = (double)body->step.dt;
    const plii_dvec3 x = plii_dvec3_from(plii_xyz(body->positions[constraint->node]));
    plii_dvec3 off = plii_dvec3_sub(constraint->goal_position, x);
    if (touched->is_dynamic) {
        off = plii_dvec3_add_scaled(off, plii_implicit_point_change(touched->change, constraint->arm), h);
    }
    double distance = plii_dvec3_length(off);
    plii_dvec3 direction = plii_dvec3_scale(off, distance > 0.0 ? 1.0 / distance : 0.0);
    if (!constraint->is_anchor) {
        direction = constraint->normal;
        distance = plii_dvec3_dot(off, direction);
    }
    if (!(distance > 0.0) || !plii_is_finite((float)distance)) { return; }
    const pli_vec3 unit = plii_dvec3_to_float(direction), arm = plii_dvec3_to_float(constraint->arm);
    const double node_weight = (double)body->positions[constraint->node].w;
    double rigid_weight = 0.0;
    if (touched->is_dynamic) {
        const pli_vec3 moment = pli_vec3_cross(arm, unit);
        const pli_vec3 spin = pli_mat3_mul_vec3(rigid->state.inverse_inertia_world, moment);
        rigid_weight = (double)rigid->state.inverse_mass + (double)pli_vec3_dot(moment, spin);
    }
    const double push = constraint->influence * distance / (node_weight + rigid_weight); /* kg m */
    plii_set_xyz(&body->positions[constraint->node],
                 plii_dvec3_to_float(plii_dvec3_add_scaled(x, direction, push * node_weight)));
    if (!touched->is_dynamic) { return; }
    const pli_vec3 linear = rigid->state.linear_velocity, angular = rigid->state.angular_velocity;
    plii_rigid_apply_impulse(rigid, pli_vec3_scale(unit, (float)(-push / h)), arm);
    const pli_vec3 changes[2] = {pli_vec3_sub(rigid->state.linear_velocity, linear),
                                 pli_vec3_sub(rigid->state.angular_velocity, angular)};
    for (int i = 0; i < 2; ++i) {
        touched->change[3 * i] += (double)changes[i].x;
        touched->change[3 * i + 1] += (double)changes[i].y;
        touched->change[3 * i + 2] += (double)changes[i].z;
    }
}

// --------------------------------------------------------------------------------------------------- conditions

/* Merges neighbouring sorted runs until there is one; constraints of a node keep their order. `to` is as long as
 * `from`. */
static void implicit_constraints_sort(plii_node_constraint* from, plii_node_constraint* to, int count) {
    for (int width = 1; width < count; width *= 2) {
        for (int begin = 0; begin < count; begin += 2 * width) {
            const int middle = begin + width < count ? begin + width : count;
            const int end = middle + width < count ? middle + width : count;
            int a = begin, b = middle;
            for (int i = begin; i < end; ++i) {
                to[i] = b >= end || (a < middle && from[a].node <= from[b].node) ? from[a++] : from[b++];
            }
        }
        for (int i = 0; i < count; ++i) {
            from[i] = to[i];
        }
    }
}

static bool implicit_constraints_are_sorted(const plii_node_constraint* constraints, int count) {
    for (int i = 1; i < count; ++i) {
        if (constraints[i].node < constraints[i - 1].node) { return false; }
    }
    return true;
}

/* Lists the constraints of all features, twice if they are more than there is room for. */
static int implicit_constraints_list(pli_body* body, plii_implicit_constraints* constraints, bool with_contacts) {
    int count = 0, wanted = 0;
    for (int attempt = 0; attempt < 2; ++attempt) {
        count = wanted = 0;
        const int room = constraints->listed_capacity / 2; /* the other half is for sorting */
        for (int i = 0; i < body->pipeline.feature_count; ++i) {
            const plii_feature* feature = &body->pipeline.features[i];
            if (feature->klass->list_constraints == NULL) { continue; }
            plii_node_constraint* free = constraints->listed != NULL ? constraints->listed + count : NULL;
            const int found = feature->klass->list_constraints(body, feature->state, room - count, free);
            wanted += found;
            count = count + found < room ? count + found : room;
        }
        if (wanted <= room ||
            !PLII_RESERVE(body->context, &constraints->listed, &constraints->listed_capacity, 2 * wanted)) {
            break;
        }
    }
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        if (with_contacts || constraints->listed[i].is_anchor) { constraints->listed[kept++] = constraints->listed[i]; }
    }
    if (!implicit_constraints_are_sorted(constraints->listed, kept)) {
        implicit_constraints_sort(constraints->listed, constraints->listed + kept, kept);
    }
    return PLII_RESERVE(body->context, &constraints->items, &constraints->capacity, kept) ? kept
                                                                                          : constraints->capacity;
}

static plii_implicit_block implicit_pinned_block(const pli_rigid* rigid) {
    const double inverse = (double)rigid->state.inverse_mass / IMPLICIT_PINNED_RATIO;
    return (plii_implicit_block){.inverse_d = {inverse, inverse, inverse}};
}

/* Velocity with which a point that moves with the rigid body leaves where it was at the start of the step, as far as it
   is known yet. */
static plii_dvec3 implicit_point_velocity(const plii_implicit_rigid* touched, pli_vec3 local, float dt) {
    const pli_rigid_state* state = &touched->rigid->state;
    pli_vec3 linear = state->linear_velocity, angular = state->angular_velocity;
    if (touched->moves_by_host) {
        linear = pli_vec3_sub(linear, touched->rigid->given_linear_velocity);
        angular = pli_vec3_sub(angular, touched->rigid->given_angular_velocity);
    }
    const pli_transform end = plii_rigid_advance(state->pose, linear, angular, dt);
    const plii_dvec3 turned = plii_dvec3_sub(plii_dvec3_from(pli_mat3_mul_vec3(end.rotation, local)),
                                             plii_dvec3_from(pli_mat3_mul_vec3(touched->pose.rotation, local)));
    plii_dvec3 moved = plii_dvec3_sub(plii_dvec3_from(state->pose.origin), plii_dvec3_from(touched->pose.origin));
    moved = plii_dvec3_add_scaled(moved, plii_dvec3_from(linear), (double)dt);
    return plii_dvec3_scale(plii_dvec3_add(moved, turned), 1.0 / (double)dt);
}

static void implicit_constraints_make_item(const pli_body* body, const plii_implicit_rigid* touched,
                                           const plii_node_constraint* from, plii_dvec3 start,
                                           plii_implicit_constraint* item) {
    const double inverse_dt = (double)body->step.inverse_dt, hardness = (double)from->hardness;
    pli_vec3 local = from->pivot;
    item->is_anchor = from->is_anchor;
    item->influence = (double)from->influence;
    if (from->is_anchor) {
        const plii_dvec3 pivot = plii_dvec3_from(pli_transform_point(touched->pose, local));
        item->recovery = plii_dvec3_scale(plii_dvec3_sub(pivot, start), hardness * inverse_dt);
        item->target = item->recovery;
    } else {
        local = pli_transform_inverse_point(touched->pose, plii_xyz(body->positions[from->node]));
        item->normal = plii_dvec3_from(from->normal);
        item->friction = (double)from->friction;
        const double gap = plii_dvec3_dot(item->normal, start) + (double)from->offset;
        const double speed =
            gap > 0.0 ? -gap * inverse_dt : fmin(-gap * hardness * inverse_dt, (double)from->recovery_speed);
        item->target = plii_dvec3_scale(item->normal, speed);
        if (speed > 0.0) { item->recovery = item->target; }
    }
    item->target = plii_dvec3_add(item->target, implicit_point_velocity(touched, local, body->step.dt));
    item->goal_position = plii_dvec3_add_scaled(start, item->target, (double)body->step.dt);
    item->arm = plii_dvec3_from(pli_mat3_mul_vec3(touched->rigid->state.pose.rotation, local));
}

void plii_implicit_constraints_gather(pli_body* body, plii_implicit_constraints* constraints, bool with_contacts,
                                      const plii_implicit_block* blocks, const plii_dvec3* base) {
    const int listed = implicit_constraints_list(body, constraints, with_contacts);
    constraints->count = 0;
    for (int i = 0; i < constraints->rigid_count; ++i) {
        implicit_constraints_prepare_rigid(&constraints->rigids[i]);
    }
    for (int i = 0; i < listed; ++i) {
        const plii_node_constraint* from = &constraints->listed[i];
        int rigid = implicit_constraints_find_rigid(constraints, from->rigid);
        if (rigid == PLI_NULL_INDEX) {
            if (!plii_implicit_constraints_find_contacts(body, constraints, from->rigid)) { continue; }
            rigid = constraints->rigid_count - 1;
            implicit_constraints_prepare_rigid(&constraints->rigids[rigid]);
        }
        const plii_implicit_rigid* touched = &constraints->rigids[rigid];
        const bool is_pinned = !(body->positions[from->node].w > 0.0f);
        if ((is_pinned && !touched->is_dynamic) || !(from->influence > 0.0f)) { continue; }
        plii_implicit_constraint* item = &constraints->items[constraints->count++];
        *item = (plii_implicit_constraint){.node = from->node, .rigid = rigid, .is_pinned = is_pinned};
        const pli_vec4 start = base != NULL ? body->previous[from->node] : body->positions[from->node];
        implicit_constraints_make_item(body, touched, from, plii_dvec3_from(plii_xyz(start)), item);
        plii_dvec3 velocity = plii_dvec3_from(plii_xyz(body->velocities[from->node]));
        if (base != NULL) { velocity = plii_dvec3_sub(velocity, base[from->node]); }
        item->target = plii_dvec3_sub(item->target, velocity);
        item->block = is_pinned ? implicit_pinned_block(touched->rigid) : blocks[from->node];
        plii_rigid_touch(touched->rigid);
    }
}

bool plii_implicit_constraints_have_contacts(const plii_implicit_constraints* constraints) {
    for (int i = 0; i < constraints->count; ++i) {
        if (!constraints->items[i].is_anchor) { return true; }
    }
    return false;
}
