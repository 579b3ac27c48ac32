/* Distance of convex sets by the algorithm of Gilbert, Johnson and Keerthi, with signed volumes (Montanari, Petrinic,
   Barbieri, "Improving the GJK algorithm for faster and more reliable distance queries between convex objects", 2017),
   flat simplices by their faces, to the gap of the bounds (van den Bergen, "A fast and robust GJK implementation",
   1999). All in double: differences and products of support points, which are floats, carry hardly any error. */

#include "geometry/gjk.h"

#define GJK_GAP 1e-7          /* of the distance, where the query has none */
#define GJK_TOUCHING 1e-10    /* of the largest difference of support points: distances below count as none */
#define GJK_FLAT_VOLUME 1e-14 /* of the cube of the longest edge from the first vertex */
#define GJK_RESIDUAL 1e-7     /* of that edge: how exactly the weights must give the origin */
#define GJK_FLAT_AREA 1e-8    /* of the product of two edges; what is lost is less than the rounding of floats */
#define GJK_PROGRESS 1e-13    /* of the squared distance */

typedef struct gjk_vertex {
    plii_dvec3 w; /* of a, with the offset, less that of b */
    pli_vec3 point_a, point_b, direction;
} gjk_vertex;

/* Convex combination of up to 4 vertices of a simplex. */
typedef struct gjk_nearest {
    plii_dvec3 point;
    double squared;
    int index[4];
    double weight[4];
    int count;
} gjk_nearest;

/* One by one: a whole one is much to clear and copy. */
static inline void gjk_set(gjk_nearest* nearest, plii_dvec3 point, double squared, int count) {
    nearest->point = point;
    nearest->squared = squared;
    nearest->count = count;
}
static inline void gjk_set_weight(gjk_nearest* nearest, int place, int index, double weight) {
    nearest->index[place] = index;
    nearest->weight[place] = weight;
}

static void gjk_reduce_to_vertex(const gjk_vertex* s, int i, gjk_nearest* best) {
    const double squared = plii_dvec3_dot(s[i].w, s[i].w);
    if (!(squared < best->squared)) { return; }
    gjk_set(best, s[i].w, squared, 1);
    gjk_set_weight(best, 0, i, 1.0);
}

static void gjk_reduce_segment(const gjk_vertex* s, int i, int j, gjk_nearest* best) {
    const plii_dvec3 a = s[i].w, ab = plii_dvec3_sub(s[j].w, a);
    const double length_squared = plii_dvec3_dot(ab, ab), along = -plii_dvec3_dot(a, ab);
    if (!(along > 0.0) || !(length_squared > 0.0)) {
        gjk_reduce_to_vertex(s, i, best);
    } else if (along >= length_squared) {
        gjk_reduce_to_vertex(s, j, best);
    } else {
        const double t = along / length_squared;
        const plii_dvec3 point = plii_dvec3_add_scaled(a, ab, t);
        const double squared = plii_dvec3_dot(point, point);
        if (!(squared < best->squared)) { return; }
        gjk_set(best, point, squared, 2);
        gjk_set_weight(best, 0, i, 1.0 - t);
        gjk_set_weight(best, 1, j, t);
    }
}

