#include "object_identity.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace pliant {

namespace {

// Bullet numbers rigid bodies in the order in which a process makes them, and has no function that tells the number. An
// explicit instantiation may name private members.
using BodyNumber = int btRigidBody::*;

struct BodyNumberKey {
    friend BodyNumber body_number(BodyNumberKey);
};

template <BodyNumber Member> struct ShowBodyNumber {
    friend BodyNumber body_number(BodyNumberKey) { return Member; }
};
template struct ShowBodyNumber<&btRigidBody::m_debugBodyId>;

} // namespace

ObjectIdentity::ObjectIdentity(const btCollisionObject& object) : type(object.getInternalType()), number(0) {
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body != nullptr) { number = body->*body_number(BodyNumberKey()); }
}

} // namespace pliant
