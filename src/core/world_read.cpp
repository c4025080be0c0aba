// SPDX-License-Identifier: Apache-2.0
// Reading a World back. Everything here works on the host's copy of the state, in double.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/exec_cpu.hpp"
#include "core/lattice.hpp"
#include "core/stage_functions.hpp"
#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"
#include "meltsim/physics/energy.hpp"

namespace meltsim {
inline namespace v0 {

using core::none;

Result<Totals> WorldImpl::totals() {
  fetch_state();
  const auto rows = material_rows();
  core::DerivedState derived;
  if (!dirty_) engine->download(derived);
  Totals t;
  Vec3d solid_moment{};
  double solid_mass = 0, heat_mass = 0, density_sum = 0;
  std::uint64_t dense = 0;
  t.temperature_min = infinity;
  t.temperature_max = -infinity;
  std::map<std::uint32_t, int> pieces;
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    const std::uint32_t tag = state_.tag[i];
    if (is_removed(tag)) continue;
    const double m = state_.mass[i];
    const Vec3d x = state_.position[i] + origin_, v = state_.velocity[i];
    const double temperature = physics::temperature_of(rows[material_of(tag)], state_.enthalpy[i] / m);
    t.mass += m;
    t.momentum += v * m;
    t.angular_momentum += cross(x, v) * m;
    t.kinetic += physics::kinetic_energy(m, v);
    t.potential += physics::potential_energy(m, desc.gravity, x);
    t.thermal += state_.enthalpy[i];
    t.latent += physics::latent_energy(rows[material_of(tag)], m, state_.enthalpy[i]);
    t.temperature_min = std::min(t.temperature_min, temperature);
    t.temperature_max = std::max(t.temperature_max, temperature);
    t.temperature_mean += m * temperature;
    heat_mass += m;
    t.max_speed = std::max(t.max_speed, length(v));
    if (is_solid(tag)) {
      ++t.solid;
      solid_moment += x * m;
      solid_mass += m;
      const std::uint32_t vertex = state_.vertex_of_id[i];
      if (vertex != none) pieces[state_.vertex_piece[vertex]] = 1;
    } else {
      ++t.fluid;
      if (i < derived.density.size() && derived.density[i] > 1) {
        const double e = derived.density[i] - 1;
        density_sum += e;
        ++dense;
        t.density_error_max = std::max(t.density_error_max, e);
      }
    }
  }
  t.bodies = pieces.size();
  t.melted = state_.melted;
  t.heat_in = state_.heat_in;
  t.frozen = state_.frozen;
  if (heat_mass > 0) {
    t.temperature_mean /= heat_mass;
  } else {
    t.temperature_min = t.temperature_max = 0;
  }
  if (solid_mass > 0) t.solid_center = solid_moment * (1 / solid_mass);
  if (dense > 0) t.density_error_mean = density_sum / double(dense);
  return t;
}

Result<Ledger> WorldImpl::ledger() {
  Ledger l;
  const core::WorldStatus s = dirty_ ? core::WorldStatus{} : engine->ledger();
  if (s.ledger_step == 0) {  // no sub-step since the scene changed: the host's copy is all there is
    const auto t = totals();
    if (!t) return t.error();
    l.step = steps;
    l.time = time;
    l.fluid = t->fluid;
    l.solid = t->solid;
    l.mass = t->mass;
    l.momentum = t->momentum;
    l.angular_momentum = t->angular_momentum;
    l.kinetic = t->kinetic;
    l.potential = t->potential;
    l.thermal = t->thermal;
    l.latent = t->latent;
    l.heat_in = t->heat_in;
    l.max_speed = t->max_speed;
    return l;
  }
  l.step = s.ledger_step;
  l.time = s.halted != 0 ? s.time : time;
  l.solid = solids_built_ + s.frozen - static_cast<std::uint64_t>(s.melted);
  l.fluid = s.particles - static_cast<std::uint64_t>(s.removed) - l.solid;
  l.mass = s.sums.mass;
  l.momentum = s.sums.momentum;
  l.angular_momentum = s.sums.angular_momentum + cross(origin_, s.sums.momentum);
  l.kinetic = s.sums.kinetic;
  l.potential = s.sums.potential + physics::potential_energy(s.sums.mass, desc.gravity, origin_);
  l.thermal = s.sums.thermal;
  l.latent = s.sums.latent;
  l.heat_in = s.heat_in;
  l.max_speed = s.step_speed;
  l.density_error_mean = s.step_excess;
  l.density_error_max = std::max(0.0, s.step_density - 1);
  l.courant = (sound_speed_ + s.step_speed) * s.ledger_dt / core::support_of(desc);
  return l;
}

Result<ParticleData> WorldImpl::particles() {
  fetch_state();
  const auto rows = material_rows();
  core::DerivedState derived;
  if (!dirty_) engine->download(derived);
  ParticleData d;
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    const std::uint32_t tag = state_.tag[i];
    if (is_removed(tag)) continue;
    const auto& m = rows[material_of(tag)];
    const double h = state_.enthalpy[i] / state_.mass[i];
    d.id.push_back(static_cast<std::uint32_t>(i));
    d.position.push_back(state_.position[i] + origin_);
    d.velocity.push_back(state_.velocity[i]);
    d.mass.push_back(state_.mass[i]);
    d.temperature.push_back(physics::temperature_of(m, h));
    d.enthalpy.push_back(state_.enthalpy[i]);
    const bool both = m.plateau != 0u;  // it melts or freezes: its enthalpy says how far it is
    d.liquid_fraction.push_back(both ? physics::liquid_fraction(m, h) : is_solid(tag) ? 0.0 : 1.0);
    const double phi = i < derived.density.size() ? derived.density[i] : 0;
    d.density.push_back(is_solid(tag) ? m.density : phi * state_.mass[i] / state_.volume[i]);
    d.pressure.push_back(is_solid(tag)                      ? 0
                         : derived.pressure_term.size() > i ? derived.pressure_term[i] * phi * phi
                                                            : 0);
    d.tag.push_back(tag);
    const std::uint32_t vertex = state_.vertex_of_id[i];
    d.piece.push_back(is_solid(tag) && vertex != none ? state_.vertex_piece[vertex] + 1 : 0u);
  }
  return d;
}

