// Cases of contacts: impacts on a thin box, cloths that cross at the start, nodes exactly on faces.

#include "case_parts.h"

#include <algorithm>
#include <cmath>

namespace demos {

namespace {

constexpr float box_half_width = 3, box_half_height = 0.05f;
constexpr float recovery_speed = 1; // m/s, of overlaps of soft bodies

// J: two sheets of 1 kg each, whose nodes overlap by twice the margin of 2 cm at the start and by what they move in a
// step later, are put apart in a step.
double parting_energy(float speed) {
    const double parting = 0.04 / static_cast<double>(frame_seconds) + static_cast<double>(speed);
    return parting * parting;
}

// Looks for nodes below the box, not beside it.
class ImpactWatcher final : public Watcher {
public:
    void after_step(const Engine& engine, int step) override {
        int below = 0;
        const std::vector<pli_vec3> positions = positions_of(engine, 0);
        for (const pli_vec3 p : positions) {
            below += p.y < -box_half_height && std::fabs(p.x) < box_half_width && std::fabs(p.z) < box_half_width;
        }
        const double share = static_cast<double>(below) / static_cast<double>(positions.size());
        if (share > share_) {
            share_ = share;
            step_ = step;
        }
    }
    Finding end(const Engine&) override {
        if (share_ <= 0.0) { return {Verdict::survives, 0, ""}; }
        return {Verdict::passes_through, share_,
                std::to_string(std::lround(100 * share_)) + " % of the nodes below the box in step " +
                    std::to_string(step_)};
    }

private:
    double share_ = 0;
    int step_ = 0;
};

void add_impacts(std::vector<StabilityCase>& cases) {
    for (const float speed : {1.0f, 10.0f, 20.0f, 30.0f, 100.0f, 300.0f}) {
        StabilityCase made;
        made.group = "impact";
        made.name = "ball at " + std::to_string(static_cast<int>(speed)) + " m/s on a box of 10 cm";
        made.figure_name = "share below";
        made.build = [speed](scene_builder* builder) {
            add_rigid(builder, scene_box(pli_vec3_make(box_half_width, box_half_height, box_half_width)),
                      pli_vec3_make(0, 0, 0), 0);
            const scene_soft_def def = case_def("ball");
            const int ball = scene_add_soft(builder, make_ball(builder, pli_vec3_make(0, 1, 0), 0.5f, 100, 1), &def);
            scene_set_velocity(builder, ball, pli_vec3_make(0, -speed, 0));
        };
        made.seconds = 1;
        made.reach = 400;
        made.has_face_contacts = true;
        made.watch = [] { return std::make_unique<ImpactWatcher>(); };
        cases.push_back(made);
    }
}

void add_crossings(std::vector<StabilityCase>& cases) {
    for (const float speed : {0.0f, 20.0f}) {
        StabilityCase made;
        made.group = "contact";
        made.name = "two sheets that cross, " + std::to_string(static_cast<int>(speed)) + " m/s";
        made.figure_name = "rms stretch";
        made.build = [speed](scene_builder* builder) {
            for (const bool is_upright : {false, true}) {
                SheetDef sheet;
                sheet.columns = 10;
                sheet.is_upright = is_upright;
                sheet.pins = is_upright ? 0 : PLI_PATCH_PIN_CORNERS;
                pli_mesh* mesh = make_sheet(builder, sheet);
                scene_soft_def def = case_def("sheet");
                def.has_soft_contacts = true;
                def.soft_contacts.recovery_speed = recovery_speed;
                set_stiffness(builder, mesh, def, 1000);
                const int soft = scene_add_soft(builder, mesh, &def);
                if (is_upright) { scene_set_velocity(builder, soft, pli_vec3_make(0, -speed, 0)); }
            }
        };
        made.seconds = 2;
        made.reach = 100; // the loose one may fall
        made.given_energy = parting_energy(speed);
        cases.push_back(made);
    }
}

void add_nodes_on_faces(std::vector<StabilityCase>& cases) {
    StabilityCase made;
    made.group = "contact";
    made.name = "two sheets in the same place";
    made.figure_name = "rms stretch";
    made.build = [](scene_builder* builder) {
        for (int i = 0; i < 2; ++i) {
            SheetDef sheet;
            sheet.columns = 6 + i; // nodes of one on faces and edges of the other
            sheet.pins = PLI_PATCH_PIN_CORNERS;
            pli_mesh* mesh = make_sheet(builder, sheet);
            scene_soft_def def = case_def("sheet");
            def.has_soft_contacts = true;
            def.soft_contacts.recovery_speed = recovery_speed;
            set_stiffness(builder, mesh, def, 1000);
            scene_add_soft(builder, mesh, &def);
        }
    };
    made.given_energy = parting_energy(0);
    cases.push_back(made);
    made.name = "sheet inside a box at the start";
    made.build = [](scene_builder* builder) {
        add_ground(builder);
        add_rigid(builder, scene_box(pli_vec3_make(0.3f, 0.3f, 0.3f)), pli_vec3_make(0, 0.3f, 0), 0);
        SheetDef sheet;
        sheet.center = pli_vec3_make(0, 0.3f, 0);
        add_sheet(builder, sheet, 0.02f);
    };
    cases.push_back(made);
}

} // namespace

void add_contact_cases(std::vector<StabilityCase>& cases) {
    add_impacts(cases);
    add_crossings(cases);
    add_nodes_on_faces(cases);
}

} // namespace demos
