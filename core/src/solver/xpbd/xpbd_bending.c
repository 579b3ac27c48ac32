/* XPBD: dihedral angles, C = angle between the normals of two faces with a common edge - rest angle. The gradient is
   that of Bridson, Marino, Fedkiw, "Simulation of Clothing with Folds and Wrinkles". */

#include "base/csr.h"
#include "body/all_features.h"
#include "math/definition.h"
#include "solver/coloring/constraint_coloring.h"
#include "solver/xpbd/xpbd_impl.h"

#include <string.h>

typedef struct xpbd_hinge {
    int nodes[4]; /* the edge, then the tips; the first face has the edge from nodes[0] to nodes[1] */
    float rest_angle;
    float multiplier;
} xpbd_hinge;

typedef struct xpbd_face_edge {
    int other; /* the larger node of the edge */
    int tip;   /* -1 - tip when the face runs from the larger to the smaller node */
} xpbd_face_edge;

/* There is room for as many hinges as the faces can have edges with two faces. */
typedef struct xpbd_bending_state {
    pli_xpbd_bending_def def;
    xpbd_hinge* hinges; /* [hinge_count] in coloured order */
    int hinge_count;
    /* What finding them needs for a while. */
    int* begin;            /* [node_count + 1] */
    xpbd_face_edge* edges; /* [3 * face_count] by their smaller node */
    int (*nodes)[4];       /* [hinge_count] as they are found */
    uint64_t* masks;       /* [node_count] */
    uint8_t* colors;       /* [hinge_count] */
    int* order;            /* [hinge_count] */
} xpbd_bending_state;

// ----------------------------------------------------------------------------------------------- angle

typedef struct xpbd_hinge_shape {
    float angle; /* in (-pi, pi] */
    pli_vec3 gradients[4];
    bool is_valid; /* no face without area */
} xpbd_hinge_shape;

static xpbd_hinge_shape xpbd_hinge_measure(const pli_vec3 x[4]) {
    xpbd_hinge_shape shape = {0};
    const pli_vec3 edge = pli_vec3_sub(x[1], x[0]);
    const pli_vec3 a0 = pli_vec3_sub(x[2], x[0]), a1 = pli_vec3_sub(x[2], x[1]);
    const pli_vec3 b0 = pli_vec3_sub(x[3], x[0]), b1 = pli_vec3_sub(x[3], x[1]);
    const pli_vec3 normal_a = pli_vec3_cross(edge, a0), normal_b = pli_vec3_cross(b0, edge);
    const float length = pli_vec3_length(edge);
    const float area_a = pli_vec3_length_squared(normal_a), area_b = pli_vec3_length_squared(normal_b);
    const float inverse_length = 1.0f / length;
    const pli_vec3 tip_a = pli_vec3_scale(normal_a, -length / area_a),
                   tip_b = pli_vec3_scale(normal_b, -length / area_b);
    const float share_a0 = pli_vec3_dot(a0, edge) * inverse_length * inverse_length;
    const float share_b0 = pli_vec3_dot(b0, edge) * inverse_length * inverse_length;
    const float share_a1 = -pli_vec3_dot(a1, edge) * inverse_length * inverse_length;
    const float share_b1 = -pli_vec3_dot(b1, edge) * inverse_length * inverse_length;
    shape.gradients[2] = tip_a;
    shape.gradients[3] = tip_b;
    shape.gradients[0] = pli_vec3_neg(pli_vec3_add(pli_vec3_scale(tip_a, share_a1), pli_vec3_scale(tip_b, share_b1)));
    shape.gradients[1] = pli_vec3_neg(pli_vec3_add(pli_vec3_scale(tip_a, share_a0), pli_vec3_scale(tip_b, share_b0)));
    shape.is_valid = true;
    for (int k = 0; k < 4; ++k) {
        shape.is_valid = shape.is_valid && plii_vec3_is_finite(shape.gradients[k]);
    }
    const float sine = pli_vec3_dot(pli_vec3_cross(normal_a, normal_b), edge) * inverse_length;
    shape.angle = atan2f(sine, pli_vec3_dot(normal_a, normal_b));
    return shape;
}

/* The shortest way round. */
static float xpbd_hinge_difference(float angle, float rest) {
    const float pi = 3.14159265f;
    const float difference = angle - rest;
    return difference > pi ? difference - 2.0f * pi : difference < -pi ? difference + 2.0f * pi : difference;
}

// ----------------------------------------------------------------------------------------------- solving

static void xpbd_bending_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_bending_state* state = data;
    for (PLII_EACH(xpbd_hinge, hinge, state->hinges, state->hinge_count)) {
        pli_vec3 x[4];
        for (int k = 0; k < 4; ++k) {
            x[k] = plii_substep_position(body, substep, hinge->nodes[k]);
        }
        const xpbd_hinge_shape shape = xpbd_hinge_measure(x);
        if (!shape.is_valid) { continue; }
        float weight = 0.0f, motion = 0.0f;
        for (int k = 0; k < 4; ++k) {
            weight += substep->displacements[hinge->nodes[k]].w * pli_vec3_length_squared(shape.gradients[k]);
            motion += pli_vec3_dot(shape.gradients[k], plii_substep_motion(substep, hinge->nodes[k]));
        }
        const float multiplier = substep->is_first_sweep ? 0.0f : hinge->multiplier;
        const float rest_angle = state->def.is_flat ? 0.0f : hinge->rest_angle;
        const float change =
            plii_xpbd_multiplier(xpbd_hinge_difference(shape.angle, rest_angle), weight, state->def.compliance,
                                 state->def.damping, multiplier, motion, substep);
        hinge->multiplier = multiplier + change;
        for (int k = 0; k < 4; ++k) {
            plii_substep_move(substep, hinge->nodes[k], shape.gradients[k], change);
        }
    }
}

