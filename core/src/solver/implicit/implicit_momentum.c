/* Springs change neither the momentum nor the angular momentum of what hangs together. Unfinished sweeps change both,
   and springs that turn within a step the second, which is taken back here. */

#include "base/union_find.h"
#include "body/rigid_impl.h"
#include "solver/implicit/implicit_system.h"

/* A contact with what nothing moves that sweeps have left to slide. */
static bool momentum_slides(const plii_implicit_constraints* constraints, const plii_implicit_constraint* constraint) {
    return constraint->rows == 1 && !constraint->is_viscous && !constraints->rigids[constraint->rigid].is_dynamic;
}

static plii_implicit_group* momentum_group_of(const plii_implicit_system* system, int node) {
    return &system->groups.items[system->groups.of_nodes[node]];
}

/* What hangs together by links and by rigid bodies that can move, which get their group. False without memory. */
static bool momentum_find_groups(plii_implicit_system* system) {
    plii_implicit_constraints* constraints = &system->constraints;
    int *groups = system->groups.of_nodes, count = 0;
    const int node_count = system->body->node_count;
    memcpy(groups, system->graph->components, (size_t)node_count * sizeof *groups);
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        rigid->group = PLI_NULL_INDEX;
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
        if (!rigid->is_dynamic || constraint->rows == 0) { continue; }
        if (rigid->group == PLI_NULL_INDEX) { rigid->group = constraint->nodes[0]; }
        plii_union_join(groups, rigid->group, constraint->nodes[0]);
    }
    plii_union_flatten(node_count, groups);
    for (int i = 0; i < node_count; ++i) { /* a root is the smallest of its group */
        groups[i] = groups[i] == i ? count++ : groups[groups[i]];
    }
    if (!PLII_RESERVE(system->body->context, &system->groups.items, &system->groups.capacity, count)) { return false; }
    memset(system->groups.items, 0, (size_t)count * sizeof *system->groups.items);
    system->groups.count = count;
    system->groups.has_free = false;
    return true;
}

/* From the first node. */
static plii_dvec3 momentum_arm(const pli_vec4* start, pli_vec3 at) {
    return plii_dvec3_sub(plii_dvec3_from(at), plii_implicit_xyz(start));
}

/* What cannot move is infinitely heavy. */
static void momentum_hold(plii_implicit_group* group) {
    group->sum.mass[0][0] = group->sum.mass[1][1] = group->sum.mass[2][2] = (double)INFINITY;
    group->is_held = true;
}
static bool momentum_is_still(const plii_implicit_group* group) {
    return !isfinite(group->sum.mass[0][0]);
}

static void momentum_add_rigid(plii_implicit_group* group, const plii_implicit_rigid* rigid, plii_dvec3 x) {
    const double *m = rigid->mass, *q = rigid->change;
    const bool is_held = m[0] != m[1] || m[0] != m[2]; /* by factors, along some axis */
    for (int k = 0; k < 3 && is_held; ++k) {
        group->sum.mass[k][k] += m[k];
        group->sum.momentum[k] += m[k] * q[k];
    }
    group->is_held = group->is_held || is_held;
    if (is_held) { return; }
    plii_mass_sum_add(&group->sum, m[0], x, plii_dvec3_make(q[0], q[1], q[2]));
    for (int k = 0; k < 9; ++k) {
        group->sum.mass[3 + k / 3][3 + k % 3] += rigid->own_inertia[k / 3][k % 3];
        group->sum.momentum[3 + k / 3] += rigid->own_inertia[k / 3][k % 3] * q[3 + k % 3];
    }
}

/* What holds nodes from outside moves a group, by what it gives to the nodes as they then are. */
static void momentum_sum(plii_implicit_system* system, const pli_vec4* start, bool with_spin) {
    const pli_body* body = system->body;
    const plii_implicit_constraints* constraints = &system->constraints;
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        if (constraints->rigids[constraint->rigid].is_dynamic || constraint->rows == 0) { continue; }
        plii_implicit_group* group = momentum_group_of(system, constraint->nodes[0]);
        if (momentum_slides(constraints, constraint)) {
            plii_implicit_add_push(group->sum.momentum, (plii_dvec3){0}, constraint->impulse, -1.0);
            group->is_held = true;
            ++group->sliding_count;
        } else {
            momentum_hold(group);
        }
    }
    for (PLII_EACH(const plii_implicit_hold, hold, system->holds.items, system->holds.count)) {
        plii_implicit_group* group = momentum_group_of(system, hold->node);
        const plii_dvec3 push = plii_implicit_hold_mul(hold, system->solution[hold->node]);
        plii_mass_sum_add(&group->sum, hold->hardness, (plii_dvec3){0}, (plii_dvec3){0});
        plii_implicit_add_push(group->sum.momentum, (plii_dvec3){0}, plii_dvec3_sub(push, hold->rhs), 1.0);
        group->is_held = true;
    }
    for (int i = 0; i < body->node_count; ++i) {
        plii_implicit_group* group = momentum_group_of(system, i);
        if (!(body->positions[i].w > 0.0f)) { momentum_hold(group); }
        if (momentum_is_still(group)) { continue; }
        const bool turns = with_spin && !group->is_held;
        const plii_dvec3 arm = turns ? momentum_arm(start, plii_xyz(start[i])) : (plii_dvec3){0};
        plii_mass_sum_add(&group->sum, 1.0 / (double)body->positions[i].w, arm, system->solution[i]);
    }
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        if (rigid->group == PLI_NULL_INDEX) { continue; }
        rigid->group = system->groups.of_nodes[rigid->group];
        momentum_add_rigid(&system->groups.items[rigid->group], rigid,
                           momentum_arm(start, rigid->rigid->path.begin.origin));
    }
}

