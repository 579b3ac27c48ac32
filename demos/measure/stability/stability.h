#ifndef DEMOS_STABILITY_H
#define DEMOS_STABILITY_H

// The stability map: extreme cases, each run by btSoftBody and by the three solvers of Pliant. docs/stability.md says
// what the cases are and when a solver survives one.

#include "engines/engine.h"

#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

namespace demos {

// `implicit` sweeps, `gradients` solves the same system by conjugate gradients.
enum class Column { bt_soft_body, position_based, implicit, gradients, xpbd };
constexpr Column all_columns[] = {Column::bt_soft_body, Column::position_based, Column::implicit, Column::gradients,
                                  Column::xpbd};

const char* column_name(Column column); // "btSoftBody", "position-based", "implicit", "gradients", "xpbd"

enum class Verdict {
    survives,
    refused, // with a clear message, where that is right
    not_finite,
    frozen,         // Pliant has put the body back and stopped it
    gains_energy,   // more than it had and gravity gave
    out_of_reach,   // nodes where they cannot get
    passes_through, // a body, or itself
    never_rests,    // what should lie still moves or creeps
    wanders,        // what lies does not stay where it is
    lags,           // anchored nodes are not where they are held
    hangs,
    crashes
};

const char* verdict_name(Verdict verdict);
bool is_survival(Verdict verdict); // survives or refused

struct Cell {
    Verdict verdict = Verdict::survives;
    double figure = -1; // of the case, after settling; < 0: there is none
    std::string note;   // why; where the verdict is `survives`: what bodies have beside the defaults
    double seconds = 0; // wall time of the cell
};

// What a case says of the end of its run; empty note and `survives` when all is well.
struct Finding {
    Verdict verdict = Verdict::survives;
    double figure = -1;
    std::string note{};
};

// State of a case that looks at every step.
class Watcher {
public:
    virtual ~Watcher() = default;
    virtual void start(const Engine&, Column) {}
    virtual void after_step(const Engine&, int) {}
    // The run need not go on.
    virtual bool is_decided() const { return false; }
    virtual Finding end(const Engine& engine) = 0;
};

struct StabilityCase {
    std::string group, name, figure_name;
    std::function<void(scene_builder*)> build;
    std::function<float(int)> step_seconds{}; // of each step; empty: 1/60 s
    float seconds = 5;                        // simulated
    double more_time = 0;                     // s of wall time beyond the limit of all cells
    double reach = 10;                        // m, how far beyond their bounds at the start nodes can get at most
    double given_energy = 0;                  // J, that the start has beside links and motion (pressure, volume)
    int most_gradients = 1000;                // iterations; as a rule the tolerance ends them before
    std::optional<int> sweeps{}, substeps{};  // of the implicit solver and of XPBD, where the defaults are not enough
    bool has_loose_energy_rule = true;        // false: its watcher has another one, or none holds
    bool is_asked_for_only = false;           // not run when no group is named
    bool has_face_contacts = false;           // faces of Pliant's bodies meet rigid bodies (continuous test)
    bool filter_compression = false;          // of the implicit solver
    int finishing_iterations = 0;             // of its sweeps
    bool smooths_steps = false;               // Pliant's bodies do
    bool sleeps = false;                      // what rests may fall asleep: rigid bodies, and Pliant's
    std::vector<Column> tethered{};           // Pliant's bodies have tethers in these columns
    std::function<void(Engine&)> prepare{};   // before the first step
    std::function<std::unique_ptr<Watcher>()> watch{}; // empty: the figure is the root mean square stretch
};

struct StabilityOptions {
    int rest_steps = 20000; // of the cases at rest
    bool sleeps = true;     // bodies of the cases of heavy bodies that come to rest may fall asleep
    uint64_t seed = 1;      // of the random cases
    int random_count = 100;
    double time_limit = 20; // s of wall time per cell, beside what a case may take more
    int jobs = 1;           // cells that run at the same time
    std::vector<Column> columns{std::begin(all_columns), std::end(all_columns)};
};

// All cases, in the order of the table.
std::vector<StabilityCase> stability_cases(const StabilityOptions& options);

// Runs one cell in a process of its own.
Cell run_cell(const StabilityCase& which, Column column, const StabilityOptions& options);

// Cells by case and wanted column; `done` is called after each one.
std::vector<std::vector<Cell>> run_cells(const std::vector<const StabilityCase*>& cases,
                                         const StabilityOptions& options,
                                         const std::function<void(const StabilityCase&)>& done);

// ------------------------------------------------------------------------------------- for cases of their own

// Replaces positions and velocities of all nodes (velocities empty: at rest). Throws Error.
void set_state(Engine& engine, int soft, const std::vector<pli_vec3>& positions,
               const std::vector<pli_vec3>& velocities);

} // namespace demos
#endif
