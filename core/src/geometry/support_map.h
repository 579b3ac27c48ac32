#ifndef PLII_SUPPORT_MAP_H
#define PLII_SUPPORT_MAP_H

/* A convex set as the collision queries see it: a core, known by its farthest points, grown by a radius. */

#include "math/vec.h"

/* A point of the core that lies farthest along `direction`, a unit vector. Finite; the same for the same direction. */
typedef pli_vec3 plii_support_fn(const void* user, pli_vec3 direction);

/* Points of a core that keep their numbers while it moves and deforms; support(user, d) is point(user, farthest(user,
   d)). */
typedef struct plii_convex_vertices {
    int (*farthest)(const void* user, pli_vec3 direction);
    pli_vec3 (*point)(const void* user, int vertex);
} plii_convex_vertices;

typedef struct plii_convex {
    plii_support_fn* support;
    const void* user;
    pli_vec3 centre; /* somewhere near the middle of the core: where searches start, needs not lie inside */
    float radius;    /* the set is all that lies within this of the core; m. The queries here look at cores only */
    const plii_convex_vertices* vertices; /* or NULL */
} plii_convex;

/* Both sets of a pair are given in one frame. Results are as accurate as float coordinates in that frame, so its origin
   should not lie far away. */

#endif
