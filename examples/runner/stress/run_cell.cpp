// SPDX-License-Identifier: Apache-2.0
// Builds a cell, steps it, and holds it to its invariants.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "meltsim/particle_tag.hpp"
#include "stress/setup.hpp"

namespace runner {
namespace stress {

namespace {

using meltsim::Status;
using meltsim::Vec3d;

// Shares of what there is that may come of discrete time, of pressure waves and of bodies that give: a fall of a block into water
// loses many times that.
constexpr double energy_tolerance = 0.05;
// Of sound: what acoustic noise moves at.
constexpr double noise = 0.05;
constexpr double heat_tolerance = 1e-6;
constexpr int looks = 8;

/// Why a cell ends: an error of the library, or an invariant that does not hold.
struct Refused {
  meltsim::Error error;
};

void need(const Status& status) {
  if (!status) throw Refused{status.error()};
}

template <class T>
T need(meltsim::Result<T> result) {
  if (!result) throw Refused{result.error()};
  return std::move(*result);
}

/// A refusal says what is wrong, and behind a semicolon what to do.
bool names_the_fix(const std::string& message) {
  const std::size_t colon = message.find(": "), semicolon = message.find("; ");
  return colon != std::string::npos && semicolon != std::string::npos && semicolon + 8 < message.size();
}

class Cell {
 public:
  explicit Cell(Setup& setup) : s_(setup), dx_(setup.world.spacing), world_(make()) {}

  void run(Outcome& o) {
    build();
    need(world_.prepare());
    begin();
    o.particles = first_.mass.size();
    const double stable = world_.stable_dt(), g = length(world_.desc().gravity);
    const double unit = g > 0 ? std::sqrt(dx_ / g) : meltsim::infinity;
    const double until = s_.times * unit;
    const double usual = std::isfinite(stable) ? stable : std::isfinite(until) ? until / 20 : 1;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> draw(0.01, 1);
    const auto end = std::min<double>(static_cast<double>(most_substeps()), 1e9);
    std::uint64_t look_at = 1;
    for (int k = 0; world_.steps() < static_cast<std::uint64_t>(end) && !(world_.time() >= until); ++k) {
      if (s_.between) need(s_.between(world_, k));
      need(world_.step(usual * (s_.random_steps ? draw(random) : s_.step)));
      if (world_.steps() < look_at) continue;
      look(o);
      look_at = world_.steps() + static_cast<std::uint64_t>(std::max(1.0, end / looks));
      if (!broken_.empty() || halted_) break;
    }
    look(o);
    if (!halted_) finish();
    o.substeps = world_.steps();
    o.time = world_.time();
    o.energy = gain_;
    o.speed = fastest_;
    if (halted_) {
      o.verdict = Verdict::fails;
      o.note = "halts: " + reason_;
    } else if (!broken_.empty()) {
      o.verdict = Verdict::fails;
      o.note = broken_;
    } else if (!flags_.empty()) {
      o.verdict = Verdict::clamped;
      o.note = flags_;
    }
  }

 private:
  meltsim::World make() {
    if (s_.walls) {
      s_.world.domain.bounded = true;
      s_.world.domain.min = s_.corner;
      s_.world.domain.max = s_.corner + Vec3d{s_.width, s_.height, s_.width} * dx_;
    }
    return need(meltsim::World::create(s_.world));
  }

  meltsim::Shape box(Vec3d low, Vec3d size) const {
    return meltsim::Shape::box(s_.corner + low * dx_, s_.corner + (low + size) * dx_);
  }

  void build() {
    const meltsim::MaterialId water = need(world_.add_material(s_.water));
    if (std::isfinite(s_.ice.melting_point)) s_.ice.melts_into = water;
    const meltsim::MaterialId ice = need(world_.add_material(s_.ice)),
                              other = need(world_.add_material(s_.other));
    if (s_.depth > 0) {
      meltsim::FluidDesc fluid;
      fluid.shape = box({0, 0, 0}, {s_.width, s_.depth, s_.width});
      fluid.material = water;
      fluid.temperature = s_.water_temperature;
      fluid.velocity = s_.water_velocity;
      need(world_.add_fluid(fluid));
    }
    if (s_.other_liquid) {
      meltsim::FluidDesc fluid;
      fluid.shape = box({0, s_.depth, 0}, {s_.width, s_.other_depth, s_.width});
      fluid.material = other;
      fluid.temperature = s_.water_temperature;
      need(world_.add_fluid(fluid));
    }
    for (const Block& b : s_.blocks) {
      meltsim::SolidDesc solid;
      solid.shape = box(b.low, b.size);
      solid.material = b.other ? other : ice;
      solid.temperature = s_.ice_temperature;
      solid.velocity = b.velocity;
      solid.angular_velocity = b.spin;
      solid.motion = b.motion;
      if (b.motion == meltsim::Motion::kinematic) solid.max_speed = length(b.velocity);
      need(world_.add_solid(solid));
    }
    if (s_.more) need(s_.more(world_));
  }

