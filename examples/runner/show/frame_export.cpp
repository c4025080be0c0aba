// SPDX-License-Identifier: Apache-2.0
#include "show/frame_export.hpp"

#include <algorithm>

#include "files.hpp"
#include "show/draw.hpp"
#include "show/mesh_files.hpp"
#include "show/pov_file.hpp"
#include "show/surfaces.hpp"
#include "show/usd_file.hpp"

namespace runner {

FrameExport::FrameExport(const Scene& scene, RunDirectory directory, const std::vector<double>& times)
    : scene_(scene),
      directory_(std::move(directory)),
      formats_(scene.output.formats.begin(), scene.output.formats.end()) {
  const auto [cold, hot] = temperature_range(scene_);
  usd_.looks = part_looks(scene_, picture_wish(scene_, cold, hot));
  usd_.spacing = scene_.world.spacing;
  usd_.fps = scene_.time.fps;
  usd_.up = upward(scene_);
  for (const double time : times)
    vtp_frames_.emplace_back(time, frame_file("particles", vtp_frames_.size(), "vtp"));
}

bool FrameExport::any() const {
  // index.html is no file of a frame.
  return std::any_of(formats_.begin(), formats_.end(),
                     [](const std::string& format) { return format != "html"; });
}

bool FrameExport::wants_shapes() const {
  return wants("surface") || wants("obj") || wants("glb") || wants("pov") || wants("png") || wants("usd");
}

FrameShapes FrameExport::shapes(meltsim::World& world, double time, const meltsim::ParticleFrame& particles) {
  return world_shapes(world, scene_, time, particles, problem_);
}

void FrameExport::write(std::uint64_t index, double time, const meltsim::ParticleFrame& particles,
                        const FrameShapes* shapes) {
  std::vector<std::string> names;
  for (const SceneLook& look : scene_.output.looks) names.push_back(look.name);
  const std::vector<std::string> contents = content_columns(particles, names);
  write_particles(index, time, particles, contents);
  if (shapes != nullptr) write_shapes(*shapes, index, contents);
  if (shapes != nullptr && wants("usd")) write_usd(index, time, particles, *shapes, contents);
}

/// The frame, then what joins it to those before it: of a run that is killed all frames play, too.
void FrameExport::write_usd(std::uint64_t index, double time, const meltsim::ParticleFrame& particles,
                            const FrameShapes& shapes, const std::vector<std::string>& contents) {
  usd_.contents = contents;
  const std::string last = index > 0 ? directory_.file(usd_frame_file(index - 1)) : "";
  if (!usd_first_ && !last.empty() && exists(last)) usd_before_ = usd_bounds_in(read_file(last));
  write_file(directory_.file(usd_frame_file(index)),
             usd_text(usd_, index, time, particles, shapes, usd_before_));
  usd_before_ = usd_bounds(usd_, particles, shapes);
  if (!usd_first_) {
    usd_first_ = index;
    while (*usd_first_ > 0 && exists(directory_.file(usd_frame_file(*usd_first_ - 1)))) --*usd_first_;
    write_file(directory_.file(usd_manifest_file), usd_manifest(usd_));
  }
  write_file(directory_.file("scene.usda"), usd_clips(usd_, *usd_first_, index));
}

void FrameExport::write_particles(std::uint64_t index, double time, const meltsim::ParticleFrame& particles,
                                  const std::vector<std::string>& contents) {
  if (wants("ply")) write_ply(directory_.frame("particles", index, "ply"), particles, time, contents);
  if (!wants("vtp")) return;
  write_vtp(directory_.frame("particles", index, "vtp"), particles, time, contents);
  vtp_frames_.emplace_back(time, frame_file("particles", index, "vtp"));
  write_file(directory_.file("particles.pvd"), pvd_text(vtp_frames_));
}

void FrameExport::write_shapes(const FrameShapes& shapes, std::uint64_t index,
                               const std::vector<std::string>& contents) {
  const auto [cold, hot] = temperature_range(scene_);
  for (const auto& [name, mesh] :
       {std::pair<const char*, const Mesh*>{"liquid", &shapes.liquid}, {"solid", &shapes.solid}}) {
    if (wants("surface"))
      write_file(directory_.frame(name, index, "ply"),
                 mesh_ply_text(*mesh, shapes.origin, shapes.time, contents));
    if (wants("obj")) {
      write_file(directory_.frame(name, index, "obj"),
                 mesh_obj_text(*mesh, shapes.origin, shapes.time, name, cold, hot, scene_.output.looks));
    }
  }
  if (wants("glb"))
    write_file(directory_.frame("surface", index, "glb"),
               glb_text(shapes, usd_.looks, contents, upward(scene_)));
  const PictureWish wish = picture_wish(scene_, cold, hot);
  // What will be where later is not known yet; a camera that moves from frame to frame is worse than a wide
  // view.
  const Box all = view_box(scene_, {});
  const Camera camera = scene_camera(scene_, all.empty() ? box_of(shapes) : all, wish.aspect());
  if (!wants("pov") && !wants("png")) return;
  const FrameShapes shown = picture_shapes(shapes, scene_);
  if (camera_problem_.empty() && eye_in_solid(shown, camera)) camera_problem_ = eye_in_solid_text;
  if (wants("pov")) {
    write_file(directory_.frame("scene", index, "pov"),
               pov_text(shown, camera, trace_settings(scene_, camera, wish)));
  }
  if (wants("png"))
    write_file(directory_.frame("picture", index, "png"), png_text(draw(shown, scene_, camera, wish)));
}

std::pair<double, double> temperature_range(const Scene& scene) {
  double cold = 1e300, hot = -1e300;
  const auto take = [&](double t) {
    cold = std::min(cold, t);
    hot = std::max(hot, t);
  };
  for (const SceneFluid& fluid : scene.fluids) take(fluid.desc.temperature);
  for (const SceneBody& body : scene.bodies) take(body.desc.temperature);
  for (const SceneEmitter& emitter : scene.emitters) take(emitter.desc.temperature);
  for (const meltsim::SurfaceHeatDesc& wall : scene.world.domain.heat) {
    if (wall.temperature) take(*wall.temperature);
  }
  for (const SceneHeatRegion& region : scene.heat_regions) {
    if (region.desc.temperature) take(*region.desc.temperature);
  }
  if (cold > hot) return {0, 1};
  if (hot - cold < 1e-3) return {cold - 0.5, hot + 0.5};
  return {cold, hot};
}

}  // namespace runner
