// Replaces the global operators; the array and nothrow forms of the standard library call these.

#include "heap_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__)
#define DEMOS_COUNTS_HEAP 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define DEMOS_COUNTS_HEAP 0
#endif
#endif
#ifndef DEMOS_COUNTS_HEAP
#define DEMOS_COUNTS_HEAP 1
#endif

namespace {

std::atomic<uint64_t> allocations{0};

} // namespace

namespace demos {

uint64_t heap_allocations() {
    return allocations.load(std::memory_order_relaxed);
}

} // namespace demos

#if DEMOS_COUNTS_HEAP

static void* counted(void* block) {
    if (block == nullptr) { throw std::bad_alloc(); }
    allocations.fetch_add(1, std::memory_order_relaxed);
    return block;
}

void* operator new(std::size_t size) {
    return counted(std::malloc(size > 0 ? size : 1));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    const auto step = static_cast<std::size_t>(alignment);
    return counted(std::aligned_alloc(step, (size + step - 1) / step * step));
}
void operator delete(void* block) noexcept {
    std::free(block);
}
void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
    std::free(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
    std::free(block);
}

#endif
