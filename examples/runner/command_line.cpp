// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <tuple>

#include "commands.hpp"
#include "failure.hpp"
#include "meltsim/world.hpp"
#include "option_values.hpp"
#include "processors.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

const std::vector<std::string> command_names{"run",      "check",  "list", "new",   "info",
                                             "validate", "render", "plot", "trade", "stress"};

/// Options that `render` has and `run` does not.
const std::vector<std::string> render_only{"--renderer", "--look", "--pictures", "--size", "--samples"};
/// Options by which settings are chosen: a run that is resumed keeps its settings.
const std::vector<std::string> choosing{"--max-error", "--of", "--time-limit"};

/// Options as typed: CLI11 sorts them, option_values checks them, so that all errors read alike.
struct Typed {
  std::string argument;  ///< SCENE, NAME or DIR
  std::vector<std::string> set, filter;
  std::map<std::string, std::string> values;
  bool deterministic = false, resume = false, overwrite = false, quiet = false, no_still = false,
       no_page = false;
  bool long_cases = false, list = false, verbose = false;
  bool support = false, no_measure = false, no_cache = false;

  bool has(const std::string& option) const { return values.count(option) > 0 && !values.at(option).empty(); }
  const std::string& get(const std::string& option) const { return values.at(option); }
};

class CommandLine {
 public:
  CommandLine() : app_("Simulates melting: liquids, solids and the heat between them.", "meltsim") {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", "meltsim " + meltsim::build_info().version);
    app_.footer(
        "Exit codes: 0 ok, 1 usage (validate, stress: something fails), 2 scene error, 3 diverged (state "
        "saved), 4 "
        "device or memory, 5 files, 130 and 143 interrupted (state saved).");
    add_run();
    add_check();
    app_.add_subcommand("list", "list the built-in scenes");
    CLI::App* fresh = app_.add_subcommand("new", "write a commented scene to start from");
    fresh->add_option("NAME", typed_.argument, "name of the scene; writes NAME.yaml")->required();
    app_.add_subcommand("info", "say what this build and this machine can do");
    add_validate();
    add_render();
    add_trade();
    add_stress();
    CLI::App* plot = app_.add_subcommand("plot", "draw the plots of a run (needs gnuplot)");
    plot->add_option("DIR", typed_.argument, "directory of a run")->required();
  }

  int parse_and_run(int argc, char** argv) {
    if (argc < 2) throw Failure(ExitCode::usage, app_.help());
    const std::string first = argv[1];
    const bool known = std::count(command_names.begin(), command_names.end(), first) > 0;
    if (!known && first.compare(0, 1, "-") != 0) {
      throw Failure(ExitCode::usage, fmt::format("unknown command \"{}\"{}", first,
                                                 suggestion(first, command_names, "commands")));
    }
    if (known) refuse_empty(*app_.get_subcommand(first), argc, argv);
    try {
      app_.parse(argc, argv);
    } catch (const CLI::Success& help) {
      return app_.exit(help);
    } catch (const CLI::ParseError& error) {
      throw Failure(ExitCode::usage, explain(error));
    }
    return dispatch(argc, argv);
  }

 private:
  void value(CLI::App* command, const std::string& option, const std::string& type, const std::string& help) {
    command->add_option(option, typed_.values[option], help)
        ->type_name(type)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }

  /// Given more than once, it means all that was given.
  void list_of(CLI::App* command, const std::string& option, const std::string& type,
               const std::string& help) {
    value(command, option, type, help);
    // Given twice it has two lines; a delimiter would also drop empty names, which are mistakes.
    command->get_option(option)->multi_option_policy(CLI::MultiOptionPolicy::Join);
  }

  void add_machine(CLI::App* command) {
    value(command, "--backend", "auto|cuda|cpu", "where to compute; auto takes CUDA when it is usable");
    value(command, "--threads", "N", "CPU threads; 0 = all");
    value(command, "--precision", "single|double", "floating-point numbers of the simulation");
  }

  void add_shared(CLI::App* command, const std::string& name = "SCENE",
                  const std::string& what =
                      "scene file (YAML or JSON), name of a built-in scene, or - for standard input") {
    command->add_option(name, typed_.argument, what)->required();
    add_machine(command);
    value(command, "--scale", "X", "linear resolution factor; 0.8 is coarser, 1.25 finer");
    value(command, "--quality", "draft|balanced|accurate",
          "draft: 0.8 x resolution, 0.8 x sound speed, Courant number 0.5, a quarter of the time; accurate: "
          "1.4 x resolution, four times the time");
    command->add_option("--set", typed_.set, "change a value of the scene, e.g. bodies[0].temperature=-5")
        ->type_name("path=value")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }

