#ifndef PLII_TEAM_H
#define PLII_TEAM_H

/* Threads that do a piece of work together, each a share of its own from beginning to end, and wait only for those
   whose shares touch theirs. Where a piece has many small parts that follow each other, as colours of links do, a range
   of the context's hook for each of them would cost more than the part. */

#include "context.h"

#include <stdatomic.h>

/* In a line of memory of its own. */
typedef struct plii_team_member {
    _Alignas(64) atomic_int steps; /* that the others may rely on */
} plii_team_member;

typedef struct plii_team {
    plii_team_member members[PLII_TEAM_MOST];
} plii_team;

typedef void plii_team_fn(plii_team* team, int member, void* task);

/* Calls `work` for members [0, count) at the same time. False where the hook's parts do not run at the same time, or
   not soon enough: then nothing was called. */
bool plii_team_run(pli_context* context, int count, plii_team_fn* work, void* task);

/* Of a member's own steps; they only grow. */
static inline void plii_team_signal(plii_team* team, int member, int steps) {
    atomic_store_explicit(&team->members[member].steps, steps, memory_order_release);
}
void plii_team_wait(const plii_team* team, int member, int steps);
/* For all of them. */
void plii_team_meet(plii_team* team, int member, int count, int steps);

#endif
