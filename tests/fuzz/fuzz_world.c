/* The reader of files of worlds, and steps of what it makes of one file in eight, which take much longer than to read
   it. The header is made to fit: else nothing but its check would be reached. */

#include "entry.h"

#include "short_steps.h"

#include <stdlib.h>
#include <string.h>

static pli_context* context;

/* By all bytes: other inputs around one that takes no steps do. */
static bool takes_steps(const uint8_t* data, size_t size) {
    unsigned sum = 0;
    for (size_t i = 0; i < size; ++i) {
        sum += data[i];
    }
    return sum % 8 == 0;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (context == NULL && pli_context_create(NULL, &context) != PLI_OK) { return 0; }
    const size_t bytes = pli_context_allocated_bytes(context);
    unsigned char* file = malloc(size + 1);
    if (file == NULL) { return 0; }
    memcpy(file, data, size);
    if (size >= PLII_FILE_HEADER_SIZE) { file_seal(file, size); }
    pli_world* world = NULL;
    if (pli_world_file_create(context, NULL, file, size, &world) == PLI_OK) {
        bool is_short = takes_steps(data, size) && pli_world_body_count(world) <= 16;
        for (int i = 0; i < pli_world_body_count(world); ++i) {
            is_short = is_short && has_short_steps(pli_world_get_body(world, i));
        }
        for (int i = 0; i < 2 && is_short; ++i) {
            (void)pli_world_step(world, 1.0f / 60.0f);
        }
        pli_world_destroy(world);
    } else if (world != NULL || pli_last_error(context)[0] == '\0') {
        abort();
    }
    if (pli_context_allocated_bytes(context) != bytes) { abort(); }
    free(file);
    return 0;
}
