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

/// Steps the body with this solver, or changes its settings. Forces stay in use; of pli_solver_settings so do
/// velocity_damping and time_scale. Links, angles and volumes are kept by the constraints below: until
/// pli_body_enable_xpbd_links, links keep no length and nodes fall one by one.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping or when the body has another solver already
PLI_API pli_status pli_body_enable_xpbd(pli_body* body, const pli_xpbd_def* def);

/// Returns to the position-based solver and to the links that the body had there; the constraints of this header go
/// too. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_disable_xpbd(pli_body* body);

// -------------------------------------------------------------------------------------------------- constraints
// Enable, or change when enabled; PLI_ERROR_WRONG_STATE while stepping and unless pli_body_enable_xpbd came before.

/// Lengths of the links.
typedef struct pli_xpbd_links_def {
    float compliance;         ///< m/N, 0 to PLI_MAX_COEFFICIENT, default 0 (rigid), of links whose material has
                              ///< linear_stiffness 1, else over that
    float bending_compliance; ///< m/N, default 0, the same for links made by pli_mesh_append_bending_links
    /// N s/m along each link, 0 to PLI_MAX_COEFFICIENT, default 0, of links whose material has linear_stiffness 1, else
    /// times that; none where the compliance is 0
    float damping;
    uint32_t cookie; ///< set by the default function
} pli_xpbd_links_def;

/// Defaults of the fields.
PLI_API pli_xpbd_links_def pli_xpbd_links_def_default(void);

/// Keeps links at their rest lengths, or changes how. Links of a closed surface of triangles with none or few others
/// inside take half of their error in a sweep at most, with some more inside two thirds, as such a surface would get
/// energy from sweeps; so do the parts of one that is cut, and links of bodies in which the masses of many neighbours
/// differ by more than 1 to 10. Rigid links may give energy to nodes that have eight or more and are not much heavier
/// than their neighbours, as the hub of a wheel: such nodes are to be heavier, or links to have a compliance
/// (docs/solvers.md).
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_links(pli_body* body, const pli_xpbd_links_def* def);

/// Lets links stretch freely. Nothing when not enabled.
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

/// Keeps the angles between faces with a common edge, or changes how. Rest angles are the present ones when first
/// enabled; cuts and refinement keep them, and parts of a face lie in its plane at rest. An angle takes two fifths of
/// its error in a sweep at most, as sheets would get energy from sweeps (docs/solvers.md): to be stiffer it needs more
/// substeps.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_bending(pli_body* body, const pli_xpbd_bending_def* def);

/// Lets faces fold freely. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_xpbd_bending(pli_body* body);

/// Keeps the volumes of the tetrahedra, at rest as they are when first enabled, or changes how. A body whose links get
/// other rest lengths is to have it disabled meanwhile: volumes that do not fit them are a fight without an end.
/// @param compliance m^5/N, 0 to PLI_MAX_COEFFICIENT
/// @return PLI_ERROR_INVALID_MESH for a body without tetrahedra, PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_tetras(pli_body* body, float compliance);

/// Lets tetrahedra change their volumes freely. Nothing when not enabled.
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

/// Keeps the volume inside the faces, or changes how; at rest as it is when first enabled. Of faces that are not
/// closed, as after a cut, it is that between them and node 0. A gas inside (pli_body_enable_pressure) then acts
/// through the compliance: none is felt where that is 0.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_WRONG_STATE without XPBD or while stepping
PLI_API pli_status pli_body_enable_xpbd_volume(pli_body* body, const pli_xpbd_volume_def* def);

/// Lets the volume inside the faces change freely. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_xpbd_volume(pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
