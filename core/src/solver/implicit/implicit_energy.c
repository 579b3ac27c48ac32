/* The energy of a step. Backward Euler minimises m (v - v*)^2 / 2 + U(x0 + h v), v* being the velocities of free
   flight. Where U is convex, impulses of springs and holds do no more work than the springs give. */

#include "body/rigid_impl.h"
#include "solver/implicit/implicit_system.h"

/* Of the energy of motions against each other, what rounding makes of it in a step. */
#define IMPLICIT_ROUNDING 1e-3
/* Of the way to a new solution: what is shorter is taken as it is. */
#define IMPLICIT_LEAST_SHARE 0.05

static double energy_of_link(const pli_body* body, int link, plii_dvec3 a, plii_dvec3 b) {
    const double rest = sqrt((double)body->links[link].rest_length_squared);
    const double stretch = plii_dvec3_length(plii_dvec3_sub(b, a)) - rest;
    return 0.5 * stretch * stretch * (double)plii_link_stiffness(body, link);
}

/* m/s, of the first that leads the body: energies are those that somebody sees who moves along with it. */
static plii_dvec3 energy_frame(const plii_implicit_system* system) {
    const pli_body* body = system->body;
    const plii_implicit_constraints* constraints = &system->constraints;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { return plii_implicit_xyz(&body->velocities[i]); }
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        const bool is_led = !constraints->rigids[constraint->rigid].is_dynamic && constraint->rows > 0;
        if (is_led) { return constraint->surface_velocity; }
    }
    return (plii_dvec3){0};
}

/* The work of impulses on a rigid body, and twice the energy of its change of velocity. */
static void energy_add_rigid(const plii_implicit_rigid* rigid, float pace, plii_dvec3 frame, double* work,
                             double* scale) {
    double p[6];
    const double* q = rigid->change;
    plii_implicit_rigid_mul(rigid, q, 1.0, p);
    const plii_twist before = plii_twist_scale(plii_rigid_velocity(rigid->rigid), pace);
    const plii_dvec3 linear = plii_dvec3_sub(plii_dvec3_from(before.linear), frame),
                     angular = plii_dvec3_from(before.angular);
    const double v[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    for (int k = 0; k < 6; ++k) {
        if (q[k] == 0.0) { continue; } /* an axis that cannot move has no end of mass */
        *work += p[k] * (v[k] + q[k]);
        *scale += p[k] * q[k];
    }
}

/* What surfaces that move and penetrations that are taken back give to nodes. */
static double energy_given(const plii_implicit_constraints* constraints, plii_dvec3 frame) {
    double sum = 0.0;
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        const bool is_led = !constraints->rigids[constraint->rigid].is_dynamic && !constraint->is_pinned;
        const plii_dvec3 led = is_led ? plii_dvec3_sub(constraint->surface_velocity, frame) : (plii_dvec3){0};
        const plii_dvec3 given = plii_dvec3_add(led, constraint->recovery);
        if (constraint->rows > 0) { sum += fmax(plii_dvec3_dot(constraint->impulse, given), 0.0); }
    }
    return sum;
}

/* What springs to fixed points give to nodes. */
static double energy_of_holds(const plii_implicit_system* system, plii_dvec3 frame) {
    double sum = 0.0;
    for (PLII_EACH(const plii_implicit_hold, hold, system->holds.items, system->holds.count)) {
        const plii_dvec3 taken = plii_implicit_hold_mul(hold, system->solution[hold->node]);
        const plii_dvec3 v = plii_dvec3_sub(plii_implicit_xyz(&system->body->velocities[hold->node]), frame);
        sum += plii_dvec3_dot(plii_dvec3_sub(hold->rhs, taken), v);
    }
    return sum;
}

/* Linearised springs brake a free body that turns far in a step, which friction hides. So what the torque of what is
   not from contacts takes from its rotation counts as an error too. */
