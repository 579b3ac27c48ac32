/* Conjugate gradients on the implicit system, preconditioned with the diagonal blocks. Directions that anchors and
   contacts hold are taken out of the search as in Baraff and Witkin, "Large Steps in Cloth Simulation", section 5.2,
   but move along with the rigid bodies, which are unknowns as well. Which contacts press and what their friction is,
   is found in alternation with the solution. Friction is a viscosity, mu times the normal impulse over the sliding of
   the round before (lagged as in Li and others, "Incremental Potential Contact"): forces change little from round to
   round where sticking and sliding as conditions would come and go. */

#include "solver/implicit/implicit_system.h"

enum { IMPLICIT_MAX_ROUNDS = 8, IMPLICIT_NODE_PASSES = 8 };
#define IMPLICIT_LEAST_SLIDING 0.01      /* of what friction takes in a step */
#define IMPLICIT_FRICTION_TOLERANCE 1e-3 /* change of friction in a round, relative to all impulses */
#define IMPLICIT_POINT_STIFFNESS 10.0    /* of points of faces, relative to that of their nodes */
#define IMPLICIT_HOLD_STIFFNESS 1e3      /* of what holds rigid bodies directly, relative to them */

// -------------------------------------------------------------------------------------- what the constraints change

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

static void gradient_add_axis(gradient_filter* filter, plii_dvec3 axis) {
    for (int i = 0; i < filter->count; ++i) {
        axis = plii_dvec3_across(axis, filter->axes[i]);
    }
    const double length = plii_dvec3_length(axis);
    if (filter->count < 3 && length > 1e-3) { filter->axes[filter->count++] = plii_dvec3_scale(axis, 1.0 / length); }
}

static bool gradient_is_rigid(const plii_implicit_constraint* constraint) {
    return constraint->rows > 0 && !constraint->is_pinned && constraint->influence >= 1.0 && !constraint->is_point;
}

/* That of the next node with constraints, from one that is all zero on; false: there is no other node. A node between
   several bodies follows one that does not move, if there is one. */
