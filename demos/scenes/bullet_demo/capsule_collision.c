/* A light sheet on a fixed capsule (demo 7, Init_CapsuleCollision). */

#include "parts.h"
#include "scenes/scenes.h"

static void capsule_collision_build(scene_builder* builder) {
    part_ground(builder);
    scene_rigid_def capsule = scene_rigid_def_default();
    capsule.name = "capsule";
    capsule.shape.kind = SCENE_SHAPE_CAPSULE;
    capsule.shape.radius = 1;
    capsule.shape.half_height = 2.5f;
    capsule.shape.axis = 0;
    capsule.pose.origin = pli_vec3_make(0, 4, 0);
    capsule.friction = 0.8f;
    scene_add_rigid(builder, &capsule);

    pli_mesh* mesh = part_sheet(builder, pli_vec3_make(0, 6, 0), 4, 20, 0);
    scene_check(builder, pli_mesh_set_total_mass(mesh, 0.1f));
    scene_soft_def def = scene_soft_def_default();
    def.name = "cloth";
    def.solver.position_iterations = 10;
    def.solver.drift_iterations = 10;
    scene_add_soft(builder, mesh, &def);
    scene_set_camera(builder, (scene_camera){{0, 3.5f, 0}, 15, 27, -20});
}

const scene scene_capsule_collision = {
    .name = "CapsuleCollision",
    .summary = "A sheet falls on a capsule and hangs over it.",
    .picture_frame = 90,
    .build = capsule_collision_build,
};
