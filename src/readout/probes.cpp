// SPDX-License-Identifier: Apache-2.0
// Probes: their checks, which of them are due in a sub-step, and copying samples from the backend to the host.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "description/load_fields.hpp"
#include "description/names.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/sampling.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using physics::SampleField;

namespace {

struct NamedField {
  const char* name;
  SampleField field;
};
constexpr NamedField field_names[] = {
    {"temperature", SampleField::temperature}, {"pressure", SampleField::pressure},
    {"density", SampleField::density},         {"speed", SampleField::speed},
    {"velocity", SampleField::velocity},       {"liquid_fraction", SampleField::liquid_fraction},
    {"solute1", SampleField::solute1},         {"solute2", SampleField::solute2},
    {"solute3", SampleField::solute3},
};
static_assert(std::size(field_names) == physics::sample_fields && physics::sample_species == most_species);

constexpr std::uint64_t most_values = std::uint64_t{1} << 19;  // of one sample
constexpr std::uint64_t usual_values = std::uint64_t{1} << 15, largest_region = std::uint64_t{1} << 20,
                        usual_samples = 256;
constexpr std::uint64_t sample_regions = most_readings + 1;
constexpr double unbounded_reach = 512;  // of a gauge's line, in spacings

/// species: how many the World has.
Result<std::vector<SampleField>> fields_of(const std::string& what, const std::vector<std::string>& names,
                                           std::size_t species) {
  std::vector<SampleField> fields;
  for (const std::string& name : names) {
    const auto* const known = std::find_if(std::begin(field_names), std::end(field_names),
                                           [&](const NamedField& f) { return name == f.name; });
    if (known == std::end(field_names))
      return invalid(
          what, "fields: unknown \"", name,
          "\"; use temperature, pressure, density, speed, velocity, liquid_fraction or solute1 to solute",
          most_species);
    if (const auto k =
            static_cast<std::size_t>(known->field) - static_cast<std::size_t>(SampleField::solute1);
        known->field >= SampleField::solute1 && k >= species)
      return invalid(what, "fields: \"", name, "\" is the content of species ", k + 1,
                     ", and this World has ", species,
                     "; add the material that dissolves first, or leave the field out");
    if (std::find(fields.begin(), fields.end(), known->field) != fields.end())
      return invalid(what, "fields: \"", name, "\" is listed twice; list it once");
    fields.push_back(known->field);
  }
  if (fields.empty())
    return invalid(what,
                   "fields: none is given; list at least one of temperature, pressure, density, speed, ",
                   "velocity, liquid_fraction and solute1 to solute", most_species);
  return fields;
}

std::uint32_t width_of(const std::vector<SampleField>& fields) {
  std::uint32_t width = 0;
  for (const SampleField f : fields) width += physics::sample_width(f);
  return width;
}

core::ProbeRow row_of(const std::vector<SampleField>& fields, std::size_t first, std::uint32_t width,
                      std::uint32_t values) {
  core::ProbeRow r;
  r.first = static_cast<std::uint32_t>(first);
  r.width = width;
  r.values = values;
  for (const SampleField f : fields) {
    r.fields |= physics::sample_bit(f);
    r.field[r.listed++] = f;
  }
  return r;
}

/// How many due times lie before t. Rounding may put t and a due time that mean the same apart by far less than a millionth
/// of `every`.
double due_before(const ProbeDesc& p, double t) {
  constexpr double slack = 1e-6;
  const double all = std::floor((p.until - p.from) / p.every + slack) + 1;
  return std::clamp(std::ceil((t - p.from) / p.every - slack), 0.0, all);
}

/// Whether a sample is due in [start, end). By division alone, so that it depends on nothing but the two times.
bool is_due(const ProbeDesc& p, double start, double end) {
  if (p.every < end - start) {
    const double slack = 1e-6 * (end - start);
    return end - slack > p.from && start <= p.until + slack && (p.every > 0 || start + slack >= p.from);
  }
  return due_before(p, end) > due_before(p, start);
}

}  // namespace