  void add_run() {
    CLI::App* run = app_.add_subcommand("run", "run a scene");
    add_shared(run);
    value(run, "--out", "DIR", "directory to write to; by default a new out/<name>-NNN");
    value(run, "--time", "S", "simulated seconds, instead of the scene's end");
    value(run, "--frames", "N", "frames after the starting one, instead of the scene's end");
    value(run, "--steps", "N", "time steps, instead of the scene's end");
    value(run, "--fps", "F", "frames per simulated second");
    list_of(run, "--export", "ply,surface,...", "what each frame is written as, or none");
    value(run, "--log", "text|json", "how to report; json is one object per line");
    value(run, "--max-error", "E", "choose the settings for this error, e.g. 3%");
    value(run, "--of", "OBSERVABLE", "of what; by default the scene's first observable");
    value(run, "--time-limit", "S", "seconds for the probes of --max-error; 60 by default");
    value(run, "--budget", "T",
          "computing a frame may take so long, e.g. 16ms; what does not fit is not simulated");
    value(run, "--repeat", "DIR", "take the sub-steps of a run under --budget again, to the bit");
    run->add_flag("--no-cache", typed_.no_cache, "of --max-error: probe anew, and keep nothing");
    run->add_flag("--deterministic", typed_.deterministic, "accepted; runs always repeat bit for bit");
    run->add_flag("--resume", typed_.resume, "continue the run in --out DIR from its checkpoint");
    run->add_flag("--no-still", typed_.no_still, "leave still.png out");
    run->add_flag("--no-page", typed_.no_page, "leave index.html out");
    run->add_flag("--overwrite", typed_.overwrite, "write over the files of an existing --out DIR");
    run->add_flag("--quiet", typed_.quiet, "say nothing but warnings and errors");
  }

  void add_trade() {
    CLI::App* trade =
        app_.add_subcommand("trade", "say what accuracy costs in a scene, and which setting buys what");
    add_shared(trade);
    list_of(trade, "--observe", "melted,front,...", "what matters; by default the scene's, or what is in it");
    value(trade, "--error", "E", "also the cheapest settings for this error of the first one, e.g. 3%");
    value(trade, "--time", "S", "simulated seconds, instead of the scene's end");
    value(trade, "--time-limit", "S", "seconds for all probes; 60 by default");
    value(trade, "--points", "N", "of the front; 8 by default");
    value(trade, "--ensemble", "N",
          "instead of a front: means over N starts that are alike, and their spread");
    value(trade, "--out", "DIR", "directory to write to; by default a new out/<name>-trade-NNN");
    trade->add_flag("--support", typed_.support, "also compare a support of 0.8 times the scene's");
    trade->add_flag("--no-measure", typed_.no_measure, "do not run points of the front");
    trade->add_flag("--no-cache", typed_.no_cache, "probe anew, and keep nothing");
  }

  void add_check() {
    CLI::App* check =
        app_.add_subcommand("check", "say what a run would be: what melts, how long, how much disk");
    add_shared(check);
    check->add_flag("--verbose", typed_.verbose,
                    "all bodies, fluids and emitters, and which stages run and why");
  }

  void add_render() {
    CLI::App* render = app_.add_subcommand("render", "make pictures and a movie of a run, or of a scene");
    add_shared(render, "DIR|SCENE", "directory of a run, or a scene to run first");
    value(render, "--renderer", "auto|povray|builtin", "auto takes POV-Ray when it is installed");
    value(render, "--look", "natural|temperature", "what colours show; by default what output.picture says");
    value(render, "--pictures", "N", "how many at most, evenly spread; 60 by default, 0 = all");
    value(render, "--size", "WxH", "pixels of a picture, e.g. 1920x1080");
    value(render, "--samples", "N", "builtin: samples along each side of a pixel");
    value(render, "--out", "DIR", "of a scene: directory to run it in; by default a new out/<name>-NNN");
    value(render, "--time", "S", "of a scene: simulated seconds, instead of the scene's end");
    value(render, "--fps", "F", "of a scene: frames per simulated second");
    render->add_flag("--quiet", typed_.quiet, "say nothing but warnings and errors");
  }

