#include "panel.h"

#include "report/table.h"
#include "scenes/scenes.h"

#include <imgui.h>

#include <algorithm>

namespace viewer {

static const ImVec4 warning_color{1.0f, 0.55f, 0.35f, 1.0f};
static const ImVec4 grab_color{0.24f, 0.52f, 0.88f, 0.45f};
static const ImVec4 quiet_color{0.66f, 0.70f, 0.76f, 1.0f};

int panel_width(const PanelState& state, int window_width, float scale) {
    if (state.is_hidden) { return 0; }
    return std::min(static_cast<int>(328.0f * scale), window_width / 2);
}

static void text(const std::string& line) {
    ImGui::TextUnformatted(line.c_str());
}

static void wrapped_text(const std::string& words, const ImVec4& color) {
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    ImGui::PushTextWrapPos(0.0f);
    text(words);
    ImGui::PopTextWrapPos();
    ImGui::PopStyleColor();
}

static void heading(const char* title) {
    ImGui::Separator();
    ImGui::TextColored(quiet_color, "%s", title);
}

// ---------------------------------------------------------------------------------------------------- parts

static void describe_scene(const Session& session, PanelWishes& wishes) {
    const scene& present = *session.description().source;
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::BeginCombo("##scene", present.name, ImGuiComboFlags_HeightLargest)) {
        for (int i = 0; i < scene_count; ++i) {
            const bool is_present = scene_list[i] == &present;
            if (ImGui::Selectable(scene_list[i]->name, is_present)) { wishes.chosen = scene_list[i]; }
            if (is_present) { ImGui::SetItemDefaultFocus(); }
        }
        ImGui::EndCombo();
    }
    wrapped_text(present.summary, ImGui::GetStyleColorVec4(ImGuiCol_Text));
}

static void describe_engines(SessionOptions options, PanelWishes& wishes) {
    int chosen = static_cast<int>(options.engines);
    static constexpr const char* labels[] = {"Pliant", "Bullet", "both"};
    for (int i = 0; i < 3; ++i) {
        if (i > 0) { ImGui::SameLine(); }
        if (!ImGui::RadioButton(labels[i], &chosen, i)) { continue; }
        options.engines = static_cast<Engines>(chosen);
        if (options.engines == Engines::bullet) { options.engine.solver = {}; }
        wishes.options = options;
    }
}

// What Pliant steps soft bodies with. Numbers of the engine's own choice are not set until they are changed.
static void describe_solver(const Session& session, SessionOptions options, PanelWishes& wishes) {
    if (options.engines == Engines::bullet) { return; }
    const demos::SolverRun& present = session.runs().front().solver;
    int chosen = static_cast<int>(present.kind);
    static constexpr const char* labels[] = {"position-based", "implicit", "XPBD"};
    for (int i = 0; i < 3; ++i) {
        if (i > 0) { ImGui::SameLine(); }
        if (!ImGui::RadioButton(labels[i], &chosen, i)) { continue; }
        options.engine.solver = {};
        options.engine.solver.kind = static_cast<demos::SolverKind>(chosen);
        wishes.options = options;
    }
    const float space = ImGui::CalcTextSize("ball radius (m) ").x;
    const auto number = [&](const char* label, int value, std::optional<int>& changed) {
        ImGui::SetNextItemWidth(-space);
        const bool is_entered = ImGui::InputInt(label, &value, 1, 5, ImGuiInputTextFlags_EnterReturnsTrue);
        if (!is_entered) { return; }
        changed = std::clamp(value, 1, 1000);
        wishes.options = options;
    };
    number("iterations", present.iterations, options.engine.solver.iterations);
    if (present.kind == demos::SolverKind::xpbd) {
        number("substeps", present.substeps, options.engine.solver.substeps);
    }
}

