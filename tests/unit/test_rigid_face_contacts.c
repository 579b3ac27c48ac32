/* Contacts of faces with convex rigid bodies: nothing small or fast passes a coarse cloth, momentum balances, contacts
   that are not needed do nothing, ropes, life of contacts, errors. */

#include "check.h"

#include "level_sheet.h"
#include "pierced.h"
#include "world_fixture.h"

#include <pliant/anchor.h>
#include <pliant/contact.h>
#include <pliant/cut.h>
#include <pliant/generate.h>
#include <pliant/implicit.h>
#include <pliant/world.h>
#include <pliant/xpbd.h>

#include <stdlib.h>

static const pli_vec3 gravity = {0, -10, 0};

/* 1 m x 1 m in cells of 10 cm, 0.2 kg, at y = 0. */
static pli_body* make_cloth(pli_world* world, int pins, float margin, int iterations) {
    pli_context* context = pli_world_get_context(world);
    pli_patch_def sheet = level_sheet(0.5f, 0, 11);
    sheet.pins = pins;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &sheet, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass_from_faces(mesh, 0.2f), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = iterations;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static void enable_faces(pli_body* body) {
    const pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_face_contacts(body, &faces), PLI_OK);
}
static void enable_nodes(pli_body* body) {
    const pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_contacts(body, &nodes), PLI_OK);
}

/* Takes over the shape. `inertia` is diagonal, in the frame of the body. */
static pli_rigid* make_rigid(pli_world* world, pli_shape* shape, float mass, pli_vec3 inertia, pli_transform pose,
                             pli_vec3 velocity) {
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 1;
    def.shapes = &shape;
    def.state.pose = pose;
    if (mass > 0) {
        def.kind = PLI_RIGID_DYNAMIC;
        def.state.inverse_mass = 1 / mass;
        def.state.linear_velocity = velocity;
        const pli_mat3 local = {{{1 / inertia.x, 0, 0}, {0, 1 / inertia.y, 0}, {0, 0, 1 / inertia.z}}};
        def.state.inverse_inertia_world =
            pli_mat3_mul(pli_mat3_mul(pose.rotation, local), pli_mat3_transpose(pose.rotation));
    }
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
    return rigid;
}

static pli_transform at(float x, float y, float z) {
    pli_transform pose = pli_transform_identity();
    pose.origin = pli_vec3_make(x, y, z);
    return pose;
}

static pli_rigid* make_ball(pli_world* world, float radius, float mass, pli_vec3 position, pli_vec3 velocity) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_sphere(pli_world_get_context(world), radius, &shape), PLI_OK);
    const float i = 0.4f * mass * radius * radius;
    return make_rigid(world, shape, mass, pli_vec3_make(i, i, i), at(position.x, position.y, position.z), velocity);
}

static pli_shape* make_box_mesh(pli_context* context, float half) {
    pli_vec3 points[8];
    for (int i = 0; i < 8; ++i) {
        points[i] =
            pli_vec3_make((i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half);
    }
    static const int triangles[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                      2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, 8, points, 12, triangles, 0.05f, &shape), PLI_OK);
    return shape;
}

/* Square of 4 m in cells of 0.25 m, facing up, with its middle point at `peak`. */
static pli_shape* make_floor(pli_context* context, float peak) {
    enum { SIDE = 17 };
    pli_vec3 points[SIDE * SIDE];
    int triangles[6 * (SIDE - 1) * (SIDE - 1)], count = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        points[i] = pli_vec3_make(0.25f * (float)(i % SIDE) - 2, 0, 0.25f * (float)(i / SIDE) - 2);
    }
    points[SIDE * SIDE / 2].y = peak;
    for (int i = 0; i < SIDE * (SIDE - 1); ++i) {
        if (i % SIDE == SIDE - 1) { continue; }
        const int cell[6] = {i, i + SIDE, i + 1, i + 1, i + SIDE, i + SIDE + 1};
        memcpy(&triangles[count], cell, sizeof cell);
        count += 6;
    }
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, SIDE * SIDE, points, count / 3, triangles, 0.1f, &shape),
                     PLI_OK);
    return shape;
}

typedef enum box_side { CORNER_DOWN, EDGE_DOWN, FLAT, ASKEW, BOX_SIDES } box_side;

static pli_mat3 rotation_of(box_side side) {
    const float a = 1 / sqrtf(3), b = 1 / sqrtf(2);
    const pli_vec3 x[BOX_SIDES] = {{b, -b, 0}, {b, -b, 0}, {1, 0, 0}, {0.8f, -0.6f, 0}};
    const pli_vec3 y[BOX_SIDES] = {{-a, -a, -a}, {b, b, 0}, {0, 1, 0}, {0.36f, 0.48f, 0.8f}};
    return (pli_mat3){{x[side], y[side], pli_vec3_cross(x[side], y[side])}};
}

static pli_rigid* make_turned_box(pli_world* world, box_side side, float half, float mass, pli_vec3 position) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_box(pli_world_get_context(world), pli_vec3_make(half, half, half), &shape),
                     PLI_OK);
    pli_transform pose = at(position.x, position.y, position.z);
    pose.rotation = rotation_of(side);
    const float i = mass * half * half * 2 / 3;
    return make_rigid(world, shape, mass, pli_vec3_make(i, i, i), pose, pli_vec3_make(0, 0, 0));
}

static pli_rigid* make_box(pli_world* world, float half, float mass, pli_vec3 position) {
    return make_turned_box(world, CORNER_DOWN, half, mass, position);
}

/* A rod of 30 cm along x. */
static pli_rigid* make_stick(pli_world* world, float mass, pli_vec3 position, pli_vec3 velocity) {
    const float radius = 0.005f;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_capsule(pli_world_get_context(world), pli_vec3_make(0.15f, 0, 0), radius, &shape),
                     PLI_OK);
    const float across = mass * 0.09f / 12, along = mass * radius * radius / 2;
    return make_rigid(world, shape, mass, pli_vec3_make(along, across, across), at(position.x, position.y, position.z),
                      velocity);
}

/* Steps in which the centre of the body went through the cloth. */
static int run(pli_world* world, pli_body* cloth, pli_rigid* rigid, float seconds, float dt) {
    int count = 0;
    const int steps = (int)(seconds / dt + 0.5f);
    for (int i = 0; i < steps; ++i) {
        const pierced_moment before = pierced_look(cloth, pli_rigid_get_state(rigid).pose.origin);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_rigid_integrate(rigid, gravity, dt), PLI_OK);
        const pierced_moment after = pierced_look(cloth, pli_rigid_get_state(rigid).pose.origin);
        count += pierced_face(cloth, &before, &after) != PLI_NULL_INDEX;
    }
    assert_false(pli_body_is_frozen(cloth));
    return count;
}

// ------------------------------------------------------------------------------------------------- nothing passes

/* Middle of a face, edge, near a node, edge of two cells. */
static const float spots[4][2] = {{0.03f, 0.02f}, {0.0f, 0.05f}, {0.003f, 0.002f}, {0.05f, 0.05f}};

static int shoot_ball(fixture* f, float radius, float mass, const float* spot, float height, float dt, int iterations,
                      bool with_faces, bool with_nodes) {
    const float margin = 0.005f;
    pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, margin, iterations);
    if (with_nodes) { enable_nodes(cloth); }
    if (with_faces) { enable_faces(cloth); }
    pli_rigid* ball = make_ball(f->world, radius, mass, pli_vec3_make(spot[0], radius + margin + height, spot[1]),
                                pli_vec3_make(0, -5, 0));
    const int count = run(f->world, cloth, ball, 0.7f, dt);
    pli_rigid_destroy(ball);
    pli_body_destroy(cloth);
    return count;
}

