/* Signed distance of convex cores. Apart: GJK. Overlapping: for every unit direction n the support points give the way
   d(n) that one core must go along n to come free; the depth is the least d(n). Started from the best of some
   directions and from a penetration search, d(n) is lowered by GJK itself: moved a little more than d(n) along n the
   cores are apart, and the normal n' of their distance has d(n') <= d(n), equal only where n is a local minimum. The
   last of these distances also yields the witness points. */

#include "convex_distance.h"

#define CONVEX_GAP 0.05          /* of the depth: how far beyond it the cores are moved */
#define CONVEX_SMALLEST_GAP 1e-4 /* of the size */
#define CONVEX_PROGRESS 1e-5     /* of the depth */
#define CONVEX_MAX_DESCENTS 8
#define CONVEX_DESCENT_CALLS 24 /* kept back for the last descent */

typedef struct convex_search {
    const plii_convex* a;
    const plii_convex* b;
    pli_vec3 normal;
    double depth;
    bool has_normal;
    pli_vec3 point_a; /* support points of the best direction */
    double size;
    int support_calls;
    int max_support_calls;
    bool is_finite;
} convex_search;

plii_convex_options plii_convex_options_default(void) {
    const plii_convex_options options = {.max_distance = HUGE_VALF, .max_support_calls = PLII_CONVEX_MAX_SUPPORT_CALLS};
    return options;
}

/* False for what has no direction. */
static bool convex_normalize(plii_dvec3 v, pli_vec3* unit) {
    const double length = plii_dvec3_length(v);
    if (!(length > 0.0) || !isfinite(length)) { return false; }
    *unit = plii_dvec3_to_float(plii_dvec3_scale(v, 1.0 / length));
    return true;
}

/* Measures d(normal) and keeps the least. True when it became less. */
static bool convex_try(convex_search* search, pli_vec3 normal) {
    if (search->support_calls + 2 > search->max_support_calls) { return false; }
    const pli_vec3 a = search->a->support(search->a->user, pli_vec3_neg(normal));
    const pli_vec3 b = search->b->support(search->b->user, normal);
    search->support_calls += 2;
    if (!plii_vec3_is_finite(a) || !plii_vec3_is_finite(b)) {
        search->is_finite = false;
        return false;
    }
    const plii_dvec3 n = plii_dvec3_from(normal), w = plii_dvec3_sub(plii_dvec3_from(b), plii_dvec3_from(a));
    const double depth = plii_dvec3_dot(n, w) / plii_dvec3_length(n);
    const double reach = plii_dvec3_length(w);
    if (reach > search->size) { search->size = reach; }
    if (search->has_normal && !(depth < search->depth)) { return false; }
    search->normal = normal;
    search->depth = depth;
    search->point_a = a;
    search->has_normal = true;
    return true;
}

/* Outward face normals of the simplex in a - b; of a flat one both sides. */
static void convex_try_simplex(convex_search* search, const plii_dvec3* s, int count) {
    for (int i = 0; i < count && count >= 3; ++i) {
        const plii_dvec3 p = s[(i + 1) % count], q = s[(i + 2) % count], r = s[(i + 3) % count];
        pli_vec3 normal;
        if (!convex_normalize(plii_dvec3_cross(plii_dvec3_sub(q, p), plii_dvec3_sub(r, p)), &normal)) { continue; }
        const plii_dvec3 inward = plii_dvec3_sub(s[i], p);
        if (count == 3) {
            convex_try(search, normal);
            convex_try(search, pli_vec3_neg(normal));
            return;
        }
        convex_try(search, plii_dvec3_dot(plii_dvec3_from(normal), inward) > 0.0 ? normal : pli_vec3_neg(normal));
    }
}

static void convex_find_start(convex_search* search, const plii_convex_cache* cache, const plii_gjk_result* gjk) {
    static const pli_vec3 axes[6] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}};
    pli_vec3 between, nearest;
    if (convex_normalize(gjk->normal, &nearest)) { convex_try(search, nearest); }
    if (cache != NULL && cache->has_normal) { convex_try(search, cache->normal); }
    if (convex_normalize(plii_dvec3_sub(plii_dvec3_from(search->a->centre), plii_dvec3_from(search->b->centre)),
                         &between)) {
        convex_try(search, between);
    }
    convex_try_simplex(search, gjk->simplex, gjk->simplex_count);
    for (int i = 0; i < 6; ++i) {
        convex_try(search, axes[i]);
    }
}

