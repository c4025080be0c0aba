// SPDX-License-Identifier: Apache-2.0
// The window, its OpenGL context, and what mouse and keyboard do.
#pragma once

#include <string>
#include <vector>

#include "camera.hpp"

struct GLFWwindow;

namespace view {

/// Since the last frame. Nothing of it was meant for the panel.
struct Input {
  double orbit_x = 0, orbit_y = 0;  ///< parts of the window's height
  double pan_x = 0, pan_y = 0;
  double zoom = 0;  ///< steps of the wheel
  bool click = false;
  double click_x = 0, click_y = 0;  ///< pixels of the framebuffer from the upper left
  std::vector<int> keys;            ///< GLFW_KEY_..., pressed or repeated
};

class Window {
 public:
  /// Throws runner::Failure (code 4) where there is no display or no OpenGL 3.3.
  Window(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool closing() const;
  void close();
  void begin_frame();  ///< handles events; the panel may be built from here on
  Input take_input();  ///< after begin_frame()
  Viewport framebuffer() const;
  double pixel_ratio() const;  ///< framebuffer pixels per unit of the panel
  void draw_panel();           ///< on top of what has been drawn
  void show();                 ///< shows what has been drawn
  std::string renderer() const;

 private:
  friend struct WindowEvents;
  GLFWwindow* window_ = nullptr;
  Input input_;
  double mouse_x_ = 0, mouse_y_ = 0, press_x_ = 0, press_y_ = 0;
  /// Whose the mouse is while a button is held. Open until the panel has seen where it was pressed.
  enum class Owner { nobody, open, scene, panel } owner_ = Owner::nobody;
  bool held_ = false;
};

}  // namespace view
