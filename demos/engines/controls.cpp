// Figures that the user, or the script of a scene, turns while it runs.

#include "description/error.h"
#include "engine.h"

#include <algorithm>
#include <cmath>

namespace demos {

static void set_initial(const Description& description, std::vector<float>& values) {
    if (!values.empty()) { return; }
    for (const ControlRecord& control : description.controls) {
        values.push_back(control.def.initial);
    }
}

void Engine::set_control(int index, float value) {
    const std::vector<ControlRecord>& controls = description().controls;
    if (index < 0 || static_cast<size_t>(index) >= controls.size()) {
        throw Error("there is no control " + std::to_string(index));
    }
    const scene_control& def = controls[static_cast<size_t>(index)].def;
    if (!std::isfinite(value)) { throw Error(controls[static_cast<size_t>(index)].name + ": the value is not finite"); }
    set_initial(description(), changed_controls_);
    float& present = changed_controls_[static_cast<size_t>(index)];
    present = std::clamp(value, def.low, def.high);
    def.apply(this, present);
}

float Engine::control(int index) const {
    const auto at = static_cast<size_t>(index);
    return changed_controls_.empty() ? description().controls.at(at).def.initial : changed_controls_.at(at);
}

} // namespace demos
