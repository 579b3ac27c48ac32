#ifndef PLII_ANCHOR_IMPL_H
#define PLII_ANCHOR_IMPL_H

#include "pliant/anchor.h"

typedef struct plii_anchor_data {
    int node;
    pli_rigid* rigid;
    pli_vec3 pivot; /* in the frame of the rigid body */
} plii_anchor_data;

/* Of the anchor at `index` in the order of creation, below pli_body_anchor_count. */
plii_anchor_data plii_anchor_get_data(const pli_body* body, int index);

#endif
