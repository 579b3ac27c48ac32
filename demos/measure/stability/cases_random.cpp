// Random extreme cases: bodies, materials, forces and steps that nobody would choose together. Each has its number; the
// seed and the number make the case.

#include "case_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

namespace demos {

namespace {

// The same numbers from every library.
class Dice {
public:
    Dice(uint64_t seed, int number) : bits_(static_cast<uint32_t>(seed * 1000003u + static_cast<uint32_t>(number))) {
        bits_.discard(16);
    }
    float share() { return static_cast<float>(bits_() >> 8) * (1.0f / 16777216.0f); }
    float between(float low, float high) { return low + (high - low) * share(); }
    float magnitude(float low, float high) { return low * std::pow(high / low, share()); }
    bool chance(float odds) { return share() < odds; }
    int below(int count) { return std::min(static_cast<int>(share() * static_cast<float>(count)), count - 1); }
    pli_vec3 vector(float length) {
        const float x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        return pli_vec3_make(length * x, length * y, length * z);
    }

private:
    std::mt19937 bits_;
};

enum class Kind { sheet, upright_sheet, ball };

struct RandomCase {
    Kind kind = Kind::sheet;
    int columns = 0, pins = 0, ball_nodes = 0;
    float node_mass = 0, stiffness = 0;
    float height = 0;
    pli_vec3 velocity{};
    bool has_box = false;
    scene_soft_def def{};
    float steps[2] = {frame_seconds, frame_seconds}; // in turn, each for `turn` steps
    int turn = 1;
};

void roll_air(Dice& dice, scene_soft_def& def) {
    def.aero.model = static_cast<pli_aero_model>(dice.below(7));
    def.aero.lift = dice.chance(0.6f) ? dice.magnitude(0.01f, 5000) : 0;
    def.aero.drag = dice.chance(0.8f) ? dice.magnitude(0.01f, 5000) : 0;
    if (dice.chance(0.7f)) { def.aero.wind = dice.vector(dice.magnitude(0.1f, 30)); }
}

void roll_steps(Dice& dice, RandomCase& made) {
    made.steps[0] = made.steps[1] = dice.chance(0.5f) ? frame_seconds : dice.magnitude(1.0f / 480, 1.0f / 15);
    if (!dice.chance(0.3f)) { return; }
    made.steps[0] = dice.magnitude(1.0f / 60, 1.0f / 15);
    made.steps[1] = dice.magnitude(1.0f / 480, 1.0f / 60);
    made.turn = 1 + dice.below(8);
}

RandomCase roll(uint64_t seed, int number) {
    Dice dice(seed, number);
    RandomCase made;
    made.kind = static_cast<Kind>(dice.below(3));
    made.columns = 5 + dice.below(12);
    made.ball_nodes = 40 + dice.below(160);
    made.node_mass = dice.magnitude(1e-5f, 1);
    made.stiffness = dice.magnitude(1, 1e6f) * std::sqrt(made.node_mass);
    made.height = dice.between(0.6f, 1.5f);
    if (dice.chance(0.5f)) { made.velocity = pli_vec3_make(dice.between(-5, 5), -dice.between(0, 20), 0); }
    made.has_box = dice.chance(0.4f);
    if (made.kind != Kind::ball && dice.chance(0.5f)) { made.pins = 1 + dice.below(15); }
    scene_soft_def& def = made.def = case_def("random");
    def.solver.velocity_damping = dice.chance(0.5f) ? 0 : dice.between(0, 0.05f);
    def.rigid_contacts.friction = dice.share();
    if (dice.chance(0.6f)) { roll_air(dice, def); }
    if (made.kind == Kind::ball && dice.chance(0.7f)) { def.pressure = dice.magnitude(1e-3f, 1e3f); }
    if (made.kind == Kind::ball && dice.chance(0.3f)) { def.volume_conservation = dice.magnitude(1e-2f, 1e6f); }
    roll_steps(dice, made);
    return made;
}

constexpr float half_width = 0.5f, ball_radius = 0.4f, floor_half_width = 50;

// Wind may have carried it farther.
bool is_over_floor(pli_vec3 x) {
    return std::fabs(x.x) < floor_half_width && std::fabs(x.z) < floor_half_width;
}

void build_random(scene_builder* builder, const RandomCase& made) {
    add_rigid(builder, scene_box(pli_vec3_make(floor_half_width, 10, floor_half_width)), pli_vec3_make(0, -10, 0), 0);
    if (made.has_box) { add_rigid(builder, scene_box(pli_vec3_make(0.3f, 0.2f, 0.3f)), pli_vec3_make(0, 0.2f, 0), 0); }
    pli_mesh* mesh = nullptr;
    if (made.kind == Kind::ball) {
        mesh = make_ball(builder, pli_vec3_make(0, made.height + ball_radius, 0), ball_radius, made.ball_nodes,
                         made.node_mass * static_cast<float>(made.ball_nodes));
    } else {
        SheetDef sheet;
        sheet.is_upright = made.kind == Kind::upright_sheet;
        sheet.center = pli_vec3_make(0, made.height + (sheet.is_upright ? half_width : 0.0f), 0);
        sheet.half_width = half_width;
        sheet.columns = made.columns;
        sheet.pins = made.pins;
        sheet.node_mass = made.node_mass;
        mesh = make_sheet(builder, sheet);
    }
    scene_soft_def def = made.def;
    set_stiffness(builder, mesh, def, made.stiffness);
    const int soft = scene_add_soft(builder, mesh, &def);
    if (made.pins == 0) { scene_set_velocity(builder, soft, made.velocity); }
}

// ------------------------------------------------------------------------------------------------------- judging

double square(pli_vec3 v) {
    return static_cast<double>(v.x) * static_cast<double>(v.x) + static_cast<double>(v.y) * static_cast<double>(v.y) +
           static_cast<double>(v.z) * static_cast<double>(v.z);
}

// What the nodes of soft body 0 may have of kinetic energy: what they had, what gravity gave, and no more than forces
// give: wind up to three times its speed, a gas what its volume has changed by, conservation of volume the square of
// that. And what springs that it has stretched give back when a sail luffs: the most that they have had in them, but no
// more than the wind can hold. All of it twice, since bodies that swing and bounce are steps off.
class ForceWatcher final : public Watcher {
public:
    explicit ForceWatcher(const RandomCase& made) : made_(made) {}

