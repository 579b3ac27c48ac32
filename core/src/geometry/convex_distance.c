/* Signed distance of convex cores. Apart: GJK. Overlapping: for every unit direction n the support points give the way
   d(n) that one core must go along n to come free; the depth is the least d(n). It is lowered from several starts by
   GJK itself: moved a little more than d(n) along n the cores are apart, and the normal n' of their distance has d(n')
   <= d(n), equal only where n is a local minimum. The last of these distances also yields the witness points. */

#include "geometry/convex_distance.h"

#define CONVEX_GAP 0.05               /* of the depth: how far beyond it the cores are moved */
#define CONVEX_SMALLEST_GAP 1e-4      /* of the size */
#define CONVEX_PROGRESS 1e-5          /* of the depth */
#define CONVEX_FOLLOWED_PROGRESS 1e-2 /* where an axis is followed from query to query */
#define CONVEX_TURN 1e-6f             /* radians: the same direction */
#define CONVEX_MAX_STEPS 8            /* of a descent */
#define CONVEX_MAX_DESCENTS 3         /* from the best directions of the start */
#define CONVEX_HOPELESS 2             /* times the best depth: starts deeper than this are left out */
#define CONVEX_FOLLOWED 1.5  /* times the depth towards the other centre: a known axis deeper than this is given up */
#define CONVEX_STEP_CALLS 24 /* a step is begun with this many calls left, except the first */
#define CONVEX_MAX_STARTS 13

/* A direction with its depth. */
typedef struct convex_axis {
    pli_vec3 normal;
    double depth;
} convex_axis;

typedef struct convex_search {
    double gap;      /* of the queries that follow */
    double progress; /* of the depth: a descent ends with a smaller one */
    const plii_convex *a, *b;
    convex_axis starts[CONVEX_MAX_STARTS];
    int start_count;
    convex_axis best;
    bool has_points;
    pli_vec3 point_a, point_b; /* nearest points of the last step towards `best` */
    double size;
    int support_calls;
    bool is_finite;
} convex_search;

/* d(normal). False when no calls are left or a support point is not finite. */
static bool convex_measure(convex_search* search, pli_vec3 normal, convex_axis* axis) {
    if (search->support_calls + 2 > PLII_CONVEX_MAX_SUPPORT_CALLS) { return false; }
    const pli_vec3 a = search->a->support(search->a->user, pli_vec3_neg(normal));
    const pli_vec3 b = search->b->support(search->b->user, normal);
    search->support_calls += 2;
    search->is_finite = search->is_finite && plii_vec3_is_finite(a) && plii_vec3_is_finite(b);
    if (!search->is_finite) { return false; }
    const plii_dvec3 n = plii_dvec3_from(normal), w = plii_dvec3_sub(plii_dvec3_from(b), plii_dvec3_from(a));
    const double reach = plii_dvec3_length(w);
    if (reach > search->size) { search->size = reach; }
    axis->normal = normal;
    axis->depth = plii_dvec3_dot(n, w) / plii_dvec3_length(n);
    if (search->start_count == 0 || axis->depth < search->best.depth) {
        search->best = *axis;
        search->has_points = false;
        search->point_a = a;
    }
    return true;
}

/* Keeps the starts in order of depth. */
static void convex_add_start(convex_search* search, pli_vec3 normal) {
    convex_axis axis;
    if (!convex_measure(search, normal, &axis) || search->start_count == CONVEX_MAX_STARTS) { return; }
    int i = search->start_count++;
    for (; i > 0 && search->starts[i - 1].depth > axis.depth; --i) {
        search->starts[i] = search->starts[i - 1];
    }
    search->starts[i] = axis;
}

/* Outward face normals of the simplex in a - b; of a flat one both sides. */
static void convex_add_simplex(convex_search* search, const plii_dvec3* s, int count) {
    for (int i = 0; i < count && count >= 3; ++i) {
        const plii_dvec3 p = s[(i + 1) % count], q = s[(i + 2) % count], r = s[(i + 3) % count];
        pli_vec3 normal;
        if (!plii_dvec3_unit(plii_dvec3_cross(plii_dvec3_sub(q, p), plii_dvec3_sub(r, p)), &normal)) { continue; }
        if (count == 3) {
            convex_add_start(search, normal);
            convex_add_start(search, pli_vec3_neg(normal));
            return;
        }
        /* The normal from b to a points into a - b. */
        const bool is_inward = plii_dvec3_dot(plii_dvec3_from(normal), plii_dvec3_sub(s[i], p)) > 0.0;
        convex_add_start(search, is_inward ? normal : pli_vec3_neg(normal));
    }
}

