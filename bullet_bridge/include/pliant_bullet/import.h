#ifndef PLIANT_BULLET_IMPORT_H
#define PLIANT_BULLET_IMPORT_H

/// From btSoftBody to Pliant, for games that move scene by scene. Only programs that call these functions link
/// BulletSoftBody.

#include "pliant_bullet.h"

#include <string>
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

/// A cluster of a btSoftBody.
struct ImportedCluster {
    std::vector<int> nodes;               ///< of the mesh
    std::vector<pli_vec3> rest_positions; ///< [nodes.size()] m, around their centre of mass
    pli_cluster_settings settings;        ///< how it behaves
};

/// A joint of a btSoftBody.
struct ImportedJoint {
    bool is_angular;             ///< AJoint, else LJoint
    int cluster;                 ///< of the body
    int other_cluster;           ///< of the body, or PLI_NULL_INDEX
    btCollisionObject* object;   ///< the other end without `other_cluster`; null: the world
    pli_vec3 place;              ///< m, world: the point held together; of an angular one the axis, unit
    pli_joint_softness softness; ///< erp, cfm, split
};

/// What a btSoftBody holds beyond its mesh. Notes and user data change no step and are not imported.
struct ImportedBody {
    pli_body_def def;                          ///< margin and solver settings
    std::vector<pli_vec3> positions;           ///< [node_count] m
    std::vector<pli_vec3> velocities;          ///< [node_count] m/s
    std::vector<float> rest_lengths;           ///< [link_count] m
    bool uses_velocity_links;                  ///< links in the velocity and drift sequences
    bool collides_with_rigid_bodies;           ///< SDF_RS
    pli_rigid_contacts_def rigid_contacts;     ///< where `collides_with_rigid_bodies`
    bool collides_with_soft_bodies;            ///< VF_SS
    pli_soft_contacts_def soft_contacts;       ///< where `collides_with_soft_bodies`
    bool has_aero;                             ///< lift or drag is not zero
    pli_aero_def aero;                         ///< where `has_aero`
    float pressure;                            ///< kPR, 0: none
    float volume_conservation;                 ///< kVC with a rest volume, 0: none
    std::vector<pli_vec3> rest_positions;      ///< [node_count] m, of setPose, or empty: there was none
    float pose_matching;                       ///< kMT with a rest shape, 0: none
    float anchor_hardness;                     ///< kAHR
    std::vector<ImportedAnchor> anchors;       ///< in Bullet's order
    std::vector<btCollisionObject*> ignored;   ///< objects that it does not collide with
    int cluster_iterations;                    ///< citerations
    std::vector<ImportedCluster> clusters;     ///< in Bullet's order
    bool has_cluster_contacts;                 ///< CL_RS or CL_SS
    pli_cluster_contacts_def cluster_contacts; ///< where `has_cluster_contacts`
    std::vector<ImportedJoint> joints;         ///< in Bullet's order, without those that are contacts
    /// Sentences about what was not taken: a joint to another btSoftBody, with an IControl of the game or with its ends
    /// apart, a rest volume set by hand, collision flags of deformable bodies.
    std::vector<std::string> not_taken;
};

/// Reads nodes, links, faces, tetrahedra and materials into a new mesh, and the rest into `parameters`.
/// @param parameters may be null
/// @return the errors of the mesh functions, for a body that they do not accept (a stiffness of zero)
PLI_API pli_status import_soft_body(pli_context* context, const btSoftBody& soft, pli_mesh** mesh,
                                    ImportedBody* parameters);

/// Adds a body to the bridge's world with the mesh, the parameters, the rest shapes and the present state of a
/// btSoftBody: all that its steps depend on, or nothing. The btSoftBody stays as it is; take it out of its world.
/// @param group,mask as in Bridge::add_body
/// @param not_taken  receives ImportedBody::not_taken; may be null
/// @return PLI_ERROR_INVALID_VALUE when something is not taken; the errors of the other one, of Bridge::add_body and of
///         the features that it needs; no body is left then
PLI_API pli_status import_soft_body(Bridge& bridge, const btSoftBody& soft, pli_body** body, int group = 1,
                                    int mask = -1, std::vector<std::string>* not_taken = nullptr);

} // namespace pliant

#endif
