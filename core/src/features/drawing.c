/* Positions and normals for renderers. */

#include "pliant/drawing.h"
#include "body/pipeline.h"

typedef struct drawn_normals_state {
    pli_vec3* previous; /* [node_count] at the start of the last step, or since nodes were placed */
} drawn_normals_state;

static void drawn_normals_keep(pli_body* body, void* data) {
    drawn_normals_state* state = data;
    memcpy(state->previous, body->normals, (size_t)body->node_count * sizeof *state->previous);
}

/* Calls that place nodes leave no motion to go evenly through. */
static void drawn_normals_refresh(pli_body* body, void* data) {
    if (!body->world->is_stepping) { drawn_normals_keep(body, data); }
}

enum { DRAWN_NORMALS_ORDER = 0, DRAWN_NORMALS_REFRESH_ORDER = 10 }; /* after the normals */
const plii_feature_class plii_drawn_normals_class = {
    .name = "drawn normals",
    .state_size = sizeof(drawn_normals_state),
    .needs = PLII_NEEDS(&plii_normals_class, &plii_face_normals_class),
    .arrays = PLII_ARRAYS({PLII_MEMBER(drawn_normals_state, previous), PLII_PER_NODE, PLII_SAVED_AS("3f")}),
    .stages = {[PLII_STAGE_FORCES] = {drawn_normals_keep, DRAWN_NORMALS_ORDER},
               [PLII_STAGE_REFRESH] = {drawn_normals_refresh, DRAWN_NORMALS_REFRESH_ORDER}},
};

pli_status pli_body_enable_normals(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_faces(body, "normals are those of faces", __func__));
    return plii_body_changed(body, plii_feature_enable(body, &plii_drawn_normals_class, NULL));
}
PLII_DEFINE_DISABLE(pli_body_disable_normals, plii_check_body_idle, plii_drawn_normals_class)

PLII_DEFINE_GET(const pli_vec3*, pli_body_get_face_normals, body, body->face_normals, NULL)

PLII_DEFINE_DEFAULT(pli_vertex_buffer_def, .stride = 6 * (int)sizeof(float), .normal_offset = 3 * (int)sizeof(float))

static const plii_field vertex_buffer_fields[] = {
    PLII_FIELD(pli_vertex_buffer_def, vertex_count, 0, INT_MAX),
    PLII_FIELD(pli_vertex_buffer_def, stride, 12, INT_MAX),
    PLII_FIELD(pli_vertex_buffer_def, position_offset, 0, INT_MAX),
    PLII_FIELD(pli_vertex_buffer_def, normal_offset, -INT_MAX, INT_MAX),
};

static pli_status vertices_check_offset(const pli_body* body, const pli_vertex_buffer_def* buffer, int offset,
                                        const char* name, const char* function) {
    const int size = 3 * (int)sizeof(float), unit = (int)sizeof(float);
    if (offset <= buffer->stride - size && offset % unit == 0 && buffer->stride % unit == 0) { return PLI_OK; }
    return plii_fail(body->context, PLI_ERROR_INVALID_VALUE, function,
                     "%s is %d with a stride of %d: multiples of %d, with room for %d bytes, are needed", name, offset,
                     buffer->stride, unit, size);
}

static pli_status vertices_check_nodes(const pli_body* body, const pli_vertex_buffer_def* buffer,
                                       const char* function) {
    PLII_FAIL_IF(buffer->vertex_nodes == NULL && buffer->vertex_count > body->node_count, body->context,
                 PLI_ERROR_INDEX_OUT_OF_RANGE, function, "there are %d vertices for %d nodes, and vertex_nodes is null",
                 buffer->vertex_count, body->node_count);
    for (int i = 0; buffer->vertex_nodes != NULL && i < buffer->vertex_count; ++i) {
        const int node = buffer->vertex_nodes[i];
        PLII_FAIL_IF(node < 0 || node >= body->node_count, body->context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                     "the node of vertex %d is %d, the body has %d", i, node, body->node_count);
    }
    return PLI_OK;
}

/* Of the body's step, given that of the world's. */
static float vertices_share_of_step(const pli_body* body, float factor) {
    const plii_update_interval* interval = &body->interval;
    if (plii_body_is_stopped(body)) { return 1.0f; }
    if (body->world->take_update_intervals == NULL || interval->step <= 0.0f) { return factor; }
    const float passed = interval->step - interval->lead;
    return (passed - (1.0f - factor) * body->world->dt) / interval->step;
}

pli_status pli_body_write_vertices(const pli_body* body, const pli_vertex_buffer_def* buffer, float factor) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY_DEF(body->context, pli_vertex_buffer_def, buffer, vertex_buffer_fields, __func__);
    PLII_TRY(plii_check_between(body->context, factor, 0.0f, 2.0f, "factor", __func__));
    if (buffer->vertices == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "vertices is null"); }
    PLII_TRY(vertices_check_offset(body, buffer, buffer->position_offset, "position_offset", __func__));
    const drawn_normals_state* normals = NULL;
    if (buffer->normal_offset >= 0) {
        PLII_TRY(vertices_check_offset(body, buffer, buffer->normal_offset, "normal_offset", __func__));
        normals = plii_feature_state(body, &plii_drawn_normals_class);
        PLII_FAIL_IF(normals == NULL, body->context, PLI_ERROR_INVALID_VALUE, __func__,
                     "normals are wanted, and pli_body_enable_normals was not called");
    }
    PLII_TRY(vertices_check_nodes(body, buffer, __func__));
    factor = vertices_share_of_step(body, factor);
    char* vertex = buffer->vertices;
    for (int i = 0; i < buffer->vertex_count; ++i, vertex += buffer->stride) {
        const int node = buffer->vertex_nodes != NULL ? buffer->vertex_nodes[i] : i;
        const pli_vec3 place = pli_vec3_lerp(plii_xyz(body->previous[node]), plii_xyz(body->positions[node]), factor);
        memcpy(vertex + buffer->position_offset, &place, sizeof place);
        if (normals == NULL) { continue; }
        const pli_vec3 sum = pli_vec3_lerp(normals->previous[node], body->normals[node], factor);
        const pli_vec3 normal = plii_vec3_unit_or(sum, PLII_EPSILON, body->normals[node]);
        memcpy(vertex + buffer->normal_offset, &normal, sizeof normal);
    }
    return PLI_OK;
}
