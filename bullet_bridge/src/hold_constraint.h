#ifndef PLIANT_BULLET_HOLD_CONSTRAINT_H
#define PLIANT_BULLET_HOLD_CONSTRAINT_H

// What soft bodies hold a rigid body with, as Bullet's solver sees it. The core holds the body after Bullet's solver,
// which would take it for a free one: what stands on it or hangs from it by a joint would push it off in each step.

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <pliant/rigid.h>

namespace pliant {

/// Of the last step; zero: nothing held the body.
struct Hold {
    btVector3 force{0, 0, 0};    ///< N, along the mean of the last steps
    btVector3 torque{0, 0, 0};   ///< N m, mean of the last steps
    btVector3 velocity{0, 0, 0}; ///< m/s, likewise
};

/// Keeps the body from going back along force and torque, by impulses of at most twice theirs. It holds for the time of
/// Bullet's solver only, and is taken back after it: the core does it in truth. So what it lends is none of the energy
/// or momentum of the world; contacts and joints take their share as from a body that something holds.
class HoldConstraint : public btTypedConstraint {
public:
    explicit HoldConstraint(btRigidBody& body);
    HoldConstraint(const HoldConstraint&) = delete;
    HoldConstraint& operator=(const HoldConstraint&) = delete;
    /// The core has changed velocities in a step of `dt` s. `was_held`: in the step before too.
    void follow(const pli_rigid_state& before, const pli_rigid_state& after, btScalar dt, bool was_held);
    void begin_step() { dt_ = 0; }
    /// Changes of velocity that it brought in Bullet's solver, in a step of the returned length; 0: it was not solved.
    btScalar lent(btVector3& velocity, btVector3& spin) const;
    Hold hold;

    void getInfo1(btConstraintInfo1* info) override;
    void getInfo2(btConstraintInfo2* info) override;
    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }

private:
    btJointFeedback feedback_{};                               ///< by Bullet's solver
    btScalar dt_ = 0;                                          ///< s, of the step that it was solved in
    btMatrix3x3 inverse_inertia_ = btMatrix3x3::getIdentity(); ///< of the body then; it has turned since
};

/// The list that Bullet's solver takes, which is open to classes of its own. The functions for it also touch the body,
/// which may be gone when the constraint goes.
struct ConstraintList : btDiscreteDynamicsWorld {
    static btAlignedObjectArray<btTypedConstraint*>& of(btDiscreteDynamicsWorld& world) {
        return world.*(&ConstraintList::m_constraints);
    }
};

} // namespace pliant

#endif
