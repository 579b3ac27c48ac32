/* Refining and cutting: parts, masses, rest lengths, surfaces that touch nothing or everything, features that follow,
   failures that change nothing. */

#include "check.h"
#include "failing_allocator.h"
#include "level_sheet.h"
#include "manifold.h"
#include "sample_mesh.h"
#include "world_fixture.h"

#include <pliant/pliant.h>

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const float dt = 1.0f / 60.0f;

static int part_count(const pli_body* body) {
    int count = -1;
    assert_int_equal(pli_body_count_parts(body, &count), PLI_OK);
    return count;
}

static pli_body* take_mesh(const fixture* f, pli_mesh* mesh) {
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

/* 0.5 m cells in the plane y = 0 round the origin. */
static pli_body* make_sheet(const fixture* f, int nodes, int pins, bool bending) {
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(f->context, nodes, 0.0f, pins, &mesh), PLI_OK);
    if (bending) { assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, NULL), PLI_OK); }
    assert_int_equal(pli_mesh_set_total_mass(mesh, 2.0f), PLI_OK);
    return take_mesh(f, mesh);
}

static pli_body* make_rope(const fixture* f, int inner_nodes) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(f->context, pli_vec3_make(0, 0, 0),
                                          pli_vec3_make((float)(inner_nodes + 1), 0, 0), inner_nodes, 0, &mesh),
                     PLI_OK);
    return take_mesh(f, mesh);
}

static pli_vec3 xyz(pli_vec4 v) {
    return pli_vec3_make(v.x, v.y, v.z);
}

static const int* link_nodes(const pli_body_view* view, int link) {
    return view->link_nodes + link * view->link_node_stride;
}

// ---------------------------------------------------------------------------------------------------- surfaces

typedef struct ball {
    pli_vec3 centre;
    float radius;
} ball;

static float ball_surface(pli_vec3 point, void* user) {
    const ball* b = user;
    return pli_vec3_length(pli_vec3_sub(point, b->centre)) - b->radius;
}

/* x = *user */
static float wall_surface(pli_vec3 point, void* user) {
    return point.x - *(const float*)user;
}

/* Upright cylinder, for discs. */
static float pipe_surface(pli_vec3 point, void* user) {
    const ball* b = user;
    const pli_vec3 d = pli_vec3_make(point.x - b->centre.x, 0, point.z - b->centre.z);
    return pli_vec3_length(d) - b->radius;
}

static pli_status refine(pli_body* body, float (*surface)(pli_vec3, void*), void* user) {
    pli_refine_def def = pli_refine_def_default();
    def.surface = surface;
    def.user = user;
    return pli_body_refine(body, &def);
}

// ------------------------------------------------------------------------------------------------------- checks

typedef struct counts {
    int nodes, links, faces;
    uint64_t hash;
    float mass;
    size_t bytes;
} counts;

static counts count_all(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    return (counts){view.node_count,           view.link_count,           view.face_count,
                    pli_body_state_hash(body), pli_body_total_mass(body), pli_body_bytes(body)};
}

/* But for room for more, which stays. */
static void check_same_state(const pli_body* body, counts before) {
    const counts now = count_all(body);
    assert_int_equal(now.nodes, before.nodes);
    assert_int_equal(now.links, before.links);
    assert_int_equal(now.faces, before.faces);
    assert_true(now.hash == before.hash && now.mass == before.mass);
}

static void check_unchanged(const pli_body* body, counts before) {
    check_same_state(body, before);
    assert_true(pli_body_bytes(body) == before.bytes);
}

static void check_finite(const pli_body* body) {
    assert_false(pli_body_is_frozen(body));
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        assert_true(isfinite(view.positions[i].x) && isfinite(view.positions[i].y) && isfinite(view.positions[i].z));
        assert_true(view.positions[i].w >= 0.0f && isfinite(view.positions[i].w));
    }
}

static void check_same_mass(const pli_body* body, float mass) {
    check_near(pli_body_total_mass(body), mass, 1e-5 * (double)mass);
}

static void run(const fixture* f, int steps) {
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    }
}

// ----------------------------------------------------------------------------------------------------- refining

static void test_wall_parts_a_sheet(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    float x = 0.2f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 2);
    check_manifold(body);
    check_same_mass(body, 2.0f);
    const pli_body_view view = pli_body_get_view(body);
    /* 9 edges along x and 8 diagonals are crossed; each new node comes twice. */
    assert_int_equal(view.node_count, 81 + 2 * 17);
    for (int i = 81; i < view.node_count; ++i) {
        check_near(view.positions[i].x, 0.2, 1e-4);
    }
    /* The parts fall apart when pulled. */
    for (int i = 0; i < view.node_count; ++i) {
        assert_int_equal(pli_body_set_node_velocity(body, i, pli_vec3_make(view.positions[i].x < 0.2f ? -1 : 1, 0, 0)),
                         PLI_OK);
    }
    run(f, 30);
    check_finite(body);
    assert_true(pli_body_max_stretch(body) < 0.2f);
}

static void test_refine_without_cut_keeps_one_part(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    ball b = {{0.1f, 0, 0.2f}, 0.9f};
    pli_refine_def def = pli_refine_def_default();
    def.surface = ball_surface;
    def.user = &b;
    def.cut = false;
    assert_int_equal(pli_body_refine(body, &def), PLI_OK);
    assert_int_equal(part_count(body), 1);
    check_manifold(body);
    check_same_mass(body, 2.0f);
    run(f, 10);
    check_finite(body);
}