static bool gradient_next_filter(const plii_implicit_constraints* constraints, gradient_filter* filter) {
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

static plii_dvec3 gradient_held_part(const gradient_filter* filter, plii_dvec3 x) {
    if (filter->count == 3) { return x; }
    plii_dvec3 sum = {0};
    for (int i = 0; i < filter->count; ++i) {
        sum = plii_dvec3_add_scaled(sum, filter->axes[i], plii_dvec3_dot(filter->axes[i], x));
    }
    return sum;
}

static double gradient_point_factor(const plii_implicit_constraint* constraint) {
    return constraint->is_pinned ? IMPLICIT_HOLD_STIFFNESS : IMPLICIT_POINT_STIFFNESS;
}

/* Impulse per velocity of constraints that give way: friction, anchors of partial influence, all on pinned nodes, and
   points of faces, whose impulses along the normal are those of the round before and this. */
static plii_dvec3 gradient_yield(const plii_implicit_constraint* constraint, plii_dvec3 x) {
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
    if (!constraint->is_pinned || constraint->rows == 3) {
        const double share = constraint->influence / (constraint->is_pinned ? 1.0 : 1.0 - constraint->influence);
        return plii_dvec3_scale(plii_implicit_block_mul(&constraint->block, x), share);
    }
    const plii_dvec3 held = plii_dvec3_scale(constraint->normal, plii_dvec3_dot(constraint->normal, x));
    return plii_implicit_block_mul(&constraint->block, held);
}

/* x += what an impulse at the point is to its nodes. */
static void gradient_spread(const plii_implicit_constraint* constraint, plii_dvec3 impulse, plii_dvec3* x) {
    for (int k = 0; k < constraint->node_count && !constraint->is_pinned; ++k) {
        const int node = constraint->nodes[k];
        x[node] = plii_dvec3_add_scaled(x[node], impulse, constraint->weights[k]);
    }
}

/* The held part of the direction is that of the rigid bodies. */
static void gradient_lead(plii_implicit_system* system) {
    const plii_implicit_constraints* constraints = &system->constraints;
    for (gradient_filter filter = {0}; gradient_next_filter(constraints, &filter);) {
        plii_dvec3 *x = &system->direction[filter.node], lead = {0};
        if (filter.count == 0) { continue; }
        if (filter.rigid != PLI_NULL_INDEX) {
            lead = plii_implicit_point_change(constraints->rigids[filter.rigid].direction, filter.arm);
        }
        *x = plii_dvec3_add(*x, gradient_held_part(&filter, plii_dvec3_sub(lead, *x)));
    }
}

/* Moves the held part of the nodes' impulses y to the rigid bodies: to their products, or residuals. */
static void gradient_reduce(const plii_implicit_constraints* constraints, bool are_products, plii_dvec3* y) {
    for (gradient_filter filter = {0}; gradient_next_filter(constraints, &filter);) {
        if (filter.count == 0) { continue; }
        plii_dvec3* of_node = &y[filter.node];
        const plii_dvec3 held = gradient_held_part(&filter, *of_node);
        if (filter.rigid != PLI_NULL_INDEX) {
            plii_implicit_rigid* rigid = &constraints->rigids[filter.rigid];
            plii_implicit_add_push(are_products ? rigid->product : rigid->residual, filter.arm, held, 1.0);
        }
        *of_node = plii_dvec3_sub(*of_node, held);
    }
}

// -------------------------------------------------------------------------------------------- passes over the nodes

enum { GRADIENT_PRODUCT_NS = 40, GRADIENT_ADD_NS = 5 }; /* per node */

/* W x of a node that is not pinned, but for holds. */
static plii_dvec3 gradient_product(const plii_implicit_pass* pass, int node, const plii_dvec3* x) {
    const plii_implicit_system* system = pass->system;
    const plii_dvec3 own = x[node];
    plii_dvec3 sum = plii_dvec3_scale(own, 1.0 / (double)system->body->positions[node].w);
    for (int k = system->graph->begin[node]; k < system->graph->begin[node + 1]; ++k) {
        const plii_implicit_half* half = &system->halves[k];
        const plii_dvec3 q = plii_dvec3_from(half->axis), difference = plii_dvec3_sub(own, x[half->neighbour]);
        sum = plii_dvec3_add_scaled(sum, q, plii_dvec3_dot(q, difference));
        sum = plii_dvec3_add_scaled(sum, difference, (double)half->isotropic);
    }
    return sum;
}

/* to = W b, or a - W b where there is an a. */
static void gradient_product_range(int begin, int end, void* data) {
    const plii_implicit_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        const bool is_pinned = plii_implicit_block_is_pinned(&pass->system->blocks[i]);
        const plii_dvec3 product = is_pinned ? (plii_dvec3){0} : gradient_product(pass, i, pass->b);
        pass->to[i] = is_pinned || pass->a == NULL ? product : plii_dvec3_sub(pass->a[i], product);
    }
}

static void gradient_add_range(int begin, int end, void* data) {
    const plii_implicit_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        pass->to[i] = plii_dvec3_add_scaled(pass->a[i], pass->b[i], pass->factor);
    }
}

/* to = a + factor b */
static void gradient_add(const plii_implicit_system* system, const plii_dvec3* a, double factor, const plii_dvec3* b,
                         plii_dvec3* to) {
    plii_implicit_pass pass = {.a = a, .b = b, .to = to, .factor = factor};
    plii_body_run_nodes(system->body, gradient_add_range, &pass, plii_grain(GRADIENT_ADD_NS));
}

static double gradient_dot_block(int begin, int end, const void* data) {
    const plii_implicit_pass* pass = data;
    double sum = 0.0;
    for (int i = begin; i < end; ++i) {
        sum += plii_dvec3_dot(pass->a[i], pass->b[i]);
    }
    return sum;
}

static double gradient_dot(const plii_implicit_system* system, const plii_dvec3* a, const plii_dvec3* b) {
    const plii_implicit_pass pass = {.a = a, .b = b};
    return plii_implicit_sum(system, gradient_dot_block, &pass);
}

// --------------------------------------------------------------------------------------------------------- products

