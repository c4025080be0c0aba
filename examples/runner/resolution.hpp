// SPDX-License-Identifier: Apache-2.0
// --scale and --quality: the same scene with coarser or finer particles.
#pragma once

#include <array>

#include "options.hpp"
#include "scene.hpp"

namespace runner {

/// draft: 0.8 x the resolution, 0.8 x the sound speed, Courant number at least 0.5. balanced: the scene as it is. accurate:
/// 1.4 x the resolution. --scale multiplies the resolution further. The spacing is then
/// moved by up to 6 % to fit between the domain's walls.
void apply_resolution(Scene& scene, double scale, Quality quality);

/// The same scene with this spacing; the support and the surface's cells keep their ratio to it.
void apply_spacing(Scene& scene, double spacing);

/// The same for a spacing that was chosen for an error: what nozzles give at most is as much liquid as before.
void apply_chosen_spacing(Scene& scene, double spacing);

/// Volume of a shape [m^3], to about a percent: from points of many shifted lattices, so that none of its faces matters more than another.
/// points: how many are looked at in all, over the bounds of the shape; lattices: 13, or 5 where each costs much.
double volume_of(const meltsim::Shape& shape, double points, int lattices);

/// Lengths of the domain that a shape reaches along from wall to wall, or over a period; 0 where it does not, or not `fills`: liquid and
/// fixed bodies do.
std::array<double, 3> filled_lengths(const meltsim::DomainDesc& domain, const meltsim::Shape& shape,
                                     bool fills, double spacing);
/// Volume of the cell around a particle [m^3]: along those lengths stretched as World::add_fluid stretches it.
double cell_volume(const meltsim::DomainDesc& domain, const meltsim::Shape& shape, bool fills,
                   double spacing);
/// What the particles of a shape take up [m^3].
double volume_of_particles(const meltsim::DomainDesc& domain, const meltsim::Shape& shape, bool fills,
                           double spacing);

}  // namespace runner
