#include "pair_algorithm.h"

#include "contact_query.h"
#include "soft_object.h"

#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btEmptyCollisionAlgorithm.h>
#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <new>

namespace pliant {

PairAlgorithm::PairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const SoftObject& soft_object,
                             const SoftObject* other_soft_object, const btCollisionObject& other_object)
    : btCollisionAlgorithm(info), soft(soft_object), other_soft(other_soft_object), other(other_object),
      proxy(other_soft_object != nullptr ? nullptr : soft_object.bridge().acquire_proxy(other_object)) {}

PairAlgorithm::~PairAlgorithm() {
    soft.bridge().drop(*this);
}

void PairAlgorithm::processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*,
                                     const btDispatcherInfo&, btManifoldResult*) {
    // Objects without response are sensors to soft bodies; a soft body without response meets nothing.
    if (!soft.hasContactResponse() || (other_soft != nullptr && !other.hasContactResponse())) { return; }
    const bool acts = other_soft == nullptr ||
                      (pli_body_collides_with_bodies(soft.body()) && pli_body_collides_with_bodies(other_soft->body()));
    if (acts) { soft.bridge().collect(*this); }
}

btScalar PairAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                              btManifoldResult*) {
    return btScalar(1);
}

void PairAlgorithm::getAllContactManifolds(btManifoldArray&) {}

namespace {

class PairCreateFunc final : public btCollisionAlgorithmCreateFunc {
public:
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* wrap0,
                                                   const btCollisionObjectWrapper* wrap1) override {
        const SoftObject* soft0 = SoftObject::from(wrap0->getCollisionObject());
        const SoftObject* soft1 = SoftObject::from(wrap1->getCollisionObject());
        if (soft0 == nullptr && soft1 == nullptr) {
            auto* dispatcher = static_cast<btCollisionDispatcher*>(info.m_dispatcher1);
            return dispatcher->getCollisionConfiguration()
                ->getCollisionAlgorithmCreateFunc(wrap0->getCollisionShape()->getShapeType(),
                                                  wrap1->getCollisionShape()->getShapeType())
                ->CreateCollisionAlgorithm(info, wrap0, wrap1);
        }
        const bool both = soft0 != nullptr && soft1 != nullptr;
        const SoftObject& soft = soft0 != nullptr ? *soft0 : *soft1;
        const btCollisionObject& other = soft0 != nullptr ? *wrap1->getCollisionObject() : *wrap0->getCollisionObject();
        const bool meet =
            both ? &soft0->bridge() == &soft1->bridge() : other.getInternalType() != btCollisionObject::CO_SOFT_BODY;
        if (!meet) {
            void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(btEmptyAlgorithm));
            return new (memory) btEmptyAlgorithm(info);
        }
        void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(PairAlgorithm));
        return new (memory) PairAlgorithm(info, soft, both ? soft1 : nullptr, other);
    }
};

class QueryCreateFunc final : public btCollisionAlgorithmCreateFunc {
public:
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* wrap0,
                                                   const btCollisionObjectWrapper* wrap1) override {
        const SoftObject* soft0 = SoftObject::from(wrap0->getCollisionObject());
        const SoftObject* soft1 = SoftObject::from(wrap1->getCollisionObject());
        if (soft0 == nullptr && soft1 == nullptr) {
            auto* dispatcher = static_cast<btCollisionDispatcher*>(info.m_dispatcher1);
            return dispatcher->getCollisionConfiguration()
                ->getClosestPointsAlgorithmCreateFunc(wrap0->getCollisionShape()->getShapeType(),
                                                      wrap1->getCollisionShape()->getShapeType())
                ->CreateCollisionAlgorithm(info, wrap0, wrap1);
        }
        // Of two soft bodies the one without faces is asked for its links, the other for its faces.
        const bool first = soft1 == nullptr || (soft0 != nullptr && pli_body_get_view(soft1->body()).face_count > 0);
        void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(ContactQuery));
        return new (memory) ContactQuery(info, first ? *soft0 : *soft1, first, wrap0, wrap1);
    }
};

} // namespace

void register_pair_algorithm(btCollisionDispatcher& dispatcher) {
    // They have no state, so they serve all dispatchers and may stay registered when the bridge has gone.
    static PairCreateFunc create;
    static QueryCreateFunc create_query;
    for (int type = 0; type < MAX_BROADPHASE_COLLISION_TYPES; ++type) {
        dispatcher.registerCollisionCreateFunc(soft_shape_type, type, &create);
        dispatcher.registerCollisionCreateFunc(type, soft_shape_type, &create);
        dispatcher.registerClosestPointsCreateFunc(soft_shape_type, type, &create_query);
        dispatcher.registerClosestPointsCreateFunc(type, soft_shape_type, &create_query);
    }
}

} // namespace pliant
