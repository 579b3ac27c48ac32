/* A torus on the ground: with bending links (demo 15, Init_Torus) and with pose matching (demo 16, Init_TorusMatch). */

#include "parts.h"
#include "scenes/scenes.h"

static void torus_place(scene_builder* builder, pli_mesh* mesh) {
    scene_check(builder, pli_mesh_shuffle_links(mesh));
    const pli_transform pose = {pli_mat3_from_euler_zyx(half_pi, 0, 0), {0, 4, 0}};
    scene_check(builder, pli_mesh_transform(mesh, pose));
    scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(2, 2, 2)));
    scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 50));
    scene_set_camera(builder, (scene_camera){{0, -7, 0}, 22, 27, -20});
}

static void torus_build(scene_builder* builder) {
    part_ground(builder);
    pli_mesh* mesh = scene_triangle_mesh(builder, "torus");
    scene_check(builder, pli_mesh_append_bending_links(mesh, 2, 0, NULL));
    torus_place(builder, mesh);
    scene_soft_def def = scene_soft_def_default();
    def.name = "torus";
    def.solver.position_iterations = 2;
    scene_add_soft(builder, mesh, &def);
}

static void torus_match_build(scene_builder* builder) {
    part_ground(builder);
    pli_mesh* mesh = scene_triangle_mesh(builder, "torus");
    part_set_stiffness(builder, mesh, 0.1f);
    torus_place(builder, mesh);
    scene_soft_def def = scene_soft_def_default();
    def.name = "torus";
    def.pose_matching = 0.05f;
    scene_add_soft(builder, mesh, &def);
}

const scene scene_torus = {
    .name = "Torus",
    .summary = "A torus with bending links falls to the ground.",
    .takes_mesh = true,
    .picture_frame = 110,
    .build = torus_build,
};

const scene scene_torus_match = {
    .name = "TorusMatch",
    .summary = "A torus that is pulled back to its shape falls to the ground.",
    .takes_mesh = true,
    .picture_frame = 110,
    .build = torus_match_build,
};
