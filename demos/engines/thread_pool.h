#ifndef DEMOS_THREAD_POOL_H
#define DEMOS_THREAD_POOL_H

// Threads for pli_context_def::parallel_for.

#include <pliant/base.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace demos {

// Each thread, the caller's included, has a stretch of every range: the same nodes stay in the same cache. Whoever has
// finished takes parts of the others' stretches. Between two ranges, which follow each other after microseconds,
// workers look out for work for a while before they sleep.
class ThreadPool {
public:
    explicit ThreadPool(int threads); // the caller's is one of them
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    // A pli_parallel_for_fn, `user` is the pool. One caller at a time has the workers; others, and calls from within a
    // range, run alone.
    static void parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user);

private:
    // What is left of a stretch, in one word: what a thread has read of the work holds as long as it has not changed.
    struct Ticket {
        uint32_t job;
        uint16_t next, end; // parts
    };
    struct alignas(64) Stretch {
        std::atomic<uint64_t> ticket{0};
    };
    static uint64_t pack(Ticket ticket);
    static Ticket unpack(uint64_t word);

    void run(pli_range_fn* range, void* task, int count, int grain);
    void run_parts(size_t thread);
    bool run_part(Stretch& stretch); // false when there is none left
    void work(size_t thread);
    void sleep(uint32_t last_job);

    std::vector<Stretch> stretches_; // of each thread
    std::atomic<uint32_t> job_{0};
    std::atomic<pli_range_fn*> range_{nullptr};
    std::atomic<void*> task_{nullptr};
    std::atomic<int> count_{0}, part_size_{1};
    alignas(64) std::atomic<int> finished_{0}; // parts
    alignas(64) std::atomic<bool> is_busy_{false}, is_ending_{false};
    std::atomic<int> sleeping_{0};
    std::mutex mutex_;
    std::condition_variable work_came_;
    std::vector<std::thread> workers_;
};

} // namespace demos
#endif
