/* Soft bodies that meet each other: tori (demo 8, Init_Collide), bunnies (demo 9, Init_Collide2) and sheets (demo 10,
   Init_Collide3). */

#include "parts.h"
#include "scenes/scenes.h"

static void collide_tori_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "torus";
    def.solver.position_iterations = 2;
    def.has_soft_contacts = true;
    for (int i = 0; i < 3; ++i) {
        const float odd = (float)(i & 1);
        pli_mesh* mesh = scene_triangle_mesh(builder, "torus");
        scene_check(builder, pli_mesh_append_bending_links(mesh, 2, 0, NULL));
        scene_check(builder, pli_mesh_shuffle_links(mesh));
        const pli_transform pose = {pli_mat3_from_euler_zyx(half_pi * (1 - odd), half_pi * odd, 0),
                                    {3 * (float)i, 2, 0}};
        scene_check(builder, pli_mesh_transform(mesh, pose));
        scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(2, 2, 2)));
        scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 50));
        scene_add_soft(builder, mesh, &def);
    }
    scene_set_camera(builder, (scene_camera){{6, -4, 0}, 28, 27, -20});
}

static void collide_bunnies_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "bunny";
    def.solver.position_iterations = 2;
    def.rigid_contacts.friction = def.soft_contacts.friction = 0.5f;
    def.has_soft_contacts = true;
    for (int i = 0; i < 3; ++i) {
        pli_mesh* mesh = scene_triangle_mesh(builder, "bunny");
        part_add_bending(builder, mesh, 0.5f);
        scene_check(builder, pli_mesh_shuffle_links(mesh));
        const pli_transform pose = {pli_mat3_from_euler_zyx(0, half_pi * (float)(i & 1), 0), {0, -1 + 5 * (float)i, 0}};
        scene_check(builder, pli_mesh_transform(mesh, pose));
        scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(6, 6, 6)));
        scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 100));
        scene_add_soft(builder, mesh, &def);
    }
    scene_set_camera(builder, (scene_camera){{0, -4, 0}, 34, 27, -14});
}

static void collide_sheets_build(scene_builder* builder) {
    part_ground(builder);
    pli_mesh* net = part_sheet(builder, pli_vec3_make(0, 0, 0), 8, 15, PLI_PATCH_PIN_CORNERS);
    part_set_stiffness(builder, net, 0.4f);
    scene_check(builder, pli_mesh_set_total_mass(net, 150));
    scene_soft_def def = scene_soft_def_default();
    def.name = "net";
    def.has_soft_contacts = true;
    scene_add_soft(builder, net, &def);

    pli_mesh* sheet = part_sheet(builder, pli_vec3_make(5, 10, 0), 4, 7, 0);
    part_add_bending(builder, sheet, 0.1f);
    part_set_stiffness(builder, sheet, 0.5f);
    scene_check(builder, pli_mesh_set_total_mass(sheet, 150));
    def.name = "sheet";
    scene_add_soft(builder, sheet, &def);
    scene_set_camera(builder, (scene_camera){{1, -1, 0}, 30, 27, -22});
}

const scene scene_collide = {
    .name = "Collide",
    .summary = "Three tori, linked like a chain, fall to the ground.",
    .takes_mesh = true,
    .picture_frame = 70,
    .build = collide_tori_build,
};

const scene scene_collide2 = {
    .name = "Collide2",
    .summary = "Three bunnies fall on each other.",
    .takes_mesh = true,
    .picture_frame = 200,
    .build = collide_bunnies_build,
};

const scene scene_collide3 = {
    .name = "Collide3",
    .summary = "A loose sheet falls on one that is held at its corners.",
    .picture_frame = 120,
    .build = collide_sheets_build,
};
