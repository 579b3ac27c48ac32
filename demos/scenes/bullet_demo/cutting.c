/* A sheet that is cut (demo 19, Init_Cutting1). */

#include "parts.h"
#include "scenes/scenes.h"

static void cutting_build(scene_builder* builder) {
    part_ground(builder);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(6, 2, -6);
    patch.corner_10 = pli_vec3_make(-6, 2, -6);
    patch.corner_01 = pli_vec3_make(6, 2, 6);
    patch.corner_11 = pli_vec3_make(-6, 2, 6);
    patch.columns = patch.rows = 16;
    patch.pins = PLI_PATCH_PIN_CORNERS;
    patch.diagonals = true;
    pli_mesh* mesh = NULL;
    scene_check(builder, pli_mesh_create_patch(scene_context(builder), &patch, &mesh));
    scene_soft_def def = scene_soft_def_default();
    def.name = "cloth";
    const int cloth = scene_add_soft(builder, mesh, &def);
    /* As the clicks of a mouse do: discs of 1 m fall out of the sheet. */
    const int frames[3] = {30, 60, 90}, nodes[3] = {5 * 16 + 5, 6 * 16 + 10, 11 * 16 + 8};
    for (int i = 0; i < 3; ++i) {
        scene_cut_at(builder, frames[i], cloth, nodes[i], 1);
    }
    scene_set_camera(builder, (scene_camera){{0, -2, 0}, 26, 27, -31});
}

const scene scene_cutting1 = {
    .name = "Cutting1",
    .summary = "Three discs are cut out of a sheet that is held at its corners.",
    .picture_frame = 110,
    .build = cutting_build,
};
