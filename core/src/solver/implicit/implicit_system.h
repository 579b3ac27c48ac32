#pragma once

/* The linear system of one implicit step, W dv = rhs with W = M - h^2 J, and three ways to its solution. Numbers of
   nodes are double: with stiff springs and light nodes the 3x3 blocks have condition numbers far beyond float. */

#include "base/ranges.h"
#include "body/link_graph.h"
#include "pliant/implicit.h"
#include "solver/implicit/implicit_constraints.h"

/* One half of a spring as its node sees it: h^2 J_ij + h c u u^T = axis axis^T + isotropic I. */
typedef struct plii_implicit_half {
    pli_vec3 axis;
    float isotropic;
    int neighbour;
} plii_implicit_half;

/* A spring from a node to a fixed point: h^2 k on the diagonal of its block, or along a line. By node. */
typedef struct plii_implicit_hold {
    int node;
    double hardness;  /* kg */
    plii_dvec3 along; /* unit, or zero */
    plii_dvec3 rhs;   /* its part of the right-hand side */
} plii_implicit_hold;
typedef struct plii_implicit_holds {
    plii_implicit_hold* items;
    int count, capacity;
} plii_implicit_holds;

/* Nodes of a block of a sum, at least. */
enum { PLII_IMPLICIT_SUM_NODES = 2048 };

typedef struct plii_implicit_system {
    pli_implicit_def def;
    bool had_links;           /* on positions, before this solver came */
    double spectral_radius;   /* 0: to be estimated */
    double spectral_mobility; /* of the step that it was estimated in */
    pli_implicit_report report;
    /* Of the step in progress, but for the arrays. */
    const pli_body* body;
    const plii_link_graph* graph;
    plii_implicit_half* halves; /* [2 * link_count] in the order of the graph */
    plii_implicit_block* blocks;
    int* groups; /* [node_count] for the balance of momentum */
    plii_implicit_constraints constraints;
    plii_implicit_holds holds;
    plii_dvec3* rhs;      /* [node_count], as all vectors */
    plii_dvec3* solution; /* change of velocity, m/s */
    plii_dvec3* spare;
    plii_dvec3* residual;
    plii_dvec3* before; /* the solution that nodes have followed */
    /* By node, the velocity that leads to where free flight would; NULL at the start of a step: that of the body. */
    const plii_dvec3* leads;
    plii_dvec3* direction; /* of conjugate gradients */
} plii_implicit_system;

/* Springs at their present lengths, and holds; adds to rhs. Gives how many springs are too short for a direction. */
int plii_implicit_assemble(const plii_implicit_system* system);

/* The springs to fixed points that features have, with their part of rhs; before plii_implicit_assemble. */
void plii_implicit_gather_holds(pli_body* body, plii_implicit_system* system);

/* What a sweep makes of the solution at a node. */
plii_dvec3 plii_implicit_swept(const plii_implicit_system* system, int node);
/* to = W_ii^-1 from at all nodes. */
void plii_implicit_solve_blocks(const plii_implicit_system* system, const plii_dvec3* from, plii_dvec3* to);

/* Energy that the step gains by the solution, where the body is, relative to what springs and constraints change. */
double plii_implicit_excess(const plii_implicit_system* system);
/* Goes back towards the solution before, where the body and the linearisation are, until what backward Euler minimises
   is not more than there. Gives the share of the way that is left. */
double plii_implicit_search(plii_implicit_system* system);

/* Of a pass over the nodes: what it reads and writes. */
typedef struct plii_implicit_pass {
    const plii_implicit_system* system;
    const plii_dvec3 *a, *b;
    plii_dvec3* to;
    double factor;
} plii_implicit_pass;

static inline size_t plii_implicit_vector_size(const pli_body* body) {
    return (size_t)body->node_count * sizeof(plii_dvec3);
}
static inline double plii_implicit_sum(const plii_implicit_system* system, plii_block_value_fn* value,
                                       const void* task) {
    return plii_sum_blocks(system->body->context, system->body->node_count, PLII_IMPLICIT_SUM_NODES, value, task);
}

/* m, since the start of the step. */
static inline plii_dvec3 plii_implicit_moved(const pli_body* body, int node) {
    return plii_dvec3_sub(plii_implicit_xyz(&body->positions[node]), plii_implicit_xyz(&body->previous[node]));
}

static inline plii_dvec3 plii_implicit_hold_mul(const plii_implicit_hold* hold, plii_dvec3 x) {
    const double along = plii_dvec3_dot(hold->along, x);
    return plii_dvec3_dot(hold->along, hold->along) > 0.0 ? plii_dvec3_scale(hold->along, hold->hardness * along)
                                                          : plii_dvec3_scale(x, hold->hardness);
}
/* sum += scale * what holds make of x. */
static inline void plii_implicit_add_holds(const plii_implicit_system* system, const plii_dvec3* x, double scale,
                                           plii_dvec3* sum) {
    for (PLII_EACH(const plii_implicit_hold, hold, system->holds.items, system->holds.count)) {
        sum[hold->node] = plii_dvec3_add_scaled(sum[hold->node], plii_implicit_hold_mul(hold, x[hold->node]), scale);
    }
}

/* All go on from the solution that is there if `is_warm`, and meet the constraints. */
/* `sweeps` after the start W_ii^-1 rhs. */
void plii_implicit_jacobi(plii_implicit_system* system, int sweeps, bool is_warm);
/* The same sweeps under Chebyshev weights, by the spectral radius. */
void plii_implicit_chebyshev(plii_implicit_system* system, int sweeps, bool is_warm);
/* Lower bound of the largest |eigenvalue| of 1 - D^-1 W by power iteration; overwrites the solution. */
double plii_implicit_spectral_radius(plii_implicit_system* system);
/* Until the residual is the tolerance of the first one, at most `iterations`; the report tells. */
void plii_implicit_conjugate_gradient(plii_implicit_system* system, int iterations, bool is_warm);
