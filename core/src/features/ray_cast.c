/* Ray casts against the nodes, links, faces and tetrahedra of a body. In reference mode faces and tetrahedra are met
   where btSoftBody::rayTest meets them, bit for bit: its tolerances have units, and triangles of a few centimetres are
   met far beside themselves. Nodes are spheres and links are capsules, which Bullet does not test. */

#include "body/world_state.h"
#include "math/dvec3.h"
#include "pliant/query.h"

#define RAY_TOLERANCE (PLII_EPSILON * 10.0f)

typedef struct ray_cast {
    const pli_body* body;
    pli_vec3 from, direction; /* not normalised */
    double radius;
    pli_ray_hit hit; /* the nearest so far, fraction 1 without one */
} ray_cast;

PLII_DEFINE_DEFAULT(pli_ray_def, .targets = PLI_RAY_FACES | PLI_RAY_TETRAS)
static pli_vec3 ray_position(const ray_cast* ray, int node) {
    return plii_xyz(ray->body->positions[node]);
}
static pli_vec3 ray_point(const ray_cast* ray, float fraction) {
    return pli_vec3_add(ray->from, pli_vec3_scale(ray->direction, fraction));
}

static void ray_accept(ray_cast* ray, pli_feature_kind kind, int index, float fraction, pli_vec3 normal) {
    ray->hit = (pli_ray_hit){
        .kind = kind, .index = index, .fraction = fraction, .normal = normal, .nearest_node = PLI_NULL_INDEX};
}

static void ray_cast_triangle_as_in_bullet(ray_cast* ray, pli_feature_kind kind, int index, const int nodes[3]) {
    const pli_vec3 a = ray_position(ray, nodes[0]), b = ray_position(ray, nodes[1]), c = ray_position(ray, nodes[2]);
    const pli_vec3 n = pli_vec3_cross(pli_vec3_sub(b, a), pli_vec3_sub(c, a));
    const float slope = pli_vec3_dot(ray->direction, n);
    if (!(fabsf(slope) >= PLII_EPSILON)) { return; }
    const float t = -(pli_vec3_dot(ray->from, n) - pli_vec3_dot(a, n)) / slope;
    if (!(t > RAY_TOLERANCE && t < ray->hit.fraction)) { return; }
    const pli_vec3 hit = ray_point(ray, t);
    const pli_vec3 to_a = pli_vec3_sub(a, hit), to_b = pli_vec3_sub(b, hit), to_c = pli_vec3_sub(c, hit);
    if (!(pli_vec3_dot(n, pli_vec3_cross(to_a, to_b)) > -RAY_TOLERANCE &&
          pli_vec3_dot(n, pli_vec3_cross(to_b, to_c)) > -RAY_TOLERANCE &&
          pli_vec3_dot(n, pli_vec3_cross(to_c, to_a)) > -RAY_TOLERANCE)) {
        return;
    }
    const pli_vec3 normal = plii_vec3_safe_normalize(n);
    ray_accept(ray, kind, index, t, slope > 0.0f ? pli_vec3_neg(normal) : normal);
}

/* On which side of the ray an edge goes by, seen from its start: twice the area times the length. Of the edge the other
   way round it is the same number with the other sign, so that no ray slips through between two triangles. */
static double ray_side(plii_dvec3 direction, plii_dvec3 p, plii_dvec3 q) {
    return plii_dvec3_dot(direction, plii_dvec3_cross(p, q));
}

static void ray_cast_triangle(ray_cast* ray, pli_feature_kind kind, int index, const int nodes[3]) {
    const plii_dvec3 direction = plii_dvec3_from(ray->direction), from = plii_dvec3_from(ray->from);
    const plii_dvec3 a = plii_dvec3_sub(plii_dvec3_from(ray_position(ray, nodes[0])), from),
                     b = plii_dvec3_sub(plii_dvec3_from(ray_position(ray, nodes[1])), from),
                     c = plii_dvec3_sub(plii_dvec3_from(ray_position(ray, nodes[2])), from);
    const double ab = ray_side(direction, a, b), bc = ray_side(direction, b, c), ca = ray_side(direction, c, a);
    const bool is_inside = (ab >= 0.0 && bc >= 0.0 && ca >= 0.0) || (ab <= 0.0 && bc <= 0.0 && ca <= 0.0);
    const plii_dvec3 n = plii_dvec3_cross(plii_dvec3_sub(b, a), plii_dvec3_sub(c, a));
    const double slope = plii_dvec3_dot(direction, n);
    pli_vec3 normal;
    if (!is_inside || slope == 0.0 || !plii_dvec3_unit(n, &normal)) { return; }
    const float t = (float)(plii_dvec3_dot(a, n) / slope);
    if (!(t > RAY_TOLERANCE && t < ray->hit.fraction)) { return; }
    ray_accept(ray, kind, index, t, slope > 0.0 ? pli_vec3_neg(normal) : normal);
}

