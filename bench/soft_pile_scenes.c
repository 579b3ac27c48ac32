/* The table of piles in docs/contacts.md: six sheets that fall onto each other, by solver, iterations or substeps, and
   margin.

     usage: soft_pile_scenes [SECONDS] */

#include "soft_piles.h"

#include <pliant/pliant.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s\n", pli_status_string(status));
    exit(1);
}

/* Of the processor, whatever else runs. */
static double milliseconds(void) {
    return (double)clock() * 1e3 / CLOCKS_PER_SEC;
}

/* s, until all sheets are asleep, where they may. */
static double time_to_sleep(const pile_def* def) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pile sheets;
    pile_def sleeping = *def;
    sleeping.may_sleep = true;
    check(pli_context_create(NULL, &context));
    check(pli_world_create(context, NULL, &world));
    check(pile_make_sheets(world, &sleeping, &sheets));
    int frames = 0;
    while (frames < 600 && !pile_is_asleep(&sheets)) {
        check(pli_world_step(world, 1.0f / 60.0f));
        ++frames;
    }
    pli_world_destroy(world);
    pli_context_destroy(context);
    return frames < 600 ? frames / 60.0 : (double)INFINITY;
}

static void run(const pile_def* def, int frames) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pile sheets;
    check(pli_context_create(NULL, &context));
    check(pli_world_create(context, NULL, &world));
    check(pile_make_sheets(world, def, &sheets));
    int contacts = 0;
    double stretch = 0, speed = 0, spent = 0;
    for (int frame = 0; frame < frames; ++frame) {
        const double start = milliseconds();
        check(pli_world_step(world, 1.0f / 60.0f));
        spent += milliseconds() - start;
        const int found = pile_contacts(&sheets);
        contacts = found > contacts ? found : contacts;
        stretch = fmax(stretch, pile_stretch(&sheets));
        if (frame >= frames - 60) { speed = fmax(speed, pile_rms_speed(&sheets)); }
    }
    printf("%6g %8.1f %7.3f %9.4f %7d %7d %7.1f %6.1f\n", (double)def->margin * 100,
           (double)contacts / pile_nodes(&sheets), stretch, speed, pile_nodes_below(&sheets, 0.005f),
           pile_nodes_below(&sheets, 0.04f), spent / frames, time_to_sleep(def));
    pli_world_destroy(world);
    pli_context_destroy(context);
}

int main(int argc, char** argv) {
    static const char* const names[] = {"position-based", "implicit, gradients", "XPBD", "implicit, sweeps"};
    static const float margins[] = {0.01f, 0.02f, 0.05f};
    const int seconds = argc > 1 ? atoi(argv[1]) : 10;
    printf("margin: cm; contacts per node, rms stretch: the most in a frame; rms speed, m/s: the most of the last "
           "second;\n"
           "nodes of 3,380 that are 0.5 and 4 cm below the next layer at the end; processor time per step, ms: the "
           "mean; asleep, s: when all sleep that may (the rest of the row is awake)\n");
    for (int solver = PILE_POSITION_BASED; solver <= PILE_SWEEPS; ++solver) {
        for (int iterations = 5; iterations <= 10; iterations += 5) {
            printf("%s, %d %s\nmargin contacts stretch     speed  0.5 cm    4 cm      ms asleep\n", names[solver],
                   iterations, solver == PILE_XPBD ? "substeps" : "iterations");
            for (int m = 0; m < 3; ++m) {
                const pile_def def = {.solver = (pile_solver)solver,
                                      .margin = margins[m],
                                      .iterations = iterations,
                                      .colored = true,
                                      .has_tethers = true,
                                      .damping = 0.01f};
                run(&def, 60 * (seconds > 0 ? seconds : 1));
            }
        }
    }
    return 0;
}
