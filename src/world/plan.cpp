// SPDX-License-Identifier: Apache-2.0
// The plan: which stages run and why; custom stages.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/text.hpp"
#include "pipeline/pipeline.hpp"
#include "world/guarded.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

/// Why a stage does not run that was needed before, or will be; empty if the reason in the table applies.
std::string WorldImpl::reason_of_change(const core::StageInfo& info) const {
  const std::string module = info.module;
  const auto any_body = [this](const auto& is) { return std::any_of(bodies_.begin(), bodies_.end(), is); };
  const auto melts = [this](const BodyRecord& b) { return leaves_lattice(b.desc.material.index); };
  const auto dissolves = [this](const BodyRecord& b) {
    return bool(materials[b.desc.material.index].dissolves_in);
  };
  if (module == "topology" && census_.meltable == 0 && any_body(melts))
    return any_body(dissolves) ? "everything that can melt or dissolve has"
                               : "everything that can melt has melted";
  if ((info.need & core::fact_fluid) != 0 && (facts_ & core::fact_fluid) == 0 && census_.removed != 0)
    return "all liquid has left";
  if ((info.need & core::fact_mobile) != 0 && (facts_ & core::fact_mobile) == 0 &&
      any_body([](const BodyRecord& b) { return !b.desc.fixed; }))
    return "every body that could move has melted";
  if ((info.need & core::fact_fields) != 0 && any_field())
    return "nothing that force fields could move is there";
  if ((info.need & core::fact_heat_boundary) != 0 && !heat_regions_.empty()) {
    const double next = next_region();
    return std::isfinite(next) ? core::text("no heat region acts before ", next, " s")
                               : std::string("every heat region has ended");
  }
  return {};
}

/// When the next heat region begins [s]; infinite where none will.
double WorldImpl::next_region() const {
  double next = infinity;
  for (const HeatRegionRecord& r : heat_regions_)
    if (r.desc.from > time && r.desc.until > r.desc.from) next = std::min(next, r.desc.from);
  return next;
}

/// The first time between two when a heat region or a force field begins or ends, or a body comes to a point of its path, which sub-steps then do, too; `end` where none does. What
/// is as near to either as rounding takes times is there already.
double WorldImpl::next_switch(double begin, double end) const {
  const double slack = 1e-9 * (end - begin);
  double next = end;
  const auto see = [&](double time) {
    if (time > begin + slack && time < end - slack) next = std::min(next, time);
  };
  for (const HeatRegionRecord& r : heat_regions_)
    if (r.desc.until > r.desc.from) see(r.desc.from), see(r.desc.until);
  for (const ForceFieldRecord& r : force_fields_)
    if (r.used) see(r.desc.from), see(r.desc.until);
  // Of points that ascend the first one after `begin`; one that is as good as there is passed over.
  const auto see_point = [&](const auto& points) {
    const auto count = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t k = physics::points_until(points.data(), count, begin); k < count; ++k) {
      see(points[k].time);
      if (points[k].time > begin + slack) break;
    }
  };
  const auto see_heat = [&](const SurfaceHeatDesc& s) {
    see_point(s.temperature_points);
    see_point(s.flux_points);
  };
  for (const BodyRecord& b : bodies_) {
    if (b.gone) continue;
    if (b.kinematic()) see_point(b.desc.path);
    see_heat(b.desc.surface);
  }
  for (const SurfaceHeatDesc& wall : desc.domain.heat) see_heat(wall);
  see_heat(desc.heat.free_surface);
  return next;
}

bool WorldImpl::is_disabled(const std::string& module) const {
  return std::find(disabled_modules_.begin(), disabled_modules_.end(), module) != disabled_modules_.end();
}