static void gjk_reduce_triangle(const gjk_vertex* s, int i, int j, int k, gjk_nearest* best) {
    const plii_dvec3 a = s[i].w, b = s[j].w, c = s[k].w;
    const plii_dvec3 ab = plii_dvec3_sub(b, a), ac = plii_dvec3_sub(c, a), n = plii_dvec3_cross(ab, ac);
    const double area_squared = plii_dvec3_dot(n, n);
    const double scale_squared = plii_dvec3_dot(ab, ab) * plii_dvec3_dot(ac, ac);
    if (!(area_squared > GJK_FLAT_AREA * GJK_FLAT_AREA * scale_squared)) {
        gjk_reduce_segment(s, i, j, best);
        gjk_reduce_segment(s, j, k, best);
        gjk_reduce_segment(s, k, i, best);
        return;
    }
    /* Areas of the triangles that the projected origin makes with the edges, from the vectors to the corners. */
    const plii_dvec3 p = plii_dvec3_scale(n, plii_dvec3_dot(a, n) / area_squared);
    const plii_dvec3 pa = plii_dvec3_sub(a, p), pb = plii_dvec3_sub(b, p), pc = plii_dvec3_sub(c, p);
    const double u = plii_dvec3_dot(plii_dvec3_cross(pb, pc), n);
    const double v = plii_dvec3_dot(plii_dvec3_cross(pc, pa), n);
    const double w = plii_dvec3_dot(plii_dvec3_cross(pa, pb), n);
    if (u > 0.0 && v > 0.0 && w > 0.0) {
        const double squared = plii_dvec3_dot(p, p);
        if (!(squared < best->squared)) { return; }
        const double inverse = 1.0 / (u + v + w);
        gjk_set(best, p, squared, 3);
        gjk_set_weight(best, 0, i, u * inverse);
        gjk_set_weight(best, 1, j, v * inverse);
        gjk_set_weight(best, 2, k, w * inverse);
        return;
    }
    if (!(u > 0.0)) { gjk_reduce_segment(s, j, k, best); }
    if (!(v > 0.0)) { gjk_reduce_segment(s, k, i, best); }
    if (!(w > 0.0)) { gjk_reduce_segment(s, i, j, best); }
}

static void gjk_reduce_tetrahedron(const gjk_vertex* s, gjk_nearest* best) {
    static const int faces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}; /* opposite of each vertex */
    const plii_dvec3 ab = plii_dvec3_sub(s[1].w, s[0].w), ac = plii_dvec3_sub(s[2].w, s[0].w);
    const plii_dvec3 ad = plii_dvec3_sub(s[3].w, s[0].w);
    const double volume = plii_dvec3_dot(plii_dvec3_cross(ab, ac), ad);
    const double ab_squared = plii_dvec3_dot(ab, ab), ac_squared = plii_dvec3_dot(ac, ac);
    const double ad_squared = plii_dvec3_dot(ad, ad), abc_squared = ac_squared > ab_squared ? ac_squared : ab_squared;
    const double longest = sqrt(ad_squared > abc_squared ? ad_squared : abc_squared);
    bool is_flat = !(fabs(volume) > GJK_FLAT_VOLUME * longest * longest * longest);
    double weight[4];
    bool is_inside = !is_flat;
    for (int i = 0; i < 4; ++i) {
        const int* f = faces[i];
        const plii_dvec3 n =
            plii_dvec3_cross(plii_dvec3_sub(s[f[1]].w, s[f[0]].w), plii_dvec3_sub(s[f[2]].w, s[f[0]].w));
        weight[i] = plii_dvec3_dot(n, s[f[0]].w) / volume; /* > 0 when the origin lies on the side of vertex i */
        if (!(weight[i] > 0.0)) { is_inside = false; }
    }
    if (is_inside) {
        const double inverse = 1.0 / (weight[0] + weight[1] + weight[2] + weight[3]);
        plii_dvec3 sum = plii_dvec3_make(0, 0, 0);
        for (int i = 0; i < 4; ++i) {
            gjk_set_weight(best, i, i, weight[i] * inverse);
            sum = plii_dvec3_add_scaled(sum, s[i].w, best->weight[i]);
        }
        if (plii_dvec3_length(sum) <= GJK_RESIDUAL * longest) {
            gjk_set(best, plii_dvec3_make(0, 0, 0), 0.0, 4);
            return;
        }
        is_flat = true; /* too flat for its weights */
    }
    for (int i = 0; i < 4; ++i) {
        if (is_flat || !(weight[i] > 0.0)) { gjk_reduce_triangle(s, faces[i][0], faces[i][1], faces[i][2], best); }
    }
}

