/* Services: unit normals of nodes and faces, refreshed after each step, and their areas at rest.
   Matches btSoftBody::updateNormals and updateArea(true). */

#include "math/simd_float4.h"

#include "body/body_impl.h"

#include <string.h>

PLII_SIMD_INLINE plii_float4 normals_face_cross(const pli_vec4* positions, const int face[3]) {
    const plii_float4 x0 = plii_float4_from(&positions[face[0]]);
    return plii_lanes_cross(plii_float4_sub(plii_float4_from(&positions[face[1]]), x0),
                            plii_float4_sub(plii_float4_from(&positions[face[2]]), x0));
}

// --------------------------------------------------------------------------------------------------- normals

typedef struct normals_state {
    pli_vec4* sums; /* [node_count] of the cross products of the faces around */
} normals_state;

/* Of four nodes; those without faces keep their zero. */
PLII_SIMD_INLINE void normals_normalize(const pli_vec4* sums, pli_vec3* normals) {
    const plii_vec3x4 sum = plii_vec3x4_from_vec4s(sums, NULL);
    const plii_float4 length = plii_float4_sqrt(plii_vec3x4_dot(sum, sum));
    const plii_float4 one = plii_float4_all(1.0f);
    const plii_mask4 is_long = plii_lanes_less(plii_float4_all(PLII_EPSILON), length);
    const plii_float4 scale = plii_lanes_select(is_long, plii_float4_div(one, length), one);
    plii_vec3x4_to(normals, plii_vec3x4_scale(sum, scale));
}

static void normals_refresh(pli_body* body, void* data, const plii_step* step) {
    (void)step;
    pli_vec4* restrict sums = ((normals_state*)data)->sums;
    const pli_vec4* restrict positions = body->positions;
    const int(*restrict faces)[3] = (const int(*)[3])body->topology->faces;
    const int count = body->node_count, face_count = body->topology->face_count;
    memset(sums, 0, (size_t)count * sizeof *sums);
    for (int i = 0; i < face_count; ++i) {
        const plii_float4 cross = normals_face_cross(positions, faces[i]);
        pli_vec4 *a = &sums[faces[i][0]], *b = &sums[faces[i][1]], *c = &sums[faces[i][2]];
        plii_float4_to(a, plii_float4_add(plii_float4_from(a), cross));
        plii_float4_to(b, plii_float4_add(plii_float4_from(b), cross));
        plii_float4_to(c, plii_float4_add(plii_float4_from(c), cross));
    }
    int i = 0;
    for (; i + PLII_LANES <= count; i += PLII_LANES) {
        normals_normalize(&sums[i], &body->normals[i]);
    }
    if (i == count) { return; }
    pli_vec4 last_sums[PLII_LANES] = {0};
    pli_vec3 last[PLII_LANES];
    memcpy(last_sums, &sums[i], (size_t)(count - i) * sizeof *sums);
    normals_normalize(last_sums, last);
    memcpy(&body->normals[i], last, (size_t)(count - i) * sizeof *last);
}

static size_t normals_bytes(const pli_body* body, const void* data) {
    const normals_state* state = data;
    return (size_t)body->node_count * (sizeof *body->normals + sizeof *state->sums);
}

static void normals_release(pli_body* body, normals_state* state, size_t count) {
    plii_release(body->context, body->normals, count * sizeof *body->normals);
    plii_release(body->context, state->sums, count * sizeof *state->sums);
    body->normals = NULL;
    state->sums = NULL;
}

static void normals_disable(pli_body* body, void* data) {
    normals_release(body, data, (size_t)body->node_count);
}

static pli_status normals_enable(pli_body* body, void* data) {
    normals_state* state = data;
    const size_t count = (size_t)body->node_count;
    body->normals = plii_allocate(body->context, count * sizeof *body->normals);
    state->sums = plii_allocate(body->context, count * sizeof *state->sums);
    if (body->normals == NULL || state->sums == NULL) {
        normals_disable(body, data);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    normals_refresh(body, data, &body->step);
    return PLI_OK;
}

static int normals_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                   size_t* sizes) {
    const normals_state* state = data;
    (void)state;
    sizes[0] = (size_t)change->node_count * sizeof *body->normals;
    sizes[1] = (size_t)change->node_count * sizeof *state->sums;
    return 2;
}

/* The refresh after the change fills them. */
static void normals_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    normals_state* state = data;
    normals_release(body, state, (size_t)change->old_node_count);
    body->normals = blocks[0];
    state->sums = blocks[1];
}

const plii_feature_class plii_normals_class = {
    .name = "normals",
    .state_size = sizeof(normals_state),
    .stages[PLII_STAGE_REFRESH] = {.run = normals_refresh},
    .enable = normals_enable,
    .disable = normals_disable,
    .bytes = normals_bytes,
    .topology_blocks = normals_topology_blocks,
    .topology_commit = normals_topology_commit,
};

// ---------------------------------------------------------------------------------------------- normals of faces

static void face_normals_refresh(pli_body* body, void* state, const plii_step* step) {
    (void)state;
    (void)step;
    for (int i = 0; i < body->topology->face_count; ++i) {
        pli_vec3 cross;
        plii_lanes_to_vec3(&cross, normals_face_cross(body->positions, body->topology->faces[i]));
        body->face_normals[i] = plii_vec3_safe_normalize(cross);
    }
}

