#pragma once

/* Tethers: distances along a body at its rest lengths. */

#include "base/csr.h"
#include "body/body_impl.h"
#include "pliant/tether.h"

/* What distances are measured along: links, and faces where they are wanted. In memory of a scratch. */
typedef struct plii_tether_surface {
    const pli_body* body;
    int* link_begin; /* [node_count + 1] */
    plii_half_link* halves;
    int* face_begin;   /* [node_count + 1] */
    int* corners;      /* of faces, three for each, at each node */
    float (*edges)[3]; /* m, from node k of a face to the next one; the first is infinite where one is no link */
    int* front;        /* nodes whose distance has changed, the first one that did so first, in a ring */
    bool* waits;       /* [node_count] is in it */
    int front_first, front_count;
} plii_tether_surface;

/* When out of memory, which the scratch tells, it is not to be used. */
plii_tether_surface plii_tether_surface_create(const pli_body* body, plii_scratch* scratch);

/* `tethers` holds the origins, at length 0, and else nothing at INFINITY; gives each node the nearest origin, and how
   far it is along links and straight across faces, which are laid flat one beside the other. */
void plii_tether_measure(plii_tether_surface* surface, pli_tether* tethers);