    void start(const Engine& engine, Column) override {
        const State now = look(engine);
        start_ = now;
        least_volume_ = most_volume_ = std::max(now.volume, 1e-6);
        rest_volume_ = now.volume;
    }

    void after_step(const Engine& engine, int step) override {
        if (is_decided()) { return; }
        const State now = look(engine);
        least_volume_ = std::min(least_volume_, std::max(now.volume, 1e-3 * rest_volume_));
        most_volume_ = std::max(most_volume_, now.volume);
        work_ = std::max(work_, start_.potential - now.potential);
        most_elastic_ = std::max(most_elastic_, now.elastic);
        const double may = allowed();
        figure_ = std::max(figure_, 100 * now.kinetic / may);
        if (now.kinetic > may) { lose(Verdict::gains_energy, now.kinetic, may, step); }
    }
    bool is_decided() const override { return lost_.verdict != Verdict::survives; }
    Finding end(const Engine& engine) override {
        const double lowest = look(engine).lowest;
        if (!is_decided() && lowest < -0.3) { lose(Verdict::passes_through, lowest, -0.3, 0); }
        if (is_decided()) { return lost_; }
        return {Verdict::survives, figure_, ""};
    }

private:
    struct State {
        double kinetic = 0, potential = 0, elastic = 0, mass = 0, volume = 0, lowest = 1e9;
    };

    State look(const Engine& engine) const {
        const SoftState soft = engine.soft(0);
        const pli_vec3 gravity = engine.description().gravity;
        State state;
        for (size_t i = 0; i < soft.positions.size(); ++i) {
            if (!(soft.inverse_masses[i] > 0.0f)) { continue; }
            const double mass = 1 / static_cast<double>(soft.inverse_masses[i]);
            state.kinetic += 0.5 * mass * square(soft.velocities[i]);
            state.potential -= mass * static_cast<double>(pli_vec3_dot(gravity, soft.positions[i]));
            state.mass += mass;
            if (is_over_floor(soft.positions[i])) {
                state.lowest = std::min(state.lowest, static_cast<double>(soft.positions[i].y));
            }
        }
        for (size_t link = 0; link < soft.rest_lengths.size(); ++link) {
            const pli_vec3 a = soft.positions[static_cast<size_t>(soft.link_nodes[2 * link])];
            const pli_vec3 b = soft.positions[static_cast<size_t>(soft.link_nodes[2 * link + 1])];
            const double stretch = std::sqrt(square(pli_vec3_sub(b, a))) - static_cast<double>(soft.rest_lengths[link]);
            state.elastic += 0.5 * static_cast<double>(made_.stiffness) * stretch * stretch;
        }
        state.volume = std::fabs(volume_of(engine, soft));
        return state;
    }

