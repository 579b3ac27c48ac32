/* Sliding boxes of growing friction (demo 14, Init_Friction). */

#include "parts.h"
#include "scenes/scenes.h"

static pli_mesh* friction_box(scene_builder* builder, pli_vec3 center) {
    pli_vec3 corners[8];
    for (int i = 0; i < 8; ++i) {
        const pli_vec3 offset =
            pli_vec3_make((i & 1) != 0 ? 1.0f : -1.0f, (i & 2) != 0 ? 1.0f : -1.0f, (i & 4) != 0 ? 1.0f : -1.0f);
        corners[i] = pli_vec3_add(center, offset);
    }
    pli_mesh* mesh = NULL;
    scene_check(builder, pli_mesh_create_convex_hull(scene_context(builder), 8, corners, 0.001f, &mesh));
    scene_check(builder, pli_mesh_append_bending_links(mesh, 2, 0, NULL));
    return mesh;
}

static void friction_build(scene_builder* builder) {
    part_ground(builder);
    for (int i = 0; i < 20; ++i) {
        scene_soft_def def = scene_soft_def_default();
        def.name = "box";
        def.rigid_contacts.friction = (float)(0.1 * (double)((float)(i + 1) / 20.0f));
        pli_mesh* mesh = friction_box(builder, pli_vec3_make(-25 + (float)i * 2.5f, -8, 40));
        const int box = scene_add_soft(builder, mesh, &def);
        scene_set_velocity(builder, box, pli_vec3_make(0, 0, -10));
    }
    scene_set_camera(builder, (scene_camera){{0, -10, 14}, 48, 10, -34});
}

const scene scene_friction = {
    .name = "Friction",
    .summary = "Twenty soft boxes slide; friction grows from one to the next.",
    .picture_frame = 300,
    .build = friction_build,
};