/* residual = rhs + friction - W x, of rigid bodies too. */
static void gradient_start_residual(plii_implicit_system* system) {
    plii_implicit_constraints* constraints = &system->constraints;
    plii_implicit_pass pass = {system, system->rhs, system->solution, system->residual, 0.0};
    plii_body_run_nodes(system->body, gradient_product_range, &pass, plii_grain(GRADIENT_PRODUCT_NS));
    plii_implicit_add_holds(system, system->solution, -1.0, system->residual);
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        plii_implicit_rigid_mul(rigid, rigid->change, -1.0, rigid->residual);
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        plii_dvec3 impulse = {0};
        if (gradient_is_rigid(constraint) && !constraint->is_viscous) {
            if (constraint->rows == 1) { impulse = plii_dvec3_across(constraint->impulse, constraint->normal); }
        } else if (constraint->rows > 0) {
            const plii_dvec3 goal = plii_implicit_constraint_goal(constraints, constraint);
            impulse = gradient_yield(
                constraint, plii_dvec3_sub(goal, plii_implicit_constraint_point(constraint, system->solution)));
            if (constraint->is_point) {
                const plii_dvec3 n = constraint->normal;
                impulse = plii_dvec3_add_scaled(impulse, n, plii_dvec3_dot(n, constraint->impulse));
            }
        }
        gradient_spread(constraint, impulse, system->residual);
        plii_implicit_add_push(constraints->rigids[constraint->rigid].residual, constraint->arm, impulse, -1.0);
    }
    gradient_reduce(constraints, false, system->residual);
}

/* spare = W direction, of rigid bodies too; gives direction . W direction. */
static double gradient_multiply(plii_implicit_system* system) {
    plii_implicit_constraints* constraints = &system->constraints;
    plii_implicit_pass pass = {.system = system, .b = system->direction, .to = system->spare};
    plii_body_run_nodes(system->body, gradient_product_range, &pass, plii_grain(GRADIENT_PRODUCT_NS));
    plii_implicit_add_holds(system, system->direction, 1.0, system->spare);
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        if (rigid->is_dynamic) { plii_implicit_rigid_mul(rigid, rigid->direction, 1.0, rigid->product); }
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
        if (constraint->rows == 0 || (gradient_is_rigid(constraint) && !constraint->is_viscous)) { continue; }
        plii_dvec3 relative = plii_implicit_constraint_point(constraint, system->direction);
        if (rigid->is_dynamic) {
            relative = plii_dvec3_sub(relative, plii_implicit_point_change(rigid->direction, constraint->arm));
        }
        const plii_dvec3 impulse = gradient_yield(constraint, relative);
        gradient_spread(constraint, impulse, system->spare);
        if (rigid->is_dynamic) { plii_implicit_add_push(rigid->product, constraint->arm, impulse, -1.0); }
    }
    gradient_reduce(constraints, true, system->spare);
    double sum = gradient_dot(system, system->direction, system->spare);
    for (PLII_EACH(const plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        for (int k = 0; k < 6 && rigid->is_dynamic; ++k) {
            sum += rigid->direction[k] * rigid->product[k];
        }
    }
    return sum;
}

// ------------------------------------------------------------------------------------------------- preconditioner

/* W_ii, with the viscosities of friction, between two directions at a node. */
static double gradient_entry(const plii_implicit_constraints* constraints, const gradient_filter* filter, plii_dvec3 a,
                             plii_dvec3 b) {
    double sum = plii_dvec3_dot(a, plii_implicit_block_mul(&constraints->items[filter->begin].block, b));
    for (GRADIENT_EACH(const plii_implicit_constraint, constraint, constraints, filter)) {
        if (!constraint->is_viscous || constraint->rows == 0) { continue; }
        const plii_dvec3 n = constraint->normal;
        sum += constraint->viscosity * (plii_dvec3_dot(a, b) - plii_dvec3_dot(n, a) * plii_dvec3_dot(n, b));
    }
    return sum;
}