    static double volume_of(const Engine& engine, const SoftState& soft) {
        const pli_mesh_view mesh = pli_mesh_get_view(engine.description().softs[0].mesh.get());
        double sum = 0;
        for (int i = 0; i < mesh.face_count; ++i) {
            const int* nodes = mesh.faces[i].nodes;
            const pli_vec3 a = soft.positions[static_cast<size_t>(nodes[0])];
            const pli_vec3 b = soft.positions[static_cast<size_t>(nodes[1])];
            const pli_vec3 c = soft.positions[static_cast<size_t>(nodes[2])];
            sum += static_cast<double>(pli_vec3_dot(a, pli_vec3_cross(b, c))) / 6;
        }
        return sum;
    }

    // J, in a row of links as long as the sheet is wide that carries what stops all nodes in a step.
    double elastic_by_wind() const {
        const double dt = static_cast<double>(std::min(made_.steps[0], made_.steps[1]));
        const double force_squared = start_.mass * start_.mass * square(made_.def.aero.wind) / (dt * dt);
        return 0.5 * made_.columns * force_squared / static_cast<double>(made_.stiffness);
    }

    double allowed() const {
        const scene_soft_def& def = made_.def;
        double sum = start_.kinetic + work_ + 0.1 * start_.mass * 10;
        if (def.aero.lift > 0.0f || def.aero.drag > 0.0f) {
            sum += 0.5 * start_.mass * 9 * square(def.aero.wind) + std::min(most_elastic_, elastic_by_wind());
        }
        if (def.pressure > 0.0f) {
            sum += 2 * static_cast<double>(def.pressure) * std::log(most_volume_ / least_volume_);
        }
        const double change = std::max(most_volume_ - rest_volume_, rest_volume_ - least_volume_);
        sum += static_cast<double>(def.volume_conservation) * change * change;
        return 2 * sum;
    }

    void lose(Verdict verdict, double is, double may, int step) {
        char text[120];
        if (verdict == Verdict::gains_energy) {
            std::snprintf(text, sizeof text, "%.3g J, %.3g at most, in step %d", is, may, step);
        } else {
            std::snprintf(text, sizeof text, "a node is at %.3g m in the end", is);
        }
        lost_ = {verdict, -1, text};
    }

    RandomCase made_;
    State start_;
    double least_volume_ = 0, most_volume_ = 0, rest_volume_ = 0, work_ = 0, most_elastic_ = 0, figure_ = 0;
    Finding lost_;
};

std::string text_of(const RandomCase& made, int number) {
    static const char* const kinds[] = {"sheet", "upright sheet", "ball"};
    const scene_soft_def& def = made.def;
    char text[200];
    int length = std::snprintf(text, sizeof text, "%d: %s, %.1g kg a node", number, kinds[static_cast<int>(made.kind)],
                               static_cast<double>(made.node_mass));
    const auto add = [&](const char* name, float value) {
        if (!(value > 0.0f) || length >= static_cast<int>(sizeof text)) { return; }
        length += std::snprintf(text + length, sizeof text - static_cast<size_t>(length), ", %s %.1g", name,
                                static_cast<double>(value));
    };
    add("pressure", def.pressure);
    add("volume", def.volume_conservation);
    add("lift", def.aero.lift);
    add("drag", def.aero.drag);
    add("wind", static_cast<float>(std::sqrt(square(def.aero.wind))));
    return text;
}

} // namespace

void add_random_cases(std::vector<StabilityCase>& cases, uint64_t seed, int count) {
    for (int number = 1; number <= count; ++number) {
        const RandomCase made = roll(seed, number);
        StabilityCase which;
        which.group = "random";
        which.name = text_of(made, number);
        which.figure_name = "energy, % of what it may have";
        which.build = [made](scene_builder* builder) { build_random(builder, made); };
        which.step_seconds = [made](int step) { return made.steps[(step - 1) / made.turn % 2]; };
        which.finishing_iterations = 100;
        which.smooths_steps = made.steps[0] != made.steps[1];
        which.seconds = 2;
        which.more_time = 100; // of a busy machine
        which.reach = 1e5;
        which.has_loose_energy_rule = false;
        which.is_asked_for_only = true;
        which.watch = [made] { return std::make_unique<ForceWatcher>(made); };
        cases.push_back(std::move(which));
    }
}

} // namespace demos
