#pragma once

#include "math/vec.h"
#include "pliant/shape.h"

/* A piece of the surface of a shape that is not convex. */
typedef struct plii_shape_triangle {
    int index;
    pli_vec3 corners[3];
    pli_vec3 normal; /* unit, outwards */
} plii_shape_triangle;

typedef void plii_shape_triangle_fn(const plii_shape_triangle* triangle, void* context);

/* Those of which files hold what they are made from. */
typedef enum plii_shape_kind {
    PLII_SHAPE_OTHER,
    PLII_SHAPE_PLANE,
    PLII_SHAPE_SPHERE,
    PLII_SHAPE_BOX,
    PLII_SHAPE_CAPSULE,
    PLII_SHAPE_CYLINDER
} plii_shape_kind;

struct pli_shape {
    uint32_t magic;
    plii_shape_kind kind;
    int reference_count;
    pli_context* context;
    pli_shape_def def; /* callbacks and their data */
    /* Calls `visit` with the triangles whose boxes overlap `box`; NULL for shapes that do not consist of any. */
    void (*triangles)(const void* user, pli_bounds box, plii_shape_triangle_fn* visit, void* context);
    const pli_shape* source; /* what a lattice samples, else NULL */
    size_t data_size;        /* bytes of def.user that the shape releases itself, after def.destroy; 0: none */
};

/* Owns a copy of `data`, which is floats but for PLII_SHAPE_OTHER, and def->user is ignored; `size` 0: it owns none.
   Messages name `function`. */
pli_status plii_shape_create_owning(pli_context* context, plii_shape_kind kind, const pli_shape_def* def,
                                    const void* data, size_t size, const char* function, pli_shape** shape);
/* Points and triangles as a surface is made from. */
pli_status plii_shape_check_triangles(pli_context* context, int point_count, const pli_vec3* points, int triangle_count,
                                      const int* triangles, const char* function);

/* For the library's own references, at any time. */
void plii_shape_retain(pli_shape* shape);
void plii_shape_release(pli_shape* shape);

/* The function for bounds of a shape whose data begin with them. */
pli_bounds plii_shape_stored_bounds(const void* user);
/* pli_shape_distance of a shape that there is. */
float plii_shape_distance(const pli_shape* shape, pli_vec3 point, pli_vec3* normal);

/* `p * p` sums below this count as zero: shorter vectors have too few bits for a direction. m^2 */
#define PLII_SHAPE_TINY_SQUARED 1e-30f

/* Bounds of the shape that a lattice samples, as Bullet has them; else its own. */
static inline pli_bounds plii_shape_source_bounds(const pli_shape* shape) {
    const pli_shape_def* def = shape->source != NULL ? &shape->source->def : &shape->def;
    return def->bounds(def->user);
}
/* Trilinear between the corners of a cell, lower face before upper one, in the operations of btSparseSdf. */
static inline float plii_shape_interpolate(const float d[8], pli_vec3 f, pli_vec3* gradient) {
    gradient->x = plii_lerp(plii_lerp(d[1] - d[0], d[2] - d[3], f.y), plii_lerp(d[5] - d[4], d[6] - d[7], f.y), f.z);
    gradient->y = plii_lerp(plii_lerp(d[3] - d[0], d[2] - d[1], f.x), plii_lerp(d[7] - d[4], d[6] - d[5], f.x), f.z);
    gradient->z = plii_lerp(plii_lerp(d[4] - d[0], d[5] - d[1], f.x), plii_lerp(d[7] - d[3], d[6] - d[2], f.x), f.y);
    const float low = plii_lerp(plii_lerp(d[0], d[1], f.x), plii_lerp(d[3], d[2], f.x), f.y);
    const float high = plii_lerp(plii_lerp(d[4], d[5], f.x), plii_lerp(d[7], d[6], f.x), f.y);
    return plii_lerp(low, high, f.z);
}
