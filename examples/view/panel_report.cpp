// SPDX-License-Identifier: Apache-2.0
// The particle that was clicked at, the time per stage, the plan.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <vector>

#include "numbers.hpp"
#include "panel.hpp"

namespace view {

namespace {

std::string text(const Vec3d& v) { return fmt::format("{:.4g}, {:.4g}, {:.4g}", v.x, v.y, v.z); }

std::string body_name(const Session& session, meltsim::ParticleTag tag) {
  const std::uint32_t body = meltsim::body_of(tag);
  if (body == 0) return "none";
  const auto& bodies = session.scene().bodies;
  return body <= bodies.size() ? bodies[body - 1].desc.name : fmt::format("{}", body);
}

}  // namespace

void draw_picked(const PanelInput& in) {
  const Picked& p = *in.picked;
  draw_value("id", fmt::format("{}", p.id));
  ImGui::SameLine();
  const bool forget = ImGui::SmallButton("forget");
  if (p.gone) {
    ImGui::TextDisabled("has left the domain");
  } else {
    const auto material = static_cast<std::size_t>(meltsim::material_of(p.tag));
    const auto& materials = in.session.built().materials;
    draw_value("body", body_name(in.session, p.tag));
    draw_value("phase", fmt::format("{}, {}, {} of its latent heat taken up",
                                    meltsim::is_solid(p.tag) ? "solid" : "liquid",
                                    material < materials.size() ? materials[material] : "?",
                                    runner::percent_text(p.liquid_fraction)));
    draw_value("position", text(p.position) + " m");
    draw_value("velocity", fmt::format("{} m/s", text(p.velocity)));
    draw_value("temperature", fmt::format("{:.3f} \xc2\xb0"
                                          "C",
                                          p.temperature));
    draw_value("enthalpy", fmt::format("{:.6g} J in {:.4g} kg", p.enthalpy, p.mass));
    draw_value("density", fmt::format("{:.5g} kg/m3", p.density));
    draw_value("pressure", fmt::format("{:.5g} Pa", p.pressure));
  }
  if (forget) in.picked.reset();
}

void draw_timings(const PanelInput& in) {
  std::vector<const meltsim::StageReport*> stages;
  double sum = 0;
  for (const meltsim::StageReport& stage : in.slow.plan.stages) {
    if (!stage.runs) continue;
    stages.push_back(&stage);
    sum += stage.median_ms;
  }
  std::stable_sort(stages.begin(), stages.end(),
                   [](const auto* a, const auto* b) { return a->median_ms > b->median_ms; });
  const ImGuiTableFlags flags = ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV;
  if (!ImGui::BeginTable("timings", 3, flags)) return;
  ImGui::TableSetupColumn("stage", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("ms", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableSetupColumn("share", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableHeadersRow();
  const auto row = [sum](const std::string& name, double ms) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(name.c_str());
    ImGui::TableNextColumn();
    ImGui::Text("%8.3f", ms);
    ImGui::TableNextColumn();
    ImGui::Text("%4.0f %%", sum > 0 ? 100 * ms / sum : 0.0);
  };
  for (const meltsim::StageReport* stage : stages) row(stage->name, stage->median_ms);
  row("a sub-step", sum);
  ImGui::EndTable();
}

void draw_plan(const PanelInput& in) {
  const meltsim::Plan& plan = in.slow.plan;
  draw_value("backend", in.slow.backend);
  draw_value("memory", runner::bytes_text(static_cast<double>(plan.bytes)));
  draw_value("neighbours", in.slow.resolved.neighbour_reason);
  draw_value("stable step", fmt::format("{:.3g} ms", 1e3 * in.slow.resolved.stable_dt));
  draw_value("drawn by", in.renderer);
  if (!ImGui::BeginTable("plan", 2, ImGuiTableFlags_RowBg | ImGuiTableFlags_BordersInnerV)) return;
  ImGui::TableSetupColumn("stage", ImGuiTableColumnFlags_WidthFixed);
  ImGui::TableSetupColumn("why", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableHeadersRow();
  for (const bool runs : {true, false}) {
    for (const meltsim::StageReport& stage : plan.stages) {
      if (stage.runs != runs) continue;
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      if (runs) ImGui::TextUnformatted(stage.name.c_str());
      else ImGui::TextDisabled("%s", stage.name.c_str());
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s%s", runs ? "" : "left out: ", stage.reason.c_str());
    }
  }
  ImGui::EndTable();
}

}  // namespace view