/* In double, since a thin link far from the start of a long ray is what a mouse looks for. */

/* Where x(t) = offset + t * direction enters |x| = radius; -1 when it does not, or starts inside. */
static double ray_enter_sphere(plii_dvec3 offset, plii_dvec3 direction, double radius) {
    const double a = plii_dvec3_dot(direction, direction);
    const double nearest = -plii_dvec3_dot(offset, direction) / a;
    const plii_dvec3 closest = plii_dvec3_add_scaled(offset, direction, nearest);
    const double under_root = radius * radius - plii_dvec3_dot(closest, closest);
    if (!(under_root > 0.0) || !(a > 0.0)) { return -1.0; }
    return nearest - sqrt(under_root / a);
}

static void ray_accept_round(ray_cast* ray, pli_feature_kind kind, int index, double t, plii_dvec3 outward) {
    const float fraction = (float)t;
    const double length = plii_dvec3_length(outward);
    if (!(t > 0.0 && fraction > 0.0f && fraction < ray->hit.fraction && length > 0.0)) { return; }
    const pli_vec3 normal =
        pli_vec3_make((float)(outward.x / length), (float)(outward.y / length), (float)(outward.z / length));
    ray_accept(ray, kind, index, fraction, normal);
}

static void ray_cast_node(ray_cast* ray, int index) {
    const plii_dvec3 direction = plii_dvec3_from(ray->direction);
    const plii_dvec3 offset = plii_dvec3_sub(plii_dvec3_from(ray->from), plii_dvec3_from(ray_position(ray, index)));
    const double t = ray_enter_sphere(offset, direction, ray->radius);
    ray_accept_round(ray, PLI_FEATURE_NODE, index, t, plii_dvec3_add_scaled(offset, direction, t));
}

/* The part of the ray inside a link, if the ray starts outside: the earliest of the tube and both ends. */
static void ray_cast_link(ray_cast* ray, int index) {
    const int* nodes = ray->body->links[index].nodes;
    const plii_dvec3 direction = plii_dvec3_from(ray->direction);
    const plii_dvec3 a = plii_dvec3_from(ray_position(ray, nodes[0])), b = plii_dvec3_from(ray_position(ray, nodes[1]));
    const plii_dvec3 axis = plii_dvec3_sub(b, a), offset = plii_dvec3_sub(plii_dvec3_from(ray->from), a);
    const double axis_squared = plii_dvec3_dot(axis, axis);

    const double along = axis_squared > 0.0 ? plii_dvec3_dot(offset, axis) / axis_squared : 0.0;
    const double clamped = along < 0.0 ? 0.0 : along > 1.0 ? 1.0 : along;
    const plii_dvec3 to_start = plii_dvec3_add_scaled(offset, axis, -clamped);
    if (plii_dvec3_dot(to_start, to_start) <= ray->radius * ray->radius) { return; }

    double first = DBL_MAX;
    plii_dvec3 outward = {0.0, 0.0, 0.0};
    for (int end = 0; end < 2; ++end) {
        const plii_dvec3 to_end = plii_dvec3_add_scaled(offset, axis, -(double)end);
        const double t = ray_enter_sphere(to_end, direction, ray->radius);
        if (t > 0.0 && t < first) {
            first = t;
            outward = plii_dvec3_add_scaled(to_end, direction, t);
        }
    }
    if (axis_squared > 0.0) {
        /* Across the axis the tube is a circle. */
        const double advance = plii_dvec3_dot(direction, axis) / axis_squared;
        const plii_dvec3 across = plii_dvec3_add_scaled(direction, axis, -advance);
        const plii_dvec3 start = plii_dvec3_add_scaled(offset, axis, -along);
        const double t = ray_enter_sphere(start, across, ray->radius);
        const double at = along + t * advance; /* 0 to 1 between the ends */
        if (t > 0.0 && t < first && at >= 0.0 && at <= 1.0) {
            first = t;
            outward = plii_dvec3_add_scaled(start, across, t);
        }
    }
    if (first < DBL_MAX) { ray_accept_round(ray, PLI_FEATURE_LINK, index, first, outward); }
}

