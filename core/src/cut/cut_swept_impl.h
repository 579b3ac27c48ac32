#ifndef PLII_CUT_SWEPT_IMPL_H
#define PLII_CUT_SWEPT_IMPL_H

/* A swept cut in parts: cut_swept.c is the sweep and its passes, cut_swept_meet.c finds what a blade meets,
   cut_swept_links.c parts links without faces, cut_swept_faces.c faces. */

#include "cut/topology_edit.h"
#include "math/dvec3.h"

/* What a cut has not opened yet. */
typedef struct plii_swept_ends {
    int* tips; /* nodes of the cut that are not parted */
    int tip_count, tip_capacity;
    int (*edges)[2]; /* of the cut, between tips */
    int edge_count, edge_capacity;
} plii_swept_ends;

// ----------------------------------------------------------------------------------------------------------- the blade

/* In double: blades are long and thin. */
typedef struct plii_swept_blade {
    plii_dvec3 corners[3];
    plii_dvec3 normal;
    plii_dvec3 inward[3]; /* of the side from corner k to the next */
} plii_swept_blade;

/* Whether a point of the blade's plane is inside of its outline, which is part of it. */
static inline bool plii_swept_is_inside(const plii_swept_blade* blade, plii_dvec3 point) {
    for (int k = 0; k < 3; ++k) {
        if (plii_dvec3_dot(blade->inward[k], plii_dvec3_sub(point, blade->corners[k])) < -1e-9) { return false; }
    }
    return true;
}

// -------------------------------------------------------------------------------------------------------------- a pass

/* Marks of nodes, */
enum {
    PLII_SWEPT_ON_BLADE = 1,
    PLII_SWEPT_HAS_FACE = 2,
    PLII_SWEPT_IS_TIP = 4,
    PLII_SWEPT_BELOW = 8,
    PLII_SWEPT_ABOVE = 16
};
/* and flags of edges. */
enum { PLII_SWEPT_OF_FACE = 1, PLII_SWEPT_CROSSED = 2 };

typedef struct plii_swept_work {
    plii_edit edit;
    plii_swept_ends ends; /* of the sweep so far */
    int parted;           /* links */
} plii_swept_work;

/* One blade on the present state of the edit. */
typedef struct plii_swept_pass {
    plii_swept_work* work;
    plii_edit* edit;
    plii_scratch scratch;
    const plii_swept_blade* blade;
    int node_count;        /* before the pass */
    double* heights;       /* [node_count] over the blade's plane */
    uint8_t* marks;        /* [node_count] */
    plii_edge_map edges;   /* that the blade meets, and those around */
    plii_edge_map borders; /* between two nodes on the blade */
    plii_edge_map cuts;    /* to be opened */
} plii_swept_pass;

static inline plii_dvec3 plii_swept_point(const plii_swept_pass* pass, int node) {
    return plii_dvec3_from(plii_edit_position(pass->edit, node));
}

static inline bool plii_swept_is_on_blade(const plii_swept_pass* pass, int node) {
    return node < pass->node_count && (pass->marks[node] & PLII_SWEPT_ON_BLADE) != 0;
}

static inline bool plii_swept_is_tip(const plii_swept_pass* pass, int node) {
    return node < pass->node_count && (pass->marks[node] & PLII_SWEPT_IS_TIP) != 0;
}

static inline void plii_swept_mark(const plii_swept_pass* pass, int node, unsigned mark) {
    pass->marks[node] = (uint8_t)(pass->marks[node] | mark);
}

/* Where the blade's plane crosses an edge, as a share from a to b; negative when it does not inside of the blade. */
static inline double plii_swept_crossing(const plii_swept_pass* pass, int a, int b) {
    const double height_a = pass->heights[a], height_b = pass->heights[b];
    if ((height_a > 0.0 && height_b > 0.0) || (height_a < 0.0 && height_b < 0.0) || height_a == height_b) {
        return -1.0;
    }
    const double t = height_a / (height_a - height_b);
    const plii_dvec3 start = plii_swept_point(pass, a), edge = plii_dvec3_sub(plii_swept_point(pass, b), start);
    return plii_swept_is_inside(pass->blade, plii_dvec3_add_scaled(start, edge, t)) ? t : -1.0;
}

// The parts of a pass, in their order; false when out of memory, but for plii_swept_meets_something.

/* Marks nodes and edges that the blade meets. */
bool plii_swept_find_edges(plii_swept_pass* pass);
bool plii_swept_meets_something(const plii_swept_pass* pass);
/* PLI_OK, or the error of a tetrahedron that the blade meets. */
pli_status plii_swept_check_tetras(const plii_swept_pass* pass);

/* Bending links and braces inside of a surface go when they are crossed. */
void plii_swept_remove_links(plii_swept_pass* pass);
/* A rope that is crossed gets two ends. Their nodes lie behind each other. */
bool plii_swept_part_rope_links(plii_swept_pass* pass);
/* A node of a rope on the blade is doubled; the copy gets the links below. */
bool plii_swept_part_rope_nodes(plii_swept_pass* pass);

/* Nodes where the blade crosses edges of faces. */
bool plii_swept_add_nodes(plii_swept_pass* pass);
/* Which edges will be opened, */
bool plii_swept_judge_faces(plii_swept_pass* pass);
/* and those that stayed closed, which may be crossed by now. */
bool plii_swept_open_closed_edges(plii_swept_pass* pass);
/* Opens them, when faces are split; what stays closed are the new ends of the cut. */
bool plii_swept_separate(plii_swept_pass* pass);

#endif
