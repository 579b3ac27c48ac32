/* Checks of definitions. */

#include "math/definition.h"

#include <string.h>

static pli_status definition_check_field(pli_context* context, const void* values, const plii_field* field,
                                         const char* function) {
    const void* value = (const char*)values + field->offset;
    if (field->type == PLII_FIELD_FLOAT) {
        return plii_check_between(context, *(const float*)value, field->lowest, field->highest, field->name, function);
    }
    if (field->type == PLII_FIELD_VEC3) {
        return plii_check_vec3_between(context, *(const pli_vec3*)value, field->lowest, field->highest, field->name,
                                       function);
    }
    int number;
    memcpy(&number, value, sizeof number);
    if ((double)number >= (double)field->lowest && (double)number <= (double)field->highest) { return PLI_OK; }
    if (field->highest >= (float)INT_MAX) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %d, at least %g is needed", field->name,
                         number, (double)field->lowest);
    }
    return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %d, the limits are %g and %g", field->name,
                     number, (double)field->lowest, (double)field->highest);
}

pli_status plii_check_fields(pli_context* context, const void* values, int count, const plii_field* fields,
                             const char* function) {
    for (int i = 0; i < count; ++i) {
        PLII_TRY(definition_check_field(context, values, &fields[i], function));
    }
    return PLI_OK;
}

pli_status plii_check_made(pli_context* context, const void* def, size_t cookie_offset, const char* type,
                           const char* function) {
    if (def == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "the definition is null"); }
    if (*(const uint32_t*)((const char*)def + cookie_offset) == PLII_DEF_COOKIE) { return PLI_OK; }
    return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "start from %s_default()", type);
}
