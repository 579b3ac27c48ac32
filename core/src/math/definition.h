#pragma once

/* Checks of what the user fills in: a definition has to come from its default function, and each of its fields has
   limits in a table. Errors name the field, its value and the limits. */

#include "math/range.h"

typedef enum plii_field_type { PLII_FIELD_INT, PLII_FIELD_FLOAT, PLII_FIELD_VEC3 } plii_field_type;

/* A number of a struct; lowest and highest are allowed, for each component of a vector. */
typedef struct plii_field {
    const char* name;
    size_t offset;
    plii_field_type type;
    float lowest, highest;
} plii_field;

/* Enumerations are ints or unsigned. */
// clang-format off
#define PLII_FIELD(type, field, lowest, highest)                                                                       \
    {#field, offsetof(type, field),                                                                                    \
     _Generic(((type*)0)->field, float: PLII_FIELD_FLOAT, pli_vec3: PLII_FIELD_VEC3,                                   \
              int: PLII_FIELD_INT, unsigned: PLII_FIELD_INT),                                                          \
     (float)(lowest), (float)(highest)}
// clang-format on

/* Of a struct, `offset` bytes into something. */
typedef struct plii_limits {
    const plii_field* fields; /* NULL: none */
    int count;
    size_t offset;
} plii_limits;
#define PLII_LIMITS(type, member, limits)                                                                              \
    { limits, (int)(sizeof(limits) / sizeof *(limits)), offsetof(type, member) }
/* The same of limits that nobody else needs: the fields in place of a table. */
#define PLII_LIMITS_AT(offset, ...)                                                                                    \
    { (const plii_field[]){__VA_ARGS__}, (int)(sizeof((const plii_field[]){__VA_ARGS__}) / sizeof(plii_field)), offset }

pli_status plii_check_fields(pli_context* context, const void* values, int count, const plii_field* fields,
                             const char* function);
#define PLII_CHECK_FIELDS(context, values, fields, function)                                                           \
    plii_check_fields(context, values, (int)(sizeof(fields) / sizeof *(fields)), fields, function)

/* Of what has limits, without their offset. */
static inline pli_status plii_check_limits(pli_context* context, const void* values, const plii_limits* limits,
                                           const char* function) {
    return plii_check_fields(context, values, limits->count, limits->fields, function);
}

/* The definition is not null and has the cookie that its default function gives it. */
pli_status plii_check_made(pli_context* context, const void* def, size_t cookie_offset, const char* type,
                           const char* function);
#define PLII_CHECK_MADE(context, type, def, function)                                                                  \
    plii_check_made(context, def, offsetof(type, cookie), #type, function)

/* Both; returns early as PLII_TRY. */
#define PLII_TRY_DEF(context, type, def, fields, function)                                                             \
    PLII_TRY(PLII_CHECK_MADE(context, type, def, function));                                                           \
    PLII_TRY(PLII_CHECK_FIELDS(context, def, fields, function))
