/* Bodies that act through their clusters: alone (demo 20, Init_ClusterDeform), against rigid bodies and each other
   (demos 21 and 22, Init_ClusterCollide1 and 2) and in stacks (demos 28 and 29, Init_ClusterStackSoft and Mixed). */

#include "parts.h"
#include "scenes/scenes.h"

static void cluster_deform_build(scene_builder* builder) {
    part_wavy_ground(builder);
    scene_soft_def def;
    pli_mesh* mesh =
        part_cluster_torus(builder, pli_vec3_make(0, 0, 0), pli_quat_from_yaw_pitch_roll(half_pi, 0, half_pi),
                           pli_vec3_make(2, 2, 2), &def);
    def.cluster_count = 8;
    scene_add_soft(builder, mesh, &def);
    scene_set_camera(builder, (scene_camera){{0, -7, 0}, 20, 27, -22});
}

static void cluster_collide1_build(scene_builder* builder) {
    part_wavy_ground(builder);
    pli_mesh* mesh = part_sheet(builder, pli_vec3_make(0, 0, 0), 8, 17, PLI_PATCH_PIN_CORNERS);
    part_add_bending(builder, mesh, 0.4f);
    scene_check(builder, pli_mesh_set_total_mass(mesh, 50));
    scene_soft_def def = part_cluster_def("cloth", 0, 1);
    def.collision_margin = 0.05f;
    def.cluster_contacts.dynamic_hardness = 1;
    def.cluster_contacts.dynamic_split = 0;
    scene_add_soft(builder, mesh, &def);
    part_falling_stack(builder, 10);
    scene_set_camera(builder, (scene_camera){{0, 1, 0}, 36, 27, -24});
}

static void cluster_collide2_build(scene_builder* builder) {
    part_wavy_ground(builder);
    scene_soft_def def = part_cluster_def("torus", 16, 1);
    def.solver.position_iterations = 2;
    def.cluster_contacts.soft_hardness = 1;
    def.cluster_contacts.soft_split = 0;
    def.cluster_contacts.static_hardness = 0.1f;
    def.cluster_contacts.static_split = 1;
    for (int i = 0; i < 3; ++i) {
        const float odd = (float)(i & 1);
        pli_mesh* mesh = scene_triangle_mesh(builder, "torus");
        part_add_bending(builder, mesh, 1);
        scene_check(builder, pli_mesh_shuffle_links(mesh));
        const pli_transform pose = {pli_mat3_from_euler_zyx(half_pi * (1 - odd), half_pi * odd, 0),
                                    {3 * (float)i, 2, 0}};
        scene_check(builder, pli_mesh_transform(mesh, pose));
        scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(2, 2, 2)));
        scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 50));
        scene_add_soft(builder, mesh, &def);
    }
    scene_set_camera(builder, (scene_camera){{6, -4, 0}, 34, 27, -24});
}

static void cluster_stack_add(scene_builder* builder, float height) {
    scene_soft_def def;
    pli_mesh* mesh =
        part_cluster_torus(builder, pli_vec3_make(0, height, 0), pli_quat_identity(), pli_vec3_make(2, 2, 2), &def);
    scene_add_soft(builder, mesh, &def);
}

static void cluster_stack_soft_build(scene_builder* builder) {
    part_wavy_ground(builder);
    for (int i = 0; i < 10; ++i) {
        cluster_stack_add(builder, -9 + 8.25f * (float)i);
    }
    scene_set_camera(builder, (scene_camera){{4, -2, 0}, 46, 27, -16});
}

static void cluster_stack_mixed_build(scene_builder* builder) {
    part_wavy_ground(builder);
    for (int i = 0; i < 10; ++i) {
        const float height = -9 + 4.25f * (float)i;
        if (i % 2 == 0) {
            part_plate(builder, 50, height);
        } else {
            cluster_stack_add(builder, height);
        }
    }
    scene_set_camera(builder, (scene_camera){{0, 0, 0}, 44, 27, -20});
}

const scene scene_cluster_deform = {
    .name = "ClusterDeform",
    .summary = "A torus of eight clusters falls on edge to wavy ground.",
    .takes_mesh = true,
    .picture_frame = 90,
    .build = cluster_deform_build,
};

const scene scene_cluster_collide1 = {
    .name = "ClusterCollide1",
    .summary = "Ten rigid bodies fall on a sheet whose faces are clusters.",
    .picture_frame = 110,
    .build = cluster_collide1_build,
};

const scene scene_cluster_collide2 = {
    .name = "ClusterCollide2",
    .summary = "Three tori, linked like a chain, fall to wavy ground; their clusters collide.",
    .takes_mesh = true,
    .picture_frame = 90,
    .build = cluster_collide2_build,
};

const scene scene_cluster_stack_soft = {
    .name = "ClusterStackSoft",
    .summary = "Ten tori fall on each other.",
    .takes_mesh = true,
    .picture_frame = 220,
    .build = cluster_stack_soft_build,
};

const scene scene_cluster_stack_mixed = {
    .name = "ClusterStackMixed",
    .summary = "Plates and tori, in turn, fall on each other.",
    .takes_mesh = true,
    .picture_frame = 160,
    .build = cluster_stack_mixed_build,
};
