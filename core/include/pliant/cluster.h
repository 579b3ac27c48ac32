#ifndef PLIANT_CLUSTER_H
#define PLIANT_CLUSTER_H

/// Clusters: groups of nodes that act as one rigid body in contacts and joints, and that can hold their shape.
/// A cluster's frame is the rotation that fits its rest shape best; its impulses are handed to its nodes.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How one cluster behaves.
typedef struct pli_cluster_settings {
    float matching;        ///< [0, 1], default 0: share of the distance to the rest shape removed per step
    float node_damping;    ///< [0, 1], default 0: share by which nodes take over the rigid motion of the cluster
    float linear_damping;  ///< [0, 1], default 0: share of the linear velocity that a step takes from the cluster
    float angular_damping; ///< [0, 1], default 0: the same of the angular velocity
    bool collides;         ///< default true; false: takes no part in cluster contacts
    /// N s per contact and step, 0 to PLI_MAX_FORCE, default 100: limit of impulses between clusters of one body.
    /// btSoftBody has this setting, but never uses it.
    float max_self_impulse;
    float self_impulse_factor; ///< [0, 1], default 1: factor of the same impulses; likewise
} pli_cluster_settings;

/// All clusters of a body.
typedef struct pli_clusters_def {
    int iterations; ///< >= 1, default 4: joint and contact iterations of the clusters. Bullet name: citerations
    /// Default false. True: as btSoftBody does it. Frames may be reflections, pinned nodes weigh 1e18 kg and are moved
    /// by matching and impulses, and candidates for contacts come from boxes that are kept from step to step.
    bool reference_mode;
    uint32_t cookie; ///< set by the default function
} pli_clusters_def;

/// Defaults of the fields.
PLI_API pli_clusters_def pli_clusters_def_default(void);

/// Lets a body have clusters, or changes the settings of all of them. At first there are none; the calls below that
/// make clusters enable them with the defaults if needed. A change of `reference_mode` takes the present shape of all
/// clusters as their rest shape.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_enable_clusters(pli_body* body, const pli_clusters_def* def);

/// Removes all clusters, and the joints and contacts that hold to them. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_clusters(pli_body* body);

/// Replaces all clusters by `count` groups of near nodes that share a ring of nodes over faces, and, when there are
/// more than one, a first cluster of all nodes that does not collide. Deterministic. Joints to clusters of this body
/// are removed. Bullet name: generateClusters(k, maxiterations)
/// @param count          >= 1; fewer groups are made where the search leaves some without nodes, as Bullet's does, and
///                       never more than there are nodes
/// @param max_iterations >= 1, of the search for near nodes (k-means); Bullet uses 8192
/// @param made           receives the number of clusters; may be NULL
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_generate_clusters(pli_body* body, int count, int max_iterations, int* made);

/// Replaces all clusters by one per tetrahedron, or per face when there are no tetrahedra. Joints to clusters of this
/// body are removed. Bullet name: generateClusters(0)
/// @param made receives the number of clusters; may be NULL
/// @return PLI_ERROR_INVALID_MESH when there are neither, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_generate_clusters_from_elements(pli_body* body, int* made);

/// Adds one cluster of nodes of the caller's choice; their present places are its rest shape.
/// @param nodes      [node_count], each once
/// @param node_count 1 to the number of nodes
/// @param cluster    receives the index of the cluster; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node), PLI_ERROR_INVALID_VALUE (a node named twice),
///         PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_add_cluster(pli_body* body, const int* nodes, int node_count, int* cluster);

/// Removes all clusters and the joints that hold to them; clusters stay enabled.
/// @return PLI_ERROR_WRONG_STATE when clusters are not enabled, or while stepping
PLI_API pli_status pli_body_remove_clusters(pli_body* body);

/// Number of clusters, 0 when they are not enabled.
PLI_API int pli_body_cluster_count(const pli_body* body);

/// The present settings of one cluster.
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
PLI_API pli_status pli_body_get_cluster_settings(const pli_body* body, int cluster, pli_cluster_settings* settings);

/// Replaces the settings of one cluster. New clusters have the defaults.
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
PLI_API pli_status pli_body_set_cluster_settings(pli_body* body, int cluster, const pli_cluster_settings* settings);

/// The present state of a cluster.
typedef struct pli_cluster_view {
    int node_count;   ///< >= 1
    const int* nodes; ///< node i at nodes[i * node_stride], valid until the clusters of the body change
    int node_stride;  ///< in numbers, from a node to the next
    /// Of the step in progress, or of the last one, where the cluster has contacts, joints, matching or node damping,
    /// and always in reference mode; else of the nodes as they are now. Origin = centre of mass.
    pli_transform frame;
    float inverse_mass;             ///< 1/kg
    pli_mat3 inverse_inertia_world; ///< 1/(kg m^2), in world axes
    pli_vec3 linear_velocity;       ///< m/s
    pli_vec3 angular_velocity;      ///< rad/s
    bool contains_pinned_node;      ///< a cluster with one is far heavier than its free nodes
} pli_cluster_view;