static size_t face_normals_bytes(const pli_body* body, const void* state) {
    (void)state;
    return (size_t)body->topology->face_count * sizeof *body->face_normals;
}

static void face_normals_disable(pli_body* body, void* state) {
    plii_release(body->context, body->face_normals, face_normals_bytes(body, state));
    body->face_normals = NULL;
}

static pli_status face_normals_enable(pli_body* body, void* state) {
    body->face_normals = plii_allocate(body->context, face_normals_bytes(body, state));
    if (body->face_normals == NULL && body->topology->face_count > 0) { return PLI_ERROR_OUT_OF_MEMORY; }
    face_normals_refresh(body, state, &body->step);
    return PLI_OK;
}

static int face_normals_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                        size_t* sizes) {
    (void)state;
    sizes[0] = (size_t)change->face_count * sizeof *body->face_normals;
    return 1;
}

static void face_normals_topology_commit(pli_body* body, void* state, const plii_topology_change* change,
                                         void** blocks) {
    (void)state;
    plii_release(body->context, body->face_normals, (size_t)change->old_face_count * sizeof *body->face_normals);
    body->face_normals = blocks[0];
}

const plii_feature_class plii_face_normals_class = {
    .name = "face normals",
    .stages[PLII_STAGE_REFRESH] = {.run = face_normals_refresh},
    .enable = face_normals_enable,
    .disable = face_normals_disable,
    .bytes = face_normals_bytes,
    .topology_blocks = face_normals_topology_blocks,
    .topology_commit = face_normals_topology_commit,
};

static float normals_doubled_area(const pli_body* body, const int face[3]) {
    const plii_float4 cross = normals_face_cross(body->positions, face);
    return sqrtf(plii_lanes_dot(cross, cross));
}

// ----------------------------------------------------------------------------------------------------- areas

static size_t areas_bytes(const pli_body* body, const void* state) {
    (void)state;
    return (size_t)body->node_count * sizeof *body->areas +
           (size_t)body->topology->face_count * sizeof *body->face_areas;
}

static void areas_disable(pli_body* body, void* state) {
    (void)state;
    plii_release(body->context, body->areas, (size_t)body->node_count * sizeof *body->areas);
    plii_release(body->context, body->face_areas, (size_t)body->topology->face_count * sizeof *body->face_areas);
    body->areas = NULL;
    body->face_areas = NULL;
}

/* Means over the faces around; `counts` [node_count] is zeroed scratch, and so are the areas. */
static void areas_of_nodes(pli_body* body, int* counts) {
    for (int i = 0; i < body->topology->face_count; ++i) {
        const int* face = body->topology->faces[i];
        for (int k = 0; k < 3; ++k) {
            counts[face[k]] += 1;
            body->areas[face[k]] += fabsf(body->face_areas[i]);
        }
    }
    for (int i = 0; i < body->node_count; ++i) {
        if (counts[i] > 0) { body->areas[i] /= (float)counts[i]; }
    }
}

static pli_status areas_enable(pli_body* body, void* state) {
    const int node_count = body->node_count, face_count = body->topology->face_count;
    body->areas = plii_allocate(body->context, (size_t)node_count * sizeof *body->areas);
    body->face_areas = plii_allocate(body->context, (size_t)face_count * sizeof *body->face_areas);
    int* counts = plii_allocate(body->context, (size_t)node_count * sizeof *counts);
    if (body->areas == NULL || (body->face_areas == NULL && face_count > 0) || counts == NULL) {
        plii_release(body->context, counts, (size_t)node_count * sizeof *counts);
        areas_disable(body, state);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    for (int i = 0; i < face_count; ++i) {
        body->face_areas[i] = normals_doubled_area(body, body->topology->faces[i]);
    }
    areas_of_nodes(body, counts);
    plii_release(body->context, counts, (size_t)node_count * sizeof *counts);
    return PLI_OK;
}

static int areas_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                 size_t* sizes) {
    (void)state;
    sizes[0] = (size_t)change->node_count * sizeof *body->areas;
    sizes[1] = (size_t)change->face_count * sizeof *body->face_areas;
    sizes[2] = (size_t)change->node_count * sizeof(int);
    return 3;
}

/* Parts of a face share its area at rest. */
static void areas_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    (void)state;
    float* face_areas = blocks[1];
    for (int i = 0; i < change->face_count; ++i) {
        const plii_face_origin origin = change->face_origins[i];
        face_areas[i] = change->takes_rest_shape ? normals_doubled_area(body, body->topology->faces[i])
                                                 : body->face_areas[origin.parent] * origin.share;
    }
    plii_release(body->context, body->areas, (size_t)change->old_node_count * sizeof *body->areas);
    plii_release(body->context, body->face_areas, (size_t)change->old_face_count * sizeof *body->face_areas);
    body->areas = blocks[0];
    body->face_areas = face_areas;
    areas_of_nodes(body, blocks[2]);
    plii_release(body->context, blocks[2], (size_t)change->node_count * sizeof(int));
}

const plii_feature_class plii_areas_class = {
    .name = "areas",
    .enable = areas_enable,
    .disable = areas_disable,
    .bytes = areas_bytes,
    .topology_blocks = areas_topology_blocks,
    .topology_commit = areas_topology_commit,
};