/// Why a stage does not run.
std::string WorldImpl::reason_to_rest(const core::StageInfo& info) const {
  const std::string module = info.module;
  // The search that runs gives the reason why the others do not.
  if ((info.need & core::any_search) != 0) return search_.reason;
  if (module == "species" && species_used_ && contents_level_) return "contents are the same everywhere";
  if (is_disabled(module)) return "switched off by the host";
  if (module == "thermal" && (facts_ & core::fact_particles) != 0)
    if (const std::string cold = heat_reason(); !cold.empty()) return cold;
  if (const std::string change = reason_of_change(info); !change.empty()) return change;
  return info.why_not;
}

StageReport WorldImpl::stage_report(int s, const core::Arrangement& arrangement) const {
  const core::StageInfo& info = core::stage_table[static_cast<std::size_t>(s)];
  StageReport r;
  r.track = arrangement.track[static_cast<std::size_t>(s)];
  r.name = info.name;
  r.module = info.module;
  r.runs = core::runs(info, facts_ | probe_facts());
  r.reason = r.runs ? info.why : reason_to_rest(info);
  if (r.module == "thermal") r.interval = heat_interval(static_dt_);
  if (s == core::stage_thermal_level) r.interval = static_cast<int>(core::level_interval);
  if (r.module == "topology")
    r.interval = s == core::stage_topology_pieces ? desc.pieces_interval : topology_interval_;
  r.median_ms = engine->median_ms(s);
  return r;
}

void WorldImpl::report_stages(Plan& p) const {
  std::uint64_t running = 0;
  for (int s = 0; s < core::stage_count; ++s)
    if (core::runs(core::stage_table[static_cast<std::size_t>(s)], facts_ | probe_facts()))
      running |= core::stage_bit(s);
  const core::Arrangement arrangement = engine->arrangement(running);
  for (int f = 0; f < core::fusion_count; ++f) {
    const core::FusionInfo& info = core::fusion_table[f];
    const bool holds = arrangement.fused[static_cast<std::size_t>(f)];
    p.fusions.push_back({info.name, holds, holds ? info.why : info.why_not});
  }
  for (int s = 0; s < core::stage_count; ++s) {
    p.stages.push_back(stage_report(s, arrangement));
    for (std::size_t k = 0; k < custom_.size(); ++k)
      if (custom_[k].after == s) p.stages.push_back(custom_report(k, arrangement));
  }
  if (const double ms = engine->median_ms(core::surface_stage); ms > 0)
    p.stages.push_back({"surface.build", "surface", true, "the host asks for it", 0, ms});
}

Plan WorldImpl::plan() {
  Plan p;
  if (Status s = ready_to_step(); !s) p.error = s.error().message;
  if (plan_changed_ && !dirty_ && !halted_) static_cast<void>(adapt());
  report_stages(p);
  for (int i = 0; i < core::field_count; ++i) {
    const core::FieldInfo& f = core::field_table[static_cast<std::size_t>(i)];
    p.channels.push_back({f.name, f.type, f.owner_name, f.lifetime_name, f.unit, engine->channel_bytes(i)});
    p.bytes += engine->channel_bytes(i);
  }
  p.bytes += engine->scratch_bytes();
  p.graphs = engine->graphs();
  p.uploads = uploads_;
  p.timings_every = timings_every_;
  p.substep_ms = engine->median_ms(core::whole_substep);
  return p;
}