static void describe_buttons(PanelState& state, PanelWishes& wishes) {
    const float gap = ImGui::GetStyle().ItemSpacing.x, small = 2.2f * ImGui::GetFrameHeight();
    const float width = (ImGui::GetContentRegionAvail().x - 2.0f * small - 4.0f * gap) / 3.0f;
    const ImVec2 wide(width, 0.0f), narrow(small, 0.0f);
    if (ImGui::Button(state.is_paused ? "Run" : "Pause", wide)) { state.is_paused = !state.is_paused; }
    ImGui::SameLine();
    wishes.step = ImGui::Button("Step", wide);
    ImGui::SameLine();
    wishes.restart = ImGui::Button("Restart", wide);
    ImGui::SameLine();
    if (ImGui::Button("<", narrow)) { wishes.neighbour = -1; } // scenes
    ImGui::SameLine();
    if (ImGui::Button(">", narrow)) { wishes.neighbour = 1; }
}

static std::string sizes_of(const demos::Measures& measures) {
    const std::pair<int, const char*> sizes[] = {{measures.nodes, "nodes"},
                                                 {measures.links, "links"},
                                                 {measures.faces, "faces"},
                                                 {measures.tetras, "tetrahedra"},
                                                 {measures.clusters, "clusters"}};
    std::string line;
    for (const auto& [count, name] : sizes) {
        if (count > 0) { line += (line.empty() ? "" : ", ") + std::to_string(count) + " " + name; }
    }
    return line;
}

static const char* short_name(const Run& run) {
    return run.engine->kind() == demos::EngineKind::pliant ? "Pliant" : "Bullet";
}

static void describe_figures(const Session& session, const PanelState& state) {
    const std::vector<Run>& runs = session.runs();
    if (!ImGui::BeginTable("figures", 1 + static_cast<int>(runs.size()), ImGuiTableFlags_RowBg)) { return; }
    const auto row = [&](const char* label, const std::function<std::string(const Run&)>& value) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextColored(quiet_color, "%s", label);
        for (const Run& run : runs) {
            ImGui::TableNextColumn();
            text(value(run));
        }
    };
    if (runs.size() > 1) { row("", short_name); }
    row("ms per step", [](const Run& run) { return report::fixed(run.ms_per_step, 3); });
    row("energy (J)", [](const Run& run) { return report::fixed(run.measures.kinetic_energy, 2); });
    row("stretch (%)", [](const Run& run) { return report::fixed(100.0 * run.measures.max_stretch, 1); });
    ImGui::EndTable();
    const std::string sizes = sizes_of(runs.front().measures);
    const bool are_alike = sizes == sizes_of(runs.back().measures);
    for (const Run& run : runs) {
        if (are_alike && &run != &runs.front()) { continue; }
        wrapped_text((are_alike ? std::string() : short_name(run) + std::string(": ")) + sizes_of(run.measures),
                     quiet_color);
    }
    const double seconds = static_cast<double>(session.frame()) * static_cast<double>(session.step_seconds());
    text("frame " + std::to_string(session.frame()) + " (" + report::fixed(seconds, 1) + " s), " +
         report::fixed(state.frames_per_second, 0) + " pictures/s" + (state.is_paused ? ", paused" : ""));
}

static void describe_controls(Session& session) {
    const std::vector<demos::ControlRecord>& controls = session.description().controls;
    if (controls.empty()) { return; }
    heading("Controls");
    for (size_t i = 0; i < controls.size(); ++i) {
        const scene_control& def = controls[i].def;
        const char* keys = def.keys == SCENE_KEYS_LEFT_RIGHT ? ", keys left/right"
                           : def.keys == SCENE_KEYS_UP_DOWN  ? ", keys up/down"
                                                             : "";
        text(controls[i].name + keys);
        float value = session.control(i);
        ImGui::PushID(static_cast<int>(i));
        ImGui::SetNextItemWidth(-1.0f);
        if (ImGui::SliderFloat("##value", &value, def.low, def.high, "%.2f")) { session.set_control(i, value); }
        ImGui::PopID();
    }
}

