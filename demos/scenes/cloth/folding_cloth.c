/* A sheet that falls in folds onto a ball. */

#include "cloth_parts.h"
#include "scenes/scenes.h"

#include <math.h>

static const float folding_size = 4; /* m */

/* On edge, a little crumpled so that it has somewhere to fold to. */
static pli_vec3 folding_place(float u, float v) {
    const float x = folding_size * (u - 0.5f), y = folding_size * v;
    return pli_vec3_make(x, 2.0f + y, 0.06f * sinf(3.0f * y + 1.5f * x) + 0.1f * v);
}

static void folding_cloth_build(scene_builder* builder) {
    cloth_part_floor(builder);
    scene_rigid_def ball = scene_rigid_def_default();
    ball.name = "ball";
    ball.shape = scene_sphere(0.8f);
    ball.pose.origin = pli_vec3_make(0, 0.8f, 0);
    scene_add_rigid(builder, &ball);

    const cloth_part part = {
        .resolution = scene_get_resolution(builder, 60, 60), .place = folding_place, .mass = 3, .bending = 0.02f};
    scene_soft_def def = cloth_part_def("cloth", folding_size / (float)(part.resolution.columns - 1));
    scene_add_soft(builder, cloth_part_mesh(builder, &part), &def);
    scene_set_camera(builder, (scene_camera){{0, 1, 0}, 6.5f, 30, -20});
}

const scene scene_folding_cloth = {
    .name = "FoldingCloth",
    .summary = "A sheet falls in folds onto a ball.",
    .takes_resolution = true,
    .is_own = true,
    .solver = SCENE_SOLVER_XPBD,
    .picture_frame = 180,
    .build = folding_cloth_build,
};
