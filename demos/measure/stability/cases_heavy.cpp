// Cases of heavy rigid bodies on cloth and ropes, of anchors at speed, and of very light nodes.

#include "case_parts.h"
#include "engines/rigid_world.h"
#include "heavy_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace demos {

namespace {

constexpr int iterations = 8; // of position-based solvers
constexpr int most_gradients = 100;
constexpr float margin = 0.02f;    // m
constexpr double end_seconds = 11; // rest is measured over the last second

// Share of the velocity that nodes lose in 1/60 s, and rigid bodies too where `calm` is set: motion fades by 1/e in a
// third of a second.
constexpr float damping = 0.05f;
// The same where nothing but friction may hold a body.
constexpr float little_damping = 0.01f;

float damping_of(float share, float seconds) {
    return 1 - std::pow(1 - share, seconds / frame_seconds);
}

// Light links need short substeps to be as stiff as they should.
int substeps_of(float step) {
    constexpr float substep = 1.0f / 1200; // s
    return static_cast<int>(std::lround(step / substep));
}

StabilityCase heavy_case(const std::string& name, const char* figure_name) {
    StabilityCase made;
    made.group = "heavy";
    made.name = name;
    made.figure_name = figure_name;
    made.seconds = static_cast<float>(end_seconds);
    made.is_asked_for_only = true;
    made.filter_compression = true;
    made.finishing_iterations = most_gradients;
    made.has_loose_energy_rule = false;
    made.most_gradients = most_gradients;
    made.more_time = 600; // of a busy machine
    made.substeps = substeps_of(frame_seconds);
    return made;
}

void watch_by(StabilityCase& which, HeavyRules rules) {
    rules.seconds = static_cast<double>(which.seconds);
    if (which.step_seconds) { rules.step_seconds = which.step_seconds(1); }
    rules.substeps = *which.substeps;
    which.watch = watch_heavy(rules);
}

// Rigid bodies lose `share` of their speed in 1/60 s, and come to rest as nodes do. Where bodies do not sleep they
// never fall asleep.
void damp_rigids(StabilityCase& which, float share) {
    which.prepare = [share, sleeps = which.sleeps](Engine& engine) {
        for (int i = 0; i < engine.rigid_count(); ++i) {
            if (!(engine.rigid_record(i).mass > 0.0f)) { continue; }
            const float share_per_second = 1 - std::pow(1 - share, 1 / frame_seconds);
            engine.rigids().body(i)->setDamping(share_per_second, share_per_second);
            if (!sleeps) { engine.rigids().body(i)->setActivationState(DISABLE_DEACTIVATION); }
        }
    };
}

scene_soft_def heavy_def(float velocity_damping, double stiffness) {
    scene_soft_def def = case_def("cloth");
    def.collision_margin = margin;
    def.solver.position_iterations = iterations;
    def.solver.velocity_damping = velocity_damping;
    def.rigid_contacts.friction = 1;
    def.link_stiffness = static_cast<float>(stiffness);
    return def;
}

// ------------------------------------------------------------------------------------------------------- sheets

enum class Support { corners, rim, hammock, floor };
constexpr int nodes_per_side = 21;

void pin_nodes(scene_builder* builder, pli_mesh* mesh, Support support) {
    for (int i = 0; mesh != nullptr && i < nodes_per_side * nodes_per_side; ++i) {
        const int column = i % nodes_per_side, row = i / nodes_per_side;
        const bool ends_row = column == 0 || column == nodes_per_side - 1;
        const bool ends_column = row == 0 || row == nodes_per_side - 1;
        const bool is_pinned = support == Support::corners   ? ends_row && ends_column
                               : support == Support::rim     ? ends_row || ends_column
                               : support == Support::hammock ? ends_row
                                                             : false;
        if (is_pinned) { scene_check(builder, pli_mesh_set_node_mass(mesh, i, 0)); }
    }
}

// 2 m by 2 m and 1 kg, nodes that are pinned included.
pli_mesh* make_heavy_sheet(scene_builder* builder, float height, Support support, float mass = 1) {
    SheetDef sheet;
    sheet.center = pli_vec3_make(0, height, 0);
    sheet.half_width = 1;
    sheet.columns = nodes_per_side;
    sheet.node_mass = mass / (nodes_per_side * nodes_per_side);
    pli_mesh* mesh = make_sheet(builder, sheet);
    pin_nodes(builder, mesh, support);
    return mesh;
}

// N/m: where a corner holds it, a link gets longer by a few percent under the sheet and a body of so many kg.
double stiffness_under(double mass) {
    return 1000 * (1 + mass);
}

// The sheet is at 0, a ball above it; without a floor but where the sheet lies on one.
void build_ball_on_sheet(scene_builder* builder, Support support, float mass, float gap, float velocity_damping) {
    constexpr float radius = 0.3f;
    add_rigid(builder, scene_sphere(radius), pli_vec3_make(0, gap + radius, 0), mass);
    if (support == Support::floor) {
        add_rigid(builder, scene_box(pli_vec3_make(50, 1, 50)), pli_vec3_make(0, -1.001f - margin, 0), 0);
    }
    pli_mesh* mesh = make_heavy_sheet(builder, 0, support);
    const scene_soft_def def = heavy_def(velocity_damping, stiffness_under(static_cast<double>(mass)));
    scene_add_soft(builder, mesh, &def);
}

const char* contacts_name(bool has_faces) {
    return has_faces ? "nodes and faces" : "nodes";
}

void add_dropped_balls(std::vector<StabilityCase>& cases, bool sleeps) {
    const struct {
        Support support;
        const char* name;
    } supports[] = {
        {Support::corners, "corners"}, {Support::rim, "rim"}, {Support::hammock, "hammock"}, {Support::floor, "floor"}};
    for (const float mass : {1.0f, 10.0f, 100.0f, 1000.0f}) {
        for (const auto& support : supports) {
            for (const bool has_faces : {false, true}) {
                for (const int rate : {30, 60, 120}) {
                    char name[80];
                    std::snprintf(name, sizeof name, "ball of %g kg, %s, %s, 1/%d s", static_cast<double>(mass),
                                  support.name, contacts_name(has_faces), rate);
                    StabilityCase made = heavy_case(name, "stretch, %");
                    const float step = 1 / static_cast<float>(rate);
                    made.build = [=](scene_builder* builder) {
                        build_ball_on_sheet(builder, support.support, mass, 0.2f, damping_of(damping, step));
                    };
                    made.step_seconds = [step](int) { return step; };
                    made.substeps = substeps_of(step);
                    made.has_face_contacts = has_faces;
                    if (support.support != Support::floor) { made.tethered = {Column::position_based, Column::xpbd}; }
                    made.sleeps = sleeps;
                    damp_rigids(made, damping);
                    HeavyRules rules;
                    rules.figure_from = end_seconds - 1;
                    rules.lying = 0;
                    watch_by(made, rules);
                    cases.push_back(made);
                }
            }
        }
    }
}

// Nothing takes energy but the solver.
void add_trampolines(std::vector<StabilityCase>& cases) {
    for (const float mass : {5.0f, 100.0f}) {
        for (const bool has_faces : {false, true}) {
            char name[80];
            std::snprintf(name, sizeof name, "trampoline, ball of %g kg, %s", static_cast<double>(mass),
                          contacts_name(has_faces));
            StabilityCase made = heavy_case(name, "stretch, %");
            made.build = [mass](scene_builder* builder) { build_ball_on_sheet(builder, Support::rim, mass, 1.5f, 0); };
            made.seconds = 5;
            made.has_face_contacts = has_faces;
            made.tethered = {Column::position_based, Column::xpbd};
            damp_rigids(made, 0);
            HeavyRules rules;
            rules.lying = rules.never_higher = 0;
            rules.rests = false;
            watch_by(made, rules);
            cases.push_back(made);
        }
    }
}

// --------------------------------------------------------------------------------------- a box that lies on cloth

constexpr float small_box_half_width = 0.15f;

void build_box_on_cloth(scene_builder* builder, float gap, float yaw) {
    scene_rigid_def box = scene_rigid_def_default();
    box.name = "box";
    box.shape = scene_box(pli_vec3_make(small_box_half_width, small_box_half_width, small_box_half_width));
    box.mass = 1;
    box.pose.origin = pli_vec3_make(0, 2 * margin + small_box_half_width + gap, 0);
    const float c = std::cos(yaw), s = std::sin(yaw);
    box.pose.rotation.rows[0] = pli_vec3_make(c, 0, s);
    box.pose.rotation.rows[2] = pli_vec3_make(-s, 0, c);
    scene_add_rigid(builder, &box);
    add_ground(builder);
    pli_mesh* mesh = make_heavy_sheet(builder, margin + 0.001f, Support::floor);
    const scene_soft_def def = heavy_def(little_damping, stiffness_under(1));
    scene_add_soft(builder, mesh, &def);
}

void add_lying_boxes(std::vector<StabilityCase>& cases, int rest_steps) {
    constexpr int starts = 8, most_steps = 3000; // 50 s
    constexpr double settled = 5;                // s
    for (const bool has_faces : {false, true}) {
        for (int start = 0; start < starts; ++start) {
            StabilityCase made = heavy_case(std::string("box on cloth, ") + contacts_name(has_faces) + ", start " +
                                                std::to_string(start + 1),
                                            "wandering, mm");
            const float gap = 0.05f + 0.005f * static_cast<float>(start), yaw = 0.1f * static_cast<float>(start);
            made.build = [gap, yaw](scene_builder* builder) { build_box_on_cloth(builder, gap, yaw); };
            made.seconds = static_cast<float>(std::min(rest_steps, most_steps)) * frame_seconds;
            made.has_face_contacts = has_faces;
            damp_rigids(made, 0);
            HeavyRules rules;
            rules.lying = rules.stays.rigid = 0;
            rules.stays_from = settled;
            watch_by(made, rules);
            cases.push_back(made);
        }
    }
}

// -------------------------------------------------------------------------------------------------------- ropes

// Level at first, the weight at its free end.
void add_weights(std::vector<StabilityCase>& cases, bool sleeps) {
    constexpr float rope_mass = 0.1f, length = 2, radius = 0.1f;
    constexpr int inner_nodes = 18;
    for (const int ratio : {1, 10, 100, 1000}) {
        StabilityCase made = heavy_case("rope with a weight, masses 1 : " + std::to_string(ratio), "stretch, %");
        made.build = [ratio](scene_builder* builder) {
            const float mass = rope_mass * static_cast<float>(ratio);
            pli_mesh* mesh = nullptr;
            scene_check(builder,
                        pli_mesh_create_rope(scene_context(builder), pli_vec3_make(0, 0, 0),
                                             pli_vec3_make(length, 0, 0), inner_nodes, PLI_ROPE_PIN_FIRST, &mesh));
            scene_check(builder, pli_mesh_set_total_mass(mesh, rope_mass));
            const int weight = add_rigid(builder, scene_sphere(radius), pli_vec3_make(length + radius, 0, 0), mass);
            // A link gets longer by 1 % under the weight.
            const scene_soft_def def = heavy_def(damping, 1e4 * static_cast<double>(mass));
            scene_add_anchor(builder, scene_add_soft(builder, mesh, &def), inner_nodes + 1, weight, true, 1);
        };
        made.tethered = {Column::position_based, Column::xpbd};
        made.sleeps = sleeps;
        damp_rigids(made, damping);
        HeavyRules rules;
        rules.has_passage = false;
        rules.figure_from = end_seconds - 1;
        watch_by(made, rules);
        cases.push_back(made);
    }
}

// ------------------------------------------------------------------------------------------------ anchors at speed

struct Motion {
    const char* name;
    pli_vec3 velocity, angular_velocity;
};

// Half a second at rest, two in motion, half a second at rest.
void build_cape(scene_builder* builder, const Motion& motion) {
    constexpr int columns = 40, rows = 30;
    constexpr float width = 1.2f, length = 1, height = 2;
    scene_rigid_def box = scene_rigid_def_default();
    box.name = "box";
    box.shape = scene_box(pli_vec3_make(0.5f * width, 0.2f, 0.2f));
    box.pose.origin = pli_vec3_make(0, height, 0);
    box.is_kinematic = true;
    const int rigid = scene_add_rigid(builder, &box);
    scene_move_rigid(builder, rigid, 30, 150, motion.velocity, motion.angular_velocity);
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-0.5f * width, height, 0.2f + margin);
    def.corner_10 = pli_vec3_make(0.5f * width, height, 0.2f + margin);
    def.corner_01 = pli_vec3_make(-0.5f * width, height - length, 0.2f + margin);
    def.corner_11 = pli_vec3_make(0.5f * width, height - length, 0.2f + margin);
    def.columns = columns;
    def.rows = rows;
    def.diagonals = true;
    pli_mesh* mesh = nullptr;
    scene_check(builder, pli_mesh_create_patch(scene_context(builder), &def, &mesh));
    scene_check(builder, pli_mesh_set_total_mass(mesh, 0.5f));
    const scene_soft_def cape = heavy_def(little_damping, stiffness_under(0));
    const int soft = scene_add_soft(builder, mesh, &cape);
    for (int i = 0; i < columns; ++i) {
        scene_add_anchor(builder, soft, i, rigid, true, 1);
    }
}

