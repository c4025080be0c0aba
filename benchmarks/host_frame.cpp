// SPDX-License-Identifier: Apache-2.0
// meltsim_host_frame [--backend cpu|cuda] [--frames N] [--watch 0|1]: how long a frame of a game keeps its host: ten kinematic bodies
// get motions, a step, a reading of forces and events, the reading of the frame before, a render pack. 60,000 particles, ice that melts
// among them. On a GPU the host is to wait for nothing; on a CPU the step is the host's own work. Prints microseconds, median and
// 95th percentile, per call.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "meltsim/meltsim.hpp"

namespace {

using namespace meltsim;

enum Call { motions, stepping, requesting, taking, packing, whole, calls };
constexpr const char* names[calls] = {"set_motion x 10",     "step",        "request",
                                      "take (frame before)", "render_view", "frame"};

int fail(const std::string& text) {
  std::fprintf(stderr, "meltsim_host_frame: %s\n", text.c_str());
  return 1;
}

double percentile(std::vector<double> v, double part) {
  std::sort(v.begin(), v.end());
  return v.empty()
             ? 0
             : v[std::min(v.size() - 1, static_cast<std::size_t>(part * static_cast<double>(v.size())))];
}

}  // namespace

int main(int count, char** arguments) {
  WorldDesc d;
  int frames = 300;
  bool watch = true;
  constexpr const char* usage = "options: --backend cpu|cuda, --frames N (more than 20), --watch 0|1";
  for (int k = 1; k < count; k += 2) {
    const std::string option = arguments[k], value = k + 1 < count ? arguments[k + 1] : "";
    if (option == "--help") return std::printf("meltsim_host_frame, %s\n", usage), 0;
    if (option == "--backend") d.backend = value == "cuda" ? Backend::cuda : Backend::cpu;
    else if (option == "--frames") frames = std::atoi(value.c_str());
    else if (option == "--watch") watch = value != "0";
    else return fail(usage);
  }
  d.spacing = 0.02;
  d.domain.bounded = true;
  d.domain.max = {0.8, 1.0, 0.8};
  d.heat.time_scale = 100;
  d.max_substeps = 1000;
  auto made = World::create(d);
  if (!made) return fail(made.error().message);
  World w = std::move(*made);
  const auto water = w.add_material({});
  MaterialDesc m;
  m.name = "ice";
  m.density = 917;
  m.melting_point = 0;
  m.latent_heat = 3.34e5;
  m.melts_into = *water;
  const auto ice = w.add_material(m);
  if (!water || !ice) return fail("a material is refused");
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {0.8, 0.74, 0.8});
  f.material = *water;
  f.temperature = 30;
  if (const auto added = w.add_fluid(f); !added) return fail(added.error().message);
  SolidDesc s;
  s.material = *ice;
  s.temperature = -5;
  s.shape = Shape::box({0.28, 0.52, 0.28}, {0.52, 0.76, 0.52});
  const auto block = w.add_solid(s);
  if (!block) return fail(block.error().message);
  m = {};
  m.name = "steel";
  m.density = 7800;
  const auto steel = w.add_material(m);
  std::vector<BodyId> bodies;
  std::vector<Vec3d> places;
  for (int k = 0; k < 10; ++k) {
    s = {};
    s.material = *steel;
    s.motion = Motion::kinematic;
    s.max_speed = 0.5;
    const Vec3d at{0.1 + 0.15 * (k % 5), 0.14 + 0.14 * (k / 5), k % 2 == 0 ? 0.2 : 0.6};
    s.shape = Shape::box(at - Vec3d{0.03, 0.03, 0.03}, at + Vec3d{0.03, 0.03, 0.03});
    const auto id = w.add_solid(s);
    if (!id) return fail(id.error().message);
    bodies.push_back(*id);
    places.push_back(w.motion(*id)->position.value());
  }
  if (watch) {
    for (const BodyId id : bodies)
      if (Status st = w.watch_forces(id); !st) return fail(st.error().message);
    if (Status st = w.watch_events(); !st) return fail(st.error().message);
  }
  if (Status st = w.prepare(); !st) return fail(st.error().message);
  const StepResult first = w.synchronize();
  std::printf("%s, %llu particles, %s\n", w.resolved().device_name.c_str(),
              static_cast<unsigned long long>(first.fluid + first.solid), watch ? "watched" : "not watched");

  using Clock = std::chrono::steady_clock;
  std::array<std::vector<double>, calls> times;
  RenderDesc colors;
  colors.color = ColorBy::temperature;
  ReadRequest what;
  what.forces = what.events = watch;
  ReadTicket open;
  std::uint64_t events = 0;
  // A device that falls behind makes step() wait: every frame ends with the device idle, outside of what is timed.
  const double dt = 0.9 * w.stable_dt();
  for (int n = 0; n < frames; ++n) {
    std::array<Clock::time_point, calls> t;
    t[motions] = Clock::now();
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      BodyMotion motion;
      motion.position = places[k] + Vec3d{0, 0.0002 * (n % 100 < 50 ? n % 100 : 100 - n % 100), 0};
      if (Status st = w.set_motion(bodies[k], motion); !st) return fail(st.error().message);
    }
    t[stepping] = Clock::now();
    if (Status st = w.step(4 * dt); !st) return fail(st.error().message);
    t[requesting] = Clock::now();
    const auto ticket = w.request(what);
    if (!ticket) return fail(ticket.error().message);
    const ReadTicket before = std::exchange(open, *ticket);
    t[taking] = Clock::now();
    if (before.value != 0) {
      const auto reading = w.take(before);
      if (!reading) return fail(reading.error().message);
      events += reading->events.events.size();
    }
    t[packing] = Clock::now();
    if (const auto view = w.render_view(colors); !view) return fail(view.error().message);
    t[whole] = Clock::now();
    const auto us = [&](int from, int to) {
      return std::chrono::duration<double, std::micro>(t[static_cast<std::size_t>(to)] -
                                                       t[static_cast<std::size_t>(from)])
          .count();
    };
    if (n >= 20) {  // memory and graphs come first
      for (int k = 0; k < whole; ++k) times[static_cast<std::size_t>(k)].push_back(us(k, k + 1));
      times[whole].push_back(us(motions, whole));
    }
    if (const StepResult r = w.synchronize(); r.halted) return fail(r.halt_reason);
  }
  std::printf("%d frames of 4 sub-steps, %llu events\n%-20s %10s %10s\n", frames,
              static_cast<unsigned long long>(events), "[us]", "median", "95 %");
  for (std::size_t k = 0; k < calls; ++k)
    std::printf("%-20s %10.1f %10.1f\n", names[k], percentile(times[k], 0.5), percentile(times[k], 0.95));
  return 0;
}
