#ifndef PLIANT_BULLET_RIGID_PROXY_H
#define PLIANT_BULLET_RIGID_PROXY_H

// The core's picture of one collision object of Bullet. It lives while the object is in the world and can meet soft
// bodies (when made ahead), or while a pair or the user (anchors) needs it.
//
// An object may be deleted as soon as it is out of the world, at any time: between steps, in a tick callback, in
// another action, in the middle of a solve. So a proxy reads it only where Bullet has just shown that it lives: while
// Bullet or the user hands it over, while a pair with it is in use (Bullet ends pairs with their objects), or after
// find_in().

#include "bridge_impl.h"
#include "hold_constraint.h"
#include "object_identity.h"
#include "shapes/shapes.h"

#include <LinearMath/btAlignedObjectArray.h>

#include <optional>

class btRigidBody;

namespace pliant {

class TriangleSlabs;

class RigidProxy {
public:
    explicit RigidProxy(const btCollisionObject& object);
    ~RigidProxy();
    RigidProxy(const RigidProxy&) = delete;
    RigidProxy& operator=(const RigidProxy&) = delete;

    const btCollisionObject* object() const { return object_; } // mostly to compare
    /// Whether a living object at the address is the one that the proxy is of.
    bool is_of(const btCollisionObject& object) const { return ObjectIdentity(object) == identity_; }
    enum class Place { here, not_here, taken_by_another };
    /// Looks for the object in the world's list.
    Place find_in(const btAlignedObjectArray<btCollisionObject*>& world_objects);
    /// Bullet has shown it in the world in this step.
    void note_place();
    pli_rigid* rigid() const { return rigid_; }
    /// Bullet's shape behind a shape of the core's body and where it was at the start of the step; null: not convex.
    const btConvexShape* convex_shape(int shape, btTransform& pose) const;

    /// Keeps the state at the start of this step for its contacts; once per step.
    void capture(unsigned step, btScalar dt);
    bool is_captured(unsigned step) const { return captured_step_ == step; }

    /// Makes the core's body, or brings its kind, response and shapes up to date.
    pli_status prepare(const ShapeOptions& options, pli_world* world);
    /// The core's body gets the captured state, if it has another.
    pli_status give_captured_state();
    /// Contacts of a body with the captured state, with the shapes that Bullet would meet it with: in reference mode.
    pli_status collide(const ShapeOptions& options, pli_world* world, pli_body* body, TriangleSlabs& slabs);
    /// One that is not dynamic is not where its velocity leads in the step from where the core's body is.
    bool has_jumped(btScalar dt) const;
    /// The core's body is where this step finds it, before the prediction.
    pli_status set_start_state(CollisionMode mode, btScalar dt);
    /// From the captured state to the one after Bullet's solver, in two steps. `dt`: of the step that ends; 0: of none.
    void read_present_state(btScalar dt);
    pli_status set_present_state();
    /// The core's body of a kinematic one that nothing met goes along, to be where it is when something does.
    void go_along(btScalar dt);
    /// The object was put elsewhere, has another shape, or has become a sensor or ceased to be one since it took part.
    bool has_changed(btScalar dt) const;
    /// Bounds of a kinematic body in the step, at whose end or further ahead Bullet has it; false: it does not come on.
    bool comes_on(btScalar dt, btVector3& low, btVector3& high) const;
    /// Hands velocities that the core changed back to Bullet, moves the body once more where face contacts held it
    /// back, and wakes it if something acted on it. `dt`: s, 0 in reference mode, in which it always wakes. Returns
    /// whether something held it, for Bullet's solver in the next step.
    bool write_back(unsigned step, btScalar dt);
    void set_hold(const Hold& hold, unsigned step);
    /// Null: nothing held it in that step.
    HoldConstraint* hold_of(unsigned step) { return hold_step_ == step && hold_ ? &*hold_ : nullptr; }
    HoldConstraint& hold() { return *hold_; } ///< of one that has had some
    /// After Bullet's solver: what the hold has lent it there.
    void take_back_hold();
    /// Destroys the core's body with its anchors; prepare() makes another one.
    void drop_rigid();
    /// False: the object is not (yet) in the world; anchors hold nothing.
    void set_present(bool is_present);
    /// The object may be deleted from now on, and its shapes with it: nothing touches them, and anchors hold nothing.
    /// The bridge lets go of the core's body when the step is over.
    void let_go();
    /// The same for its shapes; prepare() makes them anew.
    void let_go_of_shapes();
    /// The core's body is as it was at some moment before: what it has of the object is to be handed over again.
    void follow_restored();
    /// As new, but for its pairs. Not inside a step.
    void reset();
    /// The shapes were edited in place.
    void refresh() { fingerprint_ = 0; }
    /// Whether and how triangles are sampled, from the next prepare() on.
    void use_sampled_mesh(const std::optional<pli_sampled_mesh_def>& def) {
        sampled_mesh_ = def;
        refresh();
    }
    const std::optional<pli_sampled_mesh_def>& sampled_mesh() const { return sampled_mesh_; }

