#include "rigid_proxy.h"

#include "convert.h"
#include "shapes/triangle_slabs.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btTransformUtil.h>

#include <cstring>

namespace pliant {

namespace {

// m and radians that a kinematic body is away from where its velocity leads: less is motion that Bullet was not told
// of. A body that Bullet takes to be at rest has more likely been put there.
constexpr btScalar jump_distance = 1, jump_angle = 1, jump_of_resting = btScalar(0.25);

// Most sub-steps of a frame that a kinematic body is followed through.
constexpr int most_sub_steps = 16;

// Whether Bullet's algorithm for compounds comes to a child: its box touches the soft body's both in the world and in
// the frame of the compound.
bool comes_to_child(const ShapePart& child, const btTransform& compound, const pli_bounds& body_bounds) {
    const btVector3 corners[2] = {to_bullet(body_bounds.min), to_bullet(body_bounds.max)};
    btVector3 low, high;
    child.convex->getAabb(compound * child.pose, low, high);
    if (!TestAabbAgainstAabb2(low, high, corners[0], corners[1])) { return false; }
    const btTransform to_compound = compound.inverse();
    btVector3 body_low = to_compound * corners[0], body_high = body_low;
    for (int i = 1; i < 8; ++i) {
        const btVector3 corner(corners[i & 1].x(), corners[i >> 1 & 1].y(), corners[i >> 2].z());
        body_low.setMin(to_compound * corner);
        body_high.setMax(to_compound * corner);
    }
    child.convex->getAabb(child.pose, low, high);
    return TestAabbAgainstAabb2(low, high, body_low, body_high);
}

// A body that does not turn keeps its rotation and inertia as they are.
void move(btRigidBody& body, const btVector3& shift, const btVector3& rotation) {
    btTransform& pose = body.getWorldTransform();
    if (!rotation.isZero()) {
        btTransform moved;
        btTransformUtil::integrateTransform(pose, shift, rotation, 1, moved);
        body.proceedToTransform(moved);
        return;
    }
    pose.setOrigin(pose.getOrigin() + shift);
    body.setInterpolationWorldTransform(pose);
    body.setInterpolationLinearVelocity(body.getLinearVelocity());
    body.setInterpolationAngularVelocity(body.getAngularVelocity());
}

} // namespace

RigidProxy::RigidProxy(const btCollisionObject& object)
    : object_(&object), body_(btRigidBody::upcast(&object)), identity_(object) {}

RigidProxy::~RigidProxy() {
    drop_rigid();
}

void RigidProxy::drop_rigid() {
    pli_rigid_destroy(rigid_);
    rigid_ = nullptr;
    fingerprint_ = 0;
}

void RigidProxy::set_present(bool is_present) {
    is_present_ = is_present;
    (void)pli_rigid_set_present(rigid_, is_present);
}

void RigidProxy::let_go() {
    is_let_go = true;
    set_present(false);
    let_go_of_shapes();
}

void RigidProxy::let_go_of_shapes() {
    for (const ShapePart& part : parts_) {
        if (part.asked != nullptr) { part.asked->is_gone = true; }
    }
    convex_shapes_.clear();
    fingerprint_ = 0;
}

void RigidProxy::reset() {
    drop_rigid();
    use_sampled_mesh(std::nullopt);
    is_present_ = true;
    is_pinned = is_followed = was_in_world = is_let_go = false;
}

void RigidProxy::follow_restored() {
    if (rigid_ == nullptr) { return; }
    kind_ = pli_rigid_get_kind(rigid_);
    has_response_ = false;
    set_present(is_present_);
}

void RigidProxy::note_place() {
    world_array_index_ = object_->getWorldArrayIndex();
}

RigidProxy::Place RigidProxy::find_in(const btCollisionObjectArray& world_objects) {
    auto* object = const_cast<btCollisionObject*>(object_); // only to compare
    const bool is_where_it_was = world_array_index_ >= 0 && world_array_index_ < world_objects.size() &&
                                 world_objects[world_array_index_] == object;
    if (!is_where_it_was) { world_array_index_ = world_objects.findLinearSearch(object); }
    if (world_array_index_ == world_objects.size()) { return Place::not_here; }
    return is_of(*object_) ? Place::here : Place::taken_by_another;
}

const btConvexShape* RigidProxy::convex_shape(int shape, btTransform& pose) const {
    const auto index = static_cast<std::size_t>(shape);
    if (index >= convex_shapes_.size()) { return nullptr; }
    pose = captured_pose_ * convex_poses_[index];
    return convex_shapes_[index];
}

pli_rigid_kind RigidProxy::kind(CollisionMode mode) const {
    if (object_->isKinematicObject()) { return PLI_RIGID_KINEMATIC; }
    // Impulses would only gather in the velocity of a body that Bullet does not move; btSoftBody lets them.
    const bool is_held = object_->getActivationState() == DISABLE_SIMULATION && mode == CollisionMode::exact;
    const bool is_movable = body_ != nullptr && !object_->isStaticObject() && body_->getInvMass() > 0 && !is_held;
    return is_movable ? PLI_RIGID_DYNAMIC : PLI_RIGID_STATIC;
}

void RigidProxy::read_state(pli_rigid_state& state) const {
    state.pose = to_pli(object_->getWorldTransform());
    if (body_ != nullptr) {
        state.linear_velocity = to_pli(body_->getLinearVelocity());
        state.angular_velocity = to_pli(body_->getAngularVelocity());
        state.inverse_mass = to_float(body_->getInvMass());
        state.inverse_inertia_world = to_pli(body_->getInvInertiaTensorWorld());
    }
}

bool RigidProxy::is_driven(btScalar dt) const {
    return dt > 0 && body_ != nullptr && body_->isKinematicObject() &&
           !(body_->getLinearVelocity().isZero() && body_->getAngularVelocity().isZero());
}

// Bullet has moved it before its sub-steps, to where its velocity leads in all of them. From where it is in the core it
// goes on by one. A game that moves it in a tick callback does so by one step, at another speed than Bullet has seen.
// One that is where it was, or is met for the first time, and is fast all the same was placed by setWorldTransform
// after it was made, which Bullet takes for a motion from the origin.
RigidProxy::Motion RigidProxy::driven_motion(btScalar dt) const {
    const btVector3 &velocity = body_->getLinearVelocity(), &spin = body_->getAngularVelocity();
    const btTransform& present = body_->getWorldTransform();
    const btScalar way = velocity.length() * dt, turn = spin.length() * dt;
    Motion motion{present, present, velocity, spin, false};
    const btTransform before = rigid_ == nullptr ? present : to_bullet(pli_rigid_get_state(rigid_).pose);
    const bool is_fast = way > jump_of_resting * jump_distance || turn > jump_of_resting * jump_angle;
    if (is_fast && same_bits(to_pli(before), to_pli(present))) {
        return {present, present, btVector3(0, 0, 0), btVector3(0, 0, 0), false};
    }
    btTransformUtil::integrateTransform(present, -velocity, -spin, dt, motion.start);
    if (rigid_ == nullptr) { return motion; }
    const btScalar rounding = btScalar(1e-6) * present.getOrigin().length() + btScalar(1e-5);
    const bool is_as_seen = body_->getInterpolationWorldTransform() == present;
    for (int steps = 1; steps <= (is_as_seen ? most_sub_steps : 1); ++steps) {
        const btScalar share = steps == 1 ? btScalar(0.5) : btScalar(0.02);
        btTransform led;
        btTransformUtil::integrateTransform(before, velocity, spin, dt * btScalar(steps), led);
        if (led.getOrigin().distance(present.getOrigin()) > share * way + rounding ||
            led.getRotation().angleShortestPath(present.getRotation()) > share * turn + btScalar(1e-3)) {
            continue;
        }
        motion.start = before;
        motion.is_led = true;
        if (steps > 1) { btTransformUtil::integrateTransform(before, velocity, spin, dt, motion.end); }
        if (!is_as_seen) { btTransformUtil::calculateVelocity(before, present, dt, motion.velocity, motion.spin); }
        break;
    }
    return motion;
}

void RigidProxy::follow(const Motion& motion, const btTransform& pose, pli_rigid_state& state) {
    state.pose = to_pli(pose);
    state.linear_velocity = to_pli(motion.velocity);
    state.angular_velocity = to_pli(motion.spin);
}

// Returns the pose.
btTransform RigidProxy::read_start(pli_rigid_state& state, btScalar dt) const {
    read_state(state);
    if (!is_driven(dt)) { return object_->getWorldTransform(); }
    const Motion motion = driven_motion(dt);
    follow(motion, motion.start, state);
    return motion.start;
}

void RigidProxy::capture(unsigned step, btScalar dt) {
    captured_step_ = step;
    holds_captured_ = false;
    captured_pose_ = read_start(captured_, dt);
}

inline RigidProxy::Response RigidProxy::response() const {
    const btVector3 one(1, 1, 1);
    return {body_ != nullptr ? body_->getLinearFactor() : one, body_ != nullptr ? body_->getAngularFactor() : one,
            object_->getFriction(), object_->getRestitution(), !object_->hasContactResponse()};
}

pli_status RigidProxy::create_rigid(pli_world* world, CollisionMode mode) {
    const Response present = response();
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind(mode);
    def.user_data = const_cast<btCollisionObject*>(object_); // for events; nothing here writes through it
    read_state(def.state);
    def.friction = to_float(present.friction);
    def.restitution = to_float(present.restitution);
    def.linear_factor = to_pli(present.linear_factor);
    def.angular_factor = to_pli(present.angular_factor);
    const pli_status status = pli_rigid_create(world, &def, &rigid_);
    if (status != PLI_OK) { return status; }
    kind_ = def.kind;
    response_ = present;
    has_response_ = true;
    set_present(is_present_);
    (void)pli_rigid_set_sensor(rigid_, present.is_sensor);
    return PLI_OK;
}

// What has changed since the last time.
pli_status RigidProxy::update_rigid(CollisionMode mode) {
    const pli_rigid_kind present_kind = kind(mode);
    if (present_kind != kind_) {
        pli_rigid_state state{};
        read_state(state);
        const pli_status status = pli_rigid_set_kind(rigid_, present_kind, &state);
        if (status != PLI_OK) { return status; }
        kind_ = present_kind;
    }
    const Response present = response();
    const bool is_same = has_response_ && same_bits(present.linear_factor, response_.linear_factor) &&
                         same_bits(present.angular_factor, response_.angular_factor) &&
                         same_bits(present.friction, response_.friction) &&
                         same_bits(present.restitution, response_.restitution) &&
                         present.is_sensor == response_.is_sensor;
    if (is_same) { return PLI_OK; }
    pli_status status = pli_rigid_set_factors(rigid_, to_pli(present.linear_factor), to_pli(present.angular_factor));
    if (status == PLI_OK) { status = pli_rigid_set_friction(rigid_, to_float(present.friction)); }
    if (status == PLI_OK) { status = pli_rigid_set_restitution(rigid_, to_float(present.restitution)); }
    if (status == PLI_OK) { status = pli_rigid_set_sensor(rigid_, present.is_sensor); }
    if (status == PLI_OK) {
        response_ = present;
        has_response_ = true;
    }
    return status;
}

pli_status RigidProxy::prepare(const ShapeOptions& options, pli_world* world) {
    pli_status status = rigid_ == nullptr ? create_rigid(world, options.mode) : update_rigid(options.mode);
    holds_captured_ = false;
    if (status != PLI_OK) { return status; }

    const std::uint64_t fingerprint = shape_fingerprint(*object_->getCollisionShape());
    if (fingerprint == fingerprint_) { return shape_status_; }
    fingerprint_ = fingerprint;
    parts_.clear();
    ShapeOptions own_options = options;
    own_options.sampled_mesh = sampled_mesh_ ? &*sampled_mesh_ : nullptr;
    shape_status_ = make_shape_parts(*object_->getCollisionShape(), own_options, parts_);
    shapes_.clear();
    poses_.clear();
    convex_shapes_.clear();
    convex_poses_.clear();
    has_slabs_ = false;
    has_children_ = options.mode == CollisionMode::reference && object_->getCollisionShape()->isCompound();
    for (const ShapePart& part : parts_) {
        has_slabs_ = has_slabs_ || !part.shape;
        shapes_.push_back(part.shape.get());
        poses_.push_back(to_pli(part.pose));
        convex_shapes_.push_back(part.convex);
        convex_poses_.push_back(part.pose);
    }
    if (shape_status_ == PLI_ERROR_OUT_OF_MEMORY) { refresh(); } // the next step tries again
    // The shapes depend on the pair and are set for each.
    if (has_slabs_ || has_children_) { return shape_status_; }
    status = pli_rigid_set_shapes(rigid_, static_cast<int>(shapes_.size()), shapes_.data(), poses_.data());
    if (status == PLI_OK) { return shape_status_; }
    (void)pli_rigid_set_shapes(rigid_, 0, nullptr, nullptr); // those before are of another shape
    refresh();
    return status;
}

pli_status RigidProxy::give_captured_state() {
    const pli_status status = holds_captured_ ? PLI_OK : pli_rigid_set_state(rigid_, &captured_);
    holds_captured_ = holds_captured_ || status == PLI_OK;
    return status;
}

pli_status RigidProxy::collide(const ShapeOptions& options, pli_world* world, pli_body* body, TriangleSlabs& slabs) {
    pli_status status = give_captured_state();
    if (status != PLI_OK) { return status; }
    if (has_slabs_ || has_children_) {
        shapes_.clear();
        poses_.clear();
        convex_shapes_.clear();
        convex_poses_.clear();
        const pli_bounds bounds = pli_body_get_bounds(body);
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const bool is_child = has_children_ && parts_[i].convex != nullptr;
            if (is_child && !comes_to_child(parts_[i], captured_pose_, bounds)) { continue; }
            if (parts_[i].shape) {
                shapes_.push_back(parts_[i].shape.get());
                convex_shapes_.push_back(parts_[i].convex);
            } else {
                const pli_status collected = slabs.collect(options.context, static_cast<int>(i), parts_[i],
                                                           captured_pose_, bounds, shapes_, convex_shapes_);
                if (status == PLI_OK) { status = collected; }
            }
            poses_.resize(shapes_.size(), to_pli(parts_[i].pose));
            convex_poses_.resize(shapes_.size(), parts_[i].pose);
        }
        const pli_status set =
            pli_rigid_set_shapes(rigid_, static_cast<int>(shapes_.size()), shapes_.data(), poses_.data());
        if (set != PLI_OK) { return set; }
    }
    const pli_status collided = pli_world_collide_rigid(world, body, rigid_);
    return status != PLI_OK ? status : collided;
}

