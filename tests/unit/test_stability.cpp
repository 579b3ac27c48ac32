// The stability map: children that hang or crash, and verdicts on cases made for them.

#include "measure/stability/case_parts.h"
#include "measure/stability/child_process.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <unistd.h>

#include "check.h"

using demos::Cell;
using demos::ChildAnswer;
using demos::ChildEnd;
using demos::Column;
using demos::Engine;
using demos::StabilityCase;
using demos::StabilityOptions;
using demos::Verdict;

static void children_answer_or_are_ended(void**) {
    const std::string long_text(100000, 'x'); // more than a pipe holds
    ChildAnswer answer = demos::run_in_child([&] { return long_text; }, 10);
    assert_true(answer.end == ChildEnd::answered && answer.text == long_text);
    answer = demos::run_in_child(
        []() -> std::string {
            for (;;) {
                pause();
            }
        },
        0.2);
    assert_true(answer.end == ChildEnd::timed_out);
    answer = demos::run_in_child(
        []() -> std::string {
            std::signal(SIGTERM, SIG_DFL);
            raise(SIGTERM);
            return "";
        },
        10);
    assert_true(answer.end == ChildEnd::crashed && answer.signal == SIGTERM);
    answer = demos::run_in_child([]() -> std::string { throw demos::Error("no"); }, 10);
    assert_true(answer.end == ChildEnd::crashed && answer.signal == 0);
}

static void several_children_answer(void**) {
    std::vector<demos::ChildWork> works;
    for (int i = 0; i < 7; ++i) {
        works.push_back({[i] { return std::string(static_cast<size_t>(20000 * i), 'a'); }, 10});
    }
    works[3] = {[]() -> std::string {
                    for (;;) {
                        pause();
                    }
                },
                0.2};
    std::vector<int> answers(works.size());
    demos::run_in_children(works, 3, [&](size_t index, const ChildAnswer& answer) {
        ++answers[index];
        assert_true(answer.end == (index == 3 ? ChildEnd::timed_out : ChildEnd::answered));
        if (index != 3) { assert_int_equal(answer.text.size(), 20000 * index); }
    });
    assert_true(std::count(answers.begin(), answers.end(), 1) == 7);
}

static StabilityCase sheet_case(const char* name) {
    StabilityCase made;
    made.group = "test";
    made.name = name;
    made.figure_name = "rms stretch";
    made.build = [](scene_builder* builder) {
        demos::SheetDef sheet;
        sheet.columns = 4;
        sheet.pins = PLI_PATCH_PIN_CORNERS;
        demos::add_sheet(builder, sheet, 0.02f);
    };
    made.seconds = 0.2f;
    return made;
}

// Kicks the sheet in the fifth step.
class Kick final : public demos::Watcher {
public:
    explicit Kick(float speed) : speed_(speed) {}
    void after_step(const Engine& engine, int step) override {
        if (step != 5) { return; }
        const std::vector<pli_vec3> positions = demos::positions_of(engine, 0);
        const std::vector<pli_vec3> velocities(positions.size(), pli_vec3_make(0, speed_, 0));
        demos::set_state(const_cast<Engine&>(engine), 0, positions, velocities);
    }
    demos::Finding end(const Engine&) override { return {Verdict::survives, 0.5, ""}; }

private:
    float speed_;
};

static Cell run(const StabilityCase& which, Column column) {
    return demos::run_cell(which, column, StabilityOptions{});
}

static void cells_are_judged(void**) {
    StabilityCase which = sheet_case("sheet");
    for (const Column column : demos::all_columns) {
        const Cell cell = run(which, column);
        assert_true(cell.verdict == Verdict::survives);
        assert_true(cell.figure > 0.0 && cell.figure < 0.05);
    }
    which.reach = 0.01;
    assert_true(run(which, Column::position_based).verdict == Verdict::out_of_reach);
    which.reach = 10;
    which.watch = [] { return std::make_unique<Kick>(3.0f); };
    Cell cell = run(which, Column::position_based);
    assert_true(cell.verdict == Verdict::gains_energy);
    assert_non_null(std::strstr(cell.note.c_str(), "in step 6"));
    which.given_energy = 1;
    cell = run(which, Column::position_based);
    assert_true(cell.verdict == Verdict::survives);
    check_near(cell.figure, 0.5, 0.0);
    which.prepare = [](Engine&) { std::abort(); };
    cell = run(which, Column::xpbd);
    assert_true(cell.verdict == Verdict::crashes && !cell.note.empty());
    which.prepare = [](Engine&) { throw demos::Error("not this one"); };
    cell = run(which, Column::implicit);
    assert_true(cell.verdict == Verdict::refused && cell.note == "not this one");
}

