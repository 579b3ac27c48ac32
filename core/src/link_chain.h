#ifndef PLII_LINK_CHAIN_H
#define PLII_LINK_CHAIN_H

/* Links of a chain on positions, by SIMD: the even ones, then the odd ones. Even and odd nodes lie apart, by component,
   from the first sweep to the last one; the two nodes of a link are in one lane of theirs, or one lane further. */

#include "body_impl.h"

/* A chain of more links takes as long by the colours of any body. */
enum { PLII_LINK_CHAIN_MOST = 127 };

typedef struct plii_link_chain {
    int link_count;    /* 0: no chain */
    float* rows;       /* for each colour, by its links: squared rest length, inverse masses over the mass term */
    uint32_t revision; /* of the body's links, in the rows */
    bool is_stale, has_all_links;
} plii_link_chain;

/* Link k joins nodes k and k + 1, for all links, of which there are at most PLII_LINK_CHAIN_MOST. */
bool plii_link_chain_fits(const pli_body* body);
/* False: no memory, and no chain. */
bool plii_link_chain_make(const pli_body* body, plii_link_chain* chain);
void plii_link_chain_release(const pli_body* body, plii_link_chain* chain);
size_t plii_link_chain_bytes(const plii_link_chain* chain);

/* What comes before each sweep; it may move the last node of the chain, and reads no other. */
typedef void plii_link_chain_before_fn(pli_body* body);

/* False, and nothing is done, where there is a link that solvers leave out: between two pinned nodes, or without
   length. `before` may be NULL. */
bool plii_link_chain_sweep(pli_body* body, plii_link_chain* chain, int sweep_count, plii_link_chain_before_fn* before);

#endif
