/* The reader of TetGen files. An input is the .node file, a zero byte, the .ele file and, if a further zero byte
   follows, the .face file. */

#include "entry.h"
#include "input_file.h"

#include <pliant/io.h>

#include <string.h>

static pli_context* context;

/* The end of a file that starts at `data`. */
static const uint8_t* file_end(const uint8_t* data, const uint8_t* end) {
    const uint8_t* found = data < end ? memchr(data, 0, (size_t)(end - data)) : NULL;
    return found != NULL ? found : end;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const char base[] = "t";
    if (context == NULL && pli_context_create(NULL, &context) != PLI_OK) { return 0; }
    const char* const paths[3] = {input_path("t.node"), input_path("t.ele"), input_path("t.face")};
    static const uint8_t nothing[1] = {0};
    const uint8_t* at = size > 0 ? data : nothing;
    const uint8_t* const end = at + size;
    for (int i = 0; i < 3; ++i) {
        const uint8_t* const file = at <= end ? at : NULL;
        const uint8_t* const stop = file != NULL ? file_end(file, end) : NULL;
        input_write(paths[i], file, file != NULL ? (size_t)(stop - file) : 0);
        at = stop != NULL && stop < end ? stop + 1 : end + 1;
    }
    char path[256];
    const size_t length = strlen(paths[0]) - strlen("t.node");
    memcpy(path, paths[0], length);
    memcpy(path + length, base, sizeof base);
    pli_mesh* mesh = NULL;
    const pli_status status = pli_mesh_read_tetgen(context, path, &mesh);
    if (status == PLI_OK) { pli_mesh_destroy(mesh); }
    input_check(context, status);
    return 0;
}
