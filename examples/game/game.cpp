// SPDX-License-Identifier: Apache-2.0
#include "game.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace game {

using meltsim::BodyId;
using meltsim::Event;
using meltsim::EventKind;
using meltsim::Motion;
using meltsim::PieceInfo;
using meltsim::Quat;
using meltsim::Result;
using meltsim::Shape;
using meltsim::Status;
using meltsim::World;

namespace {

constexpr double shelf_top = 0.44, cup_radius = 0.2, cup_wall = 0.08, cup_height = 0.28;

Quat<double> about_z(double angle) { return {std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle)}; }

Quat<double> inverse(const Quat<double>& q) { return {q.w, -q.x, -q.y, -q.z}; }

double between(double a, double b, double part) { return a + (b - a) * std::clamp(part, 0.0, 1.0); }

std::string line(double time, const std::string& what) {
  char text[32];
  std::snprintf(text, sizeof text, "%5.2f s  ", time);
  return text + what;
}

}  // namespace

Hands Game::at_rest() {
  Hands h;
  h.cup = {0.36, 0.48, 0.3};
  h.iron = {1.16, 0.8, 0.3};
  return h;
}

Result<Game> Game::make(const Settings& settings) {
  meltsim::WorldDesc d;
  d.spacing = settings.spacing;
  d.backend = settings.backend;
  d.threads = settings.threads;
  d.domain.bounded = true;
  d.domain.max = size;
  d.heat.time_scale = 300;  // a game has no time for ice
  d.sound_speed =
      25;  // six times as fast as water that falls; ten times would be stiffer, and sub-steps shorter
  d.max_substeps = 1000;
  auto world = World::create(d);
  if (!world) return world.error();
  Game g(std::move(*world));
  World& w = g.world_;
  const Hands h = at_rest();
  g.hands_ = h;

  meltsim::MaterialDesc m;
  m.name = "water";
  m.viscosity = 0.05;
  const auto water = w.add_material(m);
  if (!water) return water.error();
  m = {};
  m.name = "ice";
  m.density = 917;
  m.conductivity = 2.2;
  m.heat_capacity = 2100;
  m.melting_point = 0;
  m.latent_heat = 3.34e5;
  m.melts_into = *water;
  const auto ice = w.add_material(m);
  if (!ice) return ice.error();
  m = {};
  m.name = "clay";
  m.density = 2000;
  m.conductivity = 0.2;
  const auto clay = w.add_material(m);
  if (!clay) return clay.error();
  m = {};
  m.name = "iron";
  m.density = 7870;
  m.conductivity = 80;
  m.heat_capacity = 450;
  const auto iron = w.add_material(m);
  if (!iron) return iron.error();

  meltsim::FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {size.x, pool, size.z});
  f.material = *water;
  f.temperature = 10;
  if (auto added = w.add_fluid(f); !added) return added.error();

  meltsim::SolidDesc s;
  s.name = "shelf";
  s.material = *clay;
  s.shape = Shape::box({0.96, shelf_top - 0.08, 0.12}, {1.36, shelf_top, 0.48});
  s.fixed = true;
  const auto shelf = w.add_solid(s);
  if (!shelf) return shelf.error();
  g.shelf_ = *shelf;

  s = {};
  s.name = "ice";
  s.material = *ice;
  s.temperature = -2;
  const double y = shelf_top + 0.02;
  s.shape = Shape::unite({Shape::box({0.96, y, 0.2}, {1.12, y + 0.16, 0.4}),
                          Shape::box({1.12, y + 0.04, 0.28}, {1.2, y + 0.12, 0.32}),
                          Shape::box({1.2, y, 0.2}, {1.36, y + 0.16, 0.4})});
  const auto body = w.add_solid(s);
  if (!body) return body.error();
  g.ice_ = *body;

  s = {};
  s.name = "cup";
  s.material = *clay;
  s.motion = Motion::kinematic;
  s.max_speed = 2;
  s.pivot = h.cup;
  s.shape = Shape::subtract(Shape::cylinder(h.cup, h.cup + Vec3d{0, cup_height, 0}, cup_radius),
                            Shape::cylinder(h.cup + Vec3d{0, cup_wall, 0},
                                            h.cup + Vec3d{0, cup_height + 0.1, 0}, cup_radius - cup_wall));
  const auto cup = w.add_solid(s);
  if (!cup) return cup.error();
  g.cup_ = *cup;

  s = {};
  s.name = "iron";
  s.material = *iron;
  s.motion = Motion::kinematic;
  s.max_speed = 2;
  s.temperature = 400;
  s.surface.temperature = 400;  // its handle is a heater
  s.pivot = h.iron;
  s.shape = Shape::box(h.iron + Vec3d{-0.04, 0, -0.16}, h.iron + Vec3d{0.04, 0.16, 0.16});
  const auto hot = w.add_solid(s);
  if (!hot) return hot.error();
  g.iron_ = *hot;

  meltsim::EmitterDesc e;
  e.name = "tap";
  e.material = *water;
  e.center = {0.12, 0.86, 0.3};
  e.radius = 0.06;
  e.speed = 1;
  e.max_particles = 4000;
  e.temperature = 10;
  const auto tap = w.add_emitter(e);
  if (!tap) return tap.error();
  g.tap_ = *tap;
  meltsim::EmitterSetting off;
  off.on = false;
  if (Status st = w.set_emitter(g.tap_, off); !st) return st.error();

  // What a game wants to hear of. Of the particles that melt the number is enough (Events::counts), and it has that with them.
  meltsim::EventWatch watch;
  watch.kinds = event_bit(EventKind::melted) | event_bit(EventKind::split) |
                event_bit(EventKind::contact_begun) | event_bit(EventKind::gone);
  if (Status st = w.watch_events(watch); !st) return st.error();

  const auto pieces = w.pieces();
  if (!pieces) return pieces.error();
  for (const PieceInfo& p : *pieces)
    if (p.body.index == g.ice_.index)
      g.flags_.push_back({p.piece, p.center, p.orientation, {-0.12, 0.08, 0}, p.orientation, true});
  return g;
}

