/* Life and queries of collision shapes. What a shape is lies in its callbacks; each built-in shape is a file of its
   own. */

#include "shape_impl.h"

pli_shape_def pli_shape_def_default(void) {
    pli_shape_def def = {0};
    def.cookie = PLII_DEF_COOKIE;
    return def;
}

pli_status plii_shape_check_create(pli_context* context, pli_shape** shape, const char* function) {
    if (shape != NULL) { *shape = NULL; }
    if (context == NULL) { return plii_fail(NULL, PLI_ERROR_NULL_ARGUMENT, function, "context is null"); }
    if (shape == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "shape is null"); }
    return PLI_OK;
}

pli_status plii_check_shape(pli_context* context, const pli_shape* shape, const char* function) {
    if (shape == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "a shape is null"); }
    if (shape->magic != PLII_SHAPE_MAGIC) {
        return plii_fail(context, PLI_ERROR_STALE_ID, function, "the shape does not exist any more");
    }
    return PLI_OK;
}

static pli_status shape_allocate(pli_context* context, const pli_shape_def* def, const char* function,
                                 pli_shape** shape) {
    pli_shape* made = plii_allocate(context, sizeof *made);
    if (made == NULL) { return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for a shape"); }
    made->magic = PLII_SHAPE_MAGIC;
    made->reference_count = 1;
    made->context = context;
    made->def = *def;
    *shape = made;
    return PLI_OK;
}

pli_status plii_shape_create_owning(pli_context* context, const pli_shape_def* def, const void* data, size_t size,
                                    const char* function, pli_shape** shape) {
    void* copy = plii_duplicate(context, data, size);
    if (copy == NULL) { return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for a shape"); }
    const pli_status status = shape_allocate(context, def, function, shape);
    if (status != PLI_OK) {
        plii_release(context, copy, size);
        return status;
    }
    (*shape)->def.user = copy;
    (*shape)->data_size = size;
    return PLI_OK;
}

pli_status pli_shape_create(pli_context* context, const pli_shape_def* def, pli_shape** shape) {
    PLII_TRY(plii_shape_check_create(context, shape, __func__));
    if (def == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return PLII_FAIL(context, PLI_ERROR_INVALID_DEF, "def was not made by pli_shape_def_default");
    }
    if (def->distances == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def->distances is null"); }
    if (def->bounds == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def->bounds is null"); }
    if (!(def->radius >= 0.0f) || !plii_is_finite(def->radius)) {
        return PLII_FAIL(context, PLI_ERROR_INVALID_VALUE, "def->radius is %g, negative or not finite",
                         (double)def->radius);
    }
    return shape_allocate(context, def, __func__, shape);
}

void pli_shape_retain(pli_shape* shape) {
    if (shape == NULL || shape->magic != PLII_SHAPE_MAGIC) { return; }
    ++shape->reference_count;
}

void pli_shape_release(pli_shape* shape) {
    if (shape == NULL || shape->magic != PLII_SHAPE_MAGIC) { return; }
    if (--shape->reference_count > 0) { return; }
    if (shape->def.destroy != NULL) { shape->def.destroy(shape->def.user); }
    if (shape->data_size > 0) { plii_release(shape->context, shape->def.user, shape->data_size); }
    shape->magic = 0;
    plii_release(shape->context, shape, sizeof *shape);
}

float pli_shape_distance(const pli_shape* shape, pli_vec3 point, pli_vec3* normal) {
    float distance = INFINITY;
    pli_vec3 direction = pli_vec3_make(1, 0, 0);
    if (shape != NULL && shape->magic == PLII_SHAPE_MAGIC && plii_vec3_is_finite(point)) {
        shape->def.distances(shape->def.user, 1, &point, INFINITY, &distance, &direction);
    }
    if (normal != NULL) { *normal = direction; }
    return distance;
}

pli_bounds pli_shape_bounds(const pli_shape* shape) {
    if (shape == NULL || shape->magic != PLII_SHAPE_MAGIC) {
        pli_bounds none = {{0, 0, 0}, {0, 0, 0}};
        return none;
    }
    return shape->def.bounds(shape->def.user);
}

pli_vec3 plii_shape_perpendicular(pli_vec3 v) {
    /* Crossing with the axis of the smallest component keeps clear of the parallel case. */
    const float x = fabsf(v.x), y = fabsf(v.y), z = fabsf(v.z);
    const pli_vec3 axis = x <= y && x <= z ? pli_vec3_make(1, 0, 0)
                          : y <= z         ? pli_vec3_make(0, 1, 0)
                                           : pli_vec3_make(0, 0, 1);
    const pli_vec3 side = pli_vec3_cross(v, axis);
    return plii_vec3_divide(side, pli_vec3_length(side));
}
