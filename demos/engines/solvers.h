#ifndef DEMOS_SOLVERS_H
#define DEMOS_SOLVERS_H

// The one place where the material of a scene, which is described as for btSoftBody, gets the units of the other
// solvers. docs/solvers.md has the formulas.

#include "engine.h"

namespace demos {

// Lets the chosen solver step a new body, with links, tetrahedra and volume as its own constraints. To be called after
// forces were enabled. Throws Error.
void enable_solver(pli_body* body, const SoftRecord& record, const SolverRun& run);

// Self-collision of the kind that the record names, none included. Throws Error.
void enable_self_collision(pli_body* body, const scene_soft_def& def, const SolverRun& run);

// The record in the units of the solver's contacts; contacts of clusters are those of nodes where it has no clusters.
scene_soft_def definition_for_solver(const SoftRecord& record, const SolverRun& run);

// N/m of a link with linear stiffness 1.
double link_stiffness(const SoftRecord& record);

} // namespace demos
#endif
