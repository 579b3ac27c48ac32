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
    pli_vec3 from, to;
    int targets;  ///< PLI_RAY_ bits, default PLI_RAY_FACES | PLI_RAY_TETRAS as btSoftBody::rayTest
    float radius; ///< m, >= 0, default 0: thickness of nodes and links, which need it to be hit
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
/// The nearest hit. `hit->kind` is PLI_FEATURE_NONE when there is none. Linear in what is asked for.
PLI_API pli_status pli_body_cast_ray(const pli_body* body, const pli_ray_def* def, pli_ray_hit* hit);

#ifdef __cplusplus
}
#endif
#endif
