/* The reader of OBJ files, and meshes out of what it reads. */

#include "entry.h"
#include "input_file.h"

#include <pliant/io.h>

static pli_context* context;

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (context == NULL && pli_context_create(NULL, &context) != PLI_OK) { return 0; }
    const char* path = input_path("a.obj");
    input_write(path, data, size);
    pli_mesh* mesh = NULL;
    const pli_status status = pli_mesh_read_obj(context, path, &mesh);
    if (status == PLI_OK) { pli_mesh_destroy(mesh); }
    input_check(context, status);
    return 0;
}
