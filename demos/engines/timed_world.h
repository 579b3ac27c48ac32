#ifndef DEMOS_TIMED_WORLD_H
#define DEMOS_TIMED_WORLD_H

// Bullet's worlds and dispatcher with a clock at the places where they call soft bodies.

#include "soft_clock.h"

#include <btBulletDynamicsCommon.h>

#include <utility>

namespace demos {

inline bool is_soft(const btCollisionObject& object) {
    return (object.getInternalType() & (btCollisionObject::CO_SOFT_BODY | btCollisionObject::CO_USER_TYPE)) != 0;
}

class TimedDispatcher final : public btCollisionDispatcher {
public:
    TimedDispatcher(btCollisionConfiguration* configuration, SoftClock& clock)
        : btCollisionDispatcher(configuration), clock_(clock) {
        setNearCallback(meet);
    }

private:
    static void meet(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
        const auto& object0 = *static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject);
        const auto& object1 = *static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject);
        if (!is_soft(object0) && !is_soft(object1)) {
            defaultNearCallback(pair, dispatcher, info);
            return;
        }
        const SoftClock::Window window(static_cast<TimedDispatcher&>(dispatcher).clock_, SoftPart::collide);
        defaultNearCallback(pair, dispatcher, info);
    }

    SoftClock& clock_;
};

// The list of overlapping pairs is the broad phase's, whoever overlaps.
class PausingPairCache final : public btHashedOverlappingPairCache {
public:
    explicit PausingPairCache(SoftClock& clock) : clock_(clock) {}
    btBroadphasePair* addOverlappingPair(btBroadphaseProxy* proxy0, btBroadphaseProxy* proxy1) override {
        const SoftClock::Pause pause(clock_);
        return btHashedOverlappingPairCache::addOverlappingPair(proxy0, proxy1);
    }

private:
    SoftClock& clock_;
};

template <class World> class TimedWorld final : public World {
public:
    template <class... Arguments>
    explicit TimedWorld(SoftClock& clock, Arguments&&... arguments)
        : World(std::forward<Arguments>(arguments)...), clock_(clock) {}

    // A btSoftBody tells the broad phase its bounds when it predicts, before those of rigid bodies are brought up to
    // date. The order of pairs, of which that of rigid contacts follows, depends on it.
    void set_soft_bounds_first(bool first) { soft_bounds_first_ = first; }

    void updateAabbs() override {
        btCollisionObjectArray& objects = this->getCollisionObjectArray();
        for (int i = 0; soft_bounds_first_ && i < objects.size(); ++i) {
            if (!is_soft(*objects[i])) { continue; }
            const SoftClock::Window window(clock_, SoftPart::predict);
            btVector3 low, high;
            objects[i]->getCollisionShape()->getAabb(objects[i]->getWorldTransform(), low, high);
            this->getBroadphase()->setAabb(objects[i]->getBroadphaseHandle(), low, high, this->getDispatcher());
        }
        for (int i = 0; i < objects.size(); ++i) {
            if (!this->getForceUpdateAllAabbs() && !objects[i]->isActive()) { continue; }
            if (is_soft(*objects[i])) {
                const SoftClock::Window window(clock_, SoftPart::predict); // the bridge predicts at the first of these
                this->updateSingleAabb(objects[i]);
            } else {
                this->updateSingleAabb(objects[i]);
            }
        }
    }

private:
    SoftClock& clock_;
    bool soft_bounds_first_ = false;
};

} // namespace demos
#endif
