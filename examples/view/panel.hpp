// SPDX-License-Identifier: Apache-2.0
// The panel. Each part shows one thing; what the user asks for is noted in PanelState and done by the viewer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "look.hpp"
#include "meltsim/world.hpp"
#include "session.hpp"

namespace view {

enum class Rebuild { none, keep_state, start_again };

/// What the panel and the keys decide, from frame to frame.
struct PanelState {
  bool paused = false;
  bool step_once = false;
  double pace = 1;  ///< simulated seconds per second on the clock
  Edits edits;      ///< as the sliders stand
  Rebuild rebuild = Rebuild::none;
  bool timings = false, reset_camera = false, fit_temperature = false;
};

/// The particle that was clicked at, as it is now.
struct Picked {
  std::uint32_t id = 0;
  bool gone = false;
  Vec3d position, velocity;
  double temperature = 0, enthalpy = 0, density = 0, pressure = 0, liquid_fraction = 0, mass = 0;
  meltsim::ParticleTag tag = 0;
};

/// What is shown and costs too much to ask for in every frame.
struct Slow {
  meltsim::Plan plan;
  meltsim::Resolved resolved;
  std::string backend;
};

struct PanelInput {
  Session& session;
  PanelState& state;
  Look& look;
  const Slow& slow;
  const meltsim::Box& box;
  std::optional<Picked>& picked;
  const std::string& data_path;  ///< how particles get into the picture
  const std::string& renderer;
  double picture_s;  ///< what the last picture took
};

/// Returns the width it takes from the left of the window, in units of the panel.
float draw_panel(const PanelInput& in);

// Its parts, in their order.
void draw_run_controls(const PanelInput& in);
void draw_numbers(const PanelInput& in);
void draw_look_controls(const PanelInput& in);
void draw_edit_controls(const PanelInput& in);
void draw_picked(const PanelInput& in);
void draw_timings(const PanelInput& in);
void draw_plan(const PanelInput& in);

// Beside it.
void draw_errors(const Session& session);
void draw_legend(const Session& session, const Look& look);

/// A line of the panel: a name, and what stands beside it.
void draw_value(const char* name, const std::string& value);

}  // namespace view
