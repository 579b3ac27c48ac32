#ifndef DEMOS_BULLET_MEMORY_H
#define DEMOS_BULLET_MEMORY_H

// What Bullet takes from its allocator.

#include <cstdint>

namespace demos {

struct BulletMemory {
    int64_t live_bytes = 0; // as asked for
    uint64_t allocations = 0;
};

// To be called before Bullet allocates anything, for memory of before could not be released.
void count_bullet_memory();
// Zero until then.
BulletMemory bullet_memory();

} // namespace demos
#endif
