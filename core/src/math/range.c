/* Errors of numbers beyond their limits. */

#include "math/range.h"

pli_status plii_check_between(pli_context* context, float value, float low, float high, const char* name,
                              const char* function) {
    if (value >= low && value <= high) { return PLI_OK; }
    if (!plii_is_finite(value)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "%s is %g, not finite", name, (double)value);
    }
    if (low == PLII_ABOVE_0 && value < low) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %g, not above 0", name, (double)value);
    }
    if (low == -high) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %g, the limit is %g", name, (double)value,
                         (double)high);
    }
    return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %g, the limits are %g and %g", name,
                     (double)value, (double)low, (double)high);
}

pli_status plii_check_vec3_between(pli_context* context, pli_vec3 value, float low, float high, const char* name,
                                   const char* function) {
    if (plii_min(plii_min(value.x, value.y), value.z) >= low && plii_vec3_is_within(value, high)) { return PLI_OK; }
    const double x = (double)value.x, y = (double)value.y, z = (double)value.z;
    if (!plii_vec3_is_finite(value)) {
        return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "%s is (%g, %g, %g), not finite", name, x, y, z);
    }
    if (low == PLII_ABOVE_0 && plii_min(plii_min(value.x, value.y), value.z) < low) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is (%g, %g, %g), not above 0", name, x, y, z);
    }
    if (low == -high) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is (%g, %g, %g), the limit is %g", name, x, y,
                         z, (double)high);
    }
    return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is (%g, %g, %g), the limits are %g and %g", name,
                     x, y, z, (double)low, (double)high);
}

pli_status plii_check_finite_points(pli_context* context, int count, const pli_vec3* points, const char* what,
                                    const char* function) {
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        if (plii_is_point(p)) { continue; }
        const bool is_finite = plii_vec3_is_finite(p);
        return plii_fail(context, is_finite ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE, function,
                         "%s %d is (%g, %g, %g)%s", what, i, (double)p.x, (double)p.y, (double)p.z,
                         is_finite ? ", coordinates go to 1e+06" : ", not finite");
    }
    return PLI_OK;
}

pli_status plii_check_mass(pli_context* context, float mass, const char* name, const char* function) {
    if (mass == 0.0f) { return PLI_OK; }
    return plii_check_between(context, mass, PLI_MIN_MASS, PLI_MAX_MASS, name, function);
}
