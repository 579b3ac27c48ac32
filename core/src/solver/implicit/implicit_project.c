/* Conditions of anchors and contacts on a solution of the implicit system, met in the norm of the diagonal blocks: each
   node, taken alone, is solved exactly with its non-penetration and Coulomb friction, then each rigid body with the
   nodes that it holds. The projection does not lengthen errors in that norm and a Jacobi sweep shortens them, hence
   sweeps with projections converge wherever sweeps do. */

#include "solver/implicit/implicit_constraints.h"

enum {
    IMPLICIT_SHARED_PASSES = 8,
    IMPLICIT_SLIDE_PASSES = 3,
    IMPLICIT_DISC_PASSES = 20,
    IMPLICIT_POINT_PASSES = 2,
    IMPLICIT_HOLD_PASSES = 20
};

plii_dvec3 plii_implicit_constraint_goal(const plii_implicit_constraints* constraints,
                                         const plii_implicit_constraint* constraint) {
    const plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
    if (!rigid->is_dynamic) { return constraint->target; }
    return plii_dvec3_add(constraint->target, plii_implicit_point_change(rigid->change, constraint->arm));
}

/* The least of p S p / 2 + c p over |p| <= limit, S symmetric and positive definite, where the free minimum lies
   outside: (S + more) p = -c with the `more` that gives p its length. S = {xx, xy, yy}. Newton for 1 / |p| = 1 / limit,
   which from below never goes too far; the start is the answer for an S that acts on c as on any vector. */
static void project_to_disc(const double s[3], const double c[2], double limit, double p[2]) {
    const double square_c = c[0] * c[0] + c[1] * c[1];
    const double along = (s[0] * c[0] * c[0] + 2.0 * s[1] * c[0] * c[1] + s[2] * c[1] * c[1]) / square_c;
    double more = fmax(sqrt(square_c) / limit - along, 0.0);
    for (int pass = 0; pass < IMPLICIT_DISC_PASSES; ++pass) {
        const double xx = s[0] + more, yy = s[2] + more, inverse = 1.0 / (xx * yy - s[1] * s[1]);
        p[0] = (s[1] * c[1] - yy * c[0]) * inverse;
        p[1] = (s[1] * c[0] - xx * c[1]) * inverse;
        const double square = p[0] * p[0] + p[1] * p[1];
        if (!(square > limit * limit * (1.0 + 1e-6))) { break; }
        const double fall = (yy * p[0] * p[0] - 2.0 * s[1] * p[0] * p[1] + xx * p[1] * p[1]) * inverse;
        more += (sqrt(square) / limit - 1.0) * square / fall;
    }
}

/* Impulse of a contact whose node slides: normal + the friction of its cone that takes most energy, so that the node
   stays at the surface. `direction` is that of some friction. */
static plii_dvec3 project_friction(const plii_implicit_constraint* constraint, plii_dvec3 relative,
                                   plii_dvec3 direction) {
    const plii_dvec3 n = constraint->normal;
    const plii_dvec3 by_normal = plii_implicit_block_solve(&constraint->block, n);
    const double depth = -plii_dvec3_dot(n, relative), response = plii_dvec3_dot(n, by_normal);
    const plii_dvec3 along = plii_dvec3_scale(direction, 1.0 / plii_dvec3_length(direction));
    const plii_dvec3 axes[2] = {along, plii_dvec3_cross(n, along)};
    /* Of a push along each axis: what the normal takes back, and the motion along the surface that is left. */
    double taken[2], c[2];
    plii_dvec3 moved[2];
    for (int k = 0; k < 2; ++k) {
        moved[k] = plii_implicit_block_solve(&constraint->block, axes[k]);
        taken[k] = plii_dvec3_dot(n, moved[k]) / response;
        moved[k] = plii_dvec3_add_scaled(moved[k], by_normal, -taken[k]);
        c[k] = plii_dvec3_dot(axes[k], plii_dvec3_add_scaled(relative, by_normal, depth / response));
    }
    const double s[3] = {plii_dvec3_dot(axes[0], moved[0]), plii_dvec3_dot(axes[0], moved[1]),
                         plii_dvec3_dot(axes[1], moved[1])};
    plii_dvec3 impulse = plii_dvec3_scale(n, depth / response);
    double pressing = depth / response;
    for (int pass = 0; pass < IMPLICIT_SLIDE_PASSES; ++pass) {
        double p[2];
        project_to_disc(s, c, constraint->friction * (fmax(pressing, 0.0) + constraint->squeeze), p);
        pressing = depth / response - taken[0] * p[0] - taken[1] * p[1];
        if (!(pressing > 0.0) && !(constraint->squeeze > 0.0)) { break; } /* it would push the node into the surface */
        impulse = plii_dvec3_scale(n, pressing);
        impulse = plii_dvec3_add_scaled(impulse, axes[0], p[0]);
        impulse = plii_dvec3_add_scaled(impulse, axes[1], p[1]);
    }
    return impulse;
}

