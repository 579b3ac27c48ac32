// Cases of stiffness, masses, size and gravity.

#include "case_parts.h"

#include <cmath>

namespace demos {

namespace {

// Held at two corners, falls and swings.
StabilityCase hanging_sheet(const std::string& group, const std::string& name, const SheetDef& sheet) {
    StabilityCase made;
    made.group = group;
    made.name = name;
    made.figure_name = "rms stretch";
    made.build = [sheet](scene_builder* builder) { add_sheet(builder, sheet, 0.02f * sheet.half_width); };
    made.reach = 10 * static_cast<double>(sheet.half_width);
    return made;
}

void set_gravity(StabilityCase& which, float gravity) {
    const auto build = which.build;
    which.build = [build, gravity](scene_builder* builder) {
        scene_set_gravity(builder, pli_vec3_make(0, -gravity, 0));
        build(builder);
    };
}

SheetDef held_sheet() {
    SheetDef sheet;
    sheet.pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10;
    return sheet;
}

void add_stiffness(std::vector<StabilityCase>& cases) {
    for (const float stiffness : {1.0f, 1e3f, 1e6f, 1e9f}) {
        SheetDef sheet = held_sheet();
        sheet.stiffness = stiffness;
        char name[64];
        std::snprintf(name, sizeof name, "hanging sheet, %.0e N/m", static_cast<double>(stiffness));
        cases.push_back(hanging_sheet("stiffness", name, sheet));
        cases.back().filter_compression = stiffness > 1e8f;
        if (stiffness < 2.0f) { cases.back().reach = 100; } // the links that hold it get 7 m long
    }
}

// Pinned node, light node, heavy node on two links; and a rope with a rigid box at its end.
void add_mass_ratios(std::vector<StabilityCase>& cases) {
    for (const float ratio : {1.0f, 1e3f, 1e6f}) {
        char name[64];
        std::snprintf(name, sizeof name, "two links, masses 1 : %.0e", static_cast<double>(ratio));
        StabilityCase made;
        made.group = "mass ratio";
        made.name = name;
        made.figure_name = "rms stretch";
        made.build = [ratio](scene_builder* builder) {
            pli_mesh* mesh = nullptr;
            scene_check(builder, pli_mesh_create_rope(scene_context(builder), pli_vec3_make(0, 0, 0),
                                                      pli_vec3_make(1, -1, 0), 1, PLI_ROPE_PIN_FIRST, &mesh));
            scene_check(builder, pli_mesh_set_node_mass(mesh, 2, ratio));
            scene_soft_def def = case_def("links");
            def.link_stiffness = 1e4f * ratio; // a millimetre longer under the weight
            scene_add_soft(builder, mesh, &def);
        };
        made.reach = 5;
        made.tethered = {Column::position_based, Column::xpbd};
        cases.push_back(made);
    }
    for (const float ratio : {1.0f, 1e3f, 1e6f}) {
        char name[64];
        std::snprintf(name, sizeof name, "rope with a box, masses 1 : %.0e", static_cast<double>(ratio));
        StabilityCase made;
        made.group = "mass ratio";
        made.name = name;
        made.figure_name = "rms stretch";
        made.build = [ratio](scene_builder* builder) {
            const pli_vec3 end = pli_vec3_make(2, 0, 0);
            pli_mesh* mesh = nullptr;
            scene_check(builder, pli_mesh_create_rope(scene_context(builder), pli_vec3_make(0, 0, 0), end, 8,
                                                      PLI_ROPE_PIN_FIRST, &mesh));
            scene_check(builder, pli_mesh_set_total_mass(mesh, 1));
            const int box =
                add_rigid(builder, scene_box(pli_vec3_make(0.2f, 0.2f, 0.2f)), pli_vec3_make(2.2f, 0, 0), ratio);
            scene_soft_def def = case_def("rope");
            def.link_stiffness = 1e5f * ratio;
            scene_add_anchor(builder, scene_add_soft(builder, mesh, &def), 9, box, true, 1);
        };
        made.filter_compression = ratio > 1e5f; // springs far stiffer than what the nodes bear, and slack on the way
        made.reach = 5;
        made.tethered = {Column::position_based, Column::xpbd};
        cases.push_back(made);
    }
}

void add_sizes(std::vector<StabilityCase>& cases) {
    const struct {
        const char* name;
        float size;
    } sizes[] = {{"hanging sheet of 1 mm, gravity to scale", 0.001f},
                 {"hanging sheet of 1 km, gravity to scale", 1000}};
    for (const auto& each : sizes) {
        SheetDef sheet = held_sheet();
        sheet.half_width = 0.5f * each.size;
        sheet.node_mass = 0.01f * each.size * each.size; // the same cloth
        sheet.stiffness = 1000 * each.size * each.size;  // the same strain under its weight
        cases.push_back(hanging_sheet("coordinates", each.name, sheet));
        // A step is as long for it as for the sheet of 1 m: only the numbers are others.
        set_gravity(cases.back(), 10 * each.size);
    }
    SheetDef sheet = held_sheet();
    sheet.center = pli_vec3_make(1e4f, 1e4f, -1e4f);
    cases.push_back(hanging_sheet("coordinates", "hanging sheet of 1 m, 10 km away", sheet));
}

void add_gravities(std::vector<StabilityCase>& cases) {
    for (const float gravity : {0.0f, 1000.0f}) {
        SheetDef sheet = held_sheet();
        sheet.stiffness = 1e5f;
        char name[64];
        std::snprintf(name, sizeof name, "hanging sheet, %g m/s2", static_cast<double>(gravity));
        cases.push_back(hanging_sheet("gravity", name, sheet));
        set_gravity(cases.back(), gravity);
        cases.back().tethered = {Column::position_based, Column::implicit, Column::xpbd};
    }
}

} // namespace

void add_material_cases(std::vector<StabilityCase>& cases) {
    add_stiffness(cases);
    add_mass_ratios(cases);
    add_sizes(cases);
    add_gravities(cases);
}

} // namespace demos
