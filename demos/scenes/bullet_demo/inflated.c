/* A closed skin that rolls down a stair: with gas inside (demo 1, Init_Pressure) and with a volume to keep (demo 2,
   Init_Volume). */

#include "parts.h"
#include "scenes/scenes.h"

static pli_mesh* inflated_skin(scene_builder* builder, float linear_stiffness, float mass) {
    pli_mesh* mesh = scene_triangle_mesh(builder, "ball");
    scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(3, 3, 3)));
    scene_check(builder, pli_mesh_translate(mesh, pli_vec3_make(35, 25, 0)));
    part_set_stiffness(builder, mesh, linear_stiffness);
    scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, mass));
    return mesh;
}

static void inflated_surroundings(scene_builder* builder) {
    part_plate(builder, 15, 4);
    part_stair(builder, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 1, 5), 10);
    scene_set_camera(builder, (scene_camera){{18, 10, 0}, 56, 27, -20});
}

static void pressure_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "balloon";
    def.rigid_contacts.friction = 1;
    def.solver.velocity_damping = 0.001f;
    def.pressure = 2500;
    scene_add_soft(builder, inflated_skin(builder, 0.1f, 30), &def);
    inflated_surroundings(builder);
}

static void volume_build(scene_builder* builder) {
    part_ground(builder);
    scene_soft_def def = scene_soft_def_default();
    def.name = "bag";
    def.volume_conservation = 20;
    scene_add_soft(builder, inflated_skin(builder, 0.45f, 50), &def);
    inflated_surroundings(builder);
}

const scene scene_pressure = {
    .name = "Pressure",
    .summary = "A balloon full of gas falls on a stair.",
    .takes_mesh = true,
    .picture_frame = 230,
    .build = pressure_build,
};

const scene scene_volume = {
    .name = "Volume",
    .summary = "A skin that keeps its volume falls on a stair.",
    .takes_mesh = true,
    .picture_frame = 200,
    .build = volume_build,
};
