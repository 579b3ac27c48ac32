/* Life and queries of shapes. What a shape is lies in its callbacks; each built-in one is a file of its own. */

#include "base/handle.h"
#include "math/definition.h"
#include "shape/shape_impl.h"

PLII_DEFINE_DEFAULT(pli_shape_def, 0)

pli_status plii_shape_create_owning(pli_context* context, plii_shape_kind kind, const pli_shape_def* def,
                                    const void* data, size_t size, const char* function, pli_shape** shape) {
    void* copy = plii_duplicate(context, data, size);
    const bool has_data = copy != NULL || size == 0;
    pli_shape* made = has_data ? plii_handle_create(context, PLII_HANDLE_SHAPE, sizeof *made) : NULL;
    if (made == NULL) {
        plii_release(context, copy, size);
        return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for a shape");
    }
    made->kind = kind;
    made->reference_count = 1;
    made->context = context;
    made->def = *def;
    made->data_size = size;
    if (size > 0) { made->def.user = copy; }
    *shape = made;
    return PLI_OK;
}

pli_status plii_shape_check_triangles(pli_context* context, int point_count, const pli_vec3* points, int triangle_count,
                                      const int* triangles, const char* function) {
    PLII_FAIL_IF(points == NULL || triangles == NULL, context, PLI_ERROR_NULL_ARGUMENT, function,
                 "points or triangles is null");
    PLII_FAIL_IF(point_count <= 0 || triangle_count <= 0 || triangle_count > INT32_MAX / 6, context,
                 PLI_ERROR_INVALID_MESH, function, "there are %d points and %d triangles", point_count, triangle_count);
    PLII_TRY(plii_check_finite_points(context, point_count, points, "point", function));
    for (int i = 0; i < 3 * triangle_count; ++i) {
        PLII_FAIL_IF(triangles[i] < 0 || triangles[i] >= point_count, context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                     "triangle %d names point %d, there are %d points", i / 3, triangles[i], point_count);
    }
    return PLI_OK;
}

pli_status pli_shape_create(pli_context* context, const pli_shape_def* def, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(PLII_CHECK_MADE(context, pli_shape_def, def, __func__));
    if (def->distances == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def->distances is null"); }
    if (def->bounds == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def->bounds is null"); }
    PLII_TRY(plii_check_between(context, def->radius, 0.0f, PLI_MAX_COORDINATE, "def->radius", __func__));
    return plii_shape_create_owning(context, PLII_SHAPE_OTHER, def, NULL, 0, __func__, shape);
}

/* The `destroy` of a shape may release other shapes; apart from that, as plii_check_change. */
static pli_status shape_check_count(const pli_shape* shape, const char* function) {
    PLII_TRY(plii_check_handle(shape, PLII_HANDLE_SHAPE, NULL, NULL, function));
    const plii_walk* walk = plii_walk_find(shape->context, PLII_WALK_ANY);
    const bool is_free = (walk == NULL || walk->kind == PLII_WALK_RELEASE) && plii_shape_queries == 0;
    return is_free ? PLI_OK : plii_refuse_change(shape->context, function);
}

void plii_shape_retain(pli_shape* shape) {
    (void)__atomic_add_fetch(&shape->reference_count, 1, __ATOMIC_RELAXED);
}
void pli_shape_retain(pli_shape* shape) {
    if (shape_check_count(shape, __func__) == PLI_OK) { plii_shape_retain(shape); }
}

static void shape_destroy(pli_shape* shape) {
    pli_context* context = shape->context;
    plii_handle_retire(shape);
    if (shape->def.destroy != NULL) {
        plii_walk walk;
        plii_walk_begin(&walk, context, PLII_WALK_RELEASE);
        shape->def.destroy(shape->def.user);
        plii_walk_end(&walk);
    }
    if (shape->data_size > 0) { plii_release(context, shape->def.user, shape->data_size); }
    plii_handle_release(context, shape, PLII_HANDLE_SHAPE, sizeof *shape);
}

void plii_shape_release(pli_shape* shape) {
    if (__atomic_sub_fetch(&shape->reference_count, 1, __ATOMIC_ACQ_REL) == 0) { shape_destroy(shape); }
}
void pli_shape_release(pli_shape* shape) {
    if (shape != NULL && shape_check_count(shape, __func__) == PLI_OK) { plii_shape_release(shape); }
}

float plii_shape_distance(const pli_shape* shape, pli_vec3 point, pli_vec3* normal) {
    float distance = INFINITY;
    pli_vec3 direction = pli_vec3_make(1, 0, 0);
    if (plii_vec3_is_finite(point)) {
        shape->def.distances(shape->def.user, 1, &point, INFINITY, &distance, &direction);
    }
    if (normal != NULL) { *normal = direction; }
    return distance;
}

float pli_shape_distance(const pli_shape* shape, pli_vec3 point, pli_vec3* normal) {
    if (plii_check_handle(shape, PLII_HANDLE_SHAPE, NULL, NULL, __func__) != PLI_OK) {
        if (normal != NULL) { *normal = pli_vec3_make(1, 0, 0); }
        return INFINITY;
    }
    ++plii_shape_queries;
    const float distance = plii_shape_distance(shape, point, normal);
    --plii_shape_queries;
    return distance;
}

pli_bounds plii_shape_stored_bounds(const void* user) {
    return *(const pli_bounds*)user;
}
pli_bounds pli_shape_bounds(const pli_shape* shape) {
    if (plii_check_handle(shape, PLII_HANDLE_SHAPE, NULL, NULL, __func__) != PLI_OK) { return (pli_bounds){0}; }
    ++plii_shape_queries;
    const pli_bounds bounds = shape->def.bounds(shape->def.user);
    --plii_shape_queries;
    return bounds;
}
