// Runs one case with one solver and judges it.

#include "child_process.h"
#include "description/function_scene.h"
#include "description/recorder.h"
#include "engines/bullet_engine.h"
#include "engines/pliant_engine.h"
#include "engines/solvers.h"
#include "heavy_checks.h"
#include "measure/measure.h"
#include "stability.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace demos {

const char* column_name(Column column) {
    static const char* const names[] = {"btSoftBody", "position-based", "implicit", "gradients", "xpbd"};
    return names[static_cast<int>(column)];
}

const char* verdict_name(Verdict verdict) {
    static const char* const names[] = {"ok",           "refused",        "NaN",         "frozen",  "gains energy",
                                        "out of reach", "passes through", "never rests", "wanders", "lags",
                                        "hangs",        "crashes"};
    return names[static_cast<int>(verdict)];
}

bool is_survival(Verdict verdict) {
    return verdict == Verdict::survives || verdict == Verdict::refused;
}

void set_state(Engine& engine, int soft, const std::vector<pli_vec3>& positions,
               const std::vector<pli_vec3>& velocities) {
    if (engine.kind() == EngineKind::pliant) {
        auto& pliant = static_cast<PliantEngine&>(engine);
        const pli_status status =
            pli_body_set_state(pliant.body(soft), positions.data(), velocities.empty() ? nullptr : velocities.data());
        if (status != PLI_OK) { throw Error(pli_last_error(pliant.bridge().context())); }
        return;
    }
    btSoftBody& body = static_cast<BulletEngine&>(engine).body(soft);
    body.updateConstants();
    body.m_bUpdateRtCst = false; // else the first step would take the new shape for the shape at rest
    for (int i = 0; i < body.m_nodes.size(); ++i) {
        const auto index = static_cast<size_t>(i);
        body.m_nodes[i].m_x = body.m_nodes[i].m_q = to_bullet(positions[index]);
        body.m_nodes[i].m_v = velocities.empty() ? btVector3(0, 0, 0) : to_bullet(velocities[index]);
    }
    body.updateNormals();
}

