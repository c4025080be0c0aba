// SPDX-License-Identifier: Apache-2.0
// What the picture shows, and its legend.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>

#include "panel.hpp"

namespace view {

namespace {

ImU32 packed(Rgb c) { return IM_COL32(c.r, c.g, c.b, 255); }

struct Swatch {
  Rgb color;
  std::string name;
};

std::vector<Swatch> swatches(const Session& session, const Look& look) {
  std::vector<Swatch> list;
  const auto at = [&row = look.colors[static_cast<std::size_t>(look.by)]](int i) {
    return row[static_cast<std::size_t>(i)];
  };
  if (look.by == ColorBy::phase) {
    list = {{at(static_cast<int>(Phase::liquid)), "liquid"},
            {at(static_cast<int>(Phase::solid)), "solid"},
            {at(static_cast<int>(Phase::melted)), "melted"}};
    return list;
  }
  constexpr std::size_t most = 12;
  if (look.by == ColorBy::material) {
    const auto& looks = session.scene().output.looks;
    for (std::size_t i = 0; i < looks.size() && i < most; ++i)
      list.push_back({at(static_cast<int>(i % solid_materials)), looks[i].name});
    return list;
  }
  list.push_back({at(0), "liquid"});
  const auto& bodies = session.scene().bodies;
  for (std::size_t i = 0; i < bodies.size() && i < most; ++i)
    list.push_back({at(body_index(static_cast<std::uint32_t>(i + 1))), bodies[i].desc.name});
  if (bodies.size() > most) list.push_back({at(0), fmt::format("... {} more", bodies.size() - most)});
  return list;
}

void draw_swatches(const Session& session, const Look& look) {
  const float size = ImGui::GetFontSize();
  for (const Swatch& swatch : swatches(session, look)) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + size, at.y + size}, packed(swatch.color), 3);
    ImGui::Dummy({size, size});
    ImGui::SameLine();
    ImGui::TextUnformatted(swatch.name.c_str());
  }
}

void draw_ramp(const Look& look) {
  const Range& range = look.range();
  const float letter = ImGui::GetFontSize(), width = 22 * letter, height = letter;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const auto& row = look.colors[static_cast<std::size_t>(look.by)];
  constexpr int pieces = 64;
  for (int i = 0; i < pieces; ++i) {
    const auto color = [&](int k) {
      return packed(row[static_cast<std::size_t>(k * (table_width - 1) / pieces)]);
    };
    const float x0 = at.x + width * static_cast<float>(i) / pieces;
    const float x1 = at.x + width * static_cast<float>(i + 1) / pieces;
    list.AddRectFilledMultiColor({x0, at.y}, {x1, at.y + height}, color(i), color(i + 1), color(i + 1),
                                 color(i));
  }
  for (const double tick : ticks(range, 7)) {
    const double share = range.high > range.low ? (tick - range.low) / (range.high - range.low) : 0.5;
    const float x = at.x + width * static_cast<float>(share);
    const std::string text = fmt::format("{:.4g}", tick);
    const float half = 0.5f * ImGui::CalcTextSize(text.c_str()).x;
    list.AddLine({x, at.y + height}, {x, at.y + height + 4}, IM_COL32(220, 225, 230, 255));
    list.AddText({x - half, at.y + height + 5}, IM_COL32(230, 234, 238, 255), text.c_str());
  }
  ImGui::Dummy({width, height + letter + 6});
}

}  // namespace

void draw_legend(const Session& session, const Look& look) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x - 14, size.y - 14}, ImGuiCond_Always, {1, 1});
  const ImGuiWindowFlags flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                                 ImGuiWindowFlags_NoInputs;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {22, 10});
  if (ImGui::Begin("legend", nullptr, flags)) {
    const bool ramp = look.by == ColorBy::temperature || look.by == ColorBy::speed;
    if (look.by == ColorBy::temperature)
      ImGui::TextUnformatted(
          "temperature, \xc2\xb0"
          "C");
    if (look.by == ColorBy::speed) ImGui::TextUnformatted("speed, m/s");
    if (ramp) draw_ramp(look);
    else draw_swatches(session, look);
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

void draw_look_controls(const PanelInput& in) {
  Look& look = in.look;
  int by = static_cast<int>(look.by);
  for (int i = 0; i < color_choices; ++i) {
    if (i > 0 && i != 3) ImGui::SameLine();  // two lines: the panel is not wide enough for one
    ImGui::RadioButton(color_names()[static_cast<std::size_t>(i)].c_str(), &by, i);
  }
  look.by = static_cast<ColorBy>(by);
  if (look.by == ColorBy::temperature) {
    float range[2] = {static_cast<float>(look.temperature.low), static_cast<float>(look.temperature.high)};
    if (ImGui::DragFloatRange2("\xc2\xb0"
                               "C",
                               &range[0], &range[1], 0.5f, -273.15f, 1e4f, "%.1f", "%.1f"))
      look.temperature = {static_cast<double>(range[0]), static_cast<double>(range[1])};
    ImGui::SameLine();
    in.state.fit_temperature = ImGui::Button("fit");
  }
  ImGui::SliderFloat("liquid", &look.liquid_size, 0, 1.2f, look.liquid_size > 0 ? "size %.2f" : "hidden");
  ImGui::SliderFloat("solid", &look.solid_size, 0, 1.2f, look.solid_size > 0 ? "size %.2f" : "hidden");
  const char* axes[] = {"nowhere", "across x", "across y", "across z"};
  int cut = look.cut_axis + 1;
  const double low[3] = {in.box.min.x, in.box.min.y, in.box.min.z};
  const double high[3] = {in.box.max.x, in.box.max.y, in.box.max.z};
  if (ImGui::Combo("cut", &cut, axes, 4)) {
    look.cut_axis = cut - 1;
    if (cut > 0) look.cut_at = static_cast<float>(0.5 * (low[cut - 1] + high[cut - 1]));
  }
  if (look.cut_axis >= 0) {
    const int a = look.cut_axis;
    ImGui::SliderFloat("at", &look.cut_at, static_cast<float>(low[a]), static_cast<float>(high[a]), "%.2f m");
  }
  ImGui::Checkbox("shadows", &look.shadows);
  ImGui::SameLine();
  ImGui::Checkbox("domain", &look.box);
  ImGui::SameLine();
  if (ImGui::Button("camera")) in.state.reset_camera = true;
}

}  // namespace view
