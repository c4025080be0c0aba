// SPDX-License-Identifier: Apache-2.0
#include "view_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>

#include "failure.hpp"
#include "meltsim/world.hpp"
#include "numbers.hpp"
#include "option_values.hpp"
#include "suggest.hpp"

namespace view {

namespace {

using runner::ExitCode;
using runner::Failure;

class Typed {
 public:
  void add(CLI::App& app, const std::string& name, const std::string& type, const std::string& help) {
    app.add_option(name, values_[name], help)
        ->type_name(type)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }
  /// The text given for an option; null when it was not.
  const std::string* find(const std::string& name) const {
    const auto at = values_.find(name);
    return at == values_.end() || at->second.empty() ? nullptr : &at->second;
  }
  std::string choice(const std::string& name, const std::vector<std::string>& names) const {
    const std::string* text = find(name);
    return text == nullptr ? "" : runner::option_choice(name, *text, names);
  }

 private:
  std::map<std::string, std::string> values_;
};

void read_size(const std::string& text, ViewOptions& options) {
  const std::size_t x = std::min(text.find('x'), text.size());
  const std::int64_t width = runner::parse_integer(text.substr(0, x)).value_or(0);
  const std::int64_t height = runner::parse_integer(x < text.size() ? text.substr(x + 1) : "").value_or(0);
  if (std::min(width, height) < 64 || std::max(width, height) > 16384) {
    throw Failure(ExitCode::usage,
                  fmt::format("--size: expected WIDTHxHEIGHT in pixels, 64 or more, got \"{}\"", text));
  }
  options.width = static_cast<int>(width);
  options.height = static_cast<int>(height);
}

void read_machine(const Typed& typed, runner::MachineOptions& machine) {
  const std::string backend = typed.choice("--backend", {"auto", "cuda", "cpu"});
  if (backend == "cuda") machine.backend = meltsim::Backend::cuda;
  if (backend == "cpu") machine.backend = meltsim::Backend::cpu;
  if (typed.choice("--precision", {"single", "double"}) == "double")
    machine.precision = meltsim::Precision::double_precision;
  if (const std::string* n = typed.find("--threads"))
    machine.threads = static_cast<int>(std::min<std::uint64_t>(runner::option_count("--threads", *n), 4096));
}

void read_scene(const Typed& typed, runner::SceneOptions& scene) {
  if (const std::string* x = typed.find("--scale")) scene.scale = runner::option_positive("--scale", *x);
  const std::string quality = typed.choice("--quality", {"draft", "balanced", "accurate"});
  if (quality == "draft") scene.quality = runner::Quality::draft;
  if (quality == "accurate") scene.quality = runner::Quality::accurate;
}

void read_picture(const Typed& typed, ViewOptions& options) {
  if (const std::string* text = typed.find("--size")) read_size(*text, options);
  if (const std::string* s = typed.find("--after"))
    options.after = runner::option_not_negative("--after", *s);
  if (const std::string* n = typed.find("--frames")) options.frames = runner::option_count("--frames", *n);
  if (options.after && options.frames) throw Failure(ExitCode::usage, "--after, --frames: give one of them");
  if (const std::string* file = typed.find("--screenshot")) options.screenshot = *file;
  if (!options.screenshot.empty() && !options.scripted()) options.after = 1;
  const std::string color = typed.choice("--color", color_names());
  const auto at = std::find(color_names().begin(), color_names().end(), color);
  if (at != color_names().end()) options.color = static_cast<ColorBy>(at - color_names().begin());
}

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const std::string& left : app.remaining(true)) {
    const std::string word = left.substr(0, left.find('='));
    if (left.compare(0, 1, "-") == 0) {
      return fmt::format("meltsim-view: unknown option \"{}\"{}", word,
                         runner::suggestion(word, names, "options"));
    }
    return fmt::format("meltsim-view: unexpected argument \"{}\"; see meltsim-view --help", left);
  }
  return fmt::format("meltsim-view: {}; see meltsim-view --help", error.what());
}

}  // namespace

std::optional<ViewOptions> parse_view_options(int argc, char** argv) {
  CLI::App app("Runs a scene in a window: watch it, turn it, change it.", "meltsim-view");
  app.set_version_flag("--version", "meltsim-view " + meltsim::build_info().version);
  app.footer(
      "Exit codes: 0 ok, 1 usage, 2 scene error, 3 diverged (before a screenshot), 4 no display, "
      "device or memory, 5 files.");
  ViewOptions options;
  Typed typed;
  bool no_panel = false;
  app.add_option("SCENE", options.scene.scene, "scene file (YAML or JSON) or name of a built-in scene")
      ->required();
  typed.add(app, "--backend", "auto|cuda|cpu", "where to compute; auto takes CUDA when it is usable");
  typed.add(app, "--threads", "N", "CPU threads; 0 = all");
  typed.add(app, "--precision", "single|double", "floating-point numbers of the simulation");
  typed.add(app, "--scale", "X", "linear resolution factor; 0.8 is coarser, 1.25 finer");
  typed.add(app, "--quality", "draft|balanced|accurate", "as in meltsim run");
  app.add_option("--set", options.scene.set, "change a value of the scene, e.g. bodies[0].temperature=-5")
      ->type_name("path=value")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_flag("--paused", options.paused, "wait for the space bar");
  typed.add(app, "--color", "temperature|phase|body|speed|material", "what particles are coloured by");
  typed.add(app, "--size", "WIDTHxHEIGHT", "of the window, in pixels");
  app.add_flag("--no-panel", no_panel, "start without the panel; P shows it");
  typed.add(app, "--screenshot", "FILE.png", "write a picture and end");
  typed.add(app, "--after", "S", "end after so many simulated seconds");
  typed.add(app, "--frames", "N", "end after so many frames of the scene");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    app.exit(help);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw Failure(ExitCode::usage, explain(app, error));
  }
  options.panel = !no_panel;
  read_scene(typed, options.scene);
  read_machine(typed, options.machine);
  read_picture(typed, options);
  return options;
}

}  // namespace view