/* Both modes differ in lengths, not in what is where. */
static void test_modes_give_the_same_topology(void** state) {
    const fixture* f = *state;
    pli_body* bodies[2] = {make_sheet(f, 12, 0, true), make_sheet(f, 12, 0, true)};
    const ball balls[3] = {{{0.3f, 0, 0.4f}, 0.9f}, {{-0.8f, 0, 0.1f}, 0.8f}, {{0.1f, 0, -0.9f}, 1.0f}};
    for (int cut = 0; cut < 3; ++cut) {
        ball b = balls[cut];
        for (int k = 0; k < 2; ++k) {
            pli_refine_def def = pli_refine_def_default();
            def.surface = ball_surface;
            def.user = &b;
            def.reset_rest_lengths = k == 1;
            assert_int_equal(pli_body_refine(bodies[k], &def), PLI_OK);
        }
        const pli_body_view a = pli_body_get_view(bodies[0]), c = pli_body_get_view(bodies[1]);
        assert_int_equal(a.node_count, c.node_count);
        assert_int_equal(a.link_count, c.link_count);
        assert_int_equal(a.face_count, c.face_count);
        for (int i = 0; i < a.link_count; ++i) {
            assert_memory_equal(link_nodes(&a, i), link_nodes(&c, i), 2 * sizeof(int));
        }
        assert_memory_equal(a.face_nodes, c.face_nodes, 3 * (size_t)a.face_count * sizeof(int));
    }
}

/* A sheet that is stretched to twice its size is cut: rest lengths are those of the small sheet. */
static void test_rest_lengths_are_those_of_the_rest_shape(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    pli_body* reset = make_sheet(f, 9, 0, false);
    pli_vec3 positions[81];
    for (int i = 0; i < 81; ++i) {
        positions[i] = pli_vec3_scale(xyz(pli_body_get_view(body).positions[i]), 2.0f);
    }
    assert_int_equal(pli_body_set_state(body, positions, NULL), PLI_OK);
    assert_int_equal(pli_body_set_state(reset, positions, NULL), PLI_OK);
    ball b = {{0.3f, 0, 0.1f}, 1.7f};
    assert_int_equal(refine(body, ball_surface, &b), PLI_OK);
    pli_refine_def def = pli_refine_def_default();
    def.surface = ball_surface;
    def.user = &b;
    def.reset_rest_lengths = true;
    assert_int_equal(pli_body_refine(reset, &def), PLI_OK);
    const pli_body_view view = pli_body_get_view(body);
    assert_true(view.node_count > 81 + 20);
    for (int i = 0; i < view.link_count; ++i) {
        const int* n = link_nodes(&view, i);
        const float length = pli_vec3_length(pli_vec3_sub(xyz(view.positions[n[0]]), xyz(view.positions[n[1]])));
        check_near(pli_body_get_rest_length(body, i), 0.5 * (double)length, 2e-6);
        check_near(pli_body_get_rest_length(reset, i), length, 1e-6);
    }
    check_near(pli_body_max_stretch(reset), 0.0, 1e-6);
    /* Lengths can be set as before. */
    assert_int_equal(pli_body_set_rest_length(body, view.link_count - 1, 3.0f), PLI_OK);
    check_near(pli_body_get_rest_length(body, view.link_count - 1), 3.0, 1e-6);
}

static void test_surfaces_that_meet_nothing_change_nothing(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 6, 0, true);
    const counts before = count_all(body);
    ball outside = {{0, 50, 0}, 3.0f}, around = {{0, 0, 0}, 50.0f};
    assert_int_equal(refine(body, ball_surface, &outside), PLI_OK);
    check_unchanged(body, before);
    assert_int_equal(refine(body, ball_surface, &around), PLI_OK);
    check_unchanged(body, before);
    float edge = -1.25f; /* the first column of nodes, with all else on one side */
    for (int side = 0; side < 2; ++side, edge = -edge) {
        assert_int_equal(refine(body, wall_surface, &edge), PLI_OK);
        const counts now = count_all(body);
        assert_int_equal(now.nodes, before.nodes);
        assert_int_equal(now.faces, before.faces);
        assert_int_equal(part_count(body), 1);
    }
    run(f, 5);
    check_finite(body);
}

static float everywhere_zero(pli_vec3 point, void* user) {
    (void)point;
    (void)user;
    return 0.0f;
}

static void test_zero_on_all_of_a_body(void** state) {
    const fixture* f = *state;
    pli_body* bodies[3] = {make_sheet(f, 5, 0, false), make_rope(f, 6), NULL};
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_ellipsoid(f->context, pli_vec3_make(1, 1, 1), &mesh), PLI_OK);
    bodies[2] = take_mesh(f, mesh);
    for (int i = 0; i < 3; ++i) {
        const counts before = count_all(bodies[i]);
        assert_int_equal(refine(bodies[i], everywhere_zero, NULL), PLI_OK);
        check_unchanged(bodies[i], before);
        /* Bullet's rule doubles all. */
        pli_refine_def def = pli_refine_def_default();
        def.surface = everywhere_zero;
        def.reset_rest_lengths = true;
        assert_int_equal(pli_body_refine(bodies[i], &def), PLI_OK);
        assert_int_equal(pli_body_get_view(bodies[i]).node_count, 2 * before.nodes);
        check_same_mass(bodies[i], before.mass);
    }
    run(f, 5);
}

static void test_cut_along_nodes_makes_no_new_edges(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    const pli_body_view before = pli_body_get_view(body);
    float x = 0.5f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    const pli_body_view view = pli_body_get_view(body);
    assert_int_equal(view.node_count, before.node_count + 9);
    assert_int_equal(view.link_count, before.link_count + 8);
    assert_int_equal(view.face_count, before.face_count);
    assert_int_equal(part_count(body), 2);
    check_manifold(body);
    check_same_mass(body, 2.0f);
}

