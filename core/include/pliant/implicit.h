#ifndef PLIANT_IMPLICIT_H
#define PLIANT_IMPLICIT_H

/// Implicit mass-spring solver: links are springs with a stiffness in N/m, integrated by backward Euler. The linear
/// system of a step is solved by Jacobi sweeps (Kang, "Efficient Methods for Cloth Animation and Collision Handling"),
/// which are stable for every stiffness, mass and step, or to a tolerance by conjugate gradients. docs/solvers.md has
/// the equations.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How the linear system of a step is solved.
typedef enum pli_implicit_method {
    /// A fixed number of Jacobi sweeps: the cheapest, always stable, softer than asked for with few sweeps. For some
    /// hundred nodes: with five sweeps and 1000 N/m a cloth of 1 kg, hung up by its corners, is stretched by 0.6 if it
    /// has 21x21 nodes, and by 11 if it has 41x41, with 10 `finishing_iterations` by 0.25.
    PLI_IMPLICIT_JACOBI = 0,
    /// Jacobi sweeps with Chebyshev weights: fewer sweeps for the same error. For stiff meshes with ten sweeps or more.
    PLI_IMPLICIT_CHEBYSHEV = 1,
    /// Until `tolerance` is met or `sweeps` are done. For materials whose stiffness has to be the one that is set.
    PLI_IMPLICIT_CONJUGATE_GRADIENT = 2
} pli_implicit_method;

/// What the sweeps start from. It takes many of them to carry a change through a stiff mesh.
typedef enum pli_implicit_start {
    /// The velocities of nodes without springs: a free body falls with exactly g. The usual choice.
    PLI_IMPLICIT_START_IN_FREE_FLIGHT = 0,
    /// At rest, as in the paper: a stiff body falls too slowly. To compare with published results.
    PLI_IMPLICIT_START_AT_REST = 1
} pli_implicit_start;

/// Material and solver of an implicit body.
typedef struct pli_implicit_def {
    float stiffness; ///< N/m, 0 to PLI_MAX_COEFFICIENT, default 1000; times the linear_stiffness of the link's
                     ///< material
    float damping;   ///< N s/m along each link, 0 to PLI_MAX_COEFFICIENT, default 0; likewise
    /// >= 1, default 5. Take an odd number: with an even one the change of velocity of the stiffest modes is up to
    /// twice too large.
    int sweeps;
    /// >= 0, default 0: iterations of conjugate gradients that follow when sweeps would end a step with more energy
    /// than it had, because they are too few for the springs or their rotation. The springs are then linearised anew
    /// and solved to `tolerance`, up to 16 times per step. Steps that sweeps can solve cost one pass over the links
    /// more.
    int finishing_iterations;
    pli_implicit_method method; ///< default PLI_IMPLICIT_JACOBI
    pli_implicit_start start;   ///< default PLI_IMPLICIT_START_IN_FREE_FLIGHT
    float tolerance;            ///< (0, 1), default 1e-4: residual relative to the first one, conjugate gradients only
    /// True: compressed springs resist being turned. Across themselves they have the absolute value of their stiffness
    /// there, |1 - rest length / length| of it, 1 at most. From 3 sweeps on. Default false: they have none, as in the
    /// paper, except where a spring far stiffer than m / h^2 would burst sideways; springs that buckle may then
    /// flutter, as in soft bodies that lie on each other under sweeps. Source: Chen and others, "Stabler Neo-Hookean
    /// Simulation: Absolute Eigenvalue Filtering for Projected Newton"
    bool filter_compression;
    uint32_t cookie; ///< set by the default function
} pli_implicit_def;

/// Defaults of the fields.
PLI_API pli_implicit_def pli_implicit_def_default(void);

/// Steps the body with this solver, or changes its settings. Forces, anchors, contacts and pose matching stay in use.
/// Anchors and contacts with rigid bodies are solved together with the springs, and push rigid bodies too. Of
/// pli_solver_settings position_iterations (for everything else), velocity_damping and time_scale stay in use.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping or when the body has another solver already
PLI_API pli_status pli_body_enable_implicit(pli_body* body, const pli_implicit_def* def);

/// Returns to the position-based solver and to the links that the body had there. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_disable_implicit(pli_body* body);

/// How the last step went.
typedef struct pli_implicit_report {
    int iterations;        ///< sweeps, or iterations of conjugate gradients
    float residual;        ///< relative to the first one; conjugate gradients only, else 0
    float spectral_radius; ///< estimated, of the Jacobi iteration; Chebyshev weights only, else 0
    int collapsed_links;   ///< springs without length, hence without direction, that were left out
} pli_implicit_report;

/// Report of the last step, all zero before the first one and when not enabled.
PLI_API pli_implicit_report pli_body_get_implicit_report(const pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
