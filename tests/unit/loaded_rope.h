#ifndef TESTS_UNIT_LOADED_ROPE_H
#define TESTS_UNIT_LOADED_ROPE_H

/* A rope with a load. */

#include "solver_choice.h"

enum { ROPE_END = 19 }; /* its last node */

/* 2 m and 1 kg that hang from a pin, and a dynamic rigid body of 5 kg, which the caller moves, on an anchor at the end.
 */
static inline pli_body* make_loaded_rope(pli_solver_settings settings, solver_choice solver, pli_rigid** load) {
    pli_mesh* mesh = NULL;
    const pli_vec3 top = pli_vec3_make(0, 0, 0), end = pli_vec3_make(0, -2, 0);
    assert_int_equal(pli_mesh_create_rope(context, top, end, 18, PLI_ROPE_PIN_FIRST, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 1), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver = settings;
    pli_body* rope = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    use_solver(rope, solver);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.pose.origin = end;
    def.state.inverse_mass = 0.2f;
    def.state.inverse_inertia_world = (pli_mat3){{{10, 0, 0}, {0, 10, 0}, {0, 0, 10}}};
    assert_int_equal(pli_rigid_create(world, &def, load), PLI_OK);
    const int end_node = ROPE_END;
    assert_int_equal(pli_body_attach_nodes(rope, &end_node, 1, *load), PLI_OK);
    return rope;
}

#endif