/* The square of the part along a surface. */
static double project_across(plii_dvec3 n, plii_dvec3 v) {
    const double along = plii_dvec3_dot(n, v);
    return plii_dvec3_dot(v, v) - along * along;
}

/* The same, with friction against the sliding that it leaves found by trying, which fails where a node is far stiffer
   in one direction than in another: friction that hardly moves a node of an upright sheet in its plane pushes it across
   this far the other way. `direction` is a first guess of that of friction. */
static plii_dvec3 project_sliding(const plii_implicit_constraint* constraint, plii_dvec3 relative,
                                  plii_dvec3 direction) {
    const plii_dvec3 n = constraint->normal;
    const double depth = -plii_dvec3_dot(n, relative);
    const double response = plii_dvec3_dot(n, plii_implicit_block_solve(&constraint->block, n));
    plii_dvec3 impulse = plii_dvec3_scale(n, depth / response);
    for (int pass = 0; pass < IMPLICIT_SLIDE_PASSES && constraint->friction > 0.0; ++pass) {
        const double length = plii_dvec3_length(direction);
        if (!(length > 0.0)) { break; }
        const plii_dvec3 push = plii_dvec3_add_scaled(n, direction, constraint->friction / length);
        const plii_dvec3 answer = plii_implicit_block_solve(&constraint->block, push);
        const double along = plii_dvec3_dot(n, answer);
        if (!(along > 0.1 * response)) { break; } /* friction would push the node into the surface */
        impulse = plii_dvec3_scale(push, depth / along);
        const plii_dvec3 moves = plii_dvec3_add_scaled(relative, answer, depth / along);
        const bool is_last = pass == IMPLICIT_SLIDE_PASSES - 1;
        if (is_last && plii_dvec3_dot(direction, moves) > 0.0 &&
            project_across(n, moves) > 4.0 * project_across(n, relative)) {
            return project_friction(constraint, relative, direction);
        }
        direction = plii_dvec3_across(plii_dvec3_add_scaled(n, moves, -1.0), n);
    }
    return impulse;
}

/* Friction of what slides is that of a dashpot for the rigid body: as an impulse that stays, it would throw a light one
   back over what slides. Not stiffer than the node itself, which gives `response` per impulse. */
static void project_set_viscosity(plii_implicit_constraint* constraint, double friction, double sliding,
                                  double response) {
    constraint->viscosity = friction > 0.0 ? friction / (sliding + friction * response) : 0.0;
}

/* The impulse of one constraint on its node, which moves with `free` without it. */
static void project_constraint(const plii_implicit_constraints* constraints, plii_implicit_constraint* constraint,
                               plii_dvec3 free) {
    const plii_dvec3 relative = plii_dvec3_sub(free, plii_implicit_constraint_goal(constraints, constraint));
    const plii_dvec3 stopping =
        plii_dvec3_scale(plii_implicit_block_mul(&constraint->block, relative), -constraint->influence);
    constraint->rows = 3;
    constraint->impulse = stopping;
    if (constraint->is_anchor) { return; }
    const bool is_squeezed = constraint->squeeze > 0.0;
    if (is_squeezed) { constraint->is_viscous = false; }
    if (!(plii_dvec3_dot(constraint->normal, relative) < 0.0) && !is_squeezed) {
        constraint->rows = 0;
        constraint->impulse = (plii_dvec3){0};
        return;
    }
    const double pressing = plii_dvec3_dot(constraint->normal, stopping);
    const plii_dvec3 across = plii_dvec3_add_scaled(stopping, constraint->normal, -pressing);
    const double grip = fmax(pressing, 0.0) + constraint->squeeze, length = plii_dvec3_length(across);
    if (grip > 0.0 && length <= constraint->friction * grip) { return; }
    constraint->rows = 1;
    constraint->is_viscous = constraint->is_viscous || is_squeezed;
    constraint->impulse =
        is_squeezed ? project_friction(constraint, relative, across) : project_sliding(constraint, relative, across);
    const plii_dvec3 slid =
        plii_dvec3_add(relative, plii_implicit_block_solve(&constraint->block, constraint->impulse));
    const double friction = sqrt(project_across(constraint->normal, constraint->impulse));
    const plii_dvec3 unit = plii_dvec3_scale(across, 1.0 / plii_dvec3_length(across));
    const double response = plii_dvec3_dot(unit, plii_implicit_block_solve(&constraint->block, unit));
    project_set_viscosity(constraint, friction, sqrt(project_across(constraint->normal, slid)), response);
}

