#ifndef PLII_CLUSTER_CONTACT_BATCHES_H
#define PLII_CLUSTER_CONTACT_BATCHES_H

/* Contacts prepared for the iterations of one step: those of four pairs that share nothing movable are solved side by
   side, and those of a pair one after the other. */

#include "cluster/cluster_contact_batch.h"

/* Contacts are added pair by pair: [count] of the same two sides, not in reference mode, which stay where they are
   until the step ends. All are false when out of memory: contacts that were not added, or prepared, are not solved. */
bool plii_contact_batches_start(pli_context* context, plii_contact_batches* groups, int rigid_count);
bool plii_contact_batches_add(pli_context* context, plii_contact_batches* groups, const plii_cluster_contact* contacts,
                              int count);
bool plii_contact_batches_prepare(pli_context* context, plii_contact_batches* groups, const plii_step* step);
/* One iteration. */
void plii_contact_batches_solve(plii_contact_batches* groups);
/* Hands impulses and displacements on to the clusters. */
void plii_contact_batches_finish(plii_contact_batches* groups);
bool plii_contact_batches_reserve(pli_context* context, plii_contact_batches* groups, int contacts);

#endif
