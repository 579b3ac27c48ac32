#ifndef PLIANT_BULLET_H
#define PLIANT_BULLET_H

/// Pliant soft bodies in a stock btDiscreteDynamicsWorld. See docs/bridge.md for the order of a step and the limits.

#include <pliant/pliant.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

class btCollisionObject;
class btDiscreteDynamicsWorld;
class btRigidBody;

namespace pliant {

/// How soft bodies see the rigid shapes of Bullet.
enum class CollisionMode {
    exact,    ///< analytic distances, hulls and triangles as they are; one-sided open surfaces. The usual choice
    reference ///< as btSoftBody does: distances on a lattice of 0.25 m, a slab of 0.1 m around each triangle. For
              ///< comparisons with it
};

/// How a bridge is made.
struct BridgeDef {
    /// m/s^2, of soft bodies. None: Bullet's getGravity(), read in each step until pli_world_set_gravity() is called.
    std::optional<pli_vec3> gravity;
    pli_world_def world = pli_world_def_default(); ///< all but its gravity
    CollisionMode mode = CollisionMode::exact;     ///< how all bodies of the bridge see rigid shapes
    /// Depth in m, above 0 to PLI_MAX_COORDINATE, behind an open triangle surface that counts as inside, exact mode.
    float surface_thickness = 0.25f;
    /// Null: the bridge makes a context and destroys it. Destroy the meshes and shapes made in it before the bridge:
    /// while some are alive the context stays, and is the caller's to destroy.
    pli_context* context = nullptr;
    /// True: the proxy of a collision object is made before the first step that finds the object in the Bullet world,
    /// if soft bodies may collide with it by its filter, so that no later step allocates for it. False: at the first
    /// overlap of bounds, for worlds with many objects of which few are touched.
    bool prepares_rigids_ahead = true;
};

/// Owns a pli_world and steps it with a Bullet world: predicts before Bullet's collision detection, takes its pairs,
/// solves after Bullet's rigid integration. Several bridges may share a Bullet world; their bodies do not collide.
///
/// Bridge and Bullet world may be destroyed in any order, and collision objects may leave the world and be deleted at
/// any time. docs/bridge.md, Lifetimes, says what happens to their anchors.
class PLI_API Bridge {
public:
    /// Makes a world and hooks it into a Bullet world; status() says whether that worked.
    explicit Bridge(btDiscreteDynamicsWorld& bullet_world, const BridgeDef& def = {});
    /// Calls detach(), then destroys the world, and the context if the bridge made it. In the hook of set_before_solve
    /// and in callbacks of the core this happens at the end of the bridge's part.
    ~Bridge();
    Bridge(const Bridge&) = delete;
    Bridge& operator=(const Bridge&) = delete;

    /// PLI_OK, or why the constructor could not make its context or world. A failed bridge returns this status, or
    /// null, from every call. The message of this, and of any call that fails, is pli_last_error(context()).
    pli_status status() const;
    /// Status of the last step: PLI_OK, or the first error; for a failed bridge status(). The message is
    /// pli_last_error(context()). After PLI_ERROR_OUT_OF_MEMORY the step was done without the things that had no memory
    /// (see pli_world_step); shapes without memory are tried again in the next step.
    pli_status step_status() const;

    /// The context of the definition, or the one that the bridge made; null when it could not be made.
    pli_context* context() const;
    /// The world that the bridge owns, for everything except stepping; null when it could not be made.
    pli_world* world() const;

    /// Makes a body from a mesh and adds its collision object to the Bullet world. Remove it by remove_body, not by
    /// pli_body_destroy. Outside of reference mode it has coloured links (pli_body_enable_colored_links);
    /// pli_body_disable_colored_links returns to the order of the mesh, as in btSoftBody.
    /// @param def   null for the defaults, which suit the mesh (PLI_MARGIN_OF_MESH)
    /// @param group, mask  Bullet's collision filter; the defaults are DefaultFilter and AllFilter
    /// @return the errors of pli_body_create; PLI_ERROR_WRONG_STATE after detach(), and when the Bullet world was
    ///         destroyed with a body of this bridge in it
    pli_status add_body(const pli_mesh* mesh, const pli_body_def* def, pli_body** body, int group = 1, int mask = -1);
    /// Removes a body and its collision object. Null is allowed.
    /// @return PLI_ERROR_WRONG_STATE inside a step, PLI_ERROR_INVALID_VALUE for a body of another bridge
    pli_status remove_body(pli_body* body);

