// SPDX-License-Identifier: Apache-2.0
// `meltsim render DIR|SCENE`: pictures of a run's frames, a sheet of them, and a movie.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "commands.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "log.hpp"
#include "numbers.hpp"
#include "show/draw.hpp"
#include "show/pov_file.hpp"
#include "show/programs.hpp"
#include "show/run_frames.hpp"

namespace runner {

namespace {

constexpr std::size_t sheet_pictures = 12;
constexpr int sheet_columns = 4, sheet_width = 480;

using Clock = std::chrono::steady_clock;

/// ", about 3 min 10 s left", where that is worth saying.
std::string time_left(Clock::time_point since, std::size_t done, std::size_t all) {
  constexpr double worth_saying = 10;
  const double spent = std::chrono::duration<double>(Clock::now() - since).count(),
               left = spent * static_cast<double>(all - done) / static_cast<double>(done);
  return left < worth_saying ? "" : fmt::format(", about {} left", duration_text(left));
}

/// At most `most` of them, evenly spread, with the first and the last; 0 = all.
std::vector<std::uint64_t> spread(const std::vector<std::uint64_t>& all, std::uint64_t most) {
  if (most == 0 || all.size() <= most) return all;
  std::vector<std::uint64_t> some;
  for (std::uint64_t i = 0; i < most; ++i) {
    some.push_back(all[most == 1 ? all.size() - 1 : i * (all.size() - 1) / (most - 1)]);
  }
  return some;
}

/// Whether run.json has a warning with this text.
bool run_warned(const RunDirectory& directory, const std::string& text) {
  const Json run = Json::parse(read_file(directory.file("run.json")), nullptr, false);
  if (!run.is_object() || !run.contains("warnings")) return false;
  return std::any_of(run["warnings"].begin(), run["warnings"].end(), [&](const Json& warning) {
    return warning.get<std::string>().find(text) != std::string::npos;
  });
}

class Renderer {
 public:
  /// `ran`: the scene was run just now, and the run said what it saw.
  Renderer(const RenderOptions& options, RunDirectory directory, Log& log, bool ran)
      : options_(options), directory_(std::move(directory)), log_(log), scene_(run_scene_of(directory_)) {
    camera_said_ = ran && run_warned(directory_, eye_in_solid_text);
    const auto [cold, hot] = range_on_disk(directory_);
    wish_ = picture_wish(scene_, cold, hot);
    if (options.width) wish_.width = *options.width;
    if (options.height) wish_.height = *options.height;
    if (options.samples) wish_.samples = *options.samples;
    if (options.look) wish_.look = *options.look == "temperature" ? Look::temperature : Look::natural;
    wish_.threads = options.run.machine.threads;
    name_ = wish_.look == Look::temperature ? "temperature" : "natural";
    choose_renderer();
  }

  int execute() {
    const std::vector<std::uint64_t> all = frames_on_disk(directory_);
    if (all.empty()) {
      throw Failure(
          ExitCode::io,
          fmt::format("{}: holds no frames as PLY; run the scene with --export surface (smooth) or ply",
                      directory_.path));
    }
    const std::vector<std::uint64_t> chosen = spread(all, options_.frames);
    camera_ = common_camera(chosen);
    std::error_code error;
    std::filesystem::create_directories(directory_.file("pictures"), error);
    if (error)
      throw Failure(ExitCode::io, directory_.file("pictures") + ": cannot be created: " + error.message());
    const DirectoryLock lock(directory_.file("pictures"), "another `meltsim render`");
    std::vector<std::pair<double, std::string>> pictures;
    std::vector<Image> small;
    const std::vector<std::uint64_t> on_sheet = spread(chosen, sheet_pictures);
    const Clock::time_point since = Clock::now();
    for (const std::uint64_t index : chosen) {
      const FrameShapes shapes = frame_on_disk(directory_, scene_, index);
      say_once(shapes);
      const Image image = picture(shapes, index);
      const std::string file = fmt::format("pictures/{}_{:05}.png", name_, index);
      write_file(directory_.file(file), png_text(image));
      pictures.emplace_back(shapes.time, file);
      if (std::count(on_sheet.begin(), on_sheet.end(), index) > 0)
        small.push_back(reduced(image, sheet_width));
      log_.info(fmt::format("{} ({} of {}{})", directory_.file(file), pictures.size(), chosen.size(),
                            time_left(since, pictures.size(), chosen.size())));
    }
    const std::string sheet = directory_.file(name_ + "_sheet.png");
    write_file(sheet, png_text(contact_sheet(
                          small, std::min<int>(sheet_columns, static_cast<int>(small.size())), sheet_width)));
    log_.info("all at a glance: " + sheet);
    if (pictures.size() > 1) movie(pictures);
    if (exists(directory_.file("still.png"))) log_.info("picture: " + directory_.file("still.png"));
    if (exists(directory_.file("index.html")))
      log_.info("page, for any browser: " + directory_.file("index.html"));
    return 0;
  }

 private:
  void choose_renderer() {
    povray_ = options_.renderer == "builtin" ? "" : find_program("povray");
    if (options_.renderer == "povray" && povray_.empty()) {
      throw Failure(
          ExitCode::usage,
          "--renderer povray: povray is not in PATH (Debian/Ubuntu: apt install povray); --renderer "
          "builtin needs nothing");
    }
    log_.info(povray_.empty()
                  ? "renderer: builtin" +
                        std::string(options_.renderer == "auto" ? " (povray is not installed)" : "")
                  : "renderer: " + povray_);
  }

