#ifndef PLIANT_BULLET_ACCUMULATOR_H
#define PLIANT_BULLET_ACCUMULATOR_H

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

namespace pliant {

/// Bullet shows its accumulator to classes of its own.
struct Accumulator : btDiscreteDynamicsWorld {
    static btScalar& time(btDiscreteDynamicsWorld& world) { return world.*(&Accumulator::m_localTime); }
    static btScalar step(const btDiscreteDynamicsWorld& world) { return world.*(&Accumulator::m_fixedTimeStep); }
};

} // namespace pliant

#endif
