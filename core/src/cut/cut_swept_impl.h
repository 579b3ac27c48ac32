#pragma once

/* What a sweep (cut_swept.c) leaves to its blades (cut_swept_blade.c). */

#include "cut/topology_edit.h"

/* What a cut has not opened yet. */
typedef struct plii_swept_ends {
    int* tips; /* nodes of the cut that are not parted */
    int tip_count, tip_capacity;
    int (*edges)[2]; /* of the cut, between tips */
    int edge_count, edge_capacity;
} plii_swept_ends;

typedef struct plii_swept_work {
    plii_edit edit;
    plii_swept_ends ends; /* of the sweep so far */
    int parted;           /* links */
} plii_swept_work;

/* Cuts by one triangle. PLI_ERROR_OUT_OF_MEMORY has no message yet. */
pli_status plii_swept_cut(plii_swept_work* work, const pli_vec3 corners[3]);