bool RigidProxy::has_jumped(btScalar dt) const {
    if (rigid_ == nullptr || (is_driven(dt) && driven_motion(dt).is_led)) { return false; }
    const btTransform before = to_bullet(pli_rigid_get_state(rigid_).pose), &present = object_->getWorldTransform();
    btTransform led = before;
    btScalar scale = jump_of_resting;
    if (is_driven(dt)) {
        btTransformUtil::integrateTransform(before, body_->getLinearVelocity(), body_->getAngularVelocity(), dt, led);
        scale = 1;
    }
    return present.getOrigin().distance(led.getOrigin()) > scale * jump_distance ||
           present.getRotation().angleShortestPath(led.getRotation()) > scale * jump_angle;
}

pli_status RigidProxy::set_start_state(CollisionMode mode, btScalar dt) {
    // The game may have made it static: the core takes no dynamic body without mass.
    const pli_status status = kind(mode) != kind_ ? update_rigid(mode) : PLI_OK;
    if (status != PLI_OK) { return status; }
    (void)read_start(present_, dt);
    return set_present_state();
}

void RigidProxy::read_present_state(btScalar dt) {
    read_state(present_);
    if (!is_driven(dt)) { return; }
    const Motion motion = driven_motion(dt);
    follow(motion, motion.end, present_);
}