namespace {

// ------------------------------------------------------------------------------------------------ making a case

EngineOptions options_of(const StabilityCase& which, Column column) {
    EngineOptions options;
    options.solver.filter_compression = which.filter_compression;
    options.unguarded = true;
    if (column == Column::implicit) {
        options.solver.kind = SolverKind::implicit;
        options.solver.iterations = which.sweeps;
        options.solver.finishing_iterations = which.finishing_iterations;
    }
    if (column == Column::gradients) {
        options.solver.kind = SolverKind::implicit;
        options.solver.implicit_method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
        options.solver.iterations = which.most_gradients;
    }
    if (column == Column::xpbd) {
        options.solver.kind = SolverKind::xpbd;
        options.solver.substeps = which.substeps;
    }
    if (column == Column::position_based) { options.solver.kind = SolverKind::position_based; }
    return options;
}

template <typename Enable> void enable_for_all(Engine& engine, const Enable& enable) {
    if (engine.kind() != EngineKind::pliant) { return; }
    auto& pliant = static_cast<PliantEngine&>(engine);
    for (int i = 0; i < pliant.soft_count(); ++i) {
        if (enable(pliant.body(i), static_cast<size_t>(i)) != PLI_OK) {
            throw Error(pli_last_error(pliant.bridge().context()));
        }
    }
}

bool is_tethered(const StabilityCase& which, Column column) {
    return std::find(which.tethered.begin(), which.tethered.end(), column) != which.tethered.end();
}

// What bodies have beside the defaults; empty: nothing.
std::string extras_of(const StabilityCase& which, Column column) {
    if (column == Column::bt_soft_body) { return ""; }
    const bool is_implicit = column == Column::implicit || column == Column::gradients;
    if (is_tethered(which, column) && which.has_face_contacts) { return "with tethers and contacts of faces"; }
    if (is_tethered(which, column)) { return "with tethers"; }
    if (which.has_face_contacts) { return "with contacts of faces"; }
    if (which.smooths_steps) { return "with step smoothing"; }
    return which.filter_compression && is_implicit ? "with filtered compression" : "";
}

void enable_extras(Engine& engine, const StabilityCase& which, Column column) {
    if (which.has_face_contacts) {
        enable_for_all(engine, [&engine](pli_body* body, size_t index) {
            pli_rigid_face_contacts_def def = pli_rigid_face_contacts_def_default();
            def.friction = engine.description().softs[index].def.rigid_contacts.friction;
            return pli_body_enable_rigid_face_contacts(body, &def);
        });
    }
    if (which.smooths_steps) {
        enable_for_all(engine, [](pli_body* body, size_t) { return pli_body_enable_step_smoothing(body); });
    }
    if (which.sleeps) {
        enable_for_all(engine, [](pli_body* body, size_t) { return pli_body_enable_sleep(body, nullptr); });
    }
    if (is_tethered(which, column)) {
        enable_for_all(engine, [](pli_body* body, size_t) {
            const pli_tethers_def def = pli_tethers_def_default();
            return pli_body_enable_tethers(body, &def);
        });
    }
}

bool is_frozen(const Engine& engine) {
    if (engine.kind() != EngineKind::pliant) { return false; }
    const auto& pliant = static_cast<const PliantEngine&>(engine);
    for (int i = 0; i < pliant.soft_count(); ++i) {
        if (pli_body_is_frozen(pliant.body(i))) { return true; }
    }
    return false;
}

// ---------------------------------------------------------------------------------------------------- the energy

struct Energy {
    double kinetic = 0, potential = 0; // J, soft and rigid bodies; potential: of gravity
    double mass = 0;
};

Energy energy_of(const Engine& engine) {
    Energy energy;
    const pli_vec3 gravity = engine.description().gravity;
    const auto add = [&](double mass, pli_vec3 position, pli_vec3 velocity) {
        energy.kinetic += 0.5 * mass * dot(velocity, velocity);
        energy.potential -= mass * dot(gravity, position);
        energy.mass += mass;
    };
    for (size_t i = 0; i < engine.description().softs.size(); ++i) {
        const SoftState state = engine.soft(static_cast<int>(i));
        for (size_t node = 0; node < state.positions.size(); ++node) {
            if (!(state.inverse_masses[node] > 0.0f)) { continue; }
            add(1.0 / static_cast<double>(state.inverse_masses[node]), state.positions[node], state.velocities[node]);
        }
    }
    for (int i = 0; i < engine.rigid_count(); ++i) {
        const double mass = static_cast<double>(engine.rigid_record(i).mass);
        if (!(mass > 0.0)) { continue; }
        const RigidState rigid = engine.rigid(i);
        add(mass, rigid.pose.origin, rigid.linear_velocity);
    }
    return energy;
}

// Of links that do not have their length, J.
double link_energy(const Engine& engine) {
    double energy = 0;
    for (size_t i = 0; i < engine.description().softs.size(); ++i) {
        const double stiffness = link_stiffness(engine.description().softs[i]);
        const SoftState state = engine.soft(static_cast<int>(i));
        for (size_t link = 0; link < state.rest_lengths.size(); ++link) {
            const pli_vec3 a = state.positions[static_cast<size_t>(state.link_nodes[2 * link])];
            const pli_vec3 b = state.positions[static_cast<size_t>(state.link_nodes[2 * link + 1])];
            const pli_vec3 d = pli_vec3_sub(b, a);
            const double stretch = std::sqrt(dot(d, d)) - static_cast<double>(state.rest_lengths[link]);
            energy += 0.5 * stiffness * stretch * stretch;
        }
    }
    return energy;
}

// --------------------------------------------------------------------------------------------------- the verdict

constexpr double rounding_speed = 0.01; // m/s, that rounding may give to a body at rest

class Judge {
public:
    Judge(const StabilityCase& which, const Engine& engine)
        : which_(which), start_(energy_of(engine)), bounds_(empty_bounds()) {
        for (size_t i = 0; i < engine.description().softs.size(); ++i) {
            for (const pli_vec3 p : engine.soft(static_cast<int>(i)).positions) {
                extend_bounds(bounds_, p);
            }
        }
        // A share for contacts and anchors that put bodies where they belong.
        const double size = bounds_diagonal(bounds_) + 0.01;
        const pli_vec3 gravity = engine.description().gravity;
        slack_ = 0.1 * start_.mass * std::sqrt(dot(gravity, gravity)) * size + which.given_energy +
                 link_energy(engine) + 0.5 * start_.mass * rounding_speed * rounding_speed;
    }

    // False when the case is lost.
    bool look(const Engine& engine, int step, Cell& cell) const {
        const auto lose = [&](Verdict verdict, const std::string& note) {
            cell.verdict = verdict;
            cell.note = note + " in step " + std::to_string(step);
            return false;
        };
        const Measures measures = measure(engine);
        if (is_frozen(engine)) { return lose(Verdict::frozen, "put back and stopped"); }
        if (!measures.finite) { return lose(Verdict::not_finite, "not finite"); }
        pli_bounds now = empty_bounds();
        for (size_t i = 0; i < engine.description().softs.size(); ++i) {
            for (const pli_vec3 p : engine.soft(static_cast<int>(i)).positions) {
                extend_bounds(now, p);
            }
        }
        const double out = std::max(std::max(beyond(now.min.x, bounds_.min.x, now.max.x, bounds_.max.x),
                                             beyond(now.min.y, bounds_.min.y, now.max.y, bounds_.max.y)),
                                    beyond(now.min.z, bounds_.min.z, now.max.z, bounds_.max.z));
        if (out > which_.reach) { return lose(Verdict::out_of_reach, figure_text(out) + " m out"); }
        const Energy energy = energy_of(engine);
        const double had = start_.kinetic + start_.potential - energy.potential;
        if (which_.has_loose_energy_rule && energy.kinetic > 1.25 * std::max(had, 0.0) + slack_) {
            return lose(Verdict::gains_energy, figure_text(energy.kinetic) + " J of " +
                                                   figure_text(1.25 * std::max(had, 0.0) + slack_) + " J");
        }
        return true;
    }

private:
    static double beyond(float low, float low_start, float high, float high_start) {
        return std::max(static_cast<double>(low_start) - static_cast<double>(low),
                        static_cast<double>(high) - static_cast<double>(high_start));
    }
    static std::string figure_text(double value) {
        char text[40];
        std::snprintf(text, sizeof text, "%.3g", value);
        return text;
    }