Status Game::frame(double seconds, const Hands& hands, std::vector<std::string>& news) {
  meltsim::BodyMotion m;
  m.position = hands.cup;
  m.orientation = about_z(hands.tilt);
  if (Status s = world_.set_motion(cup_, m); !s) return s;
  m = {};
  m.position = hands.iron;
  m.orientation = about_z(0);
  if (Status s = world_.set_motion(iron_, m); !s) return s;
  if (hands.tap != runs_) {
    meltsim::EmitterSetting tap;
    tap.on = hands.tap;
    if (Status s = world_.set_emitter(tap_, tap); !s) return s;
    runs_ = hands.tap;
    news.push_back(line(world_.time(), runs_ ? "the tap runs" : "the tap is shut"));
  }
  hands_ = hands;
  if (Status s = world_.step(seconds); !s) return s;
  if (Status s = take_news(news); !s) return s;
  return follow_pieces();
}

std::string Game::name_of(const Event& e) const {
  const auto body = [this](BodyId id) -> std::string {
    if (id.index == cup_.index) return "the cup";
    if (id.index == iron_.index) return "the iron";
    if (id.index == shelf_.index) return "the shelf";
    return "the ice";
  };
  if (e.wall >= 0) return body(e.body) + (e.wall == 2 ? " and the floor" : " and a wall");
  return body(e.other) + " and " + body(e.body);
}

Status Game::take_news(std::vector<std::string>& news) {
  const auto taken = world_.take_events();
  if (!taken) return taken.error();
  score_.melted += taken->counts[static_cast<std::size_t>(EventKind::melted)];
  splits_.clear();
  for (const Event& e : taken->events) {
    if (e.kind == EventKind::contact_begun) {
      ++score_.bumps;
      news.push_back(line(e.time, name_of(e) + " meet"));
    } else if (e.kind == EventKind::split) {
      ++score_.split;
      splits_.emplace_back(e.from, e.piece);
      news.push_back(line(e.time, "a piece comes off the ice"));
    } else if (e.kind == EventKind::gone) {
      ++score_.gone;
      news.push_back(line(e.time, "the ice has melted away"));
    }
  }
  return {};
}

