// SPDX-License-Identifier: Apache-2.0
#include "show/run_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "expect.hpp"
#include "files.hpp"
#include "numbers.hpp"
#include "show/draw.hpp"
#include "show/frame_export.hpp"
#include "show/replay_page.hpp"
#include "show/shapes.hpp"
#include "show/surfaces.hpp"

namespace runner {

namespace {

std::uint64_t live(Built& built) {
  const meltsim::StepResult now = built.world.synchronize();
  return now.fluid + now.solid;
}

/// What there is to see in any of the frames.
Box box_of(const std::vector<ReplayFrame>& frames) {
  Box box;
  for (const ReplayFrame& frame : frames) {
    for (const ReplayParticle& p : frame.particles) box.add({p.position[0], p.position[1], p.position[2]});
  }
  return box;
}

std::string note(const Scene& scene, const Replay& replay, const RunState& state) {
  std::string text = fmt::format("Particles {:.3g} m apart.", scene.world.spacing);
  if (replay.share() > 1) text += fmt::format(" One particle in {} is shown, larger.", replay.share());
  return text + fmt::format(" {} frames were computed,", state.next_frame);
}

}  // namespace

RunPictures::RunPictures(const Scene& scene, RunDirectory directory, Built& built,
                         std::uint64_t planned_frames, const RunState* resumed)
    : scene_(scene), directory_(std::move(directory)), replay_(planned_frames, live(built)) {
  if (resumed != nullptr) replay_.load(directory_.file("replay.bin"), resumed->time);
}

void RunPictures::frame(std::uint64_t index, double time, const meltsim::ParticleFrame& particles) {
  if (replay_.wants(index)) replay_.add(index, time, particles);
}

void RunPictures::save() const { replay_.save(directory_.file("replay.bin"), scene_.world.threads); }

void RunPictures::finish(meltsim::World& world, const RunState& state, bool page, bool still) {
  if (drawing_.valid()) drawing_.get();
  if (!page && !still) return;
  meltsim::ReadRequest all;
  all.particles = true;
  const meltsim::ParticleFrame particles = expect(world.take(expect(world.request(all)))).particles;
  std::vector<ReplayFrame> frames = replay_.frames();
  if (frames.empty() || state.time - frames.back().time > 1e-6 / scene_.time.fps) {
    frames.push_back(replay_.picked(state.next_frame, state.time, particles));
  }
  const Box seen = view_box(scene_, box_of(frames));
  if (page) write_page(std::move(frames), seen, state);
  if (still) write_still(world_shapes(world, scene_, state.time, particles, problem_), seen);
}

void RunPictures::write_page(std::vector<ReplayFrame> frames, const Box& seen, const RunState& state) const {
  ReplayPage page;
  page.title = scene_.title.empty() ? scene_.name : scene_.title;
  page.note = note(scene_, replay_, state);
  page.spacing = scene_.world.spacing;
  page.box = view_box(scene_, {});
  page.camera = scene_camera(scene_, seen);
  for (const SceneBody& body : scene_.bodies) page.bodies.push_back(body.desc.name);
  page.looks = scene_.output.looks;
  page.species = shown_species(scene_);
  page.stats = read_file(directory_.file("stats.csv"));
  page.share = replay_.share();
  page.threads = scene_.world.threads;
  const auto hidden = [this](const ReplayParticle& p) {
    const std::uint32_t body = p.look & 127u;  // bodies from the 127th on share a number, and stay
    return (p.look & 128u) != 0 && body < 127 && is_hidden(scene_.output.body_visible, body);
  };
  for (ReplayFrame& frame : frames)
    frame.particles.erase(std::remove_if(frame.particles.begin(), frame.particles.end(), hidden),
                          frame.particles.end());
  write_file(directory_.file("index.html"), replay_page(page, frames));
}

void RunPictures::still(std::shared_ptr<const FrameShapes> shapes) {
  if (drawing_.valid()) drawing_.get();  // both write the same file
  const Box seen = view_box(scene_, box_of(replay_.frames()));
  drawing_ = std::async([this, shapes = std::move(shapes), seen] { write_still(*shapes, seen); });
}

void RunPictures::write_still(const FrameShapes& shapes, const Box& seen) {
  const FrameShapes shown = picture_shapes(shapes, scene_);
  const auto [cold, hot] = temperature_range(scene_);
  PictureWish wish = picture_wish(scene_, cold, hot);
  wish.extent = length(seen.size());
  const Camera camera = scene_camera(scene_, seen, wish.aspect());
  if (eye_in_solid(shown, camera)) problem_ = eye_in_solid_text;
  write_file(directory_.file("still.png"), png_text(draw(shown, scene_, camera, wish)));
}

}  // namespace runner