    const StabilityCase& which_;
    Energy start_;
    pli_bounds bounds_;
    double slack_ = 0;
};

Cell run_here(const StabilityCase& which, Column column) {
    Cell cell;
    const FunctionScene source(which.name, which.build);
    std::unique_ptr<Description> description;
    std::unique_ptr<Engine> engine;
    try {
        description = Description::build(source, {});
        engine = make_engine(column == Column::bt_soft_body ? EngineKind::bullet : EngineKind::pliant, *description,
                             options_of(which, column));
        enable_extras(*engine, which, column);
        if (which.prepare) { which.prepare(*engine); }
    } catch (const Error& error) {
        cell.verdict = Verdict::refused;
        cell.note = error.what();
        return cell;
    }
    const Judge judge(which, *engine);
    const std::unique_ptr<Watcher> watcher = which.watch ? which.watch() : nullptr;
    if (watcher != nullptr) { watcher->start(*engine, column); }
    double time = 0;
    for (int step = 1; time < static_cast<double>(which.seconds) - 1e-4; ++step) {
        if (which.step_seconds) { engine->set_step_seconds(which.step_seconds(step)); }
        time += static_cast<double>(which.step_seconds ? which.step_seconds(step) : frame_seconds);
        engine->step();
        if ((step < 2000 || step % 100 == 0) && !judge.look(*engine, step, cell)) { return cell; }
        if (watcher == nullptr) { continue; }
        watcher->after_step(*engine, step);
        if (watcher->is_decided()) { break; }
    }
    if (watcher == nullptr) {
        const Measures measures = measure(*engine);
        if (measures.links > 0) { cell.figure = measures.rms_stretch; }
    } else {
        const Finding finding = watcher->end(*engine);
        cell.verdict = finding.verdict;
        cell.figure = finding.figure;
        cell.note = finding.note;
    }
    if (cell.verdict == Verdict::survives) { cell.note = extras_of(which, column); }
    return cell;
}

// ------------------------------------------------------------------------------------------------- to and fro

std::string to_text(const Cell& cell) {
    char head[64];
    std::snprintf(head, sizeof head, "%d %.17g ", static_cast<int>(cell.verdict), cell.figure);
    return head + cell.note;
}

bool from_text(const std::string& text, Cell& cell) {
    char* end = nullptr;
    const long verdict = std::strtol(text.c_str(), &end, 10);
    if (end == text.c_str() || verdict < 0 || verdict > static_cast<long>(Verdict::crashes)) { return false; }
    cell.verdict = static_cast<Verdict>(verdict);
    cell.figure = std::strtod(end, &end);
    cell.note = *end == ' ' ? end + 1 : "";
    return true;
}

} // namespace

static Cell cell_of(const ChildAnswer& answer, double limit) {
    Cell cell;
    if (answer.end == ChildEnd::timed_out) {
        cell.verdict = Verdict::hangs;
        cell.note = "no end within " + std::to_string(static_cast<int>(limit)) + " s";
    } else if (answer.end == ChildEnd::crashed || !from_text(answer.text, cell)) {
        cell.verdict = Verdict::crashes;
        cell.note = answer.signal != 0 ? strsignal(answer.signal) : "no answer";
    }
    cell.seconds = answer.seconds;
    return cell;
}

std::vector<std::vector<Cell>> run_cells(const std::vector<const StabilityCase*>& cases,
                                         const StabilityOptions& options,
                                         const std::function<void(const StabilityCase&)>& done) {
    const size_t columns = options.columns.size();
    std::vector<ChildWork> works;
    for (const StabilityCase* which : cases) {
        for (const Column column : options.columns) {
            works.push_back(
                {[which, column] { return to_text(run_here(*which, column)); }, options.time_limit + which->more_time});
        }
    }
    std::vector<std::vector<Cell>> rows(cases.size(), std::vector<Cell>(columns));
    run_in_children(works, options.jobs, [&](size_t index, const ChildAnswer& answer) {
        rows[index / columns][index % columns] = cell_of(answer, works[index].seconds);
        done(*cases[index / columns]);
    });
    return rows;
}

Cell run_cell(const StabilityCase& which, Column column, const StabilityOptions& options) {
    const double limit = options.time_limit + which.more_time;
    return cell_of(run_in_child([&] { return to_text(run_here(which, column)); }, limit), limit);
}

} // namespace demos
