// Cases of forces that no caller should give: refused with the state kept, or at least survived.

#include "case_parts.h"
#include "engines/bullet_engine.h"
#include "engines/pliant_engine.h"

#include <limits>

namespace demos {

namespace {

// Throws Error with the library's message when the force is refused.
void push(Engine& engine, pli_vec3 force) {
    if (engine.kind() == EngineKind::bullet) {
        static_cast<BulletEngine&>(engine).body(0).addForce(to_bullet(force), 5);
        return;
    }
    auto& pliant = static_cast<PliantEngine&>(engine);
    const uint64_t before = pli_body_state_hash(pliant.body(0));
    if (pli_body_add_node_force(pliant.body(0), 5, force) == PLI_OK) { return; }
    const std::string message = pli_last_error(pliant.bridge().context());
    if (message.empty()) { throw std::runtime_error("refused without a message"); }
    if (pli_body_state_hash(pliant.body(0)) != before) { throw std::runtime_error("refused, and the state changed"); }
    throw Error(message);
}

StabilityCase force_case(const std::string& name, float force) {
    StabilityCase made;
    made.group = "input";
    made.name = name;
    made.figure_name = "rms stretch";
    made.build = [](scene_builder* builder) {
        SheetDef sheet;
        sheet.pins = PLI_PATCH_PIN_CORNERS;
        sheet.columns = 4;
        add_sheet(builder, sheet, 0.02f);
    };
    made.prepare = [force](Engine& engine) { push(engine, pli_vec3_make(0, force, 0)); };
    made.seconds = 2;
    // As far as the limit on the displacement by forces lets it (1 km in the step), and as fast.
    made.reach = 2e3;
    made.given_energy = 1e10;
    return made;
}

} // namespace

void add_input_cases(std::vector<StabilityCase>& cases) {
    cases.push_back(force_case("force of 1e30 N on a node", 1e30f));
    cases.push_back(force_case("force of NaN on a node", std::numeric_limits<float>::quiet_NaN()));
}

} // namespace demos
