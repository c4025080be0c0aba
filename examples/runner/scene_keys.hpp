// SPDX-License-Identifier: Apache-2.0
// Keys of shapes and faces, which are no rows of scene_options.hpp, and words that values may be: the reader, its suggestions and
// the schema use these lists.
#pragma once

#include <string>
#include <vector>

namespace runner::keys {

using List = std::vector<std::string>;

inline const List faces{"-x", "+x", "-y", "+y", "-z", "+z", "x", "y", "z"};
inline const List one_face{"-x", "+x", "-y", "+y", "-z", "+z"};  ///< in the order of DomainDesc::faces
inline const List field_kind{"uniform", "radial", "vortex", "drag",
                             "hydrostatic"};  ///< in the order of meltsim::ForceFieldKind
inline const List probe_kind{"point", "level", "force", "heat",
                             "flux"};  ///< in the order of meltsim::ProbeKind

inline const List shapes{"box",   "sphere", "capsule", "cylinder",   "torus",
                         "blend", "mesh",   "union",   "difference", "intersection"};
inline const List shape{"box",  "sphere", "capsule",    "cylinder",     "torus",    "blend",
                        "mesh", "union",  "difference", "intersection", "transform"};
inline const List transform{"offset", "axis", "angle", "scale"};
inline const List sphere{"center", "radius"};
inline const List rod{"from", "to", "radius"};  ///< capsule and cylinder
inline const List torus{"center", "axis", "major_radius", "minor_radius"};
inline const List blend{"ellipsoids", "width"};
inline const List ellipsoid{"center", "radii"};

// Words that values may be.
inline const List walls{"box", "open", "none"};
inline const List face{"wall", "open", "periodic"};
inline const List neighbour_search{"auto", "grid", "verlet", "tree"};
inline const List viscosity{"auto", "explicit", "implicit"};  ///< in the order of meltsim::Viscosity
inline const List stepping{"fixed", "adaptive"};
inline const List motion{"free", "fixed", "kinematic", "rigid"};  ///< in the order of meltsim::Motion
inline const List end_when{"time", "melted"};
inline const List stray{"remove", "halt"};
inline const List heat_model{"none", "paper", "iwasaki", "enthalpy"};
inline const List probe_field{"temperature",     "pressure", "density", "velocity",
                              "liquid_fraction", "solute1",  "solute2", "solute3"};
inline const List force_field{"force", "moment", "contact_force", "contact_moment"};
inline const List flux_field{"mass_flux", "volume_flux"};
inline const List formats{"ply", "vtp", "surface", "obj", "glb", "usd", "pov", "png", "html"};
/// Some with @ and the name of a body or a probe behind it.
inline const List observables{"melted", "melt_time_50", "melt_time_90", "front", "height", "draught",
                              "path",   "pressure",     "temperature",  "level", "energy", "volume"};
inline const List look{"natural", "temperature"};
inline const List surface_kernel{"isotropic", "anisotropic"};

}  // namespace runner::keys
