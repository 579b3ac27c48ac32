#include "thread_pool.h"

#include <algorithm>

namespace demos {

namespace {

constexpr int parts_per_thread = 4, most_parts = 60000;
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
    return static_cast<uint64_t>(ticket.job) << 32 | static_cast<uint64_t>(ticket.next) << 16 | ticket.parts;
}

ThreadPool::Ticket ThreadPool::unpack(uint64_t word) {
    return {static_cast<uint32_t>(word >> 32), static_cast<uint16_t>(word >> 16), static_cast<uint16_t>(word)};
}

ThreadPool::ThreadPool(int threads) {
    for (int i = 1; i < threads; ++i) {
        workers_.emplace_back([this] { work(); });
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
    const int most = std::min(parts_per_thread * (static_cast<int>(workers_.size()) + 1), most_parts);
    const int part_size = std::max(std::max(grain, 1), (count + most - 1) / most);
    const int parts = (count + part_size - 1) / part_size;
    range_.store(range, std::memory_order_relaxed);
    task_.store(task, std::memory_order_relaxed);
    count_.store(count, std::memory_order_relaxed);
    part_size_.store(part_size, std::memory_order_relaxed);
    finished_.store(0, std::memory_order_relaxed);
    ticket_ = pack({unpack(ticket_).job + 1, 0, static_cast<uint16_t>(parts)});
    if (sleeping_ > 0) {
        const std::lock_guard<std::mutex> lock(mutex_);
        work_came_.notify_all();
    }
    while (run_part()) {}
    for (int looks = 0; finished_.load(std::memory_order_acquire) < parts; ++looks) {
        if (looks < looks_before_yield) {
            pause_briefly();
        } else {
            std::this_thread::yield();
        }
    }
}

bool ThreadPool::run_part() {
    uint64_t word = ticket_.load(std::memory_order_acquire);
    for (;;) {
        Ticket ticket = unpack(word);
        if (ticket.next >= ticket.parts) { return false; }
        pli_range_fn* range = range_.load(std::memory_order_relaxed);
        void* task = task_.load(std::memory_order_relaxed);
        const int count = count_.load(std::memory_order_relaxed);
        const int part_size = part_size_.load(std::memory_order_relaxed), part = ticket.next++;
        // Where this succeeds the work is still the one that was read.
        if (!ticket_.compare_exchange_weak(word, pack(ticket), std::memory_order_acq_rel, std::memory_order_acquire)) {
            continue;
        }
        const int begin = part * part_size;
        range(begin, begin + std::min(part_size, count - begin), task);
        finished_.fetch_add(1, std::memory_order_release);
        return true;
    }
}

void ThreadPool::work() {
    for (int looks = 0; !is_ending_;) {
        const uint64_t word = ticket_;
        if (unpack(word).next < unpack(word).parts) {
            while (run_part()) {}
            looks = 0;
        } else if (++looks < looks_before_sleep) {
            pause_briefly();
        } else {
            sleep(word);
            looks = 0;
        }
    }
}

void ThreadPool::sleep(uint64_t exhausted) {
    std::unique_lock<std::mutex> lock(mutex_);
    ++sleeping_;
    work_came_.wait(lock, [&] { return is_ending_ || ticket_ != exhausted; });
    --sleeping_;
}

} // namespace demos
