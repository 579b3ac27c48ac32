/* Readers of OBJ and TetGen files: what is accepted, what is refused and with which message. */

#include "failing_allocator.h"

#include "context_fixture.h"

#include <pliant/io.h>

#include <locale.h>
#include <stdio.h>

/* In the working directory. */
static const char* file_path(const char* name) {
    static char path[256];
    snprintf(path, sizeof path, "test_io_%s", name);
    return path;
}

static void write_file(const char* name, const char* content) {
    FILE* file = fopen(file_path(name), "wb");
    assert_non_null(file);
    fputs(content, file);
    fclose(file);
}

static void remove_file(const char* name) {
    remove(file_path(name));
}

static pli_status read_obj(const char* content, pli_triangles* triangles) {
    write_file("a.obj", content);
    const pli_status status = pli_triangles_read_obj(context, file_path("a.obj"), triangles);
    remove_file("a.obj");
    return status;
}

/* The message must contain `message`, and nothing may be written. */
static void check_obj_fails(const char* content, const char* message) {
    pli_triangles triangles = {.point_count = -7};
    assert_int_equal(read_obj(content, &triangles), PLI_ERROR_FILE_FORMAT);
    assert_int_equal(triangles.point_count, -7);
    if (strstr(pli_last_error(context), message) == NULL) {
        fail_msg("'%s' does not contain '%s'", pli_last_error(context), message);
    }
    assert_int_equal(pli_context_allocated_bytes(context), 0);
}

static void check_indices(const pli_triangles* triangles, int count, const int* indices) {
    assert_int_equal(triangles->triangle_count, count);
    for (int i = 0; i < 3 * count; ++i) {
        assert_int_equal(triangles->indices[i], indices[i]);
    }
}

static void test_obj_forms(void** state) {
    (void)state;
    pli_triangles t;
    assert_int_equal(read_obj("# a comment\r\n"
                              "mtllib x.mtl\r\n"
                              "v 0 0 0\r\n"
                              "v\t1.5 -2e-1 +.25 1.0 # trailing\r\n"
                              "vt 0 0\r\n"
                              "vn 0 1 0\r\n"
                              "  v 1 1 0 0.5 0.5 0.5\r\n"
                              "\r\n"
                              "v 0 1 \\\r\n"
                              "  3.\r\n"
                              "f 1/1 2/1 3/1\r\n"
                              "f 1//1 2//1 4//1 3/1/10\r\n"
                              "f -4 -1 -2 # relative\r\n"
                              "f 5 \\\r\n"
                              "1 2\r\n"
                              "v 9 9 9",
                              &t),
                     PLI_OK);
    assert_int_equal(t.point_count, 5);
    check_near(t.points[1].x, 1.5, 0);
    check_near(t.points[1].y, -0.2f, 0);
    check_near(t.points[1].z, 0.25, 0);
    check_near(t.points[3].z, 3, 0);
    check_near(t.points[4].x, 9, 0);
    const int expected[] = {0, 1, 2, 0, 1, 3, 0, 3, 2, 0, 3, 2, 4, 0, 1};
    check_indices(&t, 5, expected);
    pli_triangles_destroy(&t);
    pli_triangles_destroy(&t);
    pli_triangles_destroy(NULL);
}

/* UTF-8 with a mark: the first line is not lost. */
static void test_a_byte_order_mark_is_skipped(void** state) {
    (void)state;
    pli_triangles t;
    assert_int_equal(read_obj("\xef\xbb\xbfv 5 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n", &t), PLI_OK);
    assert_int_equal(t.point_count, 4);
    check_near(t.points[t.indices[0]].x, 5, 0);
    pli_triangles_destroy(&t);
    check_obj_fails("\xef\xbb", "ends after 0 vertices");
}

