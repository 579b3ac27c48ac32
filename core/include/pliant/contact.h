#ifndef PLIANT_CONTACT_H
#define PLIANT_CONTACT_H

/// Contacts of nodes and faces with rigid bodies, and of nodes with the faces of other soft bodies. Contacts live for
/// one step. Those of a body that is frozen or asleep are from the last step that it took part in.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

// ------------------------------------------------------------------------------- nodes against rigid bodies

/// How nodes meet rigid bodies.
typedef struct pli_rigid_contacts_def {
    /// 0 to PLI_MAX_FACTOR, default 0.2: Coulomb's coefficient, multiplied by the rigid body's. In reference mode the
    /// share of the sliding that a contact takes away, where, as in Bullet, a product above 1 reverses the sliding.
    /// Bullet name: kDF
    float friction;
    /// [0, 1], default 1: share of the penetration by dynamic bodies that the implicit solver removes per step, and
    /// reference mode per iteration. The other solvers have `compliance` instead. Bullet name: kCHR
    float dynamic_hardness;
    float static_hardness; ///< [0, 1], default 0.1: the same for static and kinematic bodies. Bullet name: kKHR
    /// m/N, 0 to PLI_MAX_COEFFICIENT, default 0 (rigid). Position-based solver and XPBD, not in reference mode
    float compliance;
    /// m/s, 0 to PLI_MAX_SPEED: the most by which a penetration that was there before the step (XPBD: the substep) is
    /// removed; it leaves no velocity. 0 (default): 1 m/s. Not in reference mode, which has the hardnesses alone.
    float recovery_speed;
    uint32_t cookie; ///< set by the default function
} pli_rigid_contacts_def;

/// Defaults of the fields.
PLI_API pli_rigid_contacts_def pli_rigid_contacts_def_default(void);

/// Keeps nodes out of the shapes of rigid bodies, by signed distances, with any solver; rigid bodies are pushed too.
/// Called again, it changes the settings. Bullet name: SDF_RS
/// @param def NULL for the defaults; copied
PLI_API pli_status pli_body_enable_rigid_contacts(pli_body* body, const pli_rigid_contacts_def* def);

/// Ends contacts of nodes with rigid bodies, also those of the step in progress. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_rigid_contacts(pli_body* body);

/// A node that touches a rigid body, or may come to touch it in the step. contact_events.h reports those that push.
typedef struct pli_rigid_contact {
    int node;         ///< of the body
    pli_rigid* rigid; ///< what it touches
    int shape;        ///< index in the rigid body's shapes
    pli_vec3 normal;  ///< unit, world, out of the rigid body
    /// m, minus the collision margin, at the predicted position. Always < 0 with the position-based solver in reference
    /// mode; else up to the margin, and up to twice the margin where the rigid body may move
    float distance;
} pli_rigid_contact;

/// Contacts of the step in progress, or of the last one, in the order of solving.
/// @param contacts NULL, or room for `capacity` contacts
/// @return the number of contacts, 0 when not enabled
PLI_API int pli_body_get_rigid_contacts(const pli_body* body, int capacity, pli_rigid_contact* contacts);

// ------------------------------------------------------------------------------- faces against rigid bodies

/// How faces meet rigid bodies.
typedef struct pli_rigid_face_contacts_def {
    float friction; ///< 0 to PLI_MAX_FACTOR, default 0.2; as in pli_rigid_contacts_def
    /// [0, 1], default 1: share of a penetration that a step removes, for dynamic bodies; at 1 m/s at most where the
    /// face was on no side of the body before, as when a body is put into cloth
    float dynamic_hardness;
    float static_hardness; ///< [0, 1], default 0.1: the same for static and kinematic bodies
    uint32_t cookie;       ///< set by the default function
} pli_rigid_face_contacts_def;

/// Defaults of the fields.
PLI_API pli_rigid_face_contacts_def pli_rigid_face_contacts_def_default(void);

/// Keeps faces out of convex rigid shapes, and of the triangles of triangle meshes from their front, on their whole way
/// through a step. So corners, edges and small bodies pass neither between nodes nor, when fast, from one step to the
/// next. In bodies without faces it does so for links, except bending links. Called again, it changes the settings.
/// btSoftBody has no such contact.
///
/// A face remembers from step to step on which side of a shape it was. If it overlaps nevertheless, because the host
/// has moved the rigid body, it is pushed back to that side.
///
/// Use it beside pli_body_enable_rigid_contacts, which handles planes and sampled meshes, and brings nodes out of
/// triangle meshes. Faces with a node that is anchored to the rigid body are left out, and so are drift iterations. If
/// a face lies between two bodies that cannot move and are closer than the margins on both sides of it, the body that
/// was made first keeps its margin. See pli_rigid_get_shift.
/// @param def NULL for the defaults; copied
PLI_API pli_status pli_body_enable_rigid_face_contacts(pli_body* body, const pli_rigid_face_contacts_def* def);