double plii_implicit_excess(const plii_implicit_system* system) {
    const pli_body* body = system->body;
    double springs = 0.0, work = 0.0, scale = 0.0, kinetic = 0.0, mass = 0.0, inertia = 0.0;
    plii_dvec3 momentum = {0}, centre = {0}, spin = {0}, torque = {0}; /* about the first node */
    const plii_dvec3 first = plii_implicit_xyz(body->positions), frame = energy_frame(system);
    for (int i = 0; i < body->link_count; ++i) {
        const int a = body->links[i].nodes[0], b = body->links[i].nodes[1];
        springs +=
            energy_of_link(body, i, plii_implicit_xyz(&body->positions[a]), plii_implicit_xyz(&body->positions[b])) -
            energy_of_link(body, i, plii_implicit_xyz(&body->previous[a]), plii_implicit_xyz(&body->previous[b]));
    }
    springs *= (double)system->def.stiffness;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { mass = (double)INFINITY; } /* no velocity in common */
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const plii_dvec3 v = plii_dvec3_sub(plii_implicit_xyz(&body->velocities[i]), frame), s = system->solution[i];
        const double m = 1.0 / (double)body->positions[i].w;
        work += m * plii_dvec3_dot(s, v);
        scale += m * plii_dvec3_dot(s, s);
        kinetic += m * plii_dvec3_dot(v, v);
        const plii_dvec3 x = plii_dvec3_sub(plii_implicit_xyz(&body->positions[i]), first);
        momentum = plii_dvec3_add_scaled(momentum, v, m);
        centre = plii_dvec3_add_scaled(centre, x, m);
        spin = plii_dvec3_add_scaled(spin, plii_dvec3_cross(x, v), m);
        torque = plii_dvec3_add_scaled(torque, plii_dvec3_cross(x, s), m);
        inertia += m * plii_dvec3_dot(x, x);
        mass += m;
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, system->constraints.items, system->constraints.count)) {
        for (int k = 0; k < constraint->node_count && constraint->rows > 0; ++k) {
            const plii_dvec3 x = plii_dvec3_sub(plii_implicit_xyz(&body->positions[constraint->nodes[k]]), first);
            torque = plii_dvec3_add_scaled(torque, plii_dvec3_cross(x, constraint->impulse), -constraint->weights[k]);
        }
    }
    for (PLII_EACH(const plii_implicit_rigid, rigid, system->constraints.rigids, system->constraints.rigid_count)) {
        if (rigid->is_dynamic) { energy_add_rigid(rigid, body->rigid_pace, frame, &work, &scale); }
    }
    work -= energy_given(&system->constraints, frame) + energy_of_holds(system, frame);
    spin = plii_dvec3_add_scaled(spin, plii_dvec3_cross(centre, momentum), -1.0 / mass);
    inertia -= plii_dvec3_dot(centre, centre) / mass;
    const bool is_free = isfinite(mass) && system->holds.count == 0 && inertia > 0.0;
    const double taken = is_free ? -plii_dvec3_dot(torque, spin) / inertia : 0.0;
    return fmax(springs + work, taken) /
           (scale + IMPLICIT_ROUNDING * (kinetic - plii_dvec3_dot(momentum, momentum) / mass));
}

/* m s^2 / 2 + U, less what constraints give, of the solution `share` of the way from that before, where the body is. */
static double energy_potential(const plii_implicit_system* system, double share) {
    const pli_body* body = system->body;
    const plii_dvec3* before = system->before;
    const plii_implicit_constraints* constraints = &system->constraints;
    const double way = share * (double)body->step.dt;
    double springs = 0.0, sum = 0.0;
    for (int i = 0; i < body->link_count; ++i) {
        plii_dvec3 ends[2];
        for (int k = 0; k < 2; ++k) {
            const int node = body->links[i].nodes[k];
            ends[k] = plii_dvec3_add_scaled(plii_implicit_xyz(&body->positions[node]),
                                            plii_dvec3_sub(system->solution[node], before[node]), way);
        }
        springs += energy_of_link(body, i, ends[0], ends[1]);
    }
    sum += springs * (double)system->def.stiffness;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const plii_dvec3 s = plii_dvec3_add_scaled(before[i], plii_dvec3_sub(system->solution[i], before[i]), share);
        sum += 0.5 * plii_dvec3_dot(s, s) / (double)body->positions[i].w;
    }
    for (PLII_EACH(const plii_implicit_hold, hold, system->holds.items, system->holds.count)) {
        const plii_dvec3 s = plii_dvec3_add_scaled(
            before[hold->node], plii_dvec3_sub(system->solution[hold->node], before[hold->node]), share);
        sum += 0.5 * plii_dvec3_dot(s, plii_implicit_hold_mul(hold, s)) - plii_dvec3_dot(hold->rhs, s);
    }
    for (PLII_EACH(const plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        double q[6], p[6];
        if (!rigid->is_dynamic) { continue; }
        for (int k = 0; k < 6; ++k) {
            q[k] = rigid->before[k] + share * (rigid->change[k] - rigid->before[k]);
        }
        plii_implicit_rigid_mul(rigid, q, 1.0, p);
        for (int k = 0; k < 6; ++k) {
            sum += q[k] != 0.0 ? 0.5 * q[k] * p[k] : 0.0;
        }
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        const plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
        if (constraint->rows == 0) { continue; }
        plii_dvec3 point = plii_dvec3_scale(plii_implicit_constraint_point(constraint, before), 1.0 - share);
        point = plii_dvec3_add_scaled(point, plii_implicit_constraint_point(constraint, system->solution), share);
        if (rigid->is_dynamic) {
            point =
                plii_dvec3_add_scaled(point, plii_implicit_point_change(rigid->before, constraint->arm), share - 1.0);
            point = plii_dvec3_add_scaled(point, plii_implicit_point_change(rigid->change, constraint->arm), -share);
        }
        sum -= plii_dvec3_dot(constraint->impulse, plii_dvec3_sub(point, constraint->target));
    }
    return sum;
}

double plii_implicit_search(plii_implicit_system* system) {
    const plii_dvec3* before = system->before;
    double share = 1.0;
    const double start = energy_potential(system, 0.0);
    while (share > IMPLICIT_LEAST_SHARE && energy_potential(system, share) > start) {
        share *= 0.5;
    }
    if (share == 1.0) { return share; }
    for (int i = 0; i < system->body->node_count; ++i) {
        system->solution[i] = plii_dvec3_add_scaled(before[i], plii_dvec3_sub(system->solution[i], before[i]), share);
    }
    for (PLII_EACH(plii_implicit_rigid, rigid, system->constraints.rigids, system->constraints.rigid_count)) {
        for (int k = 0; k < 6; ++k) {
            rigid->change[k] = rigid->before[k] + share * (rigid->change[k] - rigid->before[k]);
        }
    }
    return share;
}