/* Bullet cannot detach the first link of a body. */
static void test_first_link_is_detached_too(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 5, 0, false);
    float x = -0.75f; /* crosses link 0, from node 0 to node 1 */
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 2);
    check_manifold(body);
}

static void test_rope_is_cut_in_two(void** state) {
    const fixture* f = *state;
    pli_body* body = make_rope(f, 8);
    float x = 4.25f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 2);
    const pli_body_view view = pli_body_get_view(body);
    assert_int_equal(view.node_count, 12);
    assert_int_equal(view.link_count, 10);
    check_near(pli_body_get_rest_length(body, 4), 0.25, 1e-4);
    check_near(pli_body_get_rest_length(body, 9), 0.75, 1e-4);
    check_same_mass(body, 10.0f);
    x = 7.0f; /* at a node */
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 3);
    check_same_mass(body, 10.0f);
}

static void test_closed_surface_falls_into_bowls(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_ellipsoid(f->context, pli_vec3_make(1, 2, 1), &mesh), PLI_OK);
    pli_body* body = take_mesh(f, mesh);
    const float mass = pli_body_total_mass(body);
    float x = 0.11f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 2);
    x = -0.52f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 3);
    check_manifold(body);
    check_same_mass(body, mass);
}

static void test_several_components_are_cut_together(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    for (int part = 0; part < 3; ++part) { /* two triangles each, side by side along z */
        const float z = 2.0f * (float)part;
        const pli_vec3 points[4] = {{-1, 0, z}, {1, 0, z}, {1, 0, z + 1}, {-1, 0, z + 1}};
        int n[4];
        for (int i = 0; i < 4; ++i) {
            assert_int_equal(pli_mesh_append_node(mesh, points[i], 1.0f, &n[i]), PLI_OK);
        }
        /* Without links: faces alone are cut too. */
        assert_int_equal(pli_mesh_append_face(mesh, n[0], n[1], n[2], 0, NULL), PLI_OK);
        assert_int_equal(pli_mesh_append_face(mesh, n[0], n[2], n[3], 0, NULL), PLI_OK);
    }
    pli_body* body = take_mesh(f, mesh);
    assert_int_equal(part_count(body), 3);
    float x = 0.25f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 6);
    check_manifold(body);
    check_same_mass(body, 12.0f);
}

/* A jump has no zero; regula falsi does not find it and bisection does. */
static float jump_surface(pli_vec3 point, void* user) {
    return point.x < *(const float*)user ? -5.0f : 0.5f;
}

static void test_jump_of_the_surface_is_cut(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    float x = 0.2f;
    assert_int_equal(refine(body, jump_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 2);
    check_manifold(body);
    for (int i = 81; i < pli_body_get_view(body).node_count; ++i) {
        check_near(pli_body_get_view(body).positions[i].x, 0.2, 1e-6);
    }
}

static void test_materials_and_kinds_are_carried_on(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    const pli_vec3 points[6] = {{-1, 0, 0}, {1, 0, 0}, {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {5, 0, 1}};
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, points[i], 1.0f, NULL), PLI_OK);
    }
    const pli_material soft = {0.25f};
    int material = 0;
    assert_int_equal(pli_mesh_append_material(mesh, &soft, &material), PLI_OK);
    assert_int_equal(pli_mesh_append_link(mesh, 0, 1, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 3, 4, 5, 0, NULL), PLI_OK); /* not cut */
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, material, NULL), PLI_OK);
    pli_body* body = take_mesh(f, mesh);
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.position_iterations = 1;
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    float x = 0.0f;
    pli_refine_def def = pli_refine_def_default();
    def.surface = wall_surface;
    def.user = &x;
    def.cut = false;
    assert_int_equal(pli_body_refine(body, &def), PLI_OK);
    const pli_body_view view = pli_body_get_view(body);
    assert_int_equal(view.link_count, 3);
    assert_int_equal(link_nodes(&view, 2)[0], 6);
    assert_int_equal(link_nodes(&view, 2)[1], 2);
    /* A soft link closes a quarter of its error in a step, a hard one nearly all of it. */
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    assert_int_equal(pli_body_set_rest_length(body, 2, 1.1f), PLI_OK);
    run(f, 1);
    const float length = pli_vec3_length(
        pli_vec3_sub(xyz(pli_body_get_view(body).positions[6]), xyz(pli_body_get_view(body).positions[2])));
    check_near(length, 1.025, 2e-3);
}

// ------------------------------------------------------------------------------------------------------- errors

static float nan_surface(pli_vec3 point, void* user) {
    return ball_surface(point, user) < 0.2f ? NAN : 1.0f;
}

/* NaN only near its zero, where nodes are not but new ones would be. */
static float nan_between_surface(pli_vec3 point, void* user) {
    const float value = wall_surface(point, user);
    return fabsf(value) < 0.1f ? NAN : value;
}

static float infinite_surface(pli_vec3 point, void* user) {
    (void)user;
    return point.x > 0.3f ? INFINITY : -1.0f;
}