/// Nodes, frame, mass and velocities of one cluster.
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
PLI_API pli_status pli_body_get_cluster(const pli_body* body, int cluster, pli_cluster_view* view);

/// Takes the present shape of all clusters as their rest shape, and the present masses of the nodes. For use after
/// masses were changed or nodes placed.
/// @return PLI_ERROR_WRONG_STATE when clusters are not enabled, or while stepping
PLI_API pli_status pli_body_reset_clusters(pli_body* body);

// -------------------------------------------------------------------------------------------------- contacts

/// A contact of a cluster with a rigid body, or with another cluster.
typedef struct pli_cluster_contact {
    int cluster;            ///< of this body
    pli_rigid* rigid;       ///< or NULL
    int shape;              ///< index in the rigid body's shapes
    pli_body* other;        ///< or NULL; this body itself for self-contacts
    int other_cluster;      ///< of `other`
    pli_vec3 witness;       ///< nearest point of the cluster's core (without margin), m, world
    pli_vec3 other_witness; ///< nearest point of the other side's core, m, world
    pli_vec3 normal;        ///< unit, from the other side to the cluster
    float distance;         ///< m, of the cores; < 0 when they overlap
} pli_cluster_contact;

/// Finds witnesses, normal and distance of the pair named in `contact`; returns false when they are not near. May read
/// only.
typedef bool pli_cluster_distance_fn(const pli_body* body, pli_cluster_contact* contact, void* user);

/// What the clusters of a body collide with, and how hard.
typedef struct pli_cluster_contacts_def {
    bool with_rigids; ///< default true. Bullet name: CL_RS
    bool with_bodies; ///< default true; the other body needs it too. Bullet name: CL_SS
    bool with_self;   ///< default false; clusters of one body that are apart when first seen. Bullet name: CL_SELF
    /// 0 to PLI_MAX_FACTOR, default 0.2: Coulomb's coefficient; the smaller one of the two sides counts. In reference
    /// mode the share of the sliding velocity that each iteration removes. Bullet name: kDF
    float friction;
    float dynamic_hardness; ///< [0, 1], default 0.1: share of the overlap with a dynamic body that a step removes.
                            ///< Bullet name: kSRHR_CL
    float static_hardness;  ///< [0, 1], default 1: the same with static and kinematic bodies. Bullet name: kSKHR_CL
    float soft_hardness;    ///< [0, 1], default 0.5: the same between clusters; the larger one of the two sides counts.
                            ///< Bullet name: kSSHR_CL
    /// [0, 1], default 0.5: share of the correction that is a displacement, not a velocity. In reference mode the rigid
    /// body takes it as a velocity all the same; else it feels the rest alone, and with 1 it sinks into a cushion.
    /// Bullet name: kSR_SPLT_CL
    float dynamic_split;
    float static_split;        ///< [0, 1], default 0.5: the same with static and kinematic bodies. Bullet: kSK_SPLT_CL
    float soft_split;          ///< [0, 1], default 0.5; the mean of the two sides counts. Bullet name: kSS_SPLT_CL
    bool accurate_penetration; ///< EPA (uses the heap inside libccd) instead of descent, default false
    /// Reference mode only. True: contacts with rigid bodies and other bodies are measured anew in each step, with
    /// rigid bodies where they are when they collide. Default false: contacts whose sides hardly move against each
    /// other are followed for a few steps, with an error of some percent of the margin, and rigid bodies are measured
    /// where the step takes them. Clusters in reference mode, and with `distance`, act as with true.
    bool disable_contact_cache;
    /// Reference mode only: replaces the core's distance query, for comparisons with another library. Default NULL.
    pli_cluster_distance_fn* distance;
    void* distance_user; ///< handed to `distance`
    uint32_t cookie;     ///< set by the default function
} pli_cluster_contacts_def;

/// Defaults of the fields.
PLI_API pli_cluster_contacts_def pli_cluster_contacts_def_default(void);

/// Lets convex hulls of clusters collide with rigid shapes and with each other, where the step ends. Called again, it
/// changes the settings. Fast bodies need pli_body_enable_rigid_face_contacts beside it. Enables clusters if needed.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_enable_cluster_contacts(pli_body* body, const pli_cluster_contacts_def* def);

/// Ends cluster contacts; the clusters stay. Does nothing when not enabled.
PLI_API pli_status pli_body_disable_cluster_contacts(pli_body* body);

/// Contacts of the step in progress, or of the last one, in the order of solving.
/// @param contacts NULL, or room for `capacity` contacts
/// @return the number of contacts, 0 when not enabled
PLI_API int pli_body_get_cluster_contacts(const pli_body* body, int capacity, pli_cluster_contact* contacts);

#ifdef __cplusplus
}
#endif
#endif
