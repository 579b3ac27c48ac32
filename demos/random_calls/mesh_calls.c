/* Meshes: all generators and edits. */

#include "calls.h"

#include <pliant/bullet_reference.h>

#include <stdlib.h>

static void some_points(calls* c, pli_vec3* points, int count) {
    for (int i = 0; i < count; ++i) {
        points[i] = bytes_vec3(&c->bytes, -1.0f, 1.0f);
    }
}

static pli_patch_def some_patch(calls* c) {
    pli_patch_def def = pli_patch_def_default();
    const float height = bytes_float(&c->bytes, -1.0f, 1.0f), size = bytes_float(&c->bytes, 0.5f, 2.0f);
    def.corner_00 = pli_vec3_make(-size, height, -size);
    def.corner_10 = pli_vec3_make(size, height, -size);
    def.corner_01 = pli_vec3_make(-size, height, size);
    def.corner_11 = pli_vec3_make(size, height, size);
    if (bytes_seldom(&c->bytes, 32)) { def.corner_11 = bytes_vec3(&c->bytes, -2.0f, 2.0f); }
    def.columns = bytes_count(&c->bytes, 2, 7);
    def.rows = bytes_count(&c->bytes, 2, 7);
    def.pins = bytes_seldom(&c->bytes, 96) ? bytes_next(&c->bytes) : 0;
    def.diagonals = bytes_flag(&c->bytes);
    return def;
}

static pli_status make_patch_uv(calls* c, calls_context* home, pli_mesh** mesh) {
    const pli_patch_def def = some_patch(c);
    const bool is_usable = def.columns >= 2 && def.columns < 100 && def.rows >= 2 && def.rows < 100;
    const size_t count = is_usable ? 12 * (size_t)(def.columns - 1) * (size_t)(def.rows - 1) : 0;
    float* coordinates = bytes_flag(&c->bytes) && is_usable ? malloc(count * sizeof *coordinates) : NULL;
    const pli_status status = CALL(c, home, pli_mesh_create_patch_uv(home->context, &def, coordinates, mesh));
    free(coordinates);
    return status;
}

static pli_status make_from_triangles(calls* c, calls_context* home, pli_mesh** mesh) {
    enum { POINTS = 12, TRIANGLES = 14 };
    pli_vec3 points[POINTS];
    int corners[3 * TRIANGLES];
    const int count = 3 + bytes_below(&c->bytes, POINTS - 2), triangle_count = bytes_small(&c->bytes, 1, TRIANGLES);
    some_points(c, points, count);
    for (int i = 0; i < 3 * triangle_count; ++i) {
        corners[i] = bytes_index(&c->bytes, count);
    }
    return CALL(c, home,
                pli_mesh_create_from_triangles(home->context, count, points, triangle_count, corners,
                                               bytes_flag(&c->bytes), mesh));
}

/* Boxes of five tetrahedra side by side, or any. */
static pli_status make_from_tetras(calls* c, calls_context* home, pli_mesh** mesh) {
    static const int of_box[20] = {0, 1, 2, 4, 3, 1, 7, 2, 5, 1, 4, 7, 6, 2, 7, 4, 1, 2, 4, 7};
    enum { BOXES = 4 };
    pli_vec3 points[4 * (BOXES + 1)];
    int corners[20 * BOXES];
    const int boxes = 1 + bytes_below(&c->bytes, BOXES);
    const float edge = bytes_float(&c->bytes, 0.1f, 1.0f);
    for (int i = 0; i < 4 * (boxes + 1); ++i) {
        points[i] = pli_vec3_make((float)(i % 2) * edge, (float)(i / 2 % 2) * edge, (float)(i / 4) * edge);
    }
    for (int i = 0; i < 20 * boxes; ++i) {
        const int corner = of_box[i % 20], box = i / 20;
        corners[i] = 4 * box + (box % 2 == 0 ? corner : (corner + 4) % 8);
    }
    int count = 5 * boxes;
    if (bytes_seldom(&c->bytes, 48)) {
        corners[bytes_below(&c->bytes, 20)] = bytes_index(&c->bytes, 4 * (boxes + 1));
        points[bytes_below(&c->bytes, 8)] = bytes_vec3(&c->bytes, -1.0f, 1.0f);
        count = bytes_small(&c->bytes, 1, 5);
    }
    return CALL(c, home, pli_mesh_create_from_tetras(home->context, 4 * (boxes + 1), points, count, corners, mesh));
}

