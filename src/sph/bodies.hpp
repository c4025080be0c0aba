// SPDX-License-Identifier: Apache-2.0
// Kernels of the liquid and of its coupling to solids. One gather each; formulas in meltsim/physics/.
#pragma once

#include "frame/lattice.hpp"
#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "shared/pair_forces.hpp"
#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

using core::Frame;
using core::viscosity_of;
using physics::MaterialRow;

/// Operand beside the velocity of a solid particle: -tau_k, possibly -0, a value that no liquid's term has without
/// tension. So a liquid particle need not load the tags of its neighbours.
template <class T>
MELTSIM_HD T stored_solid_term(T phi) {
  return -physics::solid_term(phi);
}
template <class T>
MELTSIM_HD bool is_solid_term(T term) {
  return sign_bit(term) != 0u;
}

/// phi of a particle, divided by the scale of the kernel.
template <class T>
struct Surroundings {
  T phi{};
  MELTSIM_HD void add(const Surroundings& o) { phi += o.phi; }
  struct Lanes {
    spatial::LaneSum<T> phi;
    Surroundings at(std::size_t l) const { return {phi.at(l)}; }
    void put(std::size_t l, const Surroundings& s) { phi.put(l, s.phi); }
    Surroundings total() const { return {phi.total()}; }
  };
};

/// phi and P/phi^2 of every liquid particle, -tau_k of every solid one: the sum of V W over everything within H and over
/// its images in walls. First sweep of a sub-step: it finds the neighbours, too.
template <class T, spatial::SearchKind kind>
struct DensityBody {
  Frame<T> w;
  static constexpr bool Periodic = kind == spatial::SearchKind::periodic;
  static constexpr bool shared = true, mirrors = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t parts) {
    return sizeof(T) == sizeof(float) && parts == 1u && !Periodic ? 48u : 0u;
  }
  /// Other values are slower: 28, 36, 40.
  static constexpr std::uint32_t resident_warps_of_two = 32u;
  using Sum = Surroundings<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    Sum s;
    if (w.f.group_of[i] == core::none) return s;  // removed
    spatial::find_part<kind>(w, i, k, parts, [&](const Vec4<T>& xj, T r2) { found(s, xj.w, r2); });
    return s;
  }
  /// core::can_gather_two; where cells are counted.
  MELTSIM_HD std::uint32_t two(std::uint64_t i, bool alone, Sum (&s)[2]) const {
    return spatial::find_two(w, i, alone, [&](const Vec4<T>& xj, T r2, T r2_next) {
      found(s[0], xj.w, r2);
      found(s[1], xj.w, r2_next);
    });
  }
  MELTSIM_HD std::uint64_t left_over(std::uint64_t k) const { return spatial::first_of_line(w, k); }
  /// Term of a neighbour, or of its image, at its distance.
  MELTSIM_HD void found(Sum& s, T volume, T r2) const {
    s.phi += volume * physics::kernel_shape(w.c.kernel, std::sqrt(r2));
  }
  MELTSIM_HD void join(std::uint64_t i) const {
    if (w.f.group_of[i] != core::none) spatial::join_words(w, i);
  }
  MELTSIM_HD bool unfinished(std::uint64_t i) const {
    return w.f.group_of[i] != core::none && physics::wall_view(w.c.walls, xyz(w.f.position[i])).axes != 0u;
  }
  /// The images of the neighbours, distributed anew: beside an edge a third of the rows may hold half of them.
  MELTSIM_HD void more(std::uint64_t i, std::uint32_t k, std::uint32_t parts, Sum& s) const {
    if (w.f.group_of[i] == core::none) return;
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
    if (walls.axes == 0u) return;
    spatial::sweep_part<Periodic>(w, i, k, parts,
                                  [&](std::uint32_t, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
                                    s.phi += xj.w * physics::image_shape(w.c.kernel, walls, x_ij, r2);
                                  });
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    const std::uint32_t tag = w.f.tag[i];
    const T phi = w.c.kernel.w_scale * s.phi;
    T density = 0, term = 0;
    if (is_fluid(tag)) {
      density = phi;
      term = physics::pressure_term(
          physics::tait_pressure(w.f.materials[material_of(tag)].tait_stiffness, phi, w.c.lowest_phi), phi);
    } else if (is_solid(tag)) {
      term = stored_solid_term(phi);
    }
    w.f.density[i] = density;
    w.f.velocity[i].w = term;
    if (w.f.heat_share != nullptr) w.f.heat_share[i] = phi;
  }
};

