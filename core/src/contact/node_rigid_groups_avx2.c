/* Groups of contacts in AVX2. */

#include "contact/node_rigid_groups.inl"

void plii_rigid_groups_sweep_avx2(plii_rigid_groups* groups, const plii_rigid_groups_settings* settings,
                                  const pli_vec4* positions, const plii_substep* substep) {
    groups_sweep(groups, settings, positions, substep);
}
