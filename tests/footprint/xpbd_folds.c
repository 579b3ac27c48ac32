/* A sheet with hashed self-collision under XPBD: those modules and what they need, neither grids nor faces. */

#include <pliant/generate.h>
#include <pliant/self_collision.h>
#include <pliant/world.h>
#include <pliant/xpbd.h>

int main(void) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    const pli_patch_def patch = pli_patch_def_default();
    const pli_self_collision_def def = pli_self_collision_def_default();
    const pli_xpbd_def solver = pli_xpbd_def_default();
    const pli_xpbd_links_def links = pli_xpbd_links_def_default();
    const bool is_ok =
        pli_context_create(NULL, &context) == PLI_OK && pli_world_create(context, NULL, &world) == PLI_OK &&
        pli_mesh_create_patch(context, &patch, &mesh) == PLI_OK &&
        pli_body_create(world, mesh, NULL, &body) == PLI_OK && pli_body_enable_self_collision(body, &def) == PLI_OK &&
        pli_body_enable_xpbd(body, &solver) == PLI_OK && pli_body_enable_xpbd_links(body, &links) == PLI_OK &&
        pli_world_step(world, 1.0f / 60.0f) == PLI_OK;
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
    return is_ok ? 0 : 1;
}
