// SPDX-License-Identifier: Apache-2.0
#include "probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <future>
#include <iterator>
#include <utility>

#include "library_error.hpp"

namespace runner {

namespace {

bool has_points(const meltsim::ProbeDesc& desc) {
  return desc.kind == meltsim::ProbeKind::point || desc.kind == meltsim::ProbeKind::level;
}

bool alike(const SceneProbe& a, const SceneProbe& b) {
  return has_points(a.desc) && a.desc.kind == b.desc.kind && a.desc.fields == b.desc.fields &&
         a.desc.every == b.desc.every;
}

meltsim::ProbeDesc desc_of(const Scene& scene, const std::vector<meltsim::BodyId>& bodies,
                           const std::vector<std::size_t>& group) {
  meltsim::ProbeDesc desc = scene.probes[group.front()].desc;
  if (desc.body) desc.body = bodies.at(desc.body.index);
  if (!has_points(desc)) return desc;
  desc.points.clear();
  for (const std::size_t i : group) desc.points.push_back(scene.probes[i].desc.points.front());
  // A scene's velocity is its magnitude.
  for (std::string& field : desc.fields)
    if (field == "velocity") field = "speed";
  return desc;
}

/// What a probe's values are called in probes.csv.
std::vector<std::string> names_of(const meltsim::ProbeDesc& desc) {
  if (desc.kind == meltsim::ProbeKind::level) return {"level"};
  if (desc.kind == meltsim::ProbeKind::heat) return {"heat"};
  return has_points(desc) ? desc.fields : meltsim::sample_columns(desc.fields);
}

}  // namespace

ProbeGroups add_probes(meltsim::World& world, const std::vector<meltsim::BodyId>& bodies, const Scene& scene,
                       std::vector<meltsim::ProbeId>* ids) {
  ProbeGroups groups;
  for (std::size_t i = 0; i < scene.probes.size(); ++i) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const std::vector<std::size_t>& group) {
      return alike(scene.probes[group.front()], scene.probes[i]);
    });
    if (same != groups.end()) same->push_back(i);
    else groups.push_back({i});
  }
  for (const std::vector<std::size_t>& group : groups) {
    const meltsim::Result<meltsim::ProbeId> added = world.add_probe(desc_of(scene, bodies, group));
    if (!added)
      throw library_failure(added.error(), item_places(scene.probes[group.front()]),
                            fmt::format("probes[{}]", group.front()), scene.where);
    if (ids != nullptr) ids->push_back(*added);
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

ProbeTable::ProbeTable(const Scene& scene, ProbeGroups groups, int threads)
    : groups_(std::move(groups)), threads_(threads) {
  for (const SceneProbe& probe : scene.probes) {
    Probe row{probe.desc.name + ",", {}};
    for (const std::string& value : names_of(probe.desc)) {
      row.values.push_back("," + value + ",");
      longest_ = std::max(longest_, row.name.size() + row.values.back().size());
    }
    probes_.push_back(std::move(row));
  }
  longest_ += 2 * longest_csv_number + 1;
}

char* ProbeTable::append(char* to, double time, const std::vector<Item>& items) const {
  char when[longest_csv_number];
  const auto length = static_cast<std::size_t>(write_csv_number(when, time) - when);
  const auto put = [&to](const char* from, std::size_t size) {
    std::memcpy(to, from, size);
    to += size;
  };
  for (const Item& item : items) {
    const Probe& probe = probes_[item.probe];
    const double* value = item.values;
    for (const std::string& name : probe.values) {
      put(probe.name.data(), probe.name.size());
      put(when, length);
      put(name.data(), name.size());
      to = write_csv_number(to, *value++);
      *to++ = '\n';
    }
  }
  return to;
}

ProbeTable::Samples ProbeTable::in_order(const std::vector<meltsim::ProbeSeries>& series) const {
  Samples samples;
  const std::size_t groups = std::min(groups_.size(), series.size());
  for (std::size_t g = 0; g < groups; ++g)
    for (std::size_t n = 0; n < series[g].time.size(); ++n) samples.push_back({series[g].time[n], g, n});
  if (groups > 1)
    std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
      return a.time < b.time || (!(b.time < a.time) && a.group < b.group);
    });
  return samples;
}

std::vector<ProbeTable::Samples::const_iterator> ProbeTable::parts_of(const Samples& samples,
                                                                      std::size_t rows) const {
  constexpr std::size_t worth_a_thread = 10000;  // rows, a millisecond or two
  const std::size_t parts =
      std::clamp(rows / worth_a_thread, std::size_t{1}, static_cast<std::size_t>(std::max(threads_, 1)));
  std::vector<Samples::const_iterator> ends{samples.begin()};
  for (std::size_t part = 1; part <= parts; ++part) {
    auto end = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() * part / parts);
    while (end != samples.begin() && end != samples.end() && end->time == std::prev(end)->time) ++end;
    ends.push_back(std::max(end, ends.back()));
  }
  return ends;
}

ProbeTable::Text ProbeTable::rows(const std::vector<meltsim::ProbeSeries>& series,
                                  Samples::const_iterator from, Samples::const_iterator end) const {
  std::size_t rows = 0;
  for (auto at = from; at != end; ++at) rows += series[at->group].points * series[at->group].width;
  Text text;
  text.room.reset(new char[rows * longest_]);  // not filled first: most of it never is
  char* to = text.room.get();
  std::vector<Item> items;
  while (from != end) {
    const double time = from->time;
    std::size_t merged = 0;
    items.clear();
    for (; from != end && from->time == time; ++from, ++merged) {
      const meltsim::ProbeSeries& of = series[from->group];
      const double* values = of.values.data() + from->number * of.points * of.width;
      for (const std::size_t probe : groups_[from->group]) {
        items.push_back({probe, values});
        values += of.width;
      }
    }
    if (merged > 1)
      std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.probe < b.probe; });
    to = append(to, time, items);
  }
  text.size = static_cast<std::size_t>(to - text.room.get());
  return text;
}

void ProbeTable::write(CsvFile& to, const std::vector<meltsim::ProbeSeries>& series) const {
  const Samples samples = in_order(series);
  std::size_t values = 0;
  for (const meltsim::ProbeSeries& of : series) values += of.values.size();
  const std::vector<Samples::const_iterator> ends = parts_of(samples, values);
  std::vector<std::future<Text>> others;
  for (std::size_t part = 1; part + 1 < ends.size(); ++part)
    others.push_back(std::async([&, part] { return rows(series, ends[part], ends[part + 1]); }));
  const Text first = rows(series, ends[0], ends[1]);
  to.text(first.room.get(), first.size);
  for (std::future<Text>& other : others) {
    const Text text = other.get();
    to.text(text.room.get(), text.size);
  }
}

}  // namespace runner