std::vector<std::string> sample_columns(const std::vector<std::string>& fields) {
  std::vector<std::string> columns;
  const auto add = [&](const std::string& name, std::uint32_t width) {
    if (width == 3)
      for (const char* axis : {"_x", "_y", "_z"}) columns.push_back(name + axis);
    else columns.push_back(name);
  };
  for (const std::string& name : fields) {
    for (const NamedField& f : field_names)
      if (name == f.name) add(name, physics::sample_width(f.field));
    for (const core::LoadField& f : core::load_fields)
      if (name == f.name) add(name, f.width);
  }
  return columns;
}

/// Against gravity.
Vec3d WorldImpl::up() const {
  const double g = length(desc.gravity);
  return g > 0 ? desc.gravity * (-1 / g) : Vec3d{0, 1, 0};
}

/// Where a probe is, and when it samples.
Status WorldImpl::check_points(const std::string& what, const ProbeDesc& p) const {
  const DomainDesc& d = desc.domain;
  const double slack = 1e-9 * desc.spacing;
  for (const Vec3d& x : p.points) {
    if (!finite(x)) return invalid(what, "points: must be finite, got ", x);
    if (p.kind == ProbeKind::force) continue;  // moments may be about any point
    if (d.bounded && !(x.x >= d.min.x - slack && x.y >= d.min.y - slack && x.z >= d.min.z - slack &&
                       x.x <= d.max.x + slack && x.y <= d.max.y + slack && x.z <= d.max.z + slack))
      return invalid(what, "points: ", x, " is outside the domain ", d.min, " to ", d.max,
                     "; move it inside");
  }
  if (!(std::isfinite(p.every) && p.every >= 0))
    return invalid(what, "every: must be finite and >= 0 s, got ", p.every, "; 0 samples every sub-step");
  if (!std::isfinite(p.from))
    return invalid(what, "from: must be finite, got ", p.from, "; 0 starts at once");
  if (!(p.until >= p.from))
    return invalid(what, "until: must not be before from (", p.from, " s), got ", p.until,
                   "; infinity never stops");
  return {};
}

Status WorldImpl::check(const ProbeDesc& p, ProbeRecord& record) const {
  const std::string what = "probe \"" + p.name + "\": ";
  for (const ProbeRecord& other : probes_)
    if (other.desc.name == p.name) return invalid(what, "name: another probe has it; choose a different one");
  if (Status s = core::known(what + "kind", p.kind, ProbeKind::flux, "ProbeKind", "point is the default"); !s)
    return s;
  if (p.points.empty() && !record.sums()) return invalid(what, "points: none is given; give at least one");
  if (Status s = check_points(what, p); !s) return s;
  record.points = static_cast<std::uint32_t>(p.points.size());
  if (record.sums()) {
    if (Status s = check_load(what, p, record); !s) return s;
  } else if (p.body || p.wall) {
    return invalid(what, p.body ? "body" : "wall", ": only kinds force and heat have one; leave it out");
  } else if (p.kind == ProbeKind::level) {
    if (!p.fields.empty())
      return invalid(what, "fields: a level has none, got \"", p.fields.front(), "\"; leave them out");
    record.width = 1;
  } else {
    auto fields = fields_of(what, p.fields, species_.size());
    if (!fields) return fields.error();
    record.fields = *fields;
    record.width = width_of(record.fields);
  }
  std::uint64_t values = std::uint64_t{record.points} * record.width;
  for (const ProbeRecord& other : probes_) values += other.values;
  if (values > most_values)
    return Error{ErrorCode::capacity,
                 core::text(what, "points: one sample of all probes would have ", values,
                            " values, more than ", most_values, "; sample fewer points")};
  record.values = record.points * record.width;
  if (probes_.size() >= core::most_probes)
    return Error{ErrorCode::capacity, core::text(what, "there are ", core::most_probes,
                                                 " probes already; put points of one kind into one probe")};
  return {};
}