/* Lowers the depth to a local minimum and sets the witness points. */
static void convex_descend(convex_search* search, plii_convex_result* result) {
    bool has_points = false;
    for (int i = 0; i < CONVEX_MAX_DESCENTS && search->is_finite; ++i) {
        const double smallest_gap = CONVEX_SMALLEST_GAP * search->size;
        const double gap = CONVEX_GAP * search->depth > smallest_gap ? CONVEX_GAP * search->depth : smallest_gap;
        const plii_dvec3 unit = plii_dvec3_from(search->normal);
        const double way = (search->depth + gap) / plii_dvec3_length(unit);
        plii_gjk_query query = {.a = search->a,
                                .b = search->b,
                                .offset = plii_dvec3_scale(unit, way),
                                .max_distance = HUGE_VAL,
                                .max_support_calls = search->max_support_calls - search->support_calls};
        if (query.max_support_calls < CONVEX_DESCENT_CALLS && has_points) { break; }
        if (query.max_support_calls < 4) { break; }
        plii_convex_cache start = {.directions = {search->normal}, .count = 1};
        plii_gjk_result gjk;
        plii_gjk_run(&query, &start, &gjk);
        search->support_calls += gjk.support_calls;
        pli_vec3 normal;
        if (gjk.relation != PLII_CONVEX_SEPARATED || !convex_normalize(gjk.normal, &normal)) { break; }
        const double old_depth = search->depth;
        convex_try(search, normal);
        result->point_a = plii_dvec3_to_float(plii_dvec3_sub(gjk.point_a, query.offset));
        result->point_b = plii_dvec3_to_float(gjk.point_b);
        has_points = true;
        if (!(search->depth < old_depth * (1.0 - CONVEX_PROGRESS))) { break; }
    }
    if (!has_points) {
        result->point_a = search->point_a;
        result->point_b = pli_vec3_add(search->point_a, pli_vec3_scale(search->normal, (float)search->depth));
        return;
    }
    /* The last distance may belong to a direction that was not kept: what is left is the middle. */
    const pli_vec3 middle = pli_vec3_scale(pli_vec3_add(result->point_a, result->point_b), 0.5f);
    const pli_vec3 half = pli_vec3_scale(search->normal, 0.5f * (float)search->depth);
    result->point_a = pli_vec3_sub(middle, half);
    result->point_b = pli_vec3_add(middle, half);
}

/* True when the penetration function gave a direction. */
static bool convex_search_penetration(convex_search* search, plii_penetration_fn* penetration,
                                      const plii_gjk_result* gjk) {
    plii_penetration_query query = {.a = search->a,
                                    .b = search->b,
                                    .normal = search->normal,
                                    .depth = search->depth,
                                    .simplex = gjk->simplex,
                                    .simplex_count = gjk->simplex_count,
                                    .size = search->size,
                                    .max_support_calls = search->max_support_calls - search->support_calls -
                                                         2 * CONVEX_DESCENT_CALLS - 2};
    if (query.max_support_calls < 2) { return false; }
    plii_penetration_result found = {.normal = {0, 0, 0}};
    const bool is_found = penetration(&query, &found);
    search->support_calls += found.support_calls;
    pli_vec3 normal;
    if (!is_found || !plii_vec3_is_finite(found.normal) || !convex_normalize(plii_dvec3_from(found.normal), &normal)) {
        return false;
    }
    convex_try(search, normal);
    return !found.is_over_budget;
}

static void convex_overlap(const plii_gjk_result* gjk, const plii_convex_options* options, int max_support_calls,
                           plii_convex_cache* cache, const plii_convex* a, const plii_convex* b,
                           plii_convex_result* result) {
    convex_search search = {
        .a = a, .b = b, .support_calls = gjk->support_calls, .max_support_calls = max_support_calls, .is_finite = true};
    convex_find_start(&search, cache, gjk);
    if (search.is_finite && search.depth > 0.0) {
        if (options->penetration != NULL && !convex_search_penetration(&search, options->penetration, gjk)) {
            ++result->failure_count;
        }
        convex_descend(&search, result);
    } else {
        result->point_a = result->point_b = search.point_a;
        search.depth = 0.0;
    }
    result->support_calls = search.support_calls;
    if (!search.is_finite) {
        *result = (plii_convex_result){.relation = PLII_CONVEX_UNDEFINED, .support_calls = search.support_calls};
        return;
    }
    result->distance = search.depth > 0.0 ? -(float)search.depth : 0.0f;
    result->normal = search.normal;
    if (cache != NULL) {
        cache->normal = search.normal;
        cache->has_normal = true;
    }
}

void plii_convex_distance(const plii_convex* a, const plii_convex* b, const plii_convex_options* options,
                          plii_convex_cache* cache, plii_convex_result* result) {
    const int max_support_calls = options->max_support_calls > PLII_CONVEX_MIN_SUPPORT_CALLS
                                      ? options->max_support_calls
                                      : PLII_CONVEX_MIN_SUPPORT_CALLS;
    const plii_gjk_query query = {
        .a = a, .b = b, .max_distance = (double)options->max_distance, .max_support_calls = max_support_calls / 2};
    plii_gjk_result gjk;
    plii_gjk_run(&query, cache, &gjk);
    *result = (plii_convex_result){.relation = gjk.relation, .support_calls = gjk.support_calls};
    if (gjk.relation == PLII_CONVEX_UNDEFINED) { return; }
    if (gjk.relation == PLII_CONVEX_OVERLAPPING) {
        convex_overlap(&gjk, options, max_support_calls, cache, a, b, result);
        return;
    }
    result->distance = (float)gjk.distance;
    result->point_a = plii_dvec3_to_float(gjk.point_a);
    result->point_b = plii_dvec3_to_float(gjk.point_b);
    result->normal = plii_dvec3_to_float(gjk.normal);
    if (cache != NULL) {
        cache->normal = result->normal;
        cache->has_normal = true;
    }
}