/* The answer of a node of which something is held to r, in the directions that are free. */
static plii_dvec3 gradient_free_part(const plii_implicit_constraints* constraints, const gradient_filter* filter,
                                     plii_dvec3 r) {
    if (filter->count == 3) { return (plii_dvec3){0}; }
    const plii_dvec3 n = filter->axes[0];
    if (filter->count == 2) {
        const plii_dvec3 a = plii_dvec3_cross(n, filter->axes[1]);
        return plii_dvec3_scale(a, plii_dvec3_dot(a, r) / gradient_entry(constraints, filter, a, a));
    }
    const plii_dvec3 a = plii_dvec3_perpendicular(n), b = plii_dvec3_cross(n, a);
    const double aa = gradient_entry(constraints, filter, a, a), bb = gradient_entry(constraints, filter, b, b),
                 ab = gradient_entry(constraints, filter, a, b), ra = plii_dvec3_dot(a, r), rb = plii_dvec3_dot(b, r);
    const double inverse = 1.0 / (aa * bb - ab * ab);
    return plii_dvec3_add_scaled(plii_dvec3_scale(a, inverse * (bb * ra - ab * rb)), b, inverse * (aa * rb - ab * ra));
}

/* Diagonal blocks of the rigid bodies: their own mass and that of what they lead. */
static void gradient_factorise_rigids(plii_implicit_system* system) {
    plii_implicit_constraints* constraints = &system->constraints;
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        if (rigid->is_dynamic) { plii_implicit_rigid_matrix(rigid, rigid->factor); }
    }
    for (gradient_filter filter = {0}; gradient_next_filter(constraints, &filter);) {
        for (int k = 0; k < 6 && filter.count > 0 && filter.rigid != PLI_NULL_INDEX; ++k) {
            double unit[6] = {0}, column[6] = {0};
            unit[k] = 1.0;
            const plii_dvec3 held = gradient_held_part(&filter, plii_implicit_point_change(unit, filter.arm));
            const plii_dvec3 impulse = plii_implicit_block_mul(&constraints->items[filter.begin].block, held);
            plii_implicit_add_push(column, filter.arm, gradient_held_part(&filter, impulse), 1.0);
            for (int m = 0; m < 6; ++m) {
                constraints->rigids[filter.rigid].factor[m][k] += column[m];
            }
        }
    }
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        plii_implicit_rigid* rigid = &constraints->rigids[constraint->rigid];
        if (rigid->is_dynamic) { plii_implicit_add_response(constraint, gradient_yield, rigid->factor); }
    }
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        rigid->is_solved = rigid->is_dynamic && plii_factorise6(rigid->factor);
    }
}

/* spare = preconditioned residual, and `product` of rigid bodies; gives its product with the residual. */
static double gradient_precondition(plii_implicit_system* system) {
    plii_implicit_constraints* constraints = &system->constraints;
    plii_implicit_solve_blocks(system, system->residual, system->spare);
    for (gradient_filter filter = {0}; gradient_next_filter(constraints, &filter);) {
        if (constraints->items[filter.begin].is_pinned || filter.count == 0) { continue; }
        system->spare[filter.node] = gradient_free_part(constraints, &filter, system->residual[filter.node]);
    }
    double sum = gradient_dot(system, system->spare, system->residual);
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        if (!rigid->is_solved) { continue; }
        memcpy(rigid->product, rigid->residual, sizeof rigid->product);
        plii_solve6((const double(*)[6])rigid->factor, rigid->product);
        for (int k = 0; k < 6; ++k) {
            sum += rigid->product[k] * rigid->residual[k];
        }
    }
    return sum;
}

// ------------------------------------------------------------------------------------------------------ iterations

/* direction = preconditioned residual + beta direction. */
static void gradient_choose_direction(plii_implicit_system* system, double beta) {
    gradient_add(system, system->spare, beta, system->direction, system->direction);
    for (PLII_EACH(plii_implicit_rigid, rigid, system->constraints.rigids, system->constraints.rigid_count)) {
        for (int k = 0; k < 6 && rigid->is_solved; ++k) {
            rigid->direction[k] = rigid->product[k] + beta * rigid->direction[k];
        }
    }
    gradient_lead(system);
}

