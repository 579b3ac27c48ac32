/* A team comes together in one range of the hook, of as many parts as members. Nothing says that a hook runs them at
   the same time, so whoever comes waits a while for the others; if they do not come, the work is done without a team,
   and the next try is put off, longer each time. */

#include "team.h"

#ifndef __STDC_NO_THREADS__
#include <threads.h>
#endif

enum {
    TEAM_LOOKS_BEFORE_YIELD = 2000, /* some 40 cycles each */
    TEAM_MOST_FAILURES = 6
};

enum { TEAM_COMES, TEAM_IS_COMPLETE, TEAM_IS_OFF };

typedef struct team_meeting {
    plii_team team;
    plii_team_fn* work;
    void* task;
    int count, patience;
    _Alignas(64) atomic_int come;
    _Alignas(64) atomic_int state;
} team_meeting;

static void team_look_away(int looks) {
#ifndef __STDC_NO_THREADS__
    if (looks >= TEAM_LOOKS_BEFORE_YIELD) { /* there may be more threads than processors */
        thrd_yield();
        return;
    }
#else
    (void)looks;
#endif
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

void plii_team_wait(const plii_team* team, int member, int steps) {
    const atomic_int* own = &team->members[member].steps;
    for (int looks = 0; atomic_load_explicit(own, memory_order_acquire) < steps;) {
        team_look_away(looks);
        looks += looks < TEAM_LOOKS_BEFORE_YIELD;
    }
}

void plii_team_meet(plii_team* team, int member, int count, int steps) {
    plii_team_signal(team, member, steps);
    for (int other = 0; other < count; ++other) {
        if (other != member) { plii_team_wait(team, other, steps); }
    }
}

static void team_decide(team_meeting* meeting, int state) {
    int before = TEAM_COMES;
    atomic_compare_exchange_strong(&meeting->state, &before, state);
}

static void team_join(int begin, int end, void* data) {
    team_meeting* meeting = data;
    if (end - begin > 1) { /* one thread cannot be several members */
        team_decide(meeting, TEAM_IS_OFF);
        return;
    }
    if (atomic_fetch_add(&meeting->come, 1) + 1 == meeting->count) { team_decide(meeting, TEAM_IS_COMPLETE); }
    for (int looks = 0; atomic_load_explicit(&meeting->state, memory_order_acquire) == TEAM_COMES; ++looks) {
        if (looks == meeting->patience) { team_decide(meeting, TEAM_IS_OFF); }
        team_look_away(0);
    }
    if (atomic_load_explicit(&meeting->state, memory_order_acquire) == TEAM_IS_COMPLETE) {
        meeting->work(&meeting->team, begin, meeting->task);
    }
}

bool plii_team_run(pli_context* context, int count, plii_team_fn* work, void* task) {
    if (count < 2) { return false; }
    if (context->team_delay > 0) {
        context->team_delay -= 1;
        return false;
    }
    team_meeting meeting = {.work = work, .task = task, .count = count, .patience = context->team_patience};
    plii_walk_begin(context);
    context->parallel_for(team_join, &meeting, count, 1, context->parallel_user);
    plii_walk_end(context);
    if (atomic_load(&meeting.state) == TEAM_IS_COMPLETE) {
        context->team_failures = 0;
        return true;
    }
    context->team_failures += context->team_failures < TEAM_MOST_FAILURES;
    context->team_delay = (1 << context->team_failures) - 1;
    return false;
}
