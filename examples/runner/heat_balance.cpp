// SPDX-License-Identifier: Apache-2.0
#include "heat_balance.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "check_heat.hpp"
#include "expect.hpp"
#include "meltsim/physics/property_table.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

/// Sums of one pass over the particles, against a common melting point.
struct Sums {
  double heat = 0;             ///< [J] above the melting point, of liquids and of bodies that do not melt
  double capacity = 0;         ///< [J/K] of the same
  double warming = 0;          ///< [J] to bring the solids to the melting point
  double latent = 0;           ///< [J] that melts them from there on
  double melted_capacity = 0;  ///< [J/K] of the solids once they are liquid
  double solid_capacity = 0;   ///< [J/K]
  double freezing = 0;         ///< [J] that liquid gives off as it freezes
  double all_freezing = 0;     ///< [J] that it would if it were wholly liquid
  double thawed_capacity = 0;  ///< [J/K] of that liquid
  double frozen_capacity = 0;  ///< [J/K] of it once it is frozen
};

/// Where all that melts begins to, and over how much it does.
struct Common {
  double point = 0;  ///< [degrees Celsius]
  double range = 0;  ///< [K]
};

/// Per material of the table: the one that its liquid freezes to, or null.
std::vector<const meltsim::MaterialDesc*> what_freezes(const std::vector<meltsim::MaterialDesc>& table) {
  std::vector<const meltsim::MaterialDesc*> solid(table.size(), nullptr);
  for (const meltsim::MaterialDesc& material : table)
    if (material.freezes && material.melts_into) solid.at(material.melts_into.index) = &material;
  return solid;
}

std::optional<Common> common_melting(const std::vector<meltsim::MaterialDesc>& used) {
  std::optional<Common> common;
  for (const meltsim::MaterialDesc& material : used) {
    if (!material.melts_into || std::isinf(material.melting_point)) continue;
    if (common && (common->point != material.melting_point || common->range != material.melting_range))
      return std::nullopt;
    common = {material.melting_point, material.melting_range};
  }
  return common;
}

/// [J/(kg K)] The mean of a material between two temperatures.
double mean_capacity(const meltsim::MaterialDesc& m, double from, double to) {
  if (m.heat_capacity_points.empty()) return m.heat_capacity;
  meltsim::physics::PropertyTable<double> table;
  for (const meltsim::PropertyPoint& p : m.heat_capacity_points) {
    table.temperature[table.points] = p.temperature;
    table.value[table.points++] = p.value;
  }
  if (std::fabs(to - from) < 1e-3) return meltsim::physics::property_at(table, from);
  return (meltsim::physics::capacity_integral(table, to) - meltsim::physics::capacity_integral(table, from)) /
         (to - from);
}

/// Whether it brings a known mass.
bool is_counted(const SceneEmitter& emitter) {
  return !emitter.desc.level && !emitter.desc.recycle && std::isfinite(emitter.desc.until);
}

/// What is counted, against a common melting point.
class Balance {
 public:
  Balance(const Scene& scene, Built& built, const Common& common)
      : scene_(scene), built_(built), point_(common.point), range_(common.range) {
    for (const meltsim::MaterialId id : built.material_ids) table_.push_back(built.world.material(id));
    solid_of_ = what_freezes(table_);
    result_.melting_point = point_;
  }

  HeatBalance of_all() {
    const meltsim::ParticleData data = expect(built_.world.particles());
    for (std::size_t i = 0; i < data.id.size(); ++i) {
      const std::size_t row = meltsim::material_of(data.tag[i]);
      if (meltsim::is_fluid(data.tag[i]))
        add_liquid(row, data.mass[i], data.temperature[i], data.liquid_fraction[i]);
      else if (meltsim::is_solid(data.tag[i])) add_solid(row, data.mass[i], data.temperature[i]);
    }
    for (const SceneEmitter& emitter : scene_.emitters) add_emitter(emitter);
    settle();
    return result_;
  }

 private:
  /// [J/kg] From the beginning of melting to its end.
  double melting_heat(const meltsim::MaterialDesc& solid) const {
    const meltsim::MaterialDesc melt = built_.world.material(solid.melts_into);
    return solid.latent_heat +
           0.5 * range_ *
               (mean_capacity(solid, point_, point_ + range_) + mean_capacity(melt, point_, point_ + range_));
  }

