/* Conservative advancement of a face past a convex core: Mirtich, "Impulse-based dynamic simulation", 1996. */

#include "contact/face_sweep.h"
#include "body/rigid_impl.h"

#define FACE_WAY_MAX_ADVANCES 24
/* Cosine: a push that turns farther than this from the side that is known goes to the known side itself. */
#define FACE_WAY_SAME_SIDE 0.7f

/* A core at one moment. */
typedef struct face_sweep_core {
    const pli_shape* shape;
    const pli_vec3* triangle;
    pli_transform pose;
    plii_dvec3 origin; /* of the pose, relative to that of the sweep */
} face_sweep_core;

static face_sweep_core face_sweep_core_at(const plii_face_core* core, plii_dvec3 origin, float time) {
    const pli_transform begin = {core->rotation, {0, 0, 0}};
    const pli_transform rotated = plii_rigid_advance(begin, (plii_twist){{0, 0, 0}, core->rotation_vector}, time);
    const pli_transform pose = pli_transform_mul(rotated, core->pose);
    return (face_sweep_core){core->shape, core->triangle, pose, plii_dvec3_sub(plii_dvec3_from(pose.origin), origin)};
}

static plii_dvec3 face_sweep_core_point(const face_sweep_core* core, pli_vec3 local) {
    return plii_dvec3_add(core->origin, plii_dvec3_rotate(&core->pose.rotation, plii_dvec3_from(local)));
}

/* Of a triangle. */
static pli_vec3 face_sweep_support(const void* user, pli_vec3 direction) {
    return plii_vec3_farthest(3, user, direction);
}

static plii_dvec3 face_sweep_core_farthest(const face_sweep_core* core, pli_vec3 direction) {
    const pli_vec3 local = pli_mat3_transpose_mul_vec3(core->pose.rotation, direction);
    const pli_vec3 farthest = core->triangle != NULL ? face_sweep_support(core->triangle, local)
                                                     : core->shape->def.support(core->shape->def.user, local);
    return face_sweep_core_point(core, farthest);
}

static pli_vec3 face_sweep_core_support(const void* user, pli_vec3 direction) {
    return plii_dvec3_to_float(face_sweep_core_farthest(user, direction));
}
static double face_sweep_height(const face_sweep_core* core, pli_vec3 normal) {
    return plii_dvec3_dot(face_sweep_core_farthest(core, normal), plii_dvec3_from(normal));
}

double plii_face_core_height(const plii_face_core* core, float time, pli_vec3 normal) {
    const face_sweep_core placed = face_sweep_core_at(core, plii_dvec3_make(0, 0, 0), time);
    return face_sweep_height(&placed, normal);
}

float plii_face_sweep_excess(const plii_face_sweep* sweep, const plii_face_moment* moment) {
    if (moment->is_overlapping) { return 0.0f; }
    const face_sweep_core core = face_sweep_core_at(sweep->core, sweep->origin, moment->time);
    const double along = plii_dvec3_dot(plii_dvec3_from(moment->nearest), plii_dvec3_from(moment->normal));
    return plii_max((float)(face_sweep_height(&core, moment->normal) - along), 0.0f);
}

float plii_face_sweep_end_gap(const plii_face_sweep* sweep, const plii_face_moment* moment) {
    const face_sweep_core core = face_sweep_core_at(sweep->core, sweep->origin, 1.0f);
    const float height = (float)face_sweep_height(&core, moment->normal) - plii_face_sweep_excess(sweep, moment);
    return pli_vec3_dot(moment->normal, plii_face_blend(sweep->end, moment->weights)) - height;
}

float plii_face_sweep_length(const plii_face_sweep* sweep) {
    float longest = 0.0f;
    for (int k = 0; k < 3; ++k) {
        longest = plii_max(longest, pli_vec3_length(pli_vec3_sub(sweep->end[k], sweep->begin[k])));
    }
    return longest + pli_vec3_length(sweep->core->rotation_vector) * sweep->core->reach;
}

static void face_sweep_corners(const plii_face_sweep* sweep, float time, pli_vec3* corners) {
    for (int k = 0; k < 3; ++k) {
        corners[k] = pli_vec3_add(sweep->begin[k], pli_vec3_scale(pli_vec3_sub(sweep->end[k], sweep->begin[k]), time));
    }
}

static pli_vec3 face_sweep_middle(const pli_vec3* corners) {
    return pli_vec3_scale(pli_vec3_add(pli_vec3_add(corners[0], corners[1]), corners[2]), 1.0f / 3.0f);
}

static bool face_sweep_measure(const face_sweep_core* core, const pli_vec3* corners, float max_distance,
                               plii_convex_cache* cache, plii_convex_result* result) {
    const pli_vec3 middle = core->triangle == NULL ? pli_vec3_make(0, 0, 0) : face_sweep_middle(core->triangle);
    const plii_convex rigid = {.support = face_sweep_core_support,
                               .user = core,
                               .centre = plii_dvec3_to_float(face_sweep_core_point(core, middle))};
    const plii_convex face = {.support = face_sweep_support, .user = corners, .centre = face_sweep_middle(corners)};
    const plii_convex_options options = {.max_distance = max_distance};
    plii_convex_distance(&face, &rigid, &options, cache, result);
    return result->relation == PLII_CONVEX_SEPARATED || result->relation == PLII_CONVEX_OVERLAPPING;
}

