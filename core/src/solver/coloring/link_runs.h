#ifndef PLII_LINK_RUNS_H
#define PLII_LINK_RUNS_H

/* Links whose nodes follow each other in memory, as in the rows, columns and diagonals of a grid. They need no indices,
   and they may be read in planes (node_planes.h) as well as in records. */

#include "body/body_impl.h"

enum { PLII_LINK_LANES = 8 };

/* Widest offset with which first and other nodes take turns. */
enum { PLII_LINK_TURNS = 2 };

/* Groups of eight links of one tag from node a to node a + offset. First nodes come one after the other (step 1), or
   every second one does (step 2), and no link of the colour has those between. Where the offset is at most
   PLII_LINK_TURNS, `offset` of the first and as many of the other nodes take turns, and the step is 1. What does not
   fill a group is the end: a group with the links before it, which it skips. */
typedef struct plii_link_run {
    int node, offset; /* of the first link: the smaller node; from there to the other one */
    int first_group, group_count;
    plii_link_tag tag;
    uint8_t step;
    uint8_t skipped_count; /* first links of the last group; 0: there is no end */
} plii_link_run;

/* Which links they are, from a group of a run on. */
typedef struct plii_link_source {
    int first_group;
    int link, link_stride; /* index of the first link; from node to node, 0: `link` is an index into run_links */
} plii_link_source;

/* Runs of one colour share no node. */
typedef struct plii_link_run_color {
    int first_run, first_group; /* to those of the next colour */
} plii_link_run_color;

typedef struct plii_link_runs {
    int color_count, run_count, source_count, run_link_count, group_count;
    plii_link_run_color* colors; /* [color_count + 1] */
    plii_link_run* runs;         /* [run_count] */
    plii_link_source* sources;   /* [source_count] */
    int* run_links;              /* [run_link_count] of links without a stride */
} plii_link_runs;

enum { PLII_LINK_RUNS_MAX_CLASSES = 32 };

/* What finding runs needs for a while. */
typedef struct plii_link_runs_work {
    const pli_body* body;
    plii_link_runs made; /* with room for 4 PLII_LINK_RUNS_MAX_CLASSES colours, link_count / 4 runs and
                            sources, link_count links */
    int class_count;
    int classes[PLII_LINK_RUNS_MAX_CLASSES]; /* differences of node indices, ascending */
    int* places;                             /* [node_count] zero; the link of a class by its smaller node, plus 1 */
    int* list;                               /* [link_count] */
    uint8_t* sides;                          /* [node_count] of the links of a class */
    uint8_t* is_used;                        /* [link_count] zero; what comes into runs gets 1 */
} plii_link_runs_work;

void plii_link_runs_find(plii_link_runs_work* work);

static inline bool plii_link_run_has_turns(int offset) {
    return offset <= PLII_LINK_TURNS;
}
/* From the first node of a run to that of another one of its links. */
static inline int plii_link_run_way(int offset, int step, int place) {
    return plii_link_run_has_turns(offset) ? place / offset * 2 * offset + place % offset : step * place;
}
/* The same from group to group. */
static inline int plii_link_run_group_way(int offset, int step) {
    return plii_link_run_has_turns(offset) ? 2 * PLII_LINK_LANES : step * PLII_LINK_LANES;
}

static inline bool plii_link_run_is_end(const plii_link_run* run, int group) {
    return run->skipped_count > 0 && group == run->group_count - 1;
}
/* Groups without the end. */
static inline int plii_link_run_full_count(const plii_link_run* run) {
    return run->group_count - (run->skipped_count > 0);
}
/* First node of a group. */
static inline int plii_link_run_node(const plii_link_run* run, int group) {
    return plii_link_run_is_end(run, group)
               ? run->node + plii_link_run_way(run->offset, run->step, PLII_LINK_LANES * group - run->skipped_count)
               : run->node + plii_link_run_group_way(run->offset, run->step) * group;
}

/* Index of a link by its place after the first one of a source; PLI_NULL_INDEX before, for those that an end skips. */
static inline int plii_link_runs_link(const plii_link_runs* runs, const plii_link_run* run,
                                      const plii_link_source* source, int place) {
    if (place < 0) { return PLI_NULL_INDEX; }
    return source->link_stride == 0
               ? runs->run_links[source->link + place]
               : source->link + plii_link_run_way(run->offset, run->step, place) * source->link_stride;
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

/* The run of a colour that has a group, counted from the colour's first one. */
static inline const plii_link_run* plii_link_run_at(const plii_link_runs* runs, const plii_link_run_color* color,
                                                    int group) {
    const plii_link_run* first = &runs->runs[color[0].first_run];
    int low = 0, high = color[1].first_run - color[0].first_run - 1;
    while (low < high) {
        const int middle = (low + high + 1) / 2;
        if (first[middle].first_group - color->first_group <= group) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    return first + low;
}

static inline bool plii_link_runs_has_end_at(const plii_link_runs* runs, const plii_link_run_color* color, int group) {
    if (group >= color[1].first_group - color[0].first_group) { return false; }
    const plii_link_run* run = plii_link_run_at(runs, color, group);
    return plii_link_run_is_end(run, group + color->first_group - run->first_group);
}
/* What a part of the groups of a colour stands for: the end of a row, which has nodes of the group before it, comes
   with that one. */
static inline plii_link_part plii_link_runs_part(const plii_link_runs* runs, const plii_link_run_color* color,
                                                 int begin, int end) {
    return (plii_link_part){begin + plii_link_runs_has_end_at(runs, color, begin),
                            end + plii_link_runs_has_end_at(runs, color, end)};
}

#endif
