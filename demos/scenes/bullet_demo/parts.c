/* The bodies and meshes that several scenes share: ground, stack, stair, sheets, ropes. */

#include "parts.h"

#include <math.h>

static int part_add(scene_builder* builder, const char* name, scene_shape shape, float mass, pli_vec3 position,
                    float friction) {
    scene_rigid_def def = scene_rigid_def_default();
    def.name = name;
    def.shape = shape;
    def.mass = mass;
    def.pose.origin = position;
    def.friction = friction;
    return scene_add_rigid(builder, &def);
}

void part_ground(scene_builder* builder) {
    scene_rigid_def def = scene_rigid_box("ground", pli_vec3_make(100, 1.5f, 100), 0, pli_vec3_make(0, -12, 0));
    def.is_collision_only = true;
    scene_add_rigid(builder, &def);
}

#define PART_WAVES 30

void part_wavy_ground(scene_builder* builder) {
    pli_vec3 points[PART_WAVES * PART_WAVES];
    int triangles[(PART_WAVES - 1) * (PART_WAVES - 1) * 6];
    const float cell = 8, height = 5;
    int* next = triangles;
    for (int i = 0; i < PART_WAVES; ++i) {
        for (int k = 0; k < PART_WAVES; ++k) {
            const int here = i + k * PART_WAVES;
            points[here] =
                pli_vec3_make(((float)i - PART_WAVES / 2) * cell, height * sinf((float)i) * cosf((float)k - 50),
                              ((float)k - PART_WAVES / 2) * cell);
            if (i + 1 == PART_WAVES || k + 1 == PART_WAVES) { continue; }
            const int right = here + 1, below = here + PART_WAVES;
            const int corners[6] = {here, below + 1, right, here, below, below + 1};
            for (int c = 0; c < 6; ++c) {
                *next++ = corners[c];
            }
        }
    }
    scene_rigid_def def = scene_rigid_def_default();
    def.name = "ground";
    def.shape.kind = SCENE_SHAPE_TRIANGLE_MESH;
    def.shape.margin = 0.5f;
    def.shape.points = points;
    def.shape.point_count = PART_WAVES * PART_WAVES;
    def.shape.triangles = triangles;
    def.shape.triangle_count = (PART_WAVES - 1) * (PART_WAVES - 1) * 2;
    def.pose.origin = pli_vec3_make(0, -12, 0);
    def.is_collision_only = true;
    scene_add_rigid(builder, &def);
}

void part_falling_stack(scene_builder* builder, int count) {
    const pli_vec3 bar = pli_vec3_make(4, 1, 1);
    scene_shape parts[2] = {scene_box(bar), scene_box(bar)};
    parts[1].kind = SCENE_SHAPE_CYLINDER;
    parts[1].axis = 0;
    pli_transform poses[2] = {pli_transform_identity(), pli_transform_identity()};
    poses[1].rotation = pli_mat3_from_quat(pli_quat_from_yaw_pitch_roll(half_pi, 0, 0));
    scene_shape cross = scene_box(bar);
    cross.kind = SCENE_SHAPE_COMPOUND;
    cross.child_count = 2;
    cross.children = parts;
    cross.child_poses = poses;
    const scene_shape shapes[3] = {cross, scene_box(pli_vec3_make(1, 1, 1)), scene_sphere(1.5f)};
    const char* const names[3] = {"cross", "box", "ball"};
    for (int i = 0; i < count; ++i) {
        part_add(builder, names[i % 3], shapes[i % 3], 10, pli_vec3_make(0, (float)(2 + 6 * i), 0), 0.5f);
    }
}

void part_big_ball(scene_builder* builder) {
    part_add(builder, "ball", scene_sphere(3), 10, pli_vec3_make(0, 13, 0), 0.5f);
}

int part_plate(scene_builder* builder, float mass, float height) {
    return part_add(builder, "plate", scene_box(pli_vec3_make(5, 1, 5)), mass, pli_vec3_make(0, height, 0.5f), 1);
}

void part_stair(scene_builder* builder, pli_vec3 first, pli_vec3 half_extents, int count) {
    for (int i = 0; i < count; ++i) {
        const pli_vec3 rise = pli_vec3_make(half_extents.x * (float)i * 2, half_extents.y * (float)i * 2, 0);
        part_add(builder, "step", scene_box(half_extents), 0, pli_vec3_add(first, rise), 1);
    }
}

pli_mesh* part_sheet(scene_builder* builder, pli_vec3 center, float half_width, int columns, int pins) {
    const float s = half_width;
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_add(pli_vec3_make(-s, 0, -s), center);
    def.corner_10 = pli_vec3_add(pli_vec3_make(+s, 0, -s), center);
    def.corner_01 = pli_vec3_add(pli_vec3_make(-s, 0, +s), center);
    def.corner_11 = pli_vec3_add(pli_vec3_make(+s, 0, +s), center);
    def.columns = def.rows = columns;
    def.pins = pins;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    scene_check(builder, pli_mesh_create_patch(scene_context(builder), &def, &mesh));
    return mesh;
}

pli_mesh* part_rope(scene_builder* builder, pli_vec3 from, pli_vec3 to, int inner_nodes, int pins) {
    pli_mesh* mesh = NULL;
    scene_check(builder, pli_mesh_create_rope(scene_context(builder), from, to, inner_nodes, pins, &mesh));
    return mesh;
}

void part_set_stiffness(scene_builder* builder, pli_mesh* mesh, float linear_stiffness) {
    const pli_material material = {linear_stiffness};
    scene_check(builder, pli_mesh_set_material(mesh, 0, &material));
}

void part_add_bending(scene_builder* builder, pli_mesh* mesh, float linear_stiffness) {
    const pli_material material = {linear_stiffness};
    int index = 0;
    scene_check(builder, pli_mesh_append_material(mesh, &material, &index));
    scene_check(builder, pli_mesh_append_bending_links(mesh, 2, index, NULL));
}

scene_soft_def part_cluster_def(const char* name, int cluster_count, float friction) {
    scene_soft_def def = scene_soft_def_default();
    def.name = name;
    def.has_rigid_contacts = false;
    def.has_clusters = true;
    def.cluster_count = cluster_count;
    def.has_cluster_contacts = true;
    def.cluster_contacts.friction = friction;
    return def;
}

pli_mesh* part_cluster_torus(scene_builder* builder, pli_vec3 position, pli_quat rotation, pli_vec3 scale,
                             scene_soft_def* def) {
    pli_mesh* mesh = scene_triangle_mesh(builder, "torus");
    part_add_bending(builder, mesh, 1);
    scene_check(builder, pli_mesh_shuffle_links(mesh));
    scene_check(builder, pli_mesh_scale(mesh, scale));
    scene_check(builder, pli_mesh_rotate(mesh, rotation));
    scene_check(builder, pli_mesh_translate(mesh, position));
    scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 50));
    *def = part_cluster_def("torus", 64, 1);
    def->solver.position_iterations = 2;
    return mesh;
}
