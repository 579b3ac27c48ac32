/* Conditions of anchors and contacts on a solution of the implicit system, met in the norm of the diagonal blocks: each
   node, taken alone, is solved exactly with its non-penetration and Coulomb friction, then each rigid body with the
   nodes that it holds. The projection does not lengthen errors in that norm and a Jacobi sweep shortens them, hence
   sweeps with projections converge wherever sweeps do. */

#include "solver/implicit/implicit_constraints.h"

enum { IMPLICIT_SHARED_PASSES = 8, IMPLICIT_SLIDE_PASSES = 3 };

// -------------------------------------------------------------------------------------------------------- 6x6

bool plii_implicit_factorise6(double m[6][6]) {
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k <= i; ++k) {
            double sum = m[i][k];
            for (int l = 0; l < k; ++l) {
                sum -= m[i][l] * m[k][l];
            }
            if (i == k) {
                if (!(sum > 0.0)) { return false; }
                m[i][i] = sqrt(sum);
            } else {
                m[i][k] = sum / m[k][k];
            }
        }
    }
    return true;
}

void plii_implicit_solve6(const double m[6][6], double b[6]) {
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < i; ++k) {
            b[i] -= m[i][k] * b[k];
        }
        b[i] /= m[i][i];
    }
    for (int i = 5; i >= 0; --i) {
        for (int k = i + 1; k < 6; ++k) {
            b[i] -= m[k][i] * b[k];
        }
        b[i] /= m[i][i];
    }
}

// ------------------------------------------------------------------------------------------------------ nodes

plii_dvec3 plii_implicit_constraint_goal(const plii_implicit_constraints* holds, const plii_implicit_constraint* hold) {
    const plii_implicit_rigid* rigid = &holds->rigids[hold->rigid];
    if (!rigid->is_dynamic) { return hold->target; }
    return plii_dvec3_add(hold->target, plii_implicit_point_change(rigid->change, hold->lever));
}

/* Impulse of a contact whose node slides: normal + friction against the sliding, so that the node stays at the surface.
   `direction` is a first guess of that of friction. */
static plii_dvec3 project_sliding(const plii_implicit_constraint* hold, plii_dvec3 relative, plii_dvec3 direction) {
    const plii_dvec3 n = hold->normal;
    const double depth = -plii_dvec3_dot(n, relative);
    const double response = plii_dvec3_dot(n, plii_implicit_block_solve(&hold->block, n));
    plii_dvec3 impulse = plii_dvec3_scale(n, depth / response);
    for (int pass = 0; pass < IMPLICIT_SLIDE_PASSES && hold->friction > 0.0; ++pass) {
        const double length = plii_dvec3_length(direction);
        if (!(length > 0.0)) { break; }
        const plii_dvec3 push = plii_dvec3_add_scaled(n, direction, hold->friction / length);
        const plii_dvec3 answer = plii_implicit_block_solve(&hold->block, push);
        const double along = plii_dvec3_dot(n, answer);
        if (!(along > 0.1 * response)) { break; } /* friction would push the node into the surface */
        impulse = plii_dvec3_scale(push, depth / along);
        const plii_dvec3 moves = plii_dvec3_add_scaled(relative, answer, depth / along);
        direction = plii_dvec3_add_scaled(n, moves, -1.0);
        direction = plii_dvec3_add_scaled(direction, n, -plii_dvec3_dot(n, direction));
    }
    return impulse;
}

/* The impulse of one hold on its node, which moves with `free` without it. */
static void project_hold(const plii_implicit_constraints* holds, plii_implicit_constraint* hold, plii_dvec3 free) {
    const plii_dvec3 relative = plii_dvec3_sub(free, plii_implicit_constraint_goal(holds, hold));
    const plii_dvec3 stopping = plii_dvec3_scale(plii_implicit_block_mul(&hold->block, relative), -hold->share);
    hold->rows = 3;
    hold->impulse = stopping;
    if (hold->is_anchor) { return; }
    if (!(plii_dvec3_dot(hold->normal, relative) < 0.0)) {
        hold->rows = 0;
        hold->impulse = (plii_dvec3){0};
        return;
    }
    const double pressing = plii_dvec3_dot(hold->normal, stopping);
    const plii_dvec3 across = plii_dvec3_add_scaled(stopping, hold->normal, -pressing);
    if (pressing > 0.0 && plii_dvec3_length(across) <= hold->friction * pressing) { return; }
    hold->rows = 1;
    hold->impulse = project_sliding(hold, relative, across);
}

