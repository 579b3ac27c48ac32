/* A rectangular sheet with alternating diagonals, in the operation order of btSoftBodyHelpers::CreatePatch. */

#include "math/definition.h"
#include "mesh/gen_patch_impl.h"

#include <limits.h>

pli_patch_def pli_patch_def_default(void) {
    return (pli_patch_def){
        .corner_00 = {-1, 0, -1},
        .corner_10 = {1, 0, -1},
        .corner_01 = {-1, 0, 1},
        .corner_11 = {1, 0, 1},
        .columns = 16,
        .rows = 16,
        .diagonals = true,
        .cookie = PLII_DEF_COOKIE,
    };
}

static pli_status patch_check(pli_context* context, const pli_patch_def* def, int allowed_pins, const char* function) {
    PLII_TRY(PLII_CHECK_MADE(context, pli_patch_def, def, function));
    const pli_vec3 corners[4] = {def->corner_00, def->corner_10, def->corner_01, def->corner_11};
    PLII_TRY(plii_check_finite_points(context, 4, corners, "point", function));
    if (def->columns < 2 || def->rows < 2) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function,
                         "a patch of %d x %d nodes, it must be 2 x 2 or more", def->columns, def->rows);
    }
    if ((int64_t)def->columns * def->rows > INT_MAX) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "a patch of %d x %d nodes is too large",
                         def->columns, def->rows);
    }
    if ((def->pins & ~allowed_pins) != 0) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function,
                         "the pins 0x%x name nodes that this patch does not pin",
                         (unsigned)(def->pins & ~allowed_pins));
    }
    return PLI_OK;
}

pli_status plii_patch_begin(pli_context* context, const pli_patch_def* def, int allowed_pins, const char* function,
                            pli_mesh** mesh) {
    PLII_TRY(patch_check(context, def, allowed_pins, function));
    const int64_t columns = def->columns, rows = def->rows;
    const int64_t cells = (columns - 1) * (rows - 1);
    const int64_t links = columns * (rows - 1) + rows * (columns - 1) + (def->diagonals ? cells : 0);
    pli_mesh* made = NULL;
    PLII_TRY(plii_mesh_create_reserved(context, columns * rows, links, 2 * cells, 0, function, &made));
    for (int y = 0; y < def->rows; ++y) {
        const float ty = (float)y / (float)(def->rows - 1);
        const pli_vec3 left = pli_vec3_lerp(def->corner_00, def->corner_01, ty);
        const pli_vec3 right = pli_vec3_lerp(def->corner_10, def->corner_11, ty);
        for (int x = 0; x < def->columns; ++x) {
            const float tx = (float)x / (float)(def->columns - 1);
            plii_mesh_push_node(made, plii_clamp_point(pli_vec3_lerp(left, right, tx)), 1.0f);
        }
    }
    const int right = def->columns - 1, top = def->rows - 1;
    const struct {
        int pin, x, y;
    } places[] = {
        {PLI_PATCH_PIN_00, 0, 0},
        {PLI_PATCH_PIN_10, right, 0},
        {PLI_PATCH_PIN_01, 0, top},
        {PLI_PATCH_PIN_11, right, top},
        {PLI_PATCH_PIN_MID_BOTTOM, right / 2, 0},
        {PLI_PATCH_PIN_MID_LEFT, 0, top / 2},
        {PLI_PATCH_PIN_MID_RIGHT, right, top / 2},
        {PLI_PATCH_PIN_MID_TOP, right / 2, top},
        {PLI_PATCH_PIN_CENTER, right / 2, top / 2},
    };
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        if ((def->pins & places[i].pin) != 0) {
            made->inverse_masses[plii_patch_node(def, places[i].x, places[i].y)] = 0.0f;
        }
    }
    *mesh = made;
    return PLI_OK;
}

/* Two faces and, if asked, the link on their common edge. The diagonal of odd cells runs from (x, y). */
static void patch_push_cell(pli_mesh* mesh, const pli_patch_def* def, int x, int y) {
    const int n00 = plii_patch_node(def, x, y), n10 = plii_patch_node(def, x + 1, y);
    const int n01 = plii_patch_node(def, x, y + 1), n11 = plii_patch_node(def, x + 1, y + 1);
    if (((x + y) & 1) != 0) {
        plii_mesh_push_face(mesh, n00, n10, n11);
        plii_mesh_push_face(mesh, n00, n11, n01);
        if (def->diagonals) { plii_mesh_push_link(mesh, n00, n11); }
    } else {
        plii_mesh_push_face(mesh, n01, n00, n10);
        plii_mesh_push_face(mesh, n01, n10, n11);
        if (def->diagonals) { plii_mesh_push_link(mesh, n10, n01); }
    }
}

pli_status pli_mesh_create_patch(pli_context* context, const pli_patch_def* def, pli_mesh** mesh) {
    PLII_TRY(plii_check_context_change(context, __func__));
    if (mesh == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the place for the mesh is null"); }
    pli_mesh* made = NULL;
    PLII_TRY(plii_patch_begin(context, def, PLI_PATCH_PIN_CORNERS, __func__, &made));
    for (int y = 0; y < def->rows; ++y) {
        for (int x = 0; x < def->columns; ++x) {
            const int node = plii_patch_node(def, x, y);
            const bool has_right = x + 1 < def->columns, has_up = y + 1 < def->rows;
            if (has_right) { plii_mesh_push_link(made, node, node + 1); }
            if (has_up) { plii_mesh_push_link(made, node, node + def->columns); }
            if (has_right && has_up) { patch_push_cell(made, def, x, y); }
        }
    }
    *mesh = made;
    return PLI_OK;
}