/// Ends contacts of faces with rigid bodies, also those of the step in progress. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_rigid_face_contacts(pli_body* body);

/// A face, or a link, that touches a rigid body or comes near it.
typedef struct pli_rigid_face_contact {
    int face;         ///< or PLI_NULL_INDEX
    int link;         ///< of a body without faces, or PLI_NULL_INDEX
    float weights[3]; ///< barycentric, of the contact point; for a link the first two
    pli_rigid* rigid; ///< what it touches
    int shape;        ///< index in the rigid body's shapes
    pli_vec3 normal;  ///< unit, world, out of the rigid body
    float distance;   ///< m, minus the collision margin, at the predicted positions; < 0 on the other side
} pli_rigid_face_contact;

/// Contacts of the step in progress, or of the last one, including those where face and body only come near each other.
/// @param contacts NULL, or room for `capacity` contacts
/// @return the number of contacts, 0 when not enabled
PLI_API int pli_body_get_rigid_face_contacts(const pli_body* body, int capacity, pli_rigid_face_contact* contacts);

// ----------------------------------------------------------------------------------------------------- restitution

/// Makes nodes and faces bounce off rigid bodies, with any solver: they leave with a share of the speed along the
/// normal with which they came, and so does the rigid body. The share is this restitution times that of the rigid body.
/// It counts from the speed on that gravity gives in two steps. Without restitution contacts take the speed away, as in
/// btSoftBody. Source: Müller and others, "Detailed Rigid Body Simulation with Extended Position Based Dynamics",
/// section 3.6.
/// @param restitution 0 to 1
/// Cost: two passes over the contacts per step, 4 B per contact.
PLI_API pli_status pli_body_enable_restitution(pli_body* body, float restitution);

/// Ends restitution. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_restitution(pli_body* body);

// ----------------------------------------------------------------- nodes against faces of other soft bodies

/// How soft bodies meet each other.
typedef struct pli_soft_contacts_def {
    /// 0 to PLI_MAX_FACTOR, default 0.2: Coulomb's coefficient; the larger one of the two bodies counts. With
    /// `bullet_boxes` the share of the sliding that a contact takes away. Bullet name: kDF
    float friction;
    /// [0, 1], default 1: share of the overlap removed per sweep; the smaller one of the two bodies counts, with
    /// `bullet_boxes` each body's own. Bullet name: kSHR
    float hardness;
    float compliance; ///< m/N, 0 to PLI_MAX_COEFFICIENT, default 0 (rigid), of own nodes. Not with `bullet_boxes`
    /// m/s, 0 to PLI_MAX_SPEED: the most by which an overlap that was there before the step (XPBD: the substep) is
    /// removed, a fifth of it in 1/60 s; it leaves no velocity. 0 (default): 1 m/s. With `bullet_boxes` 0 removes it at
    /// once and leaves its depth per step as a velocity, as btSoftBody does.
    float recovery_speed;
    /// Reference mode only. True: keep Bullet's fat boxes from step to step and search with them, so that the same
    /// pairs are found as by btSoftBody, and meet rigid shapes as with pli_body_enable_bullet_node_boxes. Default
    /// false: search with boxes that cover the whole reach of a contact.
    bool bullet_boxes;
    uint32_t cookie; ///< set by the default function
} pli_soft_contacts_def;

/// Defaults of the fields.
PLI_API pli_soft_contacts_def pli_soft_contacts_def_default(void);

/// Keeps nodes of this body away from the faces of other bodies that have this enabled too, with any solver; both
/// bodies are pushed. Called again, it changes the settings. Bullet name: VF_SS
/// @param def NULL for the defaults; copied
PLI_API pli_status pli_body_enable_soft_contacts(pli_body* body, const pli_soft_contacts_def* def);

/// Ends contacts with other soft bodies, also those of the step in progress. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_soft_contacts(pli_body* body);

/// A node that touches a face of another soft body.
typedef struct pli_soft_contact {
    int node;            ///< of this body
    pli_body* face_body; ///< the other body
    int face;            ///< of the other body
    float weights[3];    ///< barycentric, of the nearest point of the face
    pli_vec3 normal;     ///< unit, from the face to the node
    float margin;        ///< m, distance that the contact keeps; less, or negative, while bodies part that overlap
} pli_soft_contact;

/// Contacts of this body's nodes in the step in progress, or in the last one. Contacts of its faces are in the lists of
/// the other bodies. After a step that solved them no node has more than four with all bodies together, unless
/// `bullet_boxes` is set.
/// @param contacts NULL, or room for `capacity` contacts
/// @return the number of contacts, 0 when not enabled
PLI_API int pli_body_get_soft_contacts(const pli_body* body, int capacity, pli_soft_contact* contacts);

#ifdef __cplusplus
}
#endif
#endif