/* Faces and tetrahedra before what Bullet does not test. */
static void ray_cast_targets(ray_cast* ray, int targets) {
    const pli_body* body = ray->body;
    const plii_topology* topology = body->topology;
    void (*const cast_triangle)(ray_cast*, pli_feature_kind, int, const int[3]) =
        body->world->def.reference_mode ? ray_cast_triangle_as_in_bullet : ray_cast_triangle;
    for (int i = 0; i < topology->face_count && (targets & PLI_RAY_FACES) != 0; ++i) {
        cast_triangle(ray, PLI_FEATURE_FACE, i, topology->faces[i]);
    }
    for (int i = 0; i < topology->tetra_count && (targets & PLI_RAY_TETRAS) != 0; ++i) {
        const int* n = topology->tetras[i];
        const int sides[4][3] = {{n[0], n[1], n[2]}, {n[0], n[1], n[3]}, {n[1], n[2], n[3]}, {n[0], n[2], n[3]}};
        for (int k = 0; k < 4; ++k) {
            cast_triangle(ray, PLI_FEATURE_TETRA, i, sides[k]);
        }
    }
    for (int i = 0; i < body->link_count && (targets & PLI_RAY_LINKS) != 0; ++i) {
        ray_cast_link(ray, i);
    }
    for (int i = 0; i < body->node_count && (targets & PLI_RAY_NODES) != 0; ++i) {
        ray_cast_node(ray, i);
    }
}

static void ray_find_nearest_node(ray_cast* ray) {
    pli_ray_hit* hit = &ray->hit;
    const pli_body* body = ray->body;
    static const int counts[] = {
        [PLI_FEATURE_NODE] = 1, [PLI_FEATURE_LINK] = 2, [PLI_FEATURE_FACE] = 3, [PLI_FEATURE_TETRA] = 4};
    const int* nodes = hit->kind == PLI_FEATURE_LINK    ? body->links[hit->index].nodes
                       : hit->kind == PLI_FEATURE_FACE  ? body->topology->faces[hit->index]
                       : hit->kind == PLI_FEATURE_TETRA ? body->topology->tetras[hit->index]
                                                        : &hit->index;
    float least = INFINITY;
    for (int k = 0; k < counts[hit->kind]; ++k) {
        const float squared = pli_vec3_length_squared(pli_vec3_sub(ray_position(ray, nodes[k]), hit->point));
        if (k == 0 || squared < least) {
            least = squared;
            hit->nearest_node = nodes[k];
        }
    }
}

pli_status pli_body_cast_ray(const pli_body* body, const pli_ray_def* def, pli_ray_hit* hit) {
    PLII_TRY(plii_check_body(body, __func__));
    pli_context* context = body->context;
    if (hit == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "hit is null"); }
    PLII_TRY(PLII_CHECK_MADE(context, pli_ray_def, def, __func__));
    const int known = PLI_RAY_NODES | PLI_RAY_LINKS | PLI_RAY_FACES | PLI_RAY_TETRAS;
    PLII_FAIL_IF(def->targets == 0 || (def->targets & ~known) != 0, context, PLI_ERROR_INVALID_VALUE, __func__,
                 "targets is 0x%x, bits of 0x%x are wanted", (unsigned)def->targets, (unsigned)known);
    const pli_vec3 ends[2] = {def->from, def->to}, direction = pli_vec3_sub(def->to, def->from);
    PLII_TRY(plii_check_between(context, def->radius, 0.0f, PLI_MAX_COORDINATE, "radius", __func__));
    PLII_TRY(plii_check_finite_points(context, 2, ends, "end", __func__));
    PLII_FAIL_IF(!(pli_vec3_length_squared(direction) > 0.0f) || !plii_is_finite(pli_vec3_length_squared(direction)),
                 context, PLI_ERROR_INVALID_VALUE, __func__, "the ray is %g m long",
                 (double)pli_vec3_length(direction));
    ray_cast ray = {
        .body = body,
        .from = def->from,
        .direction = direction,
        .radius = (double)def->radius,
        .hit = {.kind = PLI_FEATURE_NONE, .index = PLI_NULL_INDEX, .fraction = 1.0f, .nearest_node = PLI_NULL_INDEX},
    };
    ray_cast_targets(&ray, def->targets);
    ray.hit.point = ray_point(&ray, ray.hit.fraction);
    if (ray.hit.kind != PLI_FEATURE_NONE) { ray_find_nearest_node(&ray); }
    *hit = ray.hit;
    return PLI_OK;
}
