#ifndef PLIANT_XPBD_H
#define PLIANT_XPBD_H

/// Extended position-based dynamics (Macklin and others, "XPBD: Position-Based Simulation of Compliant Constrained
/// Dynamics"): constraints with a compliance, the inverse of a stiffness, that does not depend on the step or on
/// iterations. The solver knows no constraints by itself: each kind is enabled on its own, and what is not enabled
/// takes no time, no memory and no code. docs/solvers.md has the equations.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_xpbd_def {
    int substeps; ///< >= 1, default 10: parts of a step, each with contacts of the whole step
    int sweeps;   ///< >= 1, default 1: times that all constraints are solved in a substep
    uint32_t cookie;
} pli_xpbd_def;

PLI_API pli_xpbd_def pli_xpbd_def_default(void);
/// Steps the body with this solver, or changes its settings. Forces stay in use; of pli_solver_settings so do
/// velocity_damping and time_scale. Everything else comes with the constraints below.
/// @return PLI_ERROR_WRONG_STATE while stepping or when the body has another solver already, PLI_ERROR_INVALID_VALUE,
///         PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_enable_xpbd(pli_body* body, const pli_xpbd_def* def);
/// Returns to the position-based solver and to links on positions; the constraints go too. Nothing when not enabled.
PLI_API pli_status pli_body_disable_xpbd(pli_body* body);

// -------------------------------------------------------------------------------------------------- constraints
// Enable, or change when enabled; PLI_ERROR_WRONG_STATE unless pli_body_enable_xpbd came before. Compliances and
// dampings are 0 to PLI_MAX_COEFFICIENT, frictions 0 to PLI_MAX_FACTOR.

/// Lengths of the links.
typedef struct pli_xpbd_links_def {
    float compliance; ///< m/N, default 0 (rigid), of links whose material has linear_stiffness 1, else over that
    float bending_compliance; ///< m/N, default 0, the same for links made by pli_mesh_append_bending_links
    /// N s/m along each link, >= 0, default 0, of links whose material has linear_stiffness 1, else times that; none
    /// where the compliance is 0
    float damping;
    uint32_t cookie;
} pli_xpbd_links_def;

PLI_API pli_xpbd_links_def pli_xpbd_links_def_default(void);
PLI_API pli_status pli_body_enable_xpbd_links(pli_body* body, const pli_xpbd_links_def* def);
PLI_API pli_status pli_body_disable_xpbd_links(pli_body* body);

/// Angles between faces with a common edge. Rest angles are the present ones; a cut or refined body takes them anew.
typedef struct pli_xpbd_bending_def {
    float compliance; ///< rad/(N m), default 0
    float damping;    ///< N m s/rad, >= 0, default 0
    bool is_flat;     ///< all rest angles are zero, default false
    uint32_t cookie;
} pli_xpbd_bending_def;

PLI_API pli_xpbd_bending_def pli_xpbd_bending_def_default(void);
/// @return PLI_ERROR_INVALID_MESH for a body without faces
PLI_API pli_status pli_body_enable_xpbd_bending(pli_body* body, const pli_xpbd_bending_def* def);
PLI_API pli_status pli_body_disable_xpbd_bending(pli_body* body);

/// Volumes of the tetrahedra, at rest as they are now.
/// @param compliance m^5/N
/// @return PLI_ERROR_INVALID_MESH for a body without tetrahedra
PLI_API pli_status pli_body_enable_xpbd_tetras(pli_body* body, float compliance);
PLI_API pli_status pli_body_disable_xpbd_tetras(pli_body* body);

/// Volume inside the faces, which must be closed; at rest as it is when first enabled.
/// @param compliance     m^5/N
/// @param pressure_ratio wanted volume over the volume at rest, >= 0
/// @return PLI_ERROR_INVALID_MESH for a body without faces
PLI_API pli_status pli_body_enable_xpbd_volume(pli_body* body, float compliance, float pressure_ratio);
PLI_API pli_status pli_body_disable_xpbd_volume(pli_body* body);

/// Holds the anchors of anchor.h, both ways.
/// @param compliance m/N
PLI_API pli_status pli_body_enable_xpbd_anchors(pli_body* body, float compliance);
PLI_API pli_status pli_body_disable_xpbd_anchors(pli_body* body);

typedef struct pli_xpbd_contacts_def {
    float compliance;     ///< m/N, default 0
    float friction;       ///< Coulomb's coefficient, >= 0, default 0.5; multiplied with that of a rigid body
    float recovery_speed; ///< m/s, >= 0, default 1: how fast a penetration at the start of a substep is removed at most
    uint32_t cookie;
} pli_xpbd_contacts_def;

PLI_API pli_xpbd_contacts_def pli_xpbd_contacts_def_default(void);
/// Solves the contacts that pli_body_enable_rigid_contacts finds, both ways.
PLI_API pli_status pli_body_enable_xpbd_rigid_contacts(pli_body* body, const pli_xpbd_contacts_def* def);
PLI_API pli_status pli_body_disable_xpbd_rigid_contacts(pli_body* body);
/// Solves the contacts of this body's nodes with the faces of others that pli_body_enable_soft_contacts finds, both
/// ways.
PLI_API pli_status pli_body_enable_xpbd_soft_contacts(pli_body* body, const pli_xpbd_contacts_def* def);
PLI_API pli_status pli_body_disable_xpbd_soft_contacts(pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
