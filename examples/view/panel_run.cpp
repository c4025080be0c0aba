// SPDX-License-Identifier: Apache-2.0
// Pause, step, restart, pace; and the numbers of the run.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "numbers.hpp"
#include "panel.hpp"

namespace view {

namespace {

/// Slider of a double on a logarithmic scale.
bool slide(const char* label, double& value, double low, double high, const char* format) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &low, &high, format,
                             ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
}

std::string pace_text(const Session& session, const PanelState& state) {
  if (session.stopped()) return "stopped";
  if (state.paused) return "paused";
  const double ratio = session.ratio();
  if (ratio <= 0) return "-";
  if (ratio >= 0.97 * state.pace && state.pace == 1)
    return fmt::format("{:.2f} x: keeps up with the clock", ratio);
  return ratio < 0.97 ? fmt::format("{:.3g} x, {:.3g} times slower", ratio, 1 / ratio)
                      : fmt::format("{:.3g} x", ratio);
}

}  // namespace

void draw_run_controls(const PanelInput& in) {
  Session& session = in.session;
  PanelState& state = in.state;
  const std::string& title = session.scene().title.empty() ? session.scene().name : session.scene().title;
  ImGui::TextWrapped("%s", title.c_str());
  ImGui::BeginDisabled(session.stopped());
  if (ImGui::Button(state.paused ? "Run" : "Pause")) state.paused = !state.paused;
  ImGui::SameLine();
  if (ImGui::Button("Step")) state.paused = state.step_once = true;
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button("Restart")) state.rebuild = Rebuild::start_again;
  ImGui::SameLine();
  ImGui::Text("t = %.3f s", session.time());
  slide("pace", state.pace, 0.01, 10, "%.2f x the clock");
}

void draw_numbers(const PanelInput& in) {
  Session& session = in.session;
  const meltsim::StepResult& result = session.result();
  draw_value("to real time", pace_text(session, in.state));
  draw_value("step",
             fmt::format("{:.3g} ms, takes {:.3g} ms", 1e3 * session.last_dt(), session.ms_per_step()));
  draw_value("particles", fmt::format("{} liquid, {} solid", runner::count_text(result.fluid),
                                      runner::count_text(result.solid)));
  if (session.built().meltable > 0) {
    const auto share = static_cast<float>(session.melted_share());
    ImGui::TextDisabled("melted");
    ImGui::SameLine(15 * ImGui::GetFontSize() * 0.55f + 10);
    ImGui::ProgressBar(share, {-1, 0}, runner::percent_text(session.melted_share()).c_str());
  }
  if (session.ledger()) {
    const meltsim::Ledger& ledger = *session.ledger();
    draw_value("motion", fmt::format("{:.3g}, potential {:.3g} J", ledger.kinetic, ledger.potential));
    draw_value("heat", fmt::format("{:.5g}, latent {:.3g} J", ledger.thermal, ledger.latent));
    if (ledger.heat_in != 0) draw_value("came in", fmt::format("{:.3g} J", ledger.heat_in));
    draw_value("fastest", fmt::format("{:.3g} m/s", ledger.max_speed));
  }
  draw_value("backend", fmt::format("{}, {}", runner::backend_name(in.slow.resolved.backend),
                                    in.slow.resolved.device_name));
  draw_value("picture", fmt::format("{:.3g} ms; {}", 1e3 * in.picture_s, in.data_path));
}

void draw_errors(const Session& session) {
  const bool failed = !session.error().empty();
  const std::string text = failed ? session.error() : session.warning();
  if (text.empty()) return;
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float width = std::min(0.46f * size.x, 640.0f);
  ImGui::SetNextWindowPos({size.x - 14, 14}, ImGuiCond_Always, {1, 0});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg,
                        failed ? ImVec4{0.55f, 0.10f, 0.10f, 0.95f} : ImVec4{0.45f, 0.33f, 0.05f, 0.92f});
  const ImGuiWindowFlags flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                 ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoInputs;
  if (ImGui::Begin("errors", nullptr, flags)) ImGui::TextWrapped("%s", text.c_str());
  ImGui::End();
  ImGui::PopStyleColor();
}

}  // namespace view