    /// The collision object of a body; its user pointer and user indices are free for the game. It stays at the
    /// identity transform: the shape is in world space. A body whose object is inactive (DISABLE_SIMULATION,
    /// ISLAND_SLEEPING) or not in the world does not move. A game that deletes the object, after removing it from the
    /// world and before the bridge is destroyed, destroys the body too: at once, or, inside a step, at the end of the
    /// step.
    btCollisionObject* object(const pli_body* body) const;
    /// The object of a proxy, such as pli_contact_event::rigid; null when it is none of this bridge. It searches all
    /// proxies; pli_contact_event::user_data is the same pointer.
    const btCollisionObject* object(const pli_rigid* rigid) const;
    /// Null.
    btCollisionObject* object(std::nullptr_t) const { return nullptr; }
    /// The body of a collision object, null when it is no body of this bridge.
    pli_body* body(const btCollisionObject* object) const;
    /// The body of a collision object, null when it is no body of any bridge.
    static pli_body* from_object(const btCollisionObject* object);

    /// The proxy of a rigid body, for anchors (pli_body_add_anchor) and pli_body_ignore_rigid. It lives until
    /// forget(), or until the first step that no longer finds the object in the Bullet world; bodies that then lose
    /// anchors get a PLI_EVENT_ANCHORS_LOST. Before the object is in the world anchors to it have no effect; their
    /// pivots are taken from where it is now.
    /// @return null when out of memory, inside a step, after detach(), or for an object without a shape
    pli_rigid* rigid(btRigidBody& body);
    /// The same for a plain collision object, which is static.
    pli_rigid* rigid(btCollisionObject& object);
    /// Drops the proxy and the anchors that hold to it: at once, or, inside a step, at its end; until then they have no
    /// effect. The bridge does not touch the object any more, unless it stays in the Bullet world and collides there.
    void forget(const btCollisionObject& object);
    /// Makes the shapes of an object anew, after its collision shape was edited in place. Not needed after changes of
    /// the shape pointer, the type, scaling, margin, bounds and children, which are noticed.
    void refresh(const btCollisionObject& object);

    /// Takes the triangle meshes of an object (btBvhTriangleMeshShape, btGImpactMeshShape, btConvexTriangleMeshShape
    /// and others that yield triangles, also in compounds) as solids on a sampled grid from now on, see
    /// pli_shape_create_sampled_mesh. For closed meshes, in either mode. Cell size and padding are those of the scaled
    /// shape. Samples are made anew when the shape changes in a way that the bridge notices, or by refresh(). As with
    /// rigid() this holds until forget(), or until the object is no longer in the Bullet world.
    /// @return PLI_ERROR_INVALID_VALUE when the object has no triangles; PLI_ERROR_WRONG_STATE inside a step or after
    ///         detach(); the errors of pli_shape_create_sampled_mesh. After an error the object is as it was.
    pli_status use_sampled_mesh(const btCollisionObject& object,
                                const pli_sampled_mesh_def& def = pli_sampled_mesh_def_default());

    /// The factor for pli_body_write_vertices with which a frame that is drawn now shows soft bodies at the same time
    /// as Bullet's motion states: 0 is the start of the last step, 1 its end. It is the time in Bullet's accumulator
    /// over its fixed step, and one more after setLatencyMotionStateInterpolation(false). 1 without bodies in the
    /// Bullet world.
    float interpolation() const;

    /// Sets a function that is called in each step when all contacts are made and nothing is solved yet. For regression
    /// tests.
    void set_before_solve(std::function<void()> hook);

    /// Removes everything from the Bullet world, if that still exists. Bodies stay readable, but no longer step. Inside
    /// a step it happens at the end of the bridge's part.
    void detach();

    class Impl;

private:
    friend class BridgeSnapshot;
    friend bool bullet_cluster_distance(const pli_body*, pli_cluster_contact*, void*);
    std::unique_ptr<Impl> impl_;
};

} // namespace pliant

#endif
