// SPDX-License-Identifier: Apache-2.0
// game [--seconds S] [--spacing M] [--picture FILE.png] [--window] [--cpu]
//
// Without --window it plays itself: a scripted player, what happened line by line, and a picture of the end.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "game.hpp"
#include "picture.hpp"
#include "window_mode.hpp"

namespace {

int fail(const std::string& text) {
  std::fprintf(stderr, "game: %s\n", text.c_str());
  return 1;
}

}  // namespace

int main(int count, char** arguments) {
  game::Settings settings;
  double seconds = 5;
  std::string picture;
  bool window = false;
  for (int k = 1; k < count; ++k) {
    const std::string option = arguments[k];
    const bool has_value = k + 1 < count;
    if (option == "--window") window = true;
    else if (option == "--cpu") settings.backend = meltsim::Backend::cpu;
    else if (option == "--seconds" && has_value) seconds = std::atof(arguments[++k]);
    else if (option == "--spacing" && has_value) settings.spacing = std::atof(arguments[++k]);
    else if (option == "--picture" && has_value) picture = arguments[++k];
    else return fail("options: --seconds S, --spacing M, --picture FILE.png, --window, --cpu; got " + option);
  }
  if (!(seconds > 0) || !(seconds <= 60)) return fail("--seconds: must be above 0 and at most 60");
  if (!(settings.spacing >= 0.01) || !(settings.spacing <= 0.04))
    return fail("--spacing: must be 0.01 to 0.04: the cup's wall is 0.08 m thick");
  auto made = game::Game::make(settings);
  if (!made) return fail(made.error().message);
  game::Game& play = *made;
  if (window) return game::run_window(play);

  constexpr double frame = 1.0 / 60;
  double most = 0;
  const int frames = static_cast<int>(std::lround(seconds / frame));
  for (int k = 0; k < frames; ++k) {
    std::vector<std::string> news;
    const double end = (k + 1) * frame;
    if (meltsim::Status s = play.frame(frame, game::script(end, play.score()), news); !s)
      return fail(s.error().message);
    for (const std::string& text : news) std::printf("%s\n", text.c_str());
    if (k % 6 == 0) {
      const auto litres = play.in_cup();
      if (!litres) return fail(litres.error().message);
      if (*litres > most && end < 2.8) most = *litres;
    }
  }
  const meltsim::StepResult r = play.world().synchronize();
  if (r.halted) return fail(r.halt_reason);
  const auto litres = play.in_cup();
  if (!litres) return fail(litres.error().message);
  int flags = 0;
  for (const game::Flag& f : play.flags()) flags += f.planted_in_piece ? 1 : 0;
  std::printf("%d frames, %llu sub-steps, %llu particles\n", frames, static_cast<unsigned long long>(r.steps),
              static_cast<unsigned long long>(r.fluid + r.solid));
  std::printf("cup: %.1f litres lifted, %.1f left in it\n", most, *litres);
  std::printf("ice: %llu particles melted, %llu times a piece came off, %d flags stand\n",
              static_cast<unsigned long long>(play.score().melted),
              static_cast<unsigned long long>(play.score().split), flags);
  if (!picture.empty()) {
    const std::string problem = game::write_picture(play, picture);
    if (!problem.empty()) return fail(problem);
    std::printf("%s\n", picture.c_str());
  }
  return 0;
}