pli_status RigidProxy::set_present_state() {
    holds_captured_ = false;
    const pli_status status = pli_rigid_set_state(rigid_, &present_);
    // An object without finite numbers is left where it was.
    if (status != PLI_OK) { present_ = pli_rigid_get_state(rigid_); }
    return status;
}

void RigidProxy::go_along(btScalar dt) {
    if (rigid_ == nullptr || kind_ != PLI_RIGID_KINEMATIC) { return; }
    read_present_state(dt);
    (void)set_present_state();
}

bool RigidProxy::has_changed(btScalar dt) const {
    if (rigid_ == nullptr || is_driven(dt)) { return false; }
    const pli_transform before = pli_rigid_get_state(rigid_).pose, present = to_pli(object_->getWorldTransform());
    return std::memcmp(&before, &present, sizeof present) != 0 ||
           pli_rigid_is_sensor(rigid_) == object_->hasContactResponse() ||
           fingerprint_ != shape_fingerprint(*object_->getCollisionShape());
}

bool RigidProxy::comes_on(btScalar dt, btVector3& low, btVector3& high) const {
    if (rigid_ == nullptr || !is_driven(dt)) { return false; }
    const Motion motion = driven_motion(dt);
    if (!motion.is_led) { return false; }
    btVector3 start_low, start_high;
    object_->getCollisionShape()->getAabb(motion.end, low, high);
    object_->getCollisionShape()->getAabb(motion.start, start_low, start_high);
    low.setMin(start_low);
    high.setMax(start_high);
    return true;
}