static void convex_find_starts(convex_search* search, const plii_convex_cache* cache, const plii_gjk_result* gjk) {
    static const pli_vec3 axes[6] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}};
    pli_vec3 between, nearest;
    if (plii_dvec3_unit(gjk->normal, &nearest)) { convex_add_start(search, nearest); }
    if (cache != NULL && cache->has_normal) { convex_add_start(search, cache->normal); }
    if (plii_dvec3_unit(plii_dvec3_sub(plii_dvec3_from(search->a->centre), plii_dvec3_from(search->b->centre)),
                        &between)) {
        convex_add_start(search, between);
    }
    convex_add_simplex(search, gjk->simplex, gjk->simplex_count);
    for (int i = 0; i < 6; ++i) {
        convex_add_start(search, axes[i]);
    }
}

/* Lowers the depth from a start to a local minimum. */
static void convex_descend(convex_search* search, convex_axis axis) {
    for (int i = 0; i < CONVEX_MAX_STEPS && search->is_finite; ++i) {
        const double smallest_gap = CONVEX_SMALLEST_GAP * search->size;
        const double gap = CONVEX_GAP * axis.depth > smallest_gap ? CONVEX_GAP * axis.depth : smallest_gap;
        const plii_dvec3 unit = plii_dvec3_from(axis.normal);
        const plii_gjk_query query = {.a = search->a,
                                      .b = search->b,
                                      .offset = plii_dvec3_scale(unit, (axis.depth + gap) / plii_dvec3_length(unit)),
                                      .max_distance = HUGE_VAL,
                                      .gap = search->gap,
                                      .max_support_calls = PLII_CONVEX_MAX_SUPPORT_CALLS - search->support_calls - 2};
        if (query.max_support_calls < (search->has_points ? CONVEX_STEP_CALLS : 4)) { break; }
        plii_convex_cache start = {.directions = {axis.normal}, .count = 1};
        plii_gjk_result gjk;
        plii_gjk_run(&query, &start, &gjk);
        search->support_calls += gjk.support_calls;
        pli_vec3 normal;
        if (gjk.relation != PLII_CONVEX_SEPARATED || !plii_dvec3_unit(gjk.normal, &normal)) { break; }
        convex_axis next = axis;
        const pli_vec3 turn = pli_vec3_sub(normal, axis.normal);
        const bool is_turned = pli_vec3_length_squared(turn) > CONVEX_TURN * CONVEX_TURN;
        if (is_turned && !convex_measure(search, normal, &next)) { break; }
        if (next.depth <= search->best.depth * (1.0 + CONVEX_PROGRESS)) {
            search->point_a = plii_dvec3_to_float(plii_dvec3_sub(gjk.point_a, query.offset));
            search->point_b = plii_dvec3_to_float(gjk.point_b);
            search->has_points = true;
        }
        if (!(next.depth < axis.depth * (1.0 - search->progress))) { break; }
        axis = next;
    }
}

/* True when the penetration function gave a direction. */
static bool convex_search_penetration(convex_search* search, plii_penetration_fn* penetration) {
    plii_penetration_query query = {.a = search->a, .b = search->b, .size = search->size};
    query.max_support_calls = PLII_CONVEX_MAX_SUPPORT_CALLS - search->support_calls - 2 * CONVEX_STEP_CALLS;
    if (query.max_support_calls < 2) { return false; }
    const bool is_found = penetration(&query);
    search->support_calls += query.support_calls;
    pli_vec3 normal;
    convex_axis axis;
    return is_found && plii_dvec3_unit(plii_dvec3_from(query.normal), &normal) && convex_measure(search, normal, &axis);
}

