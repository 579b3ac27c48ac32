/* The implicit and the XPBD solver, and the constraints of the latter. */

#include "calls.h"

#define TRY(call) CALL(c, home, call)

static void enable_implicit(calls* c, pli_body* body, calls_context* home) {
    pli_implicit_def def = pli_implicit_def_default();
    def.stiffness = bytes_float(&c->bytes, 0.0f, 3000.0f);
    def.damping = bytes_float(&c->bytes, 0.0f, 2.0f);
    def.sweeps = bytes_small(&c->bytes, 1, 7);
    def.method = (pli_implicit_method)bytes_small(&c->bytes, 0, 2);
    def.start = (pli_implicit_start)bytes_small(&c->bytes, 0, 1);
    if (bytes_seldom(&c->bytes, 64)) { def.tolerance = bytes_float(&c->bytes, 0.0001f, 0.5f); }
    def.filter_compression = bytes_flag(&c->bytes);
    TRY(pli_body_enable_implicit(body, &def));
}

static void enable_links(calls* c, pli_body* body, calls_context* home) {
    pli_xpbd_links_def def = pli_xpbd_links_def_default();
    if (bytes_flag(&c->bytes)) {
        def.compliance = bytes_float(&c->bytes, 0.0f, 0.01f);
        def.bending_compliance = bytes_float(&c->bytes, 0.0f, 0.1f);
        def.damping = bytes_float(&c->bytes, 0.0f, 1.0f);
    }
    TRY(pli_body_enable_xpbd_links(body, &def));
}

static void enable_bending(calls* c, pli_body* body, calls_context* home) {
    pli_xpbd_bending_def def = pli_xpbd_bending_def_default();
    def.compliance = bytes_float(&c->bytes, 0.0f, 0.1f);
    def.damping = bytes_float(&c->bytes, 0.0f, 1.0f);
    def.is_flat = bytes_flag(&c->bytes);
    TRY(pli_body_enable_xpbd_bending(body, &def));
}

static void disable_constraint(calls* c, pli_body* body, calls_context* home) {
    switch (bytes_below(&c->bytes, 4)) {
    case 0:
        TRY(pli_body_disable_xpbd_links(body));
        break;
    case 1:
        TRY(pli_body_disable_xpbd_bending(body));
        break;
    case 2:
        TRY(pli_body_disable_xpbd_tetras(body));
        break;
    default:
        TRY(pli_body_disable_xpbd_volume(body));
        break;
    }
}

static void change_xpbd(calls* c, pli_body* body, calls_context* home) {
    pli_xpbd_def def = pli_xpbd_def_default();
    def.substeps = bytes_small(&c->bytes, 1, 4);
    def.sweeps = bytes_small(&c->bytes, 1, 2);
    TRY(pli_body_enable_xpbd(body, &def));
    const int chosen = bytes_next(&c->bytes); /* several at once, lest it take many calls to get anywhere */
    if ((chosen & 1) != 0) { enable_links(c, body, home); }
    if ((chosen & 2) != 0) { enable_bending(c, body, home); }
    if ((chosen & 4) != 0) { TRY(pli_body_enable_xpbd_tetras(body, bytes_float(&c->bytes, 0.0f, 0.01f))); }
    if ((chosen & 8) != 0) {
        pli_xpbd_volume_def volume = pli_xpbd_volume_def_default();
        volume.compliance = bytes_float(&c->bytes, 0.0f, 0.01f);
        volume.pressure_ratio = bytes_float(&c->bytes, 0.0f, 2.0f);
        TRY(pli_body_enable_xpbd_volume(body, &volume));
    }
}

void calls_change_solver(calls* c) {
    calls_body* chosen = calls_any_body(c);
    if (chosen == NULL) { return; }
    calls_context* home = chosen->world->home;
    const int kind = bytes_below(&c->bytes, 16);
    if (kind < 5) { enable_implicit(c, chosen->body, home); }
    if (kind == 5 || kind == 6) { TRY(pli_body_disable_implicit(chosen->body)); }
    if (kind >= 7 && kind < 13) { change_xpbd(c, chosen->body, home); }
    if (kind == 13) { disable_constraint(c, chosen->body, home); }
    if (kind >= 14) { TRY(pli_body_disable_xpbd(chosen->body)); }
}