/// The lines of a level gauge, without their places in the tables.
std::vector<core::ProbeLine> WorldImpl::lines_of(const ProbeDesc& p) const {
  std::vector<core::ProbeLine> lines;
  const Vec3d u = up();
  for (const Vec3d& x : p.points) {
    double below = unbounded_reach * desc.spacing, above = below;
    if (desc.domain.bounded) {
      below = above = infinity;
      const double at[3] = {x.x, x.y, x.z}, along[3] = {u.x, u.y, u.z};
      const double low[3] = {desc.domain.min.x, desc.domain.min.y, desc.domain.min.z},
                   high[3] = {desc.domain.max.x, desc.domain.max.y, desc.domain.max.z};
      for (int a = 0; a < 3; ++a) {
        if (along[a] == 0) continue;
        const double to_low = std::max(at[a] - low[a], 0.0) / std::fabs(along[a]),
                     to_high = std::max(high[a] - at[a], 0.0) / std::fabs(along[a]);
        below = std::min(below, along[a] > 0 ? to_low : to_high);
        above = std::min(above, along[a] > 0 ? to_high : to_low);
      }
    }
    // Half a spacing: between two heights the fill is all but linear where it is a half.
    const double length = below + above,
                 intervals = std::max(1.0, std::ceil(2 * length / desc.spacing - 1e-6));
    core::ProbeLine line;
    line.heights = static_cast<std::uint32_t>(std::min(intervals + 1, 2.0 * most_sample_points));
    line.step = length / intervals;
    line.lowest = dot(x - origin_, u) - below;
    lines.push_back(line);
  }
  return lines;
}

/// Facts for the plan.
core::FactSet WorldImpl::probe_facts() const {
  core::FactSet facts = 0;
  for (const ProbeRecord& p : probes_) facts |= p.sums() ? core::fact_loads : core::fact_probes;
  return facts;
}

core::ProbeSetup WorldImpl::probe_setup() const {
  core::ProbeSetup s;
  std::uint64_t values = 0;
  for (std::size_t k = 0; k < probes_.size(); ++k) {
    const ProbeRecord& p = probes_[k];
    const auto number = static_cast<std::uint32_t>(k);
    values += p.values;
    if (p.sums()) {
      s.rows.push_back(row_of({}, 0, p.width, p.values));
      place_load(p, number, s);
      continue;
    }
    if (p.desc.kind == ProbeKind::point) {
      s.rows.push_back(row_of(p.fields, s.points.size(), p.width, p.values));
      for (const Vec3d& x : p.desc.points) s.points.push_back({x - origin_, number});
      continue;
    }
    s.rows.push_back(row_of({}, s.lines.size(), 1, p.values));
    const auto lines = lines_of(p.desc);
    for (std::size_t n = 0; n < lines.size(); ++n) {
      core::ProbeLine line = lines[n];
      line.probe = number;
      line.first = static_cast<std::uint32_t>(s.heights.size());
      const Vec3d x = p.desc.points[n] - origin_, u = up();
      for (std::uint32_t h = 0; h < line.heights; ++h)
        s.heights.push_back({x + u * (line.lowest + line.step * h - dot(x, u)), number});
      s.lines.push_back(line);
    }
  }
  s.region = std::max(values, std::min(largest_region, std::max(usual_values, usual_samples * values)));
  s.room = s.region * sample_regions;
  return s;
}

Status WorldImpl::place_probes() {
  collect_samples();  // the regions that they lie in go
  const core::ProbeSetup setup = probe_setup();
  Status s = engine->set_probes(setup);
  sample_room_ = s ? setup.region : 0;
  samples_used_ = 0;
  sample_region_ = 0;
  ++sample_rooms_;  // readings hold none of the new regions
  probes_stale_ = !s;
  return s;
}