static void test_bad_input_changes_nothing(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 6, PLI_PATCH_PIN_CORNERS, true);
    const counts before = count_all(body);
    ball b = {{0, 0, 0}, 1.0f};
    float x = 0.0f;
    assert_int_equal(refine(body, nan_surface, &b), PLI_ERROR_NOT_FINITE);
    assert_non_null(strstr(pli_last_error(f->context), "the surface is"));
    assert_int_equal(refine(body, nan_between_surface, &x), PLI_ERROR_NOT_FINITE);
    assert_int_equal(refine(body, infinite_surface, NULL), PLI_ERROR_NOT_FINITE);
    assert_int_equal(refine(body, NULL, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_refine(body, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_refine(NULL, NULL), PLI_ERROR_NULL_ARGUMENT);
    pli_refine_def def = pli_refine_def_default();
    def.surface = wall_surface;
    def.user = &x;
    const float bad[4] = {0.0f, -1.0f, NAN, INFINITY};
    for (int i = 0; i < 4; ++i) {
        def.accuracy = bad[i];
        assert_int_equal(pli_body_refine(body, &def), i < 2 ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE);
    }
    def.accuracy = 1e-4f;
    def.cookie = 0;
    assert_int_equal(pli_body_refine(body, &def), PLI_ERROR_INVALID_DEF);

    assert_int_equal(pli_body_cut_link(NULL, 0, 1, 0.5f), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_cut_link(body, -1, 1, 0.5f), PLI_ERROR_INDEX_OUT_OF_RANGE);
    assert_int_equal(pli_body_cut_link(body, 0, 36, 0.5f), PLI_ERROR_INDEX_OUT_OF_RANGE);
    assert_int_equal(pli_body_cut_link(body, 3, 3, 0.5f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_cut_link(body, 0, 35, 0.5f), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(f->context), "no link joins nodes 0 and 35"));
    assert_int_equal(pli_body_cut_link(body, 0, 1, 0.0f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_cut_link(body, 0, 1, 1.0f), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_body_cut_link(body, 0, 1, NAN), PLI_ERROR_NOT_FINITE);
    assert_int_equal(pli_body_cut_link(body, 0, 1, INFINITY), PLI_ERROR_NOT_FINITE);

    const pli_vec3 zero = {0, 0, 0}, far = {0, INFINITY, 0};
    assert_int_equal(pli_body_cut_swept(NULL, zero, zero, zero, zero, NULL), PLI_ERROR_NULL_ARGUMENT);
    int parted = 77;
    assert_int_equal(pli_body_cut_swept(body, zero, far, zero, zero, &parted), PLI_ERROR_NOT_FINITE);
    assert_int_equal(parted, 77);
    int parts = 0;
    assert_int_equal(pli_body_count_parts(NULL, &parts), PLI_ERROR_NULL_ARGUMENT);

    assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
    assert_int_equal(refine(body, wall_surface, &x), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_body_cut_link(body, 0, 1, 0.5f), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_body_cut_swept(body, zero, zero, zero, zero, NULL), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_solve(f->world), PLI_OK);
    const counts after = count_all(body);
    assert_int_equal(after.nodes, before.nodes);
    assert_int_equal(after.links, before.links);
}

static float cutting_surface(pli_vec3 point, void* user) {
    pli_body* body = user;
    assert_int_equal(pli_body_cut_link(body, 0, 1, 0.5f), PLI_ERROR_WRONG_STATE);
    return point.x - 0.2f;
}

static void test_surface_cannot_cut_the_body(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 6, 0, false);
    assert_int_equal(refine(body, cutting_surface, body), PLI_OK);
    run(f, 3);
    check_finite(body);
}

static void test_tetrahedra_are_refused(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    const pli_vec3 points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, points[i], 1.0f, NULL), PLI_OK);
        for (int k = 0; k < i; ++k) {
            assert_int_equal(pli_mesh_append_link(mesh, k, i, 0, NULL), PLI_OK);
        }
    }
    assert_int_equal(pli_mesh_append_tetra(mesh, 0, 1, 2, 3, 0, NULL), PLI_OK);
    pli_body* body = take_mesh(f, mesh);
    const counts before = count_all(body);
    float x = 0.3f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_ERROR_INVALID_MESH);
    assert_non_null(strstr(pli_last_error(f->context), "tetrahedron 0"));
    check_unchanged(body, before);
    assert_int_equal(pli_body_cut_link(body, 0, 1, 0.5f), PLI_ERROR_INVALID_MESH);
    check_unchanged(body, before);
    assert_int_equal(pli_body_cut_swept(body, pli_vec3_make(0.3f, -5, -5), pli_vec3_make(0.3f, 5, -5),
                                        pli_vec3_make(0.3f, -5, 5), pli_vec3_make(0.3f, 5, 5), NULL),
                     PLI_ERROR_INVALID_MESH);
    x = 3.0f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    check_near(count_all(body).mass, before.mass, 0.0);
    assert_int_equal(part_count(body), 1);
}

// ---------------------------------------------------------------------------------------------------- cut a link

static void test_link_is_cut_with_its_faces(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    const pli_vec3 points[4] = {{0, 0, 0}, {2, 0, 0}, {1, 0, 1}, {1, 0, -1}};
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, points[i], i == 0 ? 3.0f : 1.0f, NULL), PLI_OK);
    }
    const int links[5][2] = {{1, 0}, {0, 2}, {1, 2}, {0, 3}, {1, 3}};
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(pli_mesh_append_link(mesh, links[i][0], links[i][1], 0, NULL), PLI_OK);
    }
    assert_int_equal(pli_mesh_append_face(mesh, 0, 2, 1, 0, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 3, 0, NULL), PLI_OK);
    pli_body* body = take_mesh(f, mesh);
    assert_int_equal(pli_body_cut_link(body, 0, 1, 0.25f), PLI_OK);
    const pli_body_view view = pli_body_get_view(body);
    assert_int_equal(view.node_count, 6);
    assert_int_equal(view.link_count, 10);
    assert_int_equal(view.face_count, 4);
    assert_int_equal(part_count(body), 1);
    check_same_mass(body, 6.0f);
    check_near(view.positions[4].x, 0.5, 1e-6);
    check_near(view.positions[5].x, 0.5, 1e-6);
    assert_true(view.positions[4].w == view.positions[5].w);
    for (int i = 0; i < view.link_count; ++i) {
        const int* n = link_nodes(&view, i);
        check_near(pli_body_get_rest_length(body, i),
                   pli_vec3_length(pli_vec3_sub(xyz(view.positions[n[0]]), xyz(view.positions[n[1]]))), 1e-6);
    }
    run(f, 10);
    check_finite(body);

    pli_body* rope = make_rope(f, 2);
    assert_int_equal(pli_body_cut_link(rope, 2, 1, 0.5f), PLI_OK);
    assert_int_equal(part_count(rope), 2);
    check_same_mass(rope, 4.0f);

    pli_body* sheet = make_sheet(f, 6, 0, false);
    assert_int_equal(pli_body_cut_link(sheet, 14, 15, 0.3f), PLI_OK);
    check_manifold(sheet);
    assert_int_equal(part_count(sheet), 1);
    check_same_mass(sheet, 2.0f);
}

