/* libccd's portal refinement and expanding polytope under a budget. The portal search has no bound of its own and can
   run for ever where the given centre does not lie inside the set; both loops end as soon as every further support
   point of a - b is the origin, which is what the callbacks return once the budget is spent. Sets are moved near the
   origin and scaled to about unit size, because libccd's tolerances are absolute. */

#include "geometry/convex_penetration.h"

#include <ccd/ccd.h>

#define PENETRATION_TOLERANCE 1e-5     /* of the size: how far portal and set may differ */
#define PENETRATION_EPA_TOLERANCE 1e-8 /* of the squared size */
#define PENETRATION_MAX_ITERATIONS 256 /* of libccd's bounded loops */
#define PENETRATION_MAX_AIMS 6
#define PENETRATION_PROGRESS 1e-4     /* of the depth */
#define PENETRATION_SMALLEST_AIM 0.01 /* of the depth */

typedef struct penetration_search {
    const plii_penetration_query* query;
    plii_dvec3 origin; /* of libccd's frame */
    double scale;
    int support_calls;
    int max_support_calls;
    bool is_over_budget;
} penetration_search;

typedef struct penetration_set {
    const plii_convex* convex;
    penetration_search* search;
    ccd_vec3_t centre;
} penetration_set;

static void penetration_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
    const penetration_set* set = (const penetration_set*)object;
    penetration_search* search = set->search;
    ccdVec3Set(point, 0, 0, 0);
    if (search->support_calls >= search->max_support_calls) {
        search->is_over_budget = true;
        return;
    }
    ++search->support_calls;
    const plii_dvec3 d = plii_dvec3_make(direction->v[0], direction->v[1], direction->v[2]);
    const double length = plii_dvec3_length(d);
    const bool has_direction = length > 0.0 && isfinite(length);
    const pli_vec3 unit =
        has_direction ? plii_dvec3_to_float(plii_dvec3_scale(d, 1.0 / length)) : pli_vec3_make(1, 0, 0);
    const pli_vec3 p = set->convex->support(set->convex->user, unit);
    if (!plii_vec3_is_finite(p)) {
        search->max_support_calls = search->support_calls; /* ends it like a spent budget */
        return;
    }
    const plii_dvec3 q = plii_dvec3_scale(plii_dvec3_sub(plii_dvec3_from(p), search->origin), search->scale);
    ccdVec3Set(point, q.x, q.y, q.z);
}

static void penetration_centre(const void* object, ccd_vec3_t* centre) {
    *centre = ((const penetration_set*)object)->centre;
}

static penetration_search penetration_begin(const plii_penetration_query* query) {
    const plii_dvec3 sum = plii_dvec3_add(plii_dvec3_from(query->a->centre), plii_dvec3_from(query->b->centre));
    plii_dvec3 origin = plii_dvec3_scale(sum, 0.5);
    if (!isfinite(plii_dvec3_length(origin))) { origin = plii_dvec3_make(0, 0, 0); }
    const penetration_search search = {
        .query = query, .origin = origin, .scale = 1.0 / query->size, .max_support_calls = query->max_support_calls};
    return search;
}

static ccd_t penetration_settings(void) {
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = penetration_support;
    ccd.support2 = penetration_support;
    ccd.center1 = penetration_centre;
    ccd.center2 = penetration_centre;
    ccd.max_iterations = PENETRATION_MAX_ITERATIONS;
    ccd.mpr_tolerance = PENETRATION_TOLERANCE;
    ccd.epa_tolerance = PENETRATION_EPA_TOLERANCE;
    return ccd;
}

/* libccd's direction moves b away from a. False unless it is finite and not zero. */
static bool penetration_normal(const ccd_vec3_t* direction, pli_vec3* normal) {
    const plii_dvec3 d = plii_dvec3_make(direction->v[0], direction->v[1], direction->v[2]);
    const double length = plii_dvec3_length(d);
    if (!(length > 0.5) || !isfinite(length)) { return false; }
    *normal = plii_dvec3_to_float(plii_dvec3_scale(d, -1.0 / length));
    return true;
}

