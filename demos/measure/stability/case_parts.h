#ifndef DEMOS_CASE_PARTS_H
#define DEMOS_CASE_PARTS_H

// What several cases of the stability map have in common: bodies to put together, and watchers.

#include "stability.h"

namespace demos {

// A square sheet with both structural links and one diagonal per cell, level around a center.
struct SheetDef {
    pli_vec3 center{0, 0, 0};
    float half_width = 0.5f;
    int columns = 12;
    int pins = 0;
    float node_mass = 0.01f; // kg
    float stiffness = 1000;  // N/m; btSoftBody gets what comes nearest
    bool is_upright = false; // in the plane of x and y
};

constexpr int case_iterations = 10; // of position-based solvers

pli_mesh* make_sheet(scene_builder* builder, const SheetDef& sheet);
pli_mesh* make_ball(scene_builder* builder, pli_vec3 center, float radius, int nodes, float mass);
pli_mesh* make_cube(scene_builder* builder, float mass);

// With `case_iterations`, and this stiffness for links where it is given (N/m).
scene_soft_def case_def(const char* name);
void set_stiffness(scene_builder* builder, pli_mesh* mesh, scene_soft_def& def, float stiffness);
int add_sheet(scene_builder* builder, const SheetDef& sheet, float margin);

int add_rigid(scene_builder* builder, scene_shape shape, pli_vec3 position, float mass);
void add_ground(scene_builder* builder); // its top is at y = 0

std::vector<pli_vec3> positions_of(const Engine& engine, int soft);

// A watcher that only looks at the end.
std::function<std::unique_ptr<Watcher>()> at_end(std::function<Finding(const Engine&)> finding);

// The cases by subject, in the order of the table.
void add_material_cases(std::vector<StabilityCase>& cases);
void add_step_cases(std::vector<StabilityCase>& cases);
void add_shape_cases(std::vector<StabilityCase>& cases);
void add_contact_cases(std::vector<StabilityCase>& cases);
void add_rest_cases(std::vector<StabilityCase>& cases, int steps);
void add_input_cases(std::vector<StabilityCase>& cases);
void add_random_cases(std::vector<StabilityCase>& cases, uint64_t seed, int count);
void add_heavy_cases(std::vector<StabilityCase>& cases, const StabilityOptions& options);

} // namespace demos
#endif