/* With the present conditions. Gives the number of iterations; *first is the largest residual so far. */
static int gradient_solve(plii_implicit_system* system, int iterations, double* first, double* last) {
    const double tolerance = (double)system->def.tolerance;
    gradient_factorise_rigids(system);
    gradient_start_residual(system);
    double rz = gradient_precondition(system);
    gradient_choose_direction(system, 0.0);
    bool has_holds = false; /* much stiffer than all else, and solved at once */
    for (int i = system->constraints.node_bound_count; i < system->constraints.count; ++i) {
        has_holds = has_holds || (system->constraints.items[i].is_pinned && system->constraints.items[i].rows > 0);
    }
    if (!has_holds) { *first = fmax(*first, 1e-4 * rz); }
    const double goal = tolerance * tolerance * *first;
    int done = 0;
    while (done < iterations && rz > goal) {
        const double product = gradient_multiply(system);
        if (!(product > 0.0)) { break; }
        const double alpha = rz / product, rz_before = rz;
        gradient_add(system, system->solution, alpha, system->direction, system->solution);
        gradient_add(system, system->residual, -alpha, system->spare, system->residual);
        for (PLII_EACH(plii_implicit_rigid, rigid, system->constraints.rigids, system->constraints.rigid_count)) {
            for (int k = 0; k < 6 && rigid->is_solved; ++k) {
                rigid->change[k] += alpha * rigid->direction[k];
                rigid->residual[k] -= alpha * rigid->product[k];
            }
        }
        rz = gradient_precondition(system);
        gradient_choose_direction(system, rz / rz_before);
        done += 1;
    }
    *last = rz;
    return done;
}

// ------------------------------------------------------------------------------------------------------ conditions

static double gradient_most_viscosity(const plii_implicit_constraint* constraint) {
    return constraint->is_point ? gradient_point_factor(constraint) * constraint->stiffness_across
                                : IMPLICIT_HOLD_STIFFNESS * plii_implicit_block_stiffness(&constraint->block);
}

static bool gradient_sticks(const plii_implicit_constraint* constraint) {
    return constraint->viscosity >= gradient_most_viscosity(constraint);
}

/* The sliding at the start of the step. */
static plii_dvec3 gradient_slip_before(const plii_implicit_constraint* constraint) {
    const plii_dvec3 slip = plii_dvec3_scale(plii_dvec3_add(constraint->target, constraint->fall), -1.0);
    return plii_dvec3_across(slip, constraint->normal);
}

/* Whether a contact presses after a solution, and its friction. `off`: to its goal; `impulse`: of the solution. */
static void gradient_judge_contact(plii_implicit_constraint* constraint, double mass, plii_dvec3 off,
                                   plii_dvec3 impulse) {
    const plii_dvec3 n = constraint->normal;
    const double pressing = plii_dvec3_dot(n, impulse);
    double sliding = plii_dvec3_length(plii_dvec3_across(off, n));
    constraint->impulse = (plii_dvec3){0};
    if (constraint->rows == 0) {
        /* It comes in: as before the step, or, where it slides, less what friction takes. */
        const double taken = constraint->friction * pressing / mass;
        const double before = plii_dvec3_length(gradient_slip_before(constraint));
        sliding = before > IMPLICIT_LEAST_SLIDING * taken ? fmax(before, sliding - taken) : before;
        constraint->viscosity = 0.0;
    } else if (pressing > 0.0) {
        constraint->impulse = impulse;
    }
    constraint->rows = pressing > 0.0 ? 1 : 0;
    constraint->is_viscous = true;
    if (!(pressing > 0.0)) { return; }
    /* Friction is a viscosity, of an impulse of `limit` at the sliding that there is. Where this is none, it is what
       keeps the node where it is; where that takes more, the node is let go as if it were alone. */
    const double limit = constraint->friction * pressing, most = gradient_most_viscosity(constraint);
    const double holding = plii_dvec3_length(plii_dvec3_across(impulse, n));
    if (constraint->viscosity >= most && holding > limit) { sliding = fmax(sliding, (holding - limit) / mass); }
    constraint->viscosity = limit < most * sliding ? limit / sliding : limit > 0.0 ? most : 0.0;
}