  void add_validate() {
    CLI::App* validate = app_.add_subcommand("validate", "compare with exact solutions and experiments");
    add_machine(validate);
    validate->add_option("--filter", typed_.filter, "run the cases whose name matches; may be repeated")
        ->type_name("GLOB|PART")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    value(validate, "--out", "DIR", "write the table, validation.json and the plots' data there");
    value(validate, "--draws", "N", "draws of each case of drawn.*, 3 by default");
    value(validate, "--seed", "N", "of these draws, 1 by default");
    validate->add_flag("--long", typed_.long_cases, "also the cases that take minutes on a CPU");
    validate->add_flag("--list", typed_.list, "list the cases instead of running them");
  }

  void add_stress() {
    CLI::App* stress =
        app_.add_subcommand("stress", "say what holds at the extremes: small tanks, one extreme each");
    value(stress, "--backend", "auto|cuda|cpu", "where to compute; auto takes all that are usable");
    value(stress, "--precision", "single|double", "numbers of the simulation; both by default");
    stress
        ->add_option("--filter", typed_.filter,
                     "run the cells whose \"axis: value\" has this in it; may be repeated")
        ->type_name("PART")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    value(stress, "--out", "DIR", "write stability.csv and stability.svg there");
    value(stress, "--draws", "N", "instead: N cells with several settings drawn at random");
    value(stress, "--seed", "N", "of these draws, 1 by default");
    stress->add_flag("--long", typed_.long_cases, "also the cells that take minutes");
    stress->add_flag("--list", typed_.list, "list the cells instead of running them");
  }

  /// Of a script whose variable is not set, say: what was asked for is not to be passed over. `--budget=` takes the next word otherwise.
  static void refuse_empty(const CLI::App& command, int argc, char** argv) {
    const auto takes_value = [&command](const std::string& word) {
      const CLI::Option* option = word.rfind("--", 0) == 0 ? command.get_option_no_throw(word) : nullptr;
      return option != nullptr && option->get_items_expected_max() > 0;
    };
    for (int i = 2; i < argc; ++i) {
      const std::string word = argv[i];
      const bool cut = !word.empty() && word.back() == '=';
      const std::string option = word.empty() ? argv[i - 1] : cut ? word.substr(0, word.size() - 1) : "";
      if (takes_value(option))
        throw Failure(
            ExitCode::usage,
            fmt::format("{}: expected a value, got \"\"; write one behind it, or leave the option out",
                        option));
    }
  }