/// mu of every liquid particle, where it depends on temperature or contents.
template <class T>
struct ViscosityBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_fluid(tag)) return;
    const T mu = physics::viscosity_at(w.f.materials[material_of(tag)],
                                       w.f.enthalpy[i] / static_cast<double>(w.f.mass[i]));
    w.f.viscosity[i] = w.f.solute == nullptr ? mu : of_mixture(i, mu);
  }
  MELTSIM_HD T of_mixture(std::uint64_t i, T solvent) const {
    physics::MixtureViscosity mixture;
    for (std::uint32_t k = 0; k < w.species; ++k)
      mixture.add(w.f.species[k], core::solute_at(w, k, i) / static_cast<double>(w.f.mass[i]));
    return static_cast<T>(mixture.with(static_cast<double>(solvent)));
  }
};

using core::ForceSum;

/// Kinds of neighbours of a liquid particle: the same liquid alone; that and solids; or several liquids, varying
/// viscosities, liquid with tension. In the first two only position and velocity of a neighbour are loaded.
enum class Company { liquid, solids, any };

template <class T>
Company company_of(const Frame<T>& w) {
  if (core::liquid_alone(w)) return Company::liquid;
  if (!w.one_liquid || w.f.viscosity != nullptr) return Company::any;
  return w.c.lowest_phi < T(1) ? Company::any : Company::solids;
}