namespace {

/// Height of the liquid around a box, seen against gravity: the median over columns beside it of the topmost
/// liquid. NaN when there is none within three supports.
double liquid_level(const std::vector<Vec3d>& liquid, Vec3d up, Vec3d low, Vec3d high, double reach,
                    double dx) {
  const Vec3d helper = std::fabs(up.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
  Vec3d a = cross(up, helper);
  a = a * (1 / length(a));
  const Vec3d b = cross(up, a);
  double a0 = infinity, a1 = -infinity, b0 = infinity, b1 = -infinity;
  for (int c = 0; c < 8; ++c) {
    const Vec3d p{c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z};
    a0 = std::min(a0, dot(p, a));
    a1 = std::max(a1, dot(p, a));
    b0 = std::min(b0, dot(p, b));
    b1 = std::max(b1, dot(p, b));
  }
  std::map<std::pair<std::int64_t, std::int64_t>, double> tops;
  for (const Vec3d& p : liquid) {
    const double s = dot(p, a), t = dot(p, b);
    if (s < a0 - reach || s > a1 + reach || t < b0 - reach || t > b1 + reach) continue;
    if (s > a0 - dx && s < a1 + dx && t > b0 - dx && t < b1 + dx) continue;  // under or upon the piece
    double& top =
        tops.try_emplace({std::int64_t(std::floor(s / dx)), std::int64_t(std::floor(t / dx))}, -infinity)
            .first->second;
    top = std::max(top, dot(p, up));
  }
  if (tops.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> heights;
  for (const auto& t : tops) heights.push_back(t.second);
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2),
                   heights.end());
  return heights[heights.size() / 2] + 0.5 * dx;  // particles sit in the middle of their volume
}

}  // namespace

Result<std::vector<PieceInfo>> WorldImpl::pieces() {
  fetch_state();
  const auto rows = material_rows();
  std::map<std::uint32_t, std::vector<std::uint32_t>> members;  // label -> ids
  for (std::size_t v = 0; v < state_.vertex_id.size(); ++v)
    if (state_.vertex_state[v] == 1u) members[state_.vertex_piece[v]].push_back(state_.vertex_id[v]);
  std::vector<Vec3d> liquid;
  for (std::size_t i = 0; i < state_.position.size(); ++i)
    if (is_fluid(state_.tag[i])) liquid.push_back(state_.position[i]);
  const double g = length(desc.gravity), dx = desc.spacing;
  const Vec3d up = g > 0 ? desc.gravity * (-1 / g) : Vec3d{0, 1, 0};
  std::vector<PieceInfo> out;
  std::vector<int> seen(bodies_.size(), 0);
  for (const auto& [label, ids] : members) {
    PieceInfo p;
    const std::uint32_t body = body_of(state_.tag[ids.front()]) - 1;
    p.body = BodyId{body, 1};
    p.name = bodies_[body].desc.name;
    if (++seen[body] > 1) p.name += "." + std::to_string(seen[body]);
    p.piece = label + 1;
    p.particles = ids.size();
    Vec3d lo{infinity, infinity, infinity}, hi{-infinity, -infinity, -infinity};
    for (const std::uint32_t i : ids) {
      const Vec3d x = state_.position[i];
      p.mass += state_.mass[i];
      p.center += x * state_.mass[i];
      p.velocity += state_.velocity[i] * state_.mass[i];
      p.temperature_mean += state_.mass[i] * physics::temperature_of(rows[material_of(state_.tag[i])],
                                                                     state_.enthalpy[i] / state_.mass[i]);
      lo = {std::min(lo.x, x.x), std::min(lo.y, x.y), std::min(lo.z, x.z)};
      hi = {std::max(hi.x, x.x), std::max(hi.y, x.y), std::max(hi.z, x.z)};
    }
    p.center = p.center * (1 / p.mass) + origin_;
    p.velocity = p.velocity * (1 / p.mass);
    p.temperature_mean /= p.mass;
    const double level = liquid_level(liquid, up, lo, hi, 3 * core::support_of(desc), dx);
    if (std::isfinite(level)) {
      for (const std::uint32_t i : ids)
        p.submerged_fraction += clamp((level - dot(state_.position[i], up)) / dx + 0.5, 0.0, 1.0);
      p.submerged_fraction /= double(ids.size());
    }
    out.push_back(p);
  }
  return out;
}

