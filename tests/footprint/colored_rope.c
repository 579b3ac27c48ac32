/* A rope with coloured links: brings the kernels, and no other solver. */

#include <pliant/generate.h>
#include <pliant/world.h>

int main(void) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    const int failed = pli_context_create(NULL, &context) != PLI_OK ||
                       pli_world_create(context, NULL, &world) != PLI_OK ||
                       pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 20,
                                            PLI_ROPE_PIN_FIRST, &mesh) != PLI_OK ||
                       pli_body_create(world, mesh, NULL, &body) != PLI_OK ||
                       pli_body_enable_colored_links(body) != PLI_OK || pli_world_step(world, 1.0f / 60.0f) != PLI_OK;
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
    return failed;
}
