/* A flag in gusts of wind whose direction the user turns; by itself it turns by 150 degrees. */

#include "cloth_parts.h"
#include "scenes/scenes.h"

#include <math.h>

static const float flag_height = 2.4f, flag_length = 3.6f, flag_top = 5.0f;
static const float flag_wind = 6; /* m/s */

enum { FLAG_SCRIPT_END = 1200 };

static pli_vec3 flag_place(float u, float v) {
    return pli_vec3_make(u * flag_length, flag_top - v * flag_height, 0.15f * u * sinf(7 * u + 2 * v));
}

static void flag_turn_wind(scene_run* run, float degrees) {
    const float angle = degrees * (3.1415927f / 180);
    scene_run_set_wind(run, 0, pli_vec3_make(flag_wind * cosf(angle), 0, -flag_wind * sinf(angle)));
}

static void flag_build(scene_builder* builder) {
    cloth_part_floor(builder);
    scene_rigid_def pole = scene_rigid_def_default();
    pole.name = "pole";
    pole.shape = scene_box(pli_vec3_make(0.06f, 0.5f * (flag_top + 0.2f), 0.06f));
    pole.shape.kind = SCENE_SHAPE_CYLINDER;
    pole.shape.axis = 1;
    pole.pose.origin = pli_vec3_make(-0.1f, 0.5f * (flag_top + 0.2f), 0);
    scene_add_rigid(builder, &pole);

    const cloth_part part = {
        .resolution = scene_get_resolution(builder, 60, 40), .place = flag_place, .mass = 2, .bending = 0.02f};
    pli_mesh* mesh = cloth_part_mesh(builder, &part);
    for (int r = 0; r < part.resolution.rows; ++r) {
        scene_check(builder, pli_mesh_set_node_mass(mesh, r * part.resolution.columns, 0));
    }
    scene_soft_def def = cloth_part_def("flag", flag_length / (float)(part.resolution.columns - 1));
    def.aero.model = PLI_AERO_VERTEX_TWO_SIDED;
    def.aero.lift = 0.1f;
    def.aero.drag = 0.02f;
    def.aero.wind = pli_vec3_make(flag_wind, 0, 0);
    scene_add_soft(builder, mesh, &def);

    const scene_control wind = {"wind direction (degrees)", -180, 180, 0, SCENE_KEYS_LEFT_RIGHT, false, flag_turn_wind};
    const int control = scene_add_control(builder, &wind);
    for (int frame = 3; frame < FLAG_SCRIPT_END; frame += 3) {
        const float turned = 150 * fminf(1, fmaxf(0, (float)(frame - 240) / 240));
        scene_set_control_at(builder, frame, control, turned + 18 * sinf(0.11f * (float)frame));
    }
    scene_set_camera(builder, (scene_camera){{0.8f, 3.1f, 0}, 11, 20, -8});
}

const scene scene_flag = {
    .name = "Flag",
    .summary = "A flag in the wind, whose direction is a control.",
    .takes_resolution = true,
    .is_own = true,
    .solver = SCENE_SOLVER_XPBD,
    .picture_frame = 240,
    .build = flag_build,
};
