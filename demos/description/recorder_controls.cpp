// The scene builder's controls, and what they act on.

#include "recorder_checks.h"
#include "scene_run.h"

void scene_run_set_wind(scene_run* run, int soft, pli_vec3 wind) {
    const int first = soft < 0 ? 0 : soft, end = soft < 0 ? run->soft_count() : soft + 1;
    for (int i = first; i < end && i < run->soft_count(); ++i) {
        run->set_wind(i, wind);
    }
}

void scene_run_drive(scene_run* run, float speed, float largest_change) {
    run->drive(speed, largest_change);
}

void scene_run_steer(scene_run* run, float angle) {
    run->steer(angle);
}

int scene_add_control(scene_builder* builder, const scene_control* control) {
    builder->guard([&] {
        demos::require(control != nullptr && control->name != nullptr, "a control needs a definition with a name");
        const std::string name = control->name;
        demos::require(control->apply != nullptr, name + ": a control needs something to apply");
        demos::require(std::isfinite(control->low) && std::isfinite(control->high) && control->low < control->high &&
                           control->initial >= control->low && control->initial <= control->high,
                       name + ": a control needs a range with its first value in it");
        builder->description.controls.push_back({name, *control});
        builder->description.controls.back().def.name = nullptr; // the record's name is the copy that lasts
    });
    return static_cast<int>(builder->description.controls.size()) - 1;
}

void scene_set_control_at(scene_builder* builder, int frame, int control, float value) {
    builder->guard([&] {
        const std::vector<demos::ControlRecord>& controls = builder->description.controls;
        demos::checked_index(control, controls.size(), "control");
        const demos::ControlRecord& record = controls[static_cast<size_t>(control)];
        demos::require(frame >= 0, record.name + ": a control needs a frame that is not negative");
        demos::require(value >= record.def.low && value <= record.def.high,
                       record.name + ": the value is out of range");
        builder->description.control_events.push_back({frame, control, value});
    });
}