std::string Plan::to_string() const {
  std::string out = "stage                  runs  every  track  median ms  reason\n";
  char line[256];
  for (const StageReport& s : stages) {
    std::snprintf(line, sizeof line, "%-22s %-5s %5d  %5s  %9s  %s\n", s.name.c_str(), s.runs ? "yes" : "no",
                  s.interval, s.track < 0 ? "-" : std::to_string(s.track).c_str(),
                  core::number_text(s.median_ms, std::chars_format::fixed, 4).c_str(), s.reason.c_str());
    out += line;
  }
  out += "fusion                 holds\n";
  for (const FusionReport& f : fusions) {
    std::snprintf(line, sizeof line, "%-22s %-5s %s\n", f.name.c_str(), f.holds ? "yes" : "no",
                  f.reason.c_str());
    out += line;
  }
  out += "channel                bytes        owner         lifetime\n";
  for (const ChannelReport& c : channels) {
    if (c.bytes == 0) continue;
    std::snprintf(line, sizeof line, "%-22s %-12llu %-13s %s\n", c.name.c_str(),
                  static_cast<unsigned long long>(c.bytes), c.owner.c_str(), c.lifetime.c_str());
    out += line;
  }
  std::snprintf(line, sizeof line, "total                  %llu bytes\n",
                static_cast<unsigned long long>(bytes));
  out += line;
  if (timings_every == 0) return out;
  std::snprintf(line, sizeof line, "timings                of one sub-step in %d, stage by stage\n",
                timings_every);
  out += line;
  if (substep_ms > 0)
    out += "a whole sub-step       " + core::number_text(substep_ms, std::chars_format::fixed, 4) +
           " ms as it usually runs\n";
  return out;
}

/// Channels of a scene with these facts and the custom stages there are. Of what such a stage can see, only enthalpies are
/// not there in any scene with particles.
core::FieldSet WorldImpl::channels_of(core::FactSet facts) const {
  core::FieldSet wanted = 0;
  for (const core::PlacedStage& c : custom_)
    for (const auto* list : {&c.stage.reads, &c.stage.writes})
      if (std::find(list->begin(), list->end(), "enthalpy") != list->end())
        wanted |= core::FieldSet{1} << core::field_enthalpy;
  return core::channels_for(facts, wanted);
}

/// function(), unless another thread is in a call of the World, or one of its stages calls.
template <class Function>
static Status between_steps(std::atomic<const void*>& user, const Function& function) {
  const core::Use use(user);
  return use.entered() ? core::guarded<Status>(function)
                       : core::guarded<Status>([&] { return core::not_entered(use); });
}

Status WorldImpl::insert_after(const std::string& after, CustomStage stage) {
  return between_steps(user, [&] { return place_stage(after, stage); });
}

StageReport WorldImpl::custom_report(std::size_t k, const core::Arrangement& arrangement) const {
  const CustomStage& stage = custom_[k].stage;
  StageReport r;
  r.name = "custom." + stage.name;
  r.module = "custom";
  r.runs = true;
  r.reason = std::string("added by the host after ") +
             core::stage_table[static_cast<std::size_t>(custom_[k].after)].name +
             (stage.recorded ? ", recorded with the sub-step on CUDA" : "");
  r.track = arrangement.custom_track[k];
  r.median_ms = engine->median_ms(core::custom_stage + static_cast<int>(k));
  return r;
}

namespace {
/// Parts of a channel with it: a host's stage touches all of it.
core::FieldSet channels_named(const std::vector<std::string>& names) {
  core::FieldSet set = 0;
  for (int i = 0; i < core::field_count; ++i)
    if (std::find(names.begin(), names.end(), core::field_table[static_cast<std::size_t>(i)].name) !=
        names.end())
      set |= core::FieldSet{1} << i;
  for (const core::PartInfo& p : core::part_table)
    if (set.has(p.field)) set |= core::FieldSet{1} << p.part;
  return set;
}
}  // namespace

Status WorldImpl::place_stage(const std::string& after, const CustomStage& stage) {
  if (stage.name.empty()) return invalid("custom stage: name is empty; give it one, timings refer to it");
  if (stage.run == nullptr)
    return invalid("custom stage \"", stage.name, "\": run: is null; pass a function");
  for (const auto& c : custom_)
    if (c.stage.name == stage.name)
      return invalid("custom stage \"", stage.name, "\": a stage of this name exists; remove it first");
  const auto known = [](const std::string& channel) {
    return std::any_of(core::field_table.begin(), core::field_table.end(),
                       [&](const core::FieldInfo& f) { return channel == f.name; });
  };
  for (const auto* list : {&stage.reads, &stage.writes})
    for (const std::string& channel : *list)
      if (!known(channel))
        return invalid("custom stage \"", stage.name, "\": channel \"", channel,
                       "\" does not exist; names are those of meltsim/fields.def");
  for (int s = 0; s < core::stage_count; ++s)
    if (after == core::stage_table[static_cast<std::size_t>(s)].name) {
      fetch_state();
      const core::FieldSet held = channels_of(facts_);
      custom_.push_back({s, stage, channels_named(stage.reads), channels_named(stage.writes)});
      if (engine != nullptr) engine->set_custom_stages(&custom_);
      dirty_ = dirty_ || channels_of(facts_) != held || facts() != facts_;
      return {};
    }
  return invalid("custom stage \"", stage.name, "\": after: no stage is named \"", after,
                 "\"; World::plan() lists the names");
}

