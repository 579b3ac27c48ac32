#ifndef PLIANT_FORCES_H
#define PLIANT_FORCES_H

/// Forces on soft bodies: aerodynamics, pressure, conservation of volume. Air uses the normals at the start of the step
/// and the areas at the time when the feature was enabled; pressure and volume use the faces at the start of the step.
/// In reference mode (pli_world_def) pressure and volume, too, use normals and first areas of nodes (the mean of twice
/// the areas of their faces), as in btSoftBody; such forces do not quite sum up to zero.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How air acts on a body, in Bullet's order (btSoftBody::eAeroModel). Let v be the velocity relative to the wind, n
/// the normal, rho the density of the air (pli_world_def) and A the area of a face, or the mean area of a node's faces.
/// - The one- and two-sided models push with -rho A (v.n) |v|^2 (lift n + drag v/|v|) on nodes that move into the air,
///   and with twice that on faces. These are not the coefficients of the drag equation; find them by trial.
/// - The lift-drag models have a drag of rho A |v| (v.n) drag / 2 against v, and a lift of rho A |v| lift / 2 times the
///   squared sine of the angle between v and n, across v and away from n; none where that angle is below 10 degrees.
///
/// Drag at most stops a node within the step, and air never makes a node faster than it was relative to the wind: where
/// a step is too long for the force, the rest turns the velocity. A node at rest in the air stays at rest. Under XPBD
/// air changes velocities at the start of the step, not substep by substep. Reference mode (pli_world_def) has none of
/// these limits: there large coefficients, light nodes and long steps blow bodies up.
typedef enum pli_aero_model {
    /// The same as VERTEX_ONE_SIDED, as in btSoftBody. For scenes that come from Bullet; else choose that one.
    PLI_AERO_VERTEX_POINT = 0,
    /// On nodes, whichever side is in front: flags, capes and other cloth with many nodes. The usual choice.
    PLI_AERO_VERTEX_TWO_SIDED = 1,
    /// On nodes, with separate lift and drag: things that glide, as paper and leaves.
    PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG = 2,
    /// On nodes whose normal points into the motion: closed bodies, whose lee side feels nothing.
    PLI_AERO_VERTEX_ONE_SIDED = 3,
    /// On faces, whichever side is in front: cloth with few, large faces. Costs more than the same on nodes.
    PLI_AERO_FACE_TWO_SIDED = 4,
    /// On faces, with separate lift and drag: wings and sails with few, large faces.
    PLI_AERO_FACE_TWO_SIDED_LIFT_DRAG = 5,
    /// On faces whose normal points into the motion: closed bodies of few, large faces.
    PLI_AERO_FACE_ONE_SIDED = 6
} pli_aero_model;

/// Air around a body.
typedef struct pli_aero_def {
    pli_aero_model model; ///< default PLI_AERO_VERTEX_POINT
    float lift;           ///< 0 to PLI_MAX_FACTOR, default 0; s/m, in the lift-drag models m/s. Bullet name: kLF
    float drag;           ///< 0 to PLI_MAX_FACTOR, default 0; s/m, in the lift-drag models 1. Bullet name: kDG
    pli_vec3 wind;        ///< m/s, up to PLI_MAX_SPEED, default zero
    uint32_t cookie;      ///< set by the default function
} pli_aero_def;

/// Defaults of the fields; without lift or drag there is no force.
PLI_API pli_aero_def pli_aero_def_default(void);

/// Lets air act on a body, or changes how. Bullet: addAeroForceToNode, addAeroForceToFace
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces
/// Cost: 12 B per node with the models of faces.
PLI_API pli_status pli_body_enable_aero(pli_body* body, const pli_aero_def* def);

/// Changes the wind alone. Bullet name: setWindVelocity
/// @param wind m/s, up to PLI_MAX_SPEED
/// @return PLI_ERROR_WRONG_STATE when aerodynamics are not enabled
PLI_API pli_status pli_body_set_wind(pli_body* body, pli_vec3 wind);

/// Ends aerodynamics. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_aero(pli_body* body);

/// Puts gas inside a closed surface, or changes its amount: faces feel a pressure of coefficient / |volume|.
/// - There is no force while the volume is zero (Bullet divides by it).
/// - Light nodes, high pressures and long steps would need larger forces than can be integrated. So the force is
///   limited to what changes the volume of a free body by a quarter within the step, and that of a flat one by a
///   quarter of what it was when the gas was put in. At 60 Hz some hundred Pa in a ball of 2 kg are the most. Not in
///   reference mode (pli_world_def).
/// - With pli_body_enable_xpbd_volume the gas is part of that constraint: it widens the wanted volume by compliance *
///   coefficient / |volume|, at the same pace at most, and can carry more than the force.
/// - A cut that opens the surface lets the gas out until the next call. Not in reference mode.
/// @param coefficient N m, of either sign, up to PLI_MAX_COEFFICIENT. Bullet name: kPR
/// @return PLI_ERROR_INVALID_MESH for a body without faces
PLI_API pli_status pli_body_enable_pressure(pli_body* body, float coefficient);

/// Ends pressure. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_pressure(pli_body* body);

/// Pushes a closed surface towards its rest volume, by a pressure of (rest volume - volume) * coefficient.
/// - The rest volume is that at the first call; later calls only change the coefficient.
/// - The force is limited to twice what would bring the volume back within the step, and to a change by a quarter of
///   the rest volume. Not in reference mode.
/// - Under XPBD it acts all through the step, by the volume to which velocities lead in the middle of the step.
/// - A cut that opens the surface ends it.
/// @param coefficient N/m^5, 0 to PLI_MAX_COEFFICIENT. Bullet name: kVC with setPose(true, false)
/// @return PLI_ERROR_INVALID_MESH for a body without faces
PLI_API pli_status pli_body_enable_volume_conservation(pli_body* body, float coefficient);

/// Ends conservation of volume, and forgets the rest volume. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_volume_conservation(pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
