#ifndef DEMOS_WORKPREC_SCENE_PARTS_H
#define DEMOS_WORKPREC_SCENE_PARTS_H

// What the scenes of error against run time have in common.

#include "measure/reference/mass_spring.h"
#include "workprec.h"

#include <array>
#include <map>

namespace demos {

// A chain of nodes with links, the ends at their given places; masses of 0 pin.
pli_mesh* make_chain(scene_builder* builder, const std::vector<pli_vec3>& places, const std::vector<float>& masses);

// A grid with both structural links, alternating diagonals and faces. Node of column c and row r: r * columns + c.
struct GridDef {
    int columns = 12, rows = 12;
    std::function<pli_vec3(int column, int row)> place;
    std::function<float(int column, int row)> mass; // 0: pinned
};
pli_mesh* make_grid(scene_builder* builder, const GridDef& grid);

// Settings with a stiffness in N/m; a share of the velocity goes in each step, `damping` per second.
scene_soft_def precision_def(const char* name, float stiffness, float damping, float step_seconds);

// The first soft body of a scene as masses and springs.
reference::Network network_of(const PrecisionScene& which);

// sqrt(mean |x - reference|^2) / diagonal of the bounds at rest.
double position_error(const Engine& engine, const std::vector<reference::Point>& expected);

// An evaluation of the state at the end.
std::function<std::unique_ptr<Evaluation>(const Setting&)>
at_the_end(std::function<std::vector<double>(const Engine&)> errors);

// Distance at the end from the rest of the same masses and springs, and another error where there is one.
std::function<std::unique_ptr<Evaluation>(const Setting&)> against_rest(const PrecisionScene& which,
                                                                        std::function<double(const Engine&)> other);

void add_rope_scenes(std::vector<PrecisionScene>& scenes);
void add_sheet_scenes(std::vector<PrecisionScene>& scenes);
void add_body_scenes(std::vector<PrecisionScene>& scenes);
void add_invariant_scenes(std::vector<PrecisionScene>& scenes);

} // namespace demos
#endif
