/* What cuts and refinements have made of nodes and faces, for whoever keeps data beside them. */

#include "body/pipeline.h"
#include "pliant/drawing.h"

typedef struct topology_changes_state {
    int old_node_count, old_face_count;
    pli_new_node* new_nodes;
    int new_node_count, new_node_capacity;
    int* face_parents; /* [face_count] */
} topology_changes_state;

static bool changes_topology_reserve(const pli_body* body, void* data, const plii_topology_change* change) {
    topology_changes_state* state = data;
    return PLII_RESERVE(body->context, &state->new_nodes, &state->new_node_capacity,
                        change->node_count - state->old_node_count);
}

/* Old nodes keep their index, so new ones follow those of before; parents of faces are looked up in those of before. */
static void changes_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    topology_changes_state* state = data;
    const int* old_parents = change->old_arrays[1];
    for (int i = change->old_node_count; i < change->node_count; ++i) {
        const plii_node_origin origin = change->node_origins[i - change->old_node_count];
        state->new_nodes[state->new_node_count++] = (pli_new_node){origin.a, origin.b, origin.share};
    }
    for (int i = 0; i < change->face_count; ++i) {
        state->face_parents[i] = old_parents[change->face_origins[i].parent];
    }
}

static bool topology_changes_is_sound(const pli_body* body, const void* data) {
    const topology_changes_state* state = data;
    if (state->old_node_count < 0 || state->old_node_count + state->new_node_count != body->node_count) {
        return false;
    }
    for (int i = 0; i < body->topology->face_count; ++i) {
        if (state->face_parents[i] < 0 || state->face_parents[i] >= state->old_face_count) { return false; }
    }
    return true;
}

const plii_feature_class plii_topology_changes_class = {
    .name = "topology changes",
    .state_size = sizeof(topology_changes_state),
    .state_parts =
        PLII_STATE_PARTS(PLII_STATE_SPAN(topology_changes_state, old_node_count, old_face_count, PLII_SAVED, "2i")),
    .is_sound = topology_changes_is_sound,
    .arrays = PLII_ARRAYS({PLII_COUNTED_LIST(topology_changes_state, new_nodes, new_node_capacity, new_node_count),
                           .is_kept = true, PLII_SAVED_AS("2nf")},
                          {PLII_MEMBER(topology_changes_state, face_parents), PLII_PER_FACE, PLII_SAVED_AS("i")}),
    .topology_reserve = changes_topology_reserve,
    .topology_commit = changes_topology_commit,
};

pli_status pli_body_enable_topology_changes(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_ENABLE(body, topology_changes_state, state, plii_topology_changes_class);
    state->old_node_count = body->node_count;
    state->old_face_count = body->topology->face_count;
    state->new_node_count = 0;
    for (int i = 0; i < state->old_face_count; ++i) {
        state->face_parents[i] = i;
    }
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_DISABLE(pli_body_disable_topology_changes, plii_check_body_idle, plii_topology_changes_class)

PLII_DEFINE_STATE_GET(pli_topology_changes, pli_body_get_topology_changes, topology_changes_state,
                      plii_topology_changes_class,
                      ((pli_topology_changes){.old_node_count = state->old_node_count,
                                              .new_node_count = state->new_node_count,
                                              .new_nodes = state->new_nodes,
                                              .old_face_count = state->old_face_count,
                                              .face_count = body->topology->face_count,
                                              .face_parents = state->face_parents}),
                      (pli_topology_changes){0})
