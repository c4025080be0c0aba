// SPDX-License-Identifier: Apache-2.0
// What every particle gets from its neighbours, as one sum over all pairs in double, written out here: mirror images in
// walls, their edges and corners and copies across periodic faces are explicit particles. Formulas of one particle or one
// contact (material rows, floor_push, contact_response, ...) are the library's, which has tests of each; kernels and sums
// are this file's own.
//
// Beside every sum stands its scale, the sum of the sizes of what it adds up, cancellation within the terms included. An
// error is that many units in the last place of the scale.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "engine/scales.hpp"
#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/gap.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "meltsim/physics/property_table.hpp"
#include "meltsim/physics/shifting.hpp"
#include "meltsim/physics/solute.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"
#include "meltsim/physics/walls.hpp"
#include "modules/engine.hpp"

namespace modules_test {

/// What a particle is beside; several may hold.
enum Beside : std::uint32_t {
  beside_nothing = 1u << 0,  ///< deep in its liquid or body
  beside_wall = 1u << 1,
  beside_edge = 1u << 2,  ///< of two or three walls
  beside_period = 1u << 3,
  beside_other_phase = 1u << 4,   ///< liquid beside solid, solid beside liquid
  beside_other_liquid = 1u << 5,  ///< liquid
  beside_surface = 1u << 6,       ///< less than 0.9 of its surroundings are filled
  beside_crowd = 1u << 7,         ///< more neighbours than there are words for
  beside_other_body = 1u << 8,    ///< in contact
};
inline constexpr const char* beside_names[] = {"bulk",         "wall",    "edge",  "period",    "other phase",
                                               "other liquid", "surface", "crowd", "other body"};
inline constexpr int beside_count = 9;

/// A number or vector per particle with the scale of its error.
struct Summed {
  Vec3d value, lost;  ///< lost: what the last addition rounded away
  double scale = 0;
  bool asked = false;  ///< whether such a particle has it
  void add(Vec3d term, double size) {
    const Vec3d next = term - lost, sum = value + next;
    lost = (sum - value) - next;
    value = sum;
    scale += size;
    asked = true;
  }
  void add(Vec3d term) { add(term, length(term)); }
};

/// Per id.
struct PairSums {
  std::vector<std::uint32_t> beside;
  /// diffused: acceleration where viscosity comes in one stage of sph.diffuse.
  /// watched: of a body that the host watches, six one after the other: impulses of all but gravity, of the liquid's pressure and
  /// of contact, and their moments about its centre.
  std::vector<Summed> density, term, acceleration, diffused, shift, heat, iwasaki, paper, solute, watched;
  explicit PairSums(std::size_t n = 0)
      : beside(n),
        density(n),
        term(n),
        acceleration(n),
        diffused(n),
        shift(n),
        heat(n),
        iwasaki(n),
        paper(n),
        solute(n),
        watched(n) {}
};

enum Quantity {
  of_density,
  of_term,
  of_acceleration,
  of_diffused,
  of_shift,
  of_heat,
  of_iwasaki,
  of_paper,
  of_solute,
  of_watched,
  quantities
};
inline constexpr const char* quantity_names[] = {"density", "pressure term", "acceleration", "diffused",
                                                 "shift",   "heat",          "iwasaki",      "paper",
                                                 "solute",  "watched"};
inline std::vector<Summed>& quantity(PairSums& s, int q) {
  std::vector<Summed>* all[] = {&s.density, &s.term,    &s.acceleration, &s.diffused, &s.shift,
                                &s.heat,    &s.iwasaki, &s.paper,        &s.solute,   &s.watched};
  return *all[q];
}

struct PairScene {
  core::SceneConstants constants = plain_constants(0.2);
  core::SceneLattice lattice;
  core::SceneState state;
  core::FactSet facts = core::fact_particles | core::fact_fluid;
  double dt = 1e-3, heat_dt = 1e-2;
  bool has_solids() const { return (facts & core::fact_mobile) != 0; }
};

/// Rows know their tables.
inline void set_tables(core::SceneConstants& c) {
  for (std::size_t k = 0; k < c.properties.size(); ++k)
    if (c.properties[k].viscosity.points != 0 || c.properties[k].flow.index > 0)
      c.materials[k].tables = &c.properties[k];
}

/// One sum over all pairs. T: the precision that the state is rounded to; the sums are double.
template <class T>
class AllPairs {
 public:
  explicit AllPairs(const PairScene& scene)
      : scene_(scene), c_(scene.constants), n_(scene.state.position.size()), sums_(n_) {
    set_tables(c_);
    round_state();
    place_copies();
    calibrate();
    densities();
    viscosities();
    accelerations();
    if ((scene.facts & core::fact_contact) != 0) contacts();
    if ((scene.facts & core::fact_contact) != 0 && (scene.facts & core::fact_fluid) != 0) gaps();
    if ((scene.facts & core::fact_tension) != 0) tensions();
    if ((scene.facts & core::fact_isotropic) != 0) isotropy();
    watched();
    // One stage from the beginning of the sub-step is the explicit force, but for what is along the line between liquid.
    if ((scene.facts & core::fact_fluid) != 0) {
      sums_.diffused = sums_.acceleration;
      for (std::size_t i = 0; i < n_; ++i) sums_.diffused[i].add(central_[i].value, central_[i].scale);
    }
    if ((scene.facts & core::fact_shifting) != 0) shifts();
    heat();
    if (!scene.constants.species.empty()) solute();
    classify();
  }
  const PairSums& sums() const { return sums_; }
  /// In the middle of the sub-step.
  const std::vector<Vec3d>& positions() const { return x_; }

 private:
  struct Copy {
    Vec3d x;
    bool mirrored;
    Vec3d across{};  ///< 1 along axes in whose walls it is mirrored, else 0
  };
  double H() const { return c_.support; }
  bool gone(std::size_t i) const { return is_removed(tag_[i]); }
  bool solid(std::size_t i) const { return is_solid(tag_[i]); }
  const core::MaterialRow<double>& row(std::size_t i) const { return c_.materials[material_of(tag_[i])]; }

