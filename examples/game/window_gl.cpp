// SPDX-License-Identifier: Apache-2.0
// The window: the viewer's window, camera and particle renderer, with hands of the player's.
#include <epoxy/gl.h>
// After it:
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "camera.hpp"
#include "color_map.hpp"
#include "look.hpp"
#include "particle_renderer.hpp"
#include "particle_vertex.hpp"
#include "stage_renderer.hpp"
#include "window.hpp"
#include "window_mode.hpp"

namespace game {

namespace {

/// The particles of a frame as the renderer takes them: from World::render_view(), which hands out pointers. This window is for
/// the CPU; on a GPU the values are read, which waits.
meltsim::Status vertices_of(Game& game, std::vector<view::ParticleVertex>& to, Vec3d& origin) {
  meltsim::World& w = game.world();
  to.clear();
  const auto put = [&to](const meltsim::Vec3f& x, const meltsim::Vec3f& v, float temperature,
                         meltsim::ParticleTag tag) {
    to.push_back({x.x, x.y, x.z, length(v), temperature, tag});
  };
  if (w.backend() == meltsim::Backend::cpu) {
    const auto view = w.render_view();
    if (!view) return view.error();
    origin = view->origin;
    for (std::uint64_t i = 0; i < view->count; ++i)
      put(view->position[i], view->velocity[i], view->temperature[i], view->tag[i]);
    return {};
  }
  meltsim::ReadRequest what;
  what.particles = true;
  const auto ticket = w.request(what);
  if (!ticket) return ticket.error();
  const auto reading = w.take(*ticket);
  if (!reading) return reading.error();
  const meltsim::ParticleFrame& p = reading->particles;
  origin = p.origin;
  for (std::size_t i = 0; i < p.id.size(); ++i) put(p.position[i], p.velocity[i], p.temperature[i], p.tag[i]);
  return {};
}

/// Where the cursor meets the plane through the middle of the tank.
Vec3d under_cursor(const view::Ray& ray) {
  const double t =
      std::fabs(ray.direction.z) > 1e-6 ? (0.5 * Game::size.z - ray.origin.z) / ray.direction.z : 0;
  return ray.origin + ray.direction * t;
}

/// Towards `wanted`, no faster than `speed` allows in a frame.
Vec3d moved(const Vec3d& from, const Vec3d& wanted, double most) {
  const Vec3d way = wanted - from;
  const double far = length(way);
  return far > most ? from + way * (most / far) : wanted;
}

int play(Game& game) {
  view::Window window("meltsim game: mouse: cup, wheel: tilt, i: iron follows, t: tap", 1280, 720);
  view::ParticleRenderer particles;
  view::StageRenderer around(particles);
  view::Camera camera;
  camera.place({0.9, 1.0, 2.6}, {0.8, 0.4, 0.3}, {0, 1, 0});
  view::Look look;
  look.temperature = {-5, 60};
  look.liquid_size = 0.8F;
  particles.set_colors(look.colors);
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  const meltsim::Box box{{0, 0, 0}, Game::size};
  Hands hands = Game::at_rest();
  Vec3d wanted_cup = hands.cup, wanted_iron = hands.iron;
  double wanted_tilt = 0;
  bool iron_follows = false;
  std::vector<view::ParticleVertex> vertices;
  std::vector<std::string> news;
  int code = 0;
  constexpr double frame = 1.0 / 60;
  while (!window.closing()) {
    window.begin_frame();
    const view::Input input = window.take_input();
    const view::Viewport viewport = window.framebuffer();
    for (const int key : input.keys) {
      if (key == GLFW_KEY_ESCAPE) window.close();
      if (key == GLFW_KEY_T) hands.tap = !hands.tap;
      if (key == GLFW_KEY_I) iron_follows = !iron_follows;
    }
    wanted_tilt = std::clamp(wanted_tilt + 0.2 * input.zoom, -2.5, 2.5);
    // The hand is where the cursor is, and within the tank.
    double x = 0, y = 0;
    glfwGetCursorPos(glfwGetCurrentContext(), &x, &y);
    const Vec3d at = under_cursor(camera.ray(x * window.pixel_ratio(), y * window.pixel_ratio(), viewport));
    const Vec3d hand{std::clamp(at.x, 0.32, Game::size.x - 0.32), std::clamp(at.y, 0.04, 0.66),
                     0.5 * Game::size.z};
    (iron_follows ? wanted_iron : wanted_cup) = hand;
    hands.cup = moved(hands.cup, wanted_cup, 1.5 * frame);
    hands.iron = moved(hands.iron, wanted_iron, 1.5 * frame);
    hands.tilt += std::clamp(wanted_tilt - hands.tilt, -3 * frame, 3 * frame);
    news.clear();
    if (meltsim::Status s = game.frame(frame, hands, news); !s) {
      // A hand that would go through a wall, say: it stays where the last frame had it.
      std::fprintf(stderr, "%s\n", s.error().message.c_str());
      if (s.error().code != meltsim::ErrorCode::invalid_argument) {
        code = 1;
        break;
      }
      wanted_tilt = 0;
      wanted_cup = Game::at_rest().cup;
    }
    for (const std::string& text : news) std::printf("%s\n", text.c_str());
    Vec3d origin;
    if (meltsim::Status s = vertices_of(game, vertices, origin); !s) {
      std::fprintf(stderr, "%s\n", s.error().message.c_str());
      code = 1;
      break;
    }
    // Flags are drawn as chains of small balls along their edges.
    for (const Flag& f : game.flags()) {
      if (!f.planted_in_piece) continue;
      const FlagMesh mesh = game.mesh_of(f);
      for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3)
        for (int k = 0; k < 8; ++k) {
          const Vec3d p = mesh.position[mesh.triangles[t]] * (1 - k / 8.0) +
                          mesh.position[mesh.triangles[t + 1]] * (k / 8.0) - origin;
          vertices.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0,
                              60, meltsim::tag_solid});
        }
    }
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(view::ParticleVertex)),
                 vertices.data(), GL_STREAM_DRAW);
    const view::Frame shown = view::make_frame(camera, viewport, box, origin, game.world().desc().spacing);
    particles.cast(shown, look, buffer, vertices.size());
    around.draw_behind(shown);
    particles.draw(shown, look, buffer, vertices.size());
    around.draw_around(shown, look, box);
    window.draw_panel();
    window.show();
  }
  glDeleteBuffers(1, &buffer);
  return code;
}

}  // namespace

int run_window(Game& game) {
  try {
    return play(game);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "game: --window: %s\n", e.what());
    return 1;
  }
}

}  // namespace game
