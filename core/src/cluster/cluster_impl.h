#pragma once

/* Clusters as joints and contacts see them. */

#include "body/body_impl.h"
#include "pliant/cluster.h"

typedef struct plii_cluster_member {
    int node;
    /* From the centre of mass of the rest shape, m; w = mass, kg: that of a pinned node is large, not infinite. */
    pli_vec4 rest;
} plii_cluster_member;

/* A sum of changes. */
typedef struct plii_cluster_impulse {
    pli_vec3 linear, angular; /* of velocities, m/s and rad/s */
    int count;
} plii_cluster_impulse;

static inline void plii_cluster_impulse_add(plii_cluster_impulse* sum, pli_vec3 linear, pli_vec3 angular, int count) {
    sum->linear = pli_vec3_add(sum->linear, linear);
    sum->angular = pli_vec3_add(sum->angular, angular);
    sum->count += count;
}

typedef struct plii_cluster {
    pli_cluster_settings settings;
    int first_member, member_count;
    int next_member_count; /* while the topology changes */
    bool contains_pinned_node;
    bool is_point; /* does not turn: all nodes are at one point, but for rounding */
    /* Only in reference mode: Bullet's inverse of the inertia (nodes in a line, pinned ones), or its frame, is not
       finite, and the turning no number, which keeps it from damping nodes. */
    bool has_no_inverse, has_no_frame;
    float inverse_mass;
    pli_mat3 inverse_inertia_local; /* of the rest shape */
    /* From the first centre of mass to that of the rest shape, as masses change; what is held counts from the first. */
    pli_vec3 rest_centre;
    pli_transform frame;    /* this and what follows is of the step in progress; current only when `has_frame` */
    pli_quat warm_rotation; /* the rotation of the frame, where the next one is searched from; not in reference mode */
    pli_mat3 inverse_inertia;
    float split; /* by how much inverses are larger in contacts, as others share the nodes */
    pli_vec4 linear_velocity, angular_velocity; /* w: 0. Contacts take all four numbers at once */
    /* Handed to the nodes before and after the body iterates. */
    plii_cluster_impulse impulse, drift;
    uint64_t open_batches; /* of contacts on the cluster with room for pairs, as bits; 0 but while they are made */
    pli_bounds bounds;     /* of the nodes; in reference mode the box that is kept from step to step */
    bool has_bounds;
    bool has_frame;      /* see plii_clusters_update_frames */
    bool keeps_momentum; /* nodes get all of its impulses, also where they are of other clusters that have some */
} plii_cluster;

typedef struct plii_clusters {
    pli_clusters_def def;
    plii_cluster* items;
    int count, capacity;
    plii_cluster_member* members; /* of all clusters, one after the other */
    int member_count, member_capacity;
    int next_member_count; /* of those that follow them while the topology changes */
    bool keeps_momentum;   /* one or more do, in this step */
    pli_vec4* node_sums;   /* [node_count] mass-weighted displacement and mass */
} plii_clusters;

extern const plii_field plii_cluster_settings_fields[6];

/* PLI_OK, or the error of a cluster that is not there. */
pli_status plii_check_cluster(const pli_body* body, int cluster, const char* function);

/* One more cluster with default settings, its rest shape is made by plii_clusters_settle. Nodes must be valid. */
pli_status plii_clusters_append(pli_body* body, plii_clusters* clusters, const int* nodes, int node_count);
/* Gives the arrays back; settings stay. */
void plii_clusters_release(pli_body* body, plii_clusters* clusters);
/* Of the nodes as they are now. */
pli_vec3 plii_cluster_centre(const pli_body* body, const plii_cluster* cluster);
/* The present masses; the rest shape stays. */
void plii_cluster_update_masses(const pli_body* body, plii_cluster* cluster);
/* The present masses, and the present shape as rest shape. */
void plii_cluster_set_rest_shape(const pli_body* body, plii_cluster* cluster);
/* Takes masses and rest shape of clusters from `first` on, and brings their frames up to date. */
void plii_clusters_settle(pli_body* body, plii_clusters* clusters, int first);

/* Frames, inertia and velocities are updated in a step where somebody asks for them: most clusters meet nothing. Of the
   clusters that collide and whose bounds overlap `near`, and of one. */
void plii_clusters_update_frames(const pli_body* body, pli_bounds near);
void plii_cluster_update_frame(const pli_body* body, plii_cluster* cluster);

/* Clusters that keep momentum weigh together what the nodes that they share weigh (Tonge and others, "Mass splitting
   for jitter-free parallel rigid body simulation"). */
void plii_clusters_split_masses(plii_clusters* clusters);

static inline const plii_cluster_member* plii_cluster_members(const pli_body* body, const plii_cluster* cluster) {
    return &body->clusters->members[cluster->first_member];
}
