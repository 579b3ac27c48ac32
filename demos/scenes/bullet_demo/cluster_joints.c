/* Clusters held by joints: a ball and socket (demo 23, Init_ClusterSocket), a hinge (demo 24, Init_ClusterHinge), both
   with a motor (demo 25, Init_ClusterCombine) and three legs under a plate (demo 27, Init_ClusterRobot). */

#include "parts.h"
#include "scenes/scenes.h"

#include <math.h>

static pli_mesh* upright_torus(scene_builder* builder, pli_vec3 position, pli_vec3 scale, scene_soft_def* def) {
    return part_cluster_torus(builder, position, pli_quat_from_yaw_pitch_roll(half_pi, 0, half_pi), scale, def);
}

static void cluster_socket_build(scene_builder* builder) {
    part_wavy_ground(builder);
    scene_soft_def def;
    pli_mesh* mesh = upright_torus(builder, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 2, 2), &def);
    const int torus = scene_add_soft(builder, mesh, &def);
    const int plate = part_plate(builder, 50, 8);
    const scene_joint joint = scene_joint_to_rigid(torus, plate);
    scene_add_linear_joint(builder, &joint, pli_vec3_make(0, 5, 0));
    scene_set_camera(builder, (scene_camera){{0, -3, 0}, 28, 27, -20});
}

static void cluster_hinge_build(scene_builder* builder) {
    part_wavy_ground(builder);
    scene_soft_def def;
    pli_mesh* mesh = upright_torus(builder, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 2, 2), &def);
    const int torus = scene_add_soft(builder, mesh, &def);
    const int plate = part_plate(builder, 50, 8);
    const scene_angular_joint joint = {.ends = scene_joint_to_rigid(torus, plate), .axis = {0, 0, 1}};
    scene_add_angular_joint(builder, &joint);
    scene_set_camera(builder, (scene_camera){{0, -3, 0}, 28, 27, -20});
}

static void cluster_combine_build(scene_builder* builder) {
    part_wavy_ground(builder);
    int tori[2];
    for (int i = 0; i < 2; ++i) {
        scene_soft_def def;
        pli_mesh* mesh = upright_torus(builder, pli_vec3_make(0, 8, 10 * (float)i), pli_vec3_make(2, 4, 2), &def);
        def.solver.position_iterations = 1;
        def.cluster_matching = def.cluster_node_damping = 0.05f;
        tori[i] = scene_add_soft(builder, mesh, &def);
    }
    const scene_joint ends = scene_joint_to_soft(tori[0], tori[1]);
    const scene_angular_joint hinge = {.ends = ends, .axis = {0, 0, 1}, .is_driven = true};
    scene_add_angular_joint(builder, &hinge);
    scene_add_linear_joint(builder, &ends, pli_vec3_make(0, 8, 5));
    scene_drive_at(builder, 120, 1, 10, 0);
    scene_drive_at(builder, 240, -1, 10, 0);
    scene_drive_at(builder, 360, 0, 0, 0);
    scene_set_camera(builder, (scene_camera){{0, -4, 5}, 34, 60, -20});
}

static pli_vec3 center_of_mass(const pli_mesh* mesh) {
    const pli_mesh_view view = mesh != NULL ? pli_mesh_get_view(mesh) : (pli_mesh_view){0};
    pli_vec3 sum = {0, 0, 0};
    float mass = 0;
    for (int i = 0; i < view.node_count; ++i) {
        sum = pli_vec3_add(sum, pli_vec3_scale(view.positions[i], 1 / view.inverse_masses[i]));
        mass += 1 / view.inverse_masses[i];
    }
    return mass > 0 ? pli_vec3_scale(sum, 1 / mass) : sum;
}

static void cluster_robot_build(scene_builder* builder) {
    part_wavy_ground(builder);
    const pli_vec3 base = {0, 25, 8}, feet[3] = {{-8, 0, 0}, {8, 0, 0}, {0, 0, 8 * sqrtf(2)}};
    int balls[3];
    pli_vec3 centers[3], sum = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        pli_mesh* mesh = scene_triangle_mesh(builder, "ball");
        scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(3, 3, 3)));
        scene_check(builder, pli_mesh_translate(mesh, pli_vec3_add(base, feet[i])));
        part_set_stiffness(builder, mesh, 0.45f);
        scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 50));
        centers[i] = center_of_mass(mesh);
        sum = pli_vec3_add(sum, centers[i]);
        scene_soft_def def = scene_soft_def_default();
        def.name = "ball";
        def.volume_conservation = 20;
        def.has_clusters = true;
        def.cluster_count = 1;
        balls[i] = scene_add_soft(builder, mesh, &def);
    }
    scene_rigid_def platform = scene_rigid_def_default();
    platform.name = "platform";
    platform.shape = scene_box(pli_vec3_make(8, 1, 8));
    platform.shape.kind = SCENE_SHAPE_CYLINDER;
    platform.shape.axis = 1;
    platform.mass = 50;
    platform.pose.origin = pli_vec3_add(pli_vec3_scale(sum, 1.0f / 3.0f), pli_vec3_make(0, 5, 0));
    const int plate = scene_add_rigid(builder, &platform);
    for (int i = 0; i < 3; ++i) {
        scene_joint joint = scene_joint_to_rigid(balls[i], plate);
        joint.softness.error_reduction = 0.5f;
        scene_add_linear_joint(builder, &joint, centers[i]);
    }
    scene_rigid_def slope = scene_rigid_def_default();
    slope.name = "slope";
    slope.shape = scene_box(pli_vec3_make(20, 1, 40));
    slope.pose.rotation = pli_mat3_from_quat(pli_quat_from_yaw_pitch_roll(0, -half_pi / 2, 0));
    scene_add_rigid(builder, &slope);
    scene_set_camera(builder, (scene_camera){{0, 12, 6}, 60, 60, -16});
}

const scene scene_cluster_socket = {
    .name = "ClusterSocket",
    .summary = "A plate on a ball joint over a torus.",
    .takes_mesh = true,
    .picture_frame = 90,
    .build = cluster_socket_build,
};

const scene scene_cluster_hinge = {
    .name = "ClusterHinge",
    .summary = "A plate that turns about one axis with a torus.",
    .takes_mesh = true,
    .picture_frame = 90,
    .build = cluster_hinge_build,
};

const scene scene_cluster_combine = {
    .name = "ClusterCombine",
    .summary = "Two wheels on one axle, driven against each other.",
    .takes_mesh = true,
    .picture_frame = 200,
    .build = cluster_combine_build,
};

const scene scene_cluster_robot = {
    .name = "ClusterRobot",
    .summary = "A platform on three soft balls falls on a slope.",
    .takes_mesh = true,
    .picture_frame = 110,
    .build = cluster_robot_build,
};