  /// CLI11 knows what was not expected; the user also wants to know what was meant.
  std::string explain(const CLI::ParseError& error) {
    const CLI::App* command = app_.get_subcommands().empty() ? &app_ : app_.get_subcommands().front();
    std::vector<std::string> options;
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    }
    const std::string title = "meltsim" + (command == &app_ ? "" : " " + command->get_name());
    for (const std::string& left : app_.remaining(true)) {
      const std::string word = left.substr(0, left.find('='));
      if (left.compare(0, 1, "-") == 0) {
        return fmt::format("{}: unknown option \"{}\"{}", title, word, suggestion(word, options, "options"));
      }
      return fmt::format("{}: unexpected argument \"{}\"; see {} --help", title, left, title);
    }
    return fmt::format("{}: {}; see {} --help", title, error.what(), title);
  }

  SceneOptions scene_options() const {
    SceneOptions options;
    options.scene = typed_.argument;
    options.set = typed_.set;
    if (typed_.has("--scale")) options.scale = option_positive("--scale", typed_.get("--scale"));
    if (typed_.has("--quality")) {
      const std::string word =
          option_choice("--quality", typed_.get("--quality"), {"draft", "balanced", "accurate"});
      options.quality = word == "draft"      ? Quality::draft
                        : word == "accurate" ? Quality::accurate
                                             : Quality::balanced;
    }
    return options;
  }

  MachineOptions machine_options() const {
    MachineOptions options;
    if (typed_.has("--backend")) {
      const std::string word = option_choice("--backend", typed_.get("--backend"), {"auto", "cuda", "cpu"});
      if (word == "cuda") options.backend = meltsim::Backend::cuda;
      if (word == "cpu") options.backend = meltsim::Backend::cpu;
    }
    if (typed_.has("--threads")) {
      options.threads_asked = option_count("--threads", typed_.get("--threads"));
      options.threads =
          static_cast<int>(std::min(options.threads_asked, static_cast<std::uint64_t>(processors())));
    }
    if (typed_.has("--precision")) {
      const std::string word = option_choice("--precision", typed_.get("--precision"), {"single", "double"});
      if (word == "double") options.precision = meltsim::Precision::double_precision;
    }
    return options;
  }

  /// "dir/" and "dir" are the same directory, and "/" stays itself.
  std::string out_directory() const {
    std::string out = typed_.has("--out") ? typed_.get("--out") : "";
    while (out.size() > 1 && out.back() == '/') out.pop_back();
    return out;
  }

  ValidateOptions validate_options() const {
    ValidateOptions options;
    options.machine = machine_options();
    options.filters = typed_.filter;
    options.long_cases = typed_.long_cases;
    if (typed_.has("--draws"))
      options.draws = static_cast<int>(
          std::clamp<std::uint64_t>(option_count("--draws", typed_.get("--draws")), 1, 100000));
    if (typed_.has("--seed")) options.seed = option_count("--seed", typed_.get("--seed"));
    options.list = typed_.list;
    options.out = out_directory();
    return options;
  }

  StressOptions stress_options() const {
    StressOptions options;
    const MachineOptions machine = machine_options();
    if (machine.backend != meltsim::Backend::automatic) options.backends = {machine.backend};
    if (typed_.has("--precision")) options.precisions = {machine.precision};
    options.filters = typed_.filter;
    options.long_cells = typed_.long_cases;
    if (typed_.has("--draws")) options.draws = option_count("--draws", typed_.get("--draws"));
    if (typed_.has("--seed")) options.seed = option_count("--seed", typed_.get("--seed"));
    options.list = typed_.list;
    options.out = out_directory();
    return options;
  }

  RunOptions run_options(int argc, char** argv) const {
    RunOptions options;
    options.scene = scene_options();
    options.machine = machine_options();
    options.out = out_directory();
    if (typed_.has("--time")) options.time = option_not_negative("--time", typed_.get("--time"));
    if (typed_.has("--frames")) options.frames = option_count("--frames", typed_.get("--frames"));
    if (typed_.has("--steps")) options.steps = option_count("--steps", typed_.get("--steps"));
    if (typed_.has("--fps")) options.fps = option_positive("--fps", typed_.get("--fps"));
    if (typed_.has("--export")) options.formats = option_formats(typed_.get("--export"));
    if (typed_.has("--log") && option_choice("--log", typed_.get("--log"), {"text", "json"}) == "json") {
      options.log = LogStyle::json;
    }
    options.resume = typed_.resume;
    options.overwrite = typed_.overwrite;
    options.still = !typed_.no_still;
    options.page = !typed_.no_page;
    options.quiet = typed_.quiet;
    if (typed_.has("--max-error")) options.max_error = option_share("--max-error", typed_.get("--max-error"));
    if (typed_.has("--of")) options.of = typed_.get("--of");
    if (typed_.has("--time-limit"))
      options.time_limit = option_positive("--time-limit", typed_.get("--time-limit"));
    options.cache = !typed_.no_cache;
    if (typed_.has("--budget")) options.budget_ms = option_milliseconds("--budget", typed_.get("--budget"));
    if (typed_.has("--repeat")) options.repeat = typed_.get("--repeat");
    check_together(options);
    options.resume_command = resume_command(argc, argv);
    return options;
  }

  TradeOptions trade_options() const {
    TradeOptions options;
    options.scene = scene_options();
    options.machine = machine_options();
    options.out = out_directory();
    if (typed_.has("--observe")) options.observe = option_list("--observe", typed_.get("--observe"));
    if (typed_.has("--error")) options.error = option_share("--error", typed_.get("--error"));
    if (typed_.has("--time")) options.time = option_positive("--time", typed_.get("--time"));
    if (typed_.has("--time-limit"))
      options.seconds = option_positive("--time-limit", typed_.get("--time-limit"));
    if (typed_.has("--points")) options.points = option_between("--points", typed_.get("--points"), 2, 100);
    if (typed_.has("--ensemble"))
      options.ensemble = option_between("--ensemble", typed_.get("--ensemble"), 2, 1000);
    options.cache = !typed_.no_cache;
    options.support = typed_.support;
    options.measure = !typed_.no_measure;
    for (const char* option : {"--error", "--points", "--time-limit"})
      if (options.ensemble && typed_.has(option))
        throw Failure(ExitCode::usage,
                      fmt::format("--ensemble, {}: give one of them: an ensemble has no front", option));
    return options;
  }

  RenderOptions render_options(int argc, char** argv) const {
    RenderOptions options;
    options.run = run_options(argc, argv);
    while (options.run.scene.scene.size() > 1 && options.run.scene.scene.back() == '/')
      options.run.scene.scene.pop_back();
    // What was run already is drawn as it is.
    if (std::filesystem::is_directory(options.run.scene.scene))
      for (const char* option : {"--out", "--time", "--scale", "--quality", "--set", "--fps", "--frames"})
        if (typed_.has(option) || (option == std::string("--set") && !typed_.set.empty()))
          throw Failure(
              ExitCode::usage,
              fmt::format("{}: {} has been run already, and this is for a run; leave it out, or give "
                          "the scene instead of the directory",
                          option, options.run.scene.scene));
    if (typed_.has("--renderer")) {
      options.renderer = option_choice("--renderer", typed_.get("--renderer"), {"auto", "povray", "builtin"});
    }
    if (typed_.has("--look"))
      options.look = option_choice("--look", typed_.get("--look"), {"natural", "temperature"});
    if (typed_.has("--pictures")) options.frames = option_count("--pictures", typed_.get("--pictures"));
    if (typed_.has("--size"))
      std::tie(options.width, options.height) = option_size("--size", typed_.get("--size"));
    if (typed_.has("--samples")) options.samples = option_between("--samples", typed_.get("--samples"), 1, 8);
    return options;
  }

  static void check_together(const RunOptions& options) {
    const int ends = (options.time ? 1 : 0) + (options.frames ? 1 : 0) + (options.steps ? 1 : 0);
    if (ends > 1) throw Failure(ExitCode::usage, "--time, --frames, --steps: give one of them");
    if (options.resume && options.overwrite)
      throw Failure(ExitCode::usage, "--resume, --overwrite: give one of them");
    if (options.steps && (options.budget_ms || !options.repeat.empty()))
      throw Failure(ExitCode::usage,
                    fmt::format("--steps, {}: give one of them: a frame has as many steps as its budget "
                                "allows; end with --frames N or --time S",
                                options.budget_ms ? "--budget" : "--repeat"));
    if (options.budget_ms && options.max_error)
      throw Failure(ExitCode::usage, "--budget, --max-error: give one of them");
    if (!options.repeat.empty() && (options.budget_ms || options.max_error || options.resume))
      throw Failure(ExitCode::usage,
                    "--repeat: takes settings and sub-steps of another run; leave --budget, --max-error and "
                    "--resume out");
    if (!options.of.empty() && !options.max_error)
      throw Failure(ExitCode::usage, "--of: needs --max-error E, the error of that observable");
    if (options.resume && options.out.empty()) {
      throw Failure(ExitCode::usage, "--resume: needs --out DIR, the directory of the run to continue");
    }
  }

  /// The command as typed, without the parts that a resumption replaces.
  static std::string resume_command(int argc, char** argv) {
    std::string command = shell_quoted(argv[0]);
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      const std::string option = word.substr(0, word.find('='));
      const auto among = [&](const std::vector<std::string>& some) {
        return std::count(some.begin(), some.end(), option) > 0;
      };
      if (among(render_only) || among(choosing)) i += option == word ? 1 : 0;
      else if (i == 1 && word == "render") command += " run --export surface";
      else if (word == "--out") ++i;
      else if (word.compare(0, 6, "--out=") != 0 && word != "--resume" && word != "--overwrite" &&
               word != "--no-cache") {
        command += " " + shell_quoted(word);
      }
    }
    return command;
  }

  int dispatch(int argc, char** argv) {
    const std::string name = app_.get_subcommands().front()->get_name();
    if (name == "run") return cmd_run(run_options(argc, argv));
    if (name == "check") return cmd_check(scene_options(), machine_options(), typed_.verbose);
    if (name == "list") return cmd_list();
    if (name == "new") return cmd_new(typed_.argument);
    if (name == "info") return cmd_info();
    if (name == "validate") return cmd_validate(validate_options());
    if (name == "trade") return cmd_trade(trade_options());
    if (name == "stress") return cmd_stress(stress_options());
    if (name == "render") return cmd_render(render_options(argc, argv));
    return cmd_plot(typed_.argument);
  }

  CLI::App app_;
  Typed typed_;
};

}  // namespace

int run_command_line(int argc, char** argv) { return CommandLine().parse_and_run(argc, argv); }

}  // namespace runner
