/* Services: unit normals of nodes and faces, refreshed after each step, and their areas at rest.
   Matches btSoftBody::updateNormals and updateArea(true). */

#include "body_impl.h"

// --------------------------------------------------------------------------------------------------- normals

static pli_vec3 normals_face_cross(const pli_body* body, const int face[3]) {
    const pli_vec3 x0 = plii_xyz(body->positions[face[0]]);
    return pli_vec3_cross(pli_vec3_sub(plii_xyz(body->positions[face[1]]), x0),
                          pli_vec3_sub(plii_xyz(body->positions[face[2]]), x0));
}

static void normals_refresh(pli_body* body, void* state, const plii_step* step) {
    (void)state;
    (void)step;
    for (int i = 0; i < body->node_count; ++i) {
        body->normals[i] = pli_vec3_make(0, 0, 0);
    }
    for (int i = 0; i < body->topology->face_count; ++i) {
        const int* face = body->topology->faces[i];
        const pli_vec3 cross = normals_face_cross(body, face);
        body->face_normals[i] = plii_vec3_safe_normalize(cross);
        for (int k = 0; k < 3; ++k) {
            body->normals[face[k]] = pli_vec3_add(body->normals[face[k]], cross);
        }
    }
    for (int i = 0; i < body->node_count; ++i) {
        const float length = pli_vec3_length(body->normals[i]);
        if (length > PLII_EPSILON) { body->normals[i] = plii_vec3_divide(body->normals[i], length); }
    }
}

static size_t normals_bytes(const pli_body* body, const void* state) {
    (void)state;
    return (size_t)body->node_count * sizeof *body->normals +
           (size_t)body->topology->face_count * sizeof *body->face_normals;
}

static void normals_disable(pli_body* body, void* state) {
    (void)state;
    plii_release(body->context, body->normals, (size_t)body->node_count * sizeof *body->normals);
    plii_release(body->context, body->face_normals, (size_t)body->topology->face_count * sizeof *body->face_normals);
    body->normals = NULL;
    body->face_normals = NULL;
}

static pli_status normals_enable(pli_body* body, void* state) {
    const int face_count = body->topology->face_count;
    body->normals = plii_allocate(body->context, (size_t)body->node_count * sizeof *body->normals);
    body->face_normals = plii_allocate(body->context, (size_t)face_count * sizeof *body->face_normals);
    if (body->normals == NULL || (body->face_normals == NULL && face_count > 0)) {
        normals_disable(body, state);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    normals_refresh(body, state, &body->step);
    return PLI_OK;
}

static int normals_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                   size_t* sizes) {
    (void)state;
    sizes[0] = (size_t)change->node_count * sizeof *body->normals;
    sizes[1] = (size_t)change->face_count * sizeof *body->face_normals;
    return 2;
}

/* The refresh after the change fills them. */
static void normals_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    (void)state;
    plii_release(body->context, body->normals, (size_t)change->old_node_count * sizeof *body->normals);
    plii_release(body->context, body->face_normals, (size_t)change->old_face_count * sizeof *body->face_normals);
    body->normals = blocks[0];
    body->face_normals = blocks[1];
}

const plii_feature_class plii_normals_class = {
    .name = "normals",
    .stages[PLII_STAGE_REFRESH] = {.run = normals_refresh},
    .enable = normals_enable,
    .disable = normals_disable,
    .bytes = normals_bytes,
    .topology_blocks = normals_topology_blocks,
    .topology_commit = normals_topology_commit,
};

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
        body->face_areas[i] = pli_vec3_length(normals_face_cross(body, body->topology->faces[i]));
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
        face_areas[i] = change->takes_rest_shape ? pli_vec3_length(normals_face_cross(body, body->topology->faces[i]))
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
