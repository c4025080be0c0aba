// SPDX-License-Identifier: Apache-2.0
// Reading particles and the lattice back, on the host's copy of the state, in double.
#include <algorithm>
#include <cmath>
#include <limits>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "exec/exec_cpu.hpp"
#include "frame/lattice.hpp"
#include "pipeline/stage_functions.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::none;

Result<ParticleData> WorldImpl::particles() {
  start_at_rest();
  fetch_state();
  const auto rows = material_rows();
  core::DerivedState derived;
  if (!dirty_) engine->download(derived);
  const auto fields = acting_fields();
  ParticleData d;
  const auto with_room = [n = state_.position.size()](auto&... all) { (all.reserve(n), ...); };
  with_room(d.id, d.position, d.velocity, d.mass, d.temperature, d.enthalpy, d.liquid_fraction, d.density,
            d.pressure, d.tag, d.piece);
  d.species = species_ids();
  d.fractions.resize(species_.size());
  for (auto& f : d.fractions) f.reserve(state_.position.size());
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    const std::uint32_t tag = state_.tag[i];
    if (is_removed(tag)) continue;
    for (std::size_t k = 0; k < species_.size(); ++k)
      d.fractions[k].push_back(state_.solute[k][i] / state_.mass[i]);
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
    const bool pressed = is_fluid(tag) && i < derived.pressure_term.size();
    d.pressure.push_back(
        pressed ? derived.pressure_term[i] * phi * phi + rest_pressure_at(fields, state_.position[i]) : 0.0);
    d.tag.push_back(tag);
    const std::uint32_t vertex = state_.vertex_of_id[i];
    d.piece.push_back(is_solid(tag) && vertex != none ? state_.vertex_piece[vertex] + 1 : 0u);
  }
  return d;
}

Result<StageContext> WorldImpl::device_state() {
  if (Status s = prepare(); !s) return s.error();
  if ((facts_ & core::fact_particles) == 0) {
    StageContext nothing;
    nothing.backend = engine->backend();
    nothing.precision = desc.precision;
    nothing.time = time;
    nothing.serial = mark_view(state_view_, false);
    return nothing;
  }
  StageContext c = engine->context();
  c.acceleration = nullptr;
  c.time = time;
  c.serial = mark_view(state_view_, false);
  return c;
}

namespace {

/// Colours as monitors show them, red in the lowest byte.
std::uint32_t packed(double r, double g, double b) {
  const auto byte = [](double x) { return static_cast<std::uint32_t>(std::lround(255 * x)); };
  return byte(r) | byte(g) << 8u | byte(b) << 16u | 0xff000000u;
}

std::vector<std::uint32_t> palette() {
  static constexpr double known[][3] = {{0.66, 0.80, 0.90}, {0.80, 0.42, 0.09}, {0.64, 0.15, 0.10},
                                        {0.22, 0.46, 0.18}, {0.36, 0.24, 0.55}, {0.72, 0.32, 0.43}};
  std::vector<std::uint32_t> table;
  for (std::size_t k = 0; k < 256; ++k) {
    const double* c = known[k % std::size(known)];
    table.push_back(packed(c[0], c[1], c[2]));
  }
  return table;
}

/// Cold to hot.
std::vector<std::uint32_t> ramp() {
  static constexpr double stops[][3] = {{0.14, 0.25, 0.62}, {0.27, 0.55, 0.85}, {0.68, 0.86, 0.91},
                                        {0.99, 0.90, 0.45}, {0.96, 0.52, 0.22}, {0.75, 0.09, 0.12}};
  constexpr std::size_t last = std::size(stops) - 1;
  std::vector<std::uint32_t> table;
  for (std::size_t k = 0; k < 256; ++k) {
    const double at = static_cast<double>(k) / 255 * static_cast<double>(last);
    const std::size_t i = std::min(last - 1, static_cast<std::size_t>(at));
    const double part = at - static_cast<double>(i);
    const auto mixed = [&](int c) { return stops[i][c] + part * (stops[i + 1][c] - stops[i][c]); };
    table.push_back(packed(mixed(0), mixed(1), mixed(2)));
  }
  return table;
}

/// 256 entries, or none where no colours are asked for.
std::vector<std::uint32_t> table_of(const RenderDesc& d) {
  if (d.color == ColorBy::nothing) return {};
  static const std::vector<std::uint32_t> materials = palette(), temperatures = ramp();
  if (d.colors.empty()) return d.color == ColorBy::material ? materials : temperatures;
  std::vector<std::uint32_t> table(256);
  for (std::size_t k = 0; k < 256; ++k)
    table[k] = d.color == ColorBy::material ? d.colors[std::min(k, d.colors.size() - 1)]
                                            : d.colors[k * d.colors.size() / 256];
  return table;
}

}  // namespace

