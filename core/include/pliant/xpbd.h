#ifndef PLIANT_XPBD_H
#define PLIANT_XPBD_H

/// Extended position-based dynamics (Macklin and others, "XPBD: Position-Based Simulation of Compliant Constrained
/// Dynamics"): constraints with a compliance, the inverse of a stiffness, that does not depend on the step or on
/// iterations. The solver knows no constraints by itself: each kind is enabled on its own, and what is not enabled
/// takes no time, no memory and no code. Anchors, contacts, self-collision and tethers are those of the body, enabled
/// once for any solver, before or after this one. docs/solvers.md has the equations.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How often constraints are solved.
typedef struct pli_xpbd_def {
    int substeps;    ///< >= 1, default 10: parts of a step, each with contacts of the whole step
    int sweeps;      ///< >= 1, default 1: times that all constraints are solved in a substep
    uint32_t cookie; ///< set by the default function
} pli_xpbd_def;

/// Defaults of the fields.
PLI_API pli_xpbd_def pli_xpbd_def_default(void);

/// Steps the body with this solver, or changes its settings. Forces stay in use, and of pli_solver_settings
/// velocity_damping and time_scale. Links, angles and volumes are kept by the constraints below: until
/// pli_body_enable_xpbd_links is called links keep no length, and nodes fall one by one.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping or when the body has another solver already
PLI_API pli_status pli_body_enable_xpbd(pli_body* body, const pli_xpbd_def* def);

/// Returns to the position-based solver and to the links that the body had there; the constraints of this header go
/// too. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_disable_xpbd(pli_body* body);

// -------------------------------------------------------------------------------------------------- constraints
// Called again, they change the settings. PLI_ERROR_WRONG_STATE while stepping and unless pli_body_enable_xpbd came
// before.

/// Lengths of the links.
typedef struct pli_xpbd_links_def {
    float compliance;         ///< m/N, 0 to PLI_MAX_COEFFICIENT, default 0 (rigid); divided by the linear_stiffness
                              ///< of the link's material
    float bending_compliance; ///< m/N, default 0: the same for links made by pli_mesh_append_bending_links
    /// N s/m along each link, 0 to PLI_MAX_COEFFICIENT, default 0; times the linear_stiffness of the link's material.
    /// No effect where the compliance is 0
    float damping;
    uint32_t cookie; ///< set by the default function
} pli_xpbd_links_def;

/// Defaults of the fields.
PLI_API pli_xpbd_links_def pli_xpbd_links_def_default(void);

/// Keeps links at their rest lengths. Called again, it changes the settings. Sweeps can feed energy into some meshes
/// (docs/solvers.md), so
/// - links of a closed surface of triangles, also after a cut, lose at most half of their error in a sweep if there are
///   no or few links inside, and at most two thirds if there are some more;
/// - links of bodies in which the masses of many neighbours differ by more than 1 to 10 lose at most two thirds;
/// - a node with eight or more rigid links that is not much heavier than its neighbours, as the hub of a wheel, may
///   still get energy: make it heavier, or give its links some compliance.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_links(pli_body* body, const pli_xpbd_links_def* def);

/// Lets links stretch freely. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_xpbd_links(pli_body* body);

/// Angles between faces.
typedef struct pli_xpbd_bending_def {
    float compliance; ///< rad/(N m), 0 to PLI_MAX_COEFFICIENT, default 0 (rigid)
    float damping;    ///< N m s/rad, 0 to PLI_MAX_COEFFICIENT, default 0
    bool is_flat;     ///< default false; true: all rest angles are zero
    uint32_t cookie;  ///< set by the default function
} pli_xpbd_bending_def;

/// Defaults of the fields.
PLI_API pli_xpbd_bending_def pli_xpbd_bending_def_default(void);

/// Keeps the angles between faces with a common edge. Called again, it changes the settings. Rest angles are those at
/// the time when it was first enabled; cuts and refinement keep them, and parts of a face lie in its plane at rest. An
/// angle loses at most two fifths of its error in a sweep, since sheets would otherwise get energy from sweeps
/// (docs/solvers.md). If it has to be stiffer, use more substeps.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_bending(pli_body* body, const pli_xpbd_bending_def* def);

/// Lets faces fold freely. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_xpbd_bending(pli_body* body);

/// Keeps the volumes of the tetrahedra as they were when it was first enabled. Called again, it changes the compliance.
/// Disable it while rest lengths of links change: volumes that do not fit them pull against them for ever.
/// @param compliance m^5/N, 0 to PLI_MAX_COEFFICIENT
/// @return PLI_ERROR_INVALID_MESH for a body without tetrahedra, PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_tetras(pli_body* body, float compliance);

/// Lets tetrahedra change their volumes freely. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_xpbd_tetras(pli_body* body);

/// Volume inside the faces.
typedef struct pli_xpbd_volume_def {
    float compliance;     ///< m^5/N, 0 to PLI_MAX_COEFFICIENT, default 0 (rigid)
    float pressure_ratio; ///< 0 to PLI_MAX_FACTOR, default 1: wanted volume over the volume at rest
    uint32_t cookie;      ///< set by the default function
} pli_xpbd_volume_def;

/// Defaults of the fields.
PLI_API pli_xpbd_volume_def pli_xpbd_volume_def_default(void);

/// Keeps the volume inside the faces as it was when it was first enabled. Called again, it changes the settings. If the
/// faces are not closed, as after a cut, the volume between them and node 0 counts. A gas inside
/// (pli_body_enable_pressure) then acts through the compliance, and has no effect where that is 0.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_volume(pli_body* body, const pli_xpbd_volume_def* def);

/// Lets the volume inside the faces change freely. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_xpbd_volume(pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
