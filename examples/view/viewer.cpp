// SPDX-License-Identifier: Apache-2.0
#include "viewer.hpp"

#include <epoxy/gl.h>
// After it:
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "commands.hpp"
#include "expect.hpp"
#include "failure.hpp"
#include "interrupt.hpp"
#include "load_scene.hpp"
#include "panel.hpp"
#include "particle_feed.hpp"
#include "particle_renderer.hpp"
#include "picking.hpp"
#include "screenshot.hpp"
#include "session.hpp"
#include "show/camera.hpp"
#include "stage_renderer.hpp"
#include "window.hpp"

namespace view {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// For steps, per frame; as much as the picture takes where that is slow, or little would be left for them.
constexpr double budget_s = 0.025, longest_budget_s = 0.5;
constexpr double refresh_s = 0.5;   // of what is slow to ask for
constexpr double picked_s = 0.1;    // of the particle that was clicked at
constexpr double longest_s = 0.5;   // a frame that took longer is not made up for
constexpr double far_behind = 1e9;  // a budget that is never used up

class Viewer {
 public:
  Viewer(const ViewOptions& options, Window& window, runner::Scene base)
      : options_(options),
        window_(window),
        session_(std::move(base), options.machine, options.scene.scale, options.scene.quality),
        around_(particles_),
        renderer_(window.renderer()) {
    state_.paused = options.paused;
    state_.edits = session_.edits();
    look_.panel = options.panel;
    // Balls of liquid would hide the bodies in it.
    if (!session_.scene().bodies.empty()) look_.liquid_size = 0.4f;
    look_.temperature = temperature_range(session_.scene());
    const bool heats = session_.scene().world.heat.model != meltsim::HeatModel::none;
    look_.by = options.color.value_or(heats ? ColorBy::temperature : ColorBy::speed);
    Colors materials;
    for (const runner::SceneLook& look : session_.scene().output.looks) materials.push_back(look.color);
    look_.colors = color_table(session_.scene().output.body_colors, materials);
    particles_.set_colors(look_.colors);
    box_ = scene_box(session_.scene());
    place_camera();
    feed_.attach(session_.built());
    refresh();
  }

  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  int run() {
    last_frame_ = Clock::now();
    while (!window_.closing() && runner::interrupt_signal() == 0) {
      window_.begin_frame();
      handle(window_.take_input());
      if (state_.rebuild != Rebuild::none) rebuild();
      simulate();
      follow_picked();
      if (seconds_since(last_refresh_) > refresh_s) refresh();
      const Clock::time_point start = Clock::now();
      draw();
      if (frames_drawn_ == 0) place_camera();  // now that the panel's width is known
      if (finished()) return finish();
      window_.show();
      picture_s_ = 0.7 * picture_s_ + 0.3 * seconds_since(start);
    }
    return 0;
  }

 private:
  void place_camera() {
    const Viewport viewport = window_.framebuffer();
    const double panel = look_.panel ? panel_width_ * window_.pixel_ratio() : 0;
    const double beside_panel = std::max(viewport.width - panel, 0.2 * viewport.height);
    camera_.frame(box_, runner::upward(session_.scene()), beside_panel / viewport.height);
    if (!session_.scene().output.camera.contains("eye")) return;
    runner::Box all;
    all.add(box_.min);
    all.add(box_.max);
    const runner::Camera asked = runner::scene_camera(session_.scene(), all);
    // Its author had a picture of usual width in mind.
    const double back = std::max(1.0, 1.4 * viewport.height / beside_panel);
    camera_.place(asked.look_at + (asked.eye - asked.look_at) * back, asked.look_at, asked.up);
  }

  void handle(const Input& input) {
    camera_.orbit(input.orbit_x, input.orbit_y);
    camera_.pan(input.pan_x, input.pan_y);
    camera_.zoom(input.zoom);
    for (const int key : input.keys) press(key);
    if (input.click) click(input.click_x, input.click_y);
    if (std::exchange(state_.reset_camera, false)) place_camera();
  }

  void press(int key) {
    switch (key) {
      case GLFW_KEY_SPACE:
        state_.paused = !state_.paused;
        break;
      case GLFW_KEY_S:
        state_.paused = state_.step_once = true;
        break;
      case GLFW_KEY_R:
        state_.rebuild = Rebuild::start_again;
        break;
      case GLFW_KEY_C:
        state_.reset_camera = true;
        break;
      case GLFW_KEY_P:
        look_.panel = !look_.panel;
        break;
      case GLFW_KEY_F12:
        shoot_ = true;
        break;
      case GLFW_KEY_Q:
      case GLFW_KEY_ESCAPE:
        window_.close();
        break;
      default:
        if (key >= GLFW_KEY_1 && key < GLFW_KEY_1 + color_choices)
          look_.by = static_cast<ColorBy>(key - GLFW_KEY_1);
    }
  }

  void click(double x, double y) {
    picked_.reset();
    const auto data = session_.world().particles();
    if (!data) return;
    const double spacing = session_.scene().world.spacing;
    const auto radius = [&](const Vec3d& at, meltsim::ParticleTag tag) {
      return shown_radius(look_, spacing, at, tag);
    };
    const auto hit = pick(camera_.ray(x, y, window_.framebuffer()), *data, radius);
    if (!hit) return;
    picked_.emplace();
    read_picked(*data, *hit);
  }

  void read_picked(const meltsim::ParticleData& data, std::size_t i) {
    *picked_ = {
        data.id[i],       false,           data.position[i], data.velocity[i],        data.temperature[i],
        data.enthalpy[i], data.density[i], data.pressure[i], data.liquid_fraction[i], data.mass[i],
        data.tag[i]};
    last_picked_ = Clock::now();
  }