/* Along a known axis, or that between the centres when it is shorter. False when the known one is too deep by now. */
static bool convex_search_cached_axis(convex_search* search, const plii_convex_cache* cache) {
    convex_axis known, between;
    pli_vec3 normal;
    if (!convex_measure(search, cache->normal, &known)) { return false; }
    search->start_count = 1;
    const bool has_centres = plii_dvec3_unit(
        plii_dvec3_sub(plii_dvec3_from(search->a->centre), plii_dvec3_from(search->b->centre)), &normal);
    const bool is_good =
        !has_centres || (convex_measure(search, normal, &between) && known.depth <= CONVEX_FOLLOWED * between.depth);
    search->start_count = 0;
    if (!is_good || !(search->best.depth > 0.0)) { return false; }
    convex_descend(search, search->best);
    return true;
}

static void convex_search_axes(convex_search* search, const plii_gjk_result* gjk, const plii_convex_options* options,
                               const plii_convex_cache* cache) {
    convex_find_starts(search, cache, gjk);
    const bool had_normal = cache != NULL && cache->has_normal;
    if (!search->is_finite || !(search->best.depth > 0.0)) { return; }
    /* A direction that still is the best of the starts is followed, which also keeps contacts steady. */
    const bool is_known =
        had_normal && pli_vec3_length_squared(pli_vec3_sub(search->best.normal, cache->normal)) == 0.0f;
    int descent_count = is_known ? 1 : CONVEX_MAX_DESCENTS;
    if (options->penetration != NULL && !is_known && convex_search_penetration(search, options->penetration)) {
        descent_count = 1;
    }
    convex_descend(search, search->best);
    for (int i = 1; i < search->start_count && i < descent_count; ++i) {
        if (search->starts[i].depth > CONVEX_HOPELESS * search->best.depth) { break; }
        convex_descend(search, search->starts[i]);
    }
}

static void convex_overlap(convex_search* search, const plii_gjk_result* gjk, const plii_convex_options* options,
                           plii_convex_cache* cache, plii_convex_result* result) {
    const bool is_known = options->uses_cached_axis && cache != NULL && cache->has_normal;
    if (!is_known || !convex_search_cached_axis(search, cache)) { convex_search_axes(search, gjk, options, cache); }
    result->support_calls = search->support_calls;
    if (!search->is_finite) {
        result->relation = PLII_CONVEX_UNDEFINED;
        return;
    }
    const float depth = search->best.depth > 0.0 ? (float)search->best.depth : 0.0f;
    result->distance = -depth;
    result->normal = search->best.normal;
    if (search->has_points) {
        /* The last step may have ended beside the direction that was kept: what is left is the middle. */
        const pli_vec3 middle = pli_vec3_scale(pli_vec3_add(search->point_a, search->point_b), 0.5f);
        const pli_vec3 half = pli_vec3_scale(result->normal, 0.5f * depth);
        result->point_a = pli_vec3_sub(middle, half);
        result->point_b = pli_vec3_add(middle, half);
    } else {
        result->point_a = search->point_a;
        result->point_b = pli_vec3_add(search->point_a, pli_vec3_scale(result->normal, depth));
    }
}

void plii_convex_distance(const plii_convex* a, const plii_convex* b, const plii_convex_options* options,
                          plii_convex_cache* cache, plii_convex_result* result) {
    const plii_gjk_query query = {.a = a,
                                  .b = b,
                                  .max_distance = (double)options->max_distance,
                                  .gap = options->gap,
                                  .max_support_calls = PLII_CONVEX_MAX_SUPPORT_CALLS / 2};
    plii_gjk_result gjk;
    plii_gjk_run(&query, cache, &gjk);
    *result = (plii_convex_result){.relation = gjk.relation, .support_calls = gjk.support_calls};
    if (gjk.relation == PLII_CONVEX_UNDEFINED) { return; }
    if (gjk.relation == PLII_CONVEX_OVERLAPPING) {
        convex_search search = {.a = a,
                                .b = b,
                                .support_calls = gjk.support_calls,
                                .gap = options->gap,
                                .progress = options->uses_cached_axis ? CONVEX_FOLLOWED_PROGRESS : CONVEX_PROGRESS,
                                .is_finite = true};
        convex_overlap(&search, &gjk, options, cache, result);
    } else {
        result->distance = (float)gjk.distance;
        result->point_a = plii_dvec3_to_float(gjk.point_a);
        result->point_b = plii_dvec3_to_float(gjk.point_b);
        result->normal = plii_dvec3_to_float(gjk.normal);
    }
    if (cache != NULL && result->relation != PLII_CONVEX_UNDEFINED) {
        cache->normal = result->normal;
        cache->has_normal = true;
    }
}