/* What is held turns as solved. */
static void momentum_find_motion(plii_implicit_group* group, bool with_spin) {
    double *p = group->sum.momentum, linear[6] = {0};
    for (int k = 0; k < 3; ++k) {
        linear[k] = p[k] / group->sum.mass[k][k];
    }
    const bool turns = with_spin && !group->is_held && plii_mass_sum_solve(&group->sum);
    if (!turns) { memcpy(p, linear, sizeof linear); }
}

/* Along surfaces that nothing moves a group gets what friction has given to its nodes, of which unfinished sweeps pass
   on little, but no more than stops it; across them it goes as solved. */
static void momentum_slide_groups(const plii_implicit_system* system) {
    const plii_implicit_constraints* constraints = &system->constraints;
    for (int pass = 0; pass < 2; ++pass) {
        for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
            if (!momentum_slides(constraints, constraint)) { continue; }
            plii_implicit_group* group = momentum_group_of(system, constraint->nodes[0]);
            double* motion = group->sum.momentum;
            const plii_dvec3 n = constraint->normal, linear = {motion[0], motion[1], motion[2]};
            if (pass == 0) {
                plii_implicit_add_push(motion, (plii_dvec3){0}, n, -plii_dvec3_dot(n, linear));
                continue;
            }
            const plii_dvec3 sliding = plii_dvec3_sub(plii_implicit_constraint_point(constraint, system->solution),
                                                      plii_implicit_constraint_goal(constraints, constraint));
            group->against += plii_dvec3_dot(linear, plii_dvec3_across(sliding, n));
        }
    }
    for (PLII_EACH(plii_implicit_group, group, system->groups.items, system->groups.count)) {
        double* motion = group->sum.momentum;
        const double square = motion[0] * motion[0] + motion[1] * motion[1] + motion[2] * motion[2];
        for (int k = 0; k < 3 && group->sliding_count > 0 && square > 0.0; ++k) {
            motion[k] *= fmin(fmax(group->against / (square * group->sliding_count), 0.0), 1.0);
        }
    }
}

/* The part of such a motion that a rigid body on the group has: all where it sticks; where it slides what its contacts
   push, or friction that is not its own would drive it. */
static plii_dvec3 momentum_carried(const plii_implicit_constraints* constraints, const plii_implicit_rigid* rigid,
                                   plii_dvec3 motion) {
    plii_dvec3 left = motion;
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        if (&constraints->rigids[constraint->rigid] != rigid || constraint->rows == 0) { continue; }
        if (constraint->rows == 3) { return motion; }
        left = plii_dvec3_across(left, constraint->normal);
    }
    return plii_dvec3_sub(motion, left);
}

void plii_implicit_keep_momentum(plii_implicit_system* system, const pli_vec4* start, bool with_spin) {
    plii_implicit_constraints* constraints = &system->constraints;
    if (!momentum_find_groups(system)) { return; }
    momentum_sum(system, start, with_spin);
    for (PLII_EACH(plii_implicit_group, group, system->groups.items, system->groups.count)) {
        momentum_find_motion(group, with_spin);
        system->groups.has_free = system->groups.has_free || !group->is_held;
    }
    momentum_slide_groups(system);
    for (int i = 0; i < system->body->node_count; ++i) {
        const plii_implicit_group* group = momentum_group_of(system, i);
        if (momentum_is_still(group)) { continue; }
        const plii_dvec3 more =
            plii_implicit_point_change(group->sum.momentum, momentum_arm(start, plii_xyz(start[i])));
        system->solution[i] = plii_dvec3_sub(system->solution[i], more);
    }
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        if (rigid->group == PLI_NULL_INDEX) { continue; }
        const plii_implicit_group* group = &system->groups.items[rigid->group];
        const plii_dvec3 arm = momentum_arm(start, rigid->rigid->path.begin.origin);
        plii_dvec3 more = plii_implicit_point_change(group->sum.momentum, arm);
        if (group->sliding_count > 0) { more = momentum_carried(constraints, rigid, more); }
        const double* spin = &group->sum.momentum[3];
        plii_implicit_add_twist(rigid->change, more, plii_dvec3_make(spin[0], spin[1], spin[2]), -1.0);
    }
}
