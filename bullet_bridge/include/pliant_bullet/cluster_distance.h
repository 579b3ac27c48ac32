#ifndef PLIANT_BULLET_CLUSTER_DISTANCE_H
#define PLIANT_BULLET_CLUSTER_DISTANCE_H

/// Nearest points of clusters as btSoftBody finds them, for comparisons.

#include "pliant_bullet.h"

namespace pliant {

/// By Bullet's GJK and EPA, in Bullet's order of operations. To be set as pli_cluster_contacts_def::distance of a body
/// of a bridge, with the Bridge as distance_user. False for rigid bodies that are not of that bridge.
PLI_API bool bullet_cluster_distance(const pli_body* body, pli_cluster_contact* contact, void* user);

} // namespace pliant

#endif