/* Balls of 2 and 4 cm diameter at 5 m/s: 8 cm in a step of 1/60 s. */
static void test_balls_do_not_pass_a_coarse_cloth(void** state) {
    fixture* f = *state;
    for (int c = 0; c < 64; ++c) {
        const float radius = (c & 1) != 0 ? 0.02f : 0.01f;
        const float mass = (c & 2) != 0 ? 1 : 0.001f;
        const float dt = 1.0f / ((c & 4) != 0 ? 120 : 60);
        const int iterations = (c & 8) != 0 ? 10 : 1;
        const int passed = shoot_ball(f, radius, mass, spots[c >> 4], 0.03f + 0.007f * (float)(c % 5), dt, iterations,
                                      true, c % 3 == 0);
        if (passed != 0) { fail_msg("case %d: the ball passed", c); }
    }
}

/* What the feature is for: node contacts alone let the same balls through. */
static void test_balls_pass_without_face_contacts(void** state) {
    fixture* f = *state;
    for (int spot = 0; spot < 2; ++spot) {
        assert_int_not_equal(shoot_ball(f, 0.01f, 0.001f, spots[spot], 0.03f, 1.0f / 60, 10, false, true), 0);
        assert_int_not_equal(shoot_ball(f, 0.02f, 1, spots[spot], 0.03f, 1.0f / 60, 10, false, true), 0);
    }
}

/* A cube of 10 cm falls 1 m, a corner first; a rod falls flat. */
static void test_boxes_and_sticks_do_not_pass_a_coarse_cloth(void** state) {
    fixture* f = *state;
    for (int c = 0; c < 32; ++c) {
        const float* spot = spots[c >> 3];
        const float dt = 1.0f / ((c & 1) != 0 ? 120 : 60);
        const bool is_box = (c & 4) == 0;
        const float mass = (c & 2) != 0 ? 0.2f : is_box ? 0.05f : 0.01f;
        pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.005f, 10);
        enable_nodes(cloth);
        enable_faces(cloth);
        pli_rigid* rigid =
            is_box ? make_box(f->world, 0.05f, mass, pli_vec3_make(spot[0], 1.09f, spot[1]))
                   : make_stick(f->world, mass, pli_vec3_make(spot[0], 0.04f, spot[1]), pli_vec3_make(0, -3, 0));
        const int passed = run(f->world, cloth, rigid, 0.9f, dt);
        if (passed != 0) { fail_msg("case %d: it passed", c); }
        pli_rigid_destroy(rigid);
        pli_body_destroy(cloth);
    }
}

static void pin_rim(pli_body* cloth) {
    for (int i = 0; i < 121; ++i) {
        const int row = i / 11, column = i % 11;
        if (row % 10 == 0 || column % 10 == 0) { assert_int_equal(pli_body_set_node_mass(cloth, i, 0), PLI_OK); }
    }
}

/* 1 kg falls 1 m on 0.2 kg, which stretch to twice their size, with one iteration to four times. */
static void test_heavy_boxes_do_not_pass_a_coarse_cloth(void** state) {
    fixture* f = *state;
    for (int c = 0; c < 64; ++c) {
        const box_side side = (box_side)(c & 3);
        const float* spot = spots[(c >> 2) & 3];
        pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.005f, (c & 16) != 0 ? 10 : 1);
        if ((c & 32) != 0) { pin_rim(cloth); }
        enable_nodes(cloth);
        enable_faces(cloth);
        pli_rigid* box = make_turned_box(f->world, side, 0.05f, 1, pli_vec3_make(spot[0], 1.09f, spot[1]));
        const int passed = run(f->world, cloth, box, 1.3f, 1.0f / 60);
        if (passed != 0) { fail_msg("case %d: the box passed", c); }
        pli_rigid_destroy(box);
        pli_body_destroy(cloth);
    }
}

/* Energy does not grow: a box does not fly higher than it was, nor spin instead. In the end it lies, trembling a
   little, as 1 kg does on nodes of 2 g. */
static void test_heavy_boxes_come_to_rest(void** state) {
    fixture* f = *state;
    float speed = 0, spin = 0; /* means over the last second and the sides */
    for (int c = 0; c < BOX_SIDES; ++c) {
        pli_body* cloth = make_cloth(f->world, 0, 0.005f, 10);
        pin_rim(cloth);
        pli_solver_settings solver = pli_body_get_solver_settings(cloth);
        solver.velocity_damping = 0.02f;
        assert_int_equal(pli_body_set_solver_settings(cloth, &solver), PLI_OK);
        enable_faces(cloth);
        const float half = 0.05f, height = 0.5f, inertia = half * half * 2 / 3;
        pli_rigid* box = make_turned_box(f->world, (box_side)c, half, 1, pli_vec3_make(0.03f, height, 0.02f));
        float most = 0;
        for (int i = 0; i < 300; ++i) {
            assert_int_equal(run(f->world, cloth, box, 1.0f / 60, 1.0f / 60), 0);
            const pli_rigid_state now = pli_rigid_get_state(box);
            const float v = pli_vec3_length(now.linear_velocity), w = pli_vec3_length(now.angular_velocity);
            const float energy = 0.5f * v * v + 0.5f * inertia * w * w + 10 * now.pose.origin.y;
            most = energy > most ? energy : most;
            speed += i >= 240 ? v / (60 * BOX_SIDES) : 0;
            spin += i >= 240 ? w / (60 * BOX_SIDES) : 0;
        }
        check_at_most(most, 10 * height);
        pli_rigid_destroy(box);
        pli_body_destroy(cloth);
    }
    check_at_most(speed, 0.2);
    check_at_most(spin, 3.5);
}

/* A ball that its host puts through the cloth goes back the way it came, though the other way is shorter. */
static void test_bodies_go_back_to_their_side(void** state) {
    fixture* f = *state;
    for (int is_box = 0; is_box < 2; ++is_box) {
        for (int side = -1; side <= 1; side += 2) {
            assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
            pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.005f, 10);
            enable_faces(cloth);
            const float size = 0.03f, above = (float)side;
            const pli_vec3 place = {0.03f, above * (size + 0.004f), 0.02f};
            pli_rigid* rigid = is_box != 0 ? make_turned_box(f->world, FLAT, size, 0.1f, place)
                                           : make_ball(f->world, size, 0.1f, place, pli_vec3_make(0, 0, 0));
            assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
            pli_rigid_state moved = pli_rigid_get_state(rigid);
            moved.pose.origin.y = -above * 0.5f * size;
            assert_int_equal(pli_rigid_set_state(rigid, &moved), PLI_OK);
            for (int i = 0; i < 3; ++i) {
                assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
                assert_int_equal(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), 1.0f / 60), PLI_OK);
            }
            const pli_body_view view = pli_body_get_view(cloth);
            const float relative = pli_rigid_get_state(rigid).pose.origin.y - view.positions[60].y;
            assert_true(above * relative > 0.9f * size);
            pli_rigid_destroy(rigid);
            pli_body_destroy(cloth);
        }
    }
}

/* The same boxes as triangles. */
static void test_triangle_meshes_do_not_pass_a_coarse_cloth(void** state) {
    fixture* f = *state;
    for (int c = 0; c < 32; ++c) {
        const float half = 0.05f, mass = (c & 16) != 0 ? 1 : 0.1f;
        const float* spot = spots[(c >> 2) & 3];
        pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.005f, 10);
        enable_nodes(cloth);
        enable_faces(cloth);
        pli_transform pose = at(spot[0], 1.09f, spot[1]);
        pose.rotation = rotation_of((box_side)(c & 3));
        const float i = mass * half * half * 2 / 3;
        pli_rigid* box = make_rigid(f->world, make_box_mesh(f->context, half), mass, pli_vec3_make(i, i, i), pose,
                                    pli_vec3_make(0, 0, 0));
        const int passed = run(f->world, cloth, box, 1, 1.0f / 60);
        if (passed != 0) { fail_msg("case %d: the box passed", c); }
        pli_rigid_destroy(box);
        pli_body_destroy(cloth);
    }
}

