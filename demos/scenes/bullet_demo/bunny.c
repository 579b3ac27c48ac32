/* The Stanford bunny: with bending links (demo 17, Init_Bunny) and with pose matching (demo 18, Init_BunnyMatch). */

#include "parts.h"
#include "scenes/scenes.h"

static void bunny_add(scene_builder* builder, pli_mesh* mesh, scene_soft_def def) {
    scene_check(builder, pli_mesh_shuffle_links(mesh));
    scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(6, 6, 6)));
    scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 100));
    def.name = "bunny";
    def.rigid_contacts.friction = 0.5f;
    scene_add_soft(builder, mesh, &def);
    scene_set_camera(builder, (scene_camera){{0, -7, 0}, 19, 155, -16});
}

static void bunny_build(scene_builder* builder) {
    part_ground(builder);
    pli_mesh* mesh = scene_triangle_mesh(builder, "bunny");
    part_add_bending(builder, mesh, 0.5f);
    scene_soft_def def = scene_soft_def_default();
    def.solver.position_iterations = 2;
    bunny_add(builder, mesh, def);
}

static void bunny_match_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.solver.position_iterations = 5;
    def.pose_matching = 0.05f;
    bunny_add(builder, scene_triangle_mesh(builder, "bunny"), def);
}

const scene scene_bunny = {
    .name = "Bunny",
    .summary = "A bunny with bending links falls to the ground.",
    .takes_mesh = true,
    .picture_frame = 80,
    .build = bunny_build,
};

const scene scene_bunny_match = {
    .name = "BunnyMatch",
    .summary = "A bunny that is pulled back to its shape falls to the ground.",
    .takes_mesh = true,
    .picture_frame = 110,
    .build = bunny_match_build,
};
