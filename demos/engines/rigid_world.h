#ifndef DEMOS_RIGID_WORLD_H
#define DEMOS_RIGID_WORLD_H

// The rigid half of a scene in Bullet, the same for both engines: broad phase, solver, shapes and bodies as the demos
// of Bullet set them up.

#include "timed_world.h"

#include <btBulletDynamicsCommon.h>

#include <deque>

namespace demos {

class RigidWorld {
public:
    explicit RigidWorld(std::unique_ptr<btCollisionConfiguration> configuration);
    ~RigidWorld();
    RigidWorld(const RigidWorld&) = delete;
    RigidWorld& operator=(const RigidWorld&) = delete;

    // To be set once, before bodies are added.
    void adopt(std::unique_ptr<btDiscreteDynamicsWorld> made, pli_vec3 gravity);
    // Wakes all bodies.
    void set_gravity(pli_vec3 gravity);
    void add(const RigidRecord& record); // which must outlive this
    void add_ball(pli_vec3 center, pli_vec3 velocity, float radius, float mass);
    void add_ball(const RigidRecord& record); // at rest
    void remove_last_ball();
    // Puts kinematic bodies where they are `seconds` after the start; before a step, where its end finds them.
    void move(const Description& description, double seconds);

    btCollisionDispatcher& dispatcher() { return *dispatcher_; }
    btBroadphaseInterface& broadphase() { return *broadphase_; }
    btConstraintSolver& solver() { return *solver_; }
    btCollisionConfiguration& configuration() { return *configuration_; }
    btDiscreteDynamicsWorld& world() { return *world_; }
    SoftClock& clock() { return clock_; }
    const SoftClock& clock() const { return clock_; }

    int object_count() const { return static_cast<int>(objects_.size()); }
    btCollisionObject& object(int index) const { return *objects_.at(static_cast<size_t>(index)); }
    // Null for a plain collision object.
    btRigidBody* body(int index) const { return btRigidBody::upcast(&object(index)); }
    RigidState state(int index) const;
    const RigidRecord& record(int index) const { return *records_.at(static_cast<size_t>(index)); }

    // Looks at the objects that were added here only.
    RayHit cast_ray(pli_vec3 from, pli_vec3 to) const;
    // Holds a body by a point of it; false when it does not move.
    bool hold(int index, pli_vec3 point);
    void drag(pli_vec3 goal);
    void let_go();

private:
    btCollisionShape* shape(const Shape& record);
    std::unique_ptr<btCollisionShape> make_shape(const Shape& record);
    std::unique_ptr<btCollisionShape> make_triangle_mesh(const Shape& record);

    struct CachedShape {
        const Shape* record;
        std::unique_ptr<btCollisionShape> shape;
    };

    SoftClock clock_;
    // In the order in which they must be made; Bullet's parts hold plain pointers to each other.
    std::unique_ptr<btCollisionConfiguration> configuration_;
    std::unique_ptr<btCollisionDispatcher> dispatcher_;
    std::unique_ptr<PausingPairCache> pairs_;
    std::unique_ptr<btBroadphaseInterface> broadphase_;
    std::unique_ptr<btConstraintSolver> solver_;
    std::vector<std::unique_ptr<btStridingMeshInterface>> meshes_;
    std::vector<CachedShape> shapes_; // equal shapes are one object, as in the demos
    std::vector<std::unique_ptr<btCollisionObject>> objects_;
    std::vector<const RigidRecord*> records_; // of the objects
    std::deque<RigidRecord> balls_;
    std::unique_ptr<btPoint2PointConstraint> held_;
    float linear_damping_ = 0, angular_damping_ = 0; // of the held body when it is not held
    std::unique_ptr<btDiscreteDynamicsWorld> world_;
};

btVector3 to_bullet(pli_vec3 v);
btTransform to_bullet(const pli_transform& t);
pli_vec3 from_bullet(const btVector3& v);

} // namespace demos
#endif
