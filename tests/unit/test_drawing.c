/* Normals, vertices between two steps, and what cuts have made of nodes and faces. */

#include "level_sheet.h"
#include "test_world.h"

#include <stdlib.h>

static pli_body* make_sheet(int count) {
    pli_patch_def def = level_sheet(1, 0, count);
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static void test_normals_are_there_as_long_as_they_are_enabled(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(4);
    assert_null(pli_body_get_view(sheet).normals);
    assert_null(pli_body_get_face_normals(sheet));
    assert_int_equal(pli_body_enable_normals(sheet), PLI_OK);
    const pli_body_view view = pli_body_get_view(sheet);
    const pli_vec3* of_faces = pli_body_get_face_normals(sheet);
    for (int i = 0; i < view.node_count; ++i) {
        check_near(fabsf(view.normals[i].y), 1, 1e-6);
    }
    for (int i = 0; i < view.face_count; ++i) {
        check_near(of_faces[i].y, view.normals[0].y, 1e-6);
    }
    const pli_transform turned = {pli_mat3_from_euler_zyx(0, 0, 1.5707963f), pli_vec3_make(0, 0, 0)};
    assert_int_equal(pli_body_transform(sheet, turned), PLI_OK);
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    check_near(fabsf(pli_body_get_view(sheet).normals[5].x), 1, 1e-3);
    check_near(fabsf(pli_body_get_face_normals(sheet)[5].x), 1, 1e-3);
    assert_int_equal(pli_body_disable_normals(sheet), PLI_OK);
    assert_null(pli_body_get_view(sheet).normals);

    pli_mesh* rope = NULL;
    pli_body* body = NULL;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 3, 0, &rope),
                     PLI_OK);
    assert_int_equal(pli_body_create(world, rope, NULL, &body), PLI_OK);
    pli_mesh_destroy(rope);
    check_refused(pli_body_enable_normals(body), PLI_ERROR_INVALID_MESH, "normals are those of faces");
}

typedef struct vertex {
    float before[2], position[3], between, normal[3], after;
} vertex;

static pli_vertex_buffer_def buffer_of(vertex* vertices, int count) {
    pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
    buffer.vertices = vertices;
    buffer.vertex_count = count;
    buffer.stride = (int)sizeof *vertices;
    buffer.position_offset = (int)offsetof(vertex, position);
    buffer.normal_offset = (int)offsetof(vertex, normal);
    return buffer;
}

static void test_vertices_lie_between_the_ends_of_the_last_step(void** state) {
    (void)state;
    enum { COUNT = 20 };
    pli_body* sheet = make_sheet(4);
    assert_int_equal(pli_body_enable_normals(sheet), PLI_OK);
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(pli_body_add_node_force(sheet, 5, pli_vec3_make(0, 20, 0)), PLI_OK);
        assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    }
    const pli_body_view view = pli_body_get_view(sheet);
    int nodes[COUNT]; /* four of them twice */
    for (int i = 0; i < COUNT; ++i) {
        nodes[i] = i % view.node_count;
    }
    const float factors[] = {0, 0.25f, 1, 2};
    for (int k = 0; k < 4; ++k) {
        vertex vertices[COUNT];
        memset(vertices, 0x5a, sizeof vertices);
        pli_vertex_buffer_def buffer = buffer_of(vertices, COUNT);
        buffer.vertex_nodes = nodes;
        assert_int_equal(pli_body_write_vertices(sheet, &buffer, factors[k]), PLI_OK);
        vertex untouched;
        memset(&untouched, 0x5a, sizeof untouched);
        for (int i = 0; i < COUNT; ++i) {
            const pli_vec4 a = view.previous[nodes[i]], b = view.positions[nodes[i]];
            check_near(vertices[i].position[1], a.y + factors[k] * (b.y - a.y), 1e-6);
            const float* n = vertices[i].normal;
            check_near(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-5);
            if (k == 2) { check_near(n[0], view.normals[nodes[i]].x, 1e-6); }
            assert_memory_equal(vertices[i].before, untouched.before, sizeof untouched.before);
            assert_memory_equal(&vertices[i].between, &untouched.between, sizeof untouched.between);
            assert_memory_equal(&vertices[i].after, &untouched.after, sizeof untouched.after);
        }
    }
    /* A frozen body stands still. */
    vertex at_rest[COUNT];
    pli_vertex_buffer_def buffer = buffer_of(at_rest, view.node_count);
    assert_int_equal(pli_body_set_frozen(sheet, true), PLI_OK);
    assert_int_equal(pli_body_write_vertices(sheet, &buffer, 0), PLI_OK);
    check_near(at_rest[5].position[1], view.positions[5].y, 0);
}

