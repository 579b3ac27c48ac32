// Shapes, rigid bodies and the stock parts of a Bullet world, made from the record of a scene.

#include "rigid_world.h"

#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <algorithm>

namespace demos {

btVector3 to_bullet(pli_vec3 v) {
    return btVector3(v.x, v.y, v.z);
}

btTransform to_bullet(const pli_transform& t) {
    const pli_vec3* r = t.rotation.rows;
    return btTransform(btMatrix3x3(r[0].x, r[0].y, r[0].z, r[1].x, r[1].y, r[1].z, r[2].x, r[2].y, r[2].z),
                       to_bullet(t.origin));
}

pli_vec3 from_bullet(const btVector3& v) {
    return pli_vec3_make(v.x(), v.y(), v.z());
}

static pli_transform from_bullet(const btTransform& t) {
    pli_transform result;
    for (int i = 0; i < 3; ++i) {
        result.rotation.rows[i] = from_bullet(t.getBasis()[i]);
    }
    result.origin = from_bullet(t.getOrigin());
    return result;
}

RigidWorld::RigidWorld(std::unique_ptr<btCollisionConfiguration> configuration)
    : configuration_(std::move(configuration)),
      dispatcher_(std::make_unique<TimedDispatcher>(configuration_.get(), clock_)),
      pairs_(std::make_unique<PausingPairCache>(clock_)),
      broadphase_(std::make_unique<btAxisSweep3>(btVector3(-1000, -1000, -1000), btVector3(1000, 1000, 1000),
                                                 static_cast<unsigned short>(32766), pairs_.get())),
      solver_(std::make_unique<btSequentialImpulseConstraintSolver>()) {}

RigidWorld::~RigidWorld() {
    let_go();
}

void RigidWorld::adopt(std::unique_ptr<btDiscreteDynamicsWorld> made, pli_vec3 gravity) {
    world_ = std::move(made);
    world_->setGravity(to_bullet(gravity));
}

void RigidWorld::set_gravity(pli_vec3 gravity) {
    for (const auto& object : objects_) { // Bullet leaves bodies at rest out
        if (!object->isStaticOrKinematicObject()) { object->activate(true); }
    }
    world_->setGravity(to_bullet(gravity));
}

void RigidWorld::add(const RigidRecord& record) {
    btCollisionShape* collision_shape = shape(record.shape);
    const btTransform pose = to_bullet(record.pose);
    records_.push_back(&record);
    if (record.is_collision_only) {
        auto object = std::make_unique<btCollisionObject>();
        object->setCollisionShape(collision_shape);
        object->setWorldTransform(pose);
        object->setFriction(record.friction);
        world_->addCollisionObject(object.get());
        objects_.push_back(std::move(object));
        return;
    }
    btVector3 inertia(0, 0, 0);
    if (record.mass > 0.0f) { collision_shape->calculateLocalInertia(record.mass, inertia); }
    btRigidBody::btRigidBodyConstructionInfo info(record.mass, nullptr, collision_shape, inertia);
    info.m_startWorldTransform = pose;
    auto body = std::make_unique<btRigidBody>(info);
    body->setFriction(record.friction);
    if (record.is_kinematic) {
        body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        body->setActivationState(DISABLE_DEACTIVATION);
    }
    world_->addRigidBody(body.get());
    objects_.push_back(std::move(body));
}

void RigidWorld::move(const Description& description, double seconds) {
    for (size_t i = 0; i < description.rigids.size(); ++i) {
        if (!description.rigids[i].is_kinematic) { continue; }
        btTransform pose = to_bullet(description.rigids[i].pose);
        for (const MotionRecord& motion : description.motions) {
            if (motion.rigid != static_cast<int>(i)) { continue; }
            const double first = motion.first_frame * static_cast<double>(frame_seconds);
            const double end = motion.end_frame * static_cast<double>(frame_seconds);
            const auto time = static_cast<btScalar>(std::clamp(seconds, first, end) - first);
            const btVector3 turned = to_bullet(motion.angular_velocity) * time;
            pose.setOrigin(pose.getOrigin() + to_bullet(motion.velocity) * time);
            if (turned.length2() > 0) {
                const btQuaternion turn(turned.normalized(), turned.length());
                pose.setRotation(turn * pose.getRotation());
            }
        }
        object(static_cast<int>(i)).setWorldTransform(pose);
    }
}

RigidState RigidWorld::state(int index) const {
    RigidState result{};
    result.pose = from_bullet(object(index).getWorldTransform());
    if (const btRigidBody* rigid = body(index)) {
        result.linear_velocity = from_bullet(rigid->getLinearVelocity());
        result.angular_velocity = from_bullet(rigid->getAngularVelocity());
    }
    return result;
}

void RigidWorld::add_ball(pli_vec3 center, pli_vec3 velocity, float radius, float mass) {
    RigidRecord record{};
    record.name = "ball";
    record.shape.kind = SCENE_SHAPE_SPHERE;
    record.shape.radius = radius;
    record.shape.margin = -1.0f;
    record.mass = mass;
    record.pose = pli_transform_identity();
    record.pose.origin = center;
    record.friction = 0.5f;
    add_ball(record);
    body(object_count() - 1)->setLinearVelocity(to_bullet(velocity));
}

void RigidWorld::add_ball(const RigidRecord& record) {
    balls_.push_back(record);
    add(balls_.back());
}

void RigidWorld::remove_last_ball() {
    btRigidBody* ball = body(object_count() - 1);
    if (held_ != nullptr && &held_->getRigidBodyA() == ball) { let_go(); }
    world_->removeRigidBody(ball);
    objects_.pop_back();
    records_.pop_back();
    const Shape* own = &balls_.back().shape; // later balls of the same size have used it too, and have gone
    shapes_.erase(
        std::remove_if(shapes_.begin(), shapes_.end(), [&](const CachedShape& cached) { return cached.record == own; }),
        shapes_.end());
    balls_.pop_back();
}

// ------------------------------------------------------------------------------------------- rays and dragging

// The objects of soft bodies are in the same world, and rays at them would be answered at length.
struct OwnRay final : btCollisionWorld::ClosestRayResultCallback {
    OwnRay(const btVector3& from, const btVector3& to, const std::vector<std::unique_ptr<btCollisionObject>>& own)
        : ClosestRayResultCallback(from, to), objects(own) {}
    int index(const void* object) const {
        for (size_t i = 0; i < objects.size(); ++i) {
            if (objects[i].get() == object) { return static_cast<int>(i); }
        }
        return -1;
    }
    bool needsCollision(btBroadphaseProxy* proxy) const override { return index(proxy->m_clientObject) >= 0; }