  void round_state() {
    for (std::size_t i = 0; i < n_; ++i) {
      const auto v = cast<T>(scene_.state.velocity[i]);
      x_.push_back(cast<double>(
          physics::drift(cast<T>(scene_.state.position[i]), v, static_cast<T>(0.5 * scene_.dt))));
      v_.push_back(cast<double>(v));
      volume_.push_back(static_cast<double>(static_cast<T>(scene_.state.volume[i])));
      mass_.push_back(static_cast<double>(static_cast<T>(scene_.state.mass[i])));
      tag_.push_back(scene_.state.tag[i]);
    }
  }
  Vec3d low() const { return c_.domain.min; }
  Vec3d high() const { return c_.domain.max; }
  Face face(int axis, int side) const {
    return c_.domain.bounded ? c_.domain.faces[static_cast<std::size_t>(2 * axis + side)] : Face::open;
  }
  void place_copies() {
    copies_.resize(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i)) continue;
      copies_[i] = {{x_[i], false}};
      for (int axis = 0; axis < 3; ++axis) {
        const auto along = [axis](Vec3d& v) -> double& { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; };
        Vec3d l = low(), h = high();
        const std::vector<Copy> before = copies_[i];
        for (Copy copy : before)
          for (int side = 0; side < 2; ++side) {
            Copy more = copy;
            if (face(axis, side) == Face::wall) {
              along(more.x) = 2 * (side == 0 ? along(l) : along(h)) - along(more.x);
              more.mirrored = true;
              along(more.across) = 1;
            } else if (face(axis, side) == Face::periodic) {
              along(more.x) += (side == 0 ? -1 : 1) * (along(h) - along(l));
            } else {
              continue;
            }
            copies_[i].push_back(more);
          }
      }
    }
  }
  // Wendland's C2 function, each use of it made exact on the lattice (sph_kernels.hpp).
  double bump(double r) const { return r < H() ? std::pow(1 - r / H(), 4) * (1 + 4 * r / H()) : 0; }
  double steep(double r) const { return r < H() ? std::pow(1 - r / H(), 3) : 0; }
  double epsilon2() const { return 0.01 * 0.25 * H() * H(); }
  void calibrate() {
    const double dx = c_.spacing, cell = dx * dx * dx;
    const int reach = static_cast<int>(H() / dx) + 1;
    double w = 0, f = 0, l = 0;
    for (int k = -reach; k <= reach; ++k)
      for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) {
          const double r = dx * std::sqrt(double(i * i + j * j + k * k)), x2 = dx * dx * i * i;
          w += cell * bump(r);
          f += cell * steep(r) * x2;
          l += 0.5 * cell * 2 * steep(r) * r * r / (r * r + epsilon2()) * x2;
        }
    w_ = 1 / w, f_ = 1 / f, l_ = 1 / l;
  }
  double W(double r) const { return w_ * bump(r); }
  double f(double r) const { return f_ * steep(r); }
  double L(double r) const { return l_ * 2 * steep(r) * r * r / (r * r + epsilon2()); }

  /// visit(j, copy, x_i - copy, distance) of all copies of all particles within H, its own place and images included.
  template <class Visit>
  void around(std::size_t i, const Visit& visit) const {
    for (std::size_t j = 0; j < n_; ++j)
      for (const Copy& copy : copies_[j]) {
        const Vec3d d = x_[i] - copy.x;
        const double r = length(d);
        if (r < H()) visit(j, copy, d, r);
      }
  }

  void densities() {
    term_.assign(n_, 0);
    term_scale_.assign(n_, 0);
    phi_.assign(n_, 0);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i)) continue;
      Summed phi;
      around(i, [&](std::size_t j, const Copy&, const Vec3d&, double r) {
        phi.add({volume_[j] * W(r), 0, 0});
      });
      phi_[i] = phi.value.x;  // of heat, whatever presses
      const double pressing = unstrained(i) ? phi_of_lattice(i).value.x : phi_[i];
      // Of a solid particle, what multiplies the stiffness of the liquid at the other end.
      const double stiffness = solid(i) ? 1 : row(i).tait_stiffness, lowest = !solid(i) && c_.tension ? 0 : 1;
      const double p = std::max(pressing, lowest), p7 = std::pow(p, 7);
      term_[i] = stiffness * (p7 - 1) / (pressing * pressing);
      term_scale_[i] = stiffness * (7 * p7 + 1) / (pressing * pressing);  // seven times what phi has
      if (!solid(i)) sums_.density[i] = phi;
      sums_.term[i].add({solid(i) ? -term_[i] : term_[i], 0, 0}, term_scale_[i]);
    }
  }
  /// Whether a solid particle counts its own body where the lattice has it: one that liquid touches.
  bool unstrained(std::size_t i) const {
    if (!solid(i) || scene_.lattice.bodies.empty()) return false;
    bool wet = false;
    around(i, [&](std::size_t j, const Copy& copy, const Vec3d&, double) {
      if (!copy.mirrored && !solid(j)) wet = true;
    });
    return wet;
  }
  /// Its phi. Neighbours within H of where they are count; those of its body, and their images, from where the lattice has them.
  Summed phi_of_lattice(std::size_t i) const {
    Summed phi;
    const auto coordinates = [&](std::size_t k) {
      const Vec3i p = scene_.lattice.vertex_coordinates[scene_.state.vertex_of_id[k]];
      return Vec3d{double(p.x), double(p.y), double(p.z)};
    };
    for (std::size_t j = 0; j < n_; ++j) {
      if (gone(j) || length(x_[i] - x_[j]) >= H()) continue;
      Vec3d moved{};
      if (solid(j) && body_of(tag_[j]) == body_of(tag_[i]))
        moved = x_[i] - (coordinates(i) - coordinates(j)) * c_.spacing - x_[j];
      for (const Copy& copy : copies_[j]) {
        const Vec3d a = copy.across;
        const Vec3d at =
            copy.x + Vec3d{moved.x * (1 - 2 * a.x), moved.y * (1 - 2 * a.y), moved.z * (1 - 2 * a.z)};
        phi.add({volume_[j] * W(length(x_[i] - at)), 0, 0});
      }
    }
    return phi;
  }
  double viscosity(std::size_t i) const { return mu_[i]; }
  /// Of liquids with a flow curve at the shear rate of the least-squares fit to the velocities around, walls as one particle
  /// each; mu_size_: what of it rounding reaches.
  void viscosities() {
    mu_.assign(n_, 0);
    mu_size_.assign(n_, 1);
    const auto exchange = physics::make_wall_exchange<double>(H(), c_.spacing);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || solid(i)) continue;
      mu_[i] = physics::viscosity_at(row(i), scene_.state.enthalpy[i] / scene_.state.mass[i]);
      if (row(i).tables == nullptr || !(row(i).tables->flow.index > 0)) continue;
      double M[3][3] = {}, G[3][3] = {}, S[3] = {};
      const auto add = [&](double weight, Vec3d d, Vec3d u) {
        const double x[3] = {d.x, d.y, d.z}, v[3] = {u.x, u.y, u.z};
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            M[a][b] += 0.5 * weight * x[a] * x[b];
            G[a][b] += 0.5 * weight * v[a] * x[b];
          }
      };
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
        if (copy.mirrored || r == 0) return;
        const double weight = volume_[j] * L(r), x[3] = {d.x, d.y, d.z};
        add(weight, d, (v_[i] - v_[j]) * (solid(j) ? 2.0 : 1.0));
        for (int a = 0; a < 3; ++a) S[a] += weight * x[a] * x[a] * x[a];
      });
      for (int k = 0; c_.domain.no_slip && k < 6; ++k) {
        const auto along = [k](const Vec3d& v) { return k < 2 ? v.x : k < 4 ? v.y : v.z; };
        const double d = k % 2 == 0 ? along(x_[i]) - along(low()) : along(high()) - along(x_[i]);
        if (face(k / 2, k % 2) != Face::wall || d >= H()) continue;
        const double depth = std::max(d, 0.25 * c_.spacing), inwards = k % 2 == 0 ? 1 : -1;
        Vec3d x;
        (k < 2 ? x.x : k < 4 ? x.y : x.z) = inwards * depth;
        // Neighbours inwards have components x_i - x_j against the normal.
        add(std::max(physics::wall_area(exchange, d) / depth, -inwards * S[k / 2] / (depth * depth * depth)),
            x, v_[i]);
      }
      for (int a = 0; a < 3; ++a) M[a][a] += 1e-3;
      // A = G M^-1 row by row, by Cramer's rule.
      const auto det = [](const double(&m)[3][3]) {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
      };
      double A[3][3], D2 = 0;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          double m[3][3];
          for (int p = 0; p < 3; ++p)
            for (int q = 0; q < 3; ++q) m[p][q] = q == b ? G[a][p] : M[p][q];
          A[a][b] = det(m) / det(M);
        }
      const double trace = A[0][0] + A[1][1] + A[2][2];
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          const double D = 0.5 * (A[a][b] + A[b][a]) - (a == b ? trace / 3 : 0);
          D2 += D * D;
        }
      mu_[i] = physics::flow_viscosity(row(i).tables->flow, mu_[i], std::sqrt(2 * D2));
      mu_size_[i] = 1 + 1 / std::cbrt(det(M));  // the fit divides by what neighbours span
    }
  }
  bool yields(std::size_t i) const {
    return row(i).tables != nullptr && row(i).tables->flow.yield_stress > 0;
  }
  /// The harmonic mean, of two liquids that yield the geometric one; a body is infinitely viscous.
  double viscosity(std::size_t i, std::size_t j) const {
    const double a = viscosity(i), b = viscosity(j);
    if (solid(j)) return 2 * a;
    if (yields(i) && yields(j)) return std::sqrt(a * b);
    return a + b > 0 ? 2 * a * b / (a + b) : 0;
  }
  /// What stages of sph.diffuse have beyond the explicit force of liquid i and j.
  void add_central(std::size_t i, std::size_t j, const Vec3d& d, double r) {
    if (!(central_scale_ > 0)) return;
    const double mu = viscosity(i, j) * volume_[i] * volume_[j], dx = c_.spacing;
    const double C = central_scale_ / std::pow(dx, 5);
    const Vec3d v = v_[j] - v_[i], drag = v * (mu * L(r));
    const Vec3d along = d * (mu * C * std::pow(1 - r / H(), 3) * dot(v, d) / (dx * dx));
    central_[i].add((along - drag) * (1 / mass_[i]),
                    (length(along) + length(drag)) * std::max(mu_size_[i], mu_size_[j]) / mass_[i]);
  }
  /// How much of the spring against leaks liquid i feels: its surroundings as far as they are solid, and how fast they become so.
  double leak_share(std::size_t i) const {
    double cover = 0, rate = 0;
    around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
      if (!solid(j)) return;
      const Vec3d flip = copy.across * 2.0;
      const Vec3d u = v_[i] - v_[j] + Vec3d{flip.x * v_[j].x, flip.y * v_[j].y, flip.z * v_[j].z};
      cover += volume_[j] * W(r);
      rate -= volume_[j] * f(r) * dot(u, d);
    });
    const double coming = (rate * c_.spacing / c_.sound_speed - 0.001) / 0.005, in = (cover - 0.42) / 0.05;
    return std::min(1.0, std::max({0.0, coming, in}));
  }
  /// Of liquid i and j at its other end, liquid or solid; size: of what is added up, viscous: the part of viscosity, real and artificial.
  Vec3d push(std::size_t i, std::size_t j, const Vec3d& d, double r, bool mirrored, double& size,
             Vec3d& viscous) const {
    const bool to_solid = solid(j);
    const double stiffness = to_solid ? row(i).tait_stiffness : 1, V = volume_[i] * volume_[j];
    const double terms = term_[i] + stiffness * term_[j];
    size = V * f(r) * (term_scale_[i] + stiffness * term_scale_[j]) * r;
    Vec3d force = d * (V * f(r) * terms);
    if (mirrored) return force;
    const double mu = viscosity(i, j);
    const double rho = to_solid ? 0 : 0.5 * (row(i).density + row(j).density);  // of what is damped
    const Vec3d u = v_[i] - v_[j];
    const double approach = std::min(0.0, dot(u, d)) / (r * r + epsilon2());
    const double coming = 0.5 * H() * approach;  // mu of Monaghan
    const double held = std::min(-rho * c_.artificial_viscosity * c_.sound_speed * coming,
                                 std::abs(terms) + 4 * rho * coming * coming);
    const Vec3d artificial = d * (V * f(r) * held);
    const Vec3d drag = u * (-mu * V * L(r));
    Vec3d leak{};
    if (to_solid && r < 0.9 * c_.spacing) {
      const double m = mass_[i] * mass_[j] / (mass_[i] + mass_[j]), t = c_.spring_dt;
      const double spring = 0.15 * m / (t * t) * (0.9 * c_.spacing - r);
      leak = d *
             (leak_share(i) *
              std::max(0.0, spring - physics::passing_contact<double>().dashpot * m / t * dot(u, d) / r) / r);
      size += 0.15 * m / (t * t) * 0.9 * c_.spacing;  // a difference is taken
    }
    viscous = drag + artificial;
    size += length(artificial) + length(drag) * std::max(mu_size_[i], mu_size_[j]) + length(leak);
    return force + artificial + drag + leak;
  }
  void accelerations() {
    const auto exchange = physics::make_wall_exchange<double>(H(), c_.spacing);
    const auto kernel = physics::make_kernel<double>(H(), c_.spacing);
    physics::WallBox<double> box;
    box.min = low(), box.max = high(), box.support = H();
    box.push_scale = physics::floor_push_scale<double>(H(), c_.spacing);
    for (int k = 0; k < 6; ++k)
      if (face(k / 2, k % 2) == Face::wall) box.faces |= 1u << k;
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i)) continue;
      Summed& a = sums_.acceleration[i];
      a.add(c_.surroundings.gravity);
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
        if ((solid(i) && solid(j)) || r == 0) return;
        double size = 0;
        Vec3d viscous{};
        // A solid gets the opposite of what its copy of the pair gives the liquid; images push both inwards.
        Vec3d force = solid(i) ? -push(j, i, -d, r, copy.mirrored, size, viscous)
                               : push(i, j, d, r, copy.mirrored, size, viscous);
        if (solid(i)) pressure_[i].add(force + viscous, size);
        a.add(force * (1 / mass_[i]), size / mass_[i]);
        if (!copy.mirrored && !solid(i) && !solid(j)) add_central(i, j, d, r);
      });
      if (solid(i)) continue;
      a.add(cast<double>(
          physics::floor_push(box, kernel, physics::wall_view(box, x_[i]), c_.surroundings.gravity)));
      if (!c_.domain.no_slip) continue;
      for (int k = 0; k < 6; ++k) {
        const auto along = [k](const Vec3d& v) { return k < 2 ? v.x : k < 4 ? v.y : v.z; };
        const double d = k % 2 == 0 ? along(x_[i]) - along(low()) : along(high()) - along(x_[i]);
        if ((box.faces >> k & 1u) == 0u || d >= H()) continue;
        const Vec3d drag = v_[i] * (-viscosity(i) * volume_[i] * physics::wall_area(exchange, d) /
                                    physics::wall_depth(exchange, d) / mass_[i]);
        a.add(drag, length(drag) * mu_size_[i]);
      }
    }
  }
  /// Bodies as they were built, not turned, without a past.
  void contacts() {
    const core::SceneLattice& l = scene_.lattice;
    std::vector<Vec4<double>> normal(n_);
    for (std::uint32_t v = 0; v < l.vertex_site.size(); ++v) {
      std::uint32_t mask = 0;
      for (int bit = 0; bit < 27; ++bit)
        if (vertex_at(l, v, {bit % 3 - 1, bit / 3 % 3 - 1, bit / 9 - 1}) != core::none) mask |= 1u << bit;
      const Mat3<double> upright = to_matrix(Quat<double>{});
      if (mask != 0x7ffffffu)
        normal[scene_.state.vertex_id[v]] = physics::surface_normal<double>(mask, upright);
    }
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || !solid(i) || (tag_[i] & tag_surface) == 0u) continue;
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
        if (copy.mirrored || !solid(j) || body_of(tag_[j]) == body_of(tag_[i]) || r == 0) return;
        if ((tag_[j] & tag_surface) == 0u || r * r >= 2 * c_.spacing * c_.spacing) return;
        const auto g = physics::contact_geometry(normal[i], normal[j], d, r * r, c_.spacing);
        if (!(g.overlap > 0) || !(g.weight > 0)) return;
        const double m = physics::reduced_mass(mass_[i], mass_[j]) * g.weight;
        const Vec3d force = physics::contact_response(
                                physics::body_contact<double>(), g.overlap, g.normal, v_[i] - v_[j], Vec3d{},
                                m, 0.5 * (row(i).friction + row(j).friction), scene_.dt, c_.spring_dt)
                                .force;
        // Overlap is a difference of lengths of a spacing, and the weight one of 1.
        const double size = 0.4 * physics::reduced_mass(mass_[i], mass_[j]) * c_.spacing;
        sums_.acceleration[i].add(force * (1 / mass_[i]), size / (c_.spring_dt * c_.spring_dt * mass_[i]));
        contact_[i].add(force, size / (c_.spring_dt * c_.spring_dt));
        touching_[i] = touching_[j] = true;
      });
    }
  }
  /// What a particle at the surface of a body asks of the gap to others (physics/gap.hpp).
  struct Asks {
    double open = 0, filled = 0, near = 0, sees = 0, push = 0, scale = 0;
    Vec3d to_gap;
  };
  /// The rim of a body's gaps: pressure at the origin of coordinates, and what it weighs per volume.
  struct Rim {
    double area = 0, press = 0, weight = 0, scale = 0;
  };
  bool at_surface(std::size_t i) const { return !gone(i) && solid(i) && (tag_[i] & tag_surface) != 0u; }
  Asks asks_of(std::size_t i, Rim& rim) const {
    const Vec3d gravity = c_.surroundings.gravity;
    Vec3d facing, own, bodies, liquid, pressed;
    double size = 0, level = 0, weight = 0, nearest = H(), of_facing = 0, scale = 0;
    around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
      const Vec3d g = d * (2 * volume_[i] * volume_[j] * f(r));
      if (solid(j)) {
        bodies += g;
        if (copy.mirrored) return;
        if (body_of(tag_[j]) == body_of(tag_[i])) {
          own += g;
        } else if (at_surface(j)) {
          facing += g;
          of_facing += length(g);
          nearest = std::min(nearest, r);
        }
        return;
      }
      const double p = 0.5 * (term_[j] + row(j).tait_stiffness * term_[i]);
      liquid += g;
      pressed += g * p;
      size += length(g);
      level += length(g) * (p + row(j).density * dot(gravity, d));
      weight += length(g) * row(j).density;
      scale += length(g) * 0.5 * (term_scale_[j] + row(j).tait_stiffness * term_scale_[i]);
    });
    Asks a;
    a.sees = length(facing);
    if (!(a.sees > 0)) return a;
    const Vec3d n = facing * (1 / a.sees);
    const double open = -dot(own, n), fills = open > 0 ? dot(liquid, n) / open : 0;
    a.near = std::clamp((1.9 - nearest / c_.spacing) / 0.2, 0.0, 1.0) *
             (1 - std::clamp((fills - 0.85) / 0.15, 0.0, 1.0));
    a.open = open;
    a.filled = dot(pressed, n);
    a.to_gap = n * (-0.5 * c_.spacing);
    a.scale = scale * of_facing / a.sees;  // directions are as inexact as what adds up to them
    const double S = length(bodies), area = a.near * S;
    rim.area += area;
    if (!(size > 0) || !(S > 0)) return a;
    const double wet = std::clamp(-dot(liquid, bodies) / (S * S), 0.0, 1.5) * area / size;
    rim.press += wet * (level - weight * dot(gravity, x_[i]));
    rim.weight += wet * weight;
    rim.scale += wet * scale;
    return a;
  }
  /// Liquid between bodies that may all move.
  void gaps() {
    const double c = physics::gap_scale(physics::make_kernel<double>(H(), c_.spacing), c_.spacing);
    const core::Scales scales = core::scales_of(c_, scene_.lattice);
    std::vector<Rim> rims(scene_.lattice.bodies.size());
    std::vector<Asks> all(n_);
    for (std::size_t i = 0; i < n_; ++i)
      if (at_surface(i)) all[i] = asks_of(i, rims[body_of(tag_[i]) - 1]);
    // Sums over rims are whole numbers of these units, of which each of 26 particles is rounded to one.
    const double eps = std::numeric_limits<T>::epsilon(),
                 areas = 26 * c_.spacing * c_.spacing / 16777216 / eps;
    const double forces = 26 * std::ldexp(scales.largest_mass, 1 - scales.sum_bits) * scales.spacing /
                          std::min(scales.spring_dt, scene_.dt) / scene_.dt / eps;
    for (std::size_t i = 0; i < n_; ++i) {
      Asks& a = all[i];
      if (!(a.sees > 0)) continue;
      const Rim& rim = rims[body_of(tag_[i]) - 1];
      const double p =
          !(rim.area > 0)
              ? 0
              : std::max(0.0, (rim.press + rim.weight * dot(c_.surroundings.gravity, x_[i] + a.to_gap)) /
                                  rim.area);
      const double rounding = rim.area > 0 ? (rim.scale + p * areas + forces) / rim.area : 0;
      a.push = std::max(0.0, c * a.near * (a.open * p - a.filled) / a.sees);
      a.scale = c * a.near * (std::abs(a.open) * rounding + a.scale) / a.sees;
    }
    for (std::size_t i = 0; i < n_; ++i)
      if (at_surface(i))
        around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
          if (copy.mirrored || !at_surface(j) || body_of(tag_[j]) == body_of(tag_[i])) return;
          const Asks &a = all[i], &b = all[j];
          const double sees = a.sees + b.sees, V = 2 * volume_[i] * volume_[j];
          const Vec3d force = d * (V * f(r) * (a.push * a.sees + b.push * b.sees) / sees);
          const double size = V * f(r) * r * (a.scale * a.sees + b.scale * b.sees) / sees;
          sums_.acceleration[i].add(force * (1 / mass_[i]), size / mass_[i]);
          pressure_[i].add(force, size);
        });
  }
  void watched() {
    for (std::size_t b = 0; b < scene_.lattice.bodies.size(); ++b) {
      if (scene_.lattice.bodies[b].watched == 0u) continue;
      Vec3d first{};
      double mass = 0;
      const auto each = [&](const auto& visit) {
        for (std::size_t i = 0; i < n_; ++i)
          if (!gone(i) && solid(i) && body_of(tag_[i]) == b + 1) visit(i);
      };
      each([&](std::size_t i) { first += x_[i] * mass_[i], mass += mass_[i]; });
      each([&](std::size_t i) {
        const Vec3d arm = x_[i] - first * (1 / mass);
        const Summed& a = sums_.acceleration[i];
        Summed all;
        all.add((a.value - c_.surroundings.gravity) * mass_[i], a.scale * mass_[i]);
        const Summed* const parts[] = {&all, &pressure_[i], &contact_[i]};
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3d impulse = parts[k]->value * scene_.dt;
          const double size = parts[k]->scale * scene_.dt;
          sums_.watched[6 * b + k].add(impulse, size);
          sums_.watched[6 * b + 3 + k].add(cross(arm, impulse), length(arm) * size);
        }
      });
    }
  }
  /// Isotropic pressure: what the surroundings of liquid lack of an isotropic second moment, times its pressure, as a stress.
  void isotropy() {
    std::vector<Mat3<double>> stress(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || solid(i)) continue;
      Mat3<double> A;
      around(i, [&](std::size_t j, const Copy&, const Vec3d& d, double r) {
        const double x[3] = {d.x, d.y, d.z};
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) A.m[a][b] += volume_[j] * f(r) * x[a] * x[b];
      });
      const double third = (A.m[0][0] + A.m[1][1] + A.m[2][2]) / 3;
      double size = 0;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) {
          A.m[a][b] = (a == b ? 1 : 0) - A.m[a][b] / third;
          size += A.m[a][b] * A.m[a][b];
        }
      const double share = std::min(1.0, std::max(0.0, 2 - 5 * std::sqrt(size)));
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) stress[i].m[a][b] = share * term_[i] * A.m[a][b];
    }
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i)) continue;
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
        const double x[3] = {d.x, d.y, d.z},
                     side[3] = {1 - 2 * copy.across.x, 1 - 2 * copy.across.y, 1 - 2 * copy.across.z};
        double force[3] = {};
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            force[a] += (stress[i].m[a][b] + side[a] * side[b] * stress[j].m[a][b]) * x[b];
        const double V = volume_[i] * volume_[j] * f(r) / mass_[i];
        // Of the order of 1 is what is rounded of the moments; the share falls by five times that.
        const double terms = (solid(i) ? 0 : term_scale_[i]) + (solid(j) ? 0 : term_scale_[j]);
        sums_.acceleration[i].add(Vec3d{force[0], force[1], force[2]} * V, V * terms * r);
        if (solid(i))
          pressure_[i].add(Vec3d{force[0], force[1], force[2]} * (V * mass_[i]), V * mass_[i] * terms * r);
      });
    }
  }
  /// What surface tension asks of a liquid particle; *_size: what rounding reaches of it.
  struct Surface {
    Mat3<double> stress{};
    double stress_size = 0;
    Vec3d wall{};  ///< m
    double wall_size = 0;
    double free = 0, free_size = 0, skin = 0, skin_size = 0;
  };
  Surface surface_of(std::size_t i) const {
    const auto kernel = physics::make_kernel<double>(H(), c_.spacing);
    const double tension = row(i).tension;
    Surface s;
    if (!(tension > 0)) return s;
    physics::SurfaceSums<double> sums;
    double all = 0, walls = 0;  // sizes
    around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
      const Vec3d term = d * (volume_[j] * steep(r));
      all += length(term);
      if (!copy.mirrored && !solid(j)) {
        sums.all +=
            term *
            (material_of(tag_[i]) == material_of(tag_[j]) ? 1 : std::min(1.0, row(j).tension / tension));
        return;
      }
      walls += length(term);
      sums.all += term;
      sums.wall += term;
      sums.normal += copy.mirrored
                         ? Vec3d{term.x * copy.across.x, term.y * copy.across.y, term.z * copy.across.z}
                         : term;
      sums.cover += volume_[j] * steep(r);
      sums.wetting += volume_[j] * steep(r) * cosine_at(j);
    });
    const physics::SurfaceStress<double> S = physics::surface_stress(kernel, tension, phi_[i], sums);
    s.stress = {{{S.along.x, S.shear.x, S.shear.y},
                 {S.shear.x, S.along.y, S.shear.z},
                 {S.shear.y, S.shear.z, S.along.z}}};
    s.wall = physics::wall_direction(kernel, sums);
    s.wall_size = walls > 0 ? walls / length(sums.normal) : 0;
    s.free = physics::free_share(kernel, sums);
    s.skin = physics::skin_share(kernel, sums);
    // e rises by 8 where |g| H does by 1.
    const double g = f_ * length(sums.all), gw = f_ * length(sums.wall), steps = 8 * H() * f_;
    s.free_size = s.free + steps * all;
    s.skin_size = s.skin + steps * (all + walls);
    s.stress_size =
        2 * tension / std::max(phi_[i], 0.5) * (f_ * all * s.free + g * s.free_size + f_ * walls + gw);
    return s;
  }
  /// Of the solid that j is, or of the wall that its image is in.
  double cosine_at(std::size_t j) const {
    return solid(j) ? row(j).wetting : physics::wetting_cosine(c_.domain.contact_angle);
  }
  /// Force of surface tension on liquid i from j or its image, divided by both volumes.
  Vec3d pull(const std::vector<Surface>& at, std::size_t i, std::size_t j, const Copy& copy, const Vec3d& d,
             double r, double& size) const {
    const Surface &a = at[i], &b = at[j];
    const double s = row(i).cohesion, q = 1 - r / H(), w = 12 * std::pow(q, 5) - q * q,
                 w_size = 12 * std::pow(q, 5) + q * q;
    if (!copy.mirrored && !solid(j)) {
      const double mu = 0.5 * std::min(row(i).skin_viscosity, row(j).skin_viscosity),
                   u = dot(v_[i] - v_[j], d);
      const double cohesion = 0.5 * std::min(s, row(j).cohesion), drag = mu * L(r) / (r * r + epsilon2());
      size = (a.stress_size + b.stress_size) * f(r) * r +
             cohesion * (a.free_size + b.free_size) * w_size * r +
             drag * (a.skin_size + b.skin_size) * r * r * (length(v_[i]) + length(v_[j]));
      return (a.stress * d + b.stress * d) * -f(r) +
             d * (cohesion * (a.free + b.free) * w - drag * (a.skin + b.skin) * u);
    }
    // Of walls twice the strength.
    const double cohesion = s * (1 + cosine_at(j)) / 2 * (solid(j) ? 1 : 2);
    const auto turned = [&a](Vec3d v) { return v - a.wall * (2 * dot(a.wall, v)); };
    const Vec3d Sd = a.stress * d;
    size =
        2 * a.stress_size * f(r) * r + 4 * length(Sd) * a.wall_size * f(r) + std::fabs(cohesion) * w_size * r;
    return (Sd + turned(a.stress * turned(d))) * -f(r) + d * (cohesion * w);
  }
  void tensions() {
    std::vector<Surface> at(n_);
    for (std::size_t i = 0; i < n_; ++i)
      if (!gone(i) && !solid(i)) at[i] = surface_of(i);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || solid(i)) continue;
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double r) {
        if (r == 0) return;
        double size = 0;
        const double volumes = volume_[i] * volume_[j];
        const Vec3d force = pull(at, i, j, copy, d, r, size) * volumes;
        sums_.acceleration[i].add(force * (1 / mass_[i]), size * volumes / mass_[i]);
        if (solid(j) && !copy.mirrored)  // the opposite
          sums_.acceleration[j].add(-force * (1 / mass_[j]), size * volumes / mass_[j]);
      });
    }
  }
  void shifts() {
    const auto kernel = physics::make_kernel<double>(H(), c_.spacing);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || solid(i)) continue;
      Summed g;
      around(i, [&](std::size_t j, const Copy&, const Vec3d& d, double r) {
        const double q = W(r) / W(c_.spacing);
        g.add(d * (volume_[j] * f(r) * (1 + 2 * std::pow(q, 4))));
      });
      const auto moved = [&](Vec3d sum) {
        return physics::shift_displacement(kernel, c_.spacing, c_.sound_speed, scene_.dt, phi_[i], sum);
      };
      // A limit has no scale of its own: that of what is cut.
      const double rate = 0.1 * c_.sound_speed * scene_.dt * H();
      sums_.shift[i].add(moved(g.value), rate * g.scale * 10);  // share of phi: a slope of 10
    }
  }
  double temperature(std::size_t i) const {
    return physics::temperature_of(row(i), scene_.state.enthalpy[i] / scene_.state.mass[i]);
  }
  double conduction_share(std::size_t i) const {
    const auto correction = physics::make_conduction_share<double>(H(), c_.spacing);
    if ((scene_.facts & core::fact_fluid) == 0) {  // then only what is at a surface can lack neighbours
      if ((tag_[i] & tag_surface) == 0u) return 1;
      double phi = 0;
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d&, double r) {
        if (!copy.mirrored) phi += volume_[j] * W(r);
      });
      return physics::conduction_share(correction, phi);
    }
    const auto kernel = physics::make_kernel<double>(H(), c_.spacing);
    physics::WallBox<double> box;
    box.min = low(), box.max = high(), box.support = H();
    box.cover_scale = physics::wall_cover_scale<double>(H(), c_.spacing);
    for (int k = 0; k < 6; ++k)
      if (face(k / 2, k % 2) == Face::wall) box.faces |= 1u << k;
    return physics::conduction_share(correction, phi_[i] * (1 - physics::wall_cover(box, kernel, x_[i])));
  }
  /// Resistivity of i toward the temperature of j; what changes its phase follows that.
  double resistivity(std::size_t i, std::size_t j) const {
    const core::MaterialRow<double>& m = row(i);
    const double h = scene_.state.enthalpy[i] / scene_.state.mass[i], t = temperature(i);
    const double fraction = physics::liquid_fraction(m, h);
    const bool exposed = solid(i) && (tag_[i] & tag_surface) != 0u;
    const bool changes = fraction < 1 && (fraction > 0 || (exposed && m.melts != 0u));
    const double k = changes ? physics::conductivity_toward(m, t, temperature(j))
                             : physics::conductivity_at(m, fraction, t);
    return share_[i] / k;
  }
  void heat() {
    share_.resize(n_);
    for (std::size_t i = 0; i < n_; ++i)
      if (!gone(i)) share_[i] = conduction_share(i);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i)) continue;
      const double t = temperature(i);
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d&, double r) {
        if (copy.mirrored) return;
        const double other = temperature(j), size = std::fabs(t) + std::fabs(other);
        const double g = volume_[i] * volume_[j] * L(r) * 2 / (resistivity(i, j) + resistivity(j, i));
        sums_.heat[i].add({g * (other - t), 0, 0}, g * size);
        const double rate = 0.5 * (row(i).diffusivity + row(j).diffusivity) * volume_[j] * L(r);
        sums_.iwasaki[i].add({rate * (other - t), 0, 0}, rate * size);
      });
    }
    if (!c_.domain.bounded) return;
    for (int axis = 0; axis < 3; ++axis)
      if (face(axis, 0) == Face::periodic) return;  // wrapped rows have an order of their own
    paper();
  }
  /// Liquid of the solvent and bodies of the species exchange it; nothing else holds it, and images do not. Where the species
  /// precipitates, supersaturated liquid within 1.5 spacings of a body is crystals as the body is, and what a pair moves is
  /// bounded by the room of the crystals that take it in.
  void solute() {
    const auto& s = c_.species[0];
    const auto correction = physics::make_conduction_share<double>(H(), c_.spacing);
    const auto holds = [&](std::size_t i) {
      return material_of(tag_[i]) == (solid(i) ? s.solute : s.solvent);
    };
    const bool precipitates = s.saturation.points > 0;
    // Resistivity of crystals: of the pair.
    std::vector<double> u(n_), resistivity(n_), room(n_, std::numeric_limits<double>::infinity());
    std::vector<bool> crystal(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || !holds(i)) continue;
      double phi = 0;
      bool beside_body = false;
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d&, double r) {
        if (copy.mirrored) return;
        if (holds(j)) phi += volume_[j] * W(r);
        if (r <= 1.5 * c_.spacing && solid(j) && material_of(tag_[j]) == s.solute) beside_body = true;
      });
      const double w = scene_.state.solute[0][i] / mass_[i];
      const double saturated =
          precipitates ? physics::property_at(s.saturation, temperature(i)) : s.solubility;
      crystal[i] = solid(i) || (precipitates && w > saturated && beside_body);
      u[i] = crystal[i] ? std::min(w, saturated) : w;
      if (precipitates) room[i] = crystal[i] ? 1 - w : 1;
      resistivity[i] =
          physics::conduction_share(correction, phi) *
          (crystal[i] ? physics::front_resistivity(s, w, saturated) : physics::solute_resistivity(s, w));
    }
    const auto of_pair = [&](std::size_t i, std::size_t j, double r) {
      if (!crystal[i] && !crystal[j]) return resistivity[i] + resistivity[j];
      return physics::across_front((crystal[i] ? resistivity[i] : 0) + (crystal[j] ? resistivity[j] : 0),
                                   physics::solute_resistivity(s, s.solubility), c_.spacing, r, u[i], u[j]);
    };
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i) || !holds(i)) continue;
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d&, double r) {
        if (copy.mirrored || !holds(j)) return;
        const double g = volume_[i] * volume_[j] * L(r) * 2 / of_pair(i, j, r);
        sums_.solute[i].add({g * std::max(std::min(u[j] - u[i], room[i]), -room[j]), 0, 0},
                            g * (u[i] + u[j]));
      });
    }
  }
  /// Eq. (4): upwards over half the step, then downwards over the other half; the order is that of cells, ids within one.
  void paper() {
    const Vec3d e = high() - low();
    const int reach = core::packed_reach(c_.domain, H(), n_);
    const auto cell = [](double at, double extent, std::int32_t n) {
      return static_cast<std::int32_t>(std::clamp(std::floor(at * n / extent), 0.0, double(n - 1)));
    };
    struct Place {
      std::int32_t z, y, x;
      std::size_t i;
      bool operator<(const Place& o) const { return std::tie(z, y, x, i) < std::tie(o.z, o.y, o.x, o.i); }
    };
    std::vector<Place> order;
    for (std::size_t i = 0; i < n_; ++i)
      if (!gone(i))
        order.push_back({cell(x_[i].z - low().z, e.z, core::cells_along(e.z, H())),
                         cell(x_[i].y - low().y, e.y, core::cells_along(e.y, H())),
                         cell(x_[i].x - low().x, e.x, core::cells_along(e.x, H() / reach)), i});
    std::sort(order.begin(), order.end());
    std::vector<double> t(n_), next(n_);
    for (std::size_t i = 0; i < n_; ++i) t[i] = gone(i) ? 0 : temperature(i);
    for (const bool upwards : {true, false}) {
      for (const Place& p : order) {
        const std::size_t i = p.i;
        double change = 0;
        const auto visit = [&](std::size_t j) {
          const double r = length(x_[i] - x_[j]);
          if (r >= H()) return;
          const double k = 0.5 * (row(i).diffusivity + row(j).diffusivity) * L(r) * 0.5 * scene_.heat_dt;
          const double now = t[i] + change;
          const double update = k * volume_[j] * (t[j] - now) / (1 + k * (volume_[i] + volume_[j]));
          change += update;
          sums_.paper[i].add({update, 0, 0}, k * volume_[j] * (std::fabs(t[j]) + std::fabs(now)));
        };
        if (upwards)
          for (auto q = order.begin(); q != order.end(); ++q) visit(q->i);
        else
          for (auto q = order.rbegin(); q != order.rend(); ++q) visit(q->i);
        next[i] = t[i] + change;
      }
      t = next;
    }
  }
  void classify() {
    for (std::size_t i = 0; i < n_; ++i) {
      if (gone(i)) continue;
      std::uint32_t& b = sums_.beside[i];
      int walls = 0, neighbours = 0;
      for (int k = 0; k < 6; ++k) {
        const auto along = [k](const Vec3d& v) { return k < 2 ? v.x : k < 4 ? v.y : v.z; };
        const double d = k % 2 == 0 ? along(x_[i]) - along(low()) : along(high()) - along(x_[i]);
        if (face(k / 2, k % 2) == Face::wall && d < H()) ++walls;
      }
      around(i, [&](std::size_t j, const Copy& copy, const Vec3d& d, double) {
        if (copy.mirrored) return;
        ++neighbours;
        if (length(x_[i] - d - x_[j]) > 1e-9) b |= beside_period;
        if (solid(j) != solid(i)) b |= beside_other_phase;
        else if (!solid(i) && material_of(tag_[i]) != material_of(tag_[j])) b |= beside_other_liquid;
      });
      if (walls > 0) b |= beside_wall;
      if (walls > 1) b |= beside_edge;
      if (phi_[i] < 0.9) b |= beside_surface;
      if (neighbours > 300) b |= beside_crowd;
      if (touching_[i]) b |= beside_other_body;
      if (b == 0u) b = beside_nothing;
    }
  }

  const PairScene& scene_;
  core::SceneConstants c_;
  std::size_t n_;
  PairSums sums_;
  std::vector<Vec3d> x_, v_;
  std::vector<double> volume_, mass_, phi_, term_, term_scale_, share_, mu_, mu_size_;
  std::vector<std::uint32_t> tag_;
  std::vector<std::vector<Copy>> copies_;
  std::vector<Summed> pressure_ = std::vector<Summed>(n_), contact_ = pressure_;  ///< on solids [N]
  std::vector<Summed> central_ = std::vector<Summed>(n_);                         ///< [m/s^2]
  double central_scale_ = physics::central_viscosity_scale(H(), c_.spacing);
  std::vector<bool> touching_ = std::vector<bool>(n_);
  double w_ = 1, f_ = 1, l_ = 1;
};

/// Errors in units in the last place of T of their scales, by class.
template <class T>
struct Errors {
  std::vector<double> of[quantities][beside_count];
  void note(PairSums expected, PairSums found) {
    for (int q = 0; q < quantities; ++q)
      for (std::size_t i = 0; i < expected.beside.size(); ++i) {
        const Summed &want = quantity(expected, q)[i], &have = quantity(found, q)[i];
        if (!want.asked || !have.asked) continue;
        const double unit = static_cast<double>(std::numeric_limits<T>::epsilon());
        // have.scale: what else was rounded to find it.
        const double error = length(have.value - want.value) / (unit * (want.scale + have.scale));
        for (int b = 0; b < beside_count; ++b)
          if ((expected.beside[i] >> b & 1u) != 0u) of[q][b].push_back(error);
      }
  }
};

}  // namespace modules_test
