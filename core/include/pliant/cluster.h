#ifndef PLIANT_CLUSTER_H
#define PLIANT_CLUSTER_H

/// Clusters: groups of nodes that act as one rigid body in contacts and joints, and that can hold their shape.
/// A cluster's frame is the rotation that fits its rest shape best; its impulses are handed to its nodes.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_cluster_settings {
    float matching;        ///< [0, 1], default 0: share of the distance to the rest shape removed per step
    float node_damping;    ///< [0, 1], default 0: nodes take over the rigid motion of the cluster
    float linear_damping;  ///< [0, 1], default 0
    float angular_damping; ///< [0, 1], default 0
    bool collides;         ///< default true
    /// Impulses between clusters of one body are cut to `max_self_impulse` (N s per contact and step, >= 0, default
    /// 100) and scaled by `self_impulse_factor` ([0, 1], default 1). btSoftBody has both and never comes to use them.
    float max_self_impulse;
    float self_impulse_factor;
} pli_cluster_settings;

typedef struct pli_clusters_def {
    int iterations; ///< >= 1, default 4: joint and contact iterations of the clusters. Bullet name: citerations
    /// As btSoftBody does it, for comparisons; default false. Frames may be reflections, pinned nodes weigh 1e18 kg and
    /// are moved by matching and impulses, candidates for contacts come from boxes that are kept from step to step.
    bool as_bullet;
    uint32_t cookie;
} pli_clusters_def;

PLI_API pli_clusters_def pli_clusters_def_default(void);

/// Enable, or change when enabled. A body starts without any cluster. A change of `as_bullet` takes the present shape
/// of all clusters as their rest shape. @param def NULL for the defaults
PLI_API pli_status pli_body_enable_clusters(pli_body* body, const pli_clusters_def* def);
/// Removes all clusters, and the joints and contacts that hold to them.
PLI_API void pli_body_disable_clusters(pli_body* body);

/// Replace all clusters by `count` groups of near nodes that share a ring of nodes over faces, and, when there are
/// more than one, a first cluster of all nodes that does not collide. Deterministic. Enables clusters when needed.
/// Joints to clusters of this body are removed. Bullet name: generateClusters(k, maxiterations)
/// @param count >= 1, at most the number of nodes is made
/// @param made  receives the number of clusters; may be NULL
PLI_API pli_status pli_body_generate_clusters(pli_body* body, int count, int max_iterations, int* made);
/// One cluster per tetrahedron, or per face when there are no tetrahedra. Bullet name: generateClusters(0)
/// @return PLI_ERROR_INVALID_MESH when there are neither
PLI_API pli_status pli_body_generate_clusters_from_elements(pli_body* body, int* made);
/// One more cluster, of any nodes (one or more, each once).
PLI_API pli_status pli_body_add_cluster(pli_body* body, const int* nodes, int node_count, int* cluster);
PLI_API pli_status pli_body_remove_clusters(pli_body* body);

PLI_API int pli_body_cluster_count(const pli_body* body);
PLI_API pli_status pli_body_get_cluster_settings(const pli_body* body, int cluster, pli_cluster_settings* settings);
PLI_API pli_status pli_body_set_cluster_settings(pli_body* body, int cluster, const pli_cluster_settings* settings);

typedef struct pli_cluster_view {
    int node_count;
    const int* nodes; ///< node i at nodes[i * node_stride], valid until the clusters of the body change
    int node_stride;
    /// Of the step in progress, or of the last one, where the cluster has contacts or joints; else of the nodes as they
    /// are now. Origin = centre of mass.
    pli_transform frame;
    float inverse_mass; ///< 1/kg
    pli_mat3 inverse_inertia_world;
    pli_vec3 linear_velocity;  ///< m/s
    pli_vec3 angular_velocity; ///< rad/s
    bool contains_pinned_node;
} pli_cluster_view;

PLI_API pli_status pli_body_get_cluster(const pli_body* body, int cluster, pli_cluster_view* view);
/// Takes the present shape of all clusters as their rest shape and the present masses.
PLI_API pli_status pli_body_reset_clusters(pli_body* body);

// -------------------------------------------------------------------------------------------------- contacts

/// A contact of a cluster with a rigid body, or with another cluster.
typedef struct pli_cluster_contact {
    int cluster;      ///< of this body
    pli_rigid* rigid; ///< or NULL
    int shape;        ///< index in the rigid body's shapes
    pli_body* other;  ///< or NULL; this body itself for self-contacts
    int other_cluster;
    pli_vec3 witness, other_witness; ///< nearest points of the two cores (without margins), m, world
    pli_vec3 normal;                 ///< unit, from the other side to the cluster
    float distance;                  ///< m, of the cores; < 0 when they overlap
} pli_cluster_contact;

/// Finds witnesses, normal and distance of the pair named in `contact`; false when they are not near. May read only.
typedef bool pli_cluster_distance_fn(const pli_body* body, pli_cluster_contact* contact, void* user);

typedef struct pli_cluster_contacts_def {
    bool with_rigids; ///< default true. Bullet name: CL_RS
    bool with_bodies; ///< default true; the other body needs it too. Bullet name: CL_SS
    bool with_self;   ///< default false: clusters of one body that are apart when first met. Bullet name: CL_SELF
    /// >= 0, default 0.2; the smaller of the two sides counts. Coulomb's coefficient; as_bullet the share of the
    /// sliding velocity that each iteration removes. Bullet name: kDF
    float friction;
    float dynamic_hardness; ///< [0, 1], default 0.1. Bullet name: kSRHR_CL
    float static_hardness;  ///< [0, 1], default 1. Bullet name: kSKHR_CL
    float soft_hardness;    ///< [0, 1], default 0.5; the larger of the two sides counts. Bullet name: kSSHR_CL
    /// [0, 1], default 0.5: share of the correction that is a displacement, not a velocity. The rigid body takes it as
    /// a velocity all the same. Bullet name: kSR_SPLT_CL
    float dynamic_split;
    float static_split;        ///< [0, 1], default 0.5. Bullet name: kSK_SPLT_CL
    float soft_split;          ///< [0, 1], default 0.5; the mean of the two sides counts. Bullet name: kSS_SPLT_CL
    bool accurate_penetration; ///< EPA (uses the heap inside libccd) instead of portal refinement, default false
    /// Contacts with rigid bodies and other bodies are measured anew in each step. Default false: those whose sides
    /// hardly move against each other are followed for a few steps, in which they are right to some percent of the
    /// margin. Always so with clusters as_bullet and with `distance`.
    bool measure_always;
    /// Replaces the distance query, for comparisons with that of another library; NULL: the one of the core.
    pli_cluster_distance_fn* distance;
    void* distance_user;
    uint32_t cookie;
} pli_cluster_contacts_def;

PLI_API pli_cluster_contacts_def pli_cluster_contacts_def_default(void);
/// Convex hulls of clusters meet rigid shapes and each other. Enables clusters when needed.
PLI_API pli_status pli_body_enable_cluster_contacts(pli_body* body, const pli_cluster_contacts_def* def);
PLI_API void pli_body_disable_cluster_contacts(pli_body* body);

/// Contacts of the step in progress, or of the last one; as pli_body_get_rigid_contacts.
PLI_API int pli_body_get_cluster_contacts(const pli_body* body, int capacity, pli_cluster_contact* contacts);
/// As pli_body_reorder_rigid_contacts.
PLI_API pli_status pli_body_reorder_cluster_contacts(pli_body* body, const int* order, int count);

#ifdef __cplusplus
}
#endif
#endif
