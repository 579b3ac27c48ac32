/* Bodies filled with tetrahedra: a cube in 16 clusters (demo 30, Init_TetraCube) and a bunny whose tetrahedra are
   clusters (demo 31, Init_TetraBunny). */

#include "parts.h"
#include "scenes/scenes.h"

static void tetra_cube_build(scene_builder* builder) {
    part_wavy_ground(builder);
    pli_mesh* mesh = scene_tetra_mesh(builder, "tetra_cube");
    scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(4, 4, 4)));
    scene_check(builder, pli_mesh_translate(mesh, pli_vec3_make(0, 5, 0)));
    scene_check(builder, pli_mesh_set_total_mass_from_tetras(mesh, 300));
    part_set_stiffness(builder, mesh, 0.8f);
    scene_soft_def def = part_cluster_def("cube", 16, 0.2f);
    def.collision_margin = 0.01f;
    scene_add_soft(builder, mesh, &def);
    scene_set_camera(builder, (scene_camera){{0, -5, 0}, 25, 27, -18});
}

static void tetra_bunny_build(scene_builder* builder) {
    part_wavy_ground(builder);
    pli_mesh* mesh = scene_tetra_mesh(builder, "tetra_bunny");
    scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(6, 6, 6)));
    scene_check(builder, pli_mesh_rotate(mesh, pli_quat_from_yaw_pitch_roll(half_pi, 0, 0)));
    scene_check(builder, pli_mesh_set_total_mass_from_tetras(mesh, 150));
    scene_soft_def def = part_cluster_def("bunny", 0, 10);
    def.solver.position_iterations = 2;
    scene_add_soft(builder, mesh, &def);
    scene_set_camera(builder, (scene_camera){{0, -7, 0}, 19, 27, -16});
}

const scene scene_tetra_bunny = {
    .name = "TetraBunny",
    .summary = "A bunny of tetrahedra falls to wavy ground.",
    .takes_tetra = true,
    .picture_frame = 90,
    .build = tetra_bunny_build,
};

const scene scene_tetra_cube = {
    .name = "TetraCube",
    .summary = "A cube of tetrahedra falls to wavy ground.",
    .takes_tetra = true,
    .picture_frame = 90,
    .build = tetra_cube_build,
};