  void follow_picked() {
    if (!picked_ || seconds_since(last_picked_) < picked_s) return;
    const auto data = session_.world().particles();
    if (!data) return;
    const auto at = find_id(*data, picked_->id);
    picked_->gone = !at;
    if (at) read_picked(*data, *at);
  }

  void rebuild() {
    const bool keep = std::exchange(state_.rebuild, Rebuild::none) == Rebuild::keep_state;
    session_.rebuild(state_.edits, keep);
    state_.edits = session_.edits();  // as they were, when that failed
    feed_.attach(session_.built());
    if (!keep) {
      picked_.reset();
      look_.temperature = temperature_range(session_.scene());
    }
    timed_ = false;
    refresh();
    last_frame_ = Clock::now();
  }

  void simulate() {
    const double elapsed = seconds_since(last_frame_);
    last_frame_ = Clock::now();
    const bool timed = state_.timings && look_.panel;
    if (timed != timed_) static_cast<void>(session_.world().scheduler().enable_timings(timed_ = timed, 60));
    const std::uint64_t before = session_.world().steps();
    if (options_.scripted() && !state_.paused) {
      session_.advance(1 / session_.scene().time.fps, far_behind, elapsed);
    } else if (!state_.paused) {
      session_.advance(state_.pace * std::min(elapsed, longest_s),
                       std::clamp(picture_s_, budget_s, longest_budget_s), elapsed);
    } else if (state_.step_once) {
      session_.single_step();
    }
    state_.step_once = false;
    if (session_.world().steps() != before) feed_.update(session_.built());
    if (session_.ledger()) look_.speed.high = std::max(look_.speed.high, session_.ledger()->max_speed);
  }

  void refresh() {
    slow_.plan = session_.world().plan();
    slow_.resolved = session_.world().resolved();
    slow_.backend = runner::backend_text(session_.world());
    last_refresh_ = Clock::now();
  }

  void fit_temperature() {
    if (!std::exchange(state_.fit_temperature, false)) return;
    const auto totals = session_.world().totals();
    if (totals && totals->temperature_max > totals->temperature_min)
      look_.temperature = {totals->temperature_min, totals->temperature_max};
  }

  void draw() {
    camera_.shift(look_.panel ? panel_width_ * window_.pixel_ratio() / window_.framebuffer().width : 0);
    const Frame frame =
        make_frame(camera_, window_.framebuffer(), box_, feed_.origin(), session_.scene().world.spacing);
    particles_.cast(frame, look_, feed_.buffer(), feed_.count());
    around_.draw_behind(frame);
    particles_.draw(frame, look_, feed_.buffer(), feed_.count());
    around_.draw_around(frame, look_, box_);
    if (picked_ && !picked_->gone) mark_picked();
    const std::string path = feed_.path();
    if (look_.panel)
      panel_width_ = draw_panel({session_, state_, look_, slow_, box_, picked_, path, renderer_, picture_s_});
    draw_errors(session_);
    draw_legend(session_, look_);
    window_.draw_panel();
    fit_temperature();
    if (std::exchange(shoot_, false)) save_screenshot("meltsim-view.png", frame.viewport);
  }

  /// A ring around the particle, also where others hide it.
  void mark_picked() const {
    double x = 0, y = 0;
    const Viewport viewport = window_.framebuffer();
    if (!camera_.project(picked_->position, viewport, x, y)) return;
    const double ratio = window_.pixel_ratio(), away = length(picked_->position - camera_.eye());
    const double size = 0.5 * session_.scene().world.spacing * viewport.height /
                        (2 * away * std::tan(0.5 * Camera::fov * 3.14159265 / 180));
    const ImVec2 at{static_cast<float>(x / ratio), static_cast<float>(y / ratio)};
    const auto radius = static_cast<float>(std::max(6.0, 1.25 * size / ratio));
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.AddCircle(at, radius, IM_COL32(0, 0, 0, 200), 40, 4);
    list.AddCircle(at, radius, IM_COL32(255, 255, 255, 255), 40, 2);
  }

  bool finished() {
    ++frames_drawn_;
    if (!options_.scripted()) return false;
    if (session_.stopped()) return true;
    if (options_.frames) return frames_drawn_ >= *options_.frames;
    return session_.time() >= *options_.after - 1e-9 || state_.paused;
  }

  int finish() {
    if (!options_.screenshot.empty()) save_screenshot(options_.screenshot, window_.framebuffer());
    if (!session_.stopped()) return 0;
    std::fprintf(stderr, "%s\n", session_.error().c_str());
    return static_cast<int>(runner::ExitCode::diverged);
  }

  const ViewOptions& options_;
  Window& window_;
  Session session_;
  ParticleFeed feed_;
  ParticleRenderer particles_;
  StageRenderer around_;
  Camera camera_;
  Look look_;
  PanelState state_;
  Slow slow_;
  meltsim::Box box_;
  std::optional<Picked> picked_;
  std::string renderer_;
  std::uint64_t frames_drawn_ = 0;
  double picture_s_ = 0;    ///< what a picture takes, of late
  double panel_width_ = 0;  ///< as it was in the last frame
  bool timed_ = false, shoot_ = false;
  Clock::time_point last_frame_, last_refresh_, last_picked_;
};

}  // namespace

int run_viewer(const ViewOptions& options) {
  // The resolution is applied to it anew whenever the panel changes it.
  runner::Scene base = runner::load_scene(options.scene.scene, options.scene.set);
  Window window("meltsim: " + base.name, options.width, options.height);
  runner::watch_interrupts();
  return Viewer(options, window, std::move(base)).run();
}

}  // namespace view