  void add_liquid(std::size_t row, double mass, double temperature, double liquid_fraction) {
    const meltsim::MaterialDesc* const solid = solid_of_.at(row);
    // Liquid that freezes is counted from the end of melting, where it begins to: what is colder, but its latent heat, is in that.
    const double from = solid != nullptr ? point_ + range_ : point_;
    const double above =
        solid != nullptr && range_ > 0 ? std::max(0.0, temperature - from) : temperature - from;
    const double capacity = mass * mean_capacity(table_.at(row), from, from + above);
    sums_.heat += capacity * above;
    sums_.capacity += capacity;
    result_.liquid = true;
    if (solid == nullptr) return;
    sums_.freezing += mass * melting_heat(*solid) * liquid_fraction;
    sums_.all_freezing += mass * melting_heat(*solid);
    sums_.thawed_capacity += capacity;
    sums_.frozen_capacity += mass * mean_capacity(*solid, point_, point_);
  }

  void add_solid(std::size_t row, double mass, double temperature) {
    const meltsim::MaterialDesc& material = table_.at(row);
    const double capacity = mass * mean_capacity(material, point_, temperature);
    if (!material.melts_into) {
      sums_.heat += capacity * (temperature - point_);
      sums_.capacity += capacity;
      result_.bodies = true;
      return;
    }
    const double within =
        range_ > 0 ? std::min(1.0, (temperature - point_) / range_) : 0;  // of what melting takes
    sums_.warming += within > 0 ? -within * mass * melting_heat(material) : capacity * (point_ - temperature);
    sums_.latent += mass * melting_heat(material);
    sums_.solid_capacity += capacity;
    sums_.melted_capacity += mass * mean_capacity(built_.world.material(material.melts_into), point_, point_);
    result_.freezes_onto = result_.freezes_onto || material.freezes;
  }

  void add_emitter(const SceneEmitter& emitter) {
    const auto name = std::find(built_.materials.begin(), built_.materials.end(), emitter.material);
    if (!is_counted(emitter) || name == built_.materials.end()) return;
    const auto row = static_cast<std::size_t>(name - built_.materials.begin());
    add_liquid(row, table_.at(row).density * emitted_volume(scene_, emitter.desc), emitter.desc.temperature,
               1);
  }

  void settle() {
    HeatBalance& b = result_;
    b.available = sums_.heat;
    b.needed = sums_.warming + sums_.latent;
    b.freezing = sums_.freezing;
    if (range_ > 0) settle_over_range();
    else settle_at_point();
  }

  /// Beside what melts at one temperature all comes to that before the rest melts; here all melts as it warms.
  void settle_over_range() {
    HeatBalance& b = result_;
    const double others = sums_.capacity - sums_.thawed_capacity;
    const double heat = sums_.heat + sums_.freezing - sums_.warming;  // above the beginning of melting
    const double whole = others * range_ + sums_.latent + sums_.all_freezing;
    b.cold = std::max(0.0, sums_.warming - sums_.heat);
    b.melts = whole > 0 ? std::min(1.0, std::max(0.0, heat / whole)) : 0;
    b.over_range = true;
    b.freezes = sums_.freezing > 0 && heat < 0 ? 1 : 0;
    b.end_temperature = point_ + b.melts * range_;
    if (heat > whole) b.end_temperature += (heat - whole) / (sums_.capacity + sums_.melted_capacity);
    if (heat < 0) b.end_temperature += heat / (others + sums_.frozen_capacity + sums_.solid_capacity);
  }

  void settle_at_point() {
    HeatBalance& b = result_;
    const double left = b.available - b.needed, spare = b.available - sums_.warming;
    b.cold = std::max(0.0, -spare);
    b.end_temperature = point_;
    if (left >= 0) {
      b.melts = 1;
      b.end_temperature += left / (sums_.capacity + sums_.melted_capacity);
    } else if (spare >= 0) {
      b.melts = sums_.latent > 0 ? spare / sums_.latent : 0;
    } else if (b.cold < sums_.freezing) {
      b.freezes = b.cold / sums_.freezing;
    } else {
      b.freezes = sums_.freezing > 0 ? 1 : 0;
      b.end_temperature += (spare + sums_.freezing) / (sums_.capacity - sums_.thawed_capacity +
                                                       sums_.frozen_capacity + sums_.solid_capacity);
    }
  }

  const Scene& scene_;
  Built& built_;
  double point_, range_;
  std::vector<meltsim::MaterialDesc> table_;
  std::vector<const meltsim::MaterialDesc*> solid_of_;
  Sums sums_;
  HeatBalance result_;
};

