// SPDX-License-Identifier: Apache-2.0
// Frames as text of Universal Scene Description (.usda): particles as points, surfaces as meshes, with temperature. A file per frame, and
// two more that join the frames of a run, so that it plays.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "meltsim/reading.hpp"
#include "show/parts.hpp"
#include "show/shapes.hpp"

namespace runner {

/// What all frames of a run have in common.
struct UsdRun {
  PartLooks looks;
  std::vector<std::string> contents;  ///< names of the columns of what is dissolved
  double spacing = 0;                 ///< [m]
  double fps = 25;
  meltsim::Vec3d up{0, 1,
                    0};  ///< a unit vector; where it is neither y nor z, the stage is turned so that it is y
};

/// Of a frame; nothing where there are no points.
struct UsdBounds {
  std::optional<meltsim::Box> particles, liquid, solid;
};

/// One stage "meltsim": Points "particles" (ids, velocities, widths, primvars temperature, liquid_fraction, body, material, contents), Mesh
/// "liquid" and Mesh "solid" (normals, primvars the same and displayColor, displayOpacity), in metres, world coordinates. body: from 0, -1 = liquid.
/// A surface of nothing is a mesh without points. Values are time samples at the frame's number, since value clips read no others. Extents
/// bound the frame `before` as well, which is shown until this one.
std::string usd_text(const UsdRun& run, std::uint64_t frame, double time,
                     const meltsim::ParticleFrame& particles, const FrameShapes& shapes,
                     const UsdBounds& before = {});
UsdBounds usd_bounds(const UsdRun& run, const meltsim::ParticleFrame& particles, const FrameShapes& shapes);
/// The extents that a frame's text has, which are those of its particles and surfaces or larger.
UsdBounds usd_bounds_in(const std::string& text);

/// The manifest of the run's value clips: which attributes have time samples in the frames' files, so that readers open only the frames they show.
std::string usd_manifest(const UsdRun& run);
/// The run as one stage, whose value clips are the files of its frames.
std::string usd_clips(const UsdRun& run, std::uint64_t first, std::uint64_t last);

/// Names relative to the run directory. Templates of value clips want the number between dots.
std::string usd_frame_file(std::uint64_t frame);
inline constexpr const char* usd_manifest_file = "frames/manifest.usda";

}  // namespace runner
