#ifndef PLIANT_BULLET_OBJECT_IDENTITY_H
#define PLIANT_BULLET_OBJECT_IDENTITY_H

class btCollisionObject;

namespace pliant {

/// What tells a rigid body from whatever is made at its address after its end. It stays the same when the body leaves
/// the world and comes back, which its id in the broad phase does not. Objects that are no rigid bodies have their type
/// only.
struct ObjectIdentity {
    int type, number;

    explicit ObjectIdentity(const btCollisionObject& object);
    bool operator==(const ObjectIdentity& o) const { return type == o.type && number == o.number; }
};

} // namespace pliant

#endif
