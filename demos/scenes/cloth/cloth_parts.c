/* Floor, grids of cloth and their settings, kinematic holders. */

#include "cloth_parts.h"

void cloth_part_floor(scene_builder* builder) {
    scene_rigid_def def = scene_rigid_box("floor", pli_vec3_make(40, 1, 40), 0, pli_vec3_make(0, -1, 0));
    def.is_collision_only = true;
    scene_add_rigid(builder, &def);
}

static void cloth_part_link(scene_builder* builder, pli_mesh* mesh, int a, int b, int material) {
    scene_check(builder, pli_mesh_append_link(mesh, a, b, material, NULL));
}

static void cloth_part_cell(scene_builder* builder, pli_mesh* mesh, int here, int right, int below, int across,
                            bool is_odd) {
    if (is_odd) {
        cloth_part_link(builder, mesh, right, below, 0);
        scene_check(builder, pli_mesh_append_face(mesh, here, below, right, 0, NULL));
        scene_check(builder, pli_mesh_append_face(mesh, right, below, across, 0, NULL));
    } else {
        cloth_part_link(builder, mesh, here, across, 0);
        scene_check(builder, pli_mesh_append_face(mesh, here, below, across, 0, NULL));
        scene_check(builder, pli_mesh_append_face(mesh, here, across, right, 0, NULL));
    }
}

pli_mesh* cloth_part_mesh(scene_builder* builder, const cloth_part* part) {
    const int columns = part->resolution.columns, rows = part->resolution.rows;
    pli_mesh* mesh = NULL;
    if (!scene_check(builder, pli_mesh_create(scene_context(builder), &mesh))) { return NULL; }
    const float node_mass = part->mass / (float)(columns * rows);
    for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
            const float u = (float)c / (float)(part->is_tube ? columns : columns - 1);
            const pli_vec3 place = part->place(u, (float)r / (float)(rows - 1));
            scene_check(builder, pli_mesh_append_node(mesh, place, node_mass, NULL));
        }
    }
    const pli_material soft = {part->bending};
    int bending = 0;
    scene_check(builder, pli_mesh_append_material(mesh, &soft, &bending));
    for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) {
            const int here = r * columns + c, row = r * columns;
            const bool has_right = part->is_tube || c + 1 < columns, has_below = r + 1 < rows;
            const int right = row + (c + 1) % columns, below = here + columns;
            if (has_right) { cloth_part_link(builder, mesh, here, right, 0); }
            if (has_below) { cloth_part_link(builder, mesh, here, below, 0); }
            if (part->is_tube || c + 2 < columns) {
                cloth_part_link(builder, mesh, here, row + (c + 2) % columns, bending);
            }
            if (r + 2 < rows) { cloth_part_link(builder, mesh, here, below + columns, bending); }
            if (has_right && has_below) {
                cloth_part_cell(builder, mesh, here, right, below, right + columns, ((c + r) & 1) != 0);
            }
        }
    }
    scene_check(builder, pli_mesh_shuffle_links(mesh));
    return mesh;
}

scene_soft_def cloth_part_def(const char* name, float spacing) {
    scene_soft_def def = scene_soft_def_default();
    def.name = name;
    def.collision_margin = 0.5f * spacing;
    def.solver.position_iterations = 10;
    def.solver.velocity_damping = 0.02f;
    def.rigid_contacts.friction = 0.5f;
    def.link_stiffness = 2000;
    def.link_damping = 0.05f;
    def.self_collision = SCENE_SELF_NODES;
    def.thickness = 0.9f * spacing;
    return def;
}

int cloth_part_kinematic(scene_builder* builder, const char* name, scene_shape shape, pli_vec3 origin) {
    scene_rigid_def def = scene_rigid_def_default();
    def.name = name;
    def.shape = shape;
    def.pose.origin = origin;
    def.is_kinematic = true;
    return scene_add_rigid(builder, &def);
}

void cloth_part_anchor_column(scene_builder* builder, int soft, scene_resolution resolution, int column, int rigid) {
    for (int r = 0; r < resolution.rows; ++r) {
        scene_add_anchor(builder, soft, r * resolution.columns + column, rigid, true, 1);
    }
}

void cloth_part_anchor_row(scene_builder* builder, int soft, scene_resolution resolution, int row, int rigid) {
    for (int c = 0; c < resolution.columns; ++c) {
        scene_add_anchor(builder, soft, row * resolution.columns + c, rigid, true, 1);
    }
}
