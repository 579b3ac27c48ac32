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
// finished waits a little, then takes parts of the others' stretches. Between two ranges, which follow each other after
// microseconds, workers look out for work for a while before they sleep. A line of memory that one thread writes and
// another reads takes longer than a short part, so there are few of them: the work, and what each thread has finished.
class ThreadPool {
public:
    explicit ThreadPool(int threads); // the caller's is one of them
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    int thread_count() const { return static_cast<int>(stretches_.size()); }

    // A pli_parallel_for_fn, `user` is the pool. One caller at a time has the workers; others, and calls from within a
    // range, run alone.
    static void parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user);

private:
    struct Work {
        uint32_t job;
        pli_range_fn* range;
        void* task;
        int count, part_size;
    };
    // In one line, valid while `job` stays what it was before the rest was read.
    struct alignas(64) SharedWork {
        std::atomic<uint32_t> job{0};
        std::atomic<int> count{0}, part_size{1};
        std::atomic<pli_range_fn*> range{nullptr};
        std::atomic<void*> task{nullptr};
    };
    // Of a stretch: the job in the upper half, the next part in the lower one. That of an earlier job stands for the
    // first part: only who takes parts writes it.
    struct alignas(64) Stretch {
        std::atomic<uint64_t> next{0};
    };
    struct alignas(64) Finished {
        std::atomic<uint32_t> parts{0}; // since the pool was made
    };
    struct Parts {
        uint32_t begin, end;
    };

    void run(pli_range_fn* range, void* task, int count, int grain);
    void publish(const Work& work);
    bool read(Work* work) const; // false when it was changed meanwhile
    Parts parts_of(const Work& work, size_t thread) const;
    void run_stretch(const Work& work, size_t of, size_t by);
    bool is_finished(uint32_t all_parts) const;
    void work(size_t thread);
    void sleep(uint32_t last_job);

    SharedWork work_;
    std::vector<Stretch> stretches_; // of each thread
    std::vector<Finished> finished_; // by each thread
    uint32_t published_parts_ = 0;   // since the pool was made
    alignas(64) std::atomic<bool> is_busy_{false};
    std::atomic<bool> is_ending_{false};
    std::atomic<int> sleeping_{0};
    std::mutex mutex_;
    std::condition_variable work_came_;
    std::vector<std::thread> workers_;
};

} // namespace demos
#endif