  /// One camera for all pictures: what there is to see in the first, a middle and the last.
  Camera common_camera(const std::vector<std::uint64_t>& chosen) {
    Box seen;
    for (const std::uint64_t index : spread(chosen, 3)) {
      const Box box = box_of(frame_on_disk(directory_, scene_, index));
      if (box.empty()) continue;
      seen.add(box.min);
      seen.add(box.max);
    }
    wish_.extent = length(seen.size());
    return scene_camera(scene_, view_box(scene_, seen), wish_.aspect());
  }

  void say_once(const FrameShapes& shapes) {
    if (!shapes.balls.empty()) {
      log_.warn(
          fmt::format("{} holds particles only: they are drawn as balls; --export surface writes surfaces",
                      directory_.path));
    }
    if (!camera_said_ && eye_in_solid(shapes, camera_)) {
      log_.warn("the camera stands inside a solid in some frames: move output.camera.eye");
    }
  }

  Image picture(const FrameShapes& shapes, std::uint64_t index) {
    if (povray_.empty()) return draw(shapes, scene_, camera_, wish_);
    const Scratch scratch;
    write_file(scratch.file("scene.pov"), pov_text(shapes, camera_, trace_settings(scene_, camera_, wish_)));
    std::vector<std::string> command{povray_,
                                     "+Iscene.pov",
                                     "+Opicture.png",
                                     fmt::format("+W{}", wish_.width),
                                     fmt::format("+H{}", wish_.height),
                                     "+A0.1",
                                     "+R2",
                                     "-D",
                                     "+FN8"};
    if (wish_.threads > 0) command.push_back(fmt::format("+WT{}", wish_.threads));
    const int status = run_program(command, scratch);
    if (status != 0 || !exists(scratch.file("picture.png"))) {
      const std::string base = directory_.file(fmt::format("pictures/{}_{:05}", name_, index));
      scratch.take("scene.pov", base + ".pov");
      scratch.take(program_log, base + ".log");
      throw Failure(ExitCode::io,
                    fmt::format("{0}.pov: povray ended with {1}; it said why in {0}.log; --renderer builtin "
                                "does without it",
                                base, status));
    }
    Image image = read_png(scratch.file("picture.png"));
    annotate(image, shapes.time, wish_);
    return image;
  }

  void movie(const std::vector<std::pair<double, std::string>>& pictures) {
    const std::string ffmpeg = find_program("ffmpeg");
    if (ffmpeg.empty()) {
      log_.info("no movie: ffmpeg is not installed (Debian/Ubuntu: apt install ffmpeg)");
      return;
    }
    const Scratch scratch;
    scratch.link("pictures", directory_.file("pictures"));
    std::string text = "ffconcat version 1.0\n";
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const double until = i + 1 < pictures.size() ? pictures[i + 1].first : pictures[i].first + 1;
      text += fmt::format("file '{}'\nduration {:.6f}\n", pictures[i].second,
                          std::max(1e-3, until - pictures[i].first));
    }
    // The last picture stays for a second; ffmpeg forgets a last duration that no file follows.
    text += fmt::format("file '{}'\n", pictures.back().second);
    write_file(scratch.file("pictures.ffconcat"), text);
    for (const char* codec : {"libx264", "mpeg4"}) {
      const int status = run_program({ffmpeg,
                                      "-hide_banner",
                                      "-y",
                                      "-f",
                                      "concat",
                                      "-safe",
                                      "0",
                                      "-i",
                                      "pictures.ffconcat",
                                      "-vf",
                                      "fps=25,scale=trunc(iw/2)*2:trunc(ih/2)*2",
                                      "-c:v",
                                      codec,
                                      "-q:v",
                                      "3",
                                      "-pix_fmt",
                                      "yuv420p",
                                      "-movflags",
                                      "+faststart",
                                      "movie.mp4"},
                                     scratch);
      if (status != 0) continue;
      const std::string movie = directory_.file(name_ + ".mp4");
      scratch.take("movie.mp4", movie);
      log_.info("movie: " + movie);
      return;
    }
    const std::string said = directory_.file(name_ + ".ffmpeg.log");
    scratch.take(program_log, said);
    log_.warn(fmt::format("no movie: ffmpeg failed and said why in {}", said));
  }

  const RenderOptions& options_;
  RunDirectory directory_;
  Log& log_;
  Scene scene_;
  PictureWish wish_;
  Camera camera_;
  std::string name_, povray_;
  bool camera_said_ = false;
};

}  // namespace

int cmd_render(const RenderOptions& options) {
  std::error_code error;
  std::string directory = options.run.scene.scene;
  const bool is_scene = !std::filesystem::is_directory(directory, error);
  if (is_scene) {
    // A scene: run it first, with the surfaces that pictures are made of.
    RunOptions run = options.run;
    run.formats = {"surface"};
    if (run.out.empty()) run.out = fresh_run_directory(load_scene(run.scene).name);
    directory = run.out;
    const int code = cmd_run(run);
    if (code != 0) return code;
  }
  Log log(LogStyle::text, options.run.quiet);
  try {
    return Renderer(options, {directory, {}}, log, is_scene).execute();
  } catch (const Failure& failure) {
    log.error(failure.what());
    return static_cast<int>(failure.code());
  }
}

}  // namespace runner