    const std::vector<std::unique_ptr<btCollisionObject>>& objects;
};

RayHit RigidWorld::cast_ray(pli_vec3 from, pli_vec3 to) const {
    OwnRay ray(to_bullet(from), to_bullet(to), objects_);
    world_->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
    RayHit hit;
    if (!ray.hasHit()) { return hit; }
    hit.rigid = ray.index(ray.m_collisionObject);
    hit.point = from_bullet(ray.m_hitPointWorld);
    hit.fraction = ray.m_closestHitFraction;
    return hit;
}

bool RigidWorld::hold(int index, pli_vec3 point) {
    btRigidBody* held = body(index);
    if (held == nullptr || held->getInvMass() <= 0.0f) { return false; }
    held_ = std::make_unique<btPoint2PointConstraint>(*held, held->getWorldTransform().inverse() * to_bullet(point));
    held_->m_setting.m_tau = 0.1f; // follows softly
    world_->addConstraint(held_.get());
    linear_damping_ = held->getLinearDamping();
    angular_damping_ = held->getAngularDamping();
    held->setDamping(0.5f, 0.9f); // else it would swing for long
    return true;
}

void RigidWorld::drag(pli_vec3 goal) {
    if (held_ == nullptr) { return; }
    held_->getRigidBodyA().activate(true);
    held_->setPivotB(to_bullet(goal));
}

void RigidWorld::let_go() {
    if (held_ == nullptr) { return; }
    held_->getRigidBodyA().setDamping(linear_damping_, angular_damping_);
    world_->removeConstraint(held_.get());
    held_.reset();
}

// ---------------------------------------------------------------------------------------------------- shapes

static bool equal(float a, float b) {
    return !(a < b) && !(b < a);
}

static bool equal(pli_vec3 a, pli_vec3 b) {
    return equal(a.x, b.x) && equal(a.y, b.y) && equal(a.z, b.z);
}

static bool equal(const pli_transform& a, const pli_transform& b) {
    return equal(a.origin, b.origin) && equal(a.rotation.rows[0], b.rotation.rows[0]) &&
           equal(a.rotation.rows[1], b.rotation.rows[1]) && equal(a.rotation.rows[2], b.rotation.rows[2]);
}

// Triangle meshes are large and rarely there twice: they count as different.
static bool equal(const Shape& a, const Shape& b) {
    if (a.make_own || b.make_own || a.kind != b.kind || a.kind == SCENE_SHAPE_TRIANGLE_MESH ||
        !equal(a.half_extents, b.half_extents) || !equal(a.radius, b.radius) || !equal(a.half_height, b.half_height) ||
        a.axis != b.axis || !equal(a.margin, b.margin) || a.children.size() != b.children.size()) {
        return false;
    }
    for (size_t i = 0; i < a.children.size(); ++i) {
        if (!equal(a.children[i], b.children[i]) || !equal(a.child_poses[i], b.child_poses[i])) { return false; }
    }
    return true;
}

btCollisionShape* RigidWorld::shape(const Shape& record) {
    for (const CachedShape& cached : shapes_) {
        if (equal(*cached.record, record)) { return cached.shape.get(); }
    }
    std::unique_ptr<btCollisionShape> made = make_shape(record);
    if (record.margin >= 0.0f) { made->setMargin(record.margin); }
    shapes_.push_back({&record, std::move(made)});
    return shapes_.back().shape.get();
}

static std::unique_ptr<btCollisionShape> make_cylinder(const Shape& record) {
    const btVector3 half = to_bullet(record.half_extents);
    if (record.axis == 0) { return std::make_unique<btCylinderShapeX>(half); }
    if (record.axis == 2) { return std::make_unique<btCylinderShapeZ>(half); }
    return std::make_unique<btCylinderShape>(half);
}

static std::unique_ptr<btCollisionShape> make_capsule(const Shape& record) {
    const btScalar height = 2 * record.half_height;
    if (record.axis == 0) { return std::make_unique<btCapsuleShapeX>(record.radius, height); }
    if (record.axis == 2) { return std::make_unique<btCapsuleShapeZ>(record.radius, height); }
    return std::make_unique<btCapsuleShape>(record.radius, height);
}

std::unique_ptr<btCollisionShape> RigidWorld::make_triangle_mesh(const Shape& record) {
    auto mesh = std::make_unique<btTriangleMesh>(true, false);
    for (size_t i = 0; i + 2 < record.triangles.size(); i += 3) {
        const auto corner = [&](size_t k) {
            return to_bullet(record.points[static_cast<size_t>(record.triangles[i + k])]);
        };
        mesh->addTriangle(corner(0), corner(1), corner(2));
    }
    auto made = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
    meshes_.push_back(std::move(mesh));
    return made;
}

std::unique_ptr<btCollisionShape> RigidWorld::make_shape(const Shape& record) {
    if (record.make_own) { return record.make_own(); }
    switch (record.kind) {
    case SCENE_SHAPE_BOX:
        return std::make_unique<btBoxShape>(to_bullet(record.half_extents));
    case SCENE_SHAPE_SPHERE:
        return std::make_unique<btSphereShape>(record.radius);
    case SCENE_SHAPE_CAPSULE:
        return make_capsule(record);
    case SCENE_SHAPE_CYLINDER:
        return make_cylinder(record);
    case SCENE_SHAPE_TRIANGLE_MESH:
        return make_triangle_mesh(record);
    case SCENE_SHAPE_COMPOUND:
        break;
    }
    auto compound = std::make_unique<btCompoundShape>();
    for (size_t i = 0; i < record.children.size(); ++i) {
        compound->addChildShape(to_bullet(record.child_poses[i]), shape(record.children[i]));
    }
    return compound;
}

} // namespace demos
