/* A long ribbon, wound like a spring, is let down to the floor, where it lies coil beside coil. Its faces look every
   way, so no cone of normals tells that they do not meet. */

#include "cloth_parts.h"
#include "scenes/scenes.h"

#include <math.h>

static const float ribbon_turns = 7, ribbon_outer = 1.3f, ribbon_inner = 0.35f, ribbon_rise = 0.4f; /* m per turn */
static const float ribbon_width = 0.3f, ribbon_bottom = 0.03f;

static pli_vec3 ribbon_place(float u, float v) {
    const float turn = ribbon_turns * v, angle = 6.2831853f * turn;
    const float height = ribbon_bottom + ribbon_rise * turn + ribbon_width * u;
    const float radius = ribbon_outer + (ribbon_inner - ribbon_outer) * v;
    return pli_vec3_make(radius * cosf(angle), height, radius * sinf(angle));
}

static void ribbon_build(scene_builder* builder) {
    cloth_part_floor(builder);
    const float top = ribbon_bottom + ribbon_rise * ribbon_turns + ribbon_width;
    const int holder = cloth_part_kinematic(builder, "holder", scene_box(pli_vec3_make(0.12f, 0.04f, 0.12f)),
                                            pli_vec3_make(ribbon_inner, top + 0.04f, 0));
    const cloth_part part = {
        .resolution = scene_get_resolution(builder, 6, 480), .place = ribbon_place, .mass = 1.2f, .bending = 1};
    const float length = ribbon_turns * 3.1415927f * (ribbon_outer + ribbon_inner);
    const float spacing =
        fminf(length / (float)(part.resolution.rows - 1), ribbon_width / (float)(part.resolution.columns - 1));
    scene_soft_def def = cloth_part_def("ribbon", spacing);
    const int ribbon = scene_add_soft(builder, cloth_part_mesh(builder, &part), &def);
    cloth_part_anchor_row(builder, ribbon, part.resolution, part.resolution.rows - 1, holder);
    const float fall = top - ribbon_width - 0.05f, speed = 0.6f;
    scene_move_rigid(builder, holder, 30, 30 + (int)(60 * fall / speed), pli_vec3_make(0, -speed, 0),
                     pli_vec3_make(0, 0, 0));
    scene_set_camera(builder, (scene_camera){{0, 0.9f, 0}, 6, 30, -18});
}

const scene scene_ribbon = {
    .name = "Ribbon",
    .summary = "A long ribbon is let down to the floor, where it lies coil beside coil.",
    .takes_resolution = true,
    .is_own = true,
    .solver = SCENE_SOLVER_XPBD,
    .picture_frame = 300,
    .build = ribbon_build,
};
