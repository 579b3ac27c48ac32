/* Groups of contacts in AVX2. */

#include "contact/node_rigid_groups.inl"

void plii_rigid_groups_sweep_avx2(plii_rigid_groups* groups, const plii_rigid_groups_pass* pass) {
    groups_sweep(groups, pass);
}