// ------------------------------------------------------------------------------------------------- swept cutting

/* Upright blades through the plane of the sheet. */
static int sweep(pli_body* body, float x0, float z0, float x1, float z1) {
    int parted = -1;
    assert_int_equal(pli_body_cut_swept(body, pli_vec3_make(x0, 5, z0), pli_vec3_make(x0, -5, z0),
                                        pli_vec3_make(x1, 5, z1), pli_vec3_make(x1, -5, z1), &parted),
                     PLI_OK);
    return parted;
}

static void test_swept_cut_opens_a_sheet(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, true);
    assert_int_equal(sweep(body, 5, 5, 6, 6), 0);
    assert_int_equal(pli_body_get_view(body).node_count, 81);
    assert_true(sweep(body, -0.1f, -3, 0.3f, 3) > 15);
    assert_int_equal(part_count(body), 2);
    check_manifold(body);
    check_same_mass(body, 2.0f);
    for (int i = 0; i < pli_body_get_view(body).link_count; ++i) {
        assert_true(pli_body_get_rest_length(body, i) > 0.0f);
    }
    check_near(pli_body_max_stretch(body), 0.0, 1e-5);
    run(f, 20);
    check_finite(body);
}

/* A sheet that goes to and fro under short sweeps, which stay where they are in the world: across the cut, along it,
   and past the sweeps in their direction. The cut is one all the same. */
static void test_swept_cut_follows_a_sheet_that_moves(void** state) {
    const fixture* f = *state;
    const pli_vec3 motions[] = {{0, 0, 0},       {0, 0, 0.05f},   {0, 0, 0.3f}, {0.05f, 0.02f, 0.1f},
                                {0.1f, 0, 0.3f}, {-0.1f, 0, 0.1f}};
    for (int k = 0; k < (int)(sizeof motions / sizeof motions[0]); ++k) {
        pli_body* body = make_sheet(f, 17, 0, false);
        pli_transform motion = pli_transform_identity();
        const float start = pli_body_get_bounds(body).min.x - 0.1f;
        for (int i = 0; i < 100; ++i) {
            sweep(body, start + 0.13f * (float)i, 0.01f, start + 0.13f * (float)(i + 1), 0.01f);
            motion.origin = pli_vec3_scale(motions[k], i % 6 < 3 ? 1.0f : -1.0f);
            assert_int_equal(pli_body_transform(body, motion), PLI_OK);
        }
        print_message("motion %d: %d nodes, %d parts\n", k, pli_body_get_view(body).node_count, part_count(body));
        assert_int_equal(part_count(body), 2);
        check_manifold(body);
        check_same_mass(body, 2.0f);
        pli_body_destroy(body);
    }
}

static void test_swept_cut_through_nodes_opens_too(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    assert_int_equal(sweep(body, 0.5f, -3, 0.5f, 3), 8);
    assert_int_equal(part_count(body), 2);
    assert_int_equal(pli_body_get_view(body).node_count, 90);
    check_manifold(body);
    /* Along diagonals and across them. */
    assert_true(sweep(body, -3, -3, 3, 3) > 4);
    assert_int_equal(part_count(body), 4);
    check_manifold(body);
    check_same_mass(body, 2.0f);
}

static void test_cut_that_ends_inside_leaves_a_slit(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    assert_true(sweep(body, -3, 0.13f, 0.6f, 0.17f) > 0);
    assert_int_equal(part_count(body), 1);
    check_manifold(body);
    check_same_mass(body, 2.0f);
    /* A cut from inside to inside. */
    assert_true(sweep(body, -0.9f, -1.1f, 0.8f, -1.2f) > 0);
    assert_int_equal(part_count(body), 1);
    check_manifold(body);
    run(f, 20);
    check_finite(body);
}

/* The sheet moves a little between the sweeps, as a body does between frames. */
static void sweep_in_pieces(const fixture* f, pli_body* body, int count, pli_vec3 (*path)(float)) {
    for (int i = 0; i < count; ++i) {
        const pli_vec3 a = path((float)i / (float)count), b = path((float)(i + 1) / (float)count);
        sweep(body, a.x, a.z, b.x, b.z);
        check_manifold(body);
        if (i % 8 == 0) { run(f, 1); }
    }
}

static pli_vec3 straight_path(float t) {
    return pli_vec3_make(-2.6f + 5.2f * t, 0, 0.13f + 0.2f * t);
}

static pli_vec3 round_path(float t) {
    const float turn = 6.2831853f * t * 1.02f;
    return pli_vec3_make(1.1f * cosf(turn) + 0.03f, 0, 1.1f * sinf(turn) - 0.04f);
}

static void test_short_sweeps_make_one_cut(void** state) {
    const fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0.05f, 0, 0.02f)), PLI_OK);
    const int counts_of_pieces[4] = {1, 7, 40, 300};
    for (int i = 0; i < 4; ++i) {
        pli_body* body = make_sheet(f, 9, 0, false);
        sweep_in_pieces(f, body, counts_of_pieces[i], straight_path);
        assert_int_equal(part_count(body), 2);
        check_same_mass(body, 2.0f);
        pli_body_destroy(body);
    }
}

