// SPDX-License-Identifier: Apache-2.0
#include "show/plot_script.hpp"

#include <fmt/format.h>

namespace runner {

namespace {

/// Inside single quotes of gnuplot a quote is doubled.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text)
    out += c == '\'' ? std::string("''") : c == '\n' ? std::string(" ") : std::string(1, c);
  return out + "'";
}

struct Curve {
  const char* title;
  std::string value;  ///< of gnuplot's `using`
  const char* color;
};

std::string plot(const char* title, const char* unit, std::initializer_list<Curve> curves,
                 const char* extra = "") {
  std::string text = fmt::format("set title '{}'\nset ylabel '{}'\n{}plot", title, unit, extra);
  const char* comma = " ";
  for (const Curve& curve : curves) {
    text += fmt::format("{}data using (column('time_s')):({}) title '{}' lc rgb '{}'", comma, curve.value,
                        curve.title, curve.color);
    comma = ", \\\n     ";
  }
  return text + "\nunset yrange\nunset logscale\n";
}

}  // namespace

std::string plot_script(const std::string& stats, const std::string& picture, const std::string& title,
                        bool svg, bool only_start, bool empty) {
  std::string text = fmt::format(
      "data = {}\nset datafile separator ','\nset terminal {}\nset output {}\n"
      "set style data lines\nset style line 1 lw 2\nset for [i=1:8] linetype i lw 2\nset grid lc rgb "
      "'#dddddd'\n"
      "set border 3 lc rgb '#666666'\nset tics nomirror\nset key below horizontal samplen 1.5\nset "
      "xlabel 'time [s]'\n"
      "set autoscale xfix\nset multiplot layout 2,3 title {} noenhanced\n",
      quoted(stats),
      svg ? "svg size 1500,800 dynamic background rgb 'white' font 'Helvetica,13'"
          : "pngcairo size 1500,800 font 'Sans,10'",
      quoted(picture), quoted(title));
  // A range of no height is an error to gnuplot where all values are equal.
  text += plot("melted", "%", {{"melted", "100*column('melted_fraction')", "#e07b00"}},
               "set yrange [0:*<100]\nset key off\n") +
          "set key\n";
  // While the scene is empty it has no temperature. Where it is empty all the time, gnuplot needs a number all the same.
  const auto warmth = [empty](const char* name) {
    return empty ? fmt::format("column('{}')", name)
                 : fmt::format("column('n_fluid')+column('n_solid') > 0 ? column('{}') : NaN", name);
  };
  text += plot("temperature", "degrees Celsius",
               {{"max", warmth("T_max"), "#d1392b"},
                {"mean", warmth("T_mean"), "#c8a415"},
                {"min", warmth("T_min"), "#2f62c4"}});
  text +=
      "stats data using (column('kinetic_J')) every ::0::0 name 'K' nooutput\n"
      "stats data using (column('potential_J')) every ::0::0 name 'P' nooutput\n"
      "stats data using (column('thermal_J')) every ::0::0 name 'T' nooutput\n"
      "stats data using (column('heat_in_J')) every ::0::0 name 'H' nooutput\n";
  text += plot("motion: energy, change of", "J",
               {{"kinetic", "column('kinetic_J')-K_min", "#2e9e4f"},
                {"potential", "column('potential_J')-P_min", "#8a5bd6"}});
  text += plot("heat: energy, change of", "J",
               {{"thermal, with latent", "column('thermal_J')-T_min", "#d1392b"},
                {"came in", "column('heat_in_J')-H_min", "#777777"}});
  text += plot("largest speed", "m/s", {{"speed", "column('max_speed')", "#1f8a8a"}},
               "set yrange [0:*]\nset key off\n") +
          "set key\n";
  text +=
      plot("time per step", "ms",
           {{"ms", only_start ? "column('ms_per_step')" : "$0 > 0 ? column('ms_per_step') : NaN", "#555555"}},
           "set yrange [0:*]\nset key off\n");
  return text + "unset multiplot\nset output\n";
}

}  // namespace runner