void add_capes(std::vector<StabilityCase>& cases) {
    const Motion motions[] = {{"at 6 m/s", {6, 0, 0}, {0, 0, 0}},
                              {"at 50 m/s", {50, 0, 0}, {0, 0, 0}},
                              {"turning at 20 rad/s", {0, 0, 0}, {0, 20, 0}}};
    for (const Motion& motion : motions) {
        StabilityCase made = heavy_case(std::string("cape ") + motion.name, "lag, mm");
        made.build = [motion](scene_builder* builder) { build_cape(builder, motion); };
        made.seconds = 3;
        made.reach = 120;
        HeavyRules rules;
        rules.has_passage = rules.rests = false;
        rules.has_fast_anchors = true;
        watch_by(made, rules);
        cases.push_back(made);
    }
}

// -------------------------------------------------------------------------------------------------- light sheets

// Falls on a box that stands on the floor and covers it.
void build_light_sheet(scene_builder* builder, float node_mass, float box_mass) {
    constexpr float half_width = 0.3f;
    add_rigid(builder, scene_box(pli_vec3_make(half_width, half_width, half_width)), pli_vec3_make(0, half_width, 0),
              box_mass);
    add_ground(builder);
    const float mass = node_mass * nodes_per_side * nodes_per_side;
    pli_mesh* mesh = make_heavy_sheet(builder, 2 * half_width + 0.2f, Support::floor, mass);
    const scene_soft_def def = heavy_def(damping, static_cast<double>(mass) * stiffness_under(0));
    scene_add_soft(builder, mesh, &def);
}

