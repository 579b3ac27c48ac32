#pragma once

/* Heavy rigid bodies on light cloth: the sheet and the ball that tests of each solver begin with. */

#include "level_sheet.h"
#include "test_world.h"

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

enum { SHEET_SIDE = 21, SHEET_NODES = SHEET_SIDE * SHEET_SIDE };
typedef enum sheet_pins { SHEET_LOOSE, SHEET_CORNERS, SHEET_RIM } sheet_pins;

static const float sheet_margin = 0.02f, ball_radius = 0.3f; /* m */

static inline bool sheet_is_pinned(sheet_pins pins, int node) {
    const int last = SHEET_SIDE - 1, column = node % SHEET_SIDE, row = node / SHEET_SIDE;
    const bool ends_row = column == 0 || column == last, ends_column = row == 0 || row == last;
    if (pins == SHEET_LOOSE) { return false; }
    return pins == SHEET_RIM ? level_sheet_is_rim(node, SHEET_SIDE) : ends_row && ends_column;
}

/* 2 m by 2 m, level at the height 0; 1 kg before nodes are pinned. With contacts of a friction of 1. */
static inline pli_body* make_sheet(sheet_pins pins, const pli_solver_settings* settings, bool has_nodes,
                                   bool has_faces) {
    pli_patch_def patch = level_sheet(1, 0, SHEET_SIDE);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    for (int i = 0; i < SHEET_NODES; ++i) {
        if (sheet_is_pinned(pins, i)) { CHECK_OK(pli_mesh_set_node_mass(mesh, i, 0)); }
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = sheet_margin;
    def.solver = *settings;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
    pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
    nodes.friction = faces.friction = 1;
    if (has_nodes) { CHECK_OK(pli_body_enable_rigid_contacts(body, &nodes)); }
    if (has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(body, &faces)); }
    return body;
}

/* With the inertia of a solid ball. Mass 0: static. Takes over the reference to the shape. */
static inline pli_rigid* make_rigid(pli_shape* shape, float height, float mass) {
    pli_rigid_def def = pli_rigid_def_default();
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose.origin.y = height;
    if (mass > 0) {
        const float inverse = 1 / (0.4f * mass * ball_radius * ball_radius);
        def.kind = PLI_RIGID_DYNAMIC;
        def.state.inverse_mass = 1 / mass;
        def.state.inverse_inertia_world =
            (pli_mat3){{pli_vec3_make(inverse, 0, 0), pli_vec3_make(0, inverse, 0), pli_vec3_make(0, 0, inverse)}};
    }
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

static inline pli_rigid* make_ball(float height, float mass) {
    pli_shape* sphere = NULL;
    CHECK_OK(pli_shape_create_sphere(context, ball_radius, &sphere));
    return make_rigid(sphere, height, mass);
}
