/* A sheet that holds a box by two corners (demo 5, Init_ClothAttach). */

#include "parts.h"
#include "scenes/scenes.h"

static void cloth_attach_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "cloth";
    pli_mesh* mesh = part_sheet(builder, pli_vec3_make(0, 6, 0), 4, 9, PLI_PATCH_PIN_01 | PLI_PATCH_PIN_11);
    const int cloth = scene_add_soft(builder, mesh, &def);
    const scene_rigid_def box = scene_rigid_box("box", pli_vec3_make(4, 1, 3), 20, pli_vec3_make(0, 6, -7.5f));
    const int box_index = scene_add_rigid(builder, &box);
    scene_add_anchor(builder, cloth, 0, box_index, false, 1);
    scene_add_anchor(builder, cloth, 8, box_index, false, 1);
    scene_set_camera(builder, (scene_camera){{0, 2, -3}, 27, 50, -14});
}

const scene scene_cloth_attach = {
    .name = "ClothAttach",
    .summary = "A box swings on a sheet that is held at the other side.",
    .picture_frame = 45,
    .build = cloth_attach_build,
};