// ----------------------------------------------------------------------------------------------- finding hinges

static void xpbd_bending_sort_edges(const pli_body* body, const xpbd_bending_state* state) {
    const plii_topology* topology = body->topology;
    int* begin = state->begin;
    for (int i = 0; i < topology->face_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int a = topology->faces[i][k], b = topology->faces[i][(k + 1) % 3];
            ++begin[a < b ? a : b];
        }
    }
    (void)plii_csr_sum(body->node_count, begin);
    for (int i = topology->face_count - 1; i >= 0; --i) {
        for (int k = 2; k >= 0; --k) {
            const int a = topology->faces[i][k], b = topology->faces[i][(k + 1) % 3];
            const int tip = topology->faces[i][(k + 2) % 3];
            state->edges[--begin[a < b ? a : b]] = a < b ? (xpbd_face_edge){b, tip} : (xpbd_face_edge){a, -1 - tip};
        }
    }
}

/* A pair of faces that run along the edge in opposite directions; others have no common side to bend about. Of three
   and more faces on an edge each is taken once. */
static int xpbd_bending_pair(const pli_body* body, const xpbd_bending_state* state) {
    int count = 0;
    for (int node = 0; node < body->node_count; ++node) {
        const int end = state->begin[node + 1];
        for (int i = state->begin[node]; i < end; ++i) {
            xpbd_face_edge* first = &state->edges[i];
            for (int k = i + 1; first->other != PLI_NULL_INDEX && k < end; ++k) {
                xpbd_face_edge* second = &state->edges[k];
                if (second->other != first->other || (second->tip < 0) == (first->tip < 0)) { continue; }
                const int forward = first->tip >= 0 ? first->tip : second->tip;
                const int backward = first->tip >= 0 ? -1 - second->tip : -1 - first->tip;
                const int nodes[4] = {node, first->other, forward, backward};
                memcpy(state->nodes[count], nodes, sizeof nodes);
                count += forward != backward ? 1 : 0;
                first->other = PLI_NULL_INDEX;
                second->other = PLI_NULL_INDEX;
            }
        }
    }
    return count;
}

static void xpbd_bending_build(pli_body* body, void* data) {
    xpbd_bending_state* state = data;
    state->hinge_count = 0;
    if (body->topology->face_count == 0) { return; }
    xpbd_bending_sort_edges(body, state);
    state->hinge_count = xpbd_bending_pair(body, state);
    plii_constraint_order(state->hinge_count, 4, state->nodes[0], state->masks, state->colors, state->order);
    for (int i = 0; i < state->hinge_count; ++i) {
        const int* nodes = state->nodes[state->order[i]];
        pli_vec3 x[4];
        for (int k = 0; k < 4; ++k) {
            x[k] = plii_xyz(body->positions[nodes[k]]);
        }
        const xpbd_hinge_shape shape = xpbd_hinge_measure(x);
        state->hinges[i] =
            (xpbd_hinge){{nodes[0], nodes[1], nodes[2], nodes[3]}, shape.is_valid ? shape.angle : 0.0f, 0.0f};
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

#define XPBD_BENDING_PER_HINGE PLII_PER_FACE, .times = 3, .per = 2

enum { XPBD_BENDING_ORDER = 10 }; /* the first */

const plii_feature_class plii_xpbd_bending_class = {
    .name = "XPBD bending",
    .state_size = sizeof(xpbd_bending_state),
    .settings = PLII_LIMITS_AT(offsetof(xpbd_bending_state, def),
                               PLII_FIELD(pli_xpbd_bending_def, compliance, 0, PLI_MAX_COEFFICIENT),
                               PLII_FIELD(pli_xpbd_bending_def, damping, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(xpbd_bending_state, def, PLII_SAVED, "2fBu"),
                                    PLII_STATE(xpbd_bending_state, hinge_count, PLII_LEFT)),
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(xpbd_bending_state, hinges), XPBD_BENDING_PER_HINGE, .snapshot = PLII_FILED, .fields = "4n2f"},
        {PLII_MEMBER(xpbd_bending_state, begin), PLII_PER_NODE, .more = 1, .is_scratch = true},
        {PLII_MEMBER(xpbd_bending_state, edges), PLII_PER_FACE, .times = 3, .is_scratch = true},
        {PLII_MEMBER(xpbd_bending_state, nodes), XPBD_BENDING_PER_HINGE, .is_scratch = true},
        {PLII_MEMBER(xpbd_bending_state, masks), PLII_PER_NODE, .is_scratch = true},
        {PLII_MEMBER(xpbd_bending_state, colors), XPBD_BENDING_PER_HINGE, .is_scratch = true},
        {PLII_MEMBER(xpbd_bending_state, order), XPBD_BENDING_PER_HINGE, .is_scratch = true}),
    .build = xpbd_bending_build,
    .substepped =
        &(const plii_substep_class){.order = XPBD_BENDING_ORDER, .is_of_xpbd = true, .sweep = xpbd_bending_sweep},
};

pli_xpbd_bending_def pli_xpbd_bending_def_default(void) {
    return (pli_xpbd_bending_def){.cookie = PLII_DEF_COOKIE};
}

pli_status pli_body_enable_xpbd_bending(pli_body* body, const pli_xpbd_bending_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_xpbd_bending_def, used, def, plii_xpbd_bending_class);
    PLII_TRY(plii_check_faces(body, "bending is between faces", __func__));
    return plii_xpbd_enable_kind(body, &plii_xpbd_bending_class, &used, sizeof used, __func__, NULL);
}

PLII_DEFINE_DISABLE(pli_body_disable_xpbd_bending, plii_check_body_idle, plii_xpbd_bending_class)
