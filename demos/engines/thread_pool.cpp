#include "thread_pool.h"

#include <algorithm>

namespace demos {

namespace {

constexpr int parts_per_thread = 4;
constexpr int looks_before_sleep = 20000, looks_before_yield = 2000; // some 40 cycles each

void pause_briefly() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#else
    std::this_thread::yield();
#endif
}

} // namespace

uint64_t ThreadPool::pack(Ticket ticket) {
    return static_cast<uint64_t>(ticket.job) << 32 | static_cast<uint64_t>(ticket.next) << 16 | ticket.end;
}

ThreadPool::Ticket ThreadPool::unpack(uint64_t word) {
    return {static_cast<uint32_t>(word >> 32), static_cast<uint16_t>(word >> 16), static_cast<uint16_t>(word)};
}

ThreadPool::ThreadPool(int threads) : stretches_(static_cast<size_t>(std::max(threads, 1))) {
    for (size_t i = 1; i < stretches_.size(); ++i) {
        workers_.emplace_back([this, i] { work(i); });
    }
}

ThreadPool::~ThreadPool() {
    is_ending_ = true;
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        work_came_.notify_all();
    }
    for (std::thread& worker : workers_) {
        worker.join();
    }
}

void ThreadPool::parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    ThreadPool& pool = *static_cast<ThreadPool*>(user);
    if (pool.workers_.empty() || count <= grain || pool.is_busy_.exchange(true)) {
        range(0, count, task);
        return;
    }
    pool.run(range, task, count, grain);
    pool.is_busy_ = false;
}

void ThreadPool::run(pli_range_fn* range, void* task, int count, int grain) {
    const int threads = static_cast<int>(stretches_.size()), most = parts_per_thread * threads;
    const int part_size = std::max(std::max(grain, 1), (count - 1) / most + 1);
    const int parts = (count - 1) / part_size + 1;
    range_.store(range, std::memory_order_relaxed);
    task_.store(task, std::memory_order_relaxed);
    count_.store(count, std::memory_order_relaxed);
    part_size_.store(part_size, std::memory_order_relaxed);
    finished_.store(0, std::memory_order_relaxed);
    const uint32_t job = job_ + 1;
    for (int i = 0; i < threads; ++i) {
        const auto first = static_cast<uint16_t>(parts * i / threads);
        const auto end = static_cast<uint16_t>(parts * (i + 1) / threads);
        stretches_[static_cast<size_t>(i)].ticket = pack({job, first, end});
    }
    job_ = job;
    if (sleeping_ > 0) {
        const std::lock_guard<std::mutex> lock(mutex_);
        work_came_.notify_all();
    }
    run_parts(0);
    for (int looks = 0; finished_.load(std::memory_order_acquire) < parts; ++looks) {
        if (looks < looks_before_yield) {
            pause_briefly();
        } else {
            std::this_thread::yield();
        }
    }
}

void ThreadPool::run_parts(size_t thread) {
    for (size_t i = 0; i < stretches_.size(); ++i) {
        while (run_part(stretches_[(thread + i) % stretches_.size()])) {}
    }
}

bool ThreadPool::run_part(Stretch& stretch) {
    uint64_t word = stretch.ticket.load(std::memory_order_acquire);
    for (;;) {
        Ticket ticket = unpack(word);
        if (ticket.next >= ticket.end) { return false; }
        pli_range_fn* range = range_.load(std::memory_order_relaxed);
        void* task = task_.load(std::memory_order_relaxed);
        const int count = count_.load(std::memory_order_relaxed);
        const int part_size = part_size_.load(std::memory_order_relaxed), part = ticket.next++;
        // Where this succeeds the work is still the one that was read.
        if (!stretch.ticket.compare_exchange_weak(word, pack(ticket), std::memory_order_acq_rel,
                                                  std::memory_order_acquire)) {
            continue;
        }
        const int begin = part * part_size;
        range(begin, begin + std::min(part_size, count - begin), task);
        finished_.fetch_add(1, std::memory_order_release);
        return true;
    }
}

void ThreadPool::work(size_t thread) {
    uint32_t last_job = 0;
    for (int looks = 0; !is_ending_;) {
        const uint32_t job = job_;
        if (job != last_job) {
            run_parts(thread);
            last_job = job;
            looks = 0;
        } else if (++looks < looks_before_sleep) {
            pause_briefly();
        } else {
            sleep(last_job);
            looks = 0;
        }
    }
}

void ThreadPool::sleep(uint32_t last_job) {
    std::unique_lock<std::mutex> lock(mutex_);
    ++sleeping_;
    work_came_.wait(lock, [&] { return is_ending_ || job_ != last_job; });
    --sleeping_;
}

} // namespace demos
