#ifndef PLIANT_LIMITS_H
#define PLIANT_LIMITS_H

/// The largest and smallest numbers that calls accept. Beyond them a call returns PLI_ERROR_INVALID_VALUE with a
/// message that names the value and the limit, and leaves everything as it was; NaN and infinity give
/// PLI_ERROR_NOT_FINITE. Vectors are measured by component. A body that a step would take beyond PLI_MAX_COORDINATE or
/// PLI_MAX_SPEED is put back and frozen (PLI_EVENT_BODY_FROZEN), a rigid body that it would give more speed keeps its
/// velocities (PLI_EVENT_RIGID_RESTORED). What follows from the limits for numbers in between: docs/architecture.md.

/// m: positions of nodes, points and rigid bodies, and all lengths: margins, thicknesses, sizes of shapes, rest
/// lengths, ends of rays, displacements. Floats are 6 cm apart there.
#define PLI_MAX_COORDINATE 1e6f
/// m/s: velocities, wind, recovery speeds.
#define PLI_MAX_SPEED 1e9f
/// rad/s: rigid bodies; what a joint's controller asks for is cut to this.
#define PLI_MAX_ANGULAR_SPEED 1e6f

/// kg: nodes that are not pinned, and dynamic rigid bodies. The mass of all nodes has no limit of its own.
#define PLI_MIN_MASS 1e-9f
#define PLI_MAX_MASS 1e12f
/// 1/(kg m^2): inverse inertia of rigid bodies.
#define PLI_MAX_INVERSE_INERTIA 1e18f

/// s: the length of a step, and how much shorter or longer it may be for one body (pli_solver_settings::time_scale).
#define PLI_MIN_TIME_STEP 1e-6f
#define PLI_MAX_TIME_STEP 1e3f
#define PLI_MIN_TIME_SCALE 1e-3f
#define PLI_MAX_TIME_SCALE 1e3f

/// m/s^2: gravity.
#define PLI_MAX_ACCELERATION 1e6f
/// N, or N s: forces, with all that was added to a node before, and impulses.
#define PLI_MAX_FORCE 1e30f

/// Stiffnesses, compliances, dampings, pressures and densities, in their units.
#define PLI_MAX_COEFFICIENT 1e12f
/// Numbers without a unit that have no range of their own: friction, lift, drag, factors, shares above 1.
#define PLI_MAX_FACTOR 1e6f
/// What the surface of pli_body_refine gives.
#define PLI_MAX_SURFACE_VALUE 1e30f
/// Share of its error that a link loses in an iteration, at least (pli_material::linear_stiffness).
#define PLI_MIN_STIFFNESS 1e-9f

#endif
