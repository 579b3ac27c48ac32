/* TetGen's text files: .node, .ele and, when it is there, .face. */

#include "base/csr.h"
#include "geometry/orient3d.h"
#include "mesh/io_text.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"
#include "pliant/io.h"

#include <stdio.h>

/* One of the files. */
typedef struct tetgen_file {
    plii_text text;
    const char* what;   /* its records are */
    int record_count;   /* what the first line promises */
    int first_index;    /* number of the first record, 0 or 1 */
    int trailing_count; /* numbers at the end of a record that the first line promises */
} tetgen_file;

typedef struct tetgen_mesh {
    int point_count, tetra_count, face_count;
    int first_point; /* number of the first point in the files */
    pli_vec3* points;
    int* tetras; /* [4 * tetra_count] */
    int* faces;  /* [3 * face_count] */
} tetgen_mesh;

/* The first line: how many records, then other numbers that may be left out. */
static pli_status tetgen_read_header(tetgen_file* file, int value_count, int* values) {
    char name[40];
    snprintf(name, sizeof name, "the number of %s", file->what);
    if (!plii_text_find_content(&file->text)) { return plii_text_fail(&file->text, "the file is empty"); }
    PLII_TRY(plii_text_read_int(&file->text, name, &file->record_count));
    if (file->record_count < 0) { return plii_text_fail(&file->text, "%s is %d", name, file->record_count); }
    for (int i = 0; i < value_count && !plii_text_is_line_done(&file->text); ++i) {
        PLII_TRY(plii_text_read_int(&file->text, "a number of the first line", &values[i]));
    }
    return PLI_OK;
}

/* A promised count is only believed as far as the file can hold it: a record takes at least two bytes per number. */
static pli_status tetgen_begin_records(tetgen_file* file, int numbers_per_record) {
    plii_text_next_line(&file->text);
    const int64_t bytes = file->text.end - file->text.at + 1;
    if ((int64_t)file->record_count * numbers_per_record * 2 <= bytes) { return PLI_OK; }
    return plii_text_fail(&file->text, "the file is too short for %d %s", file->record_count, file->what);
}

/* Goes to record `done` and checks its number. */
static pli_status tetgen_begin_record(tetgen_file* file, int done) {
    PLII_TEXT_FAIL_IF(!plii_text_find_content(&file->text), &file->text, "the file ends after %d of %d %s", done,
                      file->record_count, file->what);
    int index = 0;
    PLII_TRY(plii_text_read_int(&file->text, "the index", &index));
    if (done == 0 && (index == 0 || index == 1)) { file->first_index = index; }
    if (index == file->first_index + done) { return PLI_OK; }
    return plii_text_fail(&file->text, "the index is %d instead of %d", index, file->first_index + done);
}

static pli_status tetgen_end_record(tetgen_file* file) {
    for (int i = 0; i < file->trailing_count; ++i) {
        float ignored = 0.0f;
        PLII_TRY(plii_text_read_float(&file->text, "an attribute or marker", &ignored));
    }
    plii_text_next_line(&file->text);
    return PLI_OK;
}

static pli_status tetgen_end_file(tetgen_file* file) {
    if (!plii_text_find_content(&file->text)) { return PLI_OK; }
    return plii_text_fail(&file->text, "the file goes on after %d %s", file->record_count, file->what);
}
static pli_status tetgen_out_of_memory(const tetgen_file* file) {
    return plii_fail(file->text.context, PLI_ERROR_OUT_OF_MEMORY, file->text.function, "%s: no memory for %d %s",
                     file->text.path, file->record_count, file->what);
}

static pli_status tetgen_read_points(tetgen_file* file, tetgen_mesh* mesh) {
    int values[3] = {3, 0, 0}; /* dimensions, attributes, markers */
    PLII_TRY(tetgen_read_header(file, 3, values));
    const bool is_odd = values[0] != 3 || values[1] < 0 || values[1] > 1000 || values[2] < 0 || values[2] > 1;
    PLII_TEXT_FAIL_IF(file->record_count == 0 || is_odd, &file->text,
                      "%d points of %d dimensions with %d attributes and %d markers", file->record_count, values[0],
                      values[1], values[2]);
    file->trailing_count = values[1] + values[2];
    PLII_TRY(tetgen_begin_records(file, 4));
    if (!PLII_ALLOCATE(file->text.context, &mesh->points, file->record_count)) { return tetgen_out_of_memory(file); }
    mesh->point_count = file->record_count;
    for (PLII_EACH(pli_vec3, point, mesh->points, mesh->point_count)) {
        PLII_TRY(tetgen_begin_record(file, (int)(point - mesh->points)));
        PLII_TRY(plii_text_read_coordinate(&file->text, "x", PLI_MAX_COORDINATE, &point->x));
        PLII_TRY(plii_text_read_coordinate(&file->text, "y", PLI_MAX_COORDINATE, &point->y));
        PLII_TRY(plii_text_read_coordinate(&file->text, "z", PLI_MAX_COORDINATE, &point->z));
        PLII_TRY(tetgen_end_record(file));
    }
    mesh->first_point = file->first_index;
    return tetgen_end_file(file);
}

