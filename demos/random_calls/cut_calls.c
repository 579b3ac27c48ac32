/* Cuts and refinement. */

#include "calls.h"

void calls_cut(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    pli_body* body = chosen->body;
    calls_context* home = chosen->world->home;
    const pli_body_view view = pli_body_get_view(body);
    if (view.node_count > CALLS_MOST_NODES) { return; }
    pli_status status = PLI_ERROR_WRONG_STATE;
    const int kind = bytes_below(&c->bytes, 4);
    if (kind == 0) {
        pli_refine_def def = pli_refine_def_default();
        def.surface = calls_surface;
        def.user = c;
        c->whim = (uint32_t)bytes_next(&c->bytes);
        if (bytes_seldom(&c->bytes, 64)) { def.accuracy = bytes_float(&c->bytes, 1e-4f, 0.1f); }
        def.cut = bytes_below(&c->bytes, 4) > 0;
        def.reset_rest_lengths = bytes_flag(&c->bytes);
        status = CALL(c, home, pli_body_refine(body, &def));
    } else if (kind == 1) {
        const int link = bytes_next(&c->bytes);
        int a = bytes_index(&c->bytes, view.node_count), b = bytes_index(&c->bytes, view.node_count);
        if (link < 250 && view.link_count > 0) {
            const int* nodes = view.link_nodes + (ptrdiff_t)(link % view.link_count) * view.link_node_stride;
            a = nodes[0];
            b = nodes[1];
        }
        status = CALL(c, home, pli_body_cut_link(body, a, b, bytes_float(&c->bytes, 0.1f, 0.9f)));
    } else if (kind == 2) {
        int torn = 0;
        status =
            CALL(c, home,
                 pli_body_tear(body, bytes_float(&c->bytes, 0.01f, 1.0f), 1 + bytes_small(&c->bytes, 0, 15), &torn));
    } else {
        int parted = 0;
        const pli_vec3 from = bytes_vec3(&c->bytes, -2.0f, 2.0f), to = bytes_vec3(&c->bytes, -2.0f, 2.0f);
        const pli_vec3 way = bytes_vec3(&c->bytes, -1.0f, 1.0f);
        status =
            CALL(c, home, pli_body_cut_swept(body, from, to, pli_vec3_add(from, way), pli_vec3_add(to, way), &parted));
    }
    c->report->cuts += status == PLI_OK;
}
