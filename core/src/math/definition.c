/* Checks of numbers and of definitions, and the errors of those beyond their limits. */

#include "math/definition.h"

#include <stdio.h>

/* `text` is the value, `least` the smallest of its numbers. */
static pli_status range_fail(pli_context* context, bool is_finite, float least, float low, float high, const char* name,
                             const char* text, const char* function) {
    if (!is_finite) { return plii_fail(context, PLI_ERROR_NOT_FINITE, function, "%s is %s, not finite", name, text); }
    PLII_FAIL_IF(low == PLII_ABOVE_0 && least < low, context, PLI_ERROR_INVALID_VALUE, function,
                 "%s is %s, not above 0", name, text);
    PLII_FAIL_IF(low == -high, context, PLI_ERROR_INVALID_VALUE, function, "%s is %s, the limit is %g", name, text,
                 (double)high);
    return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %s, the limits are %g and %g", name, text,
                     (double)low, (double)high);
}

pli_status plii_check_between(pli_context* context, float value, float low, float high, const char* name,
                              const char* function) {
    if (value >= low && value <= high) { return PLI_OK; }
    char text[32];
    snprintf(text, sizeof text, "%g", (double)value);
    return range_fail(context, plii_is_finite(value), value, low, high, name, text, function);
}

pli_status plii_check_vec3_between(pli_context* context, pli_vec3 value, float low, float high, const char* name,
                                   const char* function) {
    const float least = plii_min(plii_min(value.x, value.y), value.z);
    if (least >= low && plii_vec3_is_within(value, high)) { return PLI_OK; }
    char text[96];
    snprintf(text, sizeof text, "(%g, %g, %g)", (double)value.x, (double)value.y, (double)value.z);
    return range_fail(context, plii_vec3_is_finite(value), least, low, high, name, text, function);
}

pli_status plii_check_finite_points(pli_context* context, int count, const pli_vec3* points, const char* what,
                                    const char* function) {
    for (int i = 0; points != NULL && i < count; ++i) {
        const pli_vec3 p = points[i];
        if (plii_is_point(p)) { continue; }
        const bool is_finite = plii_vec3_is_finite(p);
        return plii_fail(context, is_finite ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE, function,
                         "%s %d is (%g, %g, %g)%s", what, i, (double)p.x, (double)p.y, (double)p.z,
                         is_finite ? ", coordinates go to 1e+06" : ", not finite");
    }
    return PLI_OK;
}

pli_status plii_check_index(pli_context* context, int index, int count, const char* what, const char* owner,
                            const char* function) {
    if (index >= 0 && index < count) { return PLI_OK; }
    return plii_fail(context, PLI_ERROR_INDEX_OUT_OF_RANGE, function, "%s %d is out of range, the %s has %d %ss", what,
                     index, owner, count, what);
}

pli_status plii_check_int(pli_context* context, int value, double low, double high, const char* name,
                          const char* function) {
    if ((double)value >= low && (double)value <= high) { return PLI_OK; }
    PLII_FAIL_IF(high >= (double)INT_MAX, context, PLI_ERROR_INVALID_VALUE, function, "%s is %d, at least %g is needed",
                 name, value, low);
    return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %d, the limits are %g and %g", name, value, low,
                     high);
}

pli_status plii_check_fields(pli_context* context, const void* values, int count, const plii_field* fields,
                             const char* function) {
    for (PLII_EACH(const plii_field, field, fields, count)) {
        const void* value = (const char*)values + field->offset;
        const float low = field->lowest, high = field->highest;
        if (field->type == PLII_FIELD_FLOAT) {
            PLII_TRY(plii_check_between(context, *(const float*)value, low, high, field->name, function));
        } else if (field->type == PLII_FIELD_VEC3) {
            PLII_TRY(plii_check_vec3_between(context, *(const pli_vec3*)value, low, high, field->name, function));
        } else {
            int number;
            memcpy(&number, value, sizeof number);
            PLII_TRY(plii_check_int(context, number, (double)low, (double)high, field->name, function));
        }
    }
    return PLI_OK;
}

pli_status plii_check_made(pli_context* context, const void* def, size_t cookie_offset, const char* type,
                           const char* function) {
    if (def == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "the definition is null"); }
    if (*(const uint32_t*)((const char*)def + cookie_offset) == PLII_DEF_COOKIE) { return PLI_OK; }
    return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "start from %s_default()", type);
}
