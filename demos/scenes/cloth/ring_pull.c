/* A sheet is pulled through a ring by its middle. */

#include "cloth_parts.h"
#include "scenes/scenes.h"

#include <math.h>

static const float ring_sheet = 4, ring_height = 4, ring_radius = 0.6f, ring_thickness = 0.1f; /* m */

enum { RING_AROUND = 48, RING_ACROSS = 16 };

static pli_vec3 ring_place(float u, float v) {
    return pli_vec3_make(ring_sheet * (u - 0.5f), ring_height + ring_thickness + 0.15f, ring_sheet * (v - 0.5f));
}

/* A torus around the y axis. */
static int ring_add(scene_builder* builder) {
    pli_vec3 points[RING_AROUND * RING_ACROSS];
    int triangles[RING_AROUND * RING_ACROSS * 6];
    int* next = triangles;
    for (int i = 0; i < RING_AROUND; ++i) {
        const float a = 6.2831853f * (float)i / RING_AROUND;
        for (int k = 0; k < RING_ACROSS; ++k) {
            const float b = 6.2831853f * (float)k / RING_ACROSS, radius = ring_radius + ring_thickness * cosf(b);
            const int here = i * RING_ACROSS + k, right = (i + 1) % RING_AROUND * RING_ACROSS + k;
            const int turn = (k + 1) % RING_ACROSS - k;
            points[here] = pli_vec3_make(radius * cosf(a), ring_thickness * sinf(b), radius * sinf(a));
            const int corners[6] = {here, here + turn, right, here + turn, right + turn, right};
            for (int c = 0; c < 6; ++c) {
                *next++ = corners[c];
            }
        }
    }
    scene_rigid_def def = scene_rigid_def_default();
    def.name = "ring";
    def.shape.kind = SCENE_SHAPE_TRIANGLE_MESH;
    def.shape.is_solid = true;
    def.shape.points = points;
    def.shape.point_count = RING_AROUND * RING_ACROSS;
    def.shape.triangles = triangles;
    def.shape.triangle_count = RING_AROUND * RING_ACROSS * 2;
    def.shape.margin = 0.02f;
    def.pose.origin = pli_vec3_make(0, ring_height, 0);
    def.friction = 0.05f; /* polished */
    return scene_add_rigid(builder, &def);
}

static void ring_pull_build(scene_builder* builder) {
    cloth_part_floor(builder);
    ring_add(builder);
    const int hook = cloth_part_kinematic(builder, "hook", scene_sphere(0.08f),
                                          pli_vec3_make(0, ring_height + ring_thickness + 0.07f, 0));
    scene_move_rigid(builder, hook, 30, 270, pli_vec3_make(0, -0.9f, 0), pli_vec3_make(0, 0, 0));
    const cloth_part part = {
        .resolution = scene_get_resolution(builder, 61, 61), .place = ring_place, .mass = 3, .bending = 0.02f};
    scene_soft_def def = cloth_part_def("cloth", ring_sheet / (float)(part.resolution.columns - 1));
    def.self_friction = 0.02f;
    const int cloth = scene_add_soft(builder, cloth_part_mesh(builder, &part), &def);
    const int column = part.resolution.columns / 2, row = part.resolution.rows / 2;
    for (int i = 0; i < 4; ++i) {
        const int node = (row - (i >> 1)) * part.resolution.columns + column - (i & 1);
        scene_add_anchor(builder, cloth, node, hook, true, 1);
    }
    scene_set_camera(builder, (scene_camera){{0, 3, 0}, 10, 25, -10});
}

const scene scene_ring_pull = {
    .name = "RingPull",
    .summary = "A sheet is pulled through a ring by its middle.",
    .takes_resolution = true,
    .is_own = true,
    .solver = SCENE_SOLVER_XPBD,
    .substeps = 20,
    .picture_frame = 180,
    .build = ring_pull_build,
};
