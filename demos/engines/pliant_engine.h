#ifndef DEMOS_PLIANT_ENGINE_H
#define DEMOS_PLIANT_ENGINE_H

// A scene on Pliant: a stock btDiscreteDynamicsWorld and the bridge.

#include "engine.h"
#include "rigid_world.h"

#include <pliant_bullet/pliant_bullet.h>

#include <memory>
#include <optional>

namespace demos {

inline pli_vec3 xyz(const pli_vec4& v) {
    return pli_vec3_make(v.x, v.y, v.z);
}

class PliantEngine final : public Engine {
public:
    PliantEngine(const Description& description, const EngineOptions& options);
    ~PliantEngine() override;

    EngineKind kind() const override { return EngineKind::pliant; }
    std::string name() const override { return "pliant"; }
    size_t soft_bytes() const override;
    uint64_t soft_allocations() const override;
    SoftState soft(int index) const override;
    std::vector<ContactMark> contacts(int soft) const override;
    std::vector<ClusterMark> clusters(int soft) const override;
    void cut_sphere(int soft, pli_vec3 center, float radius) override;
    void cut_swept(const pli_vec3 first[2], const pli_vec3 second[2]) override;
    scene_self_collision self_collision() const override;
    std::optional<int> crossings() const override;
    void set_wind(int soft, pli_vec3 wind) override;

    RigidWorld& rigids() override { return rigids_; }
    const RigidWorld& rigids() const override { return rigids_; }
    pliant::Bridge& bridge() { return *bridge_; }
    int soft_count() const override { return static_cast<int>(bodies_.size()); }
    pli_body* body(int index) const { return bodies_.at(static_cast<size_t>(index)); }
    // The proxy of a rigid body, made when there is none yet.
    pli_rigid* proxy(int rigid);

protected:
    void add_soft(const SoftRecord& record) override;
    void check_step() const override;
    RayHit cast_soft_ray(pli_vec3 from, pli_vec3 to, float radius) const override;
    pli_vec3 node_position(int soft, int node) const override;
    void grab_soft(const RayHit& hit) override;
    pli_vec3 soft_grip(const RayHit& held) const override;
    void drag_soft(const RayHit& held, pli_vec3 goal, float seconds) override;
    void let_go_soft(const RayHit& held) override;

private:
    void enable_features(pli_body* body, const scene_soft_def& def);
    void sample_solids();
    void enable_clusters(pli_body* body, const scene_soft_def& def);
    void add_anchor(pli_body* body, const AnchorRecord& record);
    void add_joint(const JointRecord& record);
    pli_joint_end second_end(const scene_joint& ends);
    void check(pli_status status) const;

    SolverRun run_;
    pli_drag_id drag_{}; // of the body that is held
    struct JointControl {
        const Drive& drive;
        const JointRecord& record;
    };
    std::vector<std::unique_ptr<JointControl>> controls_;
    // Actions around that of the bridge, which holds all of its step that follows the rigid half.
    struct StartAction final : btActionInterface {
        explicit StartAction(SoftClock& of) : clock(of) {}
        void updateAction(btCollisionWorld*, btScalar) override { solve.emplace(clock, SoftPart::solve); }
        void debugDraw(btIDebugDraw*) override {}
        SoftClock& clock;
        std::optional<SoftClock::Window> solve;
    };
    struct EndAction final : btActionInterface {
        explicit EndAction(StartAction& of) : start(of) {}
        void updateAction(btCollisionWorld*, btScalar) override { start.solve.reset(); }
        void debugDraw(btIDebugDraw*) override {}
        StartAction& start;
    };

    struct ContextDeleter {
        void operator()(pli_context* context) const { pli_context_destroy(context); }
    };
    struct ThreadsDeleter {
        void operator()(pli_threads* threads) const { pli_threads_destroy(threads); }
    };
    std::unique_ptr<pli_threads, ThreadsDeleter> threads_; // none for one thread
    std::unique_ptr<pli_context, ContextDeleter> context_;
    RigidWorld rigids_;
    StartAction start_{rigids_.clock()};
    EndAction end_{start_};
    std::unique_ptr<pliant::Bridge> bridge_; // goes before the Bullet world
    std::vector<pli_body*> bodies_;
};

} // namespace demos
#endif
