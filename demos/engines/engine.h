#ifndef DEMOS_ENGINE_H
#define DEMOS_ENGINE_H

// One scene running in one engine: what the program, the comparison, the pictures and the tests work with.

#include "description/description.h"
#include "description/scene_run.h"
#include "drive.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace demos {

enum class EngineKind { pliant, bullet };

// What steps the soft bodies. btSoftBody has only the first one.
enum class SolverKind { position_based, implicit, xpbd };

const char* solver_name(SolverKind kind); // as on the command line

// Choices of the user; what is not set is the scene's own.
struct SolverOptions {
    std::optional<SolverKind> kind;
    std::optional<int> substeps;   // XPBD: parts of a step
    std::optional<int> iterations; // position iterations, Jacobi sweeps or XPBD's sweeps per substep
    pli_implicit_method implicit_method = PLI_IMPLICIT_JACOBI;
    bool filter_compression = false; // of the implicit solver
    int finishing_iterations = 0;    // of the same
    bool in_mesh_order = false;      // bullet: links in the order of the mesh, not colour by colour
};

struct EngineOptions {
    bool reference = false;      // Pliant only: Bullet's lattice distances and boxes, as for comparisons
    bool bullet_witness = false; // Pliant only: nearest points of clusters from Bullet's GJK
    bool unguarded = false;      // btSoftBody only: takes meshes that it is known to hang on
    SolverOptions solver{};
    bool ordered_pairs = false;         // Bullet takes pairs in an order that does not depend on what was before
    float step_seconds = frame_seconds; // the script of a scene keeps its times
    int threads = 1;                    // Pliant only
    pli_parallel_for_fn* parallel_for = nullptr; // Pliant only: in place of threads
    void* parallel_user = nullptr;
    pli_simd simd = PLI_SIMD_BEST; // Pliant only
};

// The solver that a scene runs with.
struct SolverRun {
    SolverKind kind = SolverKind::position_based;
    bool is_reference = false; // as btSoftBody's
    int substeps = 1;
    int iterations = 1; // bullet: the most that a soft body has
    pli_implicit_method implicit_method = PLI_IMPLICIT_JACOBI;
    bool filter_compression = false; // of the implicit solver
    int finishing_iterations = 0;    // of the same
};

// Throws Error when the solver cannot run the scene, and says which part of which body is in its way.
SolverRun choose_solver(const Description& description, EngineKind engine, const EngineOptions& options);

// Present state of one soft body, copied out of the engine. Faces and links index the nodes.
struct SoftState {
    std::vector<pli_vec3> positions, velocities;
    std::vector<float> inverse_masses;
    std::vector<int> link_nodes; // 2 per link
    std::vector<float> rest_lengths;
    std::vector<int> face_nodes;  // 3 per face
    std::vector<int> tetra_nodes; // 4 per tetrahedron
    int cluster_count = 0;
};

struct RigidState {
    pli_transform pose;
    pli_vec3 linear_velocity, angular_velocity;
};

// Where a step calls soft bodies.
enum class SoftPart { predict, collide, solve };
constexpr int soft_part_count = 3;

// Of one step, ms; the rigid bodies' own work is in none of them.
struct StepTimes {
    double parts[soft_part_count] = {};
    double sum() const { return parts[0] + parts[1] + parts[2]; }
};

// What a ray meets first.
struct RayHit {
    int soft = -1, node = -1; // a soft body and its node that is nearest to the point, or
    int face = -1;            // of the soft body, where one was met that can be dragged
    int rigid = -1;           // a rigid body
    pli_vec3 point{};         // m
    float fraction = 1;       // (0, 1) of the way along the ray; 1: it meets nothing

    bool is_hit() const { return fraction < 1.0f; }
};

// A contact of a soft body in the last step.
struct ContactMark {
    pli_vec3 point, normal;
};

struct ClusterMark {
    pli_vec3 center; // of mass
    std::vector<int> nodes;
};

class RigidWorld;

// Where the script of a scene is, and what the user has set.
struct ScriptState {
    ScriptClock clock;
    Drive drive;
    std::vector<float> controls; // empty: none was set
};

class Engine : public scene_run {
public:
    virtual EngineKind kind() const = 0;
    virtual std::string name() const = 0; // "pliant" or "bullet"
    const Description& description() const { return description_; }