static void gjk_find_nearest(const gjk_vertex* simplex, int count, gjk_nearest* best) {
    gjk_set(best, plii_dvec3_make(0, 0, 0), HUGE_VAL, 0);
    if (count == 4) {
        gjk_reduce_tetrahedron(simplex, best);
    } else if (count == 3) {
        gjk_reduce_triangle(simplex, 0, 1, 2, best);
    } else if (count == 2) {
        gjk_reduce_segment(simplex, 0, 1, best);
    } else {
        gjk_reduce_to_vertex(simplex, 0, best);
    }
}

typedef struct gjk_state {
    const plii_gjk_query* query;
    gjk_vertex simplex[4];
    int count;
    double lower_bound;
    pli_vec3 bound_direction; /* that proved it */
    double reach_squared;     /* of the farthest support point so far */
    int support_calls;
    bool is_finite;
} gjk_state;

static bool gjk_is_in_simplex(const gjk_state* state, const gjk_vertex* v) {
    for (int i = 0; i < state->count; ++i) {
        const plii_dvec3 w = state->simplex[i].w;
        if (w.x == v->w.x && w.y == v->w.y && w.z == v->w.z) { return true; }
    }
    return false;
}

/* Support point of a - b against `normal`, and the bound on the distance that it proves. */
static gjk_vertex gjk_support(gjk_state* state, pli_vec3 normal) {
    const plii_convex *a = state->query->a, *b = state->query->b;
    const pli_vec3 point_a = a->support(a->user, pli_vec3_neg(normal)), point_b = b->support(b->user, normal);
    state->support_calls += 2;
    state->is_finite = state->is_finite && plii_vec3_is_finite(point_a) && plii_vec3_is_finite(point_b);
    const plii_dvec3 a_moved = plii_dvec3_add(plii_dvec3_from(point_a), state->query->offset);
    const gjk_vertex v = {plii_dvec3_sub(a_moved, plii_dvec3_from(point_b)), point_a, point_b, normal};
    const double squared = plii_dvec3_dot(v.w, v.w);
    if (squared > state->reach_squared) { state->reach_squared = squared; }
    const plii_dvec3 n = plii_dvec3_from(normal);
    const double bound = plii_dvec3_dot(n, v.w) / plii_dvec3_length(n);
    if (bound > state->lower_bound) {
        state->lower_bound = bound;
        state->bound_direction = normal;
    }
    return v;
}

static bool gjk_may_call(const gjk_state* state) {
    return state->support_calls + 2 <= state->query->max_support_calls;
}

/* Fills the simplex with what the last query knew, or with the point towards the other centre. */
static void gjk_start(gjk_state* state, const plii_convex_cache* cache) {
    const int cached_count = cache == NULL ? 0 : cache->count;
    for (int i = 0; i < cached_count && gjk_may_call(state); ++i) {
        const gjk_vertex v = gjk_support(state, cache->directions[i]);
        if (!gjk_is_in_simplex(state, &v)) { state->simplex[state->count++] = v; }
        if (state->lower_bound > state->query->max_distance) { return; }
    }
    if (state->count > 0) { return; }
    const plii_dvec3 a = plii_dvec3_from(state->query->a->centre), b = plii_dvec3_from(state->query->b->centre);
    pli_vec3 towards = pli_vec3_make(1, 0, 0);
    (void)plii_dvec3_unit(plii_dvec3_add(plii_dvec3_sub(a, b), state->query->offset), &towards);
    state->simplex[state->count++] = gjk_support(state, towards);
}

/* Drops the vertices that the nearest point does not need. */
static void gjk_reduce(gjk_state* state, const gjk_nearest* nearest) {
    state->count = nearest->count;
    gjk_vertex kept[4];
    for (int i = 0; i < nearest->count; ++i) {
        kept[i] = state->simplex[nearest->index[i]];
    }
    for (int i = 0; i < nearest->count; ++i) {
        state->simplex[i] = kept[i];
    }
}

