// Cases of short, long and changing steps.

#include "case_parts.h"

namespace demos {

namespace {

// A loose sheet falls on a ball that does not move.
void build_sheet_on_ball(scene_builder* builder) {
    add_ground(builder);
    add_rigid(builder, scene_sphere(0.4f), pli_vec3_make(0, 1, 0), 0);
    SheetDef sheet;
    sheet.center = pli_vec3_make(0, 1.6f, 0);
    sheet.stiffness = 5000;
    add_sheet(builder, sheet, 0.03f);
}

// What a long step leaves of errors, some 3 cm, is put right in the short one that follows: half the mass of 1.4 kg
// times the square of that speed, J.
constexpr double changing_step_energy = 0.5 * 1.4 * (0.03 * 240) * (0.03 * 240);

constexpr float volume_stiffness = 20;
constexpr float ball_mass = 1;

// Bounces on the ground, held out by its volume.
void build_volume_ball(scene_builder* builder) {
    add_ground(builder);
    pli_mesh* mesh = make_ball(builder, pli_vec3_make(0, 2, 0), 1, 128, ball_mass);
    scene_soft_def def = case_def("ball");
    def.volume_conservation = volume_stiffness;
    scene_add_soft(builder, mesh, &def);
}

StabilityCase sheet_on_ball(const std::string& name) {
    StabilityCase made;
    made.group = "step";
    made.name = "sheet on a ball, " + name;
    made.figure_name = "rms stretch";
    made.build = build_sheet_on_ball;
    made.reach = 5;
    return made;
}

StabilityCase volume_ball(const std::string& name) {
    StabilityCase made;
    made.group = "step";
    made.name = "ball with kVC 20, " + name;
    made.figure_name = "rms stretch";
    made.build = build_volume_ball;
    made.reach = 5;
    return made;
}

} // namespace

void add_step_cases(std::vector<StabilityCase>& cases) {
    const struct {
        const char* name;
        float seconds;
    } steps[] = {{"1/240 s", 1.0f / 240}, {"1/60 s", 1.0f / 60}, {"1/15 s", 1.0f / 15}, {"1/10 s", 0.1f}};
    for (const auto& make : {sheet_on_ball, volume_ball}) {
        for (const auto& step : steps) {
            cases.push_back(make(step.name));
            cases.back().step_seconds = [seconds = step.seconds](int) { return seconds; };
        }
        cases.push_back(make("1/240 and 1/15 s in turn"));
        cases.back().step_seconds = [](int step) { return step % 2 == 0 ? 1.0f / 240 : 1.0f / 15; };
        cases.back().given_energy = changing_step_energy;
        cases.back().smooths_steps = true;
    }
}

} // namespace demos
