/* A sleeve on a cylinder that turns to and fro, while a cuff pushes the sleeve together. */

#include "cloth_parts.h"
#include "scenes/scenes.h"

#include <math.h>

static const float sleeve_length = 4, sleeve_radius = 0.75f, sleeve_height = 2, sleeve_arm = 0.55f;

static pli_vec3 sleeve_place(float u, float v) {
    const float angle = 6.2831853f * u;
    return pli_vec3_make(sleeve_length * (v - 0.5f), sleeve_height + sleeve_radius * sinf(angle),
                         sleeve_radius * cosf(angle));
}

static void sleeve_build(scene_builder* builder) {
    cloth_part_floor(builder);
    scene_shape cylinder = scene_box(pli_vec3_make(0.5f * sleeve_length + 0.4f, sleeve_arm, sleeve_arm));
    cylinder.kind = SCENE_SHAPE_CYLINDER;
    cylinder.axis = 0;
    const int arm = cloth_part_kinematic(builder, "arm", cylinder, pli_vec3_make(0, sleeve_height, 0));
    scene_shape disc = cylinder;
    disc.half_extents = pli_vec3_make(0.05f, sleeve_radius, sleeve_radius);
    const int cuff =
        cloth_part_kinematic(builder, "cuff", disc, pli_vec3_make(0.5f * sleeve_length + 0.05f, sleeve_height, 0));
    /* Bodies that anchors hold to do not collide with the sleeve, so the arm needs a band. */
    const int band =
        cloth_part_kinematic(builder, "band", disc, pli_vec3_make(-0.5f * sleeve_length - 0.05f, sleeve_height, 0));
    const int turning[2] = {arm, band};
    const pli_vec3 still = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < 2; ++i) {
        scene_move_rigid(builder, turning[i], 30, 150, still, pli_vec3_make(1.2f, 0, 0));
        scene_move_rigid(builder, turning[i], 150, 390, still, pli_vec3_make(-1.2f, 0, 0));
        scene_move_rigid(builder, turning[i], 390, 510, still, pli_vec3_make(1.2f, 0, 0));
    }
    scene_move_rigid(builder, cuff, 60, 300, pli_vec3_make(-0.3f, 0, 0), still);

    const cloth_part part = {.resolution = scene_get_resolution(builder, 64, 60),
                             .is_tube = true,
                             .place = sleeve_place,
                             .mass = 4,
                             .bending = 0.05f};
    const float around = 6.2831853f * sleeve_radius / (float)part.resolution.columns;
    scene_soft_def def = cloth_part_def("sleeve", fminf(around, sleeve_length / (float)(part.resolution.rows - 1)));
    const int sleeve = scene_add_soft(builder, cloth_part_mesh(builder, &part), &def);
    cloth_part_anchor_row(builder, sleeve, part.resolution, 0, band);
    cloth_part_anchor_row(builder, sleeve, part.resolution, part.resolution.rows - 1, cuff);
    scene_set_camera(builder, (scene_camera){{0, 2, 0}, 6, 25, -14});
}

const scene scene_sleeve = {
    .name = "Sleeve",
    .summary = "A cylinder turns to and fro in a sleeve that is pushed together.",
    .takes_resolution = true,
    .is_own = true,
    .solver = SCENE_SOLVER_XPBD,
    .picture_frame = 300,
    .build = sleeve_build,
};