/// Pressure, viscosity, gravity and walls on every liquid particle.
template <class T, Company company, bool Periodic>
struct ForcesBody {
  Frame<T> w;
  static constexpr bool ends_first = true;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) {
    return sizeof(T) != sizeof(float) ? 0u : 36u;
  }
  using Sum = ForceSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  static constexpr bool any = company == Company::any;
  struct Own {
    std::uint32_t tag;
    T stiffness, density, viscosity;
    Vec4<T> x, v;
    physics::WallView<T> walls;
    bool yields;
  };
  struct Stored {
    Vec4<T> v;
    T viscosity, density;  ///< of the pair
    bool solid;            ///< set if every neighbour loads its tag
  };
  struct Other {
    Vec3<T> v;
    T term, viscosity, density;
    bool solid;
  };
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return is_fluid(w.f.tag[i]); }
  MELTSIM_HD Own own(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const Vec4<T> x = w.f.position[i];
    return {tag,
            m.tait_stiffness,
            m.density,
            viscosity_of(w, i, m),
            x,
            w.f.velocity[i],
            physics::wall_view(w.c.walls, xyz(x)),
            any && physics::yields(m)};
  }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t j) const {
    return {w.f.velocity[j], own.viscosity, own.density, false};
  }
  /// Loads tag and material of a neighbour if the scene leaves its kind open.
  MELTSIM_HD void settle(const Own& own, Stored& s, std::uint64_t, std::uint32_t j) const {
    if (!any) return;
    const std::uint32_t tag = w.f.tag[j];
    s.solid = is_solid(tag);
    const bool same = s.solid || material_of(tag) == material_of(own.tag);
    if (!same) s.density = T(0.5) * (own.density + w.f.materials[material_of(tag)].density);
    if (!same || (w.f.viscosity != nullptr && !s.solid)) {
      const MaterialRow<T>& m = w.f.materials[material_of(tag)];
      s.viscosity = physics::pair_viscosity(own.viscosity, viscosity_of(w, j, m),
                                            own.yields && (same || physics::yields(m)));
    }
  }
  /// A solid acts like the same liquid, except for its pressure term and the pair's viscosities (as_liquid in coupling.hpp).
  MELTSIM_HD Other other(const Own& own, const Stored& s) const {
    const bool solid = any ? s.solid : company == Company::solids && is_solid_term(s.v.w);
    return {xyz(s.v), solid ? own.stiffness * -s.v.w : s.v.w,
            solid ? physics::no_slip_viscosity(s.viscosity) : s.viscosity,
            solid ? physics::undamped<T>() : s.density, solid};
  }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Other& other, const spatial::Pair<T>& pair,
                      Along along) const {
    const Vec3<T> v_ij = xyz(own.v) - other.v;
    const physics::LiquidPair<T> p{own.x.w,         pair.volume,   own.v.w,   other.term,
                                   other.viscosity, other.density, pair.x_ij, v_ij};
    auto factors = physics::liquid_factors(w.c.kernel, w.c.artificial_viscosity, w.c.sound_speed, p, pair.r2);
    if constexpr (!std::is_same<Along, spatial::NoImages>::value) factors.along += along;
    sum.force = physics::add_liquid_force(sum.force, factors, pair.x_ij, v_ij);
  }
  MELTSIM_HD void add_normal(Sum& sum, const Vec3<T>& force) const { sum.force += force; }
  MELTSIM_HD T mirrored(const Own& own, const Other& other, T volume) const {
    return physics::pressure_factor(own.x.w, volume, own.v.w + other.term, T(0), w.c.kernel.grad_scale);
  }
  MELTSIM_HD static T mirrored_shape(const physics::SphKernel<T>& kernel, T r) {
    return physics::kernel_gradient_shape(kernel, r);
  }
  MELTSIM_HD bool may_be_rare(const Other& other) const { return other.solid; }
  /// A solid so near that liquid could slip through.
  MELTSIM_HD bool rare(const Own&, const Other& other, const spatial::Pair<T>& pair) const {
    return other.solid & (pair.r2 < w.c.leak_distance2);
  }
  MELTSIM_HD void add_rare(Sum& sum, const Own& own, const Other& other, std::uint64_t i, std::uint32_t j,
                           const spatial::Pair<T>& pair) const {
    sum.force += core::leak_force_of(w, i, j, pair.x_ij, xyz(own.v) - other.v, pair.r2);
  }
  /// Viscosities, densities and phases have lanes of their own only if they are loaded per neighbour.
  struct Lanes {
    spatial::LaneVectors<T> v;
    T viscosity, density;
    std::conditional_t<any, spatial::LaneVectors<T>, spatial::NoImages> asked;
    Stored at(std::size_t k) const {
      if constexpr (any) return {v.at(k), asked.x[k], asked.y[k], asked.z[k] != T(0)};
      else return {v.at(k), viscosity, density, false};
    }
    void load(const ForcesBody& body, const Own& own, std::uint64_t i, const std::uint32_t* slots,
              std::uint32_t n, const T*) {
      v.load(body.w.f.velocity, slots, n);
      viscosity = own.viscosity;
      density = own.density;
      if constexpr (any) {
        for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k) {
          Stored s{Vec4<T>{}, viscosity, density, false};
          body.settle(own, s, i, slots[k]);
          asked.x[k] = s.viscosity;
          asked.y[k] = s.density;
          asked.z[k] = s.solid ? T(1) : T(0);
        }
      }
    }
  };
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_fluid(tag))
      w.f.acceleration[i] = acceleration(i, tag, w.f.position[i], xyz(w.f.velocity[i]), w.f.mass[i], s);
  }
  /// Acceleration of a liquid particle at x with velocity v.
  MELTSIM_HD Vec3<T> acceleration(std::uint64_t i, std::uint32_t tag, const Vec4<T>& x, Vec3<T> v, T mass,
                                  const Sum& s) const {
    Vec3<T> force = s.force;
    const auto walls = physics::wall_view(w.c.walls, xyz(x));
    if (walls.axes != 0u)
      force += physics::floor_push(w.c.walls, w.c.kernel, walls, w.f.clock->gravity) * mass;
    if (w.c.no_slip != 0u && !w.inviscid)
      force += no_slip(xyz(x), v, viscosity_of(w, i, w.f.materials[material_of(tag)]), x.w);
    return force * (T(1) / mass) + w.f.clock->gravity;
  }
  /// One particle, where bodies are called one by one.
  MELTSIM_HD void operator()(std::uint64_t i) const { finish(i, part(i, 0, 1)); }
  /// Traction of every wall within reach, each with its own velocity.
  MELTSIM_HD Vec3<T> no_slip(Vec3<T> x, Vec3<T> v, T mu, T volume) const {
    Vec3<T> force{};
    core::for_each_sticky_wall(w, x, mu, volume,
                               [&](T factor, Vec3<T> velocity) { force += (velocity - v) * factor; });
    return force;
  }
};

/// Which slots hold particles of a kind, 32 to a call.
template <class T>
struct KindBitsBody {
  Frame<T> w;
  std::uint32_t kind;   ///< tag_solid: particles of bodies; 0: liquid
  std::uint32_t* bits;  ///< of the kind
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const auto first = static_cast<std::uint32_t>(32u * k);
    std::uint32_t word = 0;
    for (std::uint32_t b = 0; b < 32u && first + b < w.particles; ++b)
      word |= ((w.f.tag[first + b] & (tag_solid | tag_removed)) == kind ? 1u : 0u) << b;
    bits[k] = word;
  }
};

