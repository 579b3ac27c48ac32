#ifndef DEMOS_HEAP_COUNT_H
#define DEMOS_HEAP_COUNT_H

// What C++ takes from the heap, in programs that use this: operator new counts there.

#include <cstdint>

namespace demos {

// Since the start, of all threads; 0 under AddressSanitizer, which has an operator new of its own.
uint64_t heap_allocations();

} // namespace demos
#endif
