/* Free motion and velocities of nodes under XPBD, two records at a time, by the instruction set of the build. */

#include "math/simd_float8.h"
#include "solver/xpbd/xpbd_impl.h"

PLII_SIMD_INLINE void nodes_fly(const plii_xpbd_nodes* nodes, int node, bool are_two, plii_float8 velocity,
                                plii_float8 start_displacements) {
    const plii_float8 dt = plii_float8_all(nodes->substep.dt);
    const plii_float8 acceleration = plii_float8_from(nodes->accelerations, node, are_two);
    velocity = plii_float8_add(velocity, plii_float8_mul(acceleration, dt));
    plii_float8_to(nodes->velocities, node, are_two, velocity);
    plii_float8_to(nodes->substep.displacements, node, are_two,
                   plii_float8_add(start_displacements, plii_float8_mul(velocity, dt)));
}

PLII_SIMD_INLINE void nodes_begin_at(const plii_xpbd_nodes* nodes, int node, bool are_two) {
    const plii_float8 predicted = plii_float8_from(nodes->positions, node, are_two);
    const plii_float8 start_displacements = plii_float8_sub(predicted, plii_float8_xyz(predicted)); /* 0, 0, 0, w */
    plii_float8_to(nodes->positions, node, are_two,
                   plii_float8_add(start_displacements, plii_float8_from(nodes->previous, node, are_two)));
    plii_float8_to(nodes->substep.start_displacements, node, are_two, start_displacements);
    nodes_fly(nodes, node, are_two, plii_float8_from(nodes->velocities, node, are_two), start_displacements);
}

PLII_SIMD_INLINE void nodes_move_at(const plii_xpbd_nodes* nodes, int node, bool are_two) {
    nodes_fly(nodes, node, are_two, plii_float8_from(nodes->velocities, node, are_two),
              plii_float8_from(nodes->substep.start_displacements, node, are_two));
}

/* m/s; a node that moves so slowly stands still. One that sticks to a surface keeps a ten millionth of its velocity in
   each substep, the rounding of dt * (1 / dt), and would come to subnormal numbers, with which processors are slow. */
#define NODES_STILL 1e-20f

/* Velocities get what constraints changed, exactly nothing where they did nothing: the whole motion over dt would give
   them its rounding in every substep. Pinned nodes keep theirs. */
PLII_SIMD_INLINE plii_float8 nodes_velocity(const plii_xpbd_nodes* nodes, int node, bool are_two,
                                            plii_float8 displacement) {
    const plii_float8 velocity = plii_float8_from(nodes->velocities, node, are_two);
    const plii_float8 free_motion = plii_float8_mul(velocity, plii_float8_all(nodes->substep.dt));
    const plii_float8 free =
        plii_float8_add(plii_float8_from(nodes->substep.start_displacements, node, are_two), free_motion);
    const plii_float8 change = plii_float8_sub(displacement, free);
    const plii_float8 added = plii_float8_mul(change, plii_float8_all(nodes->substep.inverse_dt));
    const plii_float8 changed = plii_float8_add(velocity, added);
    const plii_float8 speeds = plii_float8_max(changed, plii_float8_sub(plii_float8_all(0.0f), changed));
    const plii_float8 kept = plii_float8_where_greater(speeds, plii_float8_all(NODES_STILL), changed);
    return plii_float8_select_less(plii_float8_all(0.0f), plii_float8_all_w(displacement), kept, velocity);
}

/* The displacement from where the position is then. */
PLII_SIMD_INLINE plii_float8 nodes_carry(const plii_xpbd_nodes* nodes, int node, bool are_two,
                                         plii_float8 displacement) {
    plii_float8 start_displacements = displacement;
    if (nodes->follows) {
        const plii_float8 before = plii_float8_from(nodes->positions, node, are_two);
        const plii_float8 after = plii_float8_add(before, plii_float8_xyz(displacement));
        plii_float8_to(nodes->positions, node, are_two, after);
        start_displacements = plii_float8_sub(displacement, plii_float8_sub(after, before));
    }
    plii_float8_to(nodes->substep.start_displacements, node, are_two, start_displacements);
    return start_displacements;
}

PLII_SIMD_INLINE void nodes_finish_at(const plii_xpbd_nodes* nodes, int node, bool are_two) {
    const plii_float8 displacement = plii_float8_from(nodes->substep.displacements, node, are_two);
    plii_float8_to(nodes->velocities, node, are_two, nodes_velocity(nodes, node, are_two, displacement));
    nodes_carry(nodes, node, are_two, displacement);
}

PLII_SIMD_INLINE void nodes_finish_and_move_at(const plii_xpbd_nodes* nodes, int node, bool are_two) {
    const plii_float8 displacement = plii_float8_from(nodes->substep.displacements, node, are_two);
    const plii_float8 velocity = nodes_velocity(nodes, node, are_two, displacement);
    nodes_fly(nodes, node, are_two, velocity, nodes_carry(nodes, node, are_two, displacement));
}

PLII_RECORDS_RANGE(nodes_begin, plii_xpbd_nodes)
PLII_RECORDS_RANGE(nodes_move, plii_xpbd_nodes)
PLII_RECORDS_RANGE(nodes_finish, plii_xpbd_nodes)
PLII_RECORDS_RANGE(nodes_finish_and_move, plii_xpbd_nodes)

const plii_xpbd_nodes_kernel PLII_KERNEL_NAME(plii_xpbd_nodes) = {nodes_begin, nodes_move, nodes_finish,
                                                                  nodes_finish_and_move};
