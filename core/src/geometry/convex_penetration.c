/* libccd's expanding polytope under a budget: its loops end once every further support point of a - b is the origin,
   which callbacks return then. Sets are moved near the origin and scaled to unit size: its tolerances are absolute. */

#include "geometry/convex_distance.h"

#include <ccd/ccd.h>

#define PENETRATION_TOLERANCE 1e-8     /* of the squared size */
#define PENETRATION_MAX_ITERATIONS 256 /* of libccd's bounded loops */

typedef struct penetration_search {
    plii_dvec3 origin; /* of libccd's frame */
    double scale;
    int support_calls;
    int max_support_calls;
    bool is_over_budget;
} penetration_search;

typedef struct penetration_set {
    const plii_convex* convex;
    penetration_search* search;
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
    pli_vec3 unit = pli_vec3_make(1, 0, 0);
    (void)plii_dvec3_unit(d, &unit);
    const pli_vec3 p = set->convex->support(set->convex->user, unit);
    if (!plii_vec3_is_finite(p)) {
        search->max_support_calls = search->support_calls; /* ends it like a spent budget */
        return;
    }
    const plii_dvec3 q = plii_dvec3_scale(plii_dvec3_sub(plii_dvec3_from(p), search->origin), search->scale);
    ccdVec3Set(point, q.x, q.y, q.z);
}

bool plii_penetration_epa(plii_penetration_query* query) {
    const plii_dvec3 sum = plii_dvec3_add(plii_dvec3_from(query->a->centre), plii_dvec3_from(query->b->centre));
    penetration_search search = {.scale = 1.0 / query->size, .max_support_calls = query->max_support_calls};
    if (isfinite(plii_dvec3_length(sum))) { search.origin = plii_dvec3_scale(sum, 0.5); }
    const penetration_set a = {query->a, &search}, b = {query->b, &search};
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = penetration_support;
    ccd.max_iterations = PENETRATION_MAX_ITERATIONS;
    ccd.epa_tolerance = PENETRATION_TOLERANCE;
    ccd_real_t depth = -1;
    ccd_vec3_t direction = {{0, 0, 0}}, position;
    const int status = ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &position);
    query->support_calls = search.support_calls;
    /* libccd's direction moves b away from a. */
    const plii_dvec3 d = plii_dvec3_make(direction.v[0], direction.v[1], direction.v[2]);
    const double length = plii_dvec3_length(d);
    if (status != 0 || !(depth >= 0) || search.is_over_budget || !(length > 0.5) || !isfinite(length)) { return false; }
    query->normal = plii_dvec3_to_float(plii_dvec3_scale(d, -1.0 / length));
    return true;
}