static void test_cut_that_returns_to_its_start_frees_a_disc(void** state) {
    const fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    const int counts_of_pieces[3] = {20, 60, 500};
    for (int i = 0; i < 3; ++i) {
        pli_body* body = make_sheet(f, 9, 0, true);
        sweep_in_pieces(f, body, counts_of_pieces[i], round_path);
        assert_int_equal(part_count(body), 2);
        check_manifold(body);
        check_same_mass(body, 2.0f);
        pli_body_destroy(body);
    }
}

static void test_many_random_sweeps_stay_manifold(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, PLI_PATCH_PIN_CORNERS, true);
    uint32_t seed = 1;
    float ends[4] = {0, 0, 0, 0};
    for (int i = 0; i < 60; ++i) {
        const bool goes_on = i % 3 != 0;
        for (int k = 0; k < 4; ++k) {
            seed = seed * 1664525u + 1013904223u;
            const float value = (float)(seed >> 8) / 16777216.0f * 5.0f - 2.5f;
            if (goes_on && k < 2) {
                ends[k] = ends[k + 2];
            } else {
                ends[k] = value;
            }
        }
        sweep(body, ends[0], ends[1], ends[2], ends[3]);
        check_manifold(body);
        check_near(pli_body_total_mass(body), 77.0 * 2.0 / 77.0, 1e-4);
    }
    run(f, 60);
    check_finite(body);
}

static void test_twisted_strip_is_cut(void** state) {
    const fixture* f = *state;
    pli_body* body = make_sheet(f, 9, 0, false);
    int parted = 0;
    assert_int_equal(pli_body_cut_swept(body, pli_vec3_make(-0.6f, 3, -3), pli_vec3_make(0.2f, -3, -3),
                                        pli_vec3_make(0.7f, 3, 3), pli_vec3_make(-0.3f, -3, 3), &parted),
                     PLI_OK);
    assert_true(parted > 10);
    assert_int_equal(part_count(body), 2);
    check_manifold(body);
}

static void test_swept_cut_of_ropes(void** state) {
    const fixture* f = *state;
    pli_body* body = make_rope(f, 8);
    assert_int_equal(sweep(body, 2.3f, -1, 2.3f, 1), 1);
    assert_int_equal(part_count(body), 2);
    assert_int_equal(sweep(body, 6, -1, 6, 1), 1); /* at a node */
    assert_int_equal(part_count(body), 3);
    check_same_mass(body, 10.0f);
    assert_int_equal(sweep(body, 4.5f, -1, 4.5f, -0.1f), 0); /* beside it */
    assert_int_equal(sweep(body, 4.5f, 0, 4.5f, 0), 0);      /* no sweep */
    run(f, 10);
    check_finite(body);
}

/* A rope that hangs on a sheet, and one that braces it. */
static void test_links_without_faces(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(f->context, 5, 0.0f, 0, &mesh), PLI_OK);
    int node = 0;
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(3, 0, 0), 1.0f, &node), PLI_OK);
    assert_int_equal(pli_mesh_append_link(mesh, 14, node, 0, NULL), PLI_OK); /* from (1, 0, 0) */
    assert_int_equal(pli_mesh_append_link(mesh, 0, 4, 0, NULL), PLI_OK);     /* along z = -1 */
    pli_body* body = take_mesh(f, mesh);
    assert_int_equal(sweep(body, 2, -1, 2, 1), 1);
    assert_int_equal(part_count(body), 2);
    assert_true(sweep(body, 0.2f, -2, 0.2f, 2) > 0);
    assert_int_equal(part_count(body), 3);
    check_manifold(body);
}

// ------------------------------------------------------------------------------------- features and long runs

static pli_rigid* make_floor(const fixture* f, float height) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_plane(f->context, pli_vec3_make(0, 1, 0), height, &shape), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_STATIC;
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(f->world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
    return rigid;
}

static void enable_everything(pli_body* body, pli_rigid* floor_rigid) {
    const pli_rigid_contacts_def rigid_contacts = pli_rigid_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_contacts(body, &rigid_contacts), PLI_OK);
    pli_soft_contacts_def soft_contacts = pli_soft_contacts_def_default();
    soft_contacts.bullet_boxes = true;
    assert_int_equal(pli_body_enable_soft_contacts(body, &soft_contacts), PLI_OK);
    pli_aero_def aero = pli_aero_def_default();
    aero.drag = 0.01f;
    assert_int_equal(pli_body_enable_aero(body, &aero), PLI_OK);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.node = 0;
    anchor.rigid = floor_rigid;
    assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK);
}

static void enable_clusters(pli_body* body, pli_rigid* rigid) {
    const pli_clusters_def def = pli_clusters_def_default();
    assert_int_equal(pli_body_enable_clusters(body, &def), PLI_OK);
    assert_int_equal(pli_body_generate_clusters(body, 4, 100, NULL), PLI_OK);
    const pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    pli_linear_joint_def joint = pli_linear_joint_def_default();
    joint.other.rigid = rigid;
    joint.position = xyz(pli_body_get_view(body).positions[0]);
    assert_int_equal(pli_body_add_linear_joint(body, &joint, NULL), PLI_OK);
}

static int count_cluster_members(const pli_body* body) {
    int members = 0;
    for (int i = 0; i < pli_body_cluster_count(body); ++i) {
        pli_cluster_view view;
        assert_int_equal(pli_body_get_cluster(body, i, &view), PLI_OK);
        members += view.node_count;
    }
    return members;
}