Status WorldImpl::remove(const std::string& name) {
  return between_steps(user, [&] { return remove_stage(name); });
}

Status WorldImpl::remove_stage(const std::string& name) {
  for (auto c = custom_.begin(); c != custom_.end(); ++c)
    if (c->stage.name == name) {
      see_added();
      custom_.erase(c);
      if (engine != nullptr) engine->set_custom_stages(&custom_);
      plan_changed_ = plan_changed_ || (!dirty_ && facts() != facts_);
      return {};
    }
  return invalid("custom stage \"", name, "\": no such stage; World::plan() lists them");
}

Status WorldImpl::set_interval(const std::string& module, int n) {
  return between_steps(user, [&] { return set_interval_of(module, n); });
}

Status WorldImpl::set_interval_of(const std::string& module, int n) {
  if (n < 1)
    return invalid("interval of \"", module, "\": must be >= 1, got ", n, "; 1 runs it every sub-step");
  if (module == "thermal" && n > 1000)  // as HeatDesc::interval
    return invalid("interval of \"thermal\": must be 1 to 1000, got ", n, "; enable() switches heat off");
  if (module == "thermal") desc.heat.interval = n;
  else if (module == "topology") topology_interval_ = n;
  else
    return invalid("interval: module \"", module, "\" cannot be thinned out; only thermal and topology can");
  return {};
}

namespace {
/// Switching a module off is saying that the scene does not need it: facts go, stages and channels follow.
core::FactSet facts_of_module(const std::string& module) {
  if (module == "sph") return core::fact_fluid | core::fact_melt | core::fact_freeze;
  if (module == "lsm") return core::fact_mobile | core::fact_contact | core::fact_lattice | core::fact_rigid;
  if (module == "thermal")
    return core::fact_heat_enthalpy | core::fact_heat_paper | core::fact_heat_iwasaki |
           core::fact_heat_boundary | core::fact_levels;
  if (module == "topology") return core::fact_melt | core::fact_freeze;
  if (module == "species") return core::fact_species;
  return 0;
}
}  // namespace

Status WorldImpl::enable(const std::string& module, bool on) {
  return between_steps(user, [&] { return switch_module(module, on); });
}

Status WorldImpl::switch_module(const std::string& module, bool on) {
  if (facts_of_module(module) == 0)
    return invalid("enable: module \"", module,
                   "\" cannot be switched; sph, lsm, thermal, species and topology can");
  fetch_state();
  const auto found = std::find(disabled_modules_.begin(), disabled_modules_.end(), module);
  if (!on && found == disabled_modules_.end()) disabled_modules_.push_back(module);
  if (on && found != disabled_modules_.end()) disabled_modules_.erase(found);
  disabled_facts_ = 0;
  for (const std::string& m : disabled_modules_) disabled_facts_ |= facts_of_module(m);
  dirty_ = true;
  return {};
}

Status WorldImpl::enable_timings(bool on, int every) {
  if (every < 1)
    return invalid("enable_timings: every: must be >= 1, got ", every, "; 1 times every sub-step");
  return between_steps(user, [&]() -> Status {
    timings_every_ = on ? every : 0;
    engine->enable_timings(timings_every_);
    return {};
  });
}

}  // namespace v0
}  // namespace meltsim