/// Flags go where their pieces are. A piece that came off gets one of its own; one whose label has changed is the one that is
/// nearest to where it was.
Status Game::follow_pieces() {
  const auto all = world_.pieces();
  if (!all) return all.error();
  std::vector<const PieceInfo*> ice;
  for (const PieceInfo& p : *all)
    if (p.body.index == ice_.index) ice.push_back(&p);
  const auto with_label = [&ice](std::uint32_t label) -> const PieceInfo* {
    for (const PieceInfo* p : ice)
      if (p->piece == label) return p;
    return nullptr;
  };
  for (Flag& f : flags_) {
    if (!f.planted_in_piece) continue;
    const PieceInfo* now = with_label(f.piece);
    for (const PieceInfo* p : ice)
      if (with_label(f.piece) == nullptr &&
          (now == nullptr || length(p->center - f.position) < length(now->center - f.position)))
        now = p;
    f.planted_in_piece = now != nullptr && length(now->center - f.position) < 0.3;
    if (!f.planted_in_piece) continue;
    f.piece = now->piece;
    f.position = now->center;
    f.orientation = now->orientation;
  }
  for (const auto& [from, label] : splits_) {
    const PieceInfo* p = with_label(label);
    const bool small = p != nullptr && p->particles < 8;
    const bool has_one = std::any_of(flags_.begin(), flags_.end(), [&, wanted = label](const Flag& f) {
      return f.planted_in_piece && f.piece == wanted;
    });
    if (p == nullptr || small || has_one) continue;
    flags_.push_back({label, p->center, p->orientation, {0, 0.08, 0}, p->orientation, true});
    // The old one's piece is smaller now: its flag stands on what is left.
    for (Flag& f : flags_)
      if (const PieceInfo* rest = with_label(f.piece); rest != nullptr && f.piece == from) {
        f.at = {0, 0.08, 0};
        f.planted = rest->orientation;
      }
  }
  return {};
}

FlagMesh Game::mesh_of(const Flag& flag) const {
  // A mast of three sides and a cloth of two faces, standing at the origin.
  static constexpr std::array<Vec3d, 9> points{{{-0.008, 0, -0.008},
                                                {0.008, 0, -0.008},
                                                {0, 0, 0.008},
                                                {-0.008, 0.2, -0.008},
                                                {0.008, 0.2, -0.008},
                                                {0, 0.2, 0.008},
                                                {0, 0.19, 0},
                                                {0.12, 0.155, 0},
                                                {0, 0.12, 0}}};
  FlagMesh mesh;
  mesh.triangles = {0, 3, 1, 1, 3, 4, 1, 4, 2, 2, 4, 5, 2, 5, 0, 0, 5, 3, 6, 7, 8, 6, 8, 7};
  const Quat<double> back = inverse(flag.planted);
  for (const Vec3d& p : points)
    mesh.position.push_back(flag.position + rotate(flag.orientation, rotate(back, flag.at + p)));
  return mesh;
}

Result<double> Game::in_cup() {
  const Quat<double> turn = about_z(hands_.tilt);
  const Vec3d bottom = hands_.cup + rotate(turn, Vec3d{0, cup_wall, 0}),
              top = hands_.cup + rotate(turn, Vec3d{0, cup_height, 0});
  const auto found = world_.overlap(Shape::cylinder(bottom, top, cup_radius - cup_wall));
  if (!found) return found.error();
  return found->liquid_volume * 1000;
}

Hands script(double t, const Score& score) {
  Hands h = Game::at_rest();
  // The cup: down into the pool until its rim is under water, up, over to the right, poured out, back.
  const double down = 0.02, up = 0.5;
  h.cup.y = t < 1.4 ? between(h.cup.y, down, t / 0.9) : between(down, up, (t - 1.4) / 1.0);
  h.cup.x = between(h.cup.x, 0.56, (t - 2.4) / 0.5);
  h.tilt = t < 4.2 ? between(0, -1.9, (t - 2.9) / 1.0) : between(-1.9, 0, (t - 4.2) / 0.6);
  // The iron: onto the neck, through it, and then to the right.
  h.iron.y = t < 0.8 ? between(h.iron.y, 0.58, t / 0.8) : between(0.58, 0.47, (t - 0.8) / 1.5);
  if (score.split > 0) h.iron.x = between(h.iron.x, 1.4, (t - 2.6) / 1.6);
  h.tap = t > 0.3 && t < 3.5;
  return h;
}

}  // namespace game
