#ifndef TESTS_UNIT_HANGING_CAPE_H
#define TESTS_UNIT_HANGING_CAPE_H

/* A cape. */

#include "solver_choice.h"

static const float dt = 1.0f / 60.0f;

enum { COLUMNS = 40, ROWS = 25 };

/* A sheet of 1.2 m by 0.7 m and 0.5 kg, hanging down; its first row of COLUMNS is to be held. */
static inline pli_body* make_cape(int rows) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-0.6f, 0, 0);
    def.corner_10 = pli_vec3_make(0.6f, 0, 0);
    def.corner_01 = pli_vec3_make(-0.6f, -0.7f, 0);
    def.corner_11 = pli_vec3_make(0.6f, -0.7f, 0);
    def.columns = COLUMNS;
    def.rows = rows;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 8;
    body_def.solver.velocity_damping = 0.01f;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static inline pli_vec3 xyz(pli_vec4 v) {
    return pli_vec3_make(v.x, v.y, v.z);
}

static inline float distance(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_length(pli_vec3_sub(a, b));
}

/* Of all tethers, as a share of their length. */
static inline float longest_tether(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float most = 0;
    for (int i = COLUMNS; i < view.node_count; ++i) {
        const pli_tether t = pli_body_get_tether(body, i);
        most = fmaxf(most, distance(xyz(view.positions[i]), xyz(view.positions[t.origin])) / t.length - 1);
    }
    return most;
}

#endif