void plii_implicit_push(const plii_implicit_constraints* constraints, const plii_implicit_constraint* constraint,
                        plii_dvec3 impulse, plii_dvec3* x) {
    for (int k = 0; k < constraint->node_count && !constraint->is_pinned; ++k) {
        const int node = constraint->nodes[k];
        const plii_dvec3 moved = plii_implicit_block_solve(&constraints->blocks[node], impulse);
        x[node] = plii_dvec3_add_scaled(x[node], moved, constraint->weights[k]);
    }
}

/* Several constraints of a node are solved one after the other, each given the impulses of the others. */
void plii_implicit_project_node(const plii_implicit_constraints* constraints, int begin, int end, plii_dvec3* x) {
    plii_implicit_constraint* items = constraints->items;
    const plii_dvec3 alone = items[begin].is_pinned ? (plii_dvec3){0} : x[items[begin].nodes[0]];
    plii_dvec3 sum = {0};
    for (int i = begin; i < end; ++i) {
        sum = end - begin > 1 ? plii_dvec3_add(sum, items[i].impulse) : sum;
    }
    const int passes = end - begin > 1 ? IMPLICIT_SHARED_PASSES : 1;
    for (int pass = 0; pass < passes; ++pass) {
        for (PLII_EACH(plii_implicit_constraint, constraint, &items[begin], end - begin)) {
            const plii_dvec3 others = end - begin > 1 ? plii_dvec3_sub(sum, constraint->impulse) : sum;
            project_constraint(constraints, constraint,
                               plii_dvec3_add(alone, plii_implicit_block_solve(&constraint->block, others)));
            sum = plii_dvec3_add(others, constraint->impulse);
        }
    }
    if (!items[begin].is_pinned) {
        x[items[begin].nodes[0]] = plii_dvec3_add(alone, plii_implicit_block_solve(&items[begin].block, sum));
    }
}

/* Adds to the impulse of a point of a face. */
static void project_add_impulse(const plii_implicit_constraints* constraints, plii_implicit_constraint* constraint,
                                plii_dvec3 more, plii_dvec3* x) {
    plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
    constraint->impulse = plii_dvec3_add(constraint->impulse, more);
    plii_implicit_push(constraints, constraint, more, x);
    if (constraint->is_pinned) {
        plii_implicit_add_velocity(rigid, constraint->arm, plii_dvec3_scale(more, -1.0), rigid->change);
    }
}

/* From where all impulses have brought it. */
static void project_point(const plii_implicit_constraints* constraints, plii_implicit_constraint* constraint,
                          plii_dvec3* x) {
    const plii_dvec3 n = constraint->normal, goal = plii_implicit_constraint_goal(constraints, constraint);
    const double pressing = plii_dvec3_dot(n, constraint->impulse);
    plii_dvec3 off = plii_dvec3_sub(goal, plii_implicit_constraint_point(constraint, x));
    const double needed = fmax(pressing + constraint->stiffness * plii_dvec3_dot(n, off), 0.0);
    constraint->rows = needed > 0.0 ? 1 : 0;
    if (!(needed > 0.0) && !(pressing > 0.0)) { return; }
    project_add_impulse(constraints, constraint, plii_dvec3_scale(n, needed - pressing), x);
    off = plii_dvec3_sub(goal, plii_implicit_constraint_point(constraint, x));
    const plii_dvec3 back = plii_dvec3_across(off, n);
    const double sliding = plii_dvec3_length(back), limit = constraint->friction * needed;
    const plii_dvec3 before = plii_dvec3_across(constraint->impulse, n);
    plii_dvec3 across = before;
    if (sliding > 0.0) {
        const plii_dvec3 unit = plii_dvec3_scale(back, 1.0 / sliding);
        const double response = plii_implicit_point_response(constraints, constraint, unit);
        across = plii_dvec3_add_scaled(across, unit, sliding / response);
    }
    const double length = plii_dvec3_length(across);
    if (length > limit) {
        across = plii_dvec3_scale(across, limit / length);
    } else if (needed > 0.0) {
        constraint->rows = 3;
    }
    project_add_impulse(constraints, constraint, plii_dvec3_sub(across, before), x);
    off = plii_dvec3_sub(goal, plii_implicit_constraint_point(constraint, x));
    project_set_viscosity(constraint, fmin(length, limit), sqrt(project_across(n, off)),
                          1.0 / constraint->stiffness_across);
}