Result<ProbeId> WorldImpl::add_probe(const ProbeDesc& p) {
  ProbeRecord record;
  record.desc = p;
  if (p.name.empty()) record.desc.name = core::numbered_name("probe", probes_);
  if (Status s = check(record.desc, record); !s) return s.error();
  record.serial = next_probe_;
  const ProbeId id{record.serial, number_};
  std::uint64_t heights = 0;
  const auto count = [&](const ProbeDesc& gauge) {
    if (gauge.kind == ProbeKind::level)
      for (const core::ProbeLine& line : lines_of(gauge)) heights += line.heights;
  };
  count(record.desc);
  for (const ProbeRecord& other : probes_) count(other.desc);
  if (heights > most_sample_points)
    return Error{ErrorCode::capacity,
                 core::text("probe \"", record.desc.name, "\": points: gauges would look at ", heights,
                            " heights, one per half spacing, more than ", most_sample_points,
                            "; use fewer gauges or a lower domain")};
  collect_samples();
  probes_.push_back(std::move(record));
  sampled_.push_back(empty_series().back());
  probes_stale_ = true;
  ++next_probe_;
  if (dirty_) return id;  // prepare() places them
  if (Status s = place_probes(); !s) {
    probes_.pop_back();
    sampled_.pop_back();
    static_cast<void>(place_probes());  // fitted before
    return s.error();
  }
  return id;
}

Status WorldImpl::remove_probe(ProbeId id) {
  const auto probe = std::find_if(probes_.begin(), probes_.end(),
                                  [id](const ProbeRecord& p) { return p.serial == id.index; });
  if (id.generation != number_ || probe == probes_.end())
    return invalid("remove: probe: no probe of this World has index ", id.index, " and generation ",
                   id.generation,
                   "; pass what add_probe() of this World returned, and nothing that was removed");
  for (const OpenReading& r : readings_)
    if (r.ticket.value != 0 && r.what.probes)
      return invalid("remove: probe \"", probe->desc.name,
                     "\": a reading with its samples is open; take() it first");
  collect_samples();
  sampled_.erase(sampled_.begin() + (probe - probes_.begin()));
  probes_.erase(probe);
  probes_stale_ = true;
  if (!dirty_) static_cast<void>(place_probes());  // they fitted before; a fault of the device the step finds
  return {};
}

/// Probes that are due in this sub-step, and the place of their values.
void WorldImpl::begin_sample(core::SubstepArguments& a, double end) {
  a.sampled = 0;
  std::uint64_t values = 0;
  for (std::size_t k = 0; k < probes_.size(); ++k)
    if (is_due(probes_[k].desc, a.time, end)) {
      a.sampled |= std::uint64_t{1} << k;
      a.stages |=
          std::uint64_t{1} << (probes_[k].sums() ? core::stage_sampling_loads : core::stage_sampling_probes);
      values += probes_[k].values;
    }
  if (a.sampled == 0) return;
  if (samples_used_ + values > sample_room_) collect_samples();
  a.sample_at = first_of_region() + samples_used_;
  samples_used_ += values;
}

void WorldImpl::end_sample(const core::SubstepArguments& a, double end) {
  if (a.sampled == 0) return;
  pending_.push_back({a.index, a.time + 0.5 * (end - a.time), a.sampled, a.sample_at,
                      engine->context().particles == 0, dot(origin_, up())});
}

std::vector<ProbeSeries> WorldImpl::empty_series() const {
  std::vector<ProbeSeries> all;
  for (std::size_t k = 0; k < probes_.size(); ++k) {
    ProbeSeries s;
    s.probe = ProbeId{probes_[k].serial, number_};
    s.points = probes_[k].points;
    s.width = probes_[k].width;
    all.push_back(std::move(s));
  }
  return all;
}

namespace {

/// Room for more values; doubled at least, as batches may follow each other without end.
void make_room(std::vector<double>& of, std::size_t more) {
  const std::size_t needed = of.size() + more;
  if (needed > of.capacity()) of.reserve(std::max(needed, 2 * of.capacity()));
}

}  // namespace

