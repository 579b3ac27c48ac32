#include "hold_constraint.h"

#include "convert.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace pliant {

namespace {

// Of the last step's impulse: more lets a hold grow faster under what lands on it, and lends more to what is thrown
// against it from another side.
constexpr btScalar most_of_last = 2;

// s, over which velocities and torques are smoothed, and directions of forces: those of one step tremble with the
// ropes. What a hold lends against a joint of Bullet the joint takes, and the soft body gives it back as the next
// torque; taken as it is, that makes a wheel wobble on its axle until it bursts. Forces may grow at once, under what
// lands.
constexpr btScalar smoothing_time = btScalar(0.2), turning_time = btScalar(0.05);

btVector3 direction_of(const btVector3& v) {
    return v.fuzzyZero() ? btVector3(1, 0, 0) : v.normalized();
}

} // namespace

HoldConstraint::HoldConstraint(btRigidBody& body) : btTypedConstraint(MAX_CONSTRAINT_TYPE, body) {
    setJointFeedback(&feedback_);
}

void HoldConstraint::follow(const pli_rigid_state& before, const pli_rigid_state& after, btScalar dt, bool was_held) {
    const btMatrix3x3& basis = m_rbA.getWorldTransform().getBasis();
    const btVector3 change = to_bullet(after.linear_velocity) - to_bullet(before.linear_velocity);
    const btVector3 spin = to_bullet(after.angular_velocity) - to_bullet(before.angular_velocity);
    const btVector3 force = change / (m_rbA.getInvMass() * dt);
    const btVector3 torque =
        basis * (m_rbA.getLocalInertia() * (basis.transpose() * spin)) * m_rbA.getAngularFactor() / dt;
    const btVector3 velocity = to_bullet(after.linear_velocity);
    if (!was_held) { hold = {force, torque, velocity}; }
    const btVector3 along = direction_of(hold.force.lerp(force, dt / (turning_time + dt)));
    const btScalar share = dt / (smoothing_time + dt);
    hold.force = along * btMax(btScalar(0), force.dot(along));
    hold.torque = hold.torque.lerp(torque, share);
    hold.velocity = hold.velocity.lerp(velocity, share);
}

void HoldConstraint::getInfo1(btConstraintInfo1* info) {
    info->m_numConstraintRows = 2;
    info->nub = 0;
}

void HoldConstraint::getInfo2(btConstraintInfo2* info) {
    dt_ = 1 / info->fps;
    inverse_inertia_ = m_rbA.getInvInertiaTensorWorld();
    const btVector3 along = direction_of(hold.force), about = direction_of(hold.torque);
    for (int i = 0; i < 3; ++i) {
        info->m_J1linearAxis[i] = along[i];
        info->m_J1angularAxis[info->rowskip + i] = about[i];
    }
    // Where the ropes are let down, it goes with them.
    info->m_constraintError[0] = btMin(btScalar(0), hold.velocity.dot(along));
    info->m_lowerLimit[0] = info->m_lowerLimit[info->rowskip] = 0;
    info->m_upperLimit[0] = most_of_last * dt_ * hold.force.length();
    info->m_upperLimit[info->rowskip] = most_of_last * dt_ * hold.torque.length();
}

btScalar HoldConstraint::lent(btVector3& velocity, btVector3& spin) const {
    velocity = feedback_.m_appliedForceBodyA * (dt_ * m_rbA.getInvMass());
    spin = inverse_inertia_ * feedback_.m_appliedTorqueBodyA * m_rbA.getAngularFactor() * dt_;
    return dt_;
}

} // namespace pliant