// Cells that were lost before: faces without area in still air, fast bodies, volumes in long steps, tangles,
// heavy ends, very stiff springs, steps that change.
static void solvers_survive(void**) {
    const char* const names[] = {"ball, faces twice and without area, pressure",
                                 "ball at 300 m/s on a box of 10 cm",
                                 "ball with kVC 20, 1/10 s",
                                 "two sheets that cross, 0 m/s",
                                 "two sheets in the same place",
                                 "two links, masses 1 : 1e+06",
                                 "rope with a box, masses 1 : 1e+06",
                                 "hanging sheet, 1e+09 N/m",
                                 "sheet on a ball, 1/240 and 1/15 s in turn",
                                 "ball with kVC 20, 1/240 and 1/15 s in turn"};
    for (const StabilityCase& which : demos::stability_cases({})) {
        if (std::find(std::begin(names), std::end(names), which.name) == std::end(names)) { continue; }
        for (const Column column : {Column::position_based, Column::implicit, Column::gradients, Column::xpbd}) {
            const Cell cell = run(which, column);
            if (cell.verdict != Verdict::survives) {
                fail_msg("%s, %s: %s", which.name.c_str(), column_name(column), cell.note.c_str());
            }
            check_at_most(cell.figure, which.group == "contact" ? 0.5 : 0.2);
        }
    }
}

static void bodies_come_to_rest(void**) {
    StabilityOptions options;
    options.rest_steps = 1800;
    for (const StabilityCase& which : demos::stability_cases(options)) {
        if (which.group != "rest") { continue; }
        const Cell cell = demos::run_cell(which, Column::position_based, options);
        if (cell.verdict != Verdict::survives) { fail_msg("%s: %s", which.name.c_str(), cell.note.c_str()); }
        check_at_most(cell.figure, 0.5); // mm
    }
}

// Random cases that gained energy before: nodes that touch floor and box with friction, gas that presses against a
// volume that is held, stiff and soft.
static void random_cases_gain_no_energy(void**) {
    const struct {
        uint64_t seed;
        const char* name;
        Column column;
    } lost[] = {{1, "728:", Column::gradients}, {2, "436:", Column::gradients}, {3, "397:", Column::gradients},
                {3, "816:", Column::gradients}, {2, "274:", Column::xpbd},      {6, "396:", Column::xpbd}};
    for (const auto& each : lost) {
        StabilityOptions options;
        options.seed = each.seed;
        options.random_count = 1000;
        int found = 0;
        for (const StabilityCase& which : demos::stability_cases(options)) {
            if (which.group != "random" || which.name.rfind(each.name, 0) != 0) { continue; }
            const Cell cell = run(which, each.column);
            if (cell.verdict != Verdict::survives) { fail_msg("%s: %s", which.name.c_str(), cell.note.c_str()); }
            check_at_most(cell.figure, 60); // %; a fall has 50
            ++found;
        }
        assert_int_equal(found, 1);
    }
}

static void cases_have_names_of_their_own(void**) {
    const std::vector<StabilityCase> cases = demos::stability_cases({});
    assert_true(cases.size() >= 50);
    for (size_t i = 0; i < cases.size(); ++i) {
        for (size_t k = 0; k < i; ++k) {
            if (cases[i].name == cases[k].name) { fail_msg("twice: %s", cases[i].name.c_str()); }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(children_answer_or_are_ended),
        cmocka_unit_test(several_children_answer),
        cmocka_unit_test(cells_are_judged),
        cmocka_unit_test(solvers_survive),
        cmocka_unit_test(bodies_come_to_rest),
        cmocka_unit_test(random_cases_gain_no_energy),
        cmocka_unit_test(cases_have_names_of_their_own),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
