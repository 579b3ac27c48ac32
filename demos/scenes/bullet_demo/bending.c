/* The smallest body that folds: four nodes, three of them pinned (Init_Bending). */

#include "parts.h"
#include "scenes/scenes.h"

static void bending_build(scene_builder* builder) {
    part_ground(builder);
    static const float corners[4][2] = {{-4, -4}, {4, -4}, {4, 4}, {-4, 4}};
    static const int links[5][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}};
    pli_mesh* mesh = NULL;
    scene_check(builder, pli_mesh_create(scene_context(builder), &mesh));
    for (int i = 0; i < 4; ++i) {
        const pli_vec3 position = pli_vec3_make(corners[i][0], 0, corners[i][1]);
        scene_check(builder, pli_mesh_append_node(mesh, position, i == 3 ? 1.0f : 0.0f, NULL));
    }
    for (int i = 0; i < 5; ++i) {
        scene_check(builder, pli_mesh_append_link(mesh, links[i][0], links[i][1], 0, NULL));
    }
    scene_soft_def def = scene_soft_def_default();
    def.name = "frame";
    scene_add_soft(builder, mesh, &def);
    scene_set_camera(builder, (scene_camera){{0, -3, 0}, 24, 27, -25});
}

const scene scene_bending = {
    .name = "Bending",
    .summary = "The free corner of a frame of five links swings about the diagonal.",
    .picture_frame = 60,
    .build = bending_build,
};
