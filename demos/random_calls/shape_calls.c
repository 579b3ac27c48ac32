/* Shapes: all kinds, and queries. */

#include "calls.h"

#include <pliant/bullet_reference.h>

static pli_status make_hull_shape(calls* c, calls_context* home, pli_shape** shape) {
    enum { POINTS = 12 };
    pli_vec3 points[POINTS];
    const int count = bytes_small(&c->bytes, 4, POINTS);
    for (int i = 0; i < count; ++i) {
        points[i] = bytes_vec3(&c->bytes, -0.8f, 0.8f);
    }
    const float radius = bytes_float(&c->bytes, 0.0f, 0.2f);
    return CALL(c, home, pli_shape_create_convex_hull(home->context, count, points, radius, shape));
}

/* An octahedron, of which some corners are elsewhere. */
static pli_status make_mesh(calls* c, calls_context* home, pli_shape** shape) {
    static const int octahedron[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    pli_vec3 points[6];
    int corners[24];
    for (int i = 0; i < 6; ++i) {
        const float length = bytes_float(&c->bytes, 0.3f, 0.9f) * (i % 2 == 0 ? 1.0f : -1.0f);
        points[i] = pli_vec3_make(i / 2 == 0 ? length : 0.0f, i / 2 == 1 ? length : 0.0f, i / 2 == 2 ? length : 0.0f);
    }
    for (int i = 0; i < 24; ++i) {
        corners[i] = octahedron[i];
    }
    if (bytes_seldom(&c->bytes, 64)) { points[bytes_below(&c->bytes, 6)] = bytes_vec3(&c->bytes, -1.0f, 1.0f); }
    if (bytes_seldom(&c->bytes, 64)) { corners[bytes_below(&c->bytes, 24)] = bytes_index(&c->bytes, 6); }
    const int count = bytes_seldom(&c->bytes, 64) ? bytes_small(&c->bytes, 1, 8) : 8;
    if (bytes_flag(&c->bytes)) {
        const float thickness = bytes_float(&c->bytes, 0.05f, 0.5f);
        return CALL(c, home,
                    pli_shape_create_triangle_mesh(home->context, 6, points, count, corners, thickness, shape));
    }
    pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
    def.cell_size = bytes_float(&c->bytes, 0.15f, 0.5f);
    def.padding = bytes_float(&c->bytes, 0.0f, 0.5f);
    return CALL(c, home, pli_shape_create_sampled_mesh(home->context, 6, points, count, corners, &def, shape));
}

static pli_status make_custom(calls* c, calls_context* home, pli_shape** shape) {
    const pli_shape_def def = calls_custom_shape(c);
    const pli_status status = CALL(c, home, pli_shape_create(home->context, &def, shape));
    if (status != PLI_OK && def.destroy != NULL) { def.destroy(def.user); }
    return status;
}

void calls_make_shape(calls* c) {
    calls_shape* place = calls_shape_place(c);
    calls_context* home = calls_any_context(c);
    const calls_shape* source = &c->shapes[bytes_below(&c->bytes, CALLS_SHAPES)];
    const pli_vec3 vector = bytes_vec3(&c->bytes, 0.1f, 1.0f);
    const float number = bytes_float(&c->bytes, 0.1f, 0.8f);
    pli_shape* shape = NULL;
    pli_status status = PLI_ERROR_NULL_ARGUMENT;
    switch (bytes_below(&c->bytes, 10)) {
    case 0:
        status = CALL(c, home, pli_shape_create_plane(home->context, vector, -number, &shape));
        break;
    case 1:
        status = CALL(c, home, pli_shape_create_sphere(home->context, number, &shape));
        break;
    case 2:
        status = CALL(c, home, pli_shape_create_box(home->context, vector, &shape));
        break;
    case 3:
        status = CALL(c, home, pli_shape_create_capsule(home->context, vector, number, &shape));
        break;
    case 4:
        status = CALL(c, home, pli_shape_create_cylinder(home->context, vector, number, &shape));
        break;
    case 5:
        status = make_hull_shape(c, home, &shape);
        break;
    case 6:
    case 7:
        status = make_mesh(c, home, &shape);
        break;
    case 8:
        status = make_custom(c, home, &shape);
        break;
    default:
        if (source->shape == NULL) { return; }
        home = source->home;
        status = CALL(c, home, pli_shape_create_lattice(home->context, source->shape, number, &shape));
        break;
    }
    if (status == PLI_OK) { *place = (calls_shape){shape, home}; }
}

void calls_use_shape(calls* c) {
    const calls_shape* chosen = calls_any_shape(c);
    if (chosen == NULL) { return; }
    for (int i = 0; i < 4; ++i) {
        pli_vec3 normal;
        c->active = chosen->home;
        (void)pli_shape_distance(chosen->shape, bytes_vec3(&c->bytes, -2.0f, 2.0f), i % 2 == 0 ? &normal : NULL);
    }
    (void)pli_shape_bounds(chosen->shape);
    if (bytes_flag(&c->bytes)) {
        VOID_CALL(c, chosen->home, pli_shape_retain(chosen->shape));
        VOID_CALL(c, chosen->home, pli_shape_release(chosen->shape));
    }
}
