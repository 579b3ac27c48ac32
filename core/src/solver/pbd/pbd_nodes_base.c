/* Free motion and velocities of nodes, two records at a time, for the instruction set that the build selects. */

#include "math/simd_float8.h"
#include "solver/pbd/pbd_nodes.h"

/* Pinned nodes keep their velocity. */
PLII_SIMD_INLINE plii_float8 nodes_with_gravity(const plii_pbd_nodes* nodes, int node, bool are_two) {
    const plii_float4 gravity = plii_lanes_from_vec3(&nodes->gravity);
    const plii_float8 velocity = plii_float8_from(nodes->velocities, node, are_two);
    const plii_float8 inverse_mass = plii_float8_all_w(plii_float8_from(nodes->positions, node, are_two));
    return plii_float8_select_less(plii_float8_all(0.0f), inverse_mass,
                                   plii_float8_add(velocity, plii_float8_of(gravity, gravity)), velocity);
}

PLII_SIMD_INLINE void nodes_move(const plii_pbd_nodes* nodes, int node, bool are_two, plii_float8 velocity) {
    const plii_float8 position = plii_float8_from(nodes->positions, node, are_two);
    plii_float8_to(nodes->velocities, node, are_two, velocity);
    plii_float8_to(nodes->previous, node, are_two, plii_float8_xyz(position));
    plii_float8_to(nodes->positions, node, are_two,
                   plii_float8_add(position, plii_float8_mul(velocity, plii_float8_all(nodes->dt))));
}

PLII_SIMD_INLINE void nodes_add_gravity_at(const plii_pbd_nodes* nodes, int node, bool are_two) {
    plii_float8_to(nodes->velocities, node, are_two, nodes_with_gravity(nodes, node, are_two));
}
PLII_SIMD_INLINE void nodes_fly_at(const plii_pbd_nodes* nodes, int node, bool are_two) {
    nodes_move(nodes, node, are_two, nodes_with_gravity(nodes, node, are_two));
}

PLII_SIMD_INLINE void nodes_add_forces_at(const plii_pbd_nodes* nodes, int node, bool are_two) {
    plii_float8 velocity = plii_float8_from(nodes->velocities, node, are_two);
    if (nodes->forces != NULL) {
        pli_vec3* forces = &nodes->forces[node];
        const plii_float8 force =
            plii_float8_of(plii_lanes_from_vec3(forces), plii_lanes_from_vec3(&forces[are_two ? 1 : 0]));
        const plii_float8 inverse_mass = plii_float8_all_w(plii_float8_from(nodes->positions, node, are_two));
        const plii_float8 change = plii_float8_mul(plii_float8_mul(force, inverse_mass), plii_float8_all(nodes->dt));
        const plii_float8 above = plii_float8_max(plii_float8_all(-nodes->limit), change);
        velocity = plii_float8_add(velocity, plii_float8_min(plii_float8_all(nodes->limit), above));
        forces[0] = forces[are_two ? 1 : 0] = pli_vec3_make(0, 0, 0);
    }
    nodes_move(nodes, node, are_two, velocity);
}

PLII_SIMD_INLINE void nodes_set_velocities_at(const plii_pbd_nodes* nodes, int node, bool are_two) {
    const plii_float8 moved = plii_float8_sub(plii_float8_from(nodes->positions, node, are_two),
                                              plii_float8_from(nodes->previous, node, are_two));
    const plii_float8 velocity = plii_float8_xyz(plii_float8_mul(moved, plii_float8_all(nodes->rate)));
    plii_float8_to(nodes->velocities, node, are_two, velocity);
}

PLII_RECORDS_RANGE(nodes_add_gravity, plii_pbd_nodes)
PLII_RECORDS_RANGE(nodes_add_forces, plii_pbd_nodes)
PLII_RECORDS_RANGE(nodes_fly, plii_pbd_nodes)
PLII_RECORDS_RANGE(nodes_set_velocities, plii_pbd_nodes)

const plii_pbd_nodes_kernel PLII_KERNEL_NAME(plii_pbd_nodes) = {nodes_add_gravity, nodes_add_forces, nodes_fly,
                                                                nodes_set_velocities};