/* The same of a point of a face, whose impulse along the normal grows by what is left of the error. */
static void gradient_judge_point(const pli_body* body, const plii_implicit_constraints* constraints,
                                 plii_implicit_constraint* constraint, const plii_dvec3* x) {
    const plii_dvec3 n = constraint->normal, goal = plii_implicit_constraint_goal(constraints, constraint),
                     off = plii_dvec3_sub(goal, plii_implicit_constraint_point(constraint, x));
    double weight = 0.0;
    for (int k = 0; k < constraint->node_count; ++k) {
        weight += constraint->weights[k] * constraint->weights[k] * (double)body->positions[constraint->nodes[k]].w;
    }
    const double before = plii_dvec3_dot(n, constraint->impulse);
    const double mass = constraint->is_pinned ? constraint->stiffness : 1.0 / weight;
    const plii_dvec3 impulse = constraint->rows == 0
                                   ? plii_dvec3_scale(off, mass)
                                   : plii_dvec3_add_scaled(gradient_yield(constraint, off), n, before);
    gradient_judge_contact(constraint, mass, off, impulse);
}

/* The same of a node that touches several surfaces, `free` without their impulses, as long as its neighbours stay and
   the viscosities are what they are: their normal impulses, one after the other. Friction by how it slid before would
   throw it to and fro between surfaces that face each other. */
static void gradient_judge_node(const pli_body* body, const plii_implicit_constraints* constraints,
                                const gradient_filter* filter, plii_dvec3 free, plii_dvec3* x) {
    const plii_dvec3 a = {1, 0, 0}, b = {0, 1, 0}, c = {0, 0, 1};
    const double d[6] = {gradient_entry(constraints, filter, a, a), gradient_entry(constraints, filter, a, b),
                         gradient_entry(constraints, filter, a, c), gradient_entry(constraints, filter, b, b),
                         gradient_entry(constraints, filter, b, c), gradient_entry(constraints, filter, c, c)};
    const double mass = 1.0 / (double)body->positions[filter->node].w;
    const plii_implicit_block block = plii_implicit_factorise(d, mass);
    plii_dvec3 push = plii_implicit_block_mul(&constraints->items[filter->begin].block, free);
    for (GRADIENT_EACH(plii_implicit_constraint, constraint, constraints, filter)) { /* is left of the impulses */
        const plii_dvec3 n = constraint->normal;
        constraint->impulse = plii_dvec3_scale(n, fmax(plii_dvec3_dot(n, constraint->impulse), 0.0));
        const plii_dvec3 goal = plii_implicit_constraint_goal(constraints, constraint);
        push = plii_dvec3_add(push, plii_dvec3_add(constraint->impulse, gradient_yield(constraint, goal)));
    }
    plii_dvec3 there = plii_implicit_block_solve(&block, push);
    for (int pass = 0; pass < IMPLICIT_NODE_PASSES; ++pass) {
        for (GRADIENT_EACH(plii_implicit_constraint, constraint, constraints, filter)) {
            const plii_dvec3 n = constraint->normal, answer = plii_implicit_block_solve(&block, n),
                             off = plii_dvec3_sub(plii_implicit_constraint_goal(constraints, constraint), there);
            const double more =
                fmax(plii_dvec3_dot(n, off) / plii_dvec3_dot(n, answer), -plii_dvec3_dot(n, constraint->impulse));
            constraint->impulse = plii_dvec3_add_scaled(constraint->impulse, n, more);
            there = plii_dvec3_add_scaled(there, answer, more);
        }
    }
    for (GRADIENT_EACH(plii_implicit_constraint, constraint, constraints, filter)) {
        const plii_dvec3 off = plii_dvec3_sub(plii_implicit_constraint_goal(constraints, constraint), there);
        gradient_judge_contact(constraint, mass, off,
                               plii_dvec3_add(constraint->impulse, gradient_yield(constraint, off)));
    }
    *x = there;
}

/* Anchored, or squeezed. */
static bool gradient_is_fixed(const plii_implicit_constraints* constraints, const gradient_filter* filter) {
    for (GRADIENT_EACH(const plii_implicit_constraint, constraint, constraints, filter)) {
        if (constraint->is_anchor || constraint->is_pinned || constraint->squeeze > 0.0) { return true; }
    }
    return false;
}

