// SPDX-License-Identifier: Apache-2.0
#include "window.hpp"

#include <epoxy/gl.h>
// After it:
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "failure.hpp"
#include "theme.hpp"

namespace view {

namespace {

[[noreturn]] void no_window(const std::string& what) {
  const char* text = nullptr;
  glfwGetError(&text);
  std::string why = text != nullptr ? text : "no reason given";
  glfwTerminate();
  throw runner::Failure(runner::ExitCode::device,
                        "meltsim-view: " + what + " (" + why +
                            "); `meltsim run SCENE` needs none: it writes index.html and pictures");
}

// A click that moves further than this was meant to turn the camera.
constexpr double click_slack = 4;

}  // namespace

struct WindowEvents {
  static Window& of(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

  static void button(GLFWwindow* handle, int button, int action, int) {
    Window& w = of(handle);
    if (action == GLFW_PRESS) {
      w.held_ = true;
      w.owner_ = Window::Owner::open;
      w.press_x_ = w.mouse_x_;
      w.press_y_ = w.mouse_y_;
      return;
    }
    const double moved = std::hypot(w.mouse_x_ - w.press_x_, w.mouse_y_ - w.press_y_);
    if (button == GLFW_MOUSE_BUTTON_LEFT && moved < click_slack) {
      int width = 1, height = 1;
      glfwGetWindowSize(handle, &width, &height);
      const Viewport pixels = w.framebuffer();
      w.input_.click = true;
      w.input_.click_x = w.mouse_x_ * pixels.width / std::max(width, 1);
      w.input_.click_y = w.mouse_y_ * pixels.height / std::max(height, 1);
    }
    w.held_ = false;
  }

  static void move(GLFWwindow* handle, double x, double y) {
    Window& w = of(handle);
    int width = 1, height = 1;
    glfwGetWindowSize(handle, &width, &height);
    const double dx = (x - w.mouse_x_) / std::max(height, 1), dy = (y - w.mouse_y_) / std::max(height, 1);
    w.mouse_x_ = x;
    w.mouse_y_ = y;
    if (!w.held_) return;
    const auto down = [handle](int button) { return glfwGetMouseButton(handle, button) == GLFW_PRESS; };
    const bool shift = glfwGetKey(handle, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS ||
                       glfwGetKey(handle, GLFW_KEY_RIGHT_SHIFT) == GLFW_PRESS;
    const bool left = down(GLFW_MOUSE_BUTTON_LEFT);
    if (left && !shift) {
      w.input_.orbit_x += dx;
      w.input_.orbit_y += dy;
    } else if (left || down(GLFW_MOUSE_BUTTON_RIGHT) || down(GLFW_MOUSE_BUTTON_MIDDLE)) {
      w.input_.pan_x += dx;
      w.input_.pan_y += dy;
    }
  }

  static void scroll(GLFWwindow* handle, double, double y) { of(handle).input_.zoom += y; }

  static void key(GLFWwindow* handle, int key, int, int action, int) {
    if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
    of(handle).input_.keys.push_back(key);
  }
};

Window::Window(const std::string& title, int width, int height) {
  if (glfwInit() == GLFW_FALSE) no_window("no display to open a window on");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  for (const int samples : {4, 0}) {  // not every display smooths edges
    glfwWindowHint(GLFW_SAMPLES, samples);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (window_ != nullptr) break;
  }
  if (window_ == nullptr) no_window("this display offers no window with OpenGL 3.3");
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  // The panel's library calls these after its own.
  glfwSetMouseButtonCallback(window_, WindowEvents::button);
  glfwSetCursorPosCallback(window_, WindowEvents::move);
  glfwSetScrollCallback(window_, WindowEvents::scroll);
  glfwSetKeyCallback(window_, WindowEvents::key);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
  float scale_x = 1, scale_y = 1;
  glfwGetWindowContentScale(window_, &scale_x, &scale_y);
  set_theme(static_cast<double>(std::max(scale_x, scale_y)));
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::closing() const { return glfwWindowShouldClose(window_) != 0; }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }

void Window::begin_frame() {
  glfwPollEvents();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

Input Window::take_input() {
  const bool panel_wants = ImGui::GetIO().WantCaptureMouse;
  if (owner_ == Owner::open) owner_ = panel_wants ? Owner::panel : Owner::scene;
  Input input = std::exchange(input_, {});
  const bool panel_has = owner_ == Owner::panel || (owner_ == Owner::nobody && panel_wants);
  if (!held_) owner_ = Owner::nobody;
  if (!panel_has) return input;
  Input keys;
  keys.keys = std::move(input.keys);
  return keys;
}

Viewport Window::framebuffer() const {
  Viewport size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  size.width = std::max(size.width, 1);
  size.height = std::max(size.height, 1);
  return size;
}

double Window::pixel_ratio() const {
  int width = 1, height = 1;
  glfwGetWindowSize(window_, &width, &height);
  return static_cast<double>(framebuffer().width) / std::max(width, 1);
}

void Window::draw_panel() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::show() { glfwSwapBuffers(window_); }

std::string Window::renderer() const {
  const auto* name = glGetString(GL_RENDERER);
  return name != nullptr ? reinterpret_cast<const char*>(name) : "unknown";
}

}  // namespace view
