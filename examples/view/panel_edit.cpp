// SPDX-License-Identifier: Apache-2.0
// What can be changed about the scene. A slider acts when it is let go.
#include <imgui.h>

#include <algorithm>

#include "panel.hpp"

namespace view {

namespace {

bool slide(const std::string& label, double& value, double low, double high, const char* format, bool even) {
  const ImGuiSliderFlags flags = even ? 0 : ImGuiSliderFlags_Logarithmic;
  ImGui::SliderScalar(label.c_str(), ImGuiDataType_Double, &value, &low, &high, format, flags);
  return ImGui::IsItemDeactivatedAfterEdit();
}

const char* format_of(ConductivityEdit::Form form) {
  switch (form) {
    case ConductivityEdit::Form::conductivity:
      return "%.4g W/(m K)";
    case ConductivityEdit::Form::diffusivity:
      return "%.4g m2/s";
    case ConductivityEdit::Form::factor:
      break;
  }
  return "%.3g x its table";
}

/// A slider's bounds come from the scene, or they would run away from the hand that moves it.
void edit_heat(PanelState& state, const Session& session) {
  ImGui::TextDisabled("Built anew, goes on from here:");
  const Edits& given = session.edits();
  bool changed = false;
  for (std::size_t i = 0; i < state.edits.conductivities.size(); ++i) {
    ConductivityEdit& edit = state.edits.conductivities[i];
    const double middle = given.conductivities[i].value > 0 ? given.conductivities[i].value : 1e-7;
    changed |= slide("conducts: " + edit.material, edit.value, middle / 30, middle * 30, format_of(edit.form),
                     false);
  }
  if (session.scene().world.heat.model != meltsim::HeatModel::none) {
    const double middle = std::max(given.time_scale, 1e-3);
    changed |= slide("heat's pace", state.edits.time_scale, middle / 30, middle * 30, "%.3g x motion", false);
  }
  if (changed) state.rebuild = Rebuild::keep_state;
}

void edit_start(PanelState& state, const Session& session) {
  ImGui::TextDisabled("Built anew, starts again:");
  bool changed = false;
  const Range range = temperature_range(session.scene());
  const double reach = std::max(range.high - range.low, 20.0);
  for (TemperatureEdit& edit : state.edits.temperatures) {
    const double low = std::max(meltsim::absolute_zero, range.low - reach);
    changed |= slide(edit.name, edit.value, low, range.high + reach,
                     "%.1f \xc2\xb0"
                     "C",
                     true);
  }
  changed |= slide("quality", state.edits.scale, 0.4, 2.5, "%.2f x resolution", false);
  if (changed) state.rebuild = Rebuild::start_again;
}

}  // namespace

void draw_edit_controls(const PanelInput& in) {
  StepChoice& step = in.session.step_choice();
  ImGui::TextDisabled("At once:");
  ImGui::BeginDisabled(step.automatic);
  double ms = 1e3 * (step.automatic ? in.session.last_dt() : step.dt);
  const double stable = in.slow.resolved.stable_dt, most = stable < 1e9 ? 64e3 * stable : 100;
  if (slide("time step", ms, 1e-3, std::max(most, 1.0), "%.4g ms", false) || ImGui::IsItemActive())
    step.dt = std::max(1e-9, 1e-3 * ms);
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Checkbox("auto", &step.automatic) && !step.automatic)
    step.dt = std::max(in.session.last_dt(), 1e-9);
  edit_heat(in.state, in.session);
  edit_start(in.state, in.session);
  if (!in.session.note().empty()) ImGui::TextWrapped("%s", in.session.note().c_str());
}

}  // namespace view
