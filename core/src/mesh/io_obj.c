/* Wavefront OBJ: points and triangles, everything else is skipped. */

#include "mesh/io_text.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"
#include "pliant/io.h"

typedef struct obj_reader {
    plii_text text;
    int point_count, point_capacity;
    pli_vec3* points;
    int index_count, index_capacity;
    int* indices;
    int largest_index, largest_line; /* faces may name points that follow; checked at the end */
    float limit;                     /* of coordinates */
} obj_reader;

static pli_status obj_out_of_memory(const obj_reader* reader) {
    return plii_fail(reader->text.context, PLI_ERROR_OUT_OF_MEMORY, reader->text.function,
                     "%s:%d: no memory for more than %d points and %d triangles", reader->text.path, reader->text.line,
                     reader->point_count, reader->index_count / 3);
}

static pli_status obj_read_point(obj_reader* reader) {
    static const char* const names[7] = {"x", "y", "z", "the weight", "extra number", "extra number", "extra number"};
    float values[7];
    for (int i = 0; i < 3 || (i < 7 && !plii_text_is_line_done(&reader->text)); ++i) {
        PLII_TRY(plii_text_read_coordinate(&reader->text, names[i], i < 3 ? reader->limit : FLT_MAX, &values[i]));
    }
    PLII_TEXT_FAIL_IF(!plii_text_is_line_done(&reader->text), &reader->text, "a vertex has more than 7 numbers");
    if (!PLII_GROW(reader->text.context, &reader->points, &reader->point_capacity, reader->point_count)) {
        return obj_out_of_memory(reader);
    }
    reader->points[reader->point_count++] = pli_vec3_make(values[0], values[1], values[2]);
    return PLI_OK;
}

/* "v", "v/vt", "v//vn" or "v/vt/vn"; only v is used. */
static pli_status obj_read_corner(obj_reader* reader, int* index) {
    const char* word = NULL;
    int length = 0, number_length = 0, number = 0;
    PLII_TEXT_FAIL_IF(!plii_text_read_word(&reader->text, &word, &length), &reader->text,
                      "a face has less than 3 corners");
    while (number_length < length && word[number_length] != '/') {
        ++number_length;
    }
    bool ok = plii_parse_int(word, number_length, &number);
    int slash_count = 0;
    for (int i = number_length; i < length; ++i) {
        slash_count += word[i] == '/';
        ok = ok && (word[i] == '/' || word[i] == '-' || (word[i] >= '0' && word[i] <= '9'));
    }
    PLII_TEXT_FAIL_IF(!ok || slash_count > 2, &reader->text, "'%s' is no corner of a face",
                      plii_text_quote(word, length).text);
    PLII_TEXT_FAIL_IF(number == 0 || number < -reader->point_count, &reader->text,
                      "a face names vertex %d, there are %d so far", number, reader->point_count);
    *index = number > 0 ? number - 1 : reader->point_count + number;
    if (*index > reader->largest_index) {
        reader->largest_index = *index;
        reader->largest_line = reader->text.line;
    }
    return PLI_OK;
}

/* A polygon becomes a fan around its first corner. */
static pli_status obj_read_face(obj_reader* reader) {
    int first = 0, previous = 0, present = 0;
    PLII_TRY(obj_read_corner(reader, &first));
    PLII_TRY(obj_read_corner(reader, &previous));
    do {
        PLII_TRY(obj_read_corner(reader, &present));
        if (!PLII_RESERVE_MORE(reader->text.context, &reader->indices, &reader->index_capacity, reader->index_count,
                               3)) {
            return obj_out_of_memory(reader);
        }
        reader->indices[reader->index_count++] = first;
        reader->indices[reader->index_count++] = previous;
        reader->indices[reader->index_count++] = present;
        previous = present;
    } while (!plii_text_is_line_done(&reader->text));
    return PLI_OK;
}

static pli_status obj_read_lines(obj_reader* reader) {
    while (plii_text_find_content(&reader->text)) {
        const char* word = NULL;
        int length = 0;
        plii_text_read_word(&reader->text, &word, &length);
        if (length == 1 && *word == 'v') { PLII_TRY(obj_read_point(reader)); }
        if (length == 1 && *word == 'f') { PLII_TRY(obj_read_face(reader)); }
        if (!plii_text_next_line(&reader->text)) { break; }
    }
    PLII_TEXT_FAIL_IF(reader->index_count == 0, &reader->text, "the file ends after %d vertices without a face",
                      reader->point_count);
    if (reader->largest_index >= reader->point_count) {
        reader->text.line = reader->largest_line;
        return plii_text_fail(&reader->text, "a face names vertex %d, the file has %d", reader->largest_index + 1,
                              reader->point_count);
    }
    return PLI_OK;
}

static void obj_release(const pli_triangles* triangles) {
    PLII_RELEASE(triangles->context, triangles->points, triangles->point_count);
    PLII_RELEASE(triangles->context, triangles->indices, 3 * (size_t)triangles->triangle_count);
}

/* Blocks of exactly the size that obj_release gives back. */
static pli_status obj_write(const obj_reader* reader, pli_triangles* triangles) {
    pli_triangles made = {
        .context = reader->text.context, .point_count = reader->point_count, .triangle_count = reader->index_count / 3};
    made.points = plii_duplicate(made.context, reader->points, (size_t)reader->point_count * sizeof *reader->points);
    made.indices = plii_duplicate(made.context, reader->indices, (size_t)reader->index_count * sizeof *reader->indices);
    if (made.points == NULL || made.indices == NULL) {
        obj_release(&made);
        return obj_out_of_memory(reader);
    }
    made.context->triangles_count += 1;
    *triangles = made;
    return PLI_OK;
}

static pli_status obj_read(pli_context* context, const char* path, float limit, const char* function,
                           pli_triangles* triangles) {
    obj_reader reader = {.largest_index = -1, .limit = limit};
    PLII_TRY(plii_text_open(context, path, function, NULL, &reader.text));
    reader.text.joins_lines = true;
    pli_status status = obj_read_lines(&reader);
    if (status == PLI_OK) { status = obj_write(&reader, triangles); }
    plii_text_close(&reader.text);
    PLII_RELEASE(context, reader.points, reader.point_capacity);
    PLII_RELEASE(context, reader.indices, reader.index_capacity);
    return status;
}

pli_status pli_triangles_read_obj(pli_context* context, const char* path, pli_triangles* triangles) {
    PLII_TRY(plii_check_context_change(context, __func__));
    PLII_FAIL_IF(path == NULL || triangles == NULL, context, PLI_ERROR_NULL_ARGUMENT, __func__, "%s null",
                 path == NULL ? "the path is" : "triangles is");
    return obj_read(context, path, FLT_MAX, __func__, triangles);
}

void pli_triangles_destroy(pli_triangles* triangles) {
    if (triangles == NULL || triangles->context == NULL) { return; }
    if (plii_check_context_change(triangles->context, __func__) != PLI_OK) { return; }
    triangles->context->triangles_count -= 1;
    obj_release(triangles);
    *triangles = (pli_triangles){0};
}

pli_status pli_mesh_read_obj(pli_context* context, const char* path, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    if (path == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the path is null"); }
    pli_triangles triangles = {0};
    PLII_TRY(obj_read(context, path, PLI_MAX_COORDINATE, __func__, &triangles));
    const pli_status status = pli_mesh_create_from_triangles(context, triangles.point_count, triangles.points,
                                                             triangles.triangle_count, triangles.indices, true, mesh);
    pli_triangles_destroy(&triangles);
    return status;
}
