#ifndef SCENE_BUILDER_H
#define SCENE_BUILDER_H

/* What scenes are written against. A scene only describes: the builder records rigid bodies, soft bodies, anchors and
   scripted events, and every engine (Pliant through the bridge, btSoftBody, the core alone) is built from the same
   record. A wrong call (NaN, unknown index, ...) is remembered by the builder and fails the scene with a message. */

#include <pliant/pliant.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scene_builder scene_builder;

/* Owner of the meshes that a scene makes. */
pli_context* scene_context(scene_builder* builder);

// ----------------------------------------------------------------------------------------------------- meshes

/* A mesh made from a named set of triangles, links shuffled: "bunny" (453 nodes), "torus" (300 nodes, around the y
   axis) and "ball" (515 nodes, radius 1), or the user's file (--mesh) in place of any of them, scaled and moved to
   where the named one is. NULL when the builder has failed; the other functions accept that. */
pli_mesh* scene_triangle_mesh(scene_builder* builder, const char* name);

/* A mesh of tetrahedra with its surface: "tetra_bunny" (481 nodes, 1,394 tetrahedra; as tall as "bunny" and in its
   place) and "tetra_cube" (374 nodes, 1,607 tetrahedra, from -1 to 1), or the user's files (--tetra) in place of any of
   them, scaled and moved to where the named one is. NULL as above. */
pli_mesh* scene_tetra_mesh(scene_builder* builder, const char* name);

/* Passes a status on to the builder; true when it is PLI_OK. For calls of pli_mesh_ functions. */
bool scene_check(scene_builder* builder, pli_status status);

// ----------------------------------------------------------------------------------------------- rigid bodies

typedef enum scene_shape_kind {
    SCENE_SHAPE_BOX,           /* half_extents */
    SCENE_SHAPE_SPHERE,        /* radius */
    SCENE_SHAPE_CAPSULE,       /* radius, half_height of the segment, axis */
    SCENE_SHAPE_CYLINDER,      /* half_extents (axis names the long one) */
    SCENE_SHAPE_TRIANGLE_MESH, /* points, triangles; static only */
    SCENE_SHAPE_COMPOUND       /* children, child_poses */
} scene_shape_kind;

typedef struct scene_shape {
    scene_shape_kind kind;
    pli_vec3 half_extents;
    float radius, half_height;
    int axis;     /* 0 x, 1 y, 2 z */
    float margin; /* m, Bullet's collision margin of the shape; < 0: Bullet's default */
    int point_count, triangle_count, child_count;
    const pli_vec3* points; /* arrays are copied by scene_add_rigid */
    const int* triangles;
    const struct scene_shape* children;
    const pli_transform* child_poses;
    bool is_solid; /* of a closed triangle mesh: Pliant samples the inside, btSoftBody meets the triangles */
} scene_shape;

scene_shape scene_box(pli_vec3 half_extents);
scene_shape scene_sphere(float radius);

typedef struct scene_rigid_def {
    const char* name;
    scene_shape shape;
    float mass; /* kg; 0: static */
    pli_transform pose;
    float friction;         /* default 0.5 */
    bool is_collision_only; /* a plain static btCollisionObject, as the demos' ground, not a btRigidBody */
    bool is_kinematic;      /* of mass 0, moved by scene_move_rigid */
} scene_rigid_def;

scene_rigid_def scene_rigid_def_default(void);
/* The same of a box, level and around `center`. */
scene_rigid_def scene_rigid_box(const char* name, pli_vec3 half_extents, float mass, pli_vec3 center);
/* Index of the rigid body in the order of adding. */
int scene_add_rigid(scene_builder* builder, const scene_rigid_def* def);

/* From one frame to another a kinematic body moves with a velocity (m/s) and turns about its origin (rad/s, in the
   world); several motions add up. */
void scene_move_rigid(scene_builder* builder, int rigid, int first_frame, int end_frame, pli_vec3 velocity,
                      pli_vec3 angular_velocity);

// ------------------------------------------------------------------------------------------------ soft bodies

/* Nodes of a grid. */
typedef struct scene_resolution {
    int columns, rows;
} scene_resolution;

/* What --resolution asks for, or these: "N" stands for N columns and rows in the same ratio. */
scene_resolution scene_get_resolution(scene_builder* builder, int columns, int rows);

/* How a soft body is kept from passing through itself; btSoftBody does not know any of it. */
typedef enum scene_self_collision {
    SCENE_SELF_NONE,
    SCENE_SELF_NODES, /* hashed */
    SCENE_SELF_GRIDS, /* two shifted grids */
    SCENE_SELF_FACES
} scene_self_collision;

/* The settings of a soft body, with btSoftBody's defaults. */
typedef struct scene_soft_def {
    const char* name;
    float collision_margin; /* default 0.25 */
    pli_solver_settings solver;
    bool velocity_links;
    pli_rigid_contacts_def rigid_contacts;
    bool has_rigid_contacts; /* default true */
    pli_soft_contacts_def soft_contacts;
    bool has_soft_contacts; /* default false */
    float anchor_hardness;  /* default 0.7 */
    pli_aero_def aero;      /* lift and drag 0: none */
    float pressure;         /* 0: none */
    float volume_conservation;
    float pose_matching;
    bool has_clusters;          /* default false */
    int cluster_count;          /* groups of near nodes; 0: one cluster per tetrahedron, or per face */
    float cluster_matching;     /* of cluster 0 */
    float cluster_node_damping; /* of cluster 0 */
    bool has_cluster_contacts;  /* default false; with rigid bodies and with other soft bodies */
    pli_cluster_contacts_def cluster_contacts;
    /* N/m of a link with linear stiffness 1, for the solvers with units; 0: as it looks with btSoftBody. */
    float link_stiffness;
    float link_damping;                  /* N s/m of the same, when the stiffness is given */
    scene_self_collision self_collision; /* default none; --self-collision chooses another where there is one */
    float thickness;                     /* m, that nodes keep; faces keep a quarter of it */
    float self_friction;                 /* share of the sliding in a (sub)step, default 0.1 */
} scene_soft_def;