/* A peak of a floor holds a cloth between its nodes; nodes alone meet its flanks only. */
static void test_a_peak_of_a_mesh_holds_a_cloth(void** state) {
    fixture* f = *state;
    for (int with = 0; with < 2; ++with) {
        pli_body* cloth = make_cloth(f->world, 0, 0.005f, 10);
        enable_nodes(cloth);
        if (with != 0) { enable_faces(cloth); }
        pli_transform pose = at(0.03f, -1.2f, 0.02f);
        pli_rigid* floor =
            make_rigid(f->world, make_floor(f->context, 1.0f), 0, pli_vec3_make(1, 1, 1), pose, pli_vec3_make(0, 0, 0));
        for (int i = 0; i < 45; ++i) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
        }
        const float top = pli_body_get_bounds(cloth).max.y;
        assert_int_equal(top > -0.3f, with); /* free fall: -2.8 */
        assert_int_equal(top < -0.5f, 1 - with);
        pli_rigid_destroy(floor);
        pli_body_destroy(cloth);
    }
}

/* Edges between triangles in a plane do not catch: a cloth slides over them as over a box. */
static void test_edges_of_a_flat_mesh_do_not_catch(void** state) {
    fixture* f = *state;
    float speeds[2];
    for (int is_mesh = 0; is_mesh < 2; ++is_mesh) {
        pli_body* cloth = make_cloth(f->world, 0, 0.02f, 4);
        pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
        faces.friction = 0;
        assert_int_equal(pli_body_enable_rigid_face_contacts(cloth, &faces), PLI_OK);
        assert_int_equal(pli_body_add_velocity(cloth, pli_vec3_make(0.7f, 0, 0.4f)), PLI_OK);
        pli_shape* shape = NULL;
        if (is_mesh != 0) {
            shape = make_floor(f->context, 0);
        } else {
            assert_int_equal(pli_shape_create_box(f->context, pli_vec3_make(2, 0.5f, 2), &shape), PLI_OK);
        }
        pli_rigid* floor = make_rigid(f->world, shape, 0, pli_vec3_make(1, 1, 1),
                                      at(0, is_mesh != 0 ? -0.03f : -0.53f, 0), pli_vec3_make(0, 0, 0));
        for (int i = 0; i < 60; ++i) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
        }
        assert_true(pli_body_get_rigid_face_contacts(cloth, 0, NULL) >= 200);
        assert_true(pli_body_get_bounds(cloth).min.y > -0.06f);
        const pli_vec3 momentum = pli_body_momentum(cloth);
        speeds[is_mesh] = sqrtf(momentum.x * momentum.x + momentum.z * momentum.z) / 0.2f;
        pli_rigid_destroy(floor);
        pli_body_destroy(cloth);
    }
    check_near(speeds[0], sqrtf(0.65f), 1e-4);
    check_near(speeds[1], speeds[0], 5e-4);
}

/* The cloth moves, the needle stands. */
static void test_a_static_point_stops_a_falling_cloth(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.005f, 10);
    enable_faces(cloth);
    assert_int_equal(pli_body_add_velocity(cloth, pli_vec3_make(0, -6, 0)), PLI_OK);
    pli_rigid* ball = make_ball(f->world, 0.01f, 0, pli_vec3_make(0.03f, -0.2f, 0.02f), pli_vec3_make(0, 0, 0));
    assert_int_equal(run(f->world, cloth, ball, 0.5f, 1.0f / 60), 0);
    /* It is thrown about by the ball; in free fall it would be at -4.5. */
    const pli_bounds bounds = pli_body_get_bounds(cloth);
    assert_true(bounds.max.y > -0.5f);
    assert_true(bounds.min.y > -1.2f);
}

/* A rope has no faces: its links meet a rod that falls across between two nodes. */
static void test_a_stick_does_not_pass_a_rope(void** state) {
    fixture* f = *state;
    for (int with = 0; with < 2; ++with) {
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create_rope(f->context, pli_vec3_make(0, 0, -0.4f), pli_vec3_make(0, 0, 0.4f), 3,
                                              PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST, &mesh),
                         PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.005f;
        def.solver.position_iterations = 10;
        pli_body* rope = NULL;
        assert_int_equal(pli_body_create(f->world, mesh, &def, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        enable_nodes(rope);
        if (with != 0) { enable_faces(rope); }
        pli_rigid* stick = make_stick(f->world, 0.05f, pli_vec3_make(0, 0.1f, 0.09f), pli_vec3_make(0, -5, 0));
        int contacts = 0;
        float y = 0;
        for (int i = 0; i < 12; ++i) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
            pli_rigid_face_contact contact;
            if (pli_body_get_rigid_face_contacts(rope, 1, &contact) > 0) {
                ++contacts;
                assert_int_equal(contact.face, PLI_NULL_INDEX);
                assert_in_range(contact.link, 0, 3);
                check_near(contact.weights[0] + contact.weights[1], 1, 1e-6);
                check_near(contact.weights[2], 0, 0);
            }
            assert_int_equal(pli_rigid_integrate(stick, gravity, 1.0f / 60), PLI_OK);
            y = pli_rigid_get_state(stick).pose.origin.y;
        }
        assert_int_equal(contacts > 0, with);
        assert_int_equal(y > -0.4f, with); /* free fall: -1.1 */
        pli_rigid_destroy(stick);
        pli_body_destroy(rope);
    }
}

// ------------------------------------------------------------------------------------------------------- physics

static void test_face_contacts_keep_momentum(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_body* cloth = make_cloth(f->world, 0, 0.005f, 4);
    enable_faces(cloth);
    const float mass = 0.05f;
    pli_rigid* ball = make_ball(f->world, 0.02f, mass, pli_vec3_make(0.03f, 0.06f, 0.02f), pli_vec3_make(1, -5, 0.5f));
    bool needs_reintegration = false;
    for (int i = 0; i < 30; ++i) {
        const pli_vec3 before =
            pli_vec3_add(pli_body_momentum(cloth), pli_vec3_scale(pli_rigid_get_state(ball).linear_velocity, mass));
        assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
        const pli_vec3 after =
            pli_vec3_add(pli_body_momentum(cloth), pli_vec3_scale(pli_rigid_get_state(ball).linear_velocity, mass));
        check_at_most(pli_vec3_length(pli_vec3_sub(after, before)), 1e-6);
        assert_true(pli_rigid_was_touched(ball) || !pli_rigid_get_shift(ball, NULL, NULL));
        needs_reintegration = needs_reintegration || pli_rigid_get_shift(ball, NULL, NULL);
        assert_int_equal(pli_rigid_integrate(ball, pli_vec3_make(0, 0, 0), 1.0f / 60), PLI_OK);
    }
    assert_true(needs_reintegration);
    /* The ball hit 0.2 kg with 0.25 kg m/s. */
    assert_true(pli_body_momentum(cloth).y < -0.1f);
}

/* One face of pinned nodes: the ball loses exactly the speed that would bring it nearer than the margin. */
static void test_a_pinned_face_stops_a_ball_at_the_margin(void** state) {
    fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    const pli_vec3 corners[3] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}};
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, corners[i], 0, NULL), PLI_OK);
    }
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, 0, NULL), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.01f;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    enable_faces(body);
    pli_rigid* ball = make_ball(f->world, 0.02f, 1, pli_vec3_make(0.25f, 0.1f, 0.5f), pli_vec3_make(0, -30, 0));
    const float dt = 1.0f / 60;
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    pli_rigid_face_contact contact;
    assert_int_equal(pli_body_get_rigid_face_contacts(body, 1, &contact), 1);
    assert_int_equal(contact.face, 0);
    assert_int_equal(contact.link, PLI_NULL_INDEX);
    assert_ptr_equal(contact.rigid, ball);
    assert_int_equal(contact.shape, 0);
    check_near(contact.weights[0], 0.25, 1e-6);
    check_near(contact.weights[1], 0.5, 1e-6);
    check_near(contact.weights[2], 0.25, 1e-6);
    check_near(contact.normal.y, -1, 1e-6);
    check_near(contact.distance, 0.1 - 0.5 - 0.02 - 0.01, 1e-6);
    check_near(pli_rigid_get_state(ball).linear_velocity.y, -(0.1 - 0.03) * 60, 2e-5);
    /* On its way up again nothing holds it. */
    pli_rigid_state up = pli_rigid_get_state(ball);
    up.linear_velocity = pli_vec3_make(0, 1, 0);
    up.pose.origin.y = 0.035f;
    assert_int_equal(pli_rigid_set_state(ball, &up), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    check_near(pli_rigid_get_state(ball).linear_velocity.y, 1, 0);
    assert_false(pli_rigid_get_shift(ball, NULL, NULL));
}