/* New nodes join the clusters of their parents. */
static void test_clusters_and_joints_follow(void** state) {
    const fixture* f = *state;
    pli_rigid* floor_rigid = make_floor(f, -1.0f);
    pli_body* body = make_sheet(f, 9, 0, false);
    enable_clusters(body, floor_rigid);
    const int members = count_cluster_members(body);
    run(f, 5);
    float x = 0.2f;
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    sweep(body, -3, 0.3f, 3, 0.31f);
    assert_int_equal(pli_body_cluster_count(body), 4);
    assert_int_equal(pli_body_joint_count(body), 1);
    assert_true(count_cluster_members(body) > members);
    run(f, 60);
    check_finite(body);
}

static void test_seven_cuts_and_a_disc_with_contacts(void** state) {
    const fixture* f = *state;
    pli_rigid* floor_rigid = make_floor(f, -2.0f);
    pli_body* below = make_sheet(f, 9, 0, false);
    assert_int_equal(pli_body_transform(below, (pli_transform){pli_mat3_identity(), {0.1f, -1.0f, 0}}), PLI_OK);
    pli_body* body = make_sheet(f, 17, PLI_PATCH_PIN_CORNERS, true);
    enable_everything(below, floor_rigid);
    enable_everything(body, floor_rigid);
    const float mass = pli_body_total_mass(body);
    const float xs[7] = {-1.1f, 0.9f, 0.1f, 2.0f, -2.3f, 0.4f, -0.7f};
    for (int i = 0; i < 7; ++i) {
        run(f, 10);
        const pli_body_view view = pli_body_get_view(body);
        ball b = {pli_vec3_add(xyz(view.positions[17 * 8 + 8]), pli_vec3_make(xs[i], 0, xs[6 - i])), 0.8f};
        assert_int_equal(refine(body, ball_surface, &b), PLI_OK);
        check_same_mass(body, mass);
        check_manifold(body);
    }
    const int parts = part_count(body);
    assert_true(parts >= 3);
    run(f, 5);
    ball b = {{1.7f, 0, -2.6f}, 0.9f};
    assert_int_equal(refine(body, pipe_surface, &b), PLI_OK);
    assert_true(part_count(body) > parts);
    check_manifold(body);
    check_same_mass(body, mass);
    run(f, 150);
    sweep(body, -5, 0.3f, 5, 0.4f);
    run(f, 150);
    check_finite(body);
    check_finite(below);
    check_same_mass(body, mass);
    assert_true(pli_body_get_bounds(body).max.y < 2.0f && pli_body_get_bounds(body).min.y > -20.0f);
}

static void test_pressure_pose_and_velocity_links_follow(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_ellipsoid(f->context, pli_vec3_make(1, 1, 1), &mesh), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.solver.velocity_iterations = 2;
    def.solver.drift_iterations = 1;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    assert_int_equal(pli_body_enable_pressure(body, 0.0f), PLI_OK);
    assert_int_equal(pli_body_enable_volume_conservation(body, 0.0f), PLI_OK);
    assert_int_equal(pli_body_enable_pose_matching(body, 0.5f), PLI_OK);
    assert_int_equal(pli_body_enable_velocity_links(body), PLI_OK);
    run(f, 5);
    float x = 0.13f;
    pli_refine_def refine_def = pli_refine_def_default();
    refine_def.surface = wall_surface;
    refine_def.user = &x;
    refine_def.cut = false;
    assert_int_equal(pli_body_refine(body, &refine_def), PLI_OK);
    const int node_count = pli_body_get_view(body).node_count;
    assert_true(node_count > SAMPLE_SPHERE_NODES + 20);
    assert_int_equal(refine(body, wall_surface, &x), PLI_OK);
    assert_int_equal(part_count(body), 2);
    const pli_vec3 before = xyz(pli_body_get_view(body).positions[node_count - 1]);
    run(f, 30);
    check_finite(body);
    /* At rest before, and at rest after: new nodes are where the rest pose has them. */
    const pli_vec3 after = xyz(pli_body_get_view(body).positions[node_count - 1]);
    check_near(pli_vec3_length(pli_vec3_sub(after, before)), 0.0, 1e-3);
    const pli_body_view view = pli_body_get_view(body);
    assert_non_null(view.normals);
    for (int i = 0; i < view.node_count; ++i) {
        check_near(pli_vec3_length(view.normals[i]), 1.0, 1e-5);
    }
}

/* Bodies of one mesh share its faces until one is cut. */
static void test_other_bodies_of_the_mesh_stay(void** state) {
    const fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(f->context, 6, 0.0f, 0, &mesh), PLI_OK);
    pli_body *cut = NULL, *other = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, NULL, &cut), PLI_OK);
    assert_int_equal(pli_body_create(f->world, mesh, NULL, &other), PLI_OK);
    const counts before = count_all(other);
    float x = 0.1f;
    assert_int_equal(refine(cut, wall_surface, &x), PLI_OK);
    check_unchanged(other, before);
    assert_int_equal(part_count(other), 1);
    pli_body* later = take_mesh(f, mesh);
    assert_int_equal(pli_body_get_view(later).face_count, before.faces);
}

static void test_large_sheet(void** state) {
    const fixture* f = *state;
    pli_patch_def def = level_sheet(1, 0, 256);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(f->context, &def, &mesh), PLI_OK);
    pli_body* body = take_mesh(f, mesh);
    const float mass = pli_body_total_mass(body);
    ball b = {{0.1f, 0, 0.05f}, 0.7f};
    assert_int_equal(refine(body, pipe_surface, &b), PLI_OK);
    assert_int_equal(part_count(body), 2);
    assert_true(sweep(body, -2, 0.3f, 2, 0.31f) > 300);
    assert_int_equal(part_count(body), 4);
    check_manifold(body);
    check_same_mass(body, mass);
}

// -------------------------------------------------------------------------------------------- all or nothing