/* Points of meshes have limits, triangles have the unit of the file. */
static void test_far_points_are_named_with_their_line(void** state) {
    (void)state;
    const char* content = "v 0 0 0\nv 0 -2e6 0 1e30\nv 1 0 0\nf 1 2 3\n";
    pli_triangles t;
    assert_int_equal(read_obj(content, &t), PLI_OK);
    pli_triangles_destroy(&t);
    write_file("a.obj", content);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_read_obj(context, file_path("a.obj"), &mesh), PLI_ERROR_FILE_FORMAT);
    assert_null(mesh);
    assert_non_null(strstr(pli_last_error(context), "test_io_a.obj:2: y is -2e+06, coordinates go to 1e+06"));
    remove_file("a.obj");
}

static void test_obj_polygon_is_a_fan(void** state) {
    (void)state;
    pli_triangles t;
    assert_int_equal(read_obj("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n", &t), PLI_OK);
    const int expected[] = {0, 1, 2, 0, 2, 3, 0, 3, 4};
    check_indices(&t, 3, expected);
    pli_triangles_destroy(&t);
}

static void test_obj_refusals(void** state) {
    (void)state;
    const char* const three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    char content[256];
    check_obj_fails("", "a.obj:1: the file ends after 0 vertices without a face");
    check_obj_fails(three, "the file ends after 3 vertices without a face");
    check_obj_fails("f 1 2 3\n", "a.obj:1: a face names vertex 3, the file has 0");
    check_obj_fails("v 1 2\nf 1 1 1\n", "a.obj:1: the line ends before z");
    check_obj_fails("v 1 2 x3\n", "a.obj:1: z is 'x3', which is no usable number");
    check_obj_fails("v nan 2 3\n", "x is 'nan'");
    check_obj_fails("v 1 inf 3\n", "y is 'inf'");
    check_obj_fails("v 1 1e39 3\n", "y is '1e39'");
    check_obj_fails("v 1 1e 3\n", "y is '1e'");
    check_obj_fails("v 1 1.2.3 3\n", "y is '1.2.3'");
    check_obj_fails("v 1 - 3\n", "y is '-'");
    check_obj_fails("v 1 0x10 3\n", "y is '0x10'");
    check_obj_fails("v 1 1,5 3\n", "y is '1,5'");
    check_obj_fails("v 1 2 3 4 5 6 7 8\n", "more than 7 numbers");
    const struct {
        const char *face, *message;
    } faces[] = {
        {"f 1 2", "a.obj:4: a face has less than 3 corners"},
        {"f 1 2\n", "a.obj:4: a face has less than 3 corners"},
        {"\n# x\nf 1 2 4\n", "a.obj:6: a face names vertex 4, the file has 3"},
        {"f 0 1 2\n", "a face names vertex 0, there are 3 so far"},
        {"f -1 -2 -4\n", "a face names vertex -4, there are 3 so far"},
        {"f 1 2 3x\n", "'3x' is no corner"},
        {"f 1 2 3.0\n", "'3.0' is no corner"},
        {"f 1 2 /3\n", "'/3' is no corner"},
        {"f 1 2 3/1/1/1\n", "'3/1/1/1' is no corner"},
        {"f 1 2 99999999999\n", "'99999999999' is no corner"},
        {"f 1 2 \\\n", "a face has less than 3 corners"},
    };
    for (size_t i = 0; i < sizeof faces / sizeof faces[0]; ++i) {
        snprintf(content, sizeof content, "%s%s", three, faces[i].face);
        check_obj_fails(content, faces[i].message);
    }
}

static void test_messages_show_printable_characters_only(void** state) {
    (void)state;
    check_obj_fails("v \x7f"
                    "ELF\x1b[31m\xc3\xa4 0 0",
                    "a.obj:1: x is '.ELF.[31m..', which is no usable number");
    check_obj_fails("f \x1b]0;a\x07 2 3", "a.obj:1: '.]0;a.' is no corner of a face");
    check_obj_fails("v 0 0 123456789012345678901234567890123456789x1",
                    "z is '123456789012345678901234567890123456789x...', which");
    check_obj_fails("v 0 0 123456789012345678901234567890123456789x",
                    "z is '123456789012345678901234567890123456789x', which");
    FILE* file = fopen(file_path("t.node"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite("\x89PNG\0\x1a", 1, 6, file), 6);
    fclose(file);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_read_tetgen(context, file_path("t"), &mesh), PLI_ERROR_FILE_FORMAT);
    assert_non_null(strstr(pli_last_error(context), "t.node:1: the number of points is '.PNG..', which"));
    remove_file("t.node");
}