/* A host that moves its bodies before the solve, as Bullet does, and once more after it ends at the same place. */
static void test_hosts_that_move_bodies_before_the_solve(void** state) {
    fixture* f = *state;
    const float dt = 1.0f / 60;
    pli_rigid_state ends[2];
    for (int moves_early = 0; moves_early < 2; ++moves_early) {
        pli_body* cloth = make_cloth(f->world, 0, 0.005f, 4);
        enable_faces(cloth);
        pli_rigid* ball =
            make_ball(f->world, 0.01f, 0.01f, pli_vec3_make(0.03f, 0.05f, 0.02f), pli_vec3_make(0.3f, -5, 0));
        for (int i = 0; i < 5; ++i) {
            const pli_rigid_state begin = pli_rigid_get_state(ball);
            assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
            assert_int_equal(pli_world_collide_rigid(f->world, cloth, ball), PLI_OK);
            pli_rigid_state moved = begin;
            moved.pose.origin = pli_vec3_add(moved.pose.origin, pli_vec3_scale(begin.linear_velocity, dt));
            if (moves_early != 0) { assert_int_equal(pli_rigid_set_state(ball, &moved), PLI_OK); }
            assert_int_equal(pli_world_solve(f->world), PLI_OK);
            pli_rigid_state end = pli_rigid_get_state(ball);
            const pli_vec3 change = pli_vec3_sub(end.linear_velocity, begin.linear_velocity);
            end.pose.origin = pli_vec3_add(moved.pose.origin, pli_vec3_scale(change, dt));
            if (pli_rigid_get_shift(ball, NULL, NULL)) { assert_true(pli_vec3_length(change) > 0); }
            assert_int_equal(pli_rigid_set_state(ball, &end), PLI_OK);
        }
        ends[moves_early] = pli_rigid_get_state(ball);
        pli_rigid_destroy(ball);
        pli_body_destroy(cloth);
    }
    assert_true(ends[0].linear_velocity.y > -4.0f);
    check_at_most(pli_vec3_length(pli_vec3_sub(ends[0].pose.origin, ends[1].pose.origin)), 2e-4);
    check_at_most(pli_vec3_length(pli_vec3_sub(ends[0].linear_velocity, ends[1].linear_velocity)), 2e-2);
}

/* The same with substeps, by what the step says; momentum is exact. A host that moves bodies first has given them the
   velocity of gravity too. */
