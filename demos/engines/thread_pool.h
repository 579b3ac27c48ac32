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

// Parts of a range go to whoever is free, the caller included. Between two ranges, which follow each other after
// microseconds, workers look out for work for a while before they sleep.
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
    // The work in progress in one word: what a thread has read of it holds as long as the word has not changed.
    struct Ticket {
        uint32_t job;
        uint16_t next, parts;
    };
    static uint64_t pack(Ticket ticket);
    static Ticket unpack(uint64_t word);

    void run(pli_range_fn* range, void* task, int count, int grain);
    bool run_part(); // false when there is none left
    void work();
    void sleep(uint64_t exhausted);

    std::atomic<uint64_t> ticket_{0};
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