/// What the balance is about, and how far it goes.
std::string start_text(const HeatBalance& b) {
  if (b.freezes > 0)
    return fmt::format("what is cold takes up {:.2g} times what freezing gives off",
                       b.freezing > 0 ? b.cold / b.freezing : 0);
  const std::string who = !b.bodies  ? "the liquid holds"
                          : b.liquid ? "the liquid and what does not melt hold"
                                     : "what does not melt holds";
  return fmt::format("{} {:.2g} times what melting takes", who,
                     b.needed > 0 ? std::max(0.0, b.available / b.needed) : 0);
}

std::string end_text(const HeatBalance& b) {
  if (b.melts >= 1) return "everything melts";
  if (b.melts > 0 && b.over_range)
    return percent_text(b.melts) + " of what melts" + (b.freezes_onto ? " and freezes" : "") + " is liquid";
  if (b.melts > 0) return percent_text(b.melts) + " of the solid melts";
  if (!(b.freezes > 0)) return "nothing melts";
  if (!b.freezes_onto) return "all stays liquid, as there is nothing that it freezes onto,";
  if (b.freezes >= 1) return "all that can freeze is frozen";
  return percent_text(b.freezes) + " of what can freeze is frozen";
}

}  // namespace

std::optional<HeatBalance> heat_balance(const Scene& scene, Built& built) {
  if (built.meltable == 0) return std::nullopt;
  std::vector<meltsim::MaterialDesc> table;
  for (const meltsim::MaterialId id : built.material_ids) table.push_back(built.world.material(id));
  const auto common = common_melting(table);
  if (!common) return std::nullopt;
  return Balance(scene, built, *common).of_all();
}

std::string heat_balance_text(const HeatBalance& balance, const std::string& others) {
  if (!balance.liquid && !balance.bodies)
    return fmt::format("melting takes {:.3g} J, {}", balance.needed,
                       others.empty() ? "and nothing here brings heat" : "which has to come from " + others);
  const std::string end = fmt::format("{} at {:.3g} C", end_text(balance), balance.end_temperature);
  if (others.empty()) return fmt::format("{}: in the end {}", start_text(balance), end);
  // What is left out may turn the end round: ice that would melt grows at a cold wall.
  return fmt::format("{}: liquid and bodies by themselves come to an end where {}; not counted: {}",
                     start_text(balance), end, others);
}

double emitted_volume(const Scene& scene, const meltsim::EmitterDesc& desc) {
  constexpr double pi = 3.14159265358979323846;
  if (desc.level) return 0;
  const double area = desc.width > 0 ? desc.width * desc.height : pi * desc.radius * desc.radius;
  const double cell = std::pow(scene.world.spacing, 3);
  const double volume = area * desc.speed * std::max(0.0, std::min(desc.until, scene.time.end) - desc.from);
  return desc.max_particles > 0 ? std::min(volume, static_cast<double>(desc.max_particles) * cell) : volume;
}

std::string heat_sources_text(const Scene& scene, const std::vector<std::string>& idle) {
  std::vector<std::string> names;
  if (std::any_of(scene.world.domain.heat.begin(), scene.world.domain.heat.end(),
                  [](const meltsim::SurfaceHeatDesc& surface) { return acts(surface); }))
    names.push_back("walls");
  if (acts(scene.world.heat.free_surface)) names.push_back("the liquid's free surface");
  for (const SceneBody& body : scene.bodies) {
    if (acts(body.desc.surface)) names.push_back(fmt::format("the surface of \"{}\"", body.desc.name));
    if (body.desc.heat_source != 0) names.push_back(fmt::format("the source in \"{}\"", body.desc.name));
  }
  for (const SceneHeatRegion& region : scene.heat_regions)
    if (std::find(idle.begin(), idle.end(), region.desc.name) == idle.end())
      names.push_back(
          fmt::format("region \"{}\"{}", region.desc.name, region.desc.source < 0 ? " (cools)" : ""));
  for (const SceneEmitter& emitter : scene.emitters)
    if (!is_counted(emitter)) names.push_back(fmt::format("emitter \"{}\"", emitter.desc.name));
  constexpr std::size_t most = 3;
  if (names.size() > most) {
    const std::string rest = fmt::format("{} more", names.size() - most);
    names.resize(most);
    names.push_back(rest);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace runner
