#ifndef PLIANT_QUERY_H
#define PLIANT_QUERY_H

/// Ray casts.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What a ray may hit; bits.
enum {
    PLI_RAY_NODES = 1, ///< spheres of pli_ray_def::radius; for picking
    PLI_RAY_LINKS = 2, ///< capsules of that radius; for ropes
    PLI_RAY_FACES = 4, ///< triangles, from both sides; for surfaces
    PLI_RAY_TETRAS = 8 ///< solids, from outside and inside; for bodies without faces
};

/// What a ray has hit.
typedef enum pli_feature_kind {
    PLI_FEATURE_NONE = 0, ///< nothing
    PLI_FEATURE_NODE,     ///< `index` is that of a node
    PLI_FEATURE_LINK,     ///< of a link
    PLI_FEATURE_FACE,     ///< of a face
    PLI_FEATURE_TETRA     ///< of a tetrahedron
} pli_feature_kind;

/// A ray, and what it may hit.
typedef struct pli_ray_def {
    pli_vec3 from; ///< m, up to PLI_MAX_COORDINATE, default zero
    pli_vec3 to;   ///< as `from`, required; another point than it
    int targets;   ///< PLI_RAY_ bits, default PLI_RAY_FACES | PLI_RAY_TETRAS as btSoftBody::rayTest
    /// m, >= 0, default 0: nodes are spheres and links are capsules of that radius. With 0 they cannot be hit, nor
    /// can those that the ray starts in.
    float radius;
    uint32_t cookie; ///< set by the default function
} pli_ray_def;

/// Where a ray has hit.
typedef struct pli_ray_hit {
    pli_feature_kind kind; ///< PLI_FEATURE_NONE: nowhere
    int index;             ///< of the node, link, face or tetrahedron
    float fraction;        ///< (0, 1) from `from` to `to`; 1 without a hit
    pli_vec3 point;        ///< m
    pli_vec3 normal;       ///< unit, against the ray
    int nearest_node;      ///< of the feature, to the point
} pli_ray_hit;

/// Defaults of the fields; `from` and `to` have to be set.
PLI_API pli_ray_def pli_ray_def_default(void);

/// Finds the nearest hit of a ray with one body, as it is now. Faces and tetrahedra are hit from both sides. Where
/// several are hit at the same place faces come first, then tetrahedra, links, nodes. The first 1.2e-6 of the ray hits
/// no face and no tetrahedron, so that a ray may continue from a hit. Time is linear in the number of `targets`. In
/// reference mode (pli_world_def) it does as btSoftBody, which takes triangles below some centimetres for much larger
/// ones. Bullet name: rayTest
/// @return PLI_ERROR_INVALID_VALUE also for a ray without length and without a known target
PLI_API pli_status pli_body_cast_ray(const pli_body* body, const pli_ray_def* def, pli_ray_hit* hit);

#ifdef __cplusplus
}
#endif
#endif
