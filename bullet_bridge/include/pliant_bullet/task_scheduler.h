#ifndef PLIANT_BULLET_TASK_SCHEDULER_H
#define PLIANT_BULLET_TASK_SCHEDULER_H

/// Threads of Bullet for Pliant.

#include <pliant/base.h>

namespace pliant {

/// pli_context_def::parallel_for by a task scheduler of Bullet: one of its own, where Bullet was built with
/// BT_THREADSAFE, or one that a program derived from btITaskScheduler.
///
///     pli_context_def def = pli_context_def_default();
///     def.parallel_for = pliant::bullet_parallel_for;
///     def.parallel_user = scheduler; // a btITaskScheduler*; null: the one in use then, btGetTaskScheduler(), if any
PLI_API void bullet_parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user);

} // namespace pliant

#endif
