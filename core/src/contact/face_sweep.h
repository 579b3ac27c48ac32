#pragma once

/* The way of a face past a convex core during a step, both relative to the moving centre of mass of the rigid body that
   the core belongs to. The core turns evenly, the corners of the face go straight. */

#include "geometry/convex_distance.h"
#include "shape/shape_impl.h"

typedef struct plii_face_core {
    const pli_shape* shape;   /* convex, unless there is a triangle */
    const pli_vec3* triangle; /* [3] a piece of the shape, or NULL */
    pli_transform pose;       /* of the shape in the frame of the rigid body */
    pli_mat3 rotation;        /* of the rigid body at the start */
    pli_vec3 rotation_vector; /* its rotation during the step */
    float reach;              /* of the core from the centre of mass; m */
} plii_face_core;

typedef struct plii_face_sweep {
    const plii_face_core* core;
    /* Near the face, from the centre of mass. Points of a sweep are relative to it: those of the face and of the
       surface beside it are small then and keep their digits, however large the core is. */
    plii_dvec3 origin;
    pli_vec3 begin[3], end[3]; /* corners; a link has its last one twice */
    bool is_link;
    bool has_side; /* overlapping from the start, it is pushed to this side, not the shortest way */
    pli_vec3 side;
} plii_face_sweep;

/* Nearest points at one moment. */
typedef struct plii_face_moment {
    float time; /* 0 at the begin, 1 at the end */
    bool is_overlapping;
    float distance;      /* of face and core; < 0: overlapping */
    pli_vec3 normal;     /* unit, from the core to the face */
    pli_vec3 point;      /* on the face */
    pli_vec3 nearest;    /* of the core to it */
    pli_vec3 core_point; /* the same in the frame of the rigid body */
    pli_vec3 weights;    /* of the point; set by plii_face_sweep_weigh */
} plii_face_moment;

/* At `time`. False where face and core are farther apart than `max_distance`, or have no distance. */
bool plii_face_sweep_look(const plii_face_sweep* sweep, float time, float max_distance, plii_face_moment* moment);
/* On to the moment when face and core are `target` > 0 apart, up to `tolerance` more. False when there is none. */
bool plii_face_sweep_advance(const plii_face_sweep* sweep, float target, float tolerance, plii_face_moment* moment);
/* False for faces without area. */
bool plii_face_sweep_weigh(const plii_face_sweep* sweep, plii_face_moment* moment);

/* Upper bound of the way of a point of the face relative to the core. */
float plii_face_sweep_length(const plii_face_sweep* sweep);
/* How far the core reaches along a unit vector from the centre of mass. */
double plii_face_core_height(const plii_face_core* core, float time, pli_vec3 normal);
/* How much farther than its nearest point the core reaches along the normal of a moment; 0 where they overlap. It would
   be nothing with an exact normal, but a thousandth of a radian is ten metres at the far end of ten kilometres. */
float plii_face_sweep_excess(const plii_face_sweep* sweep, const plii_face_moment* moment);
/* Distance of the point of the face from the core along the normal, at the end. */
float plii_face_sweep_end_gap(const plii_face_sweep* sweep, const plii_face_moment* moment);

static inline pli_vec3 plii_face_blend(const pli_vec3* corners, pli_vec3 weights) {
    return pli_vec3_add(pli_vec3_add(pli_vec3_scale(corners[0], weights.x), pli_vec3_scale(corners[1], weights.y)),
                        pli_vec3_scale(corners[2], weights.z));
}