Result<RenderView> WorldImpl::render_view(const RenderDesc& d) {
  if (d.color != ColorBy::nothing && d.color != ColorBy::material && d.color != ColorBy::temperature)
    return invalid("render_view: color: is none of nothing, material, temperature");
  if (d.colors.size() > 256)
    return invalid("render_view: colors: at most 256, got ", std::uint64_t{d.colors.size()});
  core::PackColors colors;
  colors.by = static_cast<std::uint32_t>(d.color);
  if (d.color == ColorBy::temperature) {
    if (!std::isfinite(d.coldest) || !std::isfinite(d.hottest) || !(d.hottest - d.coldest > 1e-6))
      return invalid("render_view: hottest: must be above coldest, both finite, got ", d.coldest, " and ",
                     d.hottest);
    colors.coldest = static_cast<float>(d.coldest);
    colors.per_degree = static_cast<float>(256 / (d.hottest - d.coldest));
  }
  if (Status s = prepare(); !s) return s.error();
  RenderView v;
  v.backend = engine->backend();
  v.origin = origin_;
  v.serial = mark_view(render_view_, true);
  v.radius = static_cast<float>(0.5 * desc.spacing);
  if ((facts_ & core::fact_particles) == 0) return v;
  core::PackedParticles p;
  if (Status s = engine->pack(colors, table_of(d), p); !s) return s.error();
  const StageContext c = engine->context();
  v.stream = c.stream;
  v.count = c.particles;
  v.position = p.position;
  v.velocity = p.velocity;
  v.temperature = p.temperature;
  v.liquid_fraction = p.fraction;
  v.density = p.density;
  v.pressure = p.pressure;
  v.tag = p.tag;
  v.piece = p.piece;
  v.color = p.color;
  return v;
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
    d.live.push_back(state_.vertex_state[v] == core::vertex_live ? 1 : 0);
    d.body.push_back(lattice_.vertex_body[v] + 1);
    const core::BodyRow row = lattice_.bodies[lattice_.vertex_body[v]];
    const std::uint32_t site = lattice_.vertex_site[v];
    if (!masks.neighbour_mask.empty())
      core::each_direct([&](int dx, int dy, int dz) {
        const std::uint32_t bit = core::neighbour_bit(dx, dy, dz);
        if ((masks.neighbour_mask[v] >> bit) & 1u)
          d.arrayN[v * 27 + bit] = lattice_.site_vertex[core::site_beside(site, row, dx, dy, dz)] + 1;
      });
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

std::vector<BodyInfo> WorldImpl::bodies() const {
  std::vector<BodyInfo> all;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BodyRecord& body = bodies_[b];
    if (body.gone) continue;
    BodyInfo info;
    info.body = id_of(b);
    info.name = body.desc.name;
    info.material = {body.desc.material.index, number_};
    info.motion = body.desc.motion;
    info.held = body.held;
    all.push_back(std::move(info));
  }
  return all;
}

}  // namespace v0
}  // namespace meltsim
