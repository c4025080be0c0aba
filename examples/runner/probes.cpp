// SPDX-License-Identifier: Apache-2.0
#include "probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "csv.hpp"
#include "library_error.hpp"

namespace runner {

namespace {

bool alike(const SceneProbe& a, const SceneProbe& b) {
  return a.level == b.level && a.fields == b.fields && a.every == b.every;
}

meltsim::ProbeDesc desc_of(const Scene& scene, const std::vector<std::size_t>& group) {
  const SceneProbe& first = scene.probes[group.front()];
  meltsim::ProbeDesc desc;
  desc.name = first.name;
  desc.kind = first.level ? meltsim::ProbeKind::level : meltsim::ProbeKind::point;
  desc.every = first.every;
  for (const std::size_t i : group) desc.points.push_back(scene.probes[i].at);
  // A scene's velocity is its magnitude.
  for (const std::string& field : first.fields) desc.fields.push_back(field == "velocity" ? "speed" : field);
  return desc;
}

}  // namespace

ProbeGroups add_probes(meltsim::World& world, const Scene& scene) {
  ProbeGroups groups;
  for (std::size_t i = 0; i < scene.probes.size(); ++i) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const std::vector<std::size_t>& group) {
      return alike(scene.probes[group.front()], scene.probes[i]);
    });
    if (same != groups.end()) same->push_back(i);
    else groups.push_back({i});
  }
  for (const std::vector<std::size_t>& group : groups) {
    const meltsim::Result<meltsim::ProbeId> added = world.add_probe(desc_of(scene, group));
    if (!added)
      throw library_failure(added.error(), {}, fmt::format("probes[{}]", group.front()), scene.where);
  }
  return groups;
}

void append(std::vector<meltsim::ProbeSeries>& to, std::vector<meltsim::ProbeSeries> more) {
  if (to.empty()) to = std::exchange(more, {});
  for (std::size_t i = 0; i < more.size(); ++i) {
    to[i].time.insert(to[i].time.end(), more[i].time.begin(), more[i].time.end());
    to[i].values.insert(to[i].values.end(), more[i].values.begin(), more[i].values.end());
  }
}

std::vector<std::string> probe_rows(const Scene& scene, const ProbeGroups& groups,
                                    const std::vector<meltsim::ProbeSeries>& series) {
  std::vector<std::tuple<double, std::size_t, std::string>> rows;
  for (std::size_t g = 0; g < std::min(groups.size(), series.size()); ++g) {
    const meltsim::ProbeSeries& of = series[g];
    const double* value = of.values.data();
    for (const double time : of.time) {
      const std::string when = csv_number(time);
      for (const std::size_t i : groups[g]) {
        const SceneProbe& probe = scene.probes[i];
        std::string text;
        const auto line = [&](const std::string& field) {
          if (!text.empty()) text += '\n';
          text += fmt::format("{},{},{},{}", probe.name, when, field, csv_number(*value++));
        };
        if (probe.level) line("level");
        for (const std::string& field : probe.fields) line(field);
        rows.emplace_back(time, i, std::move(text));
      }
    }
  }
  std::sort(rows.begin(), rows.end());
  std::vector<std::string> lines;
  lines.reserve(rows.size());
  for (auto& [time, probe, text] : rows) lines.push_back(std::move(text));
  return lines;
}

}  // namespace runner
