#pragma once

/* Anchors and contacts as conditions on the unknowns of the implicit system, and the rigid bodies behind them as
   further unknowns: six changes of velocity each. docs/solvers.md has the equations.

   Those of a node are met one node after the other, with the rigid body or exactly. Points of faces share their nodes:
   there an impulse grows by what is left of the error, from sweep to sweep. */

#include "body/body_impl.h"
#include "body/node_constraint.h"
#include "math/mass_sum.h"

static inline plii_dvec3 plii_implicit_xyz(const pli_vec4* v) {
    return plii_dvec3_from(plii_xyz(*v));
}

/* W_ii = L D L^T with unit lower L; all zero for pinned nodes, whose solution is thereby zero. */
typedef struct plii_implicit_block {
    double l10, l20, l21;
    double inverse_d[3];
} plii_implicit_block;

/* The Schur complements of a matrix that is at least mass * I are at least mass, which rounding may hide. `d`: xx, xy,
   xz, yy, yz, zz. */
static inline plii_implicit_block plii_implicit_factorise(const double d[6], double mass) {
    plii_implicit_block block;
    const double d0 = fmax(d[0], mass);
    block.l10 = d[1] / d0;
    block.l20 = d[2] / d0;
    const double d1 = fmax(d[3] - block.l10 * d[1], mass);
    const double s21 = d[4] - block.l20 * d[1];
    block.l21 = s21 / d1;
    const double d2 = fmax(d[5] - block.l20 * d[2] - block.l21 * s21, mass);
    block.inverse_d[0] = 1.0 / d0;
    block.inverse_d[1] = 1.0 / d1;
    block.inverse_d[2] = 1.0 / d2;
    return block;
}

static inline plii_dvec3 plii_implicit_block_solve(const plii_implicit_block* block, plii_dvec3 b) {
    const double y1 = b.y - block->l10 * b.x;
    const double y2 = b.z - block->l20 * b.x - block->l21 * y1;
    const double z = y2 * block->inverse_d[2];
    const double y = y1 * block->inverse_d[1] - block->l21 * z;
    const double x = b.x * block->inverse_d[0] - block->l10 * y - block->l20 * z;
    return plii_dvec3_make(x, y, z);
}

static inline bool plii_implicit_block_is_pinned(const plii_implicit_block* block) {
    return !(block->inverse_d[0] > 0.0);
}

/* W_ii x; the block must not be of a pinned node. */
static inline plii_dvec3 plii_implicit_block_mul(const plii_implicit_block* block, plii_dvec3 x) {
    const double z0 = (x.x + block->l10 * x.y + block->l20 * x.z) / block->inverse_d[0];
    const double z1 = (x.y + block->l21 * x.z) / block->inverse_d[1];
    const double z2 = x.z / block->inverse_d[2];
    return plii_dvec3_make(z0, block->l10 * z0 + z1, block->l20 * z0 + block->l21 * z1 + z2);
}
/* Of the stiffest direction, nearly; kg. */
static inline double plii_implicit_block_stiffness(const plii_implicit_block* block) {
    const double* d = block->inverse_d;
    return 1.0 / fmin(d[0], fmin(d[1], d[2]));
}

/* A rigid body that nodes are held by. */
typedef struct plii_implicit_rigid {
    pli_rigid* rigid;
    bool is_dynamic;
    double mass[3];       /* kg, by axis; what cannot move is very heavy */
    double inertia[3][3]; /* kg m^2 */
    double inverse_inertia[3][3];
    double own_inertia[3][3]; /* without what rights it */
    double change[6];         /* m/s, rad/s: what this body's system adds to the velocities */
    double before[6];         /* `change` where the system was linearised */
    double residual[6], direction[6], product[6], factor[6][6]; /* of conjugate gradients */
    bool is_solved;
    int group; /* PLI_NULL_INDEX unless it is dynamic and holds a node; while momentum is kept */
} plii_implicit_rigid;

typedef struct plii_implicit_constraint {
    int nodes[3]; /* one, or three of a face */
    double weights[3];
    int node_count, rigid;
    bool is_anchor, is_pinned;
    bool is_point; /* of a face */
    double influence, friction;
    plii_dvec3 normal;
    plii_dvec3 arm;    /* from the centre of mass of the rigid body */
    pli_vec3 local;    /* of an anchor, in the rigid body */
    plii_dvec3 target; /* m/s: change of the node's velocity that the condition asks for, but for the rigid's change */
    plii_dvec3 surface_velocity; /* m/s: of the target, what the rigid body does */
    double gap;                  /* m, of contacts */
    double squeeze;      /* N s: what another surface presses the node on this one by; 0: nothing, or it can yield */
    plii_dvec3 recovery; /* m/s: part of the target that takes back an error and is not to stay as speed */
    plii_dvec3
        goal_position;  /* m: where it wants the node at the end of the step, but for the change of the rigid body */
    plii_dvec3 impulse; /* N s on the node */
    pli_vec3* reported; /* where its impulse is to be added; NULL: nobody asks */
    int rows;           /* directions held: 0, 1 (normal) or 3 */
    plii_dvec3 impulse_before; /* when last looked at by conjugate gradients */
    int rows_before;
    bool is_viscous;  /* contacts of conjugate gradients: rows is 1, and across the normal is this, */
    double viscosity; /* kg: impulse per sliding */
    plii_dvec3 fall;  /* m/s: of `target`, what gravity gave to the node in this step */
    plii_implicit_block block;
    double share;                       /* of its node, as long as points of faces hold that too */
    double stiffness, stiffness_across; /* kg, of a point of a face: impulse per velocity, normal and tangential */
} plii_implicit_constraint;

