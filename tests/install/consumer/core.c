/* Makes a context, which proves that the headers are found and the library links and loads. */

#include <pliant/pliant.h>

int main(void) {
    pli_context* context;
    const pli_status status = pli_context_create(0, &context);
    pli_context_destroy(context);
    return status == PLI_OK && pli_vec3_length(pli_vec3_make(0, 3, 4)) == 5 ? 0 : 1;
}
