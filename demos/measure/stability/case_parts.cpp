#include "case_parts.h"

#include <algorithm>
#include <cmath>

namespace demos {

pli_mesh* make_sheet(scene_builder* builder, const SheetDef& sheet) {
    const float s = sheet.half_width;
    const auto corner = [&](float x, float y) {
        return pli_vec3_add(sheet.center,
                            sheet.is_upright ? pli_vec3_make(x * s, y * s, 0) : pli_vec3_make(x * s, 0, y * s));
    };
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = corner(-1, -1);
    def.corner_10 = corner(1, -1);
    def.corner_01 = corner(-1, 1);
    def.corner_11 = corner(1, 1);
    def.columns = def.rows = sheet.columns;
    def.pins = sheet.pins;
    def.diagonals = true;
    pli_mesh* mesh = nullptr;
    if (!scene_check(builder, pli_mesh_create_patch(scene_context(builder), &def, &mesh))) { return nullptr; }
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    const auto moving = std::count_if(view.inverse_masses, view.inverse_masses + view.node_count,
                                      [](float inverse_mass) { return inverse_mass > 0.0f; });
    scene_check(builder, pli_mesh_set_total_mass(mesh, sheet.node_mass * static_cast<float>(moving)));
    return mesh;
}

pli_mesh* make_ball(scene_builder* builder, pli_vec3 center, float radius, int nodes, float mass) {
    pli_mesh* mesh = nullptr;
    const pli_vec3 radii = pli_vec3_make(radius, radius, radius);
    if (!scene_check(builder, pli_mesh_create_ellipsoid(scene_context(builder), center, radii, nodes, &mesh))) {
        return nullptr;
    }
    scene_check(builder, pli_mesh_set_total_mass(mesh, mass));
    return mesh;
}

pli_mesh* make_cube(scene_builder* builder, float mass) {
    pli_mesh* mesh = scene_tetra_mesh(builder, "tetra_cube");
    scene_check(builder, pli_mesh_set_total_mass(mesh, mass));
    return mesh;
}

scene_soft_def case_def(const char* name) {
    scene_soft_def def = scene_soft_def_default();
    def.name = name;
    def.collision_margin = 0.02f;
    def.solver.position_iterations = case_iterations;
    return def;
}

// The rule of the solvers with units (solvers.cpp), turned around: a linear stiffness above 1 does not exist.
void set_stiffness(scene_builder* builder, pli_mesh* mesh, scene_soft_def& def, float stiffness) {
    if (mesh == nullptr) { return; }
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    const auto moving = std::count_if(view.inverse_masses, view.inverse_masses + view.node_count,
                                      [](float inverse_mass) { return inverse_mass > 0.0f; });
    const float mass = moving > 0 ? pli_mesh_total_mass(mesh) / static_cast<float>(moving) : 1.0f;
    const float rate = static_cast<float>(case_iterations) * mass / (frame_seconds * frame_seconds);
    const pli_material material = {std::clamp(stiffness / rate, 1e-6f, 1.0f)};
    scene_check(builder, pli_mesh_set_material(mesh, 0, &material));
    def.link_stiffness = stiffness / material.linear_stiffness;
}

int add_sheet(scene_builder* builder, const SheetDef& sheet, float margin) {
    pli_mesh* mesh = make_sheet(builder, sheet);
    scene_soft_def def = case_def("sheet");
    def.collision_margin = margin;
    set_stiffness(builder, mesh, def, sheet.stiffness);
    return scene_add_soft(builder, mesh, &def);
}

int add_rigid(scene_builder* builder, scene_shape shape, pli_vec3 position, float mass) {
    scene_rigid_def def = scene_rigid_def_default();
    def.name = "rigid";
    def.shape = shape;
    def.mass = mass;
    def.pose.origin = position;
    return scene_add_rigid(builder, &def);
}

void add_ground(scene_builder* builder) {
    add_rigid(builder, scene_box(pli_vec3_make(50, 1, 50)), pli_vec3_make(0, -1, 0), 0);
}

std::vector<pli_vec3> positions_of(const Engine& engine, int soft) {
    return engine.soft(soft).positions;
}

namespace {

class EndWatcher final : public Watcher {
public:
    explicit EndWatcher(std::function<Finding(const Engine&)> finding) : finding_(std::move(finding)) {}
    Finding end(const Engine& engine) override { return finding_(engine); }

private:
    std::function<Finding(const Engine&)> finding_;
};

} // namespace

std::function<std::unique_ptr<Watcher>()> at_end(std::function<Finding(const Engine&)> finding) {
    return [finding] { return std::make_unique<EndWatcher>(finding); };
}

std::vector<StabilityCase> stability_cases(const StabilityOptions& options) {
    std::vector<StabilityCase> cases;
    add_material_cases(cases);
    add_step_cases(cases);
    add_shape_cases(cases);
    add_contact_cases(cases);
    add_rest_cases(cases, options.rest_steps);
    add_input_cases(cases);
    add_heavy_cases(cases, options);
    add_random_cases(cases, options.seed, options.random_count);
    return cases;
}

} // namespace demos
