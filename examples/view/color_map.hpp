// SPDX-License-Identifier: Apache-2.0
// Numbers to colours. The shader, the legend and the tests read the same table.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace view {

enum class ColorBy { temperature, phase, body, speed, material };
inline constexpr int color_choices = 5;
const std::vector<std::string>& color_names();  ///< in the order of ColorBy

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
};

/// One row per ColorBy, in its order: ramps from low to high for temperature (runner::ramp: blue, yellow, red) and speed;
/// phase_colors; a colour per body, 0 for liquid that never belonged to one; and, by material, the colours
/// that a scene gives, else those of water and of ice: liquids first, solids from solid_materials on.
inline constexpr int solid_materials = 128;
inline constexpr int table_width = 256;
using ColorTable = std::array<std::array<Rgb, table_width>, color_choices>;
const ColorTable& color_table();
/// With the colours that a scene gives its bodies and its materials, in their order; 0..1.
using Colors = std::vector<std::optional<std::array<double, 3>>>;
ColorTable color_table(const Colors& bodies, const Colors& materials = {});

/// Places in the row of phases.
enum class Phase { liquid, solid, melted };  ///< melted: liquid that once belonged to a body

/// What the ends of a ramp stand for.
struct Range {
  double low = 0, high = 1;
};

/// Position in a ramp: 0 at `low` and below, table_width - 1 at `high` and above.
int ramp_index(double value, const Range& range);
Phase phase_of(std::uint32_t tag);
/// Bodies past the end of the table share its colours, but not that of liquid.
int body_index(std::uint32_t body);
/// Materials past the end share colours.
int material_index(std::uint32_t tag);
Rgb color_of(ColorBy by, double temperature, double speed, std::uint32_t tag, const Range& range);

/// Round numbers within the range for a legend, at most `most`.
std::vector<double> ticks(const Range& range, int most);

}  // namespace view
