/* XPBD: dihedral angles, C = angle between the normals of two faces with a common edge - rest angle. The gradient is
   that of Bridson, Marino, Fedkiw, "Simulation of Clothing with Folds and Wrinkles". */

#include "solver/coloring/constraint_coloring.h"
#include "solver/xpbd/xpbd_impl.h"

typedef struct xpbd_hinge {
    int nodes[4]; /* the edge, then the tips; the first face has the edge from nodes[0] to nodes[1] */
    float rest_angle;
    float multiplier;
} xpbd_hinge;

/* There is room for as many hinges as the faces can have edges with two faces. */
typedef struct xpbd_bending_state {
    pli_xpbd_bending_def def;
    xpbd_hinge* hinges; /* [hinge_count] in coloured order */
    int hinge_count;
    /* What finding them needs for a while. */
    int *begin, *keys, *corners;  /* [node_count + 1], [3 * face_count]: of edges of faces, by their smaller node */
    int (*nodes)[4], (*faces)[2]; /* [hinge_count] as they are found */
    uint64_t* masks;              /* [node_count] */
    uint8_t* colors;              /* [hinge_count] */
    int* order;                   /* [hinge_count] */
} xpbd_bending_state;

typedef struct xpbd_hinge_shape {
    float angle; /* in (-pi, pi] */
    pli_vec3 gradients[4];
    bool is_valid; /* no face without area */
} xpbd_hinge_shape;

static xpbd_hinge_shape xpbd_hinge_measure(const pli_vec3 x[4]) {
    xpbd_hinge_shape shape = {0};
    const pli_vec3 edge = pli_vec3_sub(x[1], x[0]);
    const pli_vec3 a0 = pli_vec3_sub(x[2], x[0]), b0 = pli_vec3_sub(x[3], x[0]);
    const pli_vec3 normal_a = pli_vec3_cross(edge, a0), normal_b = pli_vec3_cross(b0, edge);
    const float length = pli_vec3_length(edge);
    const float area_a = pli_vec3_length_squared(normal_a), area_b = pli_vec3_length_squared(normal_b);
    const float inverse_length = 1.0f / length;
    const pli_vec3 tip_a = pli_vec3_scale(normal_a, -length / area_a),
                   tip_b = pli_vec3_scale(normal_b, -length / area_b);
    const float share_a0 = pli_vec3_dot(a0, edge) * inverse_length * inverse_length;
    const float share_b0 = pli_vec3_dot(b0, edge) * inverse_length * inverse_length;
    const float share_a1 = 1.0f - share_a0, share_b1 = 1.0f - share_b0;
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

/* Of hinges, see plii_xpbd_multiplier. Angles at the edges of a face share its nodes, and there are nearly as many of
   them as nodes can move in directions: with more than half of their error in a sweep, errors that the colours push
   around grow from sweep to sweep, as on closed surfaces those of links do. At two fifths they do not. */
#define XPBD_BENDING_SOFTENING 1.5f

static void xpbd_bending_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_bending_state* state = data;
    for (PLII_EACH(xpbd_hinge, hinge, state->hinges, state->hinge_count)) {
        pli_vec3 x[4];
        x[0] = plii_xyz(substep->displacements[hinge->nodes[0]]);
        /* From the position of the first corner: far from the origin sums of position and displacement are coarse. */
        const pli_vec3 first = plii_xyz(body->positions[hinge->nodes[0]]);
        for (int k = 1; k < 4; ++k) {
            const int node = hinge->nodes[k];
            x[k] = pli_vec3_add(pli_vec3_sub(plii_xyz(body->positions[node]), first),
                                plii_xyz(substep->displacements[node]));
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
                                 state->def.damping, XPBD_BENDING_SOFTENING, multiplier, motion, substep);
        hinge->multiplier = multiplier + change;
        for (int k = 0; k < 4; ++k) {
            plii_substep_move(substep, hinge->nodes[k], shape.gradients[k], change);
        }
    }
}

/* The edge of a face from one of its corners to the next. */
typedef struct xpbd_face_edge {
    int from, to, tip;
} xpbd_face_edge;

static xpbd_face_edge xpbd_edge_from(const pli_body* body, int corner) {
    const int *face = body->topology->faces[corner / 3], k = corner % 3;
    return (xpbd_face_edge){face[k], face[(k + 1) % 3], face[(k + 2) % 3]};
}