/* How far from the origin along `direction` the simplex in a - b reaches; 0 for a flat one. */
static double penetration_reach(const plii_penetration_query* query, plii_dvec3 direction) {
    if (query->simplex_count != 4) { return 0.0; }
    const plii_dvec3* s = query->simplex;
    double reach = HUGE_VAL;
    for (int i = 0; i < 4; ++i) {
        const plii_dvec3 p = s[(i + 1) % 4];
        plii_dvec3 n = plii_dvec3_cross(plii_dvec3_sub(s[(i + 2) % 4], p), plii_dvec3_sub(s[(i + 3) % 4], p));
        if (plii_dvec3_dot(n, plii_dvec3_sub(s[i], p)) > 0.0) { n = plii_dvec3_scale(n, -1.0); }
        const double along = plii_dvec3_dot(n, direction), height = plii_dvec3_dot(n, p);
        if (along > 0.0 && height < reach * along) { reach = height / along; }
    }
    return reach > 0.0 && isfinite(reach) ? reach : 0.0;
}

/* d(normal), as in convex_distance.c. False without calls left or points. */
static bool penetration_depth(penetration_search* search, pli_vec3 normal, double* depth) {
    const plii_penetration_query* query = search->query;
    if (search->support_calls + 2 > search->max_support_calls) { return false; }
    const pli_vec3 a = query->a->support(query->a->user, pli_vec3_neg(normal));
    const pli_vec3 b = query->b->support(query->b->user, normal);
    search->support_calls += 2;
    const plii_dvec3 w = plii_dvec3_sub(plii_dvec3_from(b), plii_dvec3_from(a));
    *depth = plii_dvec3_dot(plii_dvec3_from(normal), w);
    return isfinite(*depth);
}

bool plii_penetration_mpr(const plii_penetration_query* query, plii_penetration_result* result) {
    penetration_search search = penetration_begin(query);
    penetration_set a = {.convex = query->a, .search = &search}, b = {.convex = query->b, .search = &search};
    const ccd_t ccd = penetration_settings();
    bool is_found = false;
    double best = query->depth;
    pli_vec3 aim = query->normal;
    result->normal = aim;
    for (int i = 0; i < PENETRATION_MAX_AIMS; ++i) {
        /* The portal lies where the ray from the centre through the origin leaves a - b. */
        const plii_dvec3 unit = plii_dvec3_from(aim);
        const double reach = 0.5 * penetration_reach(query, unit), least = PENETRATION_SMALLEST_AIM * best;
        const plii_dvec3 centre = plii_dvec3_scale(unit, (reach > least ? reach : least) * search.scale);
        ccdVec3Set(&a.centre, centre.x, centre.y, centre.z);
        ccd_real_t depth = -1;
        ccd_vec3_t direction = {{0, 0, 0}}, position;
        pli_vec3 normal;
        double measured;
        if (ccdMPRPenetration(&a, &b, &ccd, &depth, &direction, &position) != 0 || !(depth >= 0) ||
            !penetration_normal(&direction, &normal) || !penetration_depth(&search, normal, &measured)) {
            break;
        }
        is_found = true;
        if (!(measured < best * (1.0 - PENETRATION_PROGRESS))) { break; }
        best = measured;
        result->normal = aim = normal;
    }
    result->support_calls = search.support_calls;
    result->is_over_budget = search.is_over_budget;
    return is_found;
}

bool plii_penetration_epa(const plii_penetration_query* query, plii_penetration_result* result) {
    penetration_search search = penetration_begin(query);
    penetration_set a = {.convex = query->a, .search = &search}, b = {.convex = query->b, .search = &search};
    const ccd_t ccd = penetration_settings();
    ccd_real_t depth = -1;
    ccd_vec3_t direction = {{0, 0, 0}}, position;
    const int status = ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &position);
    result->support_calls = search.support_calls;
    result->is_over_budget = search.is_over_budget;
    result->is_accurate = status == 0 && depth >= 0 && penetration_normal(&direction, &result->normal);
    return result->is_accurate;
}