/* Points of a tetrahedron or triangle, counted from 0. */
static pli_status tetgen_read_corners(tetgen_file* file, const tetgen_mesh* mesh, int count, int* corners) {
    for (int i = 0; i < count; ++i) {
        int number = 0;
        PLII_TRY(plii_text_read_int(&file->text, "a corner", &number));
        PLII_TEXT_FAIL_IF(number < mesh->first_point || number - mesh->first_point >= mesh->point_count, &file->text,
                          "a corner is point %d, points run from %d to %d", number, mesh->first_point,
                          mesh->first_point + mesh->point_count - 1);
        corners[i] = number - mesh->first_point;
        for (int k = 0; k < i; ++k) {
            if (corners[k] == corners[i]) { return plii_text_fail(&file->text, "point %d is named twice", number); }
        }
    }
    return PLI_OK;
}

/* Tetrahedra or triangles, and that nothing follows. */
static pli_status tetgen_read_elements(tetgen_file* file, const tetgen_mesh* mesh, int corner_count, int** corners) {
    PLII_TRY(tetgen_begin_records(file, corner_count + 1));
    if (!PLII_ALLOCATE(file->text.context, corners, (size_t)corner_count * (size_t)file->record_count)) {
        return tetgen_out_of_memory(file);
    }
    for (int i = 0; i < file->record_count; ++i) {
        PLII_TRY(tetgen_begin_record(file, i));
        PLII_TRY(tetgen_read_corners(file, mesh, corner_count, *corners + (ptrdiff_t)corner_count * i));
        PLII_TRY(tetgen_end_record(file));
    }
    return tetgen_end_file(file);
}

static pli_status tetgen_read_tetras(tetgen_file* file, tetgen_mesh* mesh) {
    int values[2] = {4, 0}; /* corners, attributes */
    PLII_TRY(tetgen_read_header(file, 2, values));
    PLII_TEXT_FAIL_IF(
        file->record_count == 0 || (values[0] != 4 && values[0] != 10) || values[1] < 0 || values[1] > 1000,
        &file->text, "%d tetrahedra of %d corners with %d attributes", file->record_count, values[0], values[1]);
    file->trailing_count = values[0] - 4 + values[1]; /* nodes on the edges are not used */
    mesh->tetra_count = file->record_count;
    return tetgen_read_elements(file, mesh, 4, &mesh->tetras);
}

static pli_status tetgen_read_faces(tetgen_file* file, tetgen_mesh* mesh) {
    int markers = 0;
    PLII_TRY(tetgen_read_header(file, 1, &markers));
    if (markers < 0 || markers > 1) { return plii_text_fail(&file->text, "faces with %d markers", markers); }
    file->trailing_count = markers;
    mesh->face_count = file->record_count;
    return tetgen_read_elements(file, mesh, 3, &mesh->faces);
}

typedef struct tetgen_part {
    const char *extension, *what;
    pli_status (*read)(tetgen_file* file, tetgen_mesh* mesh);
    bool may_be_missing;
} tetgen_part;

static pli_status tetgen_read_file(pli_context* context, const char* base, const tetgen_part* part,
                                   const char* function, tetgen_mesh* mesh) {
    const size_t path_size = strlen(base) + strlen(part->extension) + 1;
    tetgen_file file = {.what = part->what};
    char* path = plii_allocate(context, path_size);
    PLII_FAIL_IF(path == NULL, context, PLI_ERROR_OUT_OF_MEMORY, function, "%s: no memory for a file name", base);
    snprintf(path, path_size, "%s%s", base, part->extension);
    bool is_missing = false;
    pli_status status = plii_text_open(context, path, function, part->may_be_missing ? &is_missing : NULL, &file.text);
    if (status == PLI_OK && !is_missing) { status = part->read(&file, mesh); }
    plii_text_close(&file.text);
    plii_release(context, path, path_size);
    return status;
}