static void test_missing_files_and_null_arguments(void** state) {
    (void)state;
    pli_triangles t;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_triangles_read_obj(context, "/nowhere/b.obj", &t), PLI_ERROR_FILE_OPEN);
    assert_non_null(strstr(pli_last_error(context), "pli_triangles_read_obj: /nowhere/b.obj: No such file"));
    assert_int_equal(pli_mesh_read_obj(context, ".", &mesh), PLI_ERROR_FILE_OPEN);
    assert_non_null(strstr(pli_last_error(context), "cannot be read"));
    assert_int_equal(pli_mesh_read_tetgen(context, "/nowhere/b", &mesh), PLI_ERROR_FILE_OPEN);
    assert_non_null(strstr(pli_last_error(context), "/nowhere/b.node: No such file"));
    assert_int_equal(pli_triangles_read_obj(NULL, "x", &t), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_triangles_read_obj(context, NULL, &t), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_triangles_read_obj(context, "x", NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_read_obj(NULL, "x", &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_read_obj(context, NULL, &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_read_obj(context, "x", NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_read_tetgen(NULL, "x", &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_read_tetgen(context, NULL, &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_read_tetgen(context, "x", NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_null(mesh);
}

/* The file is read through a number parser of its own; strtof is the judge. */
static void test_numbers_are_rounded_correctly(void** state) {
    (void)state;
    uint32_t seed = 5;
    char* content = (char*)malloc(1 << 20);
    const int count = 6000;
    char(*words)[64] = (char(*)[64])malloc((size_t)count * 64);
    for (int i = 0; i < count; ++i) {
        uint32_t bits[3];
        for (int k = 0; k < 3; ++k) {
            bits[k] = seed = UINT32_C(1664525) * seed + UINT32_C(1013904223);
        }
        const int exponent = (int)(bits[2] >> 8) % 60 - 30;
        switch (i % 6) {
        case 0:
            snprintf(words[i], 64, "%u.%u", bits[0] >> 20, bits[1]);
            break;
        case 1:
            snprintf(words[i], 64, "-%u.%ue%d", bits[0] >> 12, bits[1], exponent);
            break;
        case 2:
            snprintf(words[i], 64, "%u%010u%010u.5E%+d", bits[0], bits[1], bits[2], exponent - 25);
            break;
        case 3: /* the middle between two floats, exactly and just beside */
            snprintf(words[i], 64, "%.1f%s", (double)(UINT32_C(0x1000000) + (bits[0] >> 8)) + 0.5,
                     (bits[1] & 1024) != 0 ? "0000000000001" : "");
            break;
        case 4:
            snprintf(words[i], 64, "%u.%ue-%u", bits[0] >> 28, bits[1], 36 + (bits[2] >> 28));
            break;
        default:
            snprintf(words[i], 64, ".%u", bits[0]);
            break;
        }
    }
    size_t used = 0;
    for (int i = 0; i < count; i += 3) {
        used += (size_t)sprintf(content + used, "v %s %s %s\n", words[i], words[i + 1], words[i + 2]);
    }
    sprintf(content + used, "f 1 2 3\n");
    pli_triangles t;
    assert_int_equal(read_obj(content, &t), PLI_OK);
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = t.points[i / 3];
        const float value = i % 3 == 0 ? p.x : i % 3 == 1 ? p.y : p.z, expected = strtof(words[i], NULL);
        if (memcmp(&value, &expected, sizeof value) != 0) {
            fail_msg("%s was read as %.9g, it is %.9g", words[i], (double)value, (double)expected);
        }
    }
    pli_triangles_destroy(&t);
    free(words);
    free(content);
}

static void test_numbers_do_not_depend_on_the_locale(void** state) {
    (void)state;
    const char* const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    const char* found = NULL;
    for (int i = 0; i < 4 && found == NULL; ++i) {
        found = setlocale(LC_NUMERIC, names[i]);
    }
    if (found == NULL) { skip(); }
    pli_triangles t;
    /* The second number takes the way through strtof. */
    const pli_status status = read_obj("v 1.5 2.50000000000000000000001 3\nf 1 1 1\n", &t);
    const pli_status comma = read_obj("v 1,5 2 3\nf 1 1 1\n", &t);
    setlocale(LC_NUMERIC, "C");
    assert_int_equal(status, PLI_OK);
    assert_int_equal(comma, PLI_ERROR_FILE_FORMAT);
    check_near(t.points[0].x, 1.5, 0);
    check_near(t.points[0].y, 2.5, 0);
    pli_triangles_destroy(&t);
}

static void test_obj_mesh(void** state) {
    (void)state;
    write_file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_read_obj(context, file_path("a.obj"), &mesh), PLI_OK);
    remove_file("a.obj");
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    assert_int_equal(view.node_count, 5);
    assert_int_equal(view.link_count, 6);
    assert_int_equal(view.face_count, 4);
    check_near(pli_mesh_volume(mesh), 1.0 / 6.0, 1e-8);
    pli_mesh_destroy(mesh);
}

/* -------------------------------------------------------------------------------------------------- TetGen */

static const char node_text[] = "# two tetrahedra\n"
                                "5 3 1 1\n"
                                "1  0 0 0  7.5 1\n"
                                "2  1 0 0  7.5 1 # right\n"
                                "\n"
                                "3  0 1 0  7.5 0\n"
                                "4  0 0 1  7.5 0\n"
                                "5  1 1 1  7.5 1\n"
                                "# Generated\n";
static const char ele_text[] = "2 4 0\r\n1 1 2 3 4\r\n2 5 3 2 4\r\n";
static const char face_text[] = "6 1\n1 1 2 3 1\n2 1 2 4 1\n3 1 3 4 1\n4 2 3 4 0\n5 5 2 3 1\n6 4 3 5 1\n";

static pli_status read_tetgen(const char* node, const char* ele, const char* face, pli_mesh** mesh) {
    if (node != NULL) { write_file("t.node", node); }
    if (ele != NULL) { write_file("t.ele", ele); }
    if (face != NULL) { write_file("t.face", face); }
    const pli_status status = pli_mesh_read_tetgen(context, file_path("t"), mesh);
    remove_file("t.node");
    remove_file("t.ele");
    remove_file("t.face");
    return status;
}

static void check_tetgen_fails(const char* node, const char* ele, const char* face, const char* message) {
    pli_mesh* mesh = NULL;
    assert_int_equal(read_tetgen(node, ele, face, &mesh), PLI_ERROR_FILE_FORMAT);
    assert_null(mesh);
    if (strstr(pli_last_error(context), message) == NULL) {
        fail_msg("'%s' does not contain '%s'", pli_last_error(context), message);
    }
    assert_int_equal(pli_context_allocated_bytes(context), 0);
}

static void test_tetgen(void** state) {
    (void)state;
    pli_mesh* mesh = NULL;
    assert_int_equal(read_tetgen(node_text, ele_text, face_text, &mesh), PLI_OK);
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    assert_int_equal(view.node_count, 5);
    assert_int_equal(view.tetra_count, 2);
    const int links[9][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}, {4, 2}, {1, 4}, {4, 3}};
    assert_int_equal(view.link_count, 9);
    for (int i = 0; i < 9; ++i) {
        assert_int_equal(view.links[i].nodes[0], links[i][0]);
        assert_int_equal(view.links[i].nodes[1], links[i][1]);
    }
    assert_int_equal(view.tetras[1].nodes[0], 4);
    assert_int_equal(view.face_count, 6);
    /* All boundary faces are turned outwards: seen from the middle, all have the same side. */
    const pli_vec3 middle = {0.4f, 0.4f, 0.4f};
    for (int i = 0; i < 6; ++i) {
        if (i == 3) { continue; } /* between the two */
        const int* n = view.faces[i].nodes;
        const pli_vec3 a = view.positions[n[0]];
        const pli_vec3 normal =
            pli_vec3_cross(pli_vec3_sub(view.positions[n[1]], a), pli_vec3_sub(view.positions[n[2]], a));
        assert_true(pli_vec3_dot(normal, pli_vec3_sub(a, middle)) > 0.0f);
    }
    pli_mesh_destroy(mesh);
    assert_int_equal(read_tetgen("4 3 2 0\n0 0 0 0 7 7\n1 1 0 0 7 7\n2 0 1 0 7 7\n3 0 0 1 7 7\n",
                                 "1 4 1\n0 0 1 2 3 7\n", NULL, &mesh),
                     PLI_OK);
    assert_int_equal(pli_mesh_get_view(mesh).face_count, 0);
    assert_int_equal(pli_mesh_get_view(mesh).link_count, 6);
    pli_mesh_destroy(mesh);
}

static void test_tetgen_refusals(void** state) {
    (void)state;
    const char* const four = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
    check_tetgen_fails("", ele_text, NULL, "t.node:1: the file is empty");
    check_tetgen_fails("# only\n\n", ele_text, NULL, "t.node:3: the file is empty");
    check_tetgen_fails("0 3 0 0\n", ele_text, NULL, "t.node:1: 0 points of 3 dimensions");
    check_tetgen_fails("4 2 0 0\n", ele_text, NULL, "4 points of 2 dimensions");
    check_tetgen_fails("-4 3 0 0\n", ele_text, NULL, "the number of points is -4");
    check_tetgen_fails("x 3 0 0\n", ele_text, NULL, "the number of points is 'x'");
    check_tetgen_fails("2000000000 3 0 0\n0 0 0 0\n", ele_text, NULL, "the file is too short for 2000000000 points");
    check_tetgen_fails("2 3 0 0\n0 0.000000 0.000000 0\n", ele_text, NULL,
                       "t.node:3: the file ends after 1 of 2 points");
    check_tetgen_fails("1 3 0 0\n0 0 0 0\n1 1 1 1\n", ele_text, NULL, "t.node:3: the file goes on after 1 points");
    check_tetgen_fails("2 3 0 0\n0 0 0 0\n2 1 1 1\n", ele_text, NULL, "t.node:3: the index is 2 instead of 1");
    check_tetgen_fails("2 3 0 0\n7 0 0 0\n8 1 1 1\n", ele_text, NULL, "t.node:2: the index is 7 instead of 0");
    check_tetgen_fails("2 3 0 0\n0 0 0.0000\n1 1 1 1\n", ele_text, NULL, "t.node:2: the line ends before z");
    check_tetgen_fails("2 3 0 0\n0 0 0 0\n1 1 1 3e6\n", ele_text, NULL,
                       "t.node:3: z is 3e+06, coordinates go to 1e+06");
    check_tetgen_fails("1 3 2 0\n0 0 0 0.00000 5\n", ele_text, NULL, "the line ends before an attribute or marker");
    check_tetgen_fails(four, "1 5 0\n0 0 1 2 3\n", NULL, "t.ele:1: 1 tetrahedra of 5 corners");
    check_tetgen_fails(four, "0 4 0\n", NULL, "t.ele:1: 0 tetrahedra");
    check_tetgen_fails(four, "1 4 0\n0 0 1 2 4\n", NULL, "t.ele:2: a corner is point 4, points run from 0 to 3");
    check_tetgen_fails(four, "1 4 0\n0 0 1 2 -1\n", NULL, "a corner is point -1");
    check_tetgen_fails(four, "1 4 0\n0 0 1 2 2\n", NULL, "t.ele:2: point 2 is named twice");
    check_tetgen_fails(four, "2 4 0\n0 0 1 2 3 # the first\n1 0 1", NULL, "t.ele:3: the line ends before a corner");
    check_tetgen_fails(four, "1 4 0\n0 0 1 2 3\n", "1 0\n0 0 1 9\n", "t.face:2: a corner is point 9");
    check_tetgen_fails(four, "1 4 0\n0 0 1 2 3\n", "1 4\n0 0 1 2\n", "t.face:1: faces with 4 markers");
    pli_mesh* mesh = NULL;
    assert_int_equal(read_tetgen(four, NULL, NULL, &mesh), PLI_ERROR_FILE_OPEN);
    assert_non_null(strstr(pli_last_error(context), "t.ele: No such file"));
}

/* Cut off after every byte: never a crash, never a leak; a whole mesh only from a file that still says so. */
static void test_every_truncation(void** state) {
    (void)state;
    char content[sizeof face_text];
    for (size_t length = 0; length + 1 < sizeof face_text; ++length) {
        memcpy(content, face_text, length);
        content[length] = '\0';
        pli_mesh* mesh = NULL;
        const pli_status status = read_tetgen(node_text, ele_text, content, &mesh);
        if (status == PLI_OK) {
            assert_true(length >= sizeof face_text - 2); /* only the line end is missing */
            pli_mesh_destroy(mesh);
        } else {
            assert_int_equal(status, PLI_ERROR_FILE_FORMAT);
            assert_null(mesh);
        }
    }
    const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n";
    for (size_t length = 0; length + 1 < sizeof obj; ++length) {
        memcpy(content, obj, length);
        content[length] = '\0';
        pli_triangles t;
        if (read_obj(content, &t) == PLI_OK) { pli_triangles_destroy(&t); }
    }
    assert_int_equal(pli_context_allocated_bytes(context), 0);
}

static pli_status read_both(pli_context* own_context, void* user) {
    (void)user;
    pli_mesh* mesh = NULL;
    pli_status status = pli_mesh_read_obj(own_context, file_path("a.obj"), &mesh);
    pli_mesh_destroy(mesh);
    if (status != PLI_OK) { return status; }
    mesh = NULL;
    status = pli_mesh_read_tetgen(own_context, file_path("t"), &mesh);
    pli_mesh_destroy(mesh);
    return status;
}

static void test_out_of_memory_leaves_nothing(void** state) {
    (void)state;
    FILE* file = fopen(file_path("a.obj"), "wb"); /* more than one block */
    assert_non_null(file);
    for (int i = 0; i < 5000; ++i) {
        fprintf(file, "v %d 0.5 %d\nf -1 1 1\n", i, i % 7);
    }
    fclose(file);
    write_file("t.node", node_text);
    write_file("t.ele", ele_text);
    write_file("t.face", face_text);
    assert_in_range(check_survives_failing_allocator(read_both, NULL), 20, 200);
    remove_file("a.obj");
    remove_file("t.node");
    remove_file("t.ele");
    remove_file("t.face");
}

/* What a modelling program numbers, as the vertices of a group, are the nodes of the same indices. */
static void nodes_are_in_the_order_of_the_file(void** state) {
    (void)state;
    write_file("a.obj", "o A\nv 3 0 0\nv 9 9 9\nv 1 0 0\no B\nv 2 2 0\ng back\nf 4/1 1/2 3/3\n");
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_read_obj(context, file_path("a.obj"), &mesh), PLI_OK);
    remove_file("a.obj");
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    const float x[] = {3, 9, 1, 2};
    assert_int_equal(view.node_count, 4);
    for (int i = 0; i < 4; ++i) {
        assert_true(view.positions[i].x == x[i]);
    }
    assert_int_equal(view.faces[0].nodes[0] + view.faces[0].nodes[1] + view.faces[0].nodes[2], 5);
    pli_mesh_destroy(mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_are_in_the_order_of_the_file),
        cmocka_unit_test(test_obj_forms),
        cmocka_unit_test(test_a_byte_order_mark_is_skipped),
        cmocka_unit_test(test_far_points_are_named_with_their_line),
        cmocka_unit_test(test_obj_polygon_is_a_fan),
        cmocka_unit_test(test_obj_refusals),
        cmocka_unit_test(test_messages_show_printable_characters_only),
        cmocka_unit_test(test_missing_files_and_null_arguments),
        cmocka_unit_test(test_numbers_are_rounded_correctly),
        cmocka_unit_test(test_numbers_do_not_depend_on_the_locale),
        cmocka_unit_test(test_obj_mesh),
        cmocka_unit_test(test_tetgen),
        cmocka_unit_test(test_tetgen_refusals),
        cmocka_unit_test(test_every_truncation),
        cmocka_unit_test(test_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
