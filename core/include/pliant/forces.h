#ifndef PLIANT_FORCES_H
#define PLIANT_FORCES_H

/// Forces on soft bodies: aerodynamics, pressure, conservation of volume. Air acts on the normals of the start of the
/// step and on areas taken when the feature is enabled, pressure and volume on the faces as they are at the start of
/// the step. In reference mode (pli_world_def) these, too, act on normals and first areas of nodes, the mean of twice
/// the areas of their faces, as in btSoftBody, and such forces do not quite sum up to zero.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How air acts on a body, in Bullet's order (btSoftBody::eAeroModel). Let v be the velocity against the wind, n the
/// normal, rho the density of the air (pli_world_def) and A the area of a face or the mean area of a node's faces.
/// The one- and two-sided models push with -rho A (v.n) |v|^2 (lift n + drag v/|v|) on what moves into the air, faces
/// with twice that; these are not the coefficients of the drag equation, but to be tried out. The lift-drag models have
/// a drag of rho A |v| (v.n) drag / 2 against v, and lift across it, none where v is within 10 degrees of the normal.
/// Drag never does more than stop a node within the step, and air never makes a node faster than it was against the
/// wind: where a step is too long for the force, the rest turns its velocity; a node at rest in the air stays so. Under
/// XPBD air changes velocities at the start of the step, not substep by substep. Not in reference mode (pli_world_def),
/// in which large coefficients, light nodes and long steps blow bodies up.
typedef enum pli_aero_model {
    /// As VERTEX_ONE_SIDED, here and in btSoftBody. Choose that one; this is for scenes that come from Bullet.
    PLI_AERO_VERTEX_POINT = 0,
    /// On nodes, whichever side is in front: flags, capes and other cloth whose nodes are many. The usual choice.
    PLI_AERO_VERTEX_TWO_SIDED = 1,
    /// On nodes, with lift and drag apart: what glides, as paper and leaves.
    PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG = 2,
    /// On nodes whose normal points into the motion: closed bodies, of which the lee side feels nothing.
    PLI_AERO_VERTEX_ONE_SIDED = 3,
    /// On faces, whichever side is in front: cloth of few, large faces. Costs more than the same on nodes.
    PLI_AERO_FACE_TWO_SIDED = 4,
    /// On faces, with lift and drag apart: wings and sails of few, large faces.
    PLI_AERO_FACE_TWO_SIDED_LIFT_DRAG = 5,
    /// On faces whose normal points into the motion: closed bodies of few, large faces.
    PLI_AERO_FACE_ONE_SIDED = 6
} pli_aero_model;

/// Air around a body.
typedef struct pli_aero_def {
    pli_aero_model model; ///< default PLI_AERO_VERTEX_POINT
    float lift;           ///< 0 to PLI_MAX_FACTOR, default 0; s/m in the simple models. Bullet name: kLF
    float drag;           ///< 0 to PLI_MAX_FACTOR, default 0; s/m in the simple models. Bullet name: kDG
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

/// Ends aerodynamics. Nothing when not enabled.
PLI_API pli_status pli_body_disable_aero(pli_body* body);

/// Gas inside a closed surface, or another amount of it: faces feel a pressure of coefficient / |volume|. No
/// force while the volume is zero (Bullet divides by it). Cut to what would change the volume of a free body by a
/// quarter within the step, and of a flat one by no more than a quarter of what it was when the gas was let in, as
/// light nodes, high pressures and long steps ask for more than can be integrated; not in reference mode
/// (pli_world_def). With pli_body_enable_xpbd_volume the gas is part of that constraint: it widens the
/// wanted volume by compliance * coefficient / |volume|, at the same pace at most; that carries more than the forces
/// can, which are cut at 60 Hz to what some hundred Pa do to a ball of 2 kg. A cut that opens a closed surface lets the
/// gas out, as a coefficient of 0 does, until the next call; not in reference mode.
/// @param coefficient N m, of either sign, up to PLI_MAX_COEFFICIENT. Bullet name: kPR
/// @return PLI_ERROR_INVALID_MESH for a body without faces
PLI_API pli_status pli_body_enable_pressure(pli_body* body, float coefficient);

/// Lets the gas out. Nothing when not enabled.
PLI_API pli_status pli_body_disable_pressure(pli_body* body);

/// A force towards the rest volume: a pressure of (rest volume - volume) * coefficient, cut to twice
/// what would bring the volume back within the step, and to a change by a quarter of the rest volume (not in reference
/// mode). Under XPBD, where it acts all through the step, by the volume that velocities lead to in the middle of it.
/// The rest volume is that at the first call; later calls change the coefficient alone. A cut ends it as it lets a gas
/// out.
/// @param coefficient N/m^5, 0 to PLI_MAX_COEFFICIENT. Bullet name: kVC with setPose(true, false)
/// @return PLI_ERROR_INVALID_MESH for a body without faces
PLI_API pli_status pli_body_enable_volume_conservation(pli_body* body, float coefficient);

/// Ends conservation of volume, and forgets the rest volume. Nothing when not enabled.
PLI_API pli_status pli_body_disable_volume_conservation(pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
