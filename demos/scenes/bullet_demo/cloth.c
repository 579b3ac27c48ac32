/* Cloth under a stack of rigid bodies (demo 0, Init_Cloth). */

#include "parts.h"
#include "scenes/scenes.h"

static void cloth_build(scene_builder* builder) {
    part_ground(builder);
    pli_mesh* mesh = part_sheet(builder, pli_vec3_make(0, 0, 0), 8, 31, PLI_PATCH_PIN_CORNERS);
    part_add_bending(builder, mesh, 0.4f);
    scene_check(builder, pli_mesh_set_total_mass(mesh, 150));
    scene_soft_def def = scene_soft_def_default();
    def.name = "cloth";
    def.collision_margin = 0.5f;
    scene_add_soft(builder, mesh, &def);
    part_falling_stack(builder, 10);
    scene_set_camera(builder, (scene_camera){{0, 1, 0}, 36, 27, -24});
}

const scene scene_cloth = {
    .name = "Cloth",
    .summary = "Ten rigid bodies fall on a sheet that is held at its corners.",
    .picture_frame = 110,
    .build = cloth_build,
};