/* Change of the impulse of a constraint when its point is moved, as long as the directions held stay the same. */
static plii_dvec3 project_response(const plii_implicit_constraint* constraint, plii_dvec3 moved) {
    const double share = constraint->share;
    if (constraint->rows == 0 || (constraint->is_point && constraint->is_pinned)) { return (plii_dvec3){0}; }
    if (constraint->is_point) {
        const double along = plii_dvec3_dot(constraint->normal, moved);
        const double across = constraint->rows == 3 ? constraint->stiffness_across : constraint->viscosity;
        return plii_dvec3_add_scaled(plii_dvec3_scale(moved, across), constraint->normal,
                                     along * (constraint->stiffness - across));
    }
    if (constraint->rows == 3) {
        return plii_dvec3_scale(plii_implicit_block_mul(&constraint->block, moved), constraint->influence * share);
    }
    const double response =
        plii_dvec3_dot(constraint->normal, plii_implicit_block_solve(&constraint->block, constraint->normal));
    const double along = plii_dvec3_dot(constraint->normal, moved);
    const plii_dvec3 across = plii_dvec3_add_scaled(moved, constraint->normal, -along);
    return plii_dvec3_add_scaled(plii_dvec3_scale(across, share * constraint->viscosity), constraint->normal,
                                 share * along / response);
}

void plii_implicit_add_response(const plii_implicit_constraint* constraint, plii_implicit_response_fn* response,
                                double m[6][6]) {
    for (int k = 0; k < 6; ++k) {
        double unit[6] = {0}, column[6] = {0};
        unit[k] = 1.0;
        const plii_dvec3 impulse = response(constraint, plii_implicit_point_change(unit, constraint->arm));
        plii_implicit_add_push(column, constraint->arm, impulse, 1.0);
        for (int i = 0; i < 6; ++i) {
            m[i][k] += column[i];
        }
    }
}

static void project_rigid(plii_implicit_constraints* constraints, int index, plii_dvec3* x) {
    plii_implicit_rigid* rigid = &constraints->rigids[index];
    double m[6][6], b[6];
    plii_implicit_rigid_matrix(rigid, m);
    plii_implicit_rigid_mul(rigid, rigid->change, -1.0, b);
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        if (constraint->rigid != index || constraint->rows == 0) { continue; }
        plii_implicit_add_push(b, constraint->arm, constraint->impulse, -1.0);
        plii_implicit_add_response(constraint, project_response, m);
    }
    if (!plii_factorise6(m)) { return; }
    plii_solve6((const double(*)[6])m, b);
    for (int i = 0; i < 6; ++i) {
        rigid->change[i] += b[i];
    }
    for (PLII_EACH(plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        if (constraint->rigid != index || constraint->rows == 0) { continue; }
        const plii_dvec3 more = project_response(constraint, plii_implicit_point_change(b, constraint->arm));
        constraint->impulse = plii_dvec3_add(constraint->impulse, more);
        plii_implicit_push(constraints, constraint, more, x);
    }
}

static void project_points(plii_implicit_constraints* constraints, bool are_pinned, int passes, plii_dvec3* x) {
    const int first = constraints->node_bound_count, count = constraints->count - first;
    for (int i = 0; i < passes * count; ++i) {
        plii_implicit_constraint* constraint = &constraints->items[first + i % count];
        if (constraint->is_pinned == are_pinned) { project_point(constraints, constraint, x); }
    }
}

static void project_push_all(const plii_implicit_constraints* constraints, int begin, int end, double sign,
                             plii_dvec3* x) {
    for (int i = begin; i < end; ++i) {
        plii_implicit_push(constraints, &constraints->items[i], plii_dvec3_scale(constraints->items[i].impulse, sign),
                           x);
    }
}

/* Points of faces start from all impulses of the sweep before. */
void plii_implicit_project(plii_implicit_constraints* constraints, plii_dvec3* x) {
    const int first = constraints->node_bound_count;
    if (first < constraints->count) {
        project_push_all(constraints, 0, constraints->count, 1.0, x);
        project_points(constraints, false, IMPLICIT_POINT_PASSES, x);
        project_push_all(constraints, 0, first, -1.0, x);
    }
    for (int begin = 0, end = 0; begin < first; begin = end) {
        while (end < first && constraints->items[end].nodes[0] == constraints->items[begin].nodes[0]) {
            ++end;
        }
        plii_implicit_project_node(constraints, begin, end, x);
    }
    plii_implicit_share_nodes(constraints);
    for (int i = 0; i < constraints->rigid_count; ++i) {
        if (constraints->rigids[i].is_dynamic) { project_rigid(constraints, i, x); }
    }
    project_points(constraints, true, IMPLICIT_HOLD_PASSES, x);
}
