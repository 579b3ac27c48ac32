/* A rope that hangs from one end: stepped by XPBD with links and no other constraints. */

#include <pliant/generate.h>
#include <pliant/world.h>
#include <pliant/xpbd.h>

int main(void) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    const pli_world_def def = pli_world_def_default();
    const pli_xpbd_def solver = pli_xpbd_def_default();
    const pli_xpbd_links_def links = pli_xpbd_links_def_default();
    const bool is_ok =
        pli_context_create(NULL, &context) == PLI_OK && pli_world_create(context, &def, &world) == PLI_OK &&
        pli_mesh_create_rope(context, pli_vec3_make(0, 5, 0), pli_vec3_make(5, 5, 0), 8, PLI_ROPE_PIN_FIRST, &mesh) ==
            PLI_OK &&
        pli_body_create(world, mesh, NULL, &body) == PLI_OK && pli_body_enable_xpbd(body, &solver) == PLI_OK &&
        pli_body_enable_xpbd_links(body, &links) == PLI_OK && pli_world_step(world, 1.0f / 60.0f) == PLI_OK;
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
    return is_ok ? 0 : 1;
}
