/* A rectangular sheet with texture coordinates and diagonals in one direction, in the operation order of
   btSoftBodyHelpers::CreatePatchUV. */

#include "mesh/gen_patch_impl.h"

/* u, v of the corners of the two faces of cell (x, y). Texture rows run against mesh rows. */
static void patch_uv_set_cell(float* uv, const pli_patch_def* def, int x, int y) {
    const float column = 1.0f / (float)(def->columns - 1), row = 1.0f / (float)(def->rows - 1);
    const float left = column * (float)x, right = column * (float)(x + 1);
    const float top = row * (float)(def->rows - 1 - y), bottom = row * (float)(def->rows - 2 - y);
    const float corners[12] = {left, top, left, bottom, right, bottom, right, bottom, right, top, left, top};
    for (int i = 0; i < 12; ++i) {
        uv[i] = corners[i];
    }
}

pli_status pli_mesh_create_patch_uv(pli_context* context, const pli_patch_def* def, float* texture_coordinates,
                                    pli_mesh** mesh) {
    PLII_TRY(plii_check_context_change(context, __func__));
    if (mesh == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the place for the mesh is null"); }
    const int all_pins = PLI_PATCH_PIN_CORNERS | PLI_PATCH_PIN_MID_BOTTOM | PLI_PATCH_PIN_MID_LEFT |
                         PLI_PATCH_PIN_MID_RIGHT | PLI_PATCH_PIN_MID_TOP | PLI_PATCH_PIN_CENTER;
    pli_mesh* made = NULL;
    PLII_TRY(plii_patch_begin(context, def, all_pins, __func__, &made));
    float* uv = texture_coordinates;
    for (int y = 0; y < def->rows; ++y) {
        for (int x = 0; x < def->columns; ++x) {
            const int node = plii_patch_node(def, x, y), above = node + def->columns;
            const bool has_right = x + 1 < def->columns, has_up = y + 1 < def->rows;
            if (has_right) { plii_mesh_push_link(made, node, node + 1); }
            if (has_up) { plii_mesh_push_link(made, node, above); }
            if (!has_right || !has_up) { continue; }
            plii_mesh_push_face(made, node, above, above + 1);
            plii_mesh_push_face(made, above + 1, node + 1, node);
            if (def->diagonals) { plii_mesh_push_link(made, node, above + 1); }
            if (uv != NULL) {
                patch_uv_set_cell(uv, def, x, y);
                uv += 12;
            }
        }
    }
    *mesh = made;
    return PLI_OK;
}
