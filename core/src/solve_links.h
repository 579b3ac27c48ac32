#ifndef PLII_SOLVE_LINKS_H
#define PLII_SOLVE_LINKS_H

#include "body_impl.h"

/* One Gauss-Seidel sweep over all links in their order, on positions (btSoftBody::PSolve_Links); no state. */
void plii_links_sweep(pli_body* body, void* state);

#endif
