/* Cutting along the surface that a ray sweeps, as a mouse does between two frames.

   The surface is one triangle or two, each a plane blade with an outline. Edges that a blade crosses get a node there,
   or, near one of their ends, use that end. Faces that a blade crosses from edge to edge are parted along it, and the
   surface is opened along these new edges. A face in which a blade ends is only refined: its node stays closed, as the
   tip of the cut. A single edge between two tips stays closed too. Both are kept with the body. A sweep that goes on
   where the last one ended opens its first face up to the tip at it, so many short sweeps make one cut, and a cut that
   returns to its start closes. */

#include "body/pipeline.h"
#include "cut/cut_swept_impl.h"
#include "math/bounds.h"
#include "pliant/cut.h"

/* A ray goes on from another when its ends are as near as this share of its length. */
#define SWEPT_SAME_RAY 1e-4f

typedef struct trace_state {
    bool has_ray;
    pli_vec3 ray[2]; /* the last ray of the last sweep */
    plii_swept_ends ends;
} trace_state;

static bool trace_copy_ends(pli_context* context, const plii_swept_ends* from, plii_swept_ends* to) {
    *to = *from;
    to->tips = plii_duplicate(context, from->tips, (size_t)from->tip_capacity * sizeof *to->tips);
    to->edges = plii_duplicate(context, from->edges, (size_t)from->edge_capacity * sizeof *to->edges);
    return (to->tips != NULL || from->tip_capacity == 0) && (to->edges != NULL || from->edge_capacity == 0);
}

/* A cut of another kind ends the sweep; a swept cut sets its ends after this. */
static void trace_forget(pli_body* body, void* state) {
    trace_state* trace = state;
    trace->has_ray = false;
    trace->ends.tip_count = 0;
    trace->ends.edge_count = 0;
}

const plii_feature_class plii_trace_class = {
    .name = "cut trace",
    .is_made_by_calls = true, /* by one that meets nothing, too */
    .state_size = sizeof(trace_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(trace_state, has_ray, ray, PLII_SAVED, "B6f")),
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(trace_state, ends.tips, ends.tip_capacity, ends.tip_count), PLII_SAVED_AS("n")},
        {PLII_COUNTED_LIST(trace_state, ends.edges, ends.edge_capacity, ends.edge_count), PLII_SAVED_AS("2n")}),
    .build = trace_forget,
};

static bool trace_ends_at(const trace_state* trace, pli_vec3 start, pli_vec3 end) {
    const float reach = SWEPT_SAME_RAY * pli_vec3_length(pli_vec3_sub(end, start));
    return trace->has_ray && pli_vec3_length(pli_vec3_sub(start, trace->ray[0])) <= reach &&
           pli_vec3_length(pli_vec3_sub(end, trace->ray[1])) <= reach;
}

/* Blades that pass the body by are not worth a copy of it. */
static bool swept_may_meet(const pli_body* body, const pli_vec3* corners) {
    return plii_bounds_overlap(plii_bounds_of_triangle(corners[0], corners[1], corners[2]), body->bounds);
}

/* `corners` of two triangles. */
static pli_status swept_cut_all(plii_swept_work* work, const pli_vec3 (*corners)[3]) {
    const pli_body* body = work->edit.body;
    for (int i = 0; i < 2; ++i) {
        if (swept_may_meet(body, corners[i])) { PLII_TRY(plii_swept_cut(work, corners[i])); }
    }
    plii_edit* edit = &work->edit;
    edit->is_unchanged = edit->node_count == edit->old_node_count && edit->link_count == edit->old_link_count;
    return PLI_OK;
}

/* Cuts and leaves the ends of the cut in `trace`. */
static pli_status swept_run(pli_body* body, trace_state* trace, const pli_vec3 (*corners)[3], bool goes_on,
                            const char* function, int* parted) {
    plii_swept_work work = {.parted = 0};
    PLII_TRY(plii_edit_open(body, function, &work.edit));
    const bool is_ready = !goes_on || trace_copy_ends(body->context, &trace->ends, &work.ends);
    const pli_status status =
        plii_edit_end(&work.edit, is_ready ? swept_cut_all(&work, corners) : PLI_ERROR_OUT_OF_MEMORY);
    if (status == PLI_OK) {
        *parted = work.parted;
        const plii_swept_ends old = trace->ends;
        trace->ends = work.ends;
        work.ends = old;
    }
    PLII_RELEASE(body->context, work.ends.tips, work.ends.tip_capacity);
    PLII_RELEASE(body->context, work.ends.edges, work.ends.edge_capacity);
    return status;
}

pli_status pli_body_cut_swept(pli_body* body, pli_vec3 from_start, pli_vec3 from_end, pli_vec3 to_start,
                              pli_vec3 to_end, int* parted) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_vec3 ends[4] = {from_start, from_end, to_start, to_end};
    PLII_TRY(plii_check_finite_points(body->context, 4, ends, "end", __func__));
    const bool was_enabled = plii_feature_state(body, &plii_trace_class) != NULL;
    PLII_TRY_ENABLE(body, trace_state, trace, plii_trace_class);
    const bool goes_on = trace_ends_at(trace, from_start, from_end);
    const pli_vec3 corners[2][3] = {{from_start, from_end, to_end}, {from_start, to_end, to_start}};
    int count = 0;
    if (swept_may_meet(body, corners[0]) || swept_may_meet(body, corners[1])) {
        const pli_status status = swept_run(body, trace, corners, goes_on, __func__, &count);
        if (status != PLI_OK) {
            if (!was_enabled) { plii_feature_disable(body, &plii_trace_class); }
            return status;
        }
    } else if (!goes_on) {
        trace_forget(body, trace);
    }
    trace->has_ray = true;
    trace->ray[0] = to_start;
    trace->ray[1] = to_end;
    if (parted != NULL) { *parted = count; }
    return plii_body_changed(body, PLI_OK);
}