void add_light_sheets(std::vector<StabilityCase>& cases, bool sleeps) {
    constexpr float heavy_box = 10; // kg
    for (const float box_mass : {0.0f, heavy_box}) {
        for (const bool has_faces : {false, true}) {
            for (const float node_mass : {1e-4f, 1e-5f, 1e-6f}) {
                char name[80];
                std::snprintf(name, sizeof name, "sheet of %.0e kg a node on a %s, %s", static_cast<double>(node_mass),
                              box_mass > 0.0f ? "box of 10 kg" : "static box", contacts_name(has_faces));
                StabilityCase made = heavy_case(name, "wandering, mm");
                made.build = [=](scene_builder* builder) { build_light_sheet(builder, node_mass, box_mass); };
                made.has_face_contacts = has_faces;
                made.sleeps = sleeps;
                damp_rigids(made, damping);
                HeavyRules rules;
                rules.stays.soft = 0;
                rules.stays_from = end_seconds - 5;
                watch_by(made, rules);
                cases.push_back(made);
            }
        }
    }
}

} // namespace

void add_heavy_cases(std::vector<StabilityCase>& cases, const StabilityOptions& options) {
    add_dropped_balls(cases, options.sleeps);
    add_lying_boxes(cases, options.rest_steps);
    add_weights(cases, options.sleeps);
    add_capes(cases);
    add_light_sheets(cases, options.sleeps);
    add_trampolines(cases);
}

} // namespace demos