typedef enum cut_kind { CUT_REFINE, CUT_REFINE_RESET, CUT_LINK, CUT_SWEPT } cut_kind;

static pli_status cut_some_way(pli_body* body, cut_kind kind) {
    ball b = {{0.1f, 0, 0.2f}, 0.6f};
    pli_refine_def def = pli_refine_def_default();
    def.surface = ball_surface;
    def.user = &b;
    def.reset_rest_lengths = kind == CUT_REFINE_RESET;
    if (kind == CUT_LINK) { return pli_body_cut_link(body, 6, 7, 0.5f); }
    if (kind == CUT_SWEPT) {
        return pli_body_cut_swept(body, pli_vec3_make(0, 5, -3), pli_vec3_make(0.1f, -5, -3),
                                  pli_vec3_make(-0.1f, 5, 3), pli_vec3_make(0.2f, -5, 3), NULL);
    }
    return pli_body_refine(body, &def);
}

/* All features are enabled; where the cut fails nothing has changed. */
static void test_lack_of_memory_changes_nothing(void** state) {
    (void)state;
    for (int kind = CUT_REFINE; kind <= CUT_SWEPT; ++kind) {
        failing_allocator allocator;
        fixture f = {.context = failing_context(&allocator)};
        assert_int_equal(pli_world_create(f.context, NULL, &f.world), PLI_OK);
        pli_rigid* floor_rigid = make_floor(&f, -0.2f);
        pli_mesh* mesh = NULL;
        assert_int_equal(sample_create_sheet(f.context, 6, 0.0f, 0, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, NULL), PLI_OK);
        pli_body* body = take_mesh(&f, mesh);
        enable_everything(body, floor_rigid);
        enable_clusters(body, floor_rigid);
        assert_int_equal(pli_body_enable_pressure(body, 0.1f), PLI_OK);
        assert_int_equal(pli_body_enable_pose_matching(body, 0.1f), PLI_OK);
        assert_int_equal(pli_body_enable_velocity_links(body), PLI_OK);
        run(&f, 3);
        const counts before = count_all(body);
        const long alive = allocator.alive;
        int failures = 0;
        for (;; ++failures) {
            allocator.fail_at = failures + 1;
            const pli_status status = cut_some_way(body, (cut_kind)kind);
            allocator.fail_at = 0;
            if (status == PLI_OK) { break; }
            assert_int_equal(status, PLI_ERROR_OUT_OF_MEMORY);
            assert_non_null(strstr(pli_last_error(f.context), "memory"));
            check_same_state(body, before);
            assert_int_equal(allocator.alive - alive, (long)(pli_body_bytes(body) - before.bytes));
            if (failures % 7 == 0) { assert_int_equal(part_count(body), 1); }
        }
        assert_true(failures > 20);
        assert_true(count_all(body).nodes > before.nodes);
        allocator.fail_at = 1;
        int parts = 77;
        assert_int_equal(pli_body_count_parts(body, &parts), PLI_ERROR_OUT_OF_MEMORY);
        assert_int_equal(parts, 77);
        allocator.fail_at = 0;
        run(&f, 10);
        check_finite(body);
        pli_world_destroy(f.world);
        assert_int_equal(pli_context_allocated_bytes(f.context), 0);
        pli_context_destroy(f.context);
        assert_int_equal(allocator.alive, 0);
    }
}

int main(void) {
#define CUT_TEST(name) cmocka_unit_test_setup_teardown(name, setup_fixture, teardown_fixture)
    const struct CMUnitTest tests[] = {
        CUT_TEST(test_wall_parts_a_sheet),
        CUT_TEST(test_refine_without_cut_keeps_one_part),
        CUT_TEST(test_modes_give_the_same_topology),
        CUT_TEST(test_rest_lengths_are_those_of_the_rest_shape),
        CUT_TEST(test_surfaces_that_meet_nothing_change_nothing),
        CUT_TEST(test_zero_on_all_of_a_body),
        CUT_TEST(test_cut_along_nodes_makes_no_new_edges),
        CUT_TEST(test_first_link_is_detached_too),
        CUT_TEST(test_rope_is_cut_in_two),
        CUT_TEST(test_closed_surface_falls_into_bowls),
        CUT_TEST(test_several_components_are_cut_together),
        CUT_TEST(test_jump_of_the_surface_is_cut),
        CUT_TEST(test_materials_and_kinds_are_carried_on),
        CUT_TEST(test_bad_input_changes_nothing),
        CUT_TEST(test_surface_cannot_cut_the_body),
        CUT_TEST(test_tetrahedra_are_refused),
        CUT_TEST(test_link_is_cut_with_its_faces),
        CUT_TEST(test_swept_cut_opens_a_sheet),
        CUT_TEST(test_swept_cut_follows_a_sheet_that_moves),
        CUT_TEST(test_swept_cut_through_nodes_opens_too),
        CUT_TEST(test_cut_that_ends_inside_leaves_a_slit),
        CUT_TEST(test_short_sweeps_make_one_cut),
        CUT_TEST(test_cut_that_returns_to_its_start_frees_a_disc),
        CUT_TEST(test_many_random_sweeps_stay_manifold),
        CUT_TEST(test_twisted_strip_is_cut),
        CUT_TEST(test_swept_cut_of_ropes),
        CUT_TEST(test_links_without_faces),
        CUT_TEST(test_clusters_and_joints_follow),
        CUT_TEST(test_seven_cuts_and_a_disc_with_contacts),
        CUT_TEST(test_pressure_pose_and_velocity_links_follow),
        CUT_TEST(test_other_bodies_of_the_mesh_stay),
        CUT_TEST(test_large_sheet),
        CUT_TEST(test_lack_of_memory_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