static pli_status make_rope(calls* c, calls_context* home, pli_mesh** mesh) {
    const pli_vec3 from = bytes_vec3(&c->bytes, -1.0f, 1.0f), to = bytes_vec3(&c->bytes, -1.0f, 1.0f);
    const int inner = bytes_count(&c->bytes, 0, 40), pins = bytes_below(&c->bytes, 4);
    return CALL(c, home, pli_mesh_create_rope(home->context, from, to, inner, pins, mesh));
}

static pli_status make_ellipsoid(calls* c, calls_context* home, pli_mesh** mesh) {
    const pli_vec3 center = bytes_vec3(&c->bytes, -1.0f, 1.0f), radii = bytes_vec3(&c->bytes, 0.3f, 1.0f);
    const int count = bytes_count(&c->bytes, 4, 60);
    return CALL(c, home, pli_mesh_create_ellipsoid(home->context, center, radii, count, mesh));
}

static pli_status make_hull(calls* c, calls_context* home, pli_mesh** mesh) {
    enum { POINTS = 20 };
    pli_vec3 points[POINTS];
    const int count = bytes_small(&c->bytes, 4, POINTS);
    some_points(c, points, count > 0 ? count : 0);
    const float tolerance = bytes_seldom(&c->bytes, 100) ? bytes_float(&c->bytes, 0.0f, 0.1f) : 0.001f;
    return CALL(c, home, pli_mesh_create_convex_hull(home->context, count, points, tolerance, mesh));
}

void calls_make_mesh(calls* c) {
    calls_mesh* place = calls_mesh_place(c);
    calls_context* home = calls_any_context(c);
    pli_mesh* mesh = NULL;
    pli_status status = PLI_OK;
    const int kind = bytes_below(&c->bytes, 16);
    if (kind == 0) {
        status = CALL(c, home, pli_mesh_create(home->context, &mesh));
    } else if (kind == 1) {
        const calls_mesh* source = &c->meshes[bytes_below(&c->bytes, CALLS_MESHES)];
        if (source->mesh == NULL) { return; }
        home = source->home;
        status = CALL(c, home, pli_mesh_clone(source->mesh, &mesh));
    } else if (kind <= 3) {
        status = make_rope(c, home, &mesh);
    } else if (kind <= 7) {
        const pli_patch_def def = some_patch(c);
        status = CALL(c, home, pli_mesh_create_patch(home->context, &def, &mesh));
    } else if (kind == 8) {
        status = make_patch_uv(c, home, &mesh);
    } else if (kind <= 11) {
        status = make_ellipsoid(c, home, &mesh);
    } else if (kind == 12) {
        status = make_hull(c, home, &mesh);
    } else if (kind == 13) {
        status = make_from_triangles(c, home, &mesh);
    } else {
        status = make_from_tetras(c, home, &mesh);
    }
    if (status != PLI_OK) { return; }
    *place = (calls_mesh){mesh, home};
    c->digest = calls_digest(c);
}

// ------------------------------------------------------------------------------------------------------ edits

