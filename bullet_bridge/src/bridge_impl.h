#ifndef PLIANT_BULLET_BRIDGE_IMPL_H
#define PLIANT_BULLET_BRIDGE_IMPL_H

// The bridge's state and its step. Pairs are collected by pair_algorithm.cpp during Bullet's collision detection.

#include "hold_constraint.h"
#include "pliant_bullet/pliant_bullet.h"

#include <LinearMath/btVector3.h>

#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

class btCollisionWorld;
class btIDebugDraw;

namespace pliant {

class BridgeAction;
class PairAlgorithm;
class RigidProxy;
class SoftObject;

/// An object as the Bullet world has it. Another one at the same address mostly differs in something.
struct FollowedObject {
    const btCollisionObject* object;
    int type, number, id, group, mask; ///< `number` as in ObjectIdentity

    explicit FollowedObject(const btCollisionObject& of);
    bool operator==(const FollowedObject& o) const {
        return object == o.object && type == o.type && number == o.number && id == o.id && group == o.group &&
               mask == o.mask;
    }
};

class Bridge::Impl {
public:
    Impl(btDiscreteDynamicsWorld& bullet_world, const BridgeDef& def);
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    // ---- BridgeAction calls
    void update(btCollisionWorld& bullet_world, btScalar dt);
    void debug_draw(btIDebugDraw* drawer);

    // ---- SoftShape and SoftObject calls, for an object that is in the Bullet world
    void predict_inside_step();
    /// From right before Bullet's collision detection to the end of the bridge's part.
    bool is_inside_step() const;
    /// Bounds of a soft body get to what Bullet has ahead of where the body meets it, if there is something.
    bool has_ahead() const { return !ahead_.empty(); }
    void reach_ahead(btVector3& low, btVector3& high) const;
    /// The object of a proxy, where the Bullet world has it now: it may have been deleted without notice. Null also for
    /// rigid bodies that the game has made in the core's world, with user data of its own.
    const btCollisionObject* living_object(const pli_rigid& rigid) const;
    /// The game has deleted the object, as Bullet's own examples do with all that a world has at its end.
    void end_body_of(const SoftObject& object);

    // ---- PairAlgorithm calls, from any thread of Bullet's dispatcher
    RigidProxy* acquire_proxy(const btCollisionObject& object);
    /// Remembers the pair for this step, with the rigid state of now.
    void collect(PairAlgorithm& pair);
    /// The pair's algorithm goes away.
    void drop(PairAlgorithm& pair);

    // ---- Bridge calls
    pli_status add_body(const pli_mesh* mesh, const pli_body_def* def, pli_body** body, int group, int mask);
    pli_status remove_body(pli_body* body);
    SoftObject* find(const pli_body* body) const;
    /// Null: the core's body is not of this bridge.
    float interpolation() const;
    const RigidProxy* find_proxy(const pli_rigid& rigid) const;
    pli_rigid* pin_proxy(const btCollisionObject& object);
    void forget(const btCollisionObject& object);
    void refresh(const btCollisionObject& object);
    pli_status use_sampled_mesh(const btCollisionObject& object, const pli_sampled_mesh_def& def);
    void detach();
    /// Whether the bridge is at work below, in code of the game that it has called: then it ends with its part.
    bool end_later();

    // ---- BridgeSnapshot calls
    /// Null inside a step, and when it is not known to live: no body is in it.
    btDiscreteDynamicsWorld* bullet_world_between_steps() const;
    /// What the bridge itself knows beyond the core's world.
    struct Knowledge {
        std::optional<pli_vec3> followed_gravity;
        struct Activation {
            bool is_frozen_by_bridge, wants_sleep, is_asleep;
        };
        std::vector<Activation> activations; ///< [bodies]
        std::vector<Hold> holds;             ///< [objects of the Bullet world], zero: of one that nothing holds
    };
    /// Makes proxies ahead, so that what is saved before a step has those that the step finds.
    void save_knowledge(Knowledge& knowledge);
    /// Of an object that was met or made ahead; null: of none.
    pli_rigid* known_rigid(const btCollisionObject& object) const;
    /// After the core's world.
    void restore_knowledge(const Knowledge& knowledge);
    /// While Bullet finds its pairs anew, which end and begin though no object has gone.
    void set_restoring(bool is_restoring) { is_restoring_ = is_restoring; }
    /// For errors that the bridge finds itself: pli_context_fail.
    pli_status fail(pli_status found, const char* function, const char* message) const {
        return pli_context_fail(context, found, function, message);
    }
    /// Of calls that need bullet_world_between_steps().
    pli_status fail_between_steps(const char* function) const {
        return fail(PLI_ERROR_WRONG_STATE, function,
                    "wanted is a bridge with bodies in a Bullet world that is not in a step");
    }

