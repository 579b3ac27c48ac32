/* Ropes of different stiffness (demo 3, Init_Ropes), ropes that hold a box (demo 4, Init_RopeAttach), and a rope of
   two nodes that is hit (Init_Impact). */

#include "parts.h"
#include "scenes/scenes.h"

static void ropes_build(scene_builder* builder) {
    part_ground(builder);
    for (int i = 0; i < 15; ++i) {
        const float z = (float)i * 0.25f;
        pli_mesh* mesh = part_rope(builder, pli_vec3_make(-10, 0, z), pli_vec3_make(10, 0, z), 16,
                                   PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST);
        part_set_stiffness(builder, mesh, (float)(0.1 + (double)((float)i / 14.0f) * 0.9));
        scene_check(builder, pli_mesh_set_total_mass(mesh, 20));
        scene_soft_def def = scene_soft_def_default();
        def.name = "rope";
        def.solver.position_iterations = 4;
        scene_add_soft(builder, mesh, &def);
    }
    scene_set_camera(builder, (scene_camera){{0, -4, 2}, 26, 20, -15});
}

static void rope_attach_build(scene_builder* builder) {
    part_ground(builder);
    const scene_rigid_def box = scene_rigid_box("box", pli_vec3_make(2, 6, 2), 50, pli_vec3_make(12, 8, 0));
    const int box_index = scene_add_rigid(builder, &box);
    int ropes[2];
    for (int i = 0; i < 2; ++i) {
        const float z = i == 0 ? -1.0f : 1.0f;
        pli_mesh* mesh = part_rope(builder, pli_vec3_make(0, 8, z), pli_vec3_make(10, 8, z), 8, PLI_ROPE_PIN_FIRST);
        scene_check(builder, pli_mesh_set_total_mass(mesh, 50));
        scene_soft_def def = scene_soft_def_default();
        def.name = "rope";
        ropes[i] = scene_add_soft(builder, mesh, &def);
    }
    for (int i = 0; i < 2; ++i) {
        scene_add_anchor(builder, ropes[i], 9, box_index, false, 1);
    }
    scene_set_camera(builder, (scene_camera){{4, 2, 0}, 34, 20, -12});
}

static void impact_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "rope";
    def.rigid_contacts.dynamic_hardness = 0.5f;
    scene_add_soft(builder, part_rope(builder, pli_vec3_make(0, 0, 0), pli_vec3_make(0, -1, 0), 0, PLI_ROPE_PIN_FIRST),
                   &def);
    const scene_rigid_def box = scene_rigid_box("box", pli_vec3_make(2, 2, 2), 10, pli_vec3_make(0, 20, 0));
    scene_add_rigid(builder, &box);
    scene_set_camera(builder, (scene_camera){{0, 0.5f, 0}, 19, 27, -20});
}

const scene scene_ropes = {
    .name = "Ropes",
    .summary = "Fifteen ropes, the stiffness grows from one to the next.",
    .picture_frame = 60,
    .build = ropes_build,
};

const scene scene_rope_attach = {
    .name = "RopeAttach",
    .summary = "A heavy box swings on two ropes.",
    .picture_frame = 90,
    .build = rope_attach_build,
};

const scene scene_impact = {
    .name = "Impact",
    .summary = "A box falls on the pinned end of a rope of two nodes and comes to rest there.",
    .picture_frame = 150,
    .build = impact_build,
};