    bool is_dynamic() const { return kind_ == PLI_RIGID_DYNAMIC; }
    bool is_needed() const { return pair_count > 0 || is_pinned || is_followed; }

    int pair_count = 0;        ///< algorithms that use it
    bool is_pinned = false;    ///< the user has it
    bool is_followed = false;  ///< kept as long as its object is in the world
    int followed_id = -1;      ///< of the object in the broad phase
    bool was_in_world = false; ///< pinned ones are let go of when their object leaves the world
    bool is_let_go = false;
    unsigned present_step = 0; ///< the last step that it took part in

private:
    /// How it answers to impulses and contacts, as Bullet has it.
    struct Response {
        btVector3 linear_factor, angular_factor;
        btScalar friction, restitution;
        bool is_sensor;
    };
    /// Where a kinematic body is at the start and the end of a step.
    struct Motion {
        btTransform start, end;
        btVector3 velocity, spin;
        bool is_led; ///< from where the core's body is, by its velocity
    };
    bool is_driven(btScalar dt) const; ///< a kinematic body that has a velocity in a step
    Motion driven_motion(btScalar dt) const;
    static void follow(const Motion& motion, const btTransform& pose, pli_rigid_state& state);
    pli_rigid_kind kind(CollisionMode mode) const;
    Response response() const;
    pli_status create_rigid(pli_world* world, CollisionMode mode);
    pli_status update_rigid(CollisionMode mode);
    void read_state(pli_rigid_state& state) const; // of what is no btRigidBody the pose only
    btTransform read_start(pli_rigid_state& state, btScalar dt) const;

    const btCollisionObject* object_;
    const btRigidBody* body_; ///< null for plain collision objects
    ObjectIdentity identity_;
    int world_array_index_ = -1; ///< where it was last
    bool is_present_ = true;
    pli_rigid* rigid_ = nullptr;
    pli_rigid_kind kind_ = PLI_RIGID_STATIC; ///< the core's body has these two
    Response response_{};
    bool has_response_ = false; ///< the core's body has it
    unsigned captured_step_ = 0;
    bool holds_captured_ = false; ///< the core's body has the captured state
    pli_rigid_state captured_{};
    btTransform captured_pose_;
    pli_rigid_state present_{};
    std::optional<HoldConstraint> hold_; ///< none: nothing ever held it
    unsigned hold_step_ = 0;             ///< the last one in which something did
    std::optional<pli_sampled_mesh_def> sampled_mesh_;
    std::vector<ShapePart> parts_;
    bool has_slabs_ = false;
    bool has_children_ = false; ///< of a compound, of which Bullet comes to some only; reference mode
    std::uint64_t fingerprint_ = 0;
    pli_status shape_status_ = PLI_OK;
    std::vector<pli_shape*> shapes_;                  ///< scratch
    std::vector<pli_transform> poses_;                ///< scratch
    std::vector<const btConvexShape*> convex_shapes_; ///< one per shape of the core's body, null: not convex
    std::vector<btTransform> convex_poses_;           ///< in the object
};

} // namespace pliant

#endif
