// SPDX-License-Identifier: Apache-2.0
#include "panel.hpp"

#include <imgui.h>

namespace view {

namespace {

constexpr float width_in_letters = 52;

bool section(const char* title, bool open) {
  return ImGui::CollapsingHeader(title, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

}  // namespace

void draw_value(const char* name, const std::string& value) {
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(15 * ImGui::GetFontSize() * 0.55f + 10);
  ImGui::TextWrapped("%s", value.c_str());
}

float draw_panel(const PanelInput& in) {
  const float letter = ImGui::GetFontSize() * 0.54f, height = ImGui::GetIO().DisplaySize.y;
  ImGui::SetNextWindowPos({10, 10}, ImGuiCond_Always);
  ImGui::SetNextWindowSizeConstraints({width_in_letters * letter, 0},
                                      {width_in_letters * letter, height - 20});
  const ImGuiWindowFlags flags =
      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoTitleBar;
  if (ImGui::Begin("panel", nullptr, flags)) {
    ImGui::PushItemWidth(20 * letter);
    draw_run_controls(in);
    if (section("Numbers", true)) draw_numbers(in);
    if (in.picked && section("Particle", true)) draw_picked(in);
    if (section("Show", true)) draw_look_controls(in);
    if (section("Change the scene", true)) draw_edit_controls(in);
    in.state.timings = section("Time per stage", false);
    if (in.state.timings) draw_timings(in);
    if (section("Plan", false)) draw_plan(in);
    ImGui::PopItemWidth();
  }
  ImGui::End();
  return 20 + width_in_letters * letter;
}

}  // namespace view
