/* A field of elastic sticks with a ball on it (demo 6, Init_Sticks). */

#include "parts.h"
#include "scenes/scenes.h"

static void sticks_build(scene_builder* builder) {
    part_ground(builder);
    const float inverse_count = 1.0f / 15.0f;
    scene_soft_def def = scene_soft_def_default();
    def.name = "stick";
    def.solver.velocity_damping = 0.005f;
    def.rigid_contacts.dynamic_hardness = 0.1f;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            const pli_vec3 foot =
                pli_vec3_make(-5 + 10 * (float)x * inverse_count, -10, -5 + 10 * (float)y * inverse_count);
            const pli_vec3 top = pli_vec3_add(foot, pli_vec3_make(4 * 0.001f, 4, 0));
            pli_mesh* mesh = part_rope(builder, foot, top, 4, PLI_ROPE_PIN_FIRST);
            for (int distance = 2; distance <= 4; ++distance) {
                scene_check(builder, pli_mesh_append_bending_links(mesh, distance, 0, NULL));
            }
            scene_check(builder, pli_mesh_set_node_mass(mesh, 1, 0));
            scene_check(builder, pli_mesh_set_total_mass(mesh, 0.01f));
            scene_add_soft(builder, mesh, &def);
        }
    }
    part_big_ball(builder);
    scene_set_camera(builder, (scene_camera){{0, -6, 0}, 24, 27, -26});
}

const scene scene_sticks = {
    .name = "Sticks",
    .summary = "A ball falls into a field of elastic sticks.",
    .picture_frame = 130,
    .build = sticks_build,
};
