/* Rectangular sheets, with alternating diagonals or with texture coordinates and diagonals in one direction, in the
   operation order of btSoftBodyHelpers::CreatePatch and CreatePatchUV. */

#include "math/definition.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

PLII_DEFINE_DEFAULT(pli_patch_def, .corner_00 = {-1, 0, -1}, .corner_10 = {1, 0, -1}, .corner_01 = {-1, 0, 1},
                    .corner_11 = {1, 0, 1}, .columns = 16, .rows = 16, .diagonals = true)

static const plii_field patch_fields[] = {
    PLII_FIELD(pli_patch_def, corner_00, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE),
    PLII_FIELD(pli_patch_def, corner_10, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE),
    PLII_FIELD(pli_patch_def, corner_01, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE),
    PLII_FIELD(pli_patch_def, corner_11, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE),
    PLII_FIELD(pli_patch_def, columns, 2, 1 << 30),
    PLII_FIELD(pli_patch_def, rows, 2, 1 << 30),
};

static int patch_node(const pli_patch_def* def, int x, int y) {
    return y * def->columns + x;
}

/* A mesh with the nodes of the patch, pinned by the bits that the generator knows, and room for links and faces. */
static pli_status patch_begin(pli_context* context, const pli_patch_def* def, int allowed_pins, const char* function,
                              pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", function));
    PLII_TRY_DEF(context, pli_patch_def, def, patch_fields, function);
    PLII_FAIL_IF((def->pins & ~allowed_pins) != 0, context, PLI_ERROR_INVALID_VALUE, function,
                 "the pins 0x%x name nodes that this patch does not pin", (unsigned)(def->pins & ~allowed_pins));
    const int64_t columns = def->columns, rows = def->rows;
    const int64_t cells = (columns - 1) * (rows - 1);
    const int64_t links = columns * (rows - 1) + rows * (columns - 1) + (def->diagonals ? cells : 0);
    PLII_TRY(plii_mesh_create_reserved(context, columns * rows, links, 2 * cells, 0, function, mesh));
    pli_mesh* made = *mesh;
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
    } pins[] = {
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
    for (size_t i = 0; i < sizeof pins / sizeof *pins; ++i) {
        if ((def->pins & pins[i].pin) != 0) { made->inverse_masses[patch_node(def, pins[i].x, pins[i].y)] = 0.0f; }
    }
    return PLI_OK;
}

/* Two faces and, if asked, the link on their common edge. The diagonal runs from (x, y), but of even cells where it
   alternates. */
static void patch_push_cell(pli_mesh* mesh, const pli_patch_def* def, int x, int y, bool alternates) {
    const int n00 = patch_node(def, x, y), n10 = n00 + 1, n01 = n00 + def->columns, n11 = n01 + 1;
    const bool is_even = alternates && ((x + y) & 1) == 0;
    if (is_even) {
        plii_mesh_push_face(mesh, n01, n00, n10);
        plii_mesh_push_face(mesh, n01, n10, n11);
    } else if (alternates) {
        plii_mesh_push_face(mesh, n00, n10, n11);
        plii_mesh_push_face(mesh, n00, n11, n01);
    } else {
        plii_mesh_push_face(mesh, n00, n01, n11);
        plii_mesh_push_face(mesh, n11, n10, n00);
    }
    if (def->diagonals) { plii_mesh_push_link(mesh, is_even ? n10 : n00, is_even ? n01 : n11); }
}

static void patch_push_cells(pli_mesh* mesh, const pli_patch_def* def, bool alternates) {
    for (int y = 0; y < def->rows; ++y) {
        for (int x = 0; x < def->columns; ++x) {
            const int node = patch_node(def, x, y);
            const bool has_right = x + 1 < def->columns, has_up = y + 1 < def->rows;
            if (has_right) { plii_mesh_push_link(mesh, node, node + 1); }
            if (has_up) { plii_mesh_push_link(mesh, node, node + def->columns); }
            if (has_right && has_up) { patch_push_cell(mesh, def, x, y, alternates); }
        }
    }
}

pli_status pli_mesh_create_patch(pli_context* context, const pli_patch_def* def, pli_mesh** mesh) {
    PLII_TRY(patch_begin(context, def, PLI_PATCH_PIN_CORNERS, __func__, mesh));
    patch_push_cells(*mesh, def, true);
    return PLI_OK;
}

/* u, v of the corners of the two faces of each cell. Texture rows run against mesh rows. */
static void patch_set_texture(const pli_patch_def* def, float* uv) {
    const float column = 1.0f / (float)(def->columns - 1), row = 1.0f / (float)(def->rows - 1);
    for (int y = 0; y + 1 < def->rows; ++y) {
        for (int x = 0; x + 1 < def->columns; ++x, uv += 12) {
            const float left = column * (float)x, right = column * (float)(x + 1);
            const float top = row * (float)(def->rows - 1 - y), bottom = row * (float)(def->rows - 2 - y);
            const float corners[12] = {left, top, left, bottom, right, bottom, right, bottom, right, top, left, top};
            memcpy(uv, corners, sizeof corners);
        }
    }
}

pli_status pli_mesh_create_patch_uv(pli_context* context, const pli_patch_def* def, float* texture_coordinates,
                                    pli_mesh** mesh) {
    const int all_pins = PLI_PATCH_PIN_CORNERS | PLI_PATCH_PIN_MID_BOTTOM | PLI_PATCH_PIN_MID_LEFT |
                         PLI_PATCH_PIN_MID_RIGHT | PLI_PATCH_PIN_MID_TOP | PLI_PATCH_PIN_CENTER;
    PLII_TRY(patch_begin(context, def, all_pins, __func__, mesh));
    patch_push_cells(*mesh, def, false);
    if (texture_coordinates != NULL) { patch_set_texture(def, texture_coordinates); }
    return PLI_OK;
}