  void begin() {
    first_ = need(world_.particles());
    const meltsim::Totals t = need(world_.totals());
    start_ = t;
    const double g = length(world_.desc().gravity);
    Vec3d low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    double fastest = 0;
    for (std::size_t i = 0; i < first_.position.size(); ++i) {
      const Vec3d x = first_.position[i], v = first_.velocity[i];
      low = {std::min(low.x, x.x), std::min(low.y, x.y), std::min(low.z, x.z)};
      high = {std::max(high.x, x.x), std::max(high.y, x.y), std::max(high.z, x.z)};
      fastest = std::max(fastest, length(v));
    }
    for (const Block& b : s_.blocks) fastest = std::max(fastest, length(b.velocity));
    if (first_.position.empty()) low = high = {};
    if (s_.walls) {  // it may fall from wall to wall
      low = s_.corner;
      if (std::abs(world_.desc().gravity.y) < g || world_.desc().gravity.y > 0)
        high = s_.corner + Vec3d{s_.width, s_.height, s_.width} * dx_;
    }
    const Vec3d fall = high - low, direction = g > 0 ? world_.desc().gravity * (1 / g) : Vec3d{};
    const double depth = std::abs(fall.x * direction.x) + std::abs(fall.y * direction.y) +
                         std::abs(fall.z * direction.z) + dx_;
    const double v2 = 2 * g * depth + fastest * fastest;
    sound_ = world_.resolved().sound_speed;
    const double quick = std::min(sound_, 10 * std::sqrt(v2) + 10 * dx_);
    allowed_speed_ = s_.most_falls * std::sqrt(v2) + noise * quick;
    energy_scale_ = t.mass * (0.5 * v2 + noise * noise * quick * quick);
    // What is denser than its melt does work when it expands, paid for by heat: it lifts the liquid above it. Twice that, with
    // the whole depth for what lies above half of it on average.
    if (std::isfinite(s_.ice.melting_point) && s_.ice.density > s_.water.density)
      for (std::size_t i = 0; i < first_.id.size(); ++i)
        if (meltsim::is_solid(first_.tag[i]))
          work_ += first_.mass[i] * (1 / s_.water.density - 1 / s_.ice.density) * s_.water.density * g *
                   s_.depth * dx_;
    if (first_.temperature.empty()) return;
    coldest_ = *std::min_element(first_.temperature.begin(), first_.temperature.end());
    hottest_ = *std::max_element(first_.temperature.begin(), first_.temperature.end());
    for (std::size_t i = 0; i < first_.enthalpy.size(); ++i) heat_scale_ += std::abs(first_.enthalpy[i]);
    heat_scale_ += std::abs(t.latent) + first_.mass.front() * s_.water.heat_capacity;
  }

  std::uint64_t most_substeps() {
    const auto sweeps = static_cast<std::uint64_t>(std::max<std::int64_t>(1, world_.resolved().heat_sweeps));
    const std::uint64_t affordable = s_.long_one ? s_.most_substeps : 20000 / sweeps;
    return std::max<std::uint64_t>(4, std::min(s_.most_substeps, affordable));
  }

  void breaks(const std::string& what) {
    if (broken_.empty()) broken_ = fmt::format("{} (sub-step {})", what, world_.steps());
  }

