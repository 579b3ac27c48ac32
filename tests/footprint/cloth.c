/* Cloth that falls on the ground, and nothing else: the check of linked modules looks at this program. */

#include <pliant/contact.h>
#include <pliant/generate.h>
#include <pliant/world.h>

int main(void) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* cloth = NULL;
    pli_shape* ground = NULL;
    pli_rigid* rigid = NULL;
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-1, 1, -1);
    patch.corner_10 = pli_vec3_make(1, 1, -1);
    patch.corner_01 = pli_vec3_make(-1, 1, 1);
    patch.corner_11 = pli_vec3_make(1, 1, 1);
    patch.columns = patch.rows = 10;
    patch.diagonals = true;
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    pli_rigid_def rigid_def = pli_rigid_def_default();
    rigid_def.shape_count = 1;
    rigid_def.shapes = &ground;
    const bool is_ok =
        pli_context_create(NULL, &context) == PLI_OK && pli_world_create(context, NULL, &world) == PLI_OK &&
        pli_mesh_create_patch(context, &patch, &mesh) == PLI_OK &&
        pli_body_create(world, mesh, NULL, &cloth) == PLI_OK &&
        pli_body_enable_rigid_contacts(cloth, &contacts) == PLI_OK &&
        pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &ground) == PLI_OK &&
        pli_rigid_create(world, &rigid_def, &rigid) == PLI_OK && pli_world_step(world, 1.0f / 60.0f) == PLI_OK;
    pli_shape_release(ground);
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
    return is_ok ? 0 : 1;
}