    pli_status status = PLI_OK;
    pli_status step_status = PLI_OK;
    CollisionMode mode;
    float surface_thickness;
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    std::function<void()> before_solve;

private:
    enum class WorldState { alive, gone, unknown };

    bool is_stepping() const { return pli_world_is_stepping(world); }
    WorldState bullet_world_state() const;
    std::unique_ptr<RigidProxy>& proxy_of(const btCollisionObject& object);
    void pin(RigidProxy& proxy);
    void leave_world();
    void begin_step(btScalar dt);
    void follow_activation(SoftObject& object, bool should_rest);
    void wake(SoftObject& object);
    void wake_met(btScalar dt);
    void look_for_grounds();
    void wake_left();
    void follow_kinematic();
    void offer_sleep();
    void follow_gravity();
    void follow_transforms();
    void sort_pairs();
    void collide_pairs();
    void collide_pairs_as_reference();
    void collide_rigid_pairs();
    void sort_rigid_pairs();
    void take_part(RigidProxy& proxy);
    void finish_step();
    void find_loaded();
    void show_holds();
    void hide_holds();
    RigidProxy* living_proxy(const pli_rigid& rigid) const;
    void pin_held();
    void look_for_new_pinned();
    void look_for_pinned(btScalar dt);
    void take_part_of_pinned();
    void let_go(RigidProxy& proxy);
    void let_go_of_removed();
    void finish_let_go();
    void follow_world();
    void follow(const btCollisionObject& object);
    void make_room();
    void sweep_proxies();
    void note(pli_status result) {
        if (step_status == PLI_OK) { step_status = result; }
    }

    btDiscreteDynamicsWorld* bullet_world_;    ///< null: detached
    std::unique_ptr<BridgeAction> action_;     ///< in the Bullet world
    std::optional<pli_vec3> followed_gravity_; ///< Bullet's, as last handed over; none: the game gave one
    bool owns_context_ = false;
    bool dispatches_in_parallel_ = false;
    bool collects_pairs_ = false;     ///< from the prediction to the contacts
    bool has_unused_proxies_ = false; ///< their last pair went away inside a step
    bool has_pinned_ = false;         ///< of proxies, or had in the last step
    bool has_holds_ = false;          ///< of proxies, in the last step
    bool has_let_go_ = false;         ///< of proxies, which the end of the step takes away
    bool prepares_ahead_ = true;
    bool is_restoring_ = false;
    bool detaches_after_step_ = false;
    bool is_at_work_ = false;
    bool ends_after_step_ = false;
    unsigned step_ = 0;
    btScalar followed_dt_ = 0; ///< s, of the step; 0 in reference mode, where kinematic bodies are met as by btSoftBody
    std::vector<std::unique_ptr<SoftObject>> objects_;
    std::vector<pli_body*> bodies_to_end_; ///< their objects were deleted inside a step
    std::unordered_map<const btCollisionObject*, std::unique_ptr<RigidProxy>> proxies_;
    std::vector<std::unique_ptr<RigidProxy>> replaced_; ///< let go of, and another object is at the address
    std::vector<FollowedObject> followed_;              ///< what the Bullet world held when proxies were made ahead
    std::vector<PairAlgorithm*> pairs_;                 ///< of this step, in dispatch order; null: the pair went away
    struct RigidPair {
        int place, order; ///< of the soft body in the Bullet world; of the pair
        pli_rigid_pair pair;
    };
    std::vector<RigidProxy*> kinematic_; ///< of the Bullet world, in the step
    struct Ahead {
        btVector3 low, high;             ///< bounds of a kinematic body in the step
        btVector3 ahead_low, ahead_high; ///< where Bullet has it: at the end of the frame
    };
    std::vector<Ahead> ahead_;                ///< that Bullet has elsewhere
    std::vector<RigidPair> sorted_pairs_;     ///< scratch
    std::vector<pli_rigid_pair> rigid_pairs_; ///< scratch
    std::vector<pli_body_pair> body_pairs_;   ///< scratch
    std::vector<int> places_;                 ///< of their bodies in the Bullet world
    std::vector<RigidProxy*> touched_;        ///< proxies that take part in this step's solve
    std::vector<RigidProxy*> held_;           ///< in the step, those whose holds Bullet's solver sees
    std::vector<bool> loaded_;                ///< objects with contacts or joints of Bullet
    std::mutex mutex_;                        ///< guards proxies_, replaced_ and pairs_ during Bullet's dispatch
};

} // namespace pliant

#endif