/* Which conditions hold after a solution; meets them. True when it was made for them, and for their friction. */
static bool gradient_judge(plii_implicit_system* system) {
    const pli_body* body = system->body;
    plii_implicit_constraints* constraints = &system->constraints;
    const int count = constraints->node_bound_count;
    double change = 0.0, scale = 0.0;
    bool is_same = true;
    for (PLII_EACH(plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        const int node = constraint->nodes[0];
        if (!constraint->is_pinned && !constraint->is_point) {
            system->spare[node] = plii_implicit_swept(system, node);
        }
        constraint->rows_before = constraint->rows;
        constraint->impulse_before = constraint->impulse;
    }
    for (int i = count; i < constraints->count; ++i) {
        gradient_judge_point(body, constraints, &constraints->items[i], system->solution);
        plii_implicit_push(constraints, &constraints->items[i], constraints->items[i].impulse, system->spare);
    }
    for (gradient_filter filter = {0}; gradient_next_filter(constraints, &filter);) {
        plii_implicit_constraint* constraint = &constraints->items[filter.begin];
        plii_dvec3* x = &system->solution[filter.node];
        const plii_dvec3 free = system->spare[filter.node];
        if (gradient_is_fixed(constraints, &filter)) {
            plii_implicit_project_node(constraints, filter.begin, filter.end, system->spare);
            if (!constraint->is_pinned) { *x = system->spare[filter.node]; }
        } else if (filter.end - filter.begin > 1) {
            gradient_judge_node(body, constraints, &filter, free, x);
        } else {
            const plii_dvec3 off = plii_dvec3_sub(plii_implicit_constraint_goal(constraints, constraint), *x);
            const double mass = 1.0 / (double)body->positions[filter.node].w;
            gradient_judge_contact(constraint, mass, off,
                                   constraint->rows == 0
                                       ? plii_dvec3_scale(off, mass)
                                       : plii_implicit_block_mul(&constraint->block, plii_dvec3_sub(*x, free)));
            const bool is_new = constraint->rows_before == 0;
            plii_dvec3 held = plii_dvec3_scale(constraint->normal, plii_dvec3_dot(constraint->normal, off));
            if (is_new || gradient_sticks(constraint)) { held = off; }
            if (is_new && !gradient_sticks(constraint)) {
                held = plii_dvec3_add(held, gradient_slip_before(constraint));
            }
            if (constraint->rows > 0) { *x = plii_dvec3_add(*x, held); }
        }
    }
    plii_implicit_share_nodes(constraints);
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->count)) {
        is_same = is_same && constraint->rows == constraint->rows_before;
        const plii_dvec3 more = plii_dvec3_sub(constraint->impulse, constraint->impulse_before);
        change += constraint->rows == 1 || constraint->is_point ? plii_dvec3_dot(more, more) : 0.0;
        scale += plii_dvec3_dot(constraint->impulse, constraint->impulse);
    }
    return is_same && change <= IMPLICIT_FRICTION_TOLERANCE * IMPLICIT_FRICTION_TOLERANCE * scale;
}

void plii_implicit_conjugate_gradient(plii_implicit_system* system, int iterations, bool is_warm) {
    plii_implicit_constraints* constraints = &system->constraints;
    if (!is_warm) { memset(system->solution, 0, plii_implicit_vector_size(system->body)); }
    memset(system->direction, 0, plii_implicit_vector_size(system->body));
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        memset(rigid->direction, 0, sizeof rigid->direction);
    }
    plii_implicit_solve_blocks(system, system->rhs, system->spare);
    double first = gradient_dot(system, system->rhs, system->spare), last = 0.0;
    (void)gradient_judge(system);
    for (int round = 0; round < IMPLICIT_MAX_ROUNDS; ++round) {
        system->report.iterations += gradient_solve(system, iterations, &first, &last);
        if (gradient_judge(system)) { break; }
    }
    system->report.residual = first > 0.0 ? (float)sqrt(last / first) : 0.0f;
}