static void describe_look(PanelState& state, PanelWishes& wishes) {
    render::Look& look = state.look;
    heading("Show");
    const auto box = [&](const char* label, bool& value, bool is_first) {
        if (!is_first) { ImGui::SameLine(ImGui::GetContentRegionAvail().x * 0.5f); }
        if (ImGui::Checkbox(label, &value)) { wishes.look_changed = true; }
    };
    box("mesh lines", look.mesh_lines, true);
    box("wireframe", look.wireframe, false);
    box("normals", look.normals, true);
    box("contacts", look.contacts, false);
    box("clusters", look.clusters, true);
    box("follow", state.follows, false);
}

static void describe_tools(PanelState& state) {
    heading("Tools");
    const float space = ImGui::CalcTextSize("ball radius (m) ").x;
    const auto slider = [&](const char* label, float& value, float low, float high) {
        ImGui::SetNextItemWidth(-space);
        ImGui::SliderFloat(label, &value, low, high, "%.2f", ImGuiSliderFlags_Logarithmic);
    };
    slider("cut radius (m)", state.cut_radius, 0.02f, 20.0f);
    slider("ball radius (m)", state.ball.radius, 0.02f, 5.0f);
    slider("ball mass (kg)", state.ball.mass, 0.1f, 1000.0f);
    slider("speed (m/s)", state.ball.speed, 1.0f, 200.0f);
}

static void describe_help() {
    heading("Mouse and keys");
    static constexpr const char* lines[][2] = {{"drag a body", "pull it"},
                                               {"drag, right drag", "turn the camera"},
                                               {"middle drag, wheel", "move it, nearer"},
                                               {"Shift+drag", "cut"},
                                               {"Ctrl+click", "cut a ball out"},
                                               {"B", "shoot a ball"},
                                               {"space", "pause, run"},
                                               {",   .", "a frame back, on"},
                                               {"PgUp, PgDn", "a second back, on"},
                                               {"Home, End, T", "first, last, timeline"},
                                               {"R, N, P", "restart, next, previous"},
                                               {"W, C", "wireframe, contacts"},
                                               {"F, H", "whole scene, hide this"}};
    if (!ImGui::BeginTable("help", 2, ImGuiTableFlags_SizingFixedFit)) { return; }
    for (const auto& line : lines) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        text(line[0]);
        ImGui::TableNextColumn();
        ImGui::TextColored(quiet_color, "%s", line[1]);
    }
    ImGui::EndTable();
}

PanelWishes describe_panel(Session& session, PanelState& state, const SessionOptions& options, int width, int height) {
    PanelWishes wishes;
    if (state.is_hidden) { return wishes; }
    ImGui::SetNextWindowPos(ImVec2(0, 0));
    ImGui::SetNextWindowSize(ImVec2(static_cast<float>(width), static_cast<float>(height)));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0f);
    const ImGuiStyle& style = ImGui::GetStyle();
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(style.ItemSpacing.x, 0.5f * style.ItemSpacing.y));
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(style.FramePadding.x, 0.75f * style.FramePadding.y));
    ImGui::Begin("Pliant", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
    ImGui::PushStyleColor(ImGuiCol_SliderGrab, grab_color); // the number below it stays legible
    describe_scene(session, wishes);
    describe_engines(options, wishes);
    describe_solver(session, options, wishes);
    describe_buttons(state, wishes);
    if (!session.message().empty()) { wrapped_text(session.message(), warning_color); }
    heading("Figures");
    describe_figures(session, state);
    describe_controls(session);
    describe_look(state, wishes);
    describe_tools(state);
    describe_help();
    ImGui::PopStyleColor();
    ImGui::End();
    ImGui::PopStyleVar(4);
    return wishes;
}

void describe_title(const std::string& title, int left, int width) {
    const ImVec2 size = ImGui::CalcTextSize(title.c_str());
    const float x = static_cast<float>(left) + 0.5f * (static_cast<float>(width) - size.x), y = 10.0f, edge = 6.0f;
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddRectFilled(ImVec2(x - edge, y - edge), ImVec2(x + size.x + edge, y + size.y + edge),
                        IM_COL32(18, 22, 30, 190), 4.0f);
    list->AddText(ImVec2(x, y), IM_COL32_WHITE, title.c_str());
}

} // namespace viewer
