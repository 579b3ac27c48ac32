#include "timeline_bar.h"

#include <imgui.h>

#include <algorithm>

namespace viewer {

static constexpr ImU32 kept_color = IM_COL32(72, 84, 104, 255), past_color = IM_COL32(61, 133, 224, 255),
                       input_color = IM_COL32(255, 176, 88, 255), place_color = IM_COL32(240, 244, 250, 255);

// With a tip that says what it is for.
static bool button(const char* label, const char* tip) {
    const bool is_pressed = ImGui::Button(label, ImVec2(1.7f * ImGui::GetFrameHeight(), 0.0f));
    if (ImGui::IsItemHovered()) { ImGui::SetTooltip("%s", tip); }
    ImGui::SameLine();
    return is_pressed;
}

// Frames from left to right; a press or a drag goes to the one below the cursor.
static std::optional<int> describe_bar(const Timeline& timeline) {
    const ImVec2 size(ImGui::GetContentRegionAvail().x, ImGui::GetFrameHeight()), from = ImGui::GetCursorScreenPos();
    if (size.x < 16.0f) { return {}; }
    ImGui::InvisibleButton("bar", size);
    const auto frames = static_cast<float>(std::max(timeline.last() - timeline.first(), 1));
    const auto place_of = [&](int frame) {
        return from.x + size.x * static_cast<float>(frame - timeline.first()) / frames;
    };
    ImDrawList* list = ImGui::GetWindowDrawList();
    const float top = from.y + 0.3f * size.y, bottom = from.y + 0.7f * size.y, present = place_of(timeline.frame());
    list->AddRectFilled(ImVec2(from.x, top), ImVec2(from.x + size.x, bottom), kept_color, 3.0f);
    list->AddRectFilled(ImVec2(from.x, top), ImVec2(present, bottom), past_color, 3.0f);
    for (const int frame : timeline.input_frames()) {
        list->AddLine(ImVec2(place_of(frame), top), ImVec2(place_of(frame), bottom), input_color, 2.0f);
    }
    const float half = 0.15f * size.y;
    list->AddRectFilled(ImVec2(present - half, from.y), ImVec2(present + half, from.y + size.y), place_color, 2.0f);
    if (!ImGui::IsItemActive()) { return {}; }
    const float share = std::clamp((ImGui::GetIO().MousePos.x - from.x) / size.x, 0.0f, 1.0f);
    const int frame = std::min(timeline.first() + static_cast<int>(share * frames + 0.5f), timeline.last());
    return frame == timeline.frame() ? std::optional<int>() : frame;
}

static TimelineWishes describe_parts(const Session& session, bool is_paused) {
    TimelineWishes wishes;
    const Timeline* timeline = session.timeline();
    if (timeline == nullptr) {
        ImGui::TextUnformatted("No timeline: btSoftBody cannot go back.");
        return wishes;
    }
    const int last = timeline->last();
    if (button("|<", "first frame (Home)")) { wishes.frame = timeline->first(); }
    if (button("<", "a frame back (,)")) { wishes.frame = timeline->frame() - 1; }
    if (button(is_paused ? ">" : "||", is_paused ? "run from here (space)" : "pause (space)")) {
        wishes.toggles_pause = true;
    }
    if (button(">|", "last frame (End)")) { wishes.frame = last; }
    ImGui::AlignTextToFramePadding();
    const float begin = ImGui::GetCursorPosX();
    ImGui::Text("%d of %d", timeline->frame(), last);
    const std::string widest = std::to_string(last) + " of " + std::to_string(last) + "  "; // the bar keeps its place
    ImGui::SameLine(begin + ImGui::CalcTextSize(widest.c_str()).x);
    const std::optional<int> chosen = describe_bar(*timeline);
    if (chosen.has_value()) { wishes.frame = chosen; }
    return wishes;
}

TimelineWishes describe_timeline(const Session& session, bool is_paused, int left, int width, int height) {
    const ImGuiStyle& style = ImGui::GetStyle();
    const float tall = ImGui::GetFrameHeight() + 2.0f * style.WindowPadding.y;
    ImGui::SetNextWindowPos(ImVec2(static_cast<float>(left), static_cast<float>(height) - tall));
    ImGui::SetNextWindowSize(ImVec2(static_cast<float>(width), tall));
    ImGui::SetNextWindowBgAlpha(0.75f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1.0f, 1.0f));
    ImGui::Begin("Timeline", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoSavedSettings);
    const TimelineWishes wishes = describe_parts(session, is_paused);
    ImGui::End();
    ImGui::PopStyleVar(3);
    return wishes;
}

} // namespace viewer