static void test_hosts_may_move_bodies_before_substeps(void** state) {
    fixture* f = *state;
    const float dt = 1.0f / 60, mass = 0.05f;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_rigid_state ends[2];
    for (int moves_early = 0; moves_early < 2; ++moves_early) {
        pli_body* cloth = make_cloth(f->world, 0, 0.005f, 4);
        assert_int_equal(pli_body_enable_xpbd(cloth, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(cloth, NULL), PLI_OK);
        enable_faces(cloth);
        enable_nodes(cloth);
        pli_rigid* ball =
            make_ball(f->world, 0.02f, mass, pli_vec3_make(0.03f, 0.06f, 0.02f), pli_vec3_make(0.3f, -5, 0));
        bool is_shifted = false;
        for (int i = 0; i < 20; ++i) {
            const pli_rigid_state begin = pli_rigid_get_state(ball);
            const pli_vec3 before = pli_vec3_add(pli_body_momentum(cloth), pli_vec3_scale(begin.linear_velocity, mass));
            assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
            assert_int_equal(pli_world_collide_rigid(f->world, cloth, ball), PLI_OK);
            pli_rigid_state moved = begin;
            moved.pose.origin = pli_vec3_add(moved.pose.origin, pli_vec3_scale(begin.linear_velocity, dt));
            if (moves_early != 0) { assert_int_equal(pli_rigid_set_state(ball, &moved), PLI_OK); }
            assert_int_equal(pli_world_solve(f->world), PLI_OK);
            pli_rigid_state end = pli_rigid_get_state(ball);
            const pli_vec3 after = pli_vec3_add(pli_body_momentum(cloth), pli_vec3_scale(end.linear_velocity, mass));
            check_at_most(pli_vec3_length(pli_vec3_sub(after, before)), 1e-5);
            pli_vec3 shift;
            is_shifted = pli_rigid_get_shift(ball, &shift, NULL) || is_shifted;
            if (moves_early != 0) {
                end.pose.origin = pli_vec3_add(moved.pose.origin, shift);
                assert_int_equal(pli_rigid_set_state(ball, &end), PLI_OK);
            } else {
                assert_int_equal(pli_rigid_integrate(ball, pli_vec3_make(0, 0, 0), dt), PLI_OK);
            }
        }
        assert_true(is_shifted);
        ends[moves_early] = pli_rigid_get_state(ball);
        pli_rigid_destroy(ball);
        pli_body_destroy(cloth);
    }
    assert_true(ends[0].linear_velocity.y > -4.5f);
    check_at_most(pli_vec3_length(pli_vec3_sub(ends[0].pose.origin, ends[1].pose.origin)), 1e-4);
    check_at_most(pli_vec3_length(pli_vec3_sub(ends[0].linear_velocity, ends[1].linear_velocity)), 1e-3);
}

/* A kinematic ball that flies up takes a sheet along, in whichever order its host moves it. */
static void test_kinematic_bodies_carry_faces_in_substeps(void** state) {
    fixture* f = *state;
    const float dt = 1.0f / 60, radius = 0.1f, margin = 0.005f, speed = 3;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    for (int moves_early = 0; moves_early < 2; ++moves_early) {
        pli_body* cloth = make_cloth(f->world, 0, margin, 4);
        assert_int_equal(pli_body_enable_xpbd(cloth, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(cloth, NULL), PLI_OK);
        enable_faces(cloth);
        pli_shape* shape = NULL;
        assert_int_equal(pli_shape_create_sphere(f->context, radius, &shape), PLI_OK);
        pli_rigid_def def = pli_rigid_def_default();
        def.kind = PLI_RIGID_KINEMATIC;
        def.shapes = &shape;
        def.shape_count = 1;
        def.state.pose = at(0.03f, -0.2f, 0.02f);
        def.state.linear_velocity = pli_vec3_make(0, speed, 0);
        pli_rigid* ball = NULL;
        assert_int_equal(pli_rigid_create(f->world, &def, &ball), PLI_OK);
        pli_shape_release(shape);
        for (int i = 0; i < 10; ++i) { /* before the rim swings round it */
            assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
            assert_int_equal(pli_world_collide_rigid(f->world, cloth, ball), PLI_OK);
            if (moves_early != 0) { assert_int_equal(pli_rigid_integrate(ball, pli_vec3_make(0, 0, 0), dt), PLI_OK); }
            assert_int_equal(pli_world_solve(f->world), PLI_OK);
            if (moves_early == 0) { assert_int_equal(pli_rigid_integrate(ball, pli_vec3_make(0, 0, 0), dt), PLI_OK); }
        }
        assert_true(pli_body_get_rigid_face_contacts(cloth, 0, NULL) > 0);
        const pli_vec3 center = pli_rigid_get_state(ball).pose.origin;
        check_near(center.y, -0.2 + 10.0 * (double)(speed * dt), 1e-4);
        const pli_body_view view = pli_body_get_view(cloth);
        float lowest = INFINITY;
        for (int i = 0; i < view.face_count; ++i) {
            const int* nodes = view.face_nodes + (ptrdiff_t)3 * i;
            pli_vec3 middle = pli_vec3_make(0, 0, 0);
            for (int k = 0; k < 3; ++k) {
                const pli_vec4 x = view.positions[nodes[k]];
                middle = pli_vec3_add(middle, pli_vec3_scale(pli_vec3_make(x.x, x.y, x.z), 1.0f / 3));
            }
            const pli_vec3 apart = pli_vec3_sub(middle, center);
            if (apart.x * apart.x + apart.z * apart.z < 0.25f * radius * radius && apart.y < lowest) {
                lowest = apart.y;
            }
        }
        assert_true(lowest > radius - margin && lowest < radius + 20 * margin);
        pli_rigid_destroy(ball);
        pli_body_destroy(cloth);
    }
}

/* Contacts stay as they were made when the host changes the shapes before the solve. */
static void test_shapes_may_change_before_the_solve(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.005f, 4);
    enable_faces(cloth);
    pli_rigid* ball = make_ball(f->world, 0.01f, 0.1f, pli_vec3_make(0.03f, 0.05f, 0.02f), pli_vec3_make(0, -5, 0));
    assert_int_equal(pli_world_predict(f->world, 1.0f / 60), PLI_OK);
    assert_int_equal(pli_world_collide_rigid(f->world, cloth, ball), PLI_OK);
    assert_int_equal(pli_rigid_set_shapes(ball, 0, NULL, NULL), PLI_OK);
    assert_int_equal(pli_world_solve(f->world), PLI_OK);
    assert_true(pli_rigid_get_shift(ball, NULL, NULL));
    assert_true(pli_rigid_get_state(ball).linear_velocity.y > -4.9f);
}

/* Cloth that lies on a table lies there as with node contacts alone. */
static void test_resting_cloth_is_as_with_nodes_alone(void** state) {
    fixture* f = *state;
    float heights[2];
    for (int with = 0; with < 2; ++with) {
        pli_body* cloth = make_cloth(f->world, 0, 0.02f, 4);
        enable_nodes(cloth);
        if (with != 0) { enable_faces(cloth); }
        pli_shape* shape = NULL;
        assert_int_equal(pli_shape_create_box(f->context, pli_vec3_make(2, 0.5f, 2), &shape), PLI_OK);
        pli_rigid* table =
            make_rigid(f->world, shape, 0, pli_vec3_make(1, 1, 1), at(0, -0.53f, 0), pli_vec3_make(0, 0, 0));
        for (int i = 0; i < 240; ++i) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
        }
        const pli_body_view view = pli_body_get_view(cloth);
        heights[with] = 0;
        for (int i = 0; i < view.node_count; ++i) {
            heights[with] += view.positions[i].y / (float)view.node_count;
        }
        check_at_most(pli_body_kinetic_energy(cloth), 1e-3);
        pli_rigid_destroy(table);
        pli_body_destroy(cloth);
    }
    check_near(heights[0], -0.01, 3e-3);
    check_near(heights[1], heights[0], 1e-3);
}

/* Faces whose nodes are held on one plane are not looked at, in whatever order contacts were enabled; where those of
   nodes rub less they hold nothing for faces. */
static void test_flat_faces_are_left_to_their_nodes(void** state) {
    fixture* f = *state;
    for (int i = 0; i < 3; ++i) {
        pli_body* cloth = make_cloth(f->world, 0, 0.02f, 4);
        if (i > 0) { enable_faces(cloth); }
        pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
        nodes.friction = i < 2 ? nodes.friction : 0;
        assert_int_equal(pli_body_enable_rigid_contacts(cloth, &nodes), PLI_OK);
        if (i == 0) { enable_faces(cloth); }
        pli_shape* shape = NULL;
        assert_int_equal(pli_shape_create_box(f->context, pli_vec3_make(2, 0.5f, 2), &shape), PLI_OK);
        pli_rigid* table =
            make_rigid(f->world, shape, 0, pli_vec3_make(1, 1, 1), at(0, -0.53f, 0), pli_vec3_make(0, 0, 0));
        for (int k = 0; k < 120; ++k) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
        }
        const int count = pli_body_get_rigid_face_contacts(cloth, 0, NULL);
        print_message("case %d: %d contacts of faces, %.2g J\n", i, count, (double)pli_body_kinetic_energy(cloth));
        assert_true(i < 2 ? count == 0 : count >= 200); /* of 200 faces */
        check_at_most(pli_body_kinetic_energy(cloth), i < 2 ? 1e-12 : 1e-6);
        pli_rigid_destroy(table);
        pli_body_destroy(cloth);
    }
}

static uint64_t hash_of_a_run(fixture* f) {
    pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10, 0.005f, 4);
    enable_faces(cloth);
    pli_rigid* box = make_box(f->world, 0.05f, 0.1f, pli_vec3_make(0.03f, 0.2f, 0.02f));
    (void)run(f->world, cloth, box, 0.5f, 1.0f / 60);
    const uint64_t hash = pli_body_state_hash(cloth);
    pli_rigid_destroy(box);
    pli_body_destroy(cloth);
    return hash;
}

static void test_face_contacts_repeat_bit_for_bit(void** state) {
    fixture* f = *state;
    assert_true(hash_of_a_run(f) == hash_of_a_run(f));
}

// ------------------------------------------------------------------------------------------------ life of contacts

static void test_face_contacts_come_and_go(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.005f, 4);
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, NULL), 0);
    const size_t bytes = pli_body_bytes(cloth);
    enable_faces(cloth);
    pli_rigid* ball = make_ball(f->world, 0.02f, 0.1f, pli_vec3_make(0.03f, 0.03f, 0.02f), pli_vec3_make(0, -5, 0));
    assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    const int count = pli_body_get_rigid_face_contacts(cloth, 0, NULL);
    assert_true(count > 0);
    /* No room: nothing is written, the count is told. */
    pli_rigid_face_contact contact = {.face = 77};
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, &contact), count);
    assert_int_equal(contact.face, 77);
    const size_t bytes_enabled = pli_body_bytes(cloth);
    assert_true(bytes_enabled > bytes);

    pli_rigid_destroy(ball);
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, NULL), 0);
    ball = make_ball(f->world, 0.02f, 0.1f, pli_vec3_make(0.03f, -0.07f, 0.02f), pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_body_disable_rigid_face_contacts(cloth), PLI_OK);
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, NULL), 0);
    assert_true(pli_body_bytes(cloth) < bytes_enabled);
    assert_int_equal(pli_body_disable_rigid_face_contacts(cloth), PLI_OK);
    assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    assert_false(pli_rigid_was_touched(ball));
}