/* What was turned round in between is drawn as it is now, not half way from before. */
static void test_normals_turn_with_the_body(void** state) {
    (void)state;
    enum { COUNT = 16 };
    pli_body* sheet = make_sheet(4);
    assert_int_equal(pli_body_enable_normals(sheet), PLI_OK);
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    const pli_transform turned = {pli_mat3_from_euler_zyx(0, 0, 3.1415927f), pli_vec3_make(0, 0, 0)};
    assert_int_equal(pli_body_transform(sheet, turned), PLI_OK);
    const pli_body_view view = pli_body_get_view(sheet);
    vertex vertices[COUNT];
    const pli_vertex_buffer_def buffer = buffer_of(vertices, COUNT);
    assert_int_equal(pli_body_write_vertices(sheet, &buffer, 0.25f), PLI_OK);
    for (int i = 0; i < COUNT; ++i) {
        check_near(vertices[i].normal[1], view.normals[i].y, 1e-6);
    }
}

/* Between steps at 60 Hz, drawn at 144 Hz, one step late. */
static void test_interpolation_takes_the_jitter_away(void** state) {
    (void)state;
    const double dt = 1.0 / 60.0, frame = 1.0 / 144.0;
    pli_body* sheet = make_sheet(3);
    assert_int_equal(pli_body_add_velocity(sheet, pli_vec3_make(2, 15, 0)), PLI_OK);
    double accumulator = 0, errors[2] = {0, 0}, last[2] = {0, 0};
    for (int i = 0; i < 288; ++i) {
        accumulator += frame;
        for (; accumulator >= dt; accumulator -= dt) {
            assert_int_equal(pli_world_step(world, (float)dt), PLI_OK);
        }
        float drawn[9][3], stepped[9][3];
        pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
        buffer.vertex_count = 9;
        buffer.stride = (int)sizeof drawn[0];
        buffer.normal_offset = -1;
        buffer.vertices = drawn;
        assert_int_equal(pli_body_write_vertices(sheet, &buffer, (float)(accumulator / dt)), PLI_OK);
        buffer.vertices = stepped;
        assert_int_equal(pli_body_write_vertices(sheet, &buffer, 1), PLI_OK);
        const double heights[2] = {(double)drawn[4][1], (double)stepped[4][1]};
        for (int k = 0; k < 2 && i > 4; ++k) {
            const double late = (i + 0.5) * frame - (k == 0 ? dt : 0), speed = (heights[k] - last[k]) / frame;
            errors[k] += pow(speed - (15 - 10 * late), 2);
        }
        memcpy(last, heights, sizeof last);
    }
    check_at_most(sqrt(errors[0]), 0.02 * sqrt(errors[1]));
}

static void test_bad_buffers_are_refused_and_stay_as_they_are(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(4);
    vertex vertices[16], before[16];
    memset(vertices, 0x5a, sizeof vertices);
    memcpy(before, vertices, sizeof before);
    pli_vertex_buffer_def buffer = buffer_of(vertices, 16);
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_INVALID_VALUE,
                  "pli_body_enable_normals was not");
    assert_int_equal(pli_body_enable_normals(sheet), PLI_OK);
    check_refused(pli_body_write_vertices(sheet, &buffer, NAN), PLI_ERROR_NOT_FINITE, "factor");
    check_refused(pli_body_write_vertices(sheet, &buffer, 2.5f), PLI_ERROR_INVALID_VALUE, "factor");
    check_refused(pli_body_write_vertices(sheet, NULL, 1), PLI_ERROR_NULL_ARGUMENT, "null");
    buffer.normal_offset = (int)sizeof(vertex) - 8;
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_INVALID_VALUE, "normal_offset");
    buffer.normal_offset = 13;
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_INVALID_VALUE, "multiples of 4");
    buffer = buffer_of(vertices, 17);
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_INDEX_OUT_OF_RANGE, "17 vertices for 16 nodes");
    int nodes[16] = {0};
    nodes[3] = 16;
    buffer = buffer_of(vertices, 16);
    buffer.vertex_nodes = nodes;
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_INDEX_OUT_OF_RANGE, "vertex 3 is 16");
    buffer = buffer_of(NULL, 16);
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_NULL_ARGUMENT, "vertices is null");
    buffer = buffer_of(vertices, 16);
    buffer.cookie = 0;
    check_refused(pli_body_write_vertices(sheet, &buffer, 1), PLI_ERROR_INVALID_DEF, "pli_vertex_buffer_def_default");
    assert_memory_equal(vertices, before, sizeof before);
}