/* Pairs of faces that run along the edge in opposite directions; of three and more on an edge each is taken once. */
static int xpbd_bending_pair(const pli_body* body, const xpbd_bending_state* state) {
    int count = 0, *corners = state->corners;
    for (int node = 0; node < body->node_count; ++node) {
        const int end = state->begin[node + 1];
        for (int i = state->begin[node]; i < end; ++i) {
            for (int k = i + 1; corners[i] != PLI_NULL_INDEX && k < end; ++k) {
                if (corners[k] == PLI_NULL_INDEX) { continue; }
                const xpbd_face_edge first = xpbd_edge_from(body, corners[i]),
                                     second = xpbd_edge_from(body, corners[k]);
                if (first.from != second.to || first.to != second.from) { continue; }
                const bool is_forward = first.from == node;
                const int nodes[4] = {node, is_forward ? first.to : first.from, is_forward ? first.tip : second.tip,
                                      is_forward ? second.tip : first.tip};
                memcpy(state->nodes[count], nodes, sizeof nodes);
                state->faces[count][0] = corners[i] / 3;
                state->faces[count][1] = corners[k] / 3;
                count += first.tip != second.tip ? 1 : 0;
                corners[i] = corners[k] = PLI_NULL_INDEX;
            }
        }
    }
    return count;
}

static void xpbd_bending_enable(pli_body* body, void* data) {
    xpbd_bending_state* state = data;
    state->hinge_count = 0;
    if (body->topology->face_count == 0) { return; }
    plii_csr_sort_edges(body->node_count, body->topology->face_count, (const int(*)[3])body->topology->faces,
                        state->keys, state->begin, state->corners);
    state->hinge_count = xpbd_bending_pair(body, state);
    plii_constraint_order(state->hinge_count, (const int(*)[4])state->nodes, state->masks, state->colors, state->order);
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

/* Between the faces that two have come from; parts of a face lie in its plane. `corners` has `before` by node. */
static float xpbd_bending_rest_before(const xpbd_bending_state* state, const xpbd_hinge* before,
                                      const plii_topology_change* change, const int faces[2]) {
    const int *a = change->old_faces[change->face_origins[faces[0]].parent],
              *b = change->old_faces[change->face_origins[faces[1]].parent];
    for (int corner = 0; corner < 9; ++corner) {
        const int j = corner / 3, k = corner % 3, from = a[j], to = a[(j + 1) % 3];
        if (from != b[(k + 1) % 3] || to != b[k]) { continue; }
        const int first = from < to ? from : to;
        for (int i = state->begin[first]; i < state->begin[first + 1]; ++i) {
            const xpbd_hinge* hinge = &before[state->corners[i]];
            if (hinge->nodes[1] == from + to - first) { return hinge->rest_angle; }
        }
    }
    return 0.0f;
}

static void xpbd_bending_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    xpbd_bending_state* state = data;
    const xpbd_hinge* before = change->old_arrays[0];
    const int count = state->hinge_count;
    xpbd_bending_enable(body, state);
    if (change->takes_rest_shape) { return; }
    for (int i = 0; i < count; ++i) {
        state->keys[i] = before[i].nodes[0];
    }
    plii_csr_sort(change->old_node_count, count, state->keys, state->begin, state->corners);
    for (int i = 0; i < state->hinge_count; ++i) {
        const int* faces = state->faces[state->order[i]];
        state->hinges[i].rest_angle = xpbd_bending_rest_before(state, before, change, faces);
    }
}

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
    .arrays = PLII_ARRAYS({PLII_MEMBER(xpbd_bending_state, hinges), XPBD_BENDING_PER_HINGE, PLII_FILED_AS("4n2f")},
                          {PLII_MEMBER(xpbd_bending_state, begin), PLII_PER_NODE, .more = 1, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, keys), PLII_PER_FACE, .times = 3, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, corners), PLII_PER_FACE, .times = 3, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, nodes), XPBD_BENDING_PER_HINGE, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, faces), XPBD_BENDING_PER_HINGE, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, masks), PLII_PER_NODE, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, colors), XPBD_BENDING_PER_HINGE, .is_scratch = true},
                          {PLII_MEMBER(xpbd_bending_state, order), XPBD_BENDING_PER_HINGE, .is_scratch = true}),
    .enable = xpbd_bending_enable,
    .topology_commit = xpbd_bending_topology_commit,
    .substepped = PLII_SUBSTEPPED(.order = XPBD_BENDING_ORDER, .is_of_xpbd = true, .sweep = xpbd_bending_sweep),
};

PLII_DEFINE_DEFAULT(pli_xpbd_bending_def, 0)
pli_status pli_body_enable_xpbd_bending(pli_body* body, const pli_xpbd_bending_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_xpbd_bending_def, used, def, plii_xpbd_bending_class);
    PLII_TRY(plii_check_faces(body, "bending is between faces", __func__));
    return plii_xpbd_enable_kind(body, &plii_xpbd_bending_class, &used, sizeof used, __func__, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_xpbd_bending, plii_check_body_idle, plii_xpbd_bending_class)
