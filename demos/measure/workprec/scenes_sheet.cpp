// Sheets: one that hangs between two edges, one that is stretched by a weight, one on a ball, one that falls in folds.

#include "description/recorder.h"
#include "measure/measure.h"
#include "scene_parts.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <cmath>

namespace demos {

namespace {

// Gradients over contacts take seconds for each second, and are better than others by nothing that shows.
bool is_affordable(const Setting& setting) {
    return setting.family != Family::gradients || setting.steps_per_second * setting.iterations <= 60 * 40;
}

// ------------------------------------------------------------------------------------------------ between two edges

// From the shape of a V, each half of it level from edge to edge: a sheet like the hanging rope.
void build_hanging_sheet(scene_builder* builder, float step_seconds) {
    GridDef grid;
    grid.columns = 17;
    grid.rows = 9;
    const float spacing = 0.1f, part = 0.06f;
    grid.place = [=](int column, int row) {
        const auto down = static_cast<float>(std::min(column, 16 - column));
        return pli_vec3_make(part * static_cast<float>(column), -std::sqrt(spacing * spacing - part * part) * down,
                             spacing * static_cast<float>(row));
    };
    grid.mass = [](int column, int) { return column == 0 || column == 16 ? 0.0f : 0.01f; };
    const scene_soft_def def = precision_def("sheet", 1e4f, 3, step_seconds);
    scene_add_soft(builder, make_grid(builder, grid), &def);
}

PrecisionScene hanging_sheet() {
    PrecisionScene made;
    made.name = "sheet";
    made.summary = "A sheet hangs between two edges.";
    made.metrics = {{"E2", "distance from its place at rest / size"}, {"E3", "rms stretch"}};
    made.seconds = 10;
    made.build = build_hanging_sheet;
    made.evaluate = against_rest(made, [](const Engine& engine) { return measure(engine).rms_stretch; });
    return made;
}

// ------------------------------------------------------------------------------------------------ under a weight

// Held at its upper edge, the lower one ten times as heavy: links get longer by some percent.
void build_stretched_sheet(scene_builder* builder, float step_seconds) {
    GridDef grid;
    grid.columns = grid.rows = 10;
    grid.place = [](int column, int row) {
        return pli_vec3_make(0.1f * static_cast<float>(column), -0.1f * static_cast<float>(row), 0);
    };
    grid.mass = [](int, int row) { return row == 0 ? 0.0f : row == 9 ? 0.1f : 0.01f; };
    const scene_soft_def def = precision_def("sheet", 500, 3, step_seconds);
    scene_add_soft(builder, make_grid(builder, grid), &def);
}

PrecisionScene stretched_sheet() {
    PrecisionScene made;
    made.name = "stretched";
    made.summary = "A sheet of 500 N/m is stretched by its heavy lower edge.";
    made.metrics = {{"E2", "distance from its place at rest / size"}};
    made.seconds = 10;
    made.build = build_stretched_sheet;
    made.evaluate = against_rest(made, nullptr);
    return made;
}

// ------------------------------------------------------------------------------------------------ on a ball

constexpr float ball_radius = 0.6f, ball_margin = 0.02f;

void build_sheet_on_ball(scene_builder* builder, float step_seconds) {
    scene_rigid_def ball = scene_rigid_def_default();
    ball.name = "ball";
    ball.shape = scene_sphere(ball_radius);
    ball.friction = 1;
    scene_add_rigid(builder, &ball);
    GridDef grid;
    grid.columns = grid.rows = 17;
    grid.place = [](int column, int row) {
        return pli_vec3_make(0.075f * static_cast<float>(column - 8), 0.65f, 0.075f * static_cast<float>(row - 8));
    };
    grid.mass = [](int, int) { return 0.005f; };
    scene_soft_def def = precision_def("sheet", 1e4f, 1, step_seconds);
    def.collision_margin = ball_margin;
    def.rigid_contacts.friction = 1;
    scene_add_soft(builder, make_grid(builder, grid), &def);
}

// Root mean square of what nodes lack of the margin, over the margin.
double ball_penetration(const Engine& engine) {
    const std::vector<pli_vec3> positions = engine.soft(0).positions;
    double sum = 0;
    for (const pli_vec3 p : positions) {
        const auto lacks =
            static_cast<double>(std::max(0.0f, ball_radius + ball_margin - pli_vec3_length(p)) / ball_margin);
        sum += lacks * lacks;
    }
    return std::sqrt(sum / static_cast<double>(positions.size()));
}

PrecisionScene sheet_on_ball() {
    PrecisionScene made;
    made.name = "ball";
    made.summary = "A stiff sheet falls on a ball and comes to rest.";
    made.metrics = {
        {"E3", "rms stretch"}, {"E3_penetration", "rms penetration / margin"}, {"E5", "rms speed at the end, m/s"}};
    made.seconds = 3;
    made.build = build_sheet_on_ball;
    made.takes = is_affordable;
    made.evaluate = at_the_end([](const Engine& engine) -> std::vector<double> {
        const Measures measures = measure(engine);
        return {measures.rms_stretch, ball_penetration(engine), measures.rms_speed};
    });
    return made;
}

// ------------------------------------------------------------------------------------------------ in folds

void build_fold(scene_builder* builder, float) {
    scene_find("FoldingCloth")->build(builder);
}

// Of the faces of the first soft body, by its positions alone.
double crossing_share(const Engine& engine) {
    const SoftRecord& soft = engine.description().softs.front();
    const auto& record = static_cast<const RecordedDescription&>(engine.description());
    const std::vector<pli_vec3> positions = engine.soft(0).positions;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    int count = 0;
    const pli_world_def def = pli_world_def_default();
    pli_status status = pli_world_create(record.context, &def, &world);
    if (status == PLI_OK) { status = pli_body_create(world, soft.mesh.get(), nullptr, &body); }
    if (status == PLI_OK) { status = pli_body_set_state(body, positions.data(), nullptr); }
    if (status == PLI_OK) { status = pli_body_count_crossings(body, &count); }
    pli_world_destroy(world);
    if (status != PLI_OK) { throw Error(pli_last_error(record.context)); }
    return static_cast<double>(count) / pli_mesh_get_view(soft.mesh.get()).face_count;
}

PrecisionScene fold() {
    PrecisionScene made;
    made.name = "fold";
    made.summary = "A sheet falls in folds onto a ball.";
    made.metrics = {{"E3", "rms stretch"}, {"E3_crossings", "crossing pairs of faces / faces"}};
    made.seconds = 3;
    made.resolution = {30, 30};
    made.build = build_fold;
    made.takes = is_affordable;
    made.evaluate = at_the_end([](const Engine& engine) -> std::vector<double> {
        return {measure(engine).rms_stretch, crossing_share(engine)};
    });
    return made;
}

} // namespace

void add_sheet_scenes(std::vector<PrecisionScene>& scenes) {
    scenes.push_back(hanging_sheet());
    scenes.push_back(stretched_sheet());
    scenes.push_back(sheet_on_ball());
    scenes.push_back(fold());
}

} // namespace demos
