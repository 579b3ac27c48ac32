#ifndef PLII_CLUSTER_CONTACT_KERNEL_H
#define PLII_CLUSTER_CONTACT_KERNEL_H

/* What groups of contacts do in a step, with the instructions of every processor of the target or with more, from
   cluster_contact_kernel.inl; all with the same results. */

#include "cluster/cluster_contact_batch.h"

struct plii_contact_kernel {
    void (*prepare)(plii_contact_batches* groups, const plii_step* step); /* fills the blocks */
    void (*solve)(plii_contact_batches* groups);  /* one iteration, on the clusters and on groups->rigids */
    void (*finish)(plii_contact_batches* groups); /* adds to the impulses of the clusters */
};

extern const plii_contact_kernel plii_contact_kernel_base, plii_contact_kernel_avx2;

#endif