/* A cylinder without caps as a renderer has it: the seam is there twice, and each quad has four vertices of its own. */
static void test_doubled_vertices_become_one_node(void** state) {
    (void)state;
    enum { AROUND = 12, ALONG = 5, QUADS = AROUND * ALONG, VERTICES = 4 * QUADS };
    static pli_vec3 vertices[VERTICES];
    static int triangles[6 * QUADS], nodes[VERTICES];
    for (int q = 0; q < QUADS; ++q) {
        for (int k = 0; k < 4; ++k) {
            const float angle = 6.2831853f / AROUND * (float)((q % AROUND + k % 2) % AROUND);
            vertices[4 * q + k] = pli_vec3_make(cosf(angle), 0.3f * (float)(q / AROUND + k / 2), sinf(angle));
            nodes[4 * q + k] = -7;
        }
        const int corners[6] = {0, 2, 1, 1, 2, 3};
        for (int k = 0; k < 6; ++k) {
            triangles[6 * q + k] = 4 * q + corners[k];
        }
    }
    vertices[0].z = -0.0f; /* the same place as 0 */
    pli_mesh* mesh = NULL;
    triangles[7] = VERTICES;
    check_refused(pli_mesh_create_from_vertices(context, VERTICES, vertices, 2 * QUADS, triangles, nodes, &mesh),
                  PLI_ERROR_INDEX_OUT_OF_RANGE, "triangle 2 names vertex 240");
    assert_int_equal(nodes[5], -7);
    triangles[7] = 6;
    check_refused(pli_mesh_create_from_vertices(context, VERTICES, vertices, 2 * QUADS, triangles, NULL, &mesh),
                  PLI_ERROR_NULL_ARGUMENT, "vertex_nodes is null");
    assert_int_equal(pli_mesh_create_from_vertices(context, VERTICES, vertices, 2 * QUADS, triangles, nodes, &mesh),
                     PLI_OK);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    const pli_body_view view = pli_body_get_view(body);
    assert_int_equal(view.node_count, AROUND * (ALONG + 1));
    assert_int_equal(view.face_count, 2 * QUADS);
    assert_int_equal(view.link_count, AROUND * (ALONG + 1) + AROUND * ALONG + QUADS); /* around, along, diagonals */
    /* Written back, all vertices are where they were, and those at one place have one normal. */
    assert_int_equal(pli_body_enable_normals(body), PLI_OK);
    static vertex written[VERTICES];
    pli_vertex_buffer_def buffer = buffer_of(written, VERTICES);
    buffer.vertex_nodes = nodes;
    assert_int_equal(pli_body_write_vertices(body, &buffer, 1), PLI_OK);
    for (int i = 0; i < VERTICES; ++i) {
        check_near(written[i].position[0], vertices[i].x, 0);
        check_near(written[i].position[1], vertices[i].y, 0);
        check_near(written[i].position[2], vertices[i].z, 0);
        /* Outwards or inwards, but along the radius. */
        const float along = written[i].normal[0] * vertices[i].x + written[i].normal[2] * vertices[i].z;
        check_near(fabsf(along), 1, 0.04);
    }
}

// --------------------------------------------------------------------------------------------------------- changes

static float ring(pli_vec3 point, void* user) {
    (void)user;
    return point.x * point.x + point.z * point.z - 0.3f;
}

static double orientation(pli_vec4 a, pli_vec4 b, double x, double z) {
    return ((double)b.x - (double)a.x) * (z - (double)a.z) - ((double)b.z - (double)a.z) * (x - (double)a.x);
}

/* In the plane. */
static bool is_inside(const pli_vec4 corners[3], double x, double z) {
    const double a = orientation(corners[0], corners[1], x, z), b = orientation(corners[1], corners[2], x, z),
                 c = orientation(corners[2], corners[0], x, z);
    return (a >= -1e-5 && b >= -1e-5 && c >= -1e-5) || (a <= 1e-5 && b <= 1e-5 && c <= 1e-5);
}