void plii_gjk_run(const plii_gjk_query* query, plii_convex_cache* cache, plii_gjk_result* result) {
    gjk_state state; /* but for the simplex, of which `count` vertices count */
    state.query = query;
    state.count = state.support_calls = 0;
    state.lower_bound = -HUGE_VAL;
    state.bound_direction = pli_vec3_make(0, 0, 0);
    state.reach_squared = 0.0;
    state.is_finite = true;
    gjk_start(&state, cache);
    gjk_nearest found[2], *nearest = &found[0], *next = &found[1];
    gjk_find_nearest(state.simplex, state.count, nearest);
    gjk_reduce(&state, nearest);
    plii_convex_relation relation = PLII_CONVEX_SEPARATED;
    const double gap = query->gap > 0.0 ? query->gap : GJK_GAP;
    while (state.is_finite) {
        if (state.lower_bound > query->max_distance) {
            relation = PLII_CONVEX_BEYOND;
            break;
        }
        if (nearest->squared <= GJK_TOUCHING * GJK_TOUCHING * state.reach_squared) {
            relation = PLII_CONVEX_OVERLAPPING;
            break;
        }
        const double distance = sqrt(nearest->squared);
        if (distance < query->enough || distance - state.lower_bound <= gap * distance || !gjk_may_call(&state)) {
            break;
        }
        const gjk_vertex v = gjk_support(&state, plii_dvec3_to_float(plii_dvec3_scale(nearest->point, 1.0 / distance)));
        if (distance - state.lower_bound <= gap * distance || gjk_is_in_simplex(&state, &v)) { break; }
        state.simplex[state.count] = v; /* beyond what counts until it proves good */
        gjk_find_nearest(state.simplex, state.count + 1, next);
        if (!(next->squared < nearest->squared * (1.0 - GJK_PROGRESS))) { break; }
        gjk_nearest* const before = nearest;
        nearest = next;
        next = before;
        gjk_reduce(&state, nearest);
    }
    if (!state.is_finite) { relation = PLII_CONVEX_UNDEFINED; }
    const plii_dvec3 zero = plii_dvec3_make(0, 0, 0);
    result->relation = relation;
    result->support_calls = state.support_calls;
    result->distance = result->lower_bound = 0.0;
    result->point_a = result->point_b = result->normal = zero;
    result->simplex_count = 0;
    if (relation == PLII_CONVEX_UNDEFINED) { return; }
    for (int i = 0; i < nearest->count; ++i) {
        const gjk_vertex* vertex = &state.simplex[i];
        const plii_dvec3 a = plii_dvec3_add(plii_dvec3_from(vertex->point_a), query->offset);
        result->point_a = plii_dvec3_add_scaled(result->point_a, a, nearest->weight[i]);
        result->point_b = plii_dvec3_add_scaled(result->point_b, plii_dvec3_from(vertex->point_b), nearest->weight[i]);
    }
    for (int i = 0; i < state.count; ++i) {
        result->simplex[i] = state.simplex[i].w;
    }
    result->simplex_count = state.count;
    /* Of pairs that are too far apart, the direction that shows it suffices: next time it will do so at once. */
    const bool is_beyond = relation == PLII_CONVEX_BEYOND;
    if (cache != NULL) { cache->count = is_beyond ? 1 : state.count; }
    for (int i = 0; cache != NULL && i < cache->count; ++i) {
        cache->directions[i] = is_beyond ? state.bound_direction : state.simplex[i].direction;
    }
    const double distance = sqrt(nearest->squared);
    if (distance > 0.0) { result->normal = plii_dvec3_scale(nearest->point, 1.0 / distance); }
    if (relation == PLII_CONVEX_OVERLAPPING) { return; }
    result->distance = distance;
    result->lower_bound = state.lower_bound > 0.0 ? state.lower_bound : 0.0;
}