namespace {

/// arrayN and arrayR of a scene whose plan keeps none on the backend: the same bodies, run here.
core::LatticeMasks host_masks(const core::SceneState& state, const core::SceneLattice& lattice) {
  core::LatticeMasks m;
  m.region_words = core::words_for(lattice.max_half_width);
  m.neighbour_mask.assign(lattice.vertex_site.size(), 0u);
  m.region_mask.assign(lattice.vertex_site.size() * m.region_words, 0u);
  core::Frame<float> w;
  w.vertices = static_cast<std::uint32_t>(lattice.vertex_site.size());
  w.region_words = m.region_words;
  // The bodies of a build read these and write the two masks.
  std::vector<std::uint32_t> vertex_state = state.vertex_state, site = lattice.vertex_site,
                             body = lattice.vertex_body, site_vertex = lattice.site_vertex,
                             members(lattice.vertex_site.size()), live(lattice.vertex_site.size()),
                             live_sites(lattice.site_vertex.size() / 32 + 2, 0u);
  std::vector<core::BodyRow> rows = lattice.bodies;
  w.f.vertex_state = vertex_state.data();
  w.f.vertex_site = site.data();
  w.f.vertex_body = body.data();
  w.f.site_vertex = site_vertex.data();
  w.f.bodies = rows.data();
  w.f.neighbour_mask = m.neighbour_mask.data();
  w.f.region_mask = m.region_mask.data();
  w.f.region_members = members.data();
  w.f.row_live = live.data();
  w.f.site_live = live_sites.data();
  core::CpuExec exec;
  topology::build<core::CpuExec, float>(exec, w);
  return m;
}

}  // namespace

Result<LatticeData> WorldImpl::lattice() {
  if (Status s = prepare(); !s) return s.error();
  fetch_state();
  core::LatticeMasks masks;
  engine->download(masks);
  if (masks.neighbour_mask.empty() || masks.region_mask.empty()) masks = host_masks(state_, lattice_);
  LatticeData d;
  const std::size_t n = lattice_.vertex_site.size();
  const int w = lattice_.max_half_width, side = 2 * w + 1;
  d.region_half_width = w;
  d.particle_id = state_.vertex_id;
  d.coordinates = lattice_.vertex_coordinates;
  d.arrayN.assign(n * 27, 0);
  d.arrayR.assign(n * static_cast<std::size_t>(side) * side * side, 0);
  for (std::size_t v = 0; v < n; ++v) {
    d.live.push_back(state_.vertex_state[v] == 1u ? 1 : 0);
    d.body.push_back(lattice_.vertex_body[v] + 1);
    const core::BodyRow row = lattice_.bodies[lattice_.vertex_body[v]];
    const std::uint32_t site = lattice_.vertex_site[v];
    if (!masks.neighbour_mask.empty())
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const std::uint32_t bit = core::neighbour_bit(dx, dy, dz);
            if ((masks.neighbour_mask[v] >> bit) & 1u)
              d.arrayN[v * 27 + bit] = lattice_.site_vertex[core::site_at(site, row, dx, dy, dz)] + 1;
          }
    if (masks.region_mask.empty()) continue;
    const int own = row.region_half_width;
    for (int dz = -own; dz <= own; ++dz)
      for (int dy = -own; dy <= own; ++dy)
        for (int dx = -own; dx <= own; ++dx) {
          const std::uint32_t bit = core::region_bit(own, dx, dy, dz);
          if ((masks.region_mask[v * masks.region_words + (bit >> 5)] >> (bit & 31u)) & 1u)
            d.arrayR[v * static_cast<std::size_t>(side * side * side) + core::region_bit(w, dx, dy, dz)] =
                lattice_.site_vertex[core::site_at(site, row, dx, dy, dz)] + 1;
        }
  }
  return d;
}

}  // namespace v0
}  // namespace meltsim