bool RigidProxy::write_back(unsigned step, btScalar dt) {
    if (kind_ != PLI_RIGID_DYNAMIC || !pli_rigid_was_touched(rigid_)) { return false; }
    // Only this class may change a Bullet body, and it got the object as const from Bullet's dispatcher.
    auto* body = const_cast<btRigidBody*>(body_);
    const pli_rigid_state after = pli_rigid_get_state(rigid_);
    const btVector3 velocity = with_change(body->getLinearVelocity(), present_.linear_velocity, after.linear_velocity);
    const btVector3 spin = with_change(body->getAngularVelocity(), present_.angular_velocity, after.angular_velocity);
    const btScalar speed_limit = body->getLinearSleepingThreshold(), spin_limit = body->getAngularSleepingThreshold();
    const bool is_slow =
        velocity.length2() < speed_limit * speed_limit && spin.length2() < spin_limit * spin_limit && dt > 0;
    // What has just fallen asleep with the soft body, which does so in the next step, has no weight any more.
    if (is_slow && pair_count > 0 && !body->isActive()) {
        (void)set_present_state();
        return false;
    }
    if (!same_bits(after.linear_velocity, present_.linear_velocity)) { body->setLinearVelocity(velocity); }
    if (!same_bits(after.angular_velocity, present_.angular_velocity)) { body->setAngularVelocity(spin); }
    pli_vec3 shift, rotation;
    const bool is_shifted = pli_rigid_get_shift(rigid_, &shift, &rotation);
    if (is_shifted) { move(*body, to_bullet(shift), to_bullet(rotation)); }
    // Bullet counts from here for how long a body has been slow. What a soft body touches is in its island, and wakes
    // with it; what it only holds by an anchor from afar is not.
    if (!is_slow || !body->isActive()) { body->activate(); }
    // Position-based anchors hand on what they do by velocities, which Bullet's solver finds in the next step.
    if (!is_shifted || !(dt > 0)) { return false; }
    if (!hold_) { hold_.emplace(*body); }
    hold_->follow(present_, after, dt, hold_step_ + 1 == step);
    hold_step_ = step;
    return true;
}

void RigidProxy::set_hold(const Hold& hold, unsigned step) {
    if (!hold_) { hold_.emplace(*const_cast<btRigidBody*>(body_)); }
    hold_->hold = hold;
    hold_step_ = step;
}

void RigidProxy::take_back_hold() {
    btVector3 velocity, spin;
    const btScalar dt = hold_->lent(velocity, spin);
    if (dt == 0 || (velocity.isZero() && spin.isZero())) { return; }
    auto* body = const_cast<btRigidBody*>(body_);
    body->setLinearVelocity(body->getLinearVelocity() - velocity);
    body->setAngularVelocity(body->getAngularVelocity() - spin);
    move(*body, -velocity * dt, -spin * dt);
}

} // namespace pliant