/* Several holds share it by turns, each given the others. */
void plii_implicit_project_node(const plii_implicit_constraints* holds, int begin, int end, plii_dvec3* x) {
    plii_implicit_constraint* items = holds->items;
    const plii_dvec3 alone = items[begin].is_pinned ? (plii_dvec3){0} : x[items[begin].node];
    plii_dvec3 sum = {0};
    for (int i = begin; i < end; ++i) {
        sum = end - begin > 1 ? plii_dvec3_add(sum, items[i].impulse) : sum;
    }
    const int passes = end - begin > 1 ? IMPLICIT_SHARED_PASSES : 1;
    for (int pass = 0; pass < passes; ++pass) {
        for (int i = begin; i < end; ++i) {
            plii_implicit_constraint* hold = &items[i];
            const plii_dvec3 others = end - begin > 1 ? plii_dvec3_sub(sum, hold->impulse) : sum;
            project_hold(holds, hold, plii_dvec3_add(alone, plii_implicit_block_solve(&hold->block, others)));
            sum = plii_dvec3_add(others, hold->impulse);
        }
    }
    if (!items[begin].is_pinned) {
        x[items[begin].node] = plii_dvec3_add(alone, plii_implicit_block_solve(&items[begin].block, sum));
    }
}

// -------------------------------------------------------------------------------------------------- rigid bodies

/* Change of the impulse of a hold when its point is moved, as long as the directions held stay the same. */
static plii_dvec3 project_response(const plii_implicit_constraint* hold, plii_dvec3 moved) {
    if (hold->rows == 3) { return plii_dvec3_scale(plii_implicit_block_mul(&hold->block, moved), hold->share); }
    if (hold->rows == 0) { return (plii_dvec3){0}; }
    const double response = plii_dvec3_dot(hold->normal, plii_implicit_block_solve(&hold->block, hold->normal));
    return plii_dvec3_scale(hold->normal, plii_dvec3_dot(hold->normal, moved) / response);
}

static void project_add_matrix(const plii_implicit_constraint* hold, double m[6][6]) {
    for (int k = 0; k < 6; ++k) {
        double unit[6] = {0}, column[6] = {0};
        unit[k] = 1.0;
        const plii_dvec3 impulse = project_response(hold, plii_implicit_point_change(unit, hold->lever));
        plii_implicit_add_push(column, hold->lever, impulse, 1.0);
        for (int i = 0; i < 6; ++i) {
            m[i][k] += column[i];
        }
    }
}

static void project_rigid(plii_implicit_constraints* holds, int index, plii_dvec3* x) {
    plii_implicit_rigid* rigid = &holds->rigids[index];
    double m[6][6], b[6];
    plii_implicit_rigid_matrix(rigid, m);
    plii_implicit_rigid_mul(rigid, rigid->change, b);
    for (int i = 0; i < 6; ++i) {
        b[i] = -b[i];
    }
    for (int i = 0; i < holds->count; ++i) {
        const plii_implicit_constraint* hold = &holds->items[i];
        if (hold->rigid != index || hold->rows == 0) { continue; }
        plii_implicit_add_push(b, hold->lever, hold->impulse, -1.0);
        project_add_matrix(hold, m);
    }
    if (!plii_implicit_factorise6(m)) { return; }
    plii_implicit_solve6((const double(*)[6])m, b);
    for (int i = 0; i < 6; ++i) {
        rigid->change[i] += b[i];
    }
    for (int i = 0; i < holds->count; ++i) {
        plii_implicit_constraint* hold = &holds->items[i];
        if (hold->rigid != index || hold->rows == 0) { continue; }
        const plii_dvec3 more = project_response(hold, plii_implicit_point_change(b, hold->lever));
        hold->impulse = plii_dvec3_add(hold->impulse, more);
        if (!hold->is_pinned) {
            x[hold->node] = plii_dvec3_add(x[hold->node], plii_implicit_block_solve(&hold->block, more));
        }
    }
}

void plii_implicit_project(plii_implicit_constraints* holds, plii_dvec3* x) {
    for (int begin = 0, end = 0; begin < holds->count; begin = end) {
        while (end < holds->count && holds->items[end].node == holds->items[begin].node) {
            ++end;
        }
        plii_implicit_project_node(holds, begin, end, x);
    }
    for (int i = 0; i < holds->rigid_count; ++i) {
        if (holds->rigids[i].is_dynamic) { project_rigid(holds, i, x); }
    }
}
