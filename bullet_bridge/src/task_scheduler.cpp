#include <pliant_bullet/task_scheduler.h>

#include <LinearMath/btThreads.h>

namespace pliant {

namespace {

struct RangeBody final : btIParallelForBody {
    RangeBody(pli_range_fn* range_of, void* task_of) : range(range_of), task(task_of) {}
    void forLoop(int begin, int end) const override { range(begin, end, task); }

    pli_range_fn* range;
    void* task;
};

} // namespace

void bullet_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    auto* chosen = static_cast<btITaskScheduler*>(user);
    btITaskScheduler* scheduler = chosen != nullptr ? chosen : btGetTaskScheduler();
    if (scheduler == nullptr) { // none was set
        range(0, count, task);
        return;
    }
    scheduler->parallelFor(0, count, grain, RangeBody(range, task));
}

} // namespace pliant
