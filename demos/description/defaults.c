/* The defaults of scene descriptions: those of Bullet's demos. */

#include "scene_builder.h"

scene_shape scene_box(pli_vec3 half_extents) {
    return (scene_shape){.kind = SCENE_SHAPE_BOX, .half_extents = half_extents, .margin = -1.0f};
}

scene_shape scene_sphere(float radius) {
    return (scene_shape){.kind = SCENE_SHAPE_SPHERE, .radius = radius, .margin = -1.0f};
}

scene_rigid_def scene_rigid_def_default(void) {
    return (scene_rigid_def){
        .name = "rigid",
        .shape = scene_sphere(1),
        .pose = pli_transform_identity(),
        .friction = 0.5f,
    };
}

scene_rigid_def scene_rigid_box(const char* name, pli_vec3 half_extents, float mass, pli_vec3 center) {
    scene_rigid_def def = scene_rigid_def_default();
    def.name = name;
    def.shape = scene_box(half_extents);
    def.mass = mass;
    def.pose.origin = center;
    return def;
}

scene_soft_def scene_soft_def_default(void) {
    pli_solver_settings solver = pli_body_def_default().solver;
    solver.position_iterations = 1;
    return (scene_soft_def){
        .name = "soft",
        .collision_margin = 0.25f, /* Bullet's: scenes are the same on btSoftBody */
        .solver = solver,
        .rigid_contacts = pli_rigid_contacts_def_default(),
        .has_rigid_contacts = true,
        .soft_contacts = pli_soft_contacts_def_default(),
        .anchor_hardness = 0.7f,
        .aero = pli_aero_def_default(),
        .cluster_contacts = pli_cluster_contacts_def_default(),
        .self_friction = pli_self_collision_def_default().friction,
    };
}

scene_joint scene_joint_to_soft(int soft, int other_soft) {
    return (scene_joint){soft, other_soft, -1, pli_linear_joint_def_default().softness};
}

scene_joint scene_joint_to_rigid(int soft, int rigid) {
    return (scene_joint){soft, -1, rigid, pli_linear_joint_def_default().softness};
}
