/* Groups of contacts with what every processor of the target has. */

#include "contact/node_rigid_groups.inl"

void plii_rigid_groups_sweep_base(plii_rigid_groups* groups, const plii_rigid_groups_pass* pass) {
    groups_sweep(groups, pass);
}
