#ifndef PLII_LINK_SHARES_H
#define PLII_LINK_SHARES_H

/* What of the runs of links in planes each member of a team (team.h) solves: the links whose first nodes are its own.
   Members wait for each other only at the few rows of nodes where their shares touch. They solve links there first in
   each colour, so that the others seldom have to wait for them. */

#include "link_colors.h"
#include "team.h"

/* Shares of a body's nodes such that no group of links has first nodes, or second ones, in two of them. No shares where
   there are none of the kind, or the hook has one thread. */
void plii_link_shares_choose(const pli_body* body, const plii_link_runs* runs, plii_node_shares* shares);

/* Groups of a colour. Only those before `low_end` have nodes that the member before moves too, only those from
   `high_begin` on have nodes of the next one. */
typedef struct plii_link_share {
    int begin, low_end, high_begin, end;
    bool is_met; /* the member before has links to nodes of this one */
} plii_link_share;

enum { PLII_LINK_RUNS_MAX_COLORS = 4 * PLII_LINK_RUNS_MAX_CLASSES };

typedef struct plii_link_shares {
    const plii_link_runs* runs;
    plii_team* team;
    int member, member_count;
    int steps;                            /* of this member */
    int met_steps;                        /* that the member before must have done before own common nodes are moved */
    int first_node, common_end, end_node; /* own nodes; the member before moves those before `common_end` too */
    plii_link_share colors[PLII_LINK_RUNS_MAX_COLORS];
} plii_link_shares;

void plii_link_shares_find(const plii_link_colors* colors, plii_team* team, int member, plii_link_shares* shares);

/* Groups [begin, end) of a colour. */
typedef void plii_link_shares_fn(const void* task, int color, int begin, int end);
void plii_link_shares_sweep(plii_link_shares* shares, plii_link_shares_fn* solve, const void* task);
/* What is done to each own node by itself. Ranges are of blocks of nodes, of which PLII_NODE_SHARES_BLOCK is a
   multiple, counted from the first own node. */
void plii_link_shares_pass(plii_link_shares* shares, pli_range_fn* range, int block, void* task);
/* What must be done to the nodes of all members before any of them goes on. Ranges are of nodes. */
void plii_link_shares_turn(plii_link_shares* shares, pli_range_fn* range, void* task);

#endif
