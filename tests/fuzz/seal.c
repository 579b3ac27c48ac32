#include "seal.h"

#include "short_steps.h"

void seal_world_file(unsigned char* bytes, size_t size) {
    if (size >= PLII_FILE_HEADER_SIZE) { file_seal(bytes, size); }
}

bool world_has_short_steps(const pli_world* world) {
    for (int i = 0; i < pli_world_body_count(world); ++i) {
        if (!has_short_steps(pli_world_get_body(world, i))) { return false; }
    }
    return true;
}