/* The corner of `tetra` that is not among the three of `face`, or -1 when the face is none of its sides. */
static int tetgen_opposite(const int* tetra, const int* face) {
    int opposite = -1, shared = 0;
    for (int i = 0; i < 4; ++i) {
        const bool is_shared = tetra[i] == face[0] || tetra[i] == face[1] || tetra[i] == face[2];
        shared += is_shared;
        if (!is_shared) { opposite = tetra[i]; }
    }
    return shared == 3 ? opposite : -1;
}

/* Orients the faces with a tetrahedron on one side only so that they run counter-clockwise seen from the other. */
static bool tetgen_reverse_faces(pli_context* context, tetgen_mesh* mesh) {
    plii_scratch scratch = {.context = context};
    /* Corners of tetrahedra, four each, by point. */
    int* begin = PLII_TAKE(&scratch, int, (size_t)mesh->point_count + 1);
    int* list = PLII_TAKE(&scratch, int, (size_t)mesh->tetra_count * 4);
    const bool ok = !scratch.is_short && mesh->tetra_count <= INT_MAX / 4;
    if (ok) { plii_csr_sort(mesh->point_count, 4 * mesh->tetra_count, mesh->tetras, begin, list); }
    for (int i = 0; ok && i < mesh->face_count; ++i) {
        int* face = mesh->faces + (ptrdiff_t)3 * i;
        int rare = face[0]; /* the corner with the fewest tetrahedra */
        for (int k = 1; k < 3; ++k) {
            if (begin[face[k] + 1] - begin[face[k]] < begin[rare + 1] - begin[rare]) { rare = face[k]; }
        }
        int side_count = 0, inner = -1;
        for (int k = begin[rare]; k < begin[rare + 1]; ++k) {
            const int opposite = tetgen_opposite(mesh->tetras + list[k] / 4 * (ptrdiff_t)4, face);
            if (opposite < 0) { continue; }
            ++side_count;
            inner = opposite;
        }
        const pli_vec3* p = mesh->points;
        if (side_count == 1 && plii_orient3d(p[face[0]], p[face[1]], p[face[2]], p[inner]) > 0) {
            PLII_SWAP(int, face[1], face[2]);
        }
    }
    plii_scratch_free(&scratch);
    return ok;
}

static pli_status tetgen_make(pli_context* context, tetgen_mesh* read, const char* function, pli_mesh** mesh) {
    PLII_FAIL_IF(read->face_count > 0 && !tetgen_reverse_faces(context, read), context, PLI_ERROR_OUT_OF_MEMORY,
                 function, "no memory to orient %d faces", read->face_count);
    pli_mesh* made = NULL;
    PLII_TRY(
        pli_mesh_create_from_tetras(context, read->point_count, read->points, read->tetra_count, read->tetras, &made));
    if (!plii_mesh_reserve(made, 0, 0, read->face_count, 0)) {
        pli_mesh_destroy(made);
        return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for %d faces", read->face_count);
    }
    for (int i = 0; i < read->face_count; ++i) {
        const int* n = read->faces + (ptrdiff_t)3 * i;
        plii_mesh_push_face(made, n[0], n[1], n[2]);
    }
    *mesh = made;
    return PLI_OK;
}

pli_status pli_mesh_read_tetgen(pli_context* context, const char* base, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    if (base == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the base name is null"); }
    static const tetgen_part parts[3] = {{".node", "points", tetgen_read_points, false},
                                         {".ele", "tetrahedra", tetgen_read_tetras, false},
                                         {".face", "faces", tetgen_read_faces, true}};
    tetgen_mesh read = {0};
    pli_status status = PLI_OK;
    for (int i = 0; i < 3 && status == PLI_OK; ++i) {
        status = tetgen_read_file(context, base, &parts[i], __func__, &read);
    }
    if (status == PLI_OK) { status = tetgen_make(context, &read, __func__, mesh); }
    PLII_RELEASE(context, read.points, read.point_count);
    PLII_RELEASE(context, read.tetras, read.tetra_count * 4);
    PLII_RELEASE(context, read.faces, read.face_count * 3);
    return status;
}