    // One step of EngineOptions::step_seconds.
    void step();
    ScriptState script_state() const { return {clock_, drive_, changed_controls_}; }
    // Of this engine, before. Bodies stay where they are.
    void set_script_state(const ScriptState& state) {
        clock_ = state.clock;
        drive_ = state.drive;
        changed_controls_ = state.controls;
    }
    // As after so many steps without a user, of an engine at its start. Bodies stay where they are.
    void skip_script(int steps) {
        for (int i = 0; i < steps; ++i) {
            clock_.advance();
            drive_.advance(clock_.frame());
        }
    }
    // Of the steps from now on. For scenes without a script, which counts steps of the first length.
    void set_step_seconds(float seconds) { options_.step_seconds = seconds; }
    // Wall time of the last step, ms. The rigid bodies are in it: both engines leave them to the same Bullet.
    double step_milliseconds() const { return milliseconds_; }
    // What the soft bodies took of it.
    const StepTimes& step_times() const;
    // Of the soft bodies at present; for btSoftBody only when count_bullet_memory() was called first.
    virtual size_t soft_bytes() const = 0;
    // Allocations that the soft bodies have made so far; as above.
    virtual uint64_t soft_allocations() const = 0;

    virtual SoftState soft(int index) const = 0;
    // Throws Error when there is no such node.
    virtual pli_vec3 node_position(int soft, int node) const = 0;
    virtual std::vector<ContactMark> contacts(int soft) const = 0;
    virtual std::vector<ClusterMark> clusters(int soft) const = 0;
    virtual RigidWorld& rigids() = 0;
    virtual const RigidWorld& rigids() const = 0;

    // Those of the description, then the balls that were shot.
    int rigid_count() const;
    RigidState rigid(int index) const;
    const RigidRecord& rigid_record(int index) const;

    // ----------------------------------------------------------------- what a user does to a scene that runs

    // Nodes and links of bodies without faces count as thick as `radius`.
    RayHit cast_ray(pli_vec3 from, pli_vec3 to, float radius) const;
    // Takes hold of a node, or of a rigid body that moves, where the ray has met it; false when it cannot be held.
    bool grab(const RayHit& hit);
    // Where it is held, now. Nothing is held: the point of the last hit.
    pli_vec3 grip() const;
    // From now on each step moves what is held, by its grip, towards the goal.
    void drag(pli_vec3 goal);
    void let_go();
    bool is_holding() const { return held_.rigid >= 0 || held_.node >= 0; }

    // Throws Error when the body cannot be cut; it is then as before.
    virtual void cut_sphere(int soft, pli_vec3 center, float radius) = 0;
    // All bodies along the surface that a ray sweeps from its first place to its second. Throws Error.
    virtual void cut_swept(const pli_vec3 first[2], const pli_vec3 second[2]) = 0;

    // Throws Error when there are `most_balls` balls.
    void shoot(pli_vec3 from, pli_vec3 velocity, float radius, float mass);
    // Those that were shot, in their order.
    std::vector<RigidRecord> balls() const;
    // Takes away the last ones, or adds some as they were shot, until there are these.
    void set_balls(const std::vector<RigidRecord>& balls);

    // Of the first soft body that has some.
    virtual scene_self_collision self_collision() const = 0;
    // Pairs of faces of one soft body that cross each other now; not set where the engine does not count them.
    virtual std::optional<int> crossings() const = 0;

    // m/s^2, of soft and rigid bodies; the next step has it.
    virtual void set_gravity(pli_vec3 gravity);

    // Clamped to the range of the control. Throws Error when the engine cannot follow.
    void set_control(int index, float value);
    float control(int index) const;
    void drive(float speed, float largest_change) override { drive_.take_speed(speed, largest_change); }
    void steer(float angle) override { drive_.take_angle(angle); }

protected:
    Engine(const Description& description, const EngineOptions& options)
        : description_(description), options_(options), drive_(description.drives), clock_(options.step_seconds) {}

    // Rigid and soft bodies of the description, in its order.
    void add_bodies();
    virtual void add_soft(const SoftRecord& record) = 0;
    // After a step. Throws Error.
    virtual void check_step() const {}
    virtual RayHit cast_soft_ray(pli_vec3 from, pli_vec3 to, float radius) const = 0;
    virtual void grab_soft(const RayHit& /*hit*/) {}
    virtual pli_vec3 soft_grip(const RayHit& held) const { return node_position(held.soft, held.node); }
    // Before each step of so many seconds.
    virtual void drag_soft(const RayHit& held, pli_vec3 goal, float seconds) = 0;
    virtual void let_go_soft(const RayHit& /*held*/) {}

    const Description& description_;
    EngineOptions options_;
    Drive drive_;

private:
    // What the user holds and what the script sets.
    void prepare_step();

    ScriptClock clock_;
    double milliseconds_ = 0;
    std::vector<float> changed_controls_; // values, when any control was set
    RayHit held_;
    pli_vec3 goal_{};
};

std::unique_ptr<Engine> make_engine(EngineKind kind, const Description& description, const EngineOptions& options);

constexpr float cut_accuracy = 1e-4f;
constexpr int most_balls = 64;

} // namespace demos
#endif