static void test_texture_coordinates_follow_cuts(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(9);
    assert_int_equal(pli_body_enable_topology_changes(sheet), PLI_OK);
    const pli_body_view before = pli_body_get_view(sheet);
    const int old_nodes = before.node_count, old_faces = before.face_count;
    pli_vec4* old_positions = malloc((size_t)old_nodes * sizeof *old_positions);
    int* old_face_nodes = malloc((size_t)old_faces * 3 * sizeof *old_face_nodes);
    memcpy(old_positions, before.positions, (size_t)old_nodes * sizeof *old_positions);
    memcpy(old_face_nodes, before.face_nodes, (size_t)old_faces * 3 * sizeof *old_face_nodes);
    pli_topology_changes changes = pli_body_get_topology_changes(sheet);
    assert_int_equal(changes.old_node_count, old_nodes);
    assert_int_equal(changes.new_node_count, 0);
    assert_int_equal(changes.face_parents[old_faces - 1], old_faces - 1);

    /* Twice, so that changes add up. */
    pli_refine_def refine = pli_refine_def_default();
    refine.surface = ring;
    assert_int_equal(pli_body_refine(sheet, &refine), PLI_OK);
    const int after_ring = pli_body_get_topology_changes(sheet).new_node_count;
    assert_true(after_ring > 8);
    int parted = 0;
    assert_int_equal(pli_body_cut_swept(sheet, pli_vec3_make(-2, 1, 0.1f), pli_vec3_make(-2, -1, 0.1f),
                                        pli_vec3_make(2, 1, 0.17f), pli_vec3_make(2, -1, 0.17f), &parted),
                     PLI_OK);
    assert_true(parted > 8);

    changes = pli_body_get_topology_changes(sheet);
    const pli_body_view after = pli_body_get_view(sheet);
    assert_int_equal(changes.old_node_count, old_nodes);
    assert_int_equal(changes.old_face_count, old_faces);
    assert_int_equal(changes.new_node_count, after.node_count - old_nodes);
    assert_int_equal(changes.face_count, after.face_count);
    assert_true(changes.new_node_count > after_ring);
    /* Coordinates that were those of the plane still are. */
    pli_vec4* coordinates = malloc((size_t)after.node_count * sizeof *coordinates);
    memcpy(coordinates, old_positions, (size_t)old_nodes * sizeof *coordinates);
    for (int i = 0; i < changes.new_node_count; ++i) {
        const pli_new_node node = changes.new_nodes[i];
        assert_in_range(node.a, 0, old_nodes + i - 1);
        assert_in_range(node.b, 0, old_nodes + i - 1);
        const pli_vec4 a = coordinates[node.a], b = coordinates[node.b];
        coordinates[old_nodes + i] = (pli_vec4){a.x + node.share * (b.x - a.x), 0, a.z + node.share * (b.z - a.z), 0};
    }
    for (int i = 0; i < after.node_count; ++i) {
        check_near(coordinates[i].x, after.positions[i].x, 1e-5);
        check_near(coordinates[i].z, after.positions[i].z, 1e-5);
    }
    for (int i = 0; i < after.face_count; ++i) {
        double x = 0, z = 0;
        pli_vec4 corners[3];
        for (int k = 0; k < 3; ++k) {
            x += (double)after.positions[after.face_nodes[3 * i + k]].x / 3;
            z += (double)after.positions[after.face_nodes[3 * i + k]].z / 3;
            assert_in_range(changes.face_parents[i], 0, old_faces - 1);
            corners[k] = old_positions[old_face_nodes[3 * changes.face_parents[i] + k]];
        }
        if (!is_inside(corners, x, z)) { fail_msg("face %d is not in face %d", i, changes.face_parents[i]); }
    }

    assert_int_equal(pli_body_enable_topology_changes(sheet), PLI_OK); /* anew */
    assert_int_equal(pli_body_get_topology_changes(sheet).old_node_count, after.node_count);
    assert_int_equal(pli_body_get_topology_changes(sheet).new_node_count, 0);
    assert_int_equal(pli_body_disable_topology_changes(sheet), PLI_OK);
    assert_int_equal(pli_body_get_topology_changes(sheet).old_node_count, 0);
    free(coordinates);
    free(old_face_nodes);
    free(old_positions);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_normals_are_there_as_long_as_they_are_enabled, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_vertices_lie_between_the_ends_of_the_last_step, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_normals_turn_with_the_body, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_interpolation_takes_the_jitter_away, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_buffers_are_refused_and_stay_as_they_are, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_doubled_vertices_become_one_node, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_texture_coordinates_follow_cuts, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
