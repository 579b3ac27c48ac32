#ifndef PLIANT_BULLET_SNAPSHOT_H
#define PLIANT_BULLET_SNAPSHOT_H

/// Going back in a Bullet world with soft bodies: rollback in networked games, trials, undo. See docs/state.md.

#include "pliant_bullet.h"

#include <memory>
#include <vector>

namespace pliant {

/// The state of a Bullet world and of the bridge's world in it between two steps. It holds what pli_world_save takes,
/// with anchors and their ids. Of Bullet's side it holds pose, velocities, forces and activity of every collision
/// object, what soft bodies held it by, Bullet's contact points, the seed of its solver and the time in its
/// accumulator. It does not hold constraints, vehicles and controllers of the game, nor masses, damping, friction,
/// shapes and filters of objects.
///
/// Frames after a restore equal those after the save bit for bit if Bullet visits pairs in an order that does not
/// depend on the past: set `world.getDispatchInfo().m_deterministicOverlappingPairs = true` before the frames that are
/// to be repeated. If rigid bodies may sleep, also use btAxisSweep3, since btDbvtBroadphase keeps pairs by their past,
/// and what sleeps together depends on pairs.
///
/// A snapshot fits as long as both worlds have the same objects and have read no file; without
/// BridgeDef::prepares_rigids_ahead, as long as the same bounds have overlapped.
class PLI_API BridgeSnapshot {
public:
    /// Empty.
    BridgeSnapshot();
    ~BridgeSnapshot(); ///< frees its memory
    /// A snapshot that was moved from may only be destroyed or assigned to.
    BridgeSnapshot(BridgeSnapshot&&) noexcept;
    /// Likewise.
    BridgeSnapshot& operator=(BridgeSnapshot&&) noexcept;

    /// Saves the present state. Memory is kept: a snapshot that is used again allocates only when it needs more.
    /// @return PLI_ERROR_WRONG_STATE inside a step, after detach(), and without a soft body in the Bullet world (which
    ///         may no longer exist then); the snapshot is empty after an error
    pli_status save(const Bridge& bridge);
    /// Goes back. On an error both worlds stay as they are.
    /// @return PLI_ERROR_INVALID_VALUE when the objects are not those of the save, or for an empty snapshot; the errors
    ///         of pli_world_restore; PLI_ERROR_WRONG_STATE as save()
    pli_status restore(Bridge& bridge) const;
    /// Size in bytes; 0: it is empty.
    std::size_t bytes() const;

    /// The same for another process, as a file: pli_world_file_write, and Bullet's side by places in the list of its
    /// objects. Empty after an error. It allocates, so use it once per file, not per frame.
    /// @return as save() and pli_world_file_write
    static pli_status write_file(const Bridge& bridge, std::vector<unsigned char>& bytes);
    /// Brings both worlds to the state of a file, in any process. The game has to make them again as they were at their
    /// start, with the same objects in the same order and the same build of Bullet. Handles stay, ids are those of the
    /// file; soft bodies may have been cut since their start. Worlds that have read the same file go the same way from
    /// there, whatever they have been through. Where compounds touch by several children at once, the world that wrote
    /// the file may differ from them by rounding, unless it reads the file as well. On an error both worlds stay as
    /// they are.
    /// @return PLI_ERROR_FILE_FORMAT when it is no such file, or is truncated or damaged; PLI_ERROR_INVALID_VALUE when
    ///         the objects are others; the errors of pli_world_file_restore; PLI_ERROR_WRONG_STATE as save()
    static pli_status read_file(Bridge& bridge, const unsigned char* bytes, std::size_t size);

private:
    struct Moment;
    struct Naming;
    static void restore_bullet(Bridge& bridge, btDiscreteDynamicsWorld& world, const Moment& moment,
                               bool forgets_pairs);
    std::unique_ptr<Moment> moment_;
};

} // namespace pliant

#endif