/// Appends the samples of a batch; `values`: its values on the backend. If the World halted, without the sub-step that did
/// not count and those after it.
void WorldImpl::add_samples(const SampleBatch& batch, const double* values, std::uint64_t halt_step,
                            std::vector<ProbeSeries>& to) const {
  for (std::size_t k = 0; k < to.size(); ++k) {
    const auto due = static_cast<std::size_t>(
        std::count_if(batch.pending.begin(), batch.pending.end(),
                      [k](const PendingSample& s) { return ((s.due >> k) & 1u) != 0; }));
    make_room(to[k].time, due);
    make_room(to[k].values, due * probes_[k].values);
  }
  for (const PendingSample& s : batch.pending) {
    if (halt_step != 0 && s.step >= halt_step) break;
    const double* from = values + (s.at - batch.first);
    for (std::size_t k = 0; k < to.size(); ++k) {
      if (((s.due >> k) & 1u) == 0) continue;
      const ProbeRecord& p = probes_[k];
      std::vector<double>& all = to[k].values;
      const std::size_t before = all.size();
      to[k].time.push_back(s.time);
      if (s.blank) all.insert(all.end(), p.values, p.sums() ? 0.0 : static_cast<double>(NAN));
      else all.insert(all.end(), from, from + p.values);
      if (p.desc.kind == ProbeKind::level)
        for (std::size_t v = before; v < all.size(); ++v) all[v] += s.origin_level;
      from += p.values;
    }
  }
}

/// Waits where there are samples: takes them to the host.
void WorldImpl::collect_samples() {
  if (pending_.empty()) return;
  SampleBatch batch;
  batch.first = first_of_region();
  batch.pending = std::exchange(pending_, {});
  std::vector<double> values(static_cast<std::size_t>(std::exchange(samples_used_, 0)));
  const std::uint64_t halt_step = engine->samples(batch.first, values.size(), values.data());
  add_samples(batch, values.data(), halt_step, sampled_);
}

/// All samples that no call has taken; their region is no longer written to.
SampleBatch WorldImpl::hand_over_samples() {
  SampleBatch batch;
  batch.region = sample_region_;
  batch.room = sample_rooms_;
  batch.first = first_of_region();
  batch.values = std::exchange(samples_used_, 0);
  batch.pending = std::exchange(pending_, {});
  batch.series = std::exchange(sampled_, empty_series());
  return batch;
}

/// Chooses a region that no open reading holds, for the samples to come.
void WorldImpl::choose_region() {
  const auto held = [&](std::uint64_t region) {
    return std::any_of(readings_.begin(), readings_.end(), [&](const OpenReading& r) {
      return r.ticket.value != 0 && r.samples.values != 0 && r.samples.room == sample_rooms_ &&
             r.samples.region == region;
    });
  };
  sample_region_ = 0;
  while (held(sample_region_)) ++sample_region_;  // there is one more than readings
}

/// After collect_samples: resets the probes whose samples are taken again.
void WorldImpl::drop_samples_from(double time_from) {
  for (std::size_t k = 0; k < sampled_.size(); ++k) {
    std::vector<double>& times = sampled_[k].time;
    const auto kept =
        static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), time_from) - times.begin());
    times.resize(kept);
    sampled_[k].values.resize(kept * probes_[k].values);
  }
}

Result<std::vector<ProbeSeries>> WorldImpl::take_samples() {
  collect_samples();
  if (const std::string fault = engine->fault(); !fault.empty())
    return Error{ErrorCode::internal, "device: " + fault};
  return std::exchange(sampled_, empty_series());
}

Result<std::vector<double>> WorldImpl::sample(const std::vector<Vec3d>& points,
                                              const std::vector<std::string>& names) {
  const auto fields = fields_of("sample: ", names, species_.size());
  if (!fields) return fields.error();
  for (const Vec3d& x : points)
    if (!finite(x)) return invalid("sample: points: must be finite, got ", x);
  if (points.size() > most_sample_points)
    return Error{ErrorCode::capacity,
                 core::text("sample: points: at most ", std::uint64_t{most_sample_points}, ", got ",
                            std::uint64_t{points.size()}, "; sample them in several calls")};
  if (points.empty()) return std::vector<double>{};
  if (Status s = prepare(); !s) return s.error();
  core::ProbeSetup setup;
  const std::uint32_t width = width_of(*fields);
  setup.rows.push_back(row_of(*fields, 0, width, static_cast<std::uint32_t>(points.size()) * width));
  for (const Vec3d& x : points) setup.points.push_back({x - origin_, 0});
  setup.room = std::uint64_t{points.size()} * width;
  std::vector<double> values;
  if (Status s = engine->sample(setup, values); !s) return s.error();
  return values;
}

}  // namespace v0
}  // namespace meltsim