static void append(calls* c, pli_mesh* mesh, calls_context* home, const pli_mesh_view* view) {
    const int n[4] = {bytes_index(&c->bytes, view->node_count), bytes_index(&c->bytes, view->node_count),
                      bytes_index(&c->bytes, view->node_count), bytes_index(&c->bytes, view->node_count)};
    const int material = bytes_seldom(&c->bytes, 64) ? bytes_index(&c->bytes, view->material_count) : 0;
    const pli_vec3 position = bytes_vec3(&c->bytes, -1.0f, 1.0f);
    const pli_material made = {bytes_float(&c->bytes, 0.1f, 1.0f)};
    int index = 0;
    switch (bytes_below(&c->bytes, 6)) {
    case 0:
        CALL(c, home, pli_mesh_append_node(mesh, position, bytes_float(&c->bytes, 0.0f, 2.0f), &index));
        break;
    case 1:
        CALL(c, home, pli_mesh_append_link(mesh, n[0], n[1], material, NULL));
        break;
    case 2:
        CALL(c, home, pli_mesh_append_face(mesh, n[0], n[1], n[2], material, &index));
        break;
    case 3:
        CALL(c, home, pli_mesh_append_tetra(mesh, n[0], n[1], n[2], n[3], material, &index));
        break;
    case 4:
        CALL(c, home, pli_mesh_append_material(mesh, &made, &index));
        break;
    default:
        CALL(c, home, pli_mesh_set_material(mesh, material, &made));
        break;
    }
}

static void set_masses(calls* c, pli_mesh* mesh, calls_context* home, const pli_mesh_view* view) {
    const int kind = bytes_below(&c->bytes, 6);
    const float mass = bytes_float(&c->bytes, 0.0f, 5.0f);
    if (kind == 0) { CALL(c, home, pli_mesh_set_node_mass(mesh, bytes_index(&c->bytes, view->node_count), mass)); }
    if (kind == 1) { CALL(c, home, pli_mesh_set_total_mass(mesh, mass)); }
    if (kind == 2) { CALL(c, home, pli_mesh_set_total_mass_from_faces(mesh, mass)); }
    if (kind == 3) { CALL(c, home, pli_mesh_set_total_mass_from_tetras(mesh, mass)); }
    if (kind == 4) { CALL(c, home, pli_mesh_set_density_from_faces(mesh, mass)); }
    if (kind == 5) { CALL(c, home, pli_mesh_set_density_from_tetras(mesh, mass)); }
}

static void move_mesh(calls* c, pli_mesh* mesh, calls_context* home, const pli_mesh_view* view) {
    const int kind = bytes_below(&c->bytes, 5);
    const pli_transform transform = bytes_transform(&c->bytes, 1.0f);
    const pli_vec3 vector = bytes_vec3(&c->bytes, -1.5f, 1.5f);
    const pli_quat turn = {vector.x, vector.y, vector.z, bytes_float(&c->bytes, 0.1f, 1.0f)};
    if (kind == 0) { CALL(c, home, pli_mesh_transform(mesh, transform)); }
    if (kind == 1) { CALL(c, home, pli_mesh_translate(mesh, vector)); }
    if (kind == 2) { CALL(c, home, pli_mesh_rotate(mesh, turn)); }
    if (kind == 3) { CALL(c, home, pli_mesh_scale(mesh, vector)); }
    if (kind == 4) {
        CALL(c, home, pli_mesh_set_node_position(mesh, bytes_index(&c->bytes, view->node_count), vector));
    }
    (void)pli_mesh_volume(mesh);
    (void)pli_mesh_bounds(mesh);
    (void)pli_mesh_total_mass(mesh);
}

void calls_edit_mesh(calls* c) {
    const calls_mesh* chosen = calls_any_mesh(c);
    if (chosen == NULL) { return; }
    pli_mesh* mesh = chosen->mesh;
    calls_context* home = chosen->home;
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    const int kind = bytes_below(&c->bytes, 12);
    if (kind < 3 && view.node_count < CALLS_MOST_NODES) { append(c, mesh, home, &view); }
    if (kind >= 3 && kind < 6) { set_masses(c, mesh, home, &view); }
    if (kind >= 6 && kind < 9) { move_mesh(c, mesh, home, &view); }
    if (kind == 9 && view.link_count < 600) {
        int added = 0;
        CALL(c, home, pli_mesh_append_bending_links(mesh, bytes_small(&c->bytes, 2, 3), 0, &added));
    }
    if (kind == 10) { CALL(c, home, pli_mesh_shuffle_links(mesh)); }
    if (kind == 11) { CALL(c, home, pli_mesh_interleave_links(mesh)); }
}
