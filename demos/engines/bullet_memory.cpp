// An allocator for Bullet that counts. Bullet has one for the whole process, so the counts are global too.

#include "bullet_memory.h"

#include <LinearMath/btAlignedAllocator.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>

namespace demos {

namespace {

std::atomic<int64_t> live_bytes{0};
std::atomic<uint64_t> allocations{0};

// Right before each block that is handed out.
struct Header {
    void* start;
    size_t size;
};

void* allocate(size_t size, int alignment) {
    const size_t step = alignment > 0 ? static_cast<size_t>(alignment) : sizeof(Header);
    const size_t lead = (sizeof(Header) + step - 1) / step * step;
    auto* start = static_cast<std::byte*>(std::malloc(lead + step + size));
    if (start == nullptr) { return nullptr; }
    const size_t misfit = (reinterpret_cast<uintptr_t>(start) + lead) % step;
    std::byte* block = start + lead + (misfit == 0 ? 0 : step - misfit);
    reinterpret_cast<Header*>(block)[-1] = {start, size};
    live_bytes.fetch_add(static_cast<int64_t>(size), std::memory_order_relaxed);
    allocations.fetch_add(1, std::memory_order_relaxed);
    return block;
}

void release(void* block) {
    if (block == nullptr) { return; }
    const Header header = static_cast<Header*>(block)[-1];
    live_bytes.fetch_sub(static_cast<int64_t>(header.size), std::memory_order_relaxed);
    std::free(header.start);
}

} // namespace

void count_bullet_memory() {
    btAlignedAllocSetCustomAligned(allocate, release);
}

BulletMemory bullet_memory() {
    return {live_bytes.load(std::memory_order_relaxed), allocations.load(std::memory_order_relaxed)};
}

} // namespace demos
