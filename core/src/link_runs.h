#ifndef PLII_LINK_RUNS_H
#define PLII_LINK_RUNS_H

/* Links whose nodes advance by a constant stride, as in the rows, columns and diagonals of a grid. They need no
   indices, and most of them read their nodes in the order of memory. */

#include "body_impl.h"

enum { PLII_LINK_LANES = 8 };

/* Groups of eight links of one tag. */
typedef struct plii_link_run {
    int node, stride;      /* the first link's smaller node; from link to link */
    int offset;            /* to the other node */
    int link, link_stride; /* index of the first link; from link to link, 0: `link` is an index into run_links */
    int first_group, group_count;
    plii_link_tag tag;
} plii_link_run;

/* Runs of one colour share no node. */
typedef struct plii_link_run_color {
    int first_run, first_group; /* to those of the next colour */
} plii_link_run_color;

typedef struct plii_link_runs {
    int color_count, run_count, run_link_count, group_count;
    plii_link_run_color* colors; /* [color_count + 1] */
    plii_link_run* runs;         /* [run_count] */
    int* run_links;              /* [run_link_count] of runs whose links have no stride */
} plii_link_runs;

enum { PLII_LINK_RUNS_MAX_CLASSES = 32 };

/* What finding runs needs for a while. */
typedef struct plii_link_runs_work {
    const pli_body* body;
    plii_link_runs made; /* with room for 2 PLII_LINK_RUNS_MAX_CLASSES colours, link_count / 8 runs, link_count links */
    int class_count;
    int classes[PLII_LINK_RUNS_MAX_CLASSES]; /* differences of node indices, ascending */
    int* places;                             /* [node_count] zero; the link of a class by its smaller node, plus 1 */
    int* list;                               /* [link_count] */
    uint8_t* sides;                          /* [node_count] of the links of a class */
    uint8_t* is_used;                        /* [link_count] zero; what comes into runs gets 1 */
} plii_link_runs_work;

void plii_link_runs_find(plii_link_runs_work* work);

/* Index of a link of a run. */
static inline int plii_link_run_link(const plii_link_runs* runs, const plii_link_run* run, int place) {
    return run->link_stride == 0 ? runs->run_links[run->link + place] : run->link + place * run->link_stride;
}

typedef struct plii_link_part {
    int begin, end; /* nothing when end <= begin */
} plii_link_part;

/* Of groups [begin, end) of a colour: those of a run, counted from its first one. */
static inline plii_link_part plii_link_run_part(const plii_link_run* run, const plii_link_run_color* color, int begin,
                                                int end) {
    const int before = run->first_group - color->first_group;
    return (plii_link_part){begin > before ? begin - before : 0,
                            end - before < run->group_count ? end - before : run->group_count};
}

#endif
