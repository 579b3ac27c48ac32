#ifndef PLIANT_BULLET_IMPORT_H
#define PLIANT_BULLET_IMPORT_H

/// From btSoftBody to Pliant, for games that move scene by scene. Only programs that call these functions link
/// BulletSoftBody.

#include "pliant_bullet.h"

#include <vector>

class btSoftBody;

namespace pliant {

/// An anchor of a btSoftBody.
struct ImportedAnchor {
    int node;             ///< of the mesh
    btRigidBody* body;    ///< that it holds to
    pli_vec3 local_pivot; ///< m, in the frame of the rigid body
    float influence;      ///< as pli_anchor_def::influence
};

/// What a btSoftBody holds beyond its mesh. Not imported: clusters, joints, notes and user data.
struct ImportedBody {
    pli_body_def def;                        ///< margin and solver settings
    std::vector<pli_vec3> positions;         ///< [node_count] m
    std::vector<pli_vec3> velocities;        ///< [node_count] m/s
    std::vector<float> rest_lengths;         ///< [link_count] m
    bool uses_velocity_links;                ///< links in the velocity and drift sequences
    bool collides_with_rigid_bodies;         ///< SDF_RS
    pli_rigid_contacts_def rigid_contacts;   ///< where `collides_with_rigid_bodies`
    bool collides_with_soft_bodies;          ///< VF_SS
    pli_soft_contacts_def soft_contacts;     ///< where `collides_with_soft_bodies`
    bool has_aero;                           ///< lift or drag is not zero
    pli_aero_def aero;                       ///< where `has_aero`
    float pressure;                          ///< kPR, 0: none
    float volume_conservation;               ///< kVC with a rest volume, 0: none
    float pose_matching;                     ///< kMT with a rest shape, 0: none
    float anchor_hardness;                   ///< kAHR
    std::vector<ImportedAnchor> anchors;     ///< in Bullet's order
    std::vector<btCollisionObject*> ignored; ///< objects that it does not collide with
};

/// Reads nodes, links, faces, tetrahedra and materials into a new mesh, and the rest into `parameters`.
/// @param parameters may be null
/// @return the errors of the mesh functions, for a body that they do not accept (a stiffness of zero)
PLI_API pli_status import_soft_body(pli_context* context, const btSoftBody& soft, pli_mesh** mesh,
                                    ImportedBody* parameters);

/// Adds a body to the bridge's world with the mesh, the parameters and the present state of a btSoftBody. The rest
/// volume and the rest shape become the present ones. The btSoftBody stays as it is; take it out of its world.
/// @param group,mask as in Bridge::add_body
/// @return the errors of the other one, of Bridge::add_body and of the features that it needs; no body is left then
PLI_API pli_status import_soft_body(Bridge& bridge, const btSoftBody& soft, pli_body** body, int group = 1,
                                    int mask = -1);

} // namespace pliant

#endif
