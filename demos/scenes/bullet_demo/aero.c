/* Sheets in air: falling flyers (demo 12, Init_Aero) and flags in the wind (demo 13, Init_Aero2). */

#include "parts.h"
#include "scenes/scenes.h"

#include <pliant/bullet_reference.h>

static const float pi = 3.1415927f;

/* A small generator of our own: the scene is the same on every machine. Values in [-1, 1). */
static float aero_random(uint32_t* state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * (2.0f / 16777216.0f) - 1.0f;
}

static pli_vec3 aero_random_direction(uint32_t* state) {
    const float x = aero_random(state), y = aero_random(state), z = aero_random(state);
    const pli_vec3 v = pli_vec3_make(x, y, z);
    const float length = pli_vec3_length(v);
    return length > 0.0f ? pli_vec3_scale(v, 1.0f / length) : pli_vec3_make(1, 0, 0);
}

static void aero_flyers_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "flyer";
    def.aero.model = PLI_AERO_VERTEX_TWO_SIDED;
    def.aero.lift = 0.004f;
    def.aero.drag = 0.0003f;
    uint32_t random = 1;
    for (int i = 0; i < 50; ++i) {
        pli_mesh* mesh = part_sheet(builder, pli_vec3_make(0, 10, 0), 2, 6, 0);
        part_add_bending(builder, mesh, 1);
        const pli_vec3 tilt = pli_vec3_scale(aero_random_direction(&random), 0.1f);
        const pli_vec3 offset = pli_vec3_scale(aero_random_direction(&random), 15);
        const pli_quat rotation = pli_quat_from_yaw_pitch_roll(pi / 8 + tilt.x, -pi / 7 + tilt.y, tilt.z);
        const pli_vec3 origin = pli_vec3_add(offset, pli_vec3_make(0, 20, 80));
        scene_check(builder, pli_mesh_transform(mesh, pli_transform_make(rotation, origin)));
        scene_check(builder, pli_mesh_set_total_mass(mesh, 0.1f));
        const int flyer = scene_add_soft(builder, mesh, &def);
        scene_add_first_force(builder, flyer, 0, pli_vec3_make(0, 2, 0));
    }
}

static const pli_vec3 aero_wind = {4, -12, -25};

/* Turned about the vertical. */
static void aero_turn_wind(scene_run* run, float degrees) {
    const pli_quat turn = pli_quat_from_yaw_pitch_roll(degrees * pi / 180, 0, 0);
    scene_run_set_wind(run, -1, pli_mat3_mul_vec3(pli_mat3_from_quat(turn), aero_wind));
}

static void aero_flags_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "flag";
    def.collision_margin = 0.5f;
    def.solver.position_iterations = 2;
    def.aero.model = PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG;
    def.aero.lift = 0.05f;
    def.aero.drag = 0.01f;
    def.aero.wind = aero_wind;
    const pli_quat upright = {sinf(pi / 4), 0, 0, cosf(pi / 4)};
    for (int i = 0; i < 5; ++i) {
        pli_patch_def sheet = pli_patch_def_default();
        sheet.corner_00 = pli_vec3_make(-5, 0, -15), sheet.corner_10 = pli_vec3_make(5, 0, -15);
        sheet.corner_01 = pli_vec3_make(-5, 0, 5), sheet.corner_11 = pli_vec3_make(5, 0, 5);
        sheet.columns = 10, sheet.rows = 30;
        sheet.pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10;
        sheet.diagonals = true;
        pli_mesh* mesh = NULL;
        scene_check(builder, pli_mesh_create_patch(scene_context(builder), &sheet, &mesh));
        part_add_bending(builder, mesh, 0.0004f);
        const pli_vec3 origin = pli_vec3_make(-39.5f + 10.5f * (float)i, 0, 0);
        scene_check(builder, pli_mesh_transform(mesh, pli_transform_make(upright, origin)));
        scene_check(builder, pli_mesh_set_total_mass(mesh, 2));
        scene_check(builder, pli_mesh_interleave_links(mesh));
        scene_add_soft(builder, mesh, &def);
    }
    const scene_control wind = {.name = "wind direction (degrees)",
                                .low = -180,
                                .high = 180,
                                .keys = SCENE_KEYS_LEFT_RIGHT,
                                .apply = aero_turn_wind};
    scene_add_control(builder, &wind);
    scene_set_camera(builder, (scene_camera){{-18, 4, -6}, 66, 20, -14});
}

const scene scene_aero = {
    .name = "Aero",
    .summary = "Fifty sheets of 0.1 kg glide down.",
    .picture_frame = 90,
    .build = aero_flyers_build,
};

const scene scene_aero2 = {
    .name = "Aero2",
    .summary = "Five flags in the wind.",
    .picture_frame = 120,
    .build = aero_flags_build,
};
