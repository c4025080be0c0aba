// SPDX-License-Identifier: Apache-2.0
#include "theme.hpp"

#include <imgui.h>

#include <cmath>

namespace view {

void set_theme(double scale) {
  ImFontConfig font;
  font.SizePixels = static_cast<float>(13 * std::max(1.0, std::round(scale)));  // its pixels stay whole
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 6;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.ItemSpacing = {8, 5};
  style.Colors[ImGuiCol_WindowBg] = {0.08f, 0.09f, 0.11f, 0.90f};
  style.Colors[ImGuiCol_FrameBg] = {0.19f, 0.22f, 0.26f, 1};
  style.Colors[ImGuiCol_Header] = {0.18f, 0.24f, 0.31f, 1};
  style.Colors[ImGuiCol_TableHeaderBg] = {0.16f, 0.19f, 0.23f, 1};
  style.ScaleAllSizes(static_cast<float>(scale));
}

}  // namespace view