static void test_cutting_ends_face_contacts(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.005f, 4);
    enable_faces(cloth);
    make_ball(f->world, 0.02f, 0.1f, pli_vec3_make(0.03f, 0.03f, 0.02f), pli_vec3_make(0, -5, 0));
    assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    assert_true(pli_body_get_rigid_face_contacts(cloth, 0, NULL) > 0);
    assert_int_equal(pli_body_cut_link(cloth, 0, 1, 0.5f), PLI_OK);
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, NULL), 0);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    }
    assert_false(pli_body_is_frozen(cloth));
}

static void test_steps_with_face_contacts_allocate_nothing(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.005f, 10);
    enable_faces(cloth);
    pli_rigid* ball = make_ball(f->world, 0.02f, 0.005f, pli_vec3_make(0.03f, 0.03f, 0.02f), pli_vec3_make(0, -1, 0));
    assert_int_equal(run(f->world, cloth, ball, 3, 1.0f / 60), 0);
    const uint64_t before = pli_context_allocation_count(f->context);
    assert_int_equal(run(f->world, cloth, ball, 1, 1.0f / 60), 0);
    assert_int_equal(pli_context_allocation_count(f->context) - before, 0);
    assert_true(pli_body_get_rigid_face_contacts(cloth, 0, NULL) > 0);
}

/* An anchored node keeps its faces from the rigid body that it hangs on, and from no other. */
static void test_faces_with_anchored_nodes(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.005f, 4);
    enable_faces(cloth);
    pli_rigid* hook = make_ball(f->world, 0.01f, 0, pli_vec3_make(0, 0.01f, 0), pli_vec3_make(0, 0, 0));
    pli_rigid* ball = make_ball(f->world, 0.01f, 0.1f, pli_vec3_make(0.03f, 0.05f, 0.02f), pli_vec3_make(0, -5, 0));
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.node = 60;
    anchor.rigid = hook;
    assert_int_equal(pli_body_add_anchor(cloth, &anchor, NULL), PLI_OK);
    assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    pli_rigid_face_contact contacts[64];
    const int count = pli_body_get_rigid_face_contacts(cloth, 64, contacts);
    assert_in_range(count, 1, 64);
    for (int i = 0; i < count; ++i) {
        assert_ptr_equal(contacts[i].rigid, ball);
    }
    assert_true(pli_rigid_get_state(ball).linear_velocity.y > -4.9f);
}

/* Planes and open shapes without a support function are left to the nodes. */
static void test_planes_have_no_face_contacts(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.02f, 4);
    enable_faces(cloth);
    pli_shape* plane = NULL;
    assert_int_equal(pli_shape_create_plane(f->context, pli_vec3_make(0, 1, 0), 0, &plane), PLI_OK);
    make_rigid(f->world, plane, 0, pli_vec3_make(1, 1, 1), pli_transform_identity(), pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, NULL), 0);
}

static void bad_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    (void)user;
    (void)points;
    (void)max_distance;
    for (int i = 0; i < count; ++i) {
        distances[i] = 1;
        normals[i] = pli_vec3_make(0, 1, 0);
    }
}
static pli_bounds bad_bounds(const void* user) {
    (void)user;
    return (pli_bounds){{-1, -1, -1}, {1, 1, 1}};
}
static pli_vec3 bad_support(const void* user, pli_vec3 direction) {
    (void)user;
    (void)direction;
    return pli_vec3_make(NAN, 0, 0);
}

static void test_a_broken_support_makes_no_contacts(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.02f, 4);
    enable_faces(cloth);
    pli_shape_def def = pli_shape_def_default();
    def.distances = bad_distances;
    def.bounds = bad_bounds;
    def.support = bad_support;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create(f->context, &def, &shape), PLI_OK);
    make_rigid(f->world, shape, 0, pli_vec3_make(1, 1, 1), pli_transform_identity(), pli_vec3_make(0, 0, 0));
    assert_int_equal(pli_world_step(f->world, 1.0f / 60), PLI_OK);
    assert_int_equal(pli_body_get_rigid_face_contacts(cloth, 0, NULL), 0);
    assert_false(pli_body_is_frozen(cloth));
}

typedef enum solver_kind { POSITION_BASED, IMPLICIT, XPBD } solver_kind;

static void enable_solver(pli_body* body, solver_kind solver) {
    if (solver == IMPLICIT) { assert_int_equal(pli_body_enable_implicit(body, NULL), PLI_OK); }
    if (solver != XPBD) { return; }
    assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK);
    assert_int_equal(pli_body_enable_xpbd_links(body, NULL), PLI_OK);
}

/* A square of two triangles. */
static pli_shape* make_large_mesh(pli_context* context, float half_width) {
    const float h = half_width;
    const pli_vec3 corners[] = {{-h, 0, -h}, {h, 0, -h}, {h, 0, h}, {-h, 0, h}};
    const int triangles[] = {0, 2, 1, 0, 3, 2};
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, 4, corners, 2, triangles, 0.1f, &shape), PLI_OK);
    return shape;
}

static pli_shape* make_large_box(pli_context* context, float half_width) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_box(context, pli_vec3_make(half_width, half_width, half_width), &shape), PLI_OK);
    return shape;
}

/* A sheet falls at 7 m/s on a ground whose top is at y = -0.5; the largest kinetic energy over that of the fall. */
static double energy_ratio_on(fixture* f, pli_shape* ground, pli_vec3 centre, solver_kind solver) {
    pli_rigid* rigid = make_rigid(f->world, ground, 0, pli_vec3_make(1, 1, 1), at(centre.x, centre.y, centre.z),
                                  pli_vec3_make(0, 0, 0));
    pli_body* cloth = make_cloth(f->world, 0, 0.02f, 8);
    enable_nodes(cloth);
    enable_faces(cloth);
    enable_solver(cloth, solver);
    assert_int_equal(pli_body_add_velocity(cloth, pli_vec3_make(0, -7, 0)), PLI_OK);
    double most = 0;
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
        const pli_body_view view = pli_body_get_view(cloth);
        double sum = 0;
        for (int k = 0; k < view.node_count; ++k) {
            const pli_vec3 v = pli_vec3_make(view.velocities[k].x, view.velocities[k].y, view.velocities[k].z);
            sum += 0.5 * (double)pli_vec3_length_squared(v) / view.node_count;
            assert_true(view.positions[k].y > -0.52f);
        }
        if (sum > most) { most = sum; }
    }
    pli_body_destroy(cloth);
    pli_rigid_destroy(rigid);
    return most / (0.5 * 7 * 7 + 10 * 0.48);
}

/* Distances from a ground of kilometres are as exact as from a small one. */
static void test_large_grounds_give_no_energy(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, gravity), PLI_OK);
    static const float half_widths[] = {10, 1000, 10000}, shares[] = {0, 0.77f};
    for (int i = 0; i < 18; ++i) {
        const float h = half_widths[i % 3], aside = shares[i / 9] * h;
        const solver_kind solver = (solver_kind)(i / 3 % 3);
        const pli_vec3 middle = pli_vec3_make(aside, -0.5f, -0.6f * aside);
        assert_true(energy_ratio_on(f, make_large_mesh(f->context, h), middle, solver) <= 1.0);
        const pli_vec3 below = pli_vec3_make(aside, -0.5f - h, -0.6f * aside);
        assert_true(energy_ratio_on(f, make_large_box(f->context, h), below, solver) <= 1.0);
    }
}