static void face_sweep_record(const face_sweep_core* core, const plii_face_sweep* sweep,
                              const plii_convex_result* result, plii_face_moment* moment) {
    moment->is_overlapping = result->relation == PLII_CONVEX_OVERLAPPING;
    moment->distance = result->distance;
    moment->normal = result->normal;
    moment->point = result->point_a;
    moment->nearest = result->point_b;
    const pli_vec3 from_core = plii_dvec3_to_float(plii_dvec3_sub(plii_dvec3_from(result->point_b), core->origin));
    moment->core_point =
        pli_transform_point(sweep->core->pose, pli_mat3_transpose_mul_vec3(core->pose.rotation, from_core));
}

/* Overlapping cores and the side where the face belongs: nearest points after the face is lifted out to that side. */
static bool face_sweep_lift(const plii_face_sweep* sweep, const face_sweep_core* core, const pli_vec3* corners,
                            plii_face_moment* moment) {
    const float depth = (float)face_sweep_height(core, sweep->side) -
                        pli_vec3_dot(face_sweep_support(corners, pli_vec3_neg(sweep->side)), sweep->side);
    const float lift = depth + plii_max(0.05f * depth, 1e-3f * pli_vec3_length(pli_vec3_sub(corners[1], corners[0])));
    const pli_vec3 up = pli_vec3_scale(sweep->side, lift);
    pli_vec3 lifted[3];
    for (int k = 0; k < 3; ++k) {
        lifted[k] = pli_vec3_add(corners[k], up);
    }
    plii_convex_result result;
    if (!(lift > 0.0f) || !face_sweep_measure(core, lifted, INFINITY, NULL, &result)) { return false; }
    if (result.relation != PLII_CONVEX_SEPARATED) { return false; }
    face_sweep_record(core, sweep, &result, moment);
    if (!(pli_vec3_dot(result.normal, sweep->side) > FACE_WAY_SAME_SIDE)) { moment->normal = sweep->side; }
    moment->point = pli_vec3_sub(result.point_a, up);
    moment->is_overlapping = true;
    moment->distance = pli_vec3_dot(face_sweep_support(corners, pli_vec3_neg(moment->normal)), moment->normal) -
                       (float)face_sweep_height(core, moment->normal);
    return true;
}

bool plii_face_sweep_look(const plii_face_sweep* sweep, float time, float max_distance, plii_face_moment* moment) {
    pli_vec3 corners[3];
    face_sweep_corners(sweep, time, corners);
    const face_sweep_core core = face_sweep_core_at(sweep->core, sweep->origin, time);
    plii_convex_result result;
    if (!face_sweep_measure(&core, corners, max_distance, NULL, &result)) { return false; }
    moment->time = time;
    face_sweep_record(&core, sweep, &result, moment);
    /* On the other side altogether, where only the host can have put it. */
    const bool is_beyond = sweep->has_side && pli_vec3_dot(moment->normal, sweep->side) < 0.0f;
    return !(sweep->has_side && (moment->is_overlapping || is_beyond)) ||
           face_sweep_lift(sweep, &core, corners, moment);
}

/* How much nearer face and core may come along `normal` on the whole way. */
static float face_sweep_approach(const plii_face_sweep* sweep, pli_vec3 normal) {
    float approach = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        approach = plii_max(approach, -pli_vec3_dot(normal, pli_vec3_sub(sweep->end[k], sweep->begin[k])));
    }
    return approach + pli_vec3_length(sweep->core->rotation_vector) * sweep->core->reach;
}

bool plii_face_sweep_advance(const plii_face_sweep* sweep, float target, float tolerance, plii_face_moment* moment) {
    plii_convex_cache cache = {.directions = {moment->normal}, .count = 1};
    for (int i = 0; i < FACE_WAY_MAX_ADVANCES; ++i) {
        const float gap = moment->distance - target;
        if (!(gap > tolerance)) { return true; }
        const float approach = face_sweep_approach(sweep, moment->normal);
        if (!(approach * (1.0f - moment->time) > gap)) { return false; }
        const float time = moment->time + gap / approach;
        pli_vec3 corners[3];
        face_sweep_corners(sweep, time, corners);
        const face_sweep_core core = face_sweep_core_at(sweep->core, sweep->origin, time);
        plii_convex_result result;
        if (!face_sweep_measure(&core, corners, INFINITY, &cache, &result)) { return false; }
        /* On the way cores cannot overlap but for rounding: then the moment before counts. */
        if (result.relation == PLII_CONVEX_OVERLAPPING) { return true; }
        moment->time = time;
        face_sweep_record(&core, sweep, &result, moment);
    }
    return true;
}

bool plii_face_sweep_weigh(const plii_face_sweep* sweep, plii_face_moment* moment) {
    pli_vec3 corners[3];
    face_sweep_corners(sweep, moment->time, corners);
    const pli_vec3 ab = pli_vec3_sub(corners[1], corners[0]), ac = pli_vec3_sub(corners[2], corners[0]);
    const pli_vec3 ap = pli_vec3_sub(moment->point, corners[0]);
    if (sweep->is_link) {
        const float t = plii_clamp(pli_vec3_dot(ap, ab) / pli_vec3_length_squared(ab), 0.0f, 1.0f);
        moment->weights = pli_vec3_make(1.0f - t, t, 0.0f);
    } else {
        const pli_vec3 n = pli_vec3_cross(ab, ac);
        const float inverse = 1.0f / pli_vec3_length_squared(n);
        const float v = plii_max(pli_vec3_dot(pli_vec3_cross(ap, ac), n) * inverse, 0.0f);
        const float w = plii_max(pli_vec3_dot(pli_vec3_cross(ab, ap), n) * inverse, 0.0f);
        const float sum = plii_max(v + w, 1.0f);
        moment->weights = pli_vec3_make(plii_max(1.0f - v - w, 0.0f), v / sum, w / sum);
    }
    return plii_vec3_is_finite(moment->weights);
}