  void look(Outcome&) {
    const meltsim::StepResult r = world_.synchronize();
    if (r.halted) {
      halted_ = true;
      reason_ = r.halt_reason;
      return;
    }
    const auto flag = [this](bool up, const char* name) {
      if (up && flags_.find(name) == std::string::npos)
        flags_ += (flags_.empty() ? "" : ", ") + std::string(name);
    };
    flag(r.courant_exceeded, "courant_exceeded");
    flag(r.heat_bound_exceeded, "heat_bound_exceeded");
    flag(r.viscous_bound_exceeded, "viscous_bound_exceeded");
    flag(r.modulus_unreachable, "modulus_unreachable");
    flag(r.body_stiffened, "body_stiffened");
    flag(r.cooled_to_zero, "cooled_to_zero");
    flag(r.level_bared, "level_bared");
    flag(r.emitter_exhausted, "emitter_exhausted");
    const meltsim::Totals t = need(world_.totals());
    fastest_ = std::max({fastest_, t.max_speed, r.max_speed});
    if (!std::isfinite(t.kinetic + t.potential + t.thermal + t.mass)) return breaks("not finite");
    const double gained = t.kinetic + t.potential - start_.kinetic - start_.potential;
    if (energy_scale_ > 0) gain_ = std::max(gain_, (gained - work_) / energy_scale_);
    if (s_.energy && gain_ > energy_tolerance)
      breaks(fmt::format("energy rises by {:.3g} of what there is", gain_));
    if (s_.speed && fastest_ > allowed_speed_)
      breaks(fmt::format("something is at {:.3g} m/s, where a fall gives {:.3g}", fastest_,
                         allowed_speed_ / s_.most_falls));
    const double drift = std::abs(t.thermal - start_.thermal - (t.heat_in - start_.heat_in));
    if (s_.ledger && s_.world.heat.model == meltsim::HeatModel::enthalpy &&
        drift > heat_tolerance * (heat_scale_ + std::abs(t.heat_in) + std::abs(t.thermal)))
      breaks(fmt::format("thermal energy drifts by {:.3g} J of {:.3g}", drift, heat_scale_));
    if (s_.momentum) {
      const double off = length(t.momentum - start_.momentum), scale = t.mass * std::max(fastest_, 1e-300);
      if (off > 1e-4 * scale) breaks(fmt::format("momentum drifts by {:.3g} of {:.3g} kg m/s", off, scale));
    }
  }

  void finish() {
    const meltsim::ParticleData p = need(world_.particles());
    if (s_.mass && (p.mass != first_.mass || p.id != first_.id))
      breaks(
          fmt::format("{} particles of {} are left, or masses changed", p.mass.size(), first_.mass.size()));
    const double range = hottest_ - coldest_;
    const double margin = 1e-3 * range + 1e-5 * std::max(std::abs(hottest_), std::abs(coldest_)) + 1e-3;
    const Vec3d low = s_.corner, high = s_.corner + Vec3d{s_.width, s_.height, s_.width} * dx_;
    // Half a spacing to a wall is what particles keep; coordinates are stored relative to the scene.
    const double slack = 0.01 * dx_;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      const Vec3d x = p.position[i], v = p.velocity[i];
      if (!std::isfinite(x.x + x.y + x.z + v.x + v.y + v.z + p.temperature[i])) return breaks("not finite");
      if (s_.bounded_heat && (p.temperature[i] < coldest_ - margin || p.temperature[i] > hottest_ + margin))
        return breaks(fmt::format("a temperature of {:.4g} leaves {:.4g}..{:.4g}", p.temperature[i], coldest_,
                                  hottest_));
      if (s_.walls && s_.inside &&
          (x.x < low.x - slack || x.y < low.y - slack || x.z < low.z - slack || x.x > high.x + slack ||
           x.y > high.y + slack || x.z > high.z + slack))
        return breaks(fmt::format(
            "a particle is {:.3g} spacings outside the walls",
            std::max({low.x - x.x, low.y - x.y, low.z - x.z, x.x - high.x, x.y - high.y, x.z - high.z}) /
                dx_));
    }
    if (s_.all_melts && need(world_.totals()).solid != 0) breaks("not everything melted");
  }

  Setup& s_;
  double dx_;
  meltsim::World world_;
  meltsim::ParticleData first_;
  meltsim::Totals start_;
  double sound_ = 0, allowed_speed_ = 0, energy_scale_ = 0, work_ = 0, heat_scale_ = 0, coldest_ = 0,
         hottest_ = 0;
  double gain_ = 0, fastest_ = 0;
  bool halted_ = false;
  std::string reason_, broken_, flags_;
};

}  // namespace

Outcome run_cell(Setup setup) {
  Outcome o;
  const auto start = std::chrono::steady_clock::now();
  try {
    Cell(setup).run(o);
  } catch (const Refused& refused) {
    o.note = refused.error.message;
    const bool good = names_the_fix(o.note) && refused.error.code != meltsim::ErrorCode::internal &&
                      refused.error.code != meltsim::ErrorCode::halted;
    o.verdict = good ? Verdict::refused : Verdict::fails;
    if (refused.error.code == meltsim::ErrorCode::halted) o.note = "halts: " + o.note;
    else if (!good) o.note = "a refusal without a fix: " + o.note;
  } catch (const std::exception& error) {
    o.verdict = Verdict::fails;
    o.note = error.what();
  }
  o.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return o;
}

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::holds:
      return "holds";
    case Verdict::clamped:
      return "clamped";
    case Verdict::refused:
      return "refused";
    default:
      return "FAILS";
  }
}

}  // namespace stress
}  // namespace runner