/* A carpet whose corners are pinned within its margin of the floor: those stay, the rest of it comes to lie. */
static void test_faces_with_pinned_nodes_inside_the_margin_stay_calm(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, gravity), PLI_OK);
    (void)make_rigid(f->world, make_large_box(f->context, 5), 0, pli_vec3_make(1, 1, 1), at(0, -5.02f, 0),
                     pli_vec3_make(0, 0, 0));
    for (int i = 0; i < 3; ++i) {
        pli_body* cloth = make_cloth(f->world, PLI_PATCH_PIN_CORNERS, 0.03f, 10);
        enable_nodes(cloth);
        enable_faces(cloth);
        enable_solver(cloth, (solver_kind)i);
        double most = 0;
        for (int k = 0; k < 240; ++k) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
            most = fmax(most, (double)pli_body_kinetic_energy(cloth));
        }
        const double last = (double)pli_body_kinetic_energy(cloth), stretch = (double)pli_body_max_stretch(cloth);
        print_message("solver %d: at most %.2g J, %.2g J in the end, stretch %.2g\n", i, most, last, stretch);
        check_at_most(most, 0.02);
        check_at_most(last, 2e-3);
        check_at_most(stretch, 0.06);
        pli_body_destroy(cloth);
    }
}

/* A ball lies too deep in a face right beside its pinned edge: the third node, which bears next to nothing of the point
   that is touched, does not go far for that point to get away. */
static void test_a_node_that_bears_little_is_not_thrown_away(void** state) {
    fixture* f = *state;
    static const float shares[] = {1e-7f, 1e-5f, 1e-3f, 0.1f};
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    for (int i = 0; i < 12; ++i) {
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
        const pli_vec3 corners[3] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}};
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(pli_mesh_append_node(mesh, corners[k], k == 1 ? 0.01f : 0.0f, NULL), PLI_OK);
        }
        assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, 0, NULL), PLI_OK);
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.02f;
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(f->world, mesh, &def, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        enable_faces(body);
        enable_solver(body, (solver_kind)(i / 4));
        pli_rigid* ball =
            make_ball(f->world, 0.2f, 20, pli_vec3_make(0.3f, 0.21f, shares[i % 4]), pli_vec3_make(0, 0, 0));
        double farthest = 0;
        for (int k = 0; k < 30; ++k) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
            const pli_vec4 x = pli_body_get_view(body).positions[1];
            farthest = fmax(farthest, (double)pli_vec3_length(pli_vec3_make(x.x, x.y, x.z - 1)));
        }
        print_message("solver %d, share %g: %.3g m\n", i / 4, (double)shares[i % 4], farthest);
        check_at_most(farthest, (double)shares[i % 4]);
        pli_body_destroy(body);
        pli_rigid_destroy(ball);
    }
}

/* Largest stretch of a cloth on a floor while a kinematic box comes down on it to `gap`, and stays. */
static double stretch_between(fixture* f, float gap, solver_kind solver) {
    const float dt = 1.0f / 60, floor = -0.03f, half_height = 0.1f, high = 0.3f;
    pli_rigid* ground = make_rigid(f->world, make_large_box(f->context, 5), 0, pli_vec3_make(1, 1, 1),
                                   at(0, floor - 5, 0), pli_vec3_make(0, 0, 0));
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_box(f->context, pli_vec3_make(0.15f, half_height, 0.15f), &shape), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_KINEMATIC;
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose = at(0.03f, floor + half_height + high, 0.02f);
    pli_rigid* box = NULL;
    assert_int_equal(pli_rigid_create(f->world, &def, &box), PLI_OK);
    pli_shape_release(shape);
    pli_body* cloth = make_cloth(f->world, 0, 0.02f, 8);
    enable_nodes(cloth);
    enable_faces(cloth);
    enable_solver(cloth, solver);
    double most = 0;
    for (int i = 0; i < 240; ++i) {
        pli_rigid_state state = pli_rigid_get_state(box);
        state.linear_velocity.y = i < 120 ? (gap - high) / 2 : 0;
        state.pose.origin.y += state.linear_velocity.y * dt;
        assert_int_equal(pli_rigid_set_state(box, &state), PLI_OK);
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        most = fmax(most, (double)pli_body_max_stretch(cloth));
    }
    pli_body_destroy(cloth);
    pli_rigid_destroy(box);
    pli_rigid_destroy(ground);
    return most;
}

/* Margins of 2 cm on both sides, and less room than that. */
static void test_bodies_that_press_on_a_cloth_do_not_pull_it_apart(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, gravity), PLI_OK);
    const float gaps[] = {0.03f, 0.01f, 0.002f, -0.005f};
    for (int i = 0; i < 3; ++i) {
        for (size_t k = 0; k < sizeof gaps / sizeof *gaps; ++k) {
            const double stretch = stretch_between(f, gaps[k], (solver_kind)i);
            print_message("solver %d, %g m between them: stretch %.2g\n", i, (double)gaps[k], stretch);
            check_at_most(stretch, 1.5);
        }
    }
}

