#ifndef TESTS_UNIT_SOLVER_CHOICE_H
#define TESTS_UNIT_SOLVER_CHOICE_H

/* The solvers that what holds nodes is tried under. */

#include "test_world.h"

typedef enum solver_choice { POSITION, COLORS, SWEEPS, GRADIENTS, XPBD, SOLVER_COUNT } solver_choice;

static inline void use_solver(pli_body* body, solver_choice which) {
    if (which == COLORS) { assert_int_equal(pli_body_enable_colored_links(body), PLI_OK); }
    if (which == XPBD) {
        assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK);
        const pli_xpbd_links_def links = pli_xpbd_links_def_default();
        assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
    }
    if (which == SWEEPS || which == GRADIENTS) {
        pli_implicit_def def = pli_implicit_def_default();
        if (which == GRADIENTS) { def.method = PLI_IMPLICIT_CONJUGATE_GRADIENT; }
        assert_int_equal(pli_body_enable_implicit(body, &def), PLI_OK);
    }
}

#endif
