// SPDX-License-Identifier: Apache-2.0
// Cells drawn at random: several settings away from their defaults at once, as a user's scene has them. Ranges are those of
// which each axis of the map says that they hold; what fails is their combination.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stress/setup.hpp"
#include "validation/dice.hpp"

namespace runner {
namespace stress {

using meltsim::Vec3d;

Setup drawn_cell(std::uint64_t seed, std::uint64_t number) {
  validation::Dice dice(seed, number);
  Setup s("drawn, seed " + fmt::to_string(seed), fmt::to_string(number));
  const auto sometimes = [&](const char* name, double low, double high, bool logarithmic, const auto& set) {
    const bool now = dice.one_in(3);
    const double v = logarithmic ? dice.log(low, high) : dice.uniform(low, high);
    if (!now) return;
    set(v);
    s.drawn += fmt::format("{}{} {:.3g}", s.drawn.empty() ? "" : ", ", name, v);
  };
  const auto also = [&](const char* name, int n, const auto& set) {
    if (!dice.one_in(n)) return;
    set();
    s.drawn += fmt::format("{}{}", s.drawn.empty() ? "" : ", ", name);
  };
  meltsim::WorldDesc& w = s.world;
  sometimes("spacing", 1e-4, 10, true, [&](double v) { w.spacing = v; });
  sometimes("courant", 0.1, 0.6, false, [&](double v) { w.courant = v; });
  sometimes("support", 2, 3.5, false, [&](double v) {
    w.support_radius = v * w.spacing;
    s.width = std::max(8.0, std::ceil(2 * v));
  });
  const double g = w.gravity.y * -1, scale = w.spacing / 0.2;  // of lengths, beside those of the default tank
  const double viscous = std::sqrt(g * w.spacing) * w.spacing;
  sometimes("viscosity / rho sqrt(g dx^3)", 1e-4, 1e3, true,
            [&](double v) { s.water.viscosity = v * 1000 * viscous; });
  also("explicit", 4, [&] { w.viscosity = meltsim::Viscosity::explicit_; });
  sometimes("artificial viscosity", 0, 0.5, false, [&](double v) { w.artificial_viscosity = v; });
  // Beyond 150 degrees a slab of liquid falls flat onto the ceiling, and closing wedges throw jets.
  sometimes("gravity tilted", 0, 150, false, [&](double v) {
    const double a = v * std::acos(-1.0) / 180;
    w.gravity = Vec3d{std::sin(a), -std::cos(a), 0} * g;
  });
  also("free slip", 4, [&] { w.domain.no_slip = false; });
  sometimes("density", 1, 1e4, true, [&](double v) {
    s.water.viscosity *= v / s.water.density;
    s.ice.density *= v / s.water.density;
    s.water.density = v;
  });
  sometimes("ice / water", 0.1, 3, true, [&](double v) { s.ice.density = v * s.water.density; });
  sometimes("conductivity", 1e-2, 1e3, true, [&](double v) { s.water.conductivity = v; });
  sometimes("conductivity of ice", 1e-2, 1e3, true, [&](double v) { s.ice.conductivity = v; });
  sometimes("latent heat", 1e3, 1e6, true, [&](double v) { s.ice.latent_heat = v; });
  sometimes("time scale", 1e2, 1e6, true, [&](double v) { w.heat.time_scale = v * scale * scale; });
  sometimes("water temperature", 1, 300, true, [&](double v) { s.water_temperature = v; });
  sometimes("ice temperature", -200, 0, false, [&](double v) { s.ice_temperature = v; });
  also("freezes", 4, [&] { s.ice.freezes = true; });
  sometimes("half-width", 1, 4.99, false, [&](double v) { s.ice.region_half_width = static_cast<int>(v); });
  sometimes("modulus", 1e4, 1e10, true, [&](double v) { s.ice.youngs_modulus = v; });
  sometimes("damping", 0, 1, false, [&](double v) { s.ice.damping = v; });
  sometimes("friction", 0, 1, false, [&](double v) { s.ice.friction = w.domain.friction = v; });
  sometimes("depth", 1, 7.99, false, [&](double v) { s.depth = std::floor(v); });
  const double edge = dice.whole(1, 4), floor = dice.whole(0, 8);
  const auto block = [&](double n, double y, double x) {
    Block b;
    b.low = {x, y, 2};
    b.size = {n, n, n};
    return b;
  };
  s.blocks = {block(edge, floor, 1)};
  s.drawn += fmt::format("{}block of {} at {}", s.drawn.empty() ? "" : ", ", edge, floor);
  also("second block", 3, [&] { s.blocks.push_back(block(2, dice.whole(0, 10), 5.5)); });
  also("rigid", 3, [&] {
    for (Block& b : s.blocks) b.motion = meltsim::Motion::rigid;
  });
  sometimes("thrown / sqrt(g dx)", 0.1, 5, true, [&](double v) {
    s.blocks[0].velocity = Vec3d{0.7, -0.3, 0.2} * (v * std::sqrt(g * w.spacing));
  });
  sometimes("other liquid / water", 0.1, 10, true, [&](double v) {
    s.other_liquid = true;
    s.other.density = v * s.water.density;
    s.other.viscosity = s.water.viscosity * dice.log(1e-3, 1e3);
    s.other_depth = 3;
    if (s.depth + s.other_depth > 9) s.depth = 6;
  });
  also("steps of any length", 4, [&] { s.random_steps = true; });
  // What a heavy body squeezes out against a wall leaves by the body's pressure, the faster the lighter it is (Bernoulli: the root of the
  // ratio of densities).
  const double liquid = s.other_liquid ? std::min(s.water.density, s.other.density) : s.water.density;
  const double heaviest = std::max({s.ice.density, s.water.density, s.other_liquid ? s.other.density : 0.0});
  s.most_falls = std::max(s.most_falls, std::sqrt(heaviest / liquid));
  return s;
}

}  // namespace stress
}  // namespace runner
