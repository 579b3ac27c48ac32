#ifndef PLIANT_QUERY_H
#define PLIANT_QUERY_H

/// Questions about where a body is.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What a ray may hit.
enum { PLI_RAY_NODES = 1, PLI_RAY_LINKS = 2, PLI_RAY_FACES = 4, PLI_RAY_TETRAS = 8 };

typedef enum pli_feature_kind {
    PLI_FEATURE_NONE = 0,
    PLI_FEATURE_NODE,
    PLI_FEATURE_LINK,
    PLI_FEATURE_FACE,
    PLI_FEATURE_TETRA
} pli_feature_kind;

typedef struct pli_ray_def {
    pli_vec3 from, to; ///< m, up to PLI_MAX_COORDINATE
    int targets;       ///< PLI_RAY_ bits, default PLI_RAY_FACES | PLI_RAY_TETRAS as btSoftBody::rayTest
    /// m, >= 0, default 0: nodes are spheres and links are capsules of that radius. With 0 they cannot be hit, nor
    /// can those that the ray starts in.
    float radius;
    uint32_t cookie;
} pli_ray_def;

typedef struct pli_ray_hit {
    pli_feature_kind kind;
    int index;        ///< of the node, link, face or tetrahedron
    float fraction;   ///< (0, 1) from `from` to `to`
    pli_vec3 point;   ///< m
    pli_vec3 normal;  ///< unit, against the ray
    int nearest_node; ///< of the feature, to the point
} pli_ray_hit;

PLI_API pli_ray_def pli_ray_def_default(void);
/// The nearest hit. `hit->kind` is PLI_FEATURE_NONE, and the fraction 1, when there is none. Faces and tetrahedra are
/// hit from both sides; of features that are hit at the same place faces come first, then tetrahedra, links, nodes.
/// Linear in what is asked for. Bullet name: rayTest
/// @return PLI_ERROR_NOT_FINITE, PLI_ERROR_INVALID_VALUE (a ray without length, a negative radius, no known target)
PLI_API pli_status pli_body_cast_ray(const pli_body* body, const pli_ray_def* def, pli_ray_hit* hit);

#ifdef __cplusplus
}
#endif
#endif