typedef struct plii_implicit_constraints {
    plii_implicit_constraint* items; /* those of a node, by node; then points of faces */
    int node_bound_count, count, capacity;
    const plii_implicit_block* blocks; /* [node_count] of the system */
    double* loads;                     /* [node_count] how often a node is held, weighted */
    plii_node_constraint* listed;
    int listed_capacity;
    plii_implicit_rigid* rigids;
    int rigid_count, rigid_capacity;
} plii_implicit_constraints;

/* What the features of the body demand now. `base` is what the velocities of the body have in them of the solution
   already, or NULL. Without contacts only anchors are listed. */
void plii_implicit_constraints_gather(pli_body* body, plii_implicit_constraints* constraints, bool with_contacts,
                                      const plii_implicit_block* blocks, const plii_dvec3* base);
/* After the blocks have changed; arms of anchors go to where the solution leads. Contacts that are released, as sweeps
   leave them sliding, are as before a solution. */
void plii_implicit_constraints_update(const pli_body* body, plii_implicit_constraints* constraints, bool are_released);
/* Hands the changes to the rigid bodies. */
void plii_implicit_constraints_push_rigids(const pli_body* body, plii_implicit_constraints* constraints);
/* Tells those that ask what the solution has pushed them by. */
void plii_implicit_constraints_report(plii_implicit_constraints* constraints);
/* Takes back a node that others have moved off its anchor or into a surface, at the expense of both sides. */
void plii_implicit_constraint_reproject(pli_body* body, plii_implicit_constraints* constraints,
                                        plii_implicit_constraint* constraint);

/* The nearest solution to `x` that meets the conditions, in the norm of the diagonal blocks; then the rigid bodies. */
void plii_implicit_project(plii_implicit_constraints* constraints, plii_dvec3* x);
/* Only the node that has constraints begin .. end - 1, with the rigid bodies as they are. */
void plii_implicit_project_node(const plii_implicit_constraints* constraints, int begin, int end, plii_dvec3* x);
/* Its nodes follow an impulse, each on its own. */
void plii_implicit_push(const plii_implicit_constraints* constraints, const plii_implicit_constraint* constraint,
                        plii_dvec3 impulse, plii_dvec3* x);
/* Velocity that a constraint asks of its node. */
plii_dvec3 plii_implicit_constraint_goal(const plii_implicit_constraints* constraints,
                                         const plii_implicit_constraint* constraint);
/* 1/kg along a unit vector: of a point of a face, if all that hold its nodes push alike; pinned, of the rigid body. */
double plii_implicit_point_response(const plii_implicit_constraints* constraints,
                                    const plii_implicit_constraint* constraint, plii_dvec3 unit);
/* By what holds its nodes now: nodes of faces have several constraints, which bear what moves a node together. */
void plii_implicit_share_nodes(plii_implicit_constraints* constraints);

/* Change of the impulse of a constraint on its node by a motion between node and rigid body. */
typedef plii_dvec3 plii_implicit_response_fn(const plii_implicit_constraint* constraint, plii_dvec3 moved);
/* m += G^T K G: what the response gives to the block of the rigid body. */
void plii_implicit_add_response(const plii_implicit_constraint* constraint, plii_implicit_response_fn* response,
                                double m[6][6]);

/* Of its nodes; what is pinned does not move. */
static inline plii_dvec3 plii_implicit_constraint_point(const plii_implicit_constraint* constraint,
                                                        const plii_dvec3* x) {
    plii_dvec3 sum = {0};
    for (int k = 0; k < constraint->node_count && !constraint->is_pinned; ++k) {
        sum = plii_dvec3_add_scaled(sum, x[constraint->nodes[k]], constraint->weights[k]);
    }
    return sum;
}
static inline plii_dvec3 plii_implicit_point_change(const double q[6], plii_dvec3 arm) {
    return plii_dvec3_add(plii_dvec3_make(q[0], q[1], q[2]), plii_dvec3_cross(plii_dvec3_make(q[3], q[4], q[5]), arm));
}
static inline void plii_implicit_add_twist(double b[6], plii_dvec3 linear, plii_dvec3 angular, double sign) {
    const double v[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    for (int i = 0; i < 6; ++i) {
        b[i] += sign * v[i];
    }
}
/* b += G^T p: what an impulse at the point gives to the body. */
static inline void plii_implicit_add_push(double b[6], plii_dvec3 arm, plii_dvec3 p, double sign) {
    plii_implicit_add_twist(b, p, plii_dvec3_cross(arm, p), sign);
}
/* q += M^-1 G^T p. */
static inline void plii_implicit_add_velocity(const plii_implicit_rigid* rigid, plii_dvec3 arm, plii_dvec3 p,
                                              double q[6]) {
    double push[6] = {0};
    plii_implicit_add_push(push, arm, p, 1.0);
    for (int i = 0; i < 3; ++i) {
        q[i] += push[i] / rigid->mass[i];
        for (int k = 0; k < 3; ++k) {
            q[3 + i] += rigid->inverse_inertia[i][k] * push[3 + k];
        }
    }
}
/* sum = sign M q. */
static inline void plii_implicit_rigid_mul(const plii_implicit_rigid* rigid, const double q[6], double sign,
                                           double sum[6]) {
    for (int i = 0; i < 3; ++i) {
        const double* row = rigid->inertia[i];
        sum[i] = sign * (rigid->mass[i] * q[i]);
        sum[3 + i] = sign * (row[0] * q[3] + row[1] * q[4] + row[2] * q[5]);
    }
}
static inline void plii_implicit_rigid_matrix(const plii_implicit_rigid* rigid, double m[6][6]) {
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < 6; ++k) {
            m[i][k] = i < 3 && i == k ? rigid->mass[i] : i >= 3 && k >= 3 ? rigid->inertia[i - 3][k - 3] : 0.0;
        }
    }
}
