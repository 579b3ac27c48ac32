/* A sheet between two bars that turn against each other, two full turns. */

#include "cloth_parts.h"
#include "scenes/scenes.h"

static const float twisted_length = 4, twisted_width = 2.4f, twisted_height = 2.5f;

static pli_vec3 twisted_place(float u, float v) {
    return pli_vec3_make(twisted_length * (u - 0.5f), twisted_height, twisted_width * (v - 0.5f));
}

static void twisted_cloth_build(scene_builder* builder) {
    cloth_part_floor(builder);
    const pli_vec3 half_extents = pli_vec3_make(0.06f, 0.06f, 0.5f * twisted_width + 0.1f);
    int bars[2];
    for (int i = 0; i < 2; ++i) {
        const float side = i == 0 ? -1.0f : 1.0f;
        bars[i] = cloth_part_kinematic(builder, "bar", scene_box(half_extents),
                                       pli_vec3_make(side * (0.5f * twisted_length + 0.06f), twisted_height, 0));
        /* One turn each in 8 s, and nearer by what twisting takes of the length. */
        scene_move_rigid(builder, bars[i], 30, 510, pli_vec3_make(-side * 0.03f, 0, 0),
                         pli_vec3_make(side * 6.2831853f / 8, 0, 0));
    }
    const cloth_part part = {
        .resolution = scene_get_resolution(builder, 60, 36), .place = twisted_place, .mass = 2, .bending = 0.02f};
    scene_soft_def def = cloth_part_def("cloth", twisted_length / (float)(part.resolution.columns - 1));
    def.self_collision = SCENE_SELF_FACES;
    const int cloth = scene_add_soft(builder, cloth_part_mesh(builder, &part), &def);
    cloth_part_anchor_column(builder, cloth, part.resolution, 0, bars[0]);
    cloth_part_anchor_column(builder, cloth, part.resolution, part.resolution.columns - 1, bars[1]);
    scene_set_camera(builder, (scene_camera){{0, 2.2f, 0}, 6.5f, 20, -14});
}

const scene scene_twisted_cloth = {
    .name = "TwistedCloth",
    .summary = "Two bars turn against each other, two full turns, and twist the sheet between them.",
    .takes_resolution = true,
    .is_own = true,
    .solver = SCENE_SOLVER_XPBD,
    .picture_frame = 510,
    .build = twisted_cloth_build,
};