/* A rope that lies tightly around a drum goes round with it, at the margin and not as fast as the drum's surface. */
static void test_a_drum_takes_a_rope_with_it(void** unused) {
    fixture* f = *unused;
    enum { NODES = 24 };
    const float radius = 0.15f, margin = 0.03f, turn = 3, dt = 1.0f / 60;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    for (int solver = POSITION_BASED; solver <= XPBD; solver += XPBD - POSITION_BASED) {
        pli_shape* shape = NULL;
        assert_int_equal(pli_shape_create_cylinder(f->context, pli_vec3_make(0, 0.5f, 0), radius, &shape), PLI_OK);
        pli_rigid_def drum_def = pli_rigid_def_default();
        drum_def.kind = PLI_RIGID_KINEMATIC;
        drum_def.shapes = &shape;
        drum_def.shape_count = 1;
        drum_def.friction = 1;
        pli_rigid* drum = NULL;
        assert_int_equal(pli_rigid_create(f->world, &drum_def, &drum), PLI_OK);
        pli_shape_release(shape);
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
        for (int i = 0; i < NODES; ++i) {
            const float angle = 6.2831853f * (float)i / NODES;
            const pli_vec3 at = pli_vec3_make((radius + margin) * cosf(angle), 0, (radius + margin) * sinf(angle));
            assert_int_equal(pli_mesh_append_node(mesh, at, 1, NULL), PLI_OK);
        }
        for (int i = 0; i < NODES; ++i) {
            assert_int_equal(pli_mesh_append_link(mesh, i, (i + 1) % NODES, 0, NULL), PLI_OK);
        }
        assert_int_equal(pli_mesh_set_total_mass(mesh, 1), PLI_OK);
        pli_body_def def = pli_body_def_default();
        def.collision_margin = margin;
        def.solver.position_iterations = 10;
        pli_body* rope = NULL;
        assert_int_equal(pli_body_create(f->world, mesh, &def, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
        faces.friction = 1;
        assert_int_equal(pli_body_enable_rigid_face_contacts(rope, &faces), PLI_OK);
        enable_solver(rope, (solver_kind)solver);
        double turned = 0;
        for (int i = 0; i < 240; ++i) {
            pli_rigid_state state = pli_rigid_get_state(drum);
            state.angular_velocity = pli_vec3_make(0, -turn, 0);
            state.pose.rotation = pli_mat3_from_euler_zyx(0, -turn * dt * (float)(i + 1), 0);
            assert_int_equal(pli_rigid_set_state(drum, &state), PLI_OK);
            const pli_vec4 before = pli_body_get_view(rope).positions[0];
            assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
            const pli_vec4 after = pli_body_get_view(rope).positions[0];
            turned += (double)asinf(
                (before.x * after.z - before.z * after.x) /
                sqrtf((before.x * before.x + before.z * before.z) * (after.x * after.x + after.z * after.z)));
        }
        print_message("solver %d: turned by %.3f of 12 rad\n", solver, turned);
        check_near(turned, 12, 0.3);
        pli_body_destroy(rope);
        pli_rigid_destroy(drum);
    }
}

static float fastest_node(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float fastest = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 v = view.velocities[i];
        fastest = fmaxf(fastest, pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
    }
    return fastest;
}

/* A box of 40 cm in the middle of a loose cloth parts from it in steps of 1/60 m; what is left of that are springs that
   it has stretched. */
static void test_a_box_put_into_a_cloth_does_not_throw_it_away(void** state) {
    static const double most[] = {[POSITION_BASED] = 21, [IMPLICIT] = 33, [XPBD] = 30};
    fixture* f = *state;
    for (int solver = POSITION_BASED; solver <= XPBD; ++solver) {
        pli_body* cloth = make_cloth(f->world, 0, 0.03f, 10);
        enable_solver(cloth, (solver_kind)solver);
        enable_faces(cloth);
        enable_nodes(cloth);
        pli_rigid* box = make_box(f->world, 0.2f, 1.5f, pli_vec3_make(0.05f, 0.02f, -0.1f));
        float fastest = 0;
        for (int i = 0; i < 60; ++i) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
            assert_int_equal(pli_rigid_integrate(box, gravity, 1.0f / 60.0f), PLI_OK);
            fastest = fmaxf(fastest, fastest_node(cloth));
        }
        print_message("solver %d: %.1f m/s\n", solver, (double)fastest);
        check_at_most(fastest, most[solver]);
        pli_body_destroy(cloth);
        pli_rigid_destroy(box);
    }
}

static void check_refused(fixture* f, pli_body* body, pli_rigid_face_contacts_def def, pli_status status,
                          const char* message) {
    assert_int_equal(pli_body_enable_rigid_face_contacts(body, &def), status);
    assert_non_null(strstr(pli_last_error(f->context), message));
}

static void test_face_contacts_refuse_bad_input(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.02f, 4);
    const pli_rigid_face_contacts_def good = pli_rigid_face_contacts_def_default();
    pli_rigid_face_contacts_def def = good;
    assert_int_equal(pli_body_enable_rigid_face_contacts(NULL, &def), PLI_ERROR_NULL_ARGUMENT);
    def.cookie = 0;
    check_refused(f, cloth, def, PLI_ERROR_INVALID_DEF, "pli_rigid_face_contacts_def_default");
    def = good;
    def.friction = -1;
    check_refused(f, cloth, def, PLI_ERROR_INVALID_VALUE, "friction is -1");
    def.friction = NAN;
    check_refused(f, cloth, def, PLI_ERROR_NOT_FINITE, "friction");
    def = good;
    def.dynamic_hardness = 1.5f;
    check_refused(f, cloth, def, PLI_ERROR_INVALID_VALUE, "dynamic_hardness is 1.5");
    def = good;
    def.static_hardness = INFINITY;
    check_refused(f, cloth, def, PLI_ERROR_NOT_FINITE, "static_hardness");
    assert_int_equal(pli_body_get_rigid_face_contacts(NULL, 0, NULL), 0);
    assert_int_equal(pli_body_disable_rigid_face_contacts(NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_false(pli_rigid_get_shift(NULL, NULL, NULL));
}

/* The bounds of a predicted body hold where it comes from, so that hosts find what it has passed. */
static void test_a_margin_that_is_set_in_a_step_keeps_its_way(void** state) {
    const fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.05f, 4);
    enable_faces(cloth);
    assert_int_equal(pli_body_add_velocity(cloth, pli_vec3_make(0, -60, 0)), PLI_OK);
    assert_int_equal(pli_world_predict(f->world, 1.0f / 60.0f), PLI_OK);
    check_near(pli_body_get_bounds(cloth).max.y, 0.05, 1e-6);
    assert_int_equal(pli_body_set_collision_margin(cloth, 0.08f), PLI_OK);
    check_near(pli_body_get_bounds(cloth).max.y, 0.08, 1e-6);
    check_near(pli_body_get_bounds(cloth).min.y, -1 - 10 / 3600.0 - 0.08, 1e-5);
    assert_int_equal(pli_world_solve(f->world), PLI_OK);
    check_near(pli_body_get_bounds(cloth).max.y, -1 - 10 / 3600.0 + 0.08, 1e-5);
}

/* A cloth lies on a shelf, close below a lid of the same rigid body. When that goes, the shelf comes to have its index,
   and not the side on which the cloth was of it. */
static void test_sides_are_of_a_shape_and_not_of_an_index(void** state) {
    fixture* f = *state;
    pli_body* cloth = make_cloth(f->world, 0, 0.02f, 10);
    enable_faces(cloth);
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_box(f->context, pli_vec3_make(2, 0.1f, 2), &shape), PLI_OK);
    pli_shape* other = NULL;
    assert_int_equal(pli_shape_create_box(f->context, pli_vec3_make(2, 0.1f, 2), &other), PLI_OK);
    pli_shape* const shapes[] = {shape, other};
    const pli_transform poses[] = {at(0, 0.125f, 0), at(0, -0.121f, 0)};
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 2;
    def.shapes = shapes;
    def.shape_poses = poses;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(f->world, &def, &rigid), PLI_OK);
    for (int i = 0; i < 20; ++i) {
        assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
    }
    assert_int_equal(pli_rigid_set_shapes(rigid, 1, shapes + 1, poses + 1), PLI_OK);
    for (int i = 0; i < 30; ++i) {
        assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
    }
    const pli_body_view view = pli_body_get_view(cloth);
    for (int i = 0; i < view.node_count; ++i) {
        check_near(view.positions[i].y, 0, 0.01);
    }
    pli_shape_release(shape);
    pli_shape_release(other);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_margin_that_is_set_in_a_step_keeps_its_way, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_balls_do_not_pass_a_coarse_cloth, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_sides_are_of_a_shape_and_not_of_an_index, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_balls_pass_without_face_contacts, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_boxes_and_sticks_do_not_pass_a_coarse_cloth, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_heavy_boxes_do_not_pass_a_coarse_cloth, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_heavy_boxes_come_to_rest, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_bodies_go_back_to_their_side, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_triangle_meshes_do_not_pass_a_coarse_cloth, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_peak_of_a_mesh_holds_a_cloth, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_edges_of_a_flat_mesh_do_not_catch, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_static_point_stops_a_falling_cloth, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_stick_does_not_pass_a_rope, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_face_contacts_keep_momentum, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_pinned_face_stops_a_ball_at_the_margin, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_hosts_that_move_bodies_before_the_solve, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_hosts_may_move_bodies_before_substeps, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_kinematic_bodies_carry_faces_in_substeps, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_shapes_may_change_before_the_solve, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_resting_cloth_is_as_with_nodes_alone, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_flat_faces_are_left_to_their_nodes, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_face_contacts_repeat_bit_for_bit, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_face_contacts_come_and_go, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_cutting_ends_face_contacts, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_steps_with_face_contacts_allocate_nothing, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_faces_with_anchored_nodes, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_planes_have_no_face_contacts, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_broken_support_makes_no_contacts, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_large_grounds_give_no_energy, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_faces_with_pinned_nodes_inside_the_margin_stay_calm, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_node_that_bears_little_is_not_thrown_away, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_bodies_that_press_on_a_cloth_do_not_pull_it_apart, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_drum_takes_a_rope_with_it, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_box_put_into_a_cloth_does_not_throw_it_away, setup_fixture,
                                        teardown_fixture),
        cmocka_unit_test_setup_teardown(test_face_contacts_refuse_bad_input, setup_fixture, teardown_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
