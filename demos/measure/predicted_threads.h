#ifndef DEMOS_PREDICTED_THREADS_H
#define DEMOS_PREDICTED_THREADS_H

#include <array>

namespace demos {

// For how many threads a speed-up is predicted.
constexpr std::array<int, 3> predicted_threads = {4, 8, 16};

} // namespace demos
#endif
