#include "thread_pool.h"

#include <algorithm>

namespace demos {

namespace {

constexpr int parts_per_thread = 4;
constexpr int looks_before_sleep = 20000, looks_before_yield = 2000; // some 40 cycles each
constexpr int looks_before_help = 50; // to look at another thread's stretch makes it wait

void pause_briefly() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#else
    std::this_thread::yield();
#endif
}

} // namespace

ThreadPool::ThreadPool(int threads)
    : stretches_(static_cast<size_t>(std::max(threads, 1))), finished_(stretches_.size()) {
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
    if (pool.workers_.empty() || count / 2 < std::max(grain, 1) || pool.is_busy_.exchange(true)) {
        range(0, count, task);
        return;
    }
    pool.run(range, task, count, grain);
    pool.is_busy_ = false;
}

void ThreadPool::publish(const Work& work) {
    // Nobody takes parts of the last job any more; who reads the new one halfway sees no job.
    work_.job.store(0, std::memory_order_relaxed);
    work_.count.store(work.count, std::memory_order_release);
    work_.part_size.store(work.part_size, std::memory_order_release);
    work_.range.store(work.range, std::memory_order_release);
    work_.task.store(work.task, std::memory_order_release);
    work_.job = work.job; // before `sleeping_` is read
}

bool ThreadPool::read(Work* work) const {
    work->job = work_.job.load(std::memory_order_acquire);
    work->count = work_.count.load(std::memory_order_acquire);
    work->part_size = work_.part_size.load(std::memory_order_acquire);
    work->range = work_.range.load(std::memory_order_acquire);
    work->task = work_.task.load(std::memory_order_acquire);
    return work->job != 0 && work_.job.load(std::memory_order_relaxed) == work->job;
}

ThreadPool::Parts ThreadPool::parts_of(const Work& work, size_t thread) const {
    const auto parts = static_cast<uint64_t>((work.count - 1) / work.part_size + 1);
    const uint64_t threads = stretches_.size();
    return {static_cast<uint32_t>(parts * thread / threads), static_cast<uint32_t>(parts * (thread + 1) / threads)};
}

void ThreadPool::run(pli_range_fn* range, void* task, int count, int grain) {
    // As many for each thread: all have the same share of every range.
    const int threads = thread_count(), wanted = count / std::max(grain, 1);
    const int parts = wanted < threads ? wanted : threads * std::min(wanted / threads, parts_per_thread);
    const uint32_t last_job = work_.job.load(std::memory_order_relaxed);
    const Work work = {last_job + 1 != 0 ? last_job + 1 : 1, range, task, count, (count - 1) / parts + 1};
    publish(work);
    if (sleeping_ > 0) {
        const std::lock_guard<std::mutex> lock(mutex_);
        work_came_.notify_all();
    }
    published_parts_ += static_cast<uint32_t>((count - 1) / work.part_size + 1);
    run_stretch(work, 0, 0);
    for (int looks = 0; !is_finished(published_parts_); ++looks) {
        if (looks < looks_before_yield) {
            pause_briefly();
        } else {
            std::this_thread::yield();
        }
        if (looks % looks_before_yield == looks_before_help) {
            for (size_t i = 1; i < stretches_.size(); ++i) {
                run_stretch(work, i, 0);
            }
        }
    }
}

bool ThreadPool::is_finished(uint32_t all_parts) const {
    uint32_t parts = 0;
    for (const Finished& finished : finished_) {
        parts += finished.parts.load(std::memory_order_acquire);
    }
    return parts == all_parts;
}

void ThreadPool::run_stretch(const Work& work, size_t of, size_t by) {
    const Parts parts = parts_of(work, of);
    std::atomic<uint64_t>& next = stretches_[of].next;
    uint32_t done = 0;
    for (uint64_t word = next.load(std::memory_order_acquire);;) {
        const auto ahead = static_cast<int32_t>(static_cast<uint32_t>(word >> 32) - work.job);
        const uint32_t part = ahead == 0 ? static_cast<uint32_t>(word) : parts.begin;
        if (ahead > 0 || part >= parts.end) { break; } // or another job has come already
        const uint64_t taken = static_cast<uint64_t>(work.job) << 32 | (part + 1);
        if (!next.compare_exchange_weak(word, taken, std::memory_order_acq_rel, std::memory_order_acquire)) {
            continue;
        }
        const int begin = static_cast<int>(part) * work.part_size;
        work.range(begin, begin + std::min(work.part_size, work.count - begin), work.task);
        ++done;
        word = next.load(std::memory_order_acquire);
    }
    if (done > 0) { finished_[by].parts.fetch_add(done, std::memory_order_release); }
}

void ThreadPool::work(size_t thread) {
    uint32_t last_job = 0;
    for (int looks = 0; !is_ending_;) {
        Work work;
        if (work_.job.load(std::memory_order_relaxed) != last_job && read(&work)) {
            run_stretch(work, thread, thread);
            last_job = work.job;
            looks = 0;
            continue;
        }
        pause_briefly();
        if (++looks == looks_before_help && read(&work) && work.job == last_job) {
            for (size_t i = 1; i < stretches_.size(); ++i) {
                run_stretch(work, (thread + i) % stretches_.size(), thread);
            }
        } else if (looks >= looks_before_sleep) {
            sleep(last_job);
            looks = 0;
        }
    }
}

void ThreadPool::sleep(uint32_t last_job) {
    std::unique_lock<std::mutex> lock(mutex_);
    ++sleeping_;
    work_came_.wait(lock, [&] { return is_ending_ || work_.job != last_job; });
    --sleeping_;
}

} // namespace demos
