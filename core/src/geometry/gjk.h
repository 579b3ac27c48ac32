#pragma once

/* Distance of two convex cores with the nearest points, or that they overlap. */

#include "math/dvec3.h"
#include "math/vec.h"

/* A convex core is known by its farthest points. Both of a pair are given in one frame, whose origin should not lie far
   away: results are as accurate as float coordinates there. */

/* A point of the core that lies farthest along `direction`, a unit vector. Finite; the same for the same direction. */
typedef pli_vec3 plii_support_fn(const void* user, pli_vec3 direction);

typedef struct plii_convex {
    plii_support_fn* support;
    const void* user;
    pli_vec3 centre; /* somewhere near the middle of the core: where searches start, needs not lie inside */
} plii_convex;

typedef enum plii_convex_relation {
    PLII_CONVEX_SEPARATED,
    PLII_CONVEX_BEYOND,      /* proven farther apart than the query's max_distance; the nearest points are rough */
    PLII_CONVEX_OVERLAPPING, /* or touching */
    PLII_CONVEX_UNDEFINED    /* a support point is not finite */
} plii_convex_relation;

/* What a pair remembers from query to query, zero at first. Directions stay of use while both sets move and deform. */
enum { PLII_CONVEX_CACHE_POINTS = 4 };

typedef struct plii_convex_cache {
    union {
        pli_vec3 points[PLII_CONVEX_CACHE_POINTS]; /* of those who keep contacts and no simplex */
        pli_vec3 directions[4];                    /* normals (b to a) whose support points made the last simplex */
    };
    int count;
    pli_vec3 normal; /* of the last signed distance */
    bool has_normal;
} plii_convex_cache;

typedef struct plii_gjk_query {
    const plii_convex *a, *b;
    plii_dvec3 offset;   /* added to every point of a */
    double max_distance; /* farther pairs end as PLII_CONVEX_BEYOND; HUGE_VAL: none do */
    double enough;       /* ends, as PLII_CONVEX_SEPARATED, once a smaller distance is known; 0: exact */
    /* Ends when the bounds agree to this share of the distance; 0: 1e-7, the normal is right to 0.03 degrees then. */
    double gap;
    int max_support_calls; /* of both callbacks together, at least 4 */
} plii_gjk_query;

typedef struct plii_gjk_result {
    plii_convex_relation relation;
    double distance;             /* of the points below; 0 when overlapping */
    double lower_bound;          /* the true distance lies between this and `distance` */
    plii_dvec3 point_a, point_b; /* nearest points of the cores, `offset` included */
    plii_dvec3 normal;           /* unit, from b to a; when overlapping zero, or what rounding left */
    plii_dvec3 simplex[4];       /* last simplex in a - b; contains the origin when overlapping */
    int simplex_count;
    int support_calls;
} plii_gjk_result;

/* Ends by the gap of the bounds, or when nothing improves in double precision. `cache` may be NULL. */
void plii_gjk_run(const plii_gjk_query* query, plii_convex_cache* cache, plii_gjk_result* result);