/// leak_share of a liquid particle.
template <class T>
struct CoverBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    if (!is_fluid(w.f.tag[i])) return;
    physics::SolidCover<T> cover;
    if (spatial::any_marked(w, i, w.f.solid_bits)) {
      const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[i]));
      const Vec3<T> v = xyz(w.f.velocity[i]);
      spatial::for_each_neighbour(w, i, [&](std::uint32_t k, const Vec4<T>& xk, const Vec3<T>& x_ik, T r2) {
        if (is_solid(w.f.tag[k])) add(cover, walls, v, xyz(w.f.velocity[k]), xk.w, x_ik, r2);
      });
    }
    w.f.leak_share[i] = physics::leak_share(cover, w.c.spacing, w.c.sound_speed);
  }
  /// A particle of a body and its images.
  MELTSIM_HD void add(physics::SolidCover<T>& cover, const physics::WallView<T>& walls, Vec3<T> v, Vec3<T> vk,
                      T volume, const Vec3<T>& x_ik, T r2) const {
    cover.add(w.c.kernel, volume, x_ik, v - vk, r2);
    physics::for_each_masked_image(
        walls, w.c.kernel.support2, x_ik, r2, [&](std::uint32_t mask, const Vec3<T>& x_m, T square) {
          cover.add(w.c.kernel, volume, x_m, v - vk + spatial::across(vk, mask) * T(2), square);
        });
  }
};

/// Whether liquid is within H of a solid particle; also of a fixed one, because probes read loads on obstacles.
template <class T>
struct WettedBody {
  Frame<T> w;
  MELTSIM_HD bool wanted(std::uint64_t k) const {
    return is_solid(w.f.tag[k]) && spatial::any_marked(w, k, w.f.liquid_bits);
  }
};

/// -tau_k of every wetted particle of a body that can be strained: the particles of its own piece count where the lattice has
/// them (coupling.hpp). A piece's label is that of vertex_piece, as for contact.
template <class T, bool Periodic>
struct UnstrainedBody {
  Frame<T> w;
  using Sum = Surroundings<T>;
  MELTSIM_HD bool wanted(std::uint64_t k) const { return WettedBody<T>{w}.wanted(k); }
  MELTSIM_HD std::uint32_t vertex_of(std::uint64_t k) const { return w.f.vertex_of_id[w.f.id[k]]; }
  MELTSIM_HD bool can_be_strained(std::uint32_t v) const {
    return w.f.bodies[w.f.vertex_body[v]].motion == core::body_free;
  }
  MELTSIM_HD Sum part(std::uint64_t k, std::uint32_t share, std::uint32_t parts) const {
    Sum s;
    const std::uint32_t v = vertex_of(k);
    if (!can_be_strained(v)) return s;
    const std::uint32_t piece = w.f.vertex_piece[v], body = w.f.vertex_body[v];
    const Vec3<double> own = core::steps_in_box(w, v, body);
    const Mat3<T> turn = to_matrix(w.f.region_rotation[v]);
    const auto walls = physics::wall_view(w.c.walls, xyz(w.f.position[k]));
    spatial::sweep_part<Periodic>(
        w, k, share, parts, [&](std::uint32_t j, const Vec4<T>& xj, Vec3<T> x_kj, T r2) {
          if (is_solid(w.f.tag[j]) && w.f.vertex_piece[vertex_of(j)] == piece) {
            const Vec3<T> steps = cast<T>(own - core::steps_in_box(w, vertex_of(j), body));
            x_kj = physics::lattice_offset(turn, steps, w.c.spacing);
            r2 = dot(x_kj, x_kj);
          }
          s.phi += xj.w * physics::kernel_shape(w.c.kernel, std::sqrt(r2));
          if (walls.axes != 0u) s.phi += xj.w * physics::image_shape(w.c.kernel, walls, x_kj, r2);
        });
    return s;
  }
  MELTSIM_HD void finish(std::uint64_t k, const Sum& s) const {
    if (can_be_strained(vertex_of(k))) w.f.velocity[k].w = stored_solid_term(w.c.kernel.w_scale * s.phi);
  }
};

/// Force of the liquid on every solid particle: the negatives of the forces in ForcesBody, by the same formula from the
/// same numbers. If a compiler fuses multiplications and additions, the sums may differ by rounding.
template <class T, bool Periodic>
struct ReactionBody : core::LiquidOnSolid<T> {
  using core::LiquidOnSolid<T>::w;
  using Sum = ForceSum<T>;
  MELTSIM_HD bool wanted(std::uint64_t k) const { return WettedBody<T>{w}.wanted(k); }
  MELTSIM_HD Sum part(std::uint64_t k, std::uint32_t share, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, static_cast<const core::LiquidOnSolid<T>&>(*this), k, share, parts);
  }
  MELTSIM_HD void finish(std::uint64_t k, const Sum& s) const {
    w.f.acceleration[k] += s.force * (T(1) / w.f.mass[k]);
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
