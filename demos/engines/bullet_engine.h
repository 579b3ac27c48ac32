#ifndef DEMOS_BULLET_ENGINE_H
#define DEMOS_BULLET_ENGINE_H

// The reference: a scene on btSoftBody in a btSoftRigidDynamicsWorld.

#include "engine.h"
#include "rigid_world.h"

#include <BulletSoftBody/btSoftBody.h>

#include <functional>

namespace demos {

class BulletEngine final : public Engine {
public:
    explicit BulletEngine(const Description& description, const EngineOptions& options = {});
    ~BulletEngine() override;

    EngineKind kind() const override { return EngineKind::bullet; }
    std::string name() const override { return "bullet"; }
    size_t soft_bytes() const override;
    uint64_t soft_allocations() const override { return rigids_.clock().allocations(); }
    SoftState soft(int index) const override;
    std::vector<ContactMark> contacts(int soft) const override;
    std::vector<ClusterMark> clusters(int soft) const override;
    void cut_sphere(int soft, pli_vec3 center, float radius) override;
    void cut_swept(const pli_vec3 first[2], const pli_vec3 second[2]) override;
    scene_self_collision self_collision() const override { return SCENE_SELF_NONE; }
    std::optional<int> crossings() const override { return std::nullopt; }
    void set_wind(int soft, pli_vec3 wind) override;
    void set_gravity(pli_vec3 gravity) override;

    RigidWorld& rigids() override { return rigids_; }
    const RigidWorld& rigids() const override { return rigids_; }
    int soft_count() const override { return static_cast<int>(softs_.size()); }
    btSoftBody& body(int index) const { return *softs_.at(static_cast<size_t>(index)); }

    // Called in each step when all contacts are made and nothing of the soft bodies is solved yet.
    void set_before_solve(std::function<void()> hook) { before_solve_ = std::move(hook); }

protected:
    void add_soft(const SoftRecord& record) override;
    RayHit cast_soft_ray(pli_vec3 from, pli_vec3 to, float radius) const override;
    pli_vec3 node_position(int soft, int node) const override;
    void drag_soft(const RayHit& held, pli_vec3 goal, float seconds) override;

private:
    struct JointControl;
    class TimedSolver;

    void add_joint(const JointRecord& record);
    static void on_tick(btDynamicsWorld* world, btScalar seconds);

    btSoftBodyWorldInfo info_;
    std::vector<std::unique_ptr<JointControl>> controls_;
    std::vector<std::unique_ptr<btSoftBody>> softs_; // the world goes before its bodies
    RigidWorld rigids_;
    std::unique_ptr<TimedSolver> solver_;
    std::function<void()> before_solve_;
};

} // namespace demos
#endif