scene_soft_def scene_soft_def_default(void);
/* Takes over the mesh (also when it fails; NULL is allowed). Index of the soft body in the order of adding. */
int scene_add_soft(scene_builder* builder, pli_mesh* mesh, const scene_soft_def* def);

void scene_set_velocity(scene_builder* builder, int soft, pli_vec3 velocity);
/* A force that acts in the first step only. */
void scene_add_first_force(scene_builder* builder, int soft, int node, pli_vec3 force);

/* The pivot is where the node is. */
void scene_add_anchor(scene_builder* builder, int soft, int node, int rigid, bool disable_collision, float influence);

// ---------------------------------------------------------------------------------------------------- joints

/* Cluster 0 of one soft body held to cluster 0 of another, or to a rigid body. */
typedef struct scene_joint {
    int soft;
    int other_soft, rigid; /* one of them is < 0 */
    pli_joint_softness softness;
} scene_joint;

scene_joint scene_joint_to_soft(int soft, int other_soft);
scene_joint scene_joint_to_rigid(int soft, int rigid);

/* Positions and axes are those in the world at the start. */
void scene_add_linear_joint(scene_builder* builder, const scene_joint* joint, pli_vec3 position);

typedef struct scene_angular_joint {
    scene_joint ends;
    pli_vec3 axis;
    bool is_driven; /* by scene_drive_at; else it turns freely */
    pli_vec3 side;  /* where a steered axis points when it has been turned by a quarter; zero: it is not steered */
} scene_angular_joint;

void scene_add_angular_joint(scene_builder* builder, const scene_angular_joint* joint);

// ---------------------------------------------------------------------------------------------------- script

/* Happens when `frame` frames have passed, and lasts: driven joints go for `speed` (rad/s) with at most
   `largest_change` per iteration (0: they turn freely), and steered axes are turned by `angle` (rad). */
void scene_drive_at(scene_builder* builder, int frame, float speed, float largest_change, float angle);

/* When `frame` frames have passed, the soft body is cut along a sphere around where one of its nodes is then. */
void scene_cut_at(scene_builder* builder, int frame, int soft, int node, float radius);

// -------------------------------------------------------------------------------------------------- controls

/* A scene that runs, as the functions behind controls see it. They act from the next step on. */
typedef struct scene_run scene_run;

/* The wind on a soft body with aerodynamics, or on all such bodies (soft < 0), m/s. */
void scene_run_set_wind(scene_run* run, int soft, pli_vec3 wind);
/* As scene_drive_at; what it says of the same thing, speed or angle, holds no longer. */
void scene_run_drive(scene_run* run, float speed, float largest_change);
void scene_run_steer(scene_run* run, float angle);

typedef enum scene_keys { SCENE_KEYS_NONE, SCENE_KEYS_LEFT_RIGHT, SCENE_KEYS_UP_DOWN } scene_keys;

/* A figure that the user turns while the scene runs: `pliant view` shows a slider. */
typedef struct scene_control {
    const char* name; /* with its unit: "wind direction (degrees)" */
    float low, high;
    float initial;     /* what the scene starts with: `apply` is called only when the value changes */
    scene_keys keys;   /* arrow keys that move it: right and up to `high`, left and down to `low` */
    bool springs_back; /* to `initial` when the keys are let go */
    void (*apply)(scene_run* run, float value);
} scene_control;

/* Index of the control in the order of adding. */
int scene_add_control(scene_builder* builder, const scene_control* control);
/* When `frame` frames have passed, the control gets the value, whatever it is then. */
void scene_set_control_at(scene_builder* builder, int frame, int control, float value);

// ----------------------------------------------------------------------------------------------------- scene

/* Of soft and rigid bodies, m/s^2; default (0, -10, 0). */
void scene_set_gravity(scene_builder* builder, pli_vec3 gravity);

typedef struct scene_camera {
    pli_vec3 target;
    float distance, yaw_degrees, pitch_degrees; /* pitch < 0 looks down */
} scene_camera;

/* Where pictures are taken from. Default: chosen from the bounds of the soft bodies at the frame that is drawn. */
void scene_set_camera(scene_builder* builder, scene_camera camera);

typedef enum scene_solver { SCENE_SOLVER_POSITION_BASED, SCENE_SOLVER_IMPLICIT, SCENE_SOLVER_XPBD } scene_solver;

typedef struct scene {
    const char* name;      /* as in `pliant run NAME` */
    const char* summary;   /* one sentence: what to look at */
    bool takes_mesh;       /* --mesh replaces its triangle mesh */
    bool takes_tetra;      /* --tetra replaces its tetrahedral mesh */
    bool takes_resolution; /* --resolution changes its grid */
    bool is_own;           /* not of Bullet's demo; such scenes come last */
    scene_solver solver;   /* that looks and settles best; --solver overrides */
    int substeps;          /* of XPBD, 0: the default */
    int picture_frame;     /* the frame that pictures show by default */
    void (*build)(scene_builder* builder);
} scene;

#ifdef __cplusplus
}
#endif
#endif
