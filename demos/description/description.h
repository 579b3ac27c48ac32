#ifndef DEMOS_DESCRIPTION_H
#define DEMOS_DESCRIPTION_H

// What a scene has said to the scene builder: the record that engines are built from.

#include "error.h"
#include "scene_builder.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class btCollisionShape;

namespace demos {

struct Shape {
    scene_shape_kind kind;
    pli_vec3 half_extents;
    float radius, half_height;
    int axis;
    float margin;
    std::vector<pli_vec3> points;
    std::vector<int> triangles;
    std::vector<Shape> children;
    std::vector<pli_transform> child_poses;
    bool is_solid;
    // Of tests: makes a shape that scenes do not have, in place of all that.
    std::function<std::unique_ptr<btCollisionShape>()> make_own;
};

struct RigidRecord {
    std::string name;
    Shape shape;
    float mass;
    pli_transform pose;
    float friction;
    bool is_collision_only, is_kinematic;
};

// Of a kinematic body, between two frames.
struct MotionRecord {
    int rigid, first_frame, end_frame;
    pli_vec3 velocity, angular_velocity;
};

struct FirstForce {
    int node;
    pli_vec3 force;
};

struct AnchorRecord {
    int node, rigid;
    bool disable_collision;
    float influence;
};

// A linear or an angular joint; joints keep the order in which they were added.
struct JointRecord {
    bool is_angular;
    scene_joint ends;
    pli_vec3 position; // of a linear joint
    pli_vec3 axis;     // of an angular joint, as are the other two
    bool is_driven;
    pli_vec3 side;
};

// What scripts count in.
constexpr float frame_seconds = 1.0f / 60.0f;

// What happens when `frame` frames have passed.
struct DriveRecord {
    int frame;
    float speed, largest_change, angle;
};

struct CutRecord {
    int frame;
    int soft, node;
    float radius;
};

struct ControlRecord {
    std::string name;
    scene_control def; // without its name
};

struct ControlEvent {
    int frame, control;
    float value;
};

struct MeshDeleter {
    void operator()(pli_mesh* mesh) const { pli_mesh_destroy(mesh); }
};
using MeshPointer = std::unique_ptr<pli_mesh, MeshDeleter>;

struct SoftRecord {
    std::string name;
    MeshPointer mesh;
    scene_soft_def def;
    pli_vec3 velocity;
    std::vector<FirstForce> first_forces;
    std::vector<AnchorRecord> anchors;
    int order; // number of rigid bodies that were added before this soft body
};

struct SceneOptions {
    std::string mesh_file;                                // --mesh; empty: the scene's own
    std::string tetra_base;                               // --tetra; empty: the scene's own
    std::optional<scene_self_collision> self_collision{}; // --self-collision; not set: the scene's own
    scene_resolution resolution{0, 0};                    // --resolution; no rows: as many as the columns ask for
};

// The record of a scene. Owns its context and meshes; must outlive the engines that are built from it.
class Description {
public:
    // Throws Error when the scene cannot be built (unreadable mesh file, scene that takes no mesh, ...).
    static std::unique_ptr<Description> build(const scene& which, const SceneOptions& options);
    virtual ~Description() = default;

    const scene* source = nullptr;
    std::vector<RigidRecord> rigids;
    std::vector<SoftRecord> softs;
    std::vector<JointRecord> joints;
    std::vector<DriveRecord> drives; // in the order of frames
    std::vector<CutRecord> cuts;
    std::vector<MotionRecord> motions;
    std::vector<ControlRecord> controls;
    std::vector<ControlEvent> control_events;
    pli_vec3 gravity{0, -10, 0};
    bool has_self_collision = false; // that can be chosen, none included
    bool has_camera = false;
    scene_camera camera{};
    pli_bounds rest_bounds{}; // of all soft bodies at the start
};

} // namespace demos
#endif
