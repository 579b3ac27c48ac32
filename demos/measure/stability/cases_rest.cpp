// Cases at rest for a long time: nothing may creep or begin to move.

#include "case_parts.h"
#include "measure/measure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace demos {

namespace {

constexpr int settling_steps = 1200; // 20 s
constexpr double most_creep = 0.001; // m
// m/s, a tenth of what gravity gives in a step: below it motion does not count as growing.
constexpr double least_speed = 0.017;

// The way of the centre of mass, and the largest speed in the first and in the last quarter after settling.
class RestWatcher final : public Watcher {
public:
    explicit RestWatcher(int steps) : steps_(steps) {}

    void after_step(const Engine& engine, int step) override {
        if (step < settling_steps || (step % 10 != 0 && step != steps_)) { return; }
        double center[3] = {};
        const SoftState state = engine.soft(0);
        const auto count = static_cast<double>(state.positions.size());
        for (const pli_vec3 p : state.positions) {
            center[0] += static_cast<double>(p.x) / count;
            center[1] += static_cast<double>(p.y) / count;
            center[2] += static_cast<double>(p.z) / count;
        }
        if (!has_start_) { std::copy(center, center + 3, start_); }
        has_start_ = true;
        creep_ =
            std::sqrt(squared(center[0] - start_[0]) + squared(center[1] - start_[1]) + squared(center[2] - start_[2]));
        const int quarter = (steps_ - settling_steps) / 4;
        const double speed = measure(engine).rms_speed;
        if (step <= settling_steps + quarter) { first_ = std::max(first_, speed); }
        if (step > steps_ - quarter) { last_ = std::max(last_, speed); }
    }

    Finding end(const Engine&) override {
        Finding finding{Verdict::survives, 1000 * creep_, ""};
        char text[80];
        if (creep_ > most_creep) {
            std::snprintf(text, sizeof text, "creeps by %.3g mm", 1000 * creep_);
        } else if (last_ > std::max(1.5 * first_, least_speed)) {
            std::snprintf(text, sizeof text, "speed grows from %.2g to %.2g m/s", first_, last_);
        } else {
            return finding;
        }
        finding.verdict = Verdict::never_rests;
        finding.note = text;
        return finding;
    }

private:
    static double squared(double x) { return x * x; }

    int steps_;
    bool has_start_ = false;
    double start_[3] = {}, creep_ = 0, first_ = 0, last_ = 0;
};

// Takes away all sliding of a soft body whose friction is 1.
void add_rough(scene_builder* builder, scene_shape shape, pli_vec3 position) {
    scene_rigid_def def = scene_rigid_def_default();
    def.name = "rough";
    def.shape = shape;
    def.pose.origin = position;
    def.friction = 1;
    scene_add_rigid(builder, &def);
}

StabilityCase rest_case(const std::string& name, int steps, std::function<void(scene_builder*)> build) {
    StabilityCase made;
    made.group = "rest";
    made.name = name + ", " + std::to_string(steps) + " steps";
    made.figure_name = "creep, mm";
    made.build = std::move(build);
    made.seconds = static_cast<float>(steps) * frame_seconds;
    made.more_time = 0.01 * steps;
    made.watch = [steps] { return std::make_unique<RestWatcher>(steps); };
    return made;
}

} // namespace

void add_rest_cases(std::vector<StabilityCase>& cases, int steps) {
    cases.push_back(rest_case("sheet on a ball", steps, [](scene_builder* builder) {
        add_ground(builder);
        add_rough(builder, scene_sphere(0.6f), pli_vec3_make(0, 0.6f, 0));
        SheetDef sheet;
        sheet.center = pli_vec3_make(0, 1.25f, 0);
        sheet.columns = 9;
        pli_mesh* mesh = make_sheet(builder, sheet);
        scene_soft_def def = case_def("sheet");
        def.collision_margin = 0.03f;
        def.rigid_contacts.friction = 1;
        def.solver.velocity_damping = 0.01f;
        set_stiffness(builder, mesh, def, 1000);
        scene_add_soft(builder, mesh, &def);
    }));
    cases.push_back(rest_case("cube of tetrahedra on the ground", steps, [](scene_builder* builder) {
        add_rough(builder, scene_box(pli_vec3_make(50, 1, 50)), pli_vec3_make(0, -1, 0));
        pli_mesh* mesh = make_cube(builder, 10);
        scene_check(builder, pli_mesh_scale(mesh, pli_vec3_make(0.5f, 0.5f, 0.5f)));
        scene_check(builder, pli_mesh_translate(mesh, pli_vec3_make(0, 0.6f, 0)));
        scene_soft_def def = case_def("cube");
        def.rigid_contacts.friction = 1;
        def.solver.velocity_damping = 0.01f;
        scene_add_soft(builder, mesh, &def);
    }));
}

} // namespace demos
