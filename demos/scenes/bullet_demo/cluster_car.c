/* A bunny on four wheels, driven and steered by a script (demo 26, Init_ClusterCar). */

#include "parts.h"
#include "scenes/scenes.h"

#include <math.h>

static const pli_vec3 car_origin = {100, 80, 0};

/* From the frame of the car, which looks along +z, to the world. */
static pli_quat car_orientation(void) {
    return pli_quat_from_yaw_pitch_roll(-half_pi, 0, 0);
}

static void car_place(scene_builder* builder, pli_mesh* mesh) {
    scene_check(builder, pli_mesh_rotate(mesh, car_orientation()));
    scene_check(builder, pli_mesh_translate(mesh, car_origin));
}

static pli_vec3 car_direction(pli_vec3 local) {
    return pli_mat3_mul_vec3(pli_mat3_from_quat(car_orientation()), local);
}

static int car_add_body(scene_builder* builder) {
    pli_mesh* mesh = scene_triangle_mesh(builder, "bunny");
    part_add_bending(builder, mesh, 1);
    scene_check(builder, pli_mesh_shuffle_links(mesh));
    scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(8, 8, 8)));
    scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 150));
    car_place(builder, mesh);
    scene_soft_def def = part_cluster_def("bunny", 1, 1);
    def.solver.position_iterations = 2;
    return scene_add_soft(builder, mesh, &def);
}

static int car_add_wheel(scene_builder* builder, pli_vec3 place, float width) {
    scene_soft_def def;
    pli_mesh* mesh = part_cluster_torus(builder, place, pli_quat_from_yaw_pitch_roll(0, 0, half_pi),
                                        pli_vec3_make(2, width, 2), &def);
    car_place(builder, mesh);
    def.name = "wheel";
    def.solver.position_iterations = 1;
    def.cluster_matching = def.cluster_node_damping = 0.05f;
    return scene_add_soft(builder, mesh, &def);
}

/* Forwards; the wheels turn freely when the car is not driven. */
static void car_drive(scene_run* run, float value) {
    scene_run_drive(run, -value, fabsf(value) > 0.0f ? 10.0f : 0.0f);
}

static void car_add_controls(scene_builder* builder) {
    const scene_control drive = {.name = "drive (rad/s)",
                                 .low = -3,
                                 .high = 3,
                                 .keys = SCENE_KEYS_UP_DOWN,
                                 .springs_back = true,
                                 .apply = car_drive};
    const scene_control steer = {.name = "steer (rad)",
                                 .low = -0.6f,
                                 .high = 0.6f,
                                 .keys = SCENE_KEYS_LEFT_RIGHT,
                                 .springs_back = true,
                                 .apply = scene_run_steer};
    scene_add_control(builder, &drive);
    scene_add_control(builder, &steer);
}

static void cluster_car_build(scene_builder* builder) {
    part_wavy_ground(builder);
    const pli_vec3 places[4] = {{8, -4, 8}, {-8, -4, 8}, {9, -4, -8}, {-9, -4, -8}}; /* the front ones first */
    const int body = car_add_body(builder);
    scene_joint joints[4];
    for (int i = 0; i < 4; ++i) {
        joints[i] = scene_joint_to_soft(body, car_add_wheel(builder, places[i], i < 2 ? 4 : 5));
    }
    for (int i = 0; i < 4; ++i) {
        scene_add_linear_joint(builder, &joints[i], pli_vec3_add(car_direction(places[i]), car_origin));
    }
    for (int i = 0; i < 4; ++i) {
        scene_angular_joint axle = {
            .ends = joints[i], .axis = car_direction(pli_vec3_make(1, 0, 0)), .is_driven = true};
        if (i < 2) { axle.side = car_direction(pli_vec3_make(0, 0, 1)); }
        scene_add_angular_joint(builder, &axle);
    }
    part_stair(builder, pli_vec3_make(0, -8, 0), pli_vec3_make(3, 2, 40), 20);
    part_falling_stack(builder, 50);
    /* It lands on the stair, drives down, and turns left and right. */
    scene_drive_at(builder, 90, 1, 10, 0);
    scene_drive_at(builder, 240, 1, 10, 0.3f);
    scene_drive_at(builder, 330, 1, 10, -0.3f);
    scene_drive_at(builder, 450, 0, 0, 0);
    car_add_controls(builder);
    scene_set_camera(builder, (scene_camera){{92, 68, 0}, 56, 27, -18});
}

const scene scene_cluster_car = {
    .name = "ClusterCar",
    .summary = "A bunny on four wheels drives down a stair.",
    .takes_mesh = true,
    .picture_frame = 150,
    .build = cluster_car_build,
};
