#pragma once

/* What constraints take out of the search of conjugate gradients at a node, and what they give where they yield. */

#include "solver/implicit/implicit_system.h"

#define IMPLICIT_POINT_STIFFNESS 10.0 /* of points of faces, relative to that of their nodes */
#define IMPLICIT_HOLD_STIFFNESS 1e3   /* of what holds rigid bodies directly, relative to them */

/* The directions held at one node, and by whom. */
typedef struct gradient_filter {
    int node, begin, end; /* its constraints */
    int count;
    plii_dvec3 axes[3]; /* [count] orthonormal */
    int rigid;          /* PLI_NULL_INDEX unless dynamic */
    plii_dvec3 arm;
} gradient_filter;

/* In a `for`: each constraint of the node. */
#define GRADIENT_EACH(type, constraint, constraints, filter)                                                           \
    PLII_EACH(type, constraint, (constraints)->items + (filter)->begin, (filter)->end - (filter)->begin)

static inline void gradient_add_axis(gradient_filter* filter, plii_dvec3 axis) {
    for (int i = 0; i < filter->count; ++i) {
        axis = plii_dvec3_across(axis, filter->axes[i]);
    }
    const double length = plii_dvec3_length(axis);
    if (filter->count < 3 && length > 1e-3) { filter->axes[filter->count++] = plii_dvec3_scale(axis, 1.0 / length); }
}

static inline bool gradient_is_rigid(const plii_implicit_constraint* constraint) {
    return constraint->rows > 0 && !constraint->is_pinned && constraint->influence >= 1.0 && !constraint->is_point;
}

/* That of the next node with constraints, from one that is all zero on; false: there is no other node. A node between
   several bodies follows one that does not move, if there is one. */
static inline bool gradient_next_filter(const plii_implicit_constraints* constraints, gradient_filter* filter) {
    const int begin = filter->end, count = constraints->node_bound_count;
    if (begin == count) { return false; }
    const int node = constraints->items[begin].nodes[0];
    *filter = (gradient_filter){.node = node, .begin = begin, .end = begin, .rigid = PLI_NULL_INDEX};
    bool is_led = false;
    for (; filter->end < count && constraints->items[filter->end].nodes[0] == node; ++filter->end) {
        const plii_implicit_constraint* constraint = &constraints->items[filter->end];
        if (!gradient_is_rigid(constraint)) { continue; }
        if (!is_led || !constraints->rigids[constraint->rigid].is_dynamic) {
            filter->rigid = constraints->rigids[constraint->rigid].is_dynamic ? constraint->rigid : PLI_NULL_INDEX;
            filter->arm = constraint->arm;
            is_led = true;
        }
        if (constraint->rows == 1) { gradient_add_axis(filter, constraint->normal); }
        for (int k = 0; k < 3 && constraint->rows == 3; ++k) {
            gradient_add_axis(filter, plii_dvec3_make(k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0));
        }
    }
    return true;
}

static inline plii_dvec3 gradient_held_part(const gradient_filter* filter, plii_dvec3 x) {
    if (filter->count == 3) { return x; }
    plii_dvec3 sum = {0};
    for (int i = 0; i < filter->count; ++i) {
        sum = plii_dvec3_add_scaled(sum, filter->axes[i], plii_dvec3_dot(filter->axes[i], x));
    }
    return sum;
}

static inline double gradient_point_factor(const plii_implicit_constraint* constraint) {
    return constraint->is_pinned ? IMPLICIT_HOLD_STIFFNESS : IMPLICIT_POINT_STIFFNESS;
}

/* Impulse per velocity of constraints that give way: friction, anchors of partial influence, all on pinned nodes, and
   points of faces, whose impulses along the normal are those of the round before and this. */
static inline plii_dvec3 gradient_yield(const plii_implicit_constraint* constraint, plii_dvec3 x) {
    if (constraint->rows == 0) { return (plii_dvec3){0}; }
    if (gradient_is_rigid(constraint)) {
        if (!constraint->is_viscous) { return (plii_dvec3){0}; }
        return plii_dvec3_scale(plii_dvec3_across(x, constraint->normal), constraint->viscosity);
    }
    if (constraint->is_point) {
        const double along = gradient_point_factor(constraint) * constraint->stiffness;
        return plii_dvec3_add_scaled(plii_dvec3_scale(x, constraint->viscosity), constraint->normal,
                                     (along - constraint->viscosity) * plii_dvec3_dot(constraint->normal, x));
    }
    if (!constraint->is_pinned) {
        return plii_dvec3_scale(plii_implicit_block_mul(&constraint->block, x),
                                constraint->influence / (1.0 - constraint->influence));
    }
    if (constraint->rows == 3) {
        return plii_dvec3_scale(plii_implicit_block_mul(&constraint->block, x), constraint->influence);
    }
    const plii_dvec3 held = plii_dvec3_scale(constraint->normal, plii_dvec3_dot(constraint->normal, x));
    return plii_implicit_block_mul(&constraint->block, held);
}

/* x += what an impulse at the point is to its nodes. */
static inline void gradient_spread(const plii_implicit_constraint* constraint, plii_dvec3 impulse, plii_dvec3* x) {
    for (int k = 0; k < constraint->node_count && !constraint->is_pinned; ++k) {
        const int node = constraint->nodes[k];
        x[node] = plii_dvec3_add_scaled(x[node], impulse, constraint->weights[k]);
    }
}
