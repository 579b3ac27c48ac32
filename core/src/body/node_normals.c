/* Services: normals of nodes and faces after each step, areas at rest. Bullet: updateNormals, updateArea(true). */

#include "body/pipeline.h"
#include "math/simd_float4.h"

PLII_SIMD_INLINE plii_float4 normals_face_cross(const pli_vec4* positions, const int face[3]) {
    const plii_float4 x0 = plii_float4_from(&positions[face[0]]);
    return plii_lanes_cross(plii_float4_from(&positions[face[1]]) - x0, plii_float4_from(&positions[face[2]]) - x0);
}

typedef struct normals_state {
    pli_vec4* sums; /* [node_count] of the cross products of the faces around */
} normals_state;

static void normals_gather(pli_body* body, pli_vec4* restrict sums) {
    const pli_vec4* restrict positions = body->positions;
    const int(*restrict faces)[3] = (const int(*)[3])body->topology->faces;
    const int count = body->node_count, face_count = body->topology->face_count;
    memset(sums, 0, (size_t)count * sizeof *sums);
    for (int i = 0; i < face_count; ++i) {
        const plii_float4 cross = normals_face_cross(positions, faces[i]);
        pli_vec4 *a = &sums[faces[i][0]], *b = &sums[faces[i][1]], *c = &sums[faces[i][2]];
        plii_float4_to(a, plii_float4_from(a) + cross);
        plii_float4_to(b, plii_float4_from(b) + cross);
        plii_float4_to(c, plii_float4_from(c) + cross);
    }
    body->has_crosses = true;
}

const pli_vec4* plii_normals_crosses(pli_body* body) {
    if (body->world->def.reference_mode) { return NULL; }
    normals_state* state = plii_feature_state(body, &plii_normals_class);
    if (!body->has_crosses) { normals_gather(body, state->sums); }
    return state->sums;
}

static void normals_refresh(pli_body* body, void* data) {
    pli_vec4* sums = ((normals_state*)data)->sums;
    normals_gather(body, sums);
    int i = 0;
    for (; i + PLII_LANES <= body->node_count; i += PLII_LANES) {
        const plii_vec3x4 sum = plii_vec3x4_from_vec4s(&sums[i]);
        const plii_float4 length = plii_float4_sqrt(plii_vec3x4_dot(sum, sum));
        const plii_vec3x4 normals = plii_vec3x4_scale(sum, 1.0f / length);
        plii_vec3x4_to(&body->normals[i], plii_vec3x4_select(length > PLII_EPSILON, normals, sum));
    }
    for (; i < body->node_count; ++i) {
        const pli_vec3 sum = plii_xyz(sums[i]);
        body->normals[i] = plii_vec3_unit_or(sum, PLII_EPSILON, sum); /* those without faces keep their zero */
    }
}

static void normals_on_restored(pli_body* body, void* state) {
    body->has_crosses = false;
}

const plii_feature_class plii_normals_class = {
    .name = "normals",
    .state_size = sizeof(normals_state),
    /* After a cut the refresh fills them. */
    .arrays = PLII_ARRAYS({PLII_MEMBER(pli_body, normals), PLII_PER_NODE, .is_in_body = true, PLII_SAVED_AS("3f")},
                          PLII_LEFT_PER_NODE(normals_state, sums)),
    .stages[PLII_STAGE_REFRESH] = {.run = normals_refresh},
    .on_restored = normals_on_restored,
};

static void face_normals_refresh(pli_body* body, void* state) {
    for (int i = 0; i < body->topology->face_count; ++i) {
        pli_vec3 cross;
        plii_lanes_to_vec3(&cross, normals_face_cross(body->positions, body->topology->faces[i]));
        body->face_normals[i] = plii_vec3_safe_normalize(cross);
    }
}

const plii_feature_class plii_face_normals_class = {
    .name = "face normals",
    .arrays =
        PLII_ARRAYS({PLII_MEMBER(pli_body, face_normals), PLII_PER_FACE, .is_in_body = true, PLII_SAVED_AS("3f")}),
    .stages[PLII_STAGE_REFRESH] = {.run = face_normals_refresh},
};

static float normals_doubled_area(const pli_body* body, const int face[3]) {
    const plii_float4 cross = normals_face_cross(body->positions, face);
    return sqrtf(plii_lanes_dot(cross, cross));
}

typedef struct areas_state {
    int* face_counts; /* [node_count] */
} areas_state;

/* Means over the faces around. */
static void areas_of_nodes(pli_body* body, const areas_state* state) {
    for (int i = 0; i < body->topology->face_count; ++i) {
        const int* face = body->topology->faces[i];
        for (int k = 0; k < 3; ++k) {
            state->face_counts[face[k]] += 1;
            body->areas[face[k]] += fabsf(body->face_areas[i]);
        }
    }
    for (int i = 0; i < body->node_count; ++i) {
        if (state->face_counts[i] > 0) { body->areas[i] /= (float)state->face_counts[i]; }
    }
}

static void areas_enable(pli_body* body, void* state) {
    for (int i = 0; i < body->topology->face_count; ++i) {
        body->face_areas[i] = normals_doubled_area(body, body->topology->faces[i]);
    }
    areas_of_nodes(body, state);
}

/* Parts of a face share its area at rest. */
static void areas_topology_commit(pli_body* body, void* state, const plii_topology_change* change) {
    const float* old_face_areas = change->old_arrays[1];
    for (int i = 0; i < change->face_count; ++i) {
        const plii_face_origin origin = change->face_origins[i];
        body->face_areas[i] = change->takes_rest_shape ? normals_doubled_area(body, body->topology->faces[i])
                                                       : old_face_areas[origin.parent] * origin.share;
    }
    areas_of_nodes(body, state);
}

const plii_feature_class plii_areas_class = {
    .name = "areas",
    .state_size = sizeof(areas_state),
    .arrays = PLII_ARRAYS({PLII_MEMBER(pli_body, areas), PLII_PER_NODE, .is_in_body = true, PLII_FILED_AS("f")},
                          {PLII_MEMBER(pli_body, face_areas), PLII_PER_FACE, .is_in_body = true, PLII_FILED_AS("f")},
                          {PLII_MEMBER(areas_state, face_counts), PLII_PER_NODE, .is_scratch = true}),
    .enable = areas_enable,
    .topology_commit = areas_topology_commit,
};
