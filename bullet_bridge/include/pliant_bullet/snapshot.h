#ifndef PLIANT_BULLET_SNAPSHOT_H
#define PLIANT_BULLET_SNAPSHOT_H

/// Going back in a Bullet world with soft bodies: rollback in networked games, trials, undo. See docs/state.md.

#include "pliant_bullet.h"

#include <memory>
#include <vector>

namespace pliant {

/// A moment between two steps of a Bullet world and of the bridge's world in it: what pli_world_save takes, with
/// anchors and their ids, and of every collision object of the Bullet world pose, velocities, forces and activity,
/// with what soft bodies held it by and the contact points that Bullet has between them, the seed of its solver and the
/// time in its accumulator.
///
/// Frames after a restore equal those after the save bit for bit where Bullet takes pairs in an order that does not
/// depend on what was before: `world.getDispatchInfo().m_deterministicOverlappingPairs = true`, set before the frames
/// that are to be repeated; and where rigid bodies may sleep a broad phase of axes (btAxisSweep3), since what sleeps
/// together depends on pairs that btDbvtBroadphase keeps by their past. It fits as long as both worlds have the same
/// objects and have read no file; without BridgeDef::prepares_rigids_ahead, as long as the same bounds have overlapped.
/// Not in it: constraints, vehicles and controllers of the game, masses, damping, friction, shapes and filters of its
/// objects.
class PLI_API BridgeSnapshot {
public:
    /// Empty.
    BridgeSnapshot();
    ~BridgeSnapshot(); ///< frees its memory
    /// What is moved from may only end, or be assigned to.
    BridgeSnapshot(BridgeSnapshot&&) noexcept;
    /// Likewise.
    BridgeSnapshot& operator=(BridgeSnapshot&&) noexcept;

    /// Takes the state of now. Memory is kept: a snapshot that is used again allocates only where there is more to
    /// keep.
    /// @return PLI_ERROR_WRONG_STATE inside a step, after detach(), and with no soft body in the Bullet world, which
    ///         may have gone then; the snapshot is empty after an error
    pli_status save(const Bridge& bridge);
    /// Goes back. On an error both worlds stay as they are.
    /// @return PLI_ERROR_INVALID_VALUE where other objects are there than then, or for an empty snapshot; errors of
    ///         pli_world_restore; PLI_ERROR_WRONG_STATE as of save()
    pli_status restore(Bridge& bridge) const;
    /// Bytes that it holds; 0: it is empty.
    std::size_t bytes() const;

    /// The same moment for another process, as a file: pli_world_file_write, and Bullet's side by places in the list of
    /// its objects. Empty after an error. Once per file, not per frame: it allocates.
    /// @return as save(), and of pli_world_file_write
    static pli_status write_file(const Bridge& bridge, std::vector<unsigned char>& bytes);
    /// Brings both worlds to the moment of a file, in any process: the game has made them again as they were at their
    /// start, with the same objects in the same order and by the same build of Bullet. Handles stay, ids are those of
    /// the file; soft bodies may have been cut since their start. Worlds that have read the same file go the same way
    /// from there, whatever was before; where compounds touch by several children at once, the world that wrote it may
    /// differ from them by rounding, unless it reads the file as well. On an error both worlds stay as they are.
    /// @return PLI_ERROR_FILE_FORMAT for what is no such file, is truncated or damaged; PLI_ERROR_INVALID_VALUE where
    ///         other objects are there; errors of pli_world_file_restore; PLI_ERROR_WRONG_STATE as of save()
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
