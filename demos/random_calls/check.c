/* The checks after each call. */

#include "calls.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void calls_finding(calls* c, const char* format, ...) {
    if (calls_have_finding(c)) { return; }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->report->finding, sizeof c->report->finding, format, arguments);
    va_end(arguments);
}

bool calls_have_finding(const calls* c) {
    return c->report->finding[0] != '\0';
}

// ----------------------------------------------------------------------------------------------------- digest

static uint64_t digest_word(uint64_t digest, uint64_t word) {
    digest = (digest ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return digest ^ digest >> 29;
}

static uint64_t digest_bytes(uint64_t digest, const void* data, size_t size) {
    const char* at = data;
    for (; size >= sizeof(uint64_t); size -= sizeof(uint64_t), at += sizeof(uint64_t)) {
        uint64_t word;
        memcpy(&word, at, sizeof word);
        digest = digest_word(digest, word);
    }
    uint64_t rest = 0;
    if (size > 0) { memcpy(&rest, at, size); }
    return digest_word(digest, rest);
}

/* No bit pattern of an infinite value or NaN among floats that lie one behind the other. */
static bool all_finite(const void* floats, size_t count) {
    const char* at = floats;
    bool are_finite = true;
    for (size_t i = 0; i < count; ++i, at += sizeof(float)) {
        uint32_t bits;
        memcpy(&bits, at, sizeof bits);
        are_finite = are_finite && (bits & 0x7f800000u) != 0x7f800000u;
    }
    return are_finite;
}

static uint64_t digest_body(calls* c, uint64_t digest, const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    const size_t count = (size_t)view.node_count;
    if (!all_finite(view.positions, 4 * count) || !all_finite(view.previous, 4 * count) ||
        !all_finite(view.velocities, 4 * count)) {
        calls_finding(c, "a body is not finite");
    }
    for (size_t i = 0; i < count; ++i) {
        if (view.positions[i].w < 0.0f) { calls_finding(c, "node %d has a negative mass", (int)i); }
    }
    const int counts[] = {view.node_count,
                          view.link_count,
                          view.face_count,
                          view.tetra_count,
                          pli_body_anchor_count(body),
                          pli_body_joint_count(body),
                          pli_body_cluster_count(body),
                          pli_body_is_frozen(body)};
    digest = digest_bytes(digest, counts, sizeof counts);
    digest = digest_bytes(digest, view.positions, count * sizeof *view.positions);
    digest = digest_bytes(digest, view.previous, count * sizeof *view.previous);
    digest = digest_bytes(digest, view.velocities, count * sizeof *view.velocities);
    for (int i = 0; i < view.link_count; ++i) {
        const int* nodes = view.link_nodes + (ptrdiff_t)i * view.link_node_stride;
        digest = digest_word(digest, (uint64_t)nodes[0] << 32 | (uint64_t)nodes[1]);
    }
    digest = digest_bytes(digest, view.face_nodes, (size_t)view.face_count * 3 * sizeof(int));
    const pli_solver_settings settings = pli_body_get_solver_settings(body);
    digest = digest_bytes(digest, &settings, sizeof settings);
    const float margin = pli_body_get_collision_margin(body);
    digest = digest_bytes(digest, &margin, sizeof margin);
    pli_feature_cost features[48];
    const int feature_count = pli_body_get_features(body, 48, features);
    for (int i = 0; i < feature_count && i < 48; ++i) {
        if (!features[i].is_needed) { digest = digest_bytes(digest, features[i].name, strlen(features[i].name)); }
    }
    return digest;
}

static uint64_t digest_rigid(calls* c, uint64_t digest, const pli_rigid* rigid) {
    const pli_rigid_state state = pli_rigid_get_state(rigid);
    const float moving[6] = {state.linear_velocity.x,  state.linear_velocity.y,  state.linear_velocity.z,
                             state.angular_velocity.x, state.angular_velocity.y, state.angular_velocity.z};
    if (!all_finite(&state.pose, 12) || !all_finite(moving, 6)) { calls_finding(c, "a rigid body is not finite"); }
    digest = digest_bytes(digest, &state.pose, sizeof state.pose);
    digest = digest_bytes(digest, moving, sizeof moving);
    return digest_word(digest, (uint64_t)pli_rigid_get_kind(rigid));
}

static uint64_t digest_mesh(calls* c, uint64_t digest, const pli_mesh* mesh) {
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    const size_t count = (size_t)view.node_count;
    if (!all_finite(view.positions, 3 * count) || !all_finite(view.inverse_masses, count)) {
        calls_finding(c, "a mesh is not finite");
    }
    const int counts[] = {view.node_count, view.link_count, view.face_count, view.tetra_count, view.material_count};
    digest = digest_bytes(digest, counts, sizeof counts);
    digest = digest_bytes(digest, view.positions, count * sizeof *view.positions);
    digest = digest_bytes(digest, view.inverse_masses, count * sizeof *view.inverse_masses);
    for (int i = 0; i < view.link_count; ++i) {
        digest = digest_word(digest, (uint64_t)view.links[i].nodes[0] << 32 | (uint64_t)view.links[i].nodes[1]);
    }
    return digest_bytes(digest, view.faces, (size_t)view.face_count * sizeof *view.faces);
}

uint64_t calls_digest(calls* c) {
    uint64_t digest = 1;
    for (int i = 0; i < CALLS_MESHES; ++i) {
        if (c->meshes[i].mesh != NULL) { digest = digest_mesh(c, digest, c->meshes[i].mesh); }
    }
    for (int i = 0; i < CALLS_BODIES; ++i) {
        if (c->bodies[i].body != NULL) { digest = digest_body(c, digest, c->bodies[i].body); }
    }
    for (int i = 0; i < CALLS_RIGIDS; ++i) {
        if (c->rigids[i].rigid != NULL) { digest = digest_rigid(c, digest, c->rigids[i].rigid); }
    }
    for (int i = 0; i < CALLS_WORLDS; ++i) {
        if (c->worlds[i].world != NULL) {
            digest = digest_word(digest, (uint64_t)pli_world_body_count(c->worlds[i].world));
            digest = digest_word(digest, pli_world_is_stepping(c->worlds[i].world));
        }
    }
    return digest;
}

// ------------------------------------------------------------------------------------------------------ calls

static bool is_known(pli_status status) {
    switch (status) {
#define CALLS_KNOWN(name, value, text) case name:
        PLI_STATUS_LIST(CALLS_KNOWN)
#undef CALLS_KNOWN
        return true;
    }
    return false;
}

void calls_begin(calls* c, calls_context* home) {
    c->active = home;
    if (home != NULL) { home->errors = 0; }
}

static pli_status check_call(calls* c, calls_context* home, const char* call, pli_status status, bool may_change) {
    c->active = NULL;
    ++c->call_count;
    ++c->report->calls;
    const int length = (int)strcspn(call, "(");
    const uint64_t digest = calls_digest(c);
    if ((c->kinds & RANDOM_CALLS_TRACE) != 0) {
        fprintf(stderr, "%3d %.*s: %s\n", c->call_count, length, call,
                status == PLI_OK ? "ok"
                : home != NULL   ? pli_last_error(home->context)
                                 : pli_status_string(status));
    }
    if (!is_known(status)) { calls_finding(c, "%.*s: unknown status %d", length, call, (int)status); }
    if (status != PLI_OK) {
        ++c->report->refused;
        if (digest != c->digest && !may_change) {
            calls_finding(c, "%.*s: refused (%s), and something has changed", length, call, pli_status_string(status));
        }
        const char* message = home != NULL ? pli_last_error(home->context) : "-";
        if (home != NULL && (home->errors == 0 || message[0] == '\0')) {
            calls_finding(c, "%.*s: refused (%s) without a message", length, call, pli_status_string(status));
        }
    }
    if (calls_have_finding(c) && strstr(c->report->finding, " after ") == NULL) {
        const size_t used = strlen(c->report->finding);
        snprintf(c->report->finding + used, sizeof c->report->finding - used, ", after call %d, %.*s", c->call_count,
                 length, call);
    }
    c->digest = digest;
    c->report->digest = digest_word(c->report->digest, digest ^ (uint64_t)status);
    return status;
}

pli_status calls_end(calls* c, calls_context* home, const char* call, pli_status status) {
    return check_call(c, home, call, status, false);
}

pli_status calls_end_of_step(calls* c, calls_context* home, const char* call, pli_status status) {
    return check_call(c, home, call, status, status == PLI_ERROR_OUT_OF_MEMORY);
}
